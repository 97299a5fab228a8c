"""Where the joints come to rest under constant contraction, whether that rest is stable, and whether there are others."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand, frozen
from handlab.simulation.balance import stops, tangent, total_torque
from handlab.simulation.dynamics import WEIGHTLESS
from handlab.simulation.laws import Laws
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skeleton import contraction_of, held_coordinates, integrate, rest, state_at, substeps_of
from handlab.simulation.state import State

SECONDS = 2.0  # between two looks at a motion that dies away
LONGEST = 60.0  # seconds after which a motion that has not died away is given up
SLOW = np.deg2rad(0.01)  # rad/s: what moves less is about to rest, and Newton's method finishes
CLOSE = 1e-10  # N m: balanced
STABLE = 1e-6  # N m/rad: a rest with less stiffness than this is none
SAME = np.deg2rad(0.5)  # two rests nearer than this are one

# Postures from which other rests are looked for: shares of the way from the relaxed hand to the upper (+) or lower (-) limits,
# for all flexions, and for the deviations.
STARTS = ((0.9, 0.0), (-0.9, 0.0), (0.0, 0.9), (0.0, -0.9), (0.9, 0.9), (0.9, -0.9), (-0.9, 0.9), (-0.9, -0.9))


@dataclass(frozen=True, eq=False)
class Rest:
    """A posture at which constant contractions leave no torque.

    ``state``: it does not move. ``stable``: a small push dies away; ``stiffness`` (free,) N m/rad: eigenvalues of the resistance to
    turning, weakest first, of the joints that are neither held nor at a hard stop. ``unbalanced`` (moving,) N m left.
    ``others``: angles (dof,) of other rests that were found from other starts; there may be more.
    """

    state: State
    stable: bool
    stiffness: Array
    unbalanced: Array
    others: tuple[Array, ...] = ()


def settle(
    hand: Hand,
    contraction: Mapping[str, float] | ArrayLike,
    start: State | None = None,
    *,
    hold: Iterable[str] = (),
    gravity: Sequence[float] = WEIGHTLESS,
    look_for_others: bool = True,
) -> Rest:
    """Where the hand comes to rest from ``start`` (the relaxed hand) under constant ``contraction``.

    The motion itself decides which rest it is; its last hundredth of a degree is found by Newton's method. Raises ``RuntimeError``
    if it has not died away after a minute. ``hold`` as in ``step``, ``gravity`` (3,) m/s^2 as in ``Laws``. Others are looked for from
    postures near the limits, unless ``look_for_others`` is false.
    """
    values, held = contraction_of(hand, contraction), held_coordinates(hand, hold)
    laws = Laws(gravity=gravity)
    begin = rest(hand) if start is None else start
    shape = (len(hand.dof_names),)
    if not isinstance(begin, State) or begin.angle.shape != shape or not np.isfinite([*begin.angle, *begin.speed]).all():
        raise ValueError(f"start is {start!r}; give a state of this hand with {shape[0]} finite angles, such as hl.pose(hand, ...)")
    moving = mechanics(hand).moving
    y, speed = np.array(begin.angle[moving]), np.array(begin.speed[moving])
    found = _rest(hand, y, speed, values, held, laws, begin.time)
    others: list[Array] = []
    for flexion, deviation in STARTS if look_for_others else ():
        try:
            other = _rest(hand, _toward(hand, y, held, flexion, deviation), np.zeros(len(y)), values, held, laws, 0.0)
        except RuntimeError:
            continue
        known = [found.state.angle, *others]
        if other.stable and all(np.abs(other.state.angle - angle).max() > SAME for angle in known):
            others.append(other.state.angle)
    return Rest(found.state, found.stable, found.stiffness, found.unbalanced, tuple(others))


def _toward(hand: Hand, y: Array, held: NDArray[np.bool_], flexion: float, deviation: float) -> Array:
    """A start with all free joints a share of the way to their limits."""
    m = mechanics(hand)
    share = np.array([flexion if "flexion" in name or "abduction" in name else deviation for name in hand.moving_names])
    reach = np.where(share > 0.0, m.limits[:, 1] - m.relaxed, m.relaxed - m.limits[:, 0])
    result: Array = np.where(held, y, m.relaxed + share * reach)
    return result


def _rest(hand: Hand, y: Array, speed: Array, values: Array, held: NDArray[np.bool_], laws: Laws, time: float) -> Rest:
    substeps = substeps_of(SECONDS, laws)
    rows = np.tile(values, (substeps, 1))
    for _ in range(round(LONGEST / SECONDS)):
        path_y, path_speed = integrate(hand, y, speed, rows, SECONDS / substeps, held, laws)
        y, speed, time = path_y[-1], path_speed[-1], time + SECONDS
        if np.abs(speed).max() > SLOW:
            continue
        exact, free = _newton(hand, y, values, held, laws.gravity)
        if exact is not None and np.abs(exact - y).max() < SAME:
            stiffness = np.linalg.eigvalsh(-tangent(hand, coupled(hand, exact), values, laws.gravity)[np.ix_(free, free)])
            left = np.where(free, total_torque(hand, exact, values, laws.gravity), 0.0)
            still = state_at(hand, exact, np.zeros(len(exact)), time)
            return Rest(still, bool(np.all(stiffness > STABLE)), frozen(stiffness), frozen(left))
    name = hand.moving_names[int(np.abs(speed).argmax())]
    left = np.rad2deg(np.abs(speed).max())
    raise RuntimeError(f"the hand has not come to rest after {LONGEST:g} s: {name} still turns by {left:.2g} degrees/s")


def _newton(
    hand: Hand, y: Array, values: Array, held: NDArray[np.bool_], gravity: Sequence[float]
) -> tuple[Array | None, NDArray[np.bool_]]:
    """The balanced posture next to ``y``, or None, and which coordinates are free: neither held nor pressed into a hard stop."""
    low, high = stops(hand, y)
    torque = total_torque(hand, y, values, gravity)
    free = ~(held | (low & (torque < 0.0)) | (high & (torque > 0.0)))
    y = np.array(y)
    for _ in range(30):
        torque = total_torque(hand, y, values, gravity)
        if np.abs(torque[free]).max(initial=0.0) < CLOSE:
            return y, free
        slope = tangent(hand, coupled(hand, y), values, gravity)[np.ix_(free, free)]
        y[free] -= np.linalg.lstsq(slope, torque[free])[0]  # a joint that nothing holds has no slope at all; it stays where it is
        if not np.isfinite(y).all():
            break
    return None, free
