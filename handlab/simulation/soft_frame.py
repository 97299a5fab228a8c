"""One frame of the whole hand: contraction -> skeleton -> muscle segments -> anchors -> skin -> normals (sections 3.1 and 4.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand
from handlab.simulation import soft_frame_kernel as frame_kernel
from handlab.simulation import soft_skin_kernel as kernel
from handlab.simulation.bone_field import bone_field
from handlab.simulation.laws import SOUND, Laws
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skeleton import contraction_of, held_coordinates, integrate, substeps_of
from handlab.simulation.skin import blend_into
from handlab.simulation.soft_anchors import COLUMN, COLUMN_REACH, SKINS, Anchors, Below, Skin, anchors, below
from handlab.simulation.soft_limits import BONE_ROUNDS, LEAST_SHADOW, LONGEST, PASSES, ROUNDS, guard
from handlab.simulation.soft_skin import PAIR_REST, Network, SoftSkin, balanced, tension

T = TypeVar("T")

AT_ONCE = 8  # frames: so many the skeleton is ahead of the skin

YIELDING = 10.0  # 1/s: how fast columns of tissue that bones and folds have pushed aside come back once nothing pushes: assumption
GAIN = 0.5  # share of a lack of volume that the next frame makes good
SWELLING = (-0.15, 0.5)  # how far columns of tissue may be pressed or stretched for the volume


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
    return pulled(hand, network, soft, below(hand, network, angle, contraction, skin=skin), dt)


def pulled(hand: Hand, network: Network, soft: SoftSkin, under: Below, dt: float) -> SoftSkin:
    """The skin ``dt`` seconds later, pulled along by what is ``under`` it then, whose anchors are used up."""
    after = under.anchors
    if after is None:
        return blended(hand, network, under.transforms)
    swelling = soft.swelling + GAIN * (network.volume - soft.volume) / network.compliance
    swelling = min(max(swelling, SWELLING[0]), SWELLING[1])
    held, field = guard(hand), bone_field(hand)
    position, velocity, push, normal = soft.position.copy(), soft.velocity.copy(), soft.push.copy(), np.empty_like(soft.position)
    faults, volume = frame_kernel.pulled(
        position, velocity, push, normal, soft.centre, after.centre, after.arm, after.stretch,
        network.depth, swelling, *COLUMN, COLUMN_REACH, PAIR_REST,
        network.first, network.second, network.stiffness, network.rest, network.slack, network.hold, network.inverse_mass,
        dt, network.substeps(dt), network.damping, YIELDING,
        under.transforms, held.corner, held.body, held.clearance, held.group, held.near,
        field.floor, field.value, field.start, field.size, field.origin, field.spacing,
        network.longest, LONGEST, network.faces, network.fan_start, network.fan, under.plane, LEAST_SHADOW,
        PASSES, ROUNDS, BONE_ROUNDS,
    )  # fmt: skip
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
    tied = anchors(network, transforms)
    tied.swell(network, 0.0)
    return SoftSkin(position, np.zeros_like(position), tied.centre, normal, 0.0, volume, np.zeros_like(position))


def ahead(work: Callable[[int], T], count: int) -> Iterator[T]:
    """``work(0)``, ``work(1)``, ... ``count`` of them in order, done on another thread some way before they are asked for.

    Several at once, for waking that thread takes longer than a piece of the work: one, then two, then four, then ``AT_ONCE`` at a time.
    """

    def some(begin: int, end: int) -> list[T]:
        return [work(k) for k in range(begin, end)]

    begin, end = 0, min(1, count)
    with ThreadPoolExecutor(1) as other:
        coming = other.submit(some, begin, end)
        while begin < count:
            now, begin, end = coming.result(), end, min(count, 2 * end + 1, end + AT_ONCE)
            coming = other.submit(some, begin, end)
            yield from now


def skins(hand: Hand, network: Network, time: ArrayLike, angle: Array, contraction: Array, *, skin: Skin = SKINS[2]) -> Iterator[SoftSkin]:
    """The skin of ``angle`` (T, dof) rad and ``contraction`` (T, muscle) at ``time`` (T,) s, frame by frame; in the first at rest."""
    soft = begin(hand, network, angle[0], contraction[0], skin=skin)
    yield soft
    under = ahead(lambda k: below(hand, network, angle[k + 1], contraction[k + 1], skin=skin), len(angle) - 1)
    for dt, lying in zip(np.diff(time), under, strict=True):
        soft = pulled(hand, network, soft, lying, float(dt))
        yield soft


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
    y, speed, under = _skeleton(hand, network, before.y, before.speed, contraction, dt, skin, laws, held_coordinates(hand, hold))
    return Frame(y, speed, pulled(hand, network, before.soft, under, dt))


def frames(
    hand: Hand,
    network: Network,
    before: Frame,
    contraction: ArrayLike,
    dt: float,
    *,
    skin: str = SKINS[2],
    laws: Laws = SOUND,
    hold: tuple[str, ...] = (),
) -> Iterator[Frame]:
    """The frames of ``frame``, ``dt`` seconds apart, for contractions (T, muscle) that are known beforehand.

    The skin does not act back on the bones, so the skeleton is up to ``AT_ONCE`` frames ahead of it, on another thread.
    """
    values, held = np.asarray(contraction, dtype=np.float64), held_coordinates(hand, hold)
    y, speed, soft = before

    def bones(k: int) -> tuple[Array, Array, Below]:
        nonlocal y, speed
        y, speed, under = _skeleton(hand, network, y, speed, values[k], dt, skin, laws, held)
        return y, speed, under

    for now, pace, under in ahead(bones, len(values)):
        soft = pulled(hand, network, soft, under, dt)
        yield Frame(now, pace, soft)


def _skeleton(
    hand: Hand,
    network: Network,
    y: Array,
    speed: Array,
    contraction: ArrayLike,
    dt: float,
    skin: str,
    laws: Laws,
    held: NDArray[np.bool_],
) -> tuple[Array, Array, Below]:
    values, steps = contraction_of(hand, contraction), substeps_of(dt, laws)
    path, pace = integrate(hand, y, speed, np.tile(values, (steps, 1)), dt / steps, held, laws)
    return path[-1], pace[-1], below(hand, network, coupled(hand, path[-1]), values, skin=skin)


def first_frame(hand: Hand, network: Network, *, skin: Skin = SKINS[2]) -> Frame:
    """The relaxed hand, at rest."""
    y = mechanics(hand).relaxed
    return Frame(np.array(y), np.zeros(len(y)), begin(hand, network, coupled(hand, y), skin=skin))
