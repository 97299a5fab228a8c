"""Static balance: which torque is left at a posture, and which contractions leave none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand, frozen
from handlab.physics.muscle import active_force_length, active_slope, muscle_force, passive_force_length, passive_slope
from handlab.simulation import dynamics
from handlab.simulation.dynamics import WEIGHTLESS
from handlab.simulation.laws import SOUND, Laws
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skeleton import contraction_of, held_coordinates, integrate, state_at, substeps_of
from handlab.simulation.state import State

Flags = NDArray[np.bool_]

# A joint without capsule this near to a limit leans on its stop (an assumption; a posture is aimed at, not met).
NEAR_LIMIT = np.deg2rad(0.5)
# Torque that one muscle at full contraction is worth: effort decides only where balance leaves a choice (an assumption).
EFFORT = 1e-3


def muscle_ratio(hand: Hand, y: Array) -> Array:
    """Fibre length over resting length (muscle,) at moving coordinates (moving,)."""
    m = mechanics(hand)
    result: Array = (m.length_at_zero - m.arm @ y) / m.rest_length
    return result


def other_torque(hand: Hand, y: Array, gravity: Sequence[float] = WEIGHTLESS) -> Array:
    """Torque (moving,) of all but the muscles: springs, capsules, ligaments and weight, N m."""
    angle = coupled(hand, y)
    torque = dynamics.passive_torque(hand, angle)
    if any(gravity):
        torque = torque - dynamics.bias(hand, angle, np.zeros(len(angle)), gravity)
    return torque


def stops(hand: Hand, y: Array) -> tuple[Flags, Flags]:
    """Whether each moving coordinate leans on its lower and its upper hard stop, where nothing gives any more."""
    stop = dynamics.hard_stops(hand, coupled(hand, y))
    near = NEAR_LIMIT if hand.capsule is None else 1e-9
    return y <= stop[:, 0] + near, y >= stop[:, 1] - near


def total_torque(hand: Hand, y: Array, contraction: Array, gravity: Sequence[float] = WEIGHTLESS) -> Array:
    """Torque (moving,) of muscles, passive structures and weight, N m; hard stops and friction not included."""
    m = mechanics(hand)
    force = muscle_force(contraction, muscle_ratio(hand, y), m.max_force)
    result: Array = m.arm.T @ force + other_torque(hand, y, gravity)
    return result


def unbalanced(
    hand: Hand,
    angle: ArrayLike,
    contraction: Mapping[str, float] | ArrayLike,
    *,
    hold: Iterable[str] = (),
    gravity: Sequence[float] = WEIGHTLESS,
) -> Array:
    """Torque (moving,) in N m that would move the hand at ``angle`` (dof,): what held joints and hard stops take up is left out."""
    y = np.asarray(angle, dtype=np.float64)[mechanics(hand).moving]
    torque = total_torque(hand, y, contraction_of(hand, contraction), gravity)
    low, high = stops(hand, y)
    torque = np.where(low, np.maximum(torque, 0.0), torque)
    torque = np.where(high, np.minimum(torque, 0.0), torque)
    return np.where(held_coordinates(hand, hold), 0.0, torque)


def tangent(hand: Hand, angle: ArrayLike, contraction: Mapping[str, float] | ArrayLike, gravity: Sequence[float] = WEIGHTLESS) -> Array:
    """Derivative (moving, moving) of the torque by the moving coordinates, N m/rad, without hard stops; symmetric.

    A balance is stable where all its eigenvalues are negative.
    """
    m = mechanics(hand)
    y = np.asarray(angle, dtype=np.float64)[m.moving]
    ratio = muscle_ratio(hand, y)
    per_length = (contraction_of(hand, contraction) * active_slope(ratio) + passive_slope(ratio)) * m.max_force / m.rest_length
    step = 1e-6
    other = [(other_torque(hand, y + step * e, gravity) - other_torque(hand, y - step * e, gravity)) / (2.0 * step) for e in np.eye(len(y))]
    result: Array = -m.arm.T @ (per_length[:, None] * m.arm) + np.array(other).T
    return result


@dataclass(frozen=True, eq=False)
class Balance:
    """Contractions (muscle,) and the torque (moving,) in N m that they leave at ``angle`` (dof,)."""

    angle: Array
    contraction: Array
    unbalanced: Array

    @property
    def worst(self) -> float:
        """Largest unbalanced torque, N m."""
        return float(np.abs(self.unbalanced).max())


def contraction_for(
    hand: Hand,
    angle: ArrayLike,
    *,
    hold: Iterable[str] = (),
    muscles: Iterable[str] | None = None,
    weight: Mapping[str, float] | None = None,
    near: Mapping[str, float] | ArrayLike | None = None,
    effort: float = EFFORT,
    gravity: Sequence[float] = WEIGHTLESS,
) -> Balance:
    """Contractions in [0, 1] that balance the hand best at ``angle`` (dof,): bounded least squares.

    Forces are linear in the contractions while the posture stands still, so the answer is exact. Minimises
    sum (weight torque)^2 + effort^2 sum (contraction - near)^2, in N m. ``muscles``: only these may contract; ``weight`` by
    degree of freedom (1 if not given); ``near``: contractions to stay close to (0). Where a capsule is stretched or a stop reached, it
    takes up whatever presses against it: a joint settles within its width of the posture.
    """
    from scipy.optimize import lsq_linear

    m = mechanics(hand)
    y = np.asarray(angle, dtype=np.float64)[m.moving]
    ratio = muscle_ratio(hand, y)
    free = ~held_coordinates(hand, hold)
    scale = np.ones(len(y))
    for name, value in (weight or {}).items():
        scale[hand.moving_names.index(hand.dofs[name].name)] = value
    allowed = np.ones(len(m.max_force), dtype=bool)
    if muscles is not None:
        allowed[:] = False
        allowed[[hand.muscle_names.index(hand.muscles[name].name) for name in muscles]] = True
    aim = np.zeros(len(allowed)) if near is None else contraction_of(hand, near)
    low, high = stops(hand, y)
    stretched = dynamics.capsules(hand, coupled(hand, y))
    low, high = low | (stretched.lower > 0.0), high | (stretched.upper > 0.0)
    pull = (m.arm * (active_force_length(ratio) * m.max_force)[:, None]).T[:, allowed]
    push = np.eye(len(y))[:, low].copy(), -np.eye(len(y))[:, high]
    constant = m.arm.T @ (passive_force_length(ratio) * m.max_force) + other_torque(hand, y, gravity)
    constant -= stretched.torque
    columns = np.hstack([pull, *push])
    count = int(allowed.sum())
    reactions = columns.shape[1] - count
    matrix = np.vstack([(scale[:, None] * columns)[free], effort * np.eye(count, columns.shape[1])])
    target = np.concatenate([(-scale * constant)[free], effort * aim[allowed]])
    upper = np.concatenate([np.ones(count), np.full(reactions, np.inf)])
    solved = lsq_linear(matrix, target, bounds=(np.zeros(count + reactions), upper), method="bvls", max_iter=1000)
    contraction = np.zeros(len(allowed))
    contraction[allowed] = np.clip(solved.x[:count], 0.0, 1.0)
    left = np.where(free, columns @ solved.x + constant, 0.0)
    return Balance(frozen(coupled(hand, y)), frozen(contraction), frozen(left))


def settled(
    hand: Hand,
    contraction: Mapping[str, float] | ArrayLike,
    *,
    hold: Iterable[str] = (),
    start: State | None = None,
    seconds: float = 5.0,
    laws: Laws = SOUND,
) -> State:
    """The state after ``seconds`` of constant contraction: its steady posture, for most (see ``settle.settle``)."""
    from handlab.simulation.skeleton import rest

    state = rest(hand) if start is None else start
    moving = mechanics(hand).moving
    substeps = substeps_of(seconds, laws)
    values = np.tile(contraction_of(hand, contraction), (substeps, 1))
    held = held_coordinates(hand, hold)
    y, speed = integrate(hand, state.angle[moving], state.speed[moving], values, seconds / substeps, held, laws)
    return state_at(hand, y[-1], speed[-1], state.time + seconds)
