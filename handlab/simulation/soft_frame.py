"""One frame of the whole hand: contraction -> skeleton -> muscle segments -> anchors -> skin -> normals (sections 3.1 and 4.2).

Three ways to wear the skin, by name: ``"blend"`` (bones alone move it), ``"springs"`` (the network follows the bones), ``"springs and
muscles"`` (and the surfaces of the geometric muscles below it).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, frozen
from handlab.anatomy.terms import find
from handlab.simulation import skin_kernel
from handlab.simulation import soft_hold_kernel as limits
from handlab.simulation import soft_skin_kernel as kernel
from handlab.simulation.bone_field import REACH, bone_field
from handlab.simulation.clip import Clip
from handlab.simulation.geometric_muscle import Ellipsoids, place
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.laws import SOUND, Laws
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skeleton import contraction_of, held_coordinates, integrate, substeps_of
from handlab.simulation.skin import binding, blend, blend_into
from handlab.simulation.soft_skin import PAIR_REST, Network, SoftSkin
from handlab.simulation.soft_skin_kernel import Node

Skin = Literal["blend", "springs", "springs and muscles"]
SKINS: tuple[Skin, ...] = ("blend", "springs", "springs and muscles")

LONGEST = 1.85  # times its rest length: no edge is longer at the end of a frame
LEAST_TURN = 0.1  # cosine between a triangle's normal and the carried one, below which it is turned back
PART, PASSES, ROUNDS = 0.1, 16, 12  # how far (more would make skin snap visibly), how often, at most how many rounds of all limits
BONE_ROUNDS = 6  # rounds in which skin is pushed out of bone; where limits exclude each other, a whole skin comes before a deep bone
CENTRE_PASSES = 6
# A column of tissue under skin that is stretched to twice its area would have half its length, were nothing to flow sideways: assumption.
# By area to the power of -3/4, written as roots in ``columns``.
COLUMN, COLUMN_REACH, COLUMN_PASSES = (0.6, 1.4), 0.010, 3
LIFT = 0.012  # m: a node follows a muscle's surface by less than this
GAIN = 0.5  # share of a lack of volume that the next frame makes good
SWELLING = (-0.15, 0.5)  # how far columns of tissue may be pressed or stretched for the volume
# Skin keeps this share of its rest distance from bone, at most so many metres: 1.5 mm of skin and 1 mm of extensor tendon or capsule
# below it, over the knuckles nothing else, are pressed together by no more than a tenth: assumption.
CLEARANCE, MOST_CLEARANCE = 0.9, 0.0025
NEAR_BONE = 0.015  # m: bones of the palm that come this near a node in the bind posture are asked for
POSTURES = 300  # random ones; from 100 to 300 of them add 2 in 100 pairs
OWN, FAR_BONE = 0.02, 0.020  # and within this reach those of bodies that have this weight in it


class Anchors(NamedTuple):
    """Where the network is tied at one moment: ``centre``, ``arm`` (3, n) of the mirrored pairs; ``turn`` (4, n), how nodes are turned."""

    centre: Array
    arm: Array
    turn: Array


class Guard(NamedTuple):
    """Which bones are looked up where: the middle of nodes ``corner`` (p, 3), the ``body`` (p,), the ``clearance`` (p,) m that is kept."""

    corner: Node
    body: Node
    clearance: Array


def anchors(network: Network, transforms: Array, ellipsoids: Ellipsoids | None = None, *, swelling: float = 0.0) -> Anchors:
    """Anchors for ``transforms`` (body, 4, 4), as ``relative_transforms`` gives them.

    ``ellipsoids``: muscles that lift the skin above them, of ``network.muscles``; without them bones alone count. ``swelling``: relative
    stretch of all columns of tissue.
    """
    count = len(network.points)
    quaternion = np.empty((len(transforms), 8))
    skin_kernel.dual_quaternions(transforms, quaternion)
    out = Anchors(np.empty((3, count)), np.empty((3, count)), np.empty((4, count)))
    kernel.carried(quaternion, network.index, network.weight, network.centre, network.arm, out.turn, out.centre, out.arm)
    if ellipsoids is not None:
        ties = network.ties
        kernel.lifted(
            ties.node, ties.ellipsoid, ties.share, ties.local, ties.below, network.centre, out.turn, *ellipsoids, LIFT, out.centre
        )
    last, clock = np.zeros(count, np.int64), np.zeros(3, np.int64)
    shape = (network.faces, network.corner, network.face_normal)
    limits.unfold(out.centre, out.turn, *shape, LEAST_TURN, PART, CENTRE_PASSES, last, clock)
    kernel.columns(
        out.centre,
        out.arm,
        network.faces,
        network.first,
        network.second,
        network.degree,
        network.area,
        network.depth,
        swelling,
        *COLUMN,
        COLUMN_REACH,
        COLUMN_PASSES,
    )
    return out


def advance(network: Network, soft: SoftSkin, after: Anchors, dt: float, *, steps: int | None = None) -> tuple[Array, Array]:
    """Position and velocity (3, n) after ``dt`` seconds of springs alone, while the anchors go evenly from ``soft.centre`` to ``after``.

    ``steps``: leapfrog steps; from the largest eigenvalue if not given.
    """
    count = network.substeps(dt) if steps is None else steps
    position, velocity = soft.position.copy(), soft.velocity.copy()
    force, block = np.empty_like(position), np.empty((10, position.shape[1]))
    kernel.framed(soft.centre, after.centre, after.arm, PAIR_REST, block)
    kernel.leapfrog(
        position,
        velocity,
        force,
        network.first,
        network.second,
        network.stiffness,
        network.rest,
        network.slack,
        block,
        network.hold,
        network.inverse_mass,
        dt / count,
        count,
        network.damping,
    )
    return position, velocity


def limited(hand: Hand, network: Network, position: Array, transforms: Array) -> int:
    """Skin out of bone, no edge too long, no triangle inverted, in place; returns how many triangles stay inverted.

    Inverted means against the rotation of the skin's own blend, not of the anchors'.
    """
    pairs, field, bound = guard(hand), bone_field(hand), binding(hand)
    quaternion, turn = np.empty((len(transforms), 8)), np.empty((4, position.shape[1]))
    skin_kernel.dual_quaternions(transforms, quaternion)
    kernel.turned(quaternion, bound.index, bound.weight, turn)
    return limits.limited(
        position,
        transforms,
        turn,
        pairs.corner,
        pairs.body,
        pairs.clearance,
        field.value,
        field.start,
        field.size,
        field.origin,
        field.spacing,
        network.first,
        network.second,
        LONGEST * network.longest,
        network.faces,
        network.corner,
        network.face_normal,
        LEAST_TURN,
        PART,
        PASSES,
        ROUNDS,
        BONE_ROUNDS,
    )


@per_hand
def guard(hand: Hand) -> Guard:
    """Nodes and triangles, and the bodies whose bones they must stay out of: what moves them, and what is near in the bind posture.

    Of these pairs only those stay that blending alone brings within the reach of the bones' field, 5 mm, in any of many postures, most
    of them near limits: springs and muscles move skin along or away from bone, and a clearance is at most 2.5 mm.
    """
    from scipy.spatial import cKDTree

    points, faces = hand.skin.points, hand.skin.faces
    places = np.concatenate([points, points[faces].mean(axis=1)])
    corners = np.concatenate([np.repeat(np.arange(len(points))[:, None], 3, axis=1), faces])
    weights = np.concatenate([hand.skin.weights, hand.skin.weights[faces].mean(axis=1)])
    corner, body, clearance = [], [], []
    for b, name in enumerate(hand.body_names):
        bones = np.concatenate([bone.points[bone.faces].mean(axis=1) for bone in hand.bones.values() if bone.body == name])
        near = cKDTree(bones).query(places)[0]
        # Fingers cross in some postures: the skin of one must not be pushed out of its own bones by those of its neighbour.
        mine = np.flatnonzero(((weights[:, b] > OWN) & (near < FAR_BONE)) | ((near < NEAR_BONE) & ("phalanx" not in name)))
        corner.append(corners[mine])
        body.append(np.full(len(mine), b))
        clearance.append(np.minimum(CLEARANCE * near[mine], MOST_CLEARANCE))
    pairs = Guard(*(frozen(np.concatenate(v), kind) for v, kind in ((corner, np.uint32), (body, np.uint32), (clearance, np.float64))))
    field, least, rng = bone_field(hand), np.full(len(pairs.body), np.inf), np.random.default_rng(0)
    low, high = mechanics(hand).limits.T
    for k in range(POSTURES):
        angle = coupled(hand, low + rng.beta(0.5, 0.5, len(low)) * (high - low)) if k else hand.bind
        transforms = relative_transforms(hand, angle)
        position = np.ascontiguousarray(blend(hand, angle).T)
        limits.nearest_bone(position, transforms, pairs.corner, pairs.body, *field, least)
    return Guard(*(frozen(v[least < 0.999 * REACH], v.dtype) for v in pairs))


def begin(hand: Hand, network: Network, angle: ArrayLike, contraction: ArrayLike | None = None, *, skin: Skin = SKINS[2]) -> SoftSkin:
    """The skin at rest at ``angle`` (dof,) rad: bent there from the bind posture, slowly, and left until it is still."""
    soft = at_bind(network)
    goal, way = np.asarray(angle, dtype=np.float64), 24
    for k in range(2 * way):
        part = min(1.0, (k + 1) / way)
        soft = follow(hand, network, soft, hand.bind + part * (goal - hand.bind), contraction, 1.0 / 60.0, skin=skin)
    return soft


def at_bind(network: Network) -> SoftSkin:
    """The network in the bind posture: at rest exactly where its nodes are."""
    position, normal = np.ascontiguousarray(network.points.T), np.empty((3, len(network.points)))
    volume = kernel.volume_and_area(position, network.faces, normal)
    return SoftSkin(position, np.zeros_like(position), np.ascontiguousarray(network.centre.T), normal, 0.0, volume)


def follow(
    hand: Hand,
    network: Network,
    soft: SoftSkin,
    angle: ArrayLike,
    contraction: ArrayLike | None,
    dt: float,
    *,
    skin: str = SKINS[2],
) -> SoftSkin:
    """The skin ``dt`` seconds later, when the bones have come to ``angle`` (dof,) rad and muscles have ``contraction`` (muscle,)."""
    worn = find(skin, SKINS, kind="way to wear the skin")
    transforms = relative_transforms(hand, angle)
    if worn == "blend":
        return blended(hand, network, transforms)
    shapes = None
    if worn == SKINS[2] and network.muscles is not None:
        count = len(network.muscles.owner)
        shapes = Ellipsoids(np.empty((count, 3)), np.empty((count, 3, 3)), np.empty((count, 3)))
        activity = np.zeros(len(hand.muscles)) if contraction is None else np.asarray(contraction, dtype=np.float64)
        place(network.muscles, transforms, activity, shapes)
    swelling = soft.swelling + GAIN * (network.volume - soft.volume) / network.compliance
    swelling = min(max(swelling, SWELLING[0]), SWELLING[1])
    after = anchors(network, transforms, shapes, swelling=swelling)
    position, velocity = advance(network, soft, after, dt)
    faults = limited(hand, network, position, transforms)
    normal = np.empty_like(position)
    volume = kernel.volume_and_area(position, network.faces, normal)
    return SoftSkin(position, velocity, after.centre, normal, swelling, volume, faults)


def blended(hand: Hand, network: Network, transforms: Array) -> SoftSkin:
    """The skin as ``simulation.skin.blend`` has it, as a state from which springs can go on."""
    points = np.empty_like(network.points)
    blend_into(hand, transforms, points)
    position, normal = np.ascontiguousarray(points.T), np.empty((3, len(points)))
    volume = kernel.volume_and_area(position, network.faces, normal)
    return SoftSkin(position, np.zeros_like(position), anchors(network, transforms).centre, normal, 0.0, volume)


class Frame(NamedTuple):
    """The whole hand at one moment: moving coordinates ``y`` and ``speed`` (moving,), and the skin."""

    y: Array
    speed: Array
    soft: SoftSkin


def frame(
    hand: Hand,
    network: Network,
    before: Frame,
    contraction: ArrayLike,
    dt: float,
    *,
    skin: str = SKINS[2],
    laws: Laws = SOUND,
    hold: tuple[str, ...] = (),
) -> Frame:
    """The whole hand ``dt`` seconds later: skeleton, then muscles, anchors, skin, normals, as in section 3.1."""
    values = contraction_of(hand, contraction)
    steps = substeps_of(dt, laws)
    y, speed = integrate(hand, before.y, before.speed, np.tile(values, (steps, 1)), dt / steps, held_coordinates(hand, hold), laws)
    return Frame(y[-1], speed[-1], follow(hand, network, before.soft, coupled(hand, y[-1]), values, dt, skin=skin))


def first_frame(hand: Hand, network: Network, *, skin: Skin = SKINS[2]) -> Frame:
    """The relaxed hand, at rest."""
    y = mechanics(hand).relaxed
    return Frame(np.array(y), np.zeros(len(y)), begin(hand, network, coupled(hand, y), skin=skin))


def skins(clip: Clip, network: Network, *, skin: Skin = SKINS[2]) -> Iterator[SoftSkin]:
    """The skin in every frame of a clip, one after the other; the first at rest."""
    hand = clip.hand
    soft = begin(hand, network, clip.angle[0], clip.contraction[0], skin=skin)
    yield soft
    for k in range(1, len(clip)):
        soft = follow(hand, network, soft, clip.angle[k], clip.contraction[k], float(clip.time[k] - clip.time[k - 1]), skin=skin)
        yield soft
