"""Static balance: which torque is left at a posture, and which contractions leave none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand, frozen
from handlab.physics.ligament import between, collateral_torque
from handlab.physics.muscle import active_force_length, active_slope, muscle_force, passive_force_length, passive_slope
from handlab.simulation.skeleton import SUBSTEP, contraction_of, held_coordinates, integrate, mechanics, state_at
from handlab.simulation.state import State

Flags = NDArray[np.bool_]

# A joint this near to a limit leans on its stop (an assumption; a posture is aimed at, not met).
NEAR_LIMIT = np.deg2rad(0.5)
# Torque that one muscle at full contraction is worth: effort decides only where balance leaves a choice (an assumption).
EFFORT = 1e-3


def muscle_ratio(hand: Hand, y: Array) -> Array:
    """Fibre length over resting length (muscle,) at moving coordinates (moving,)."""
    m = mechanics(hand)
    result: Array = (m.length_at_zero - m.arm @ y) / m.rest_length
    return result


def passive_torque(hand: Hand, y: Array) -> Array:
    """Torque (moving,) of joint stiffness and collateral ligaments, N m."""
    m = mechanics(hand)
    torque: Array = -m.stiffness * (y - m.rest_y)
    d, f = m.collateral_deviation, m.collateral_flexion
    on_deviation, on_flexion = collateral_torque(m.stiffness[d], m.stiffness_factor, y[f], y[d], m.rest_y[d])
    torque[d] = on_deviation
    torque[f] += on_flexion
    return torque


def stops(hand: Hand, y: Array) -> tuple[Flags, Flags]:
    """Whether each moving coordinate leans on its lower and its upper stop, collateral ligaments included."""
    m = mechanics(hand)
    limits = np.array(m.limits)
    d, f = m.collateral_deviation, m.collateral_flexion
    limits[d] *= between(1.0, m.range_fraction, y[f])[:, None]
    return y <= limits[:, 0] + NEAR_LIMIT, y >= limits[:, 1] - NEAR_LIMIT


def total_torque(hand: Hand, y: Array, contraction: Array) -> Array:
    """Torque (moving,) of muscles, stiffness and ligaments, N m; stops and friction not included."""
    m = mechanics(hand)
    force = muscle_force(contraction, muscle_ratio(hand, y), m.max_force)
    result: Array = m.arm.T @ force + passive_torque(hand, y)
    return result


def unbalanced(hand: Hand, angle: ArrayLike, contraction: Mapping[str, float] | ArrayLike, *, hold: Iterable[str] = ()) -> Array:
    """Torque (moving,) in N m that would move the hand at ``angle`` (dof,): what held joints and stops take up is left out."""
    y = np.asarray(angle, dtype=np.float64)[mechanics(hand).moving]
    torque = total_torque(hand, y, contraction_of(hand, contraction))
    low, high = stops(hand, y)
    torque = np.where(low, np.maximum(torque, 0.0), torque)
    torque = np.where(high, np.minimum(torque, 0.0), torque)
    return np.where(held_coordinates(hand, hold), 0.0, torque)


def tangent(hand: Hand, angle: ArrayLike, contraction: Mapping[str, float] | ArrayLike) -> Array:
    """Derivative (moving, moving) of the torque by the moving coordinates, N m/rad, without stops; symmetric.

    A balance is stable where all its eigenvalues are negative.
    """
    m = mechanics(hand)
    y = np.asarray(angle, dtype=np.float64)[m.moving]
    ratio = muscle_ratio(hand, y)
    per_length = (contraction_of(hand, contraction) * active_slope(ratio) + passive_slope(ratio)) * m.max_force / m.rest_length
    step = 1e-6
    passive = [(passive_torque(hand, y + step * e) - passive_torque(hand, y - step * e)) / (2.0 * step) for e in np.eye(len(y))]
    result: Array = -m.arm.T @ (per_length[:, None] * m.arm) + np.array(passive).T
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
) -> Balance:
    """Contractions in [0, 1] that balance the hand best at ``angle`` (dof,): bounded least squares.

    Forces are linear in the contractions while the posture stands still, so the answer is exact. Minimises
    sum (weight torque)^2 + effort^2 sum (contraction - near)^2, in N m. ``muscles``: only these may contract; ``weight`` by
    degree of freedom (1 if not given); ``near``: contractions to stay close to (0). A stop takes up what presses against it.
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
    pull = (m.arm * (active_force_length(ratio) * m.max_force)[:, None]).T[:, allowed]
    push = np.eye(len(y))[:, low].copy(), -np.eye(len(y))[:, high]
    constant = m.arm.T @ (passive_force_length(ratio) * m.max_force) + passive_torque(hand, y)
    columns = np.hstack([pull, *push])
    count = int(allowed.sum())
    reactions = columns.shape[1] - count
    matrix = np.vstack([(scale[:, None] * columns)[free], effort * np.eye(count, columns.shape[1])])
    target = np.concatenate([(-scale * constant)[free], effort * aim[allowed]])
    upper = np.concatenate([np.ones(count), np.full(reactions, np.inf)])
    solved = lsq_linear(matrix, target, bounds=(np.zeros(count + reactions), upper), method="bvls", max_iter=1000)
    contraction = np.zeros(len(allowed))
    contraction[allowed] = np.clip(solved.x[:count], 0.0, 1.0)
    full = hand.coupling @ y + hand.coupling_offset
    return Balance(frozen(full), frozen(contraction), frozen(unbalanced(hand, full, contraction, hold=hold)))


def settled(
    hand: Hand, contraction: Mapping[str, float] | ArrayLike, *, hold: Iterable[str] = (), start: State | None = None, seconds: float = 5.0
) -> State:
    """The state after ``seconds`` of constant contraction: its steady posture, for most."""
    from handlab.simulation.skeleton import rest

    state = rest(hand) if start is None else start
    moving = mechanics(hand).moving
    values = np.tile(contraction_of(hand, contraction), (round(seconds / SUBSTEP), 1))
    y, speed = integrate(hand, state.angle[moving], state.speed[moving], values, SUBSTEP, held_coordinates(hand, hold))
    return state_at(hand, y[-1], speed[-1], state.time + seconds)
