"""One frame of the whole hand: contraction -> skeleton -> muscle segments -> anchors -> skin -> normals (sections 3.1 and 4.2).

Three ways to wear the skin, by name: ``"blend"`` (bones alone move it), ``"springs"`` (the network follows the bones), ``"springs and
muscles"`` (and the surfaces of the geometric muscles below it).
"""

from __future__ import annotations

from collections.abc import Iterator
from math import exp
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.simulation import skin_kernel
from handlab.simulation import soft_skin_kernel as kernel
from handlab.simulation.clip import Clip
from handlab.simulation.geometric_muscle import Ellipsoids, place
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.laws import SOUND, Laws
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skeleton import contraction_of, held_coordinates, integrate, substeps_of
from handlab.simulation.skin import blend_into
from handlab.simulation.soft_limits import limited
from handlab.simulation.soft_skin import PAIR_REST, Network, SoftSkin, balanced, tension

Skin = Literal["blend", "springs", "springs and muscles"]
SKINS: tuple[Skin, ...] = ("blend", "springs", "springs and muscles")

# A column of tissue under skin that is stretched to twice its area would have half its length, were nothing to flow sideways: assumption.
# By area to the power of -3/4, written as roots in ``columns``.
COLUMN, COLUMN_REACH, COLUMN_PASSES = (0.6, 1.4), 0.010, 3
LIFT = 0.012  # m: a node follows a muscle's surface by less than this
YIELDING = 10.0  # 1/s: how fast columns of tissue that bones and folds have pushed aside come back once nothing pushes: assumption
GAIN = 0.5  # share of a lack of volume that the next frame makes good
SWELLING = (-0.15, 0.5)  # how far columns of tissue may be pressed or stretched for the volume


class Anchors(NamedTuple):
    """Where the network is tied at one moment: ``centre``, ``arm`` (3, n) of the mirrored pairs; ``turn`` (4, n), how nodes are turned."""

    centre: Array
    arm: Array
    turn: Array


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
    return SoftSkin(position, np.zeros_like(position), np.ascontiguousarray(network.centre.T), normal, 0.0, volume, np.zeros_like(position))


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
    # What limits moved in earlier frames, columns of tissue keep: springs that pulled back into the limits in every frame would flicker.
    after.centre[...] += soft.push
    position, velocity = advance(network, soft, after, dt)
    free = position.copy()
    faults = limited(hand, network, position, transforms)
    push = exp(-YIELDING * dt) * soft.push + (position - free)
    normal = np.empty_like(position)
    volume = kernel.volume_and_area(position, network.faces, normal)
    return SoftSkin(position, velocity, after.centre, normal, swelling, volume, push, faults)


def resting(network: Network, points: Array, after: Anchors, swelling: float) -> SoftSkin:
    """The skin at rest just where it is, ``points`` (n, 3): columns of tissue are moved until they hold it there."""
    position, normal = np.ascontiguousarray(points.T), np.empty((3, len(points)))
    volume = kernel.volume_and_area(position, network.faces, normal)
    edges = np.stack([network.first, network.second], axis=1).astype(np.int64)
    centre = balanced(points, after.arm.T, network.hold, tension(points, edges, network.stiffness, network.rest)).T
    push = np.ascontiguousarray(centre - after.centre)
    return SoftSkin(position, np.zeros_like(position), np.ascontiguousarray(centre), normal, swelling, volume, push)


def blended(hand: Hand, network: Network, transforms: Array) -> SoftSkin:
    """The skin as ``simulation.skin.blend`` has it, as a state from which springs can go on."""
    points = np.empty_like(network.points)
    blend_into(hand, transforms, points)
    position, normal = np.ascontiguousarray(points.T), np.empty((3, len(points)))
    volume = kernel.volume_and_area(position, network.faces, normal)
    return SoftSkin(position, np.zeros_like(position), anchors(network, transforms).centre, normal, 0.0, volume, np.zeros_like(position))


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
