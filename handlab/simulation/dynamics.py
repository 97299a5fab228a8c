"""The equation of motion of a hand at a posture, to look at and to test: M(y) y'' + h(y, y') = torque, and its energies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.physics.ligament import between, capsule_torque, strain
from handlab.simulation.coupled_kernel import mass_and_bias, workspace
from handlab.simulation.mechanics import mechanics
from handlab.simulation.skeleton import centres_of_mass
from handlab.simulation.state import State
from handlab.simulation.torque_kernel import passive_torque as passive

WEIGHTLESS = (0.0, 0.0, 0.0)


class Energy(NamedTuple):
    """Joules: of motion, of height against gravity (0 at the wrist), and stored in springs, capsules and ligaments."""

    kinetic: float
    gravity: float
    passive: float


def _equation(hand: Hand, angle: ArrayLike, speed: ArrayLike, gravity: Sequence[float]) -> tuple[Array, Array]:
    m = mechanics(hand)
    count = len(m.moving)
    mass, bias = np.zeros((count, count)), np.empty(count)
    y, rate = (np.array(np.asarray(values, dtype=np.float64)[m.moving]) for values in (angle, speed))
    mass_and_bias(y, rate, np.array(gravity, dtype=np.float64), m, workspace(len(m.parent), len(m.ratio)), mass, bias)
    lower = np.tril(mass)
    return lower + np.tril(lower, -1).T, bias


def mass_matrix(hand: Hand, angle: ArrayLike) -> Array:
    """M (moving, moving) in kg m^2 at ``angle`` (dof,): kinetic energy is y' M y' / 2. Composite rigid bodies."""
    return _equation(hand, angle, np.zeros(len(hand.dof_names)), WEIGHTLESS)[0]


def bias(hand: Hand, angle: ArrayLike, speed: ArrayLike, gravity: Sequence[float] = WEIGHTLESS) -> Array:
    """h (moving,) in N m at ``angle`` and ``speed`` (dof,): velocity terms and gravity, M y'' + h = torque."""
    return _equation(hand, angle, speed, gravity)[1]


def passive_torque(hand: Hand, angle: ArrayLike, speed: ArrayLike | None = None) -> Array:
    """Torque (moving,) in N m of springs, capsules and ligaments; with ``speed`` (dof,) also of friction and of the capsules' drag."""
    return _passive(hand, angle, speed)[0]


def passive_slope(hand: Hand, angle: ArrayLike) -> Array:
    """Minus the derivative (moving,) of each passive torque by its own coordinate, N m/rad."""
    return _passive(hand, angle, None)[1]


def _passive(hand: Hand, angle: ArrayLike, speed: ArrayLike | None) -> tuple[Array, Array, float]:
    m = mechanics(hand)
    y = np.array(np.asarray(angle, dtype=np.float64)[m.moving])
    torque, slope, drag, stop = np.zeros(len(y)), np.empty(len(y)), np.empty(len(y)), np.empty((len(y), 2))
    stored = passive(y, m, torque, slope, drag, stop)
    if speed is not None:
        torque -= drag * np.asarray(speed, dtype=np.float64)[m.moving]
    return torque, slope, float(stored)


def hard_stops(hand: Hand, angle: ArrayLike) -> Array:
    """Where nothing gives any more (moving, 2), rad: past the limits, which MCP flexion narrows for a deviation."""
    m = mechanics(hand)
    y = np.array(np.asarray(angle, dtype=np.float64)[m.moving])
    stop = np.empty((len(y), 2))
    passive(y, m, np.zeros(len(y)), np.empty(len(y)), np.empty(len(y)), stop)
    return stop


class Capsules(NamedTuple):
    """How far each coordinate (moving,) stretches its capsule at the ``lower`` and ``upper`` end (1 at the limit), and its ``torque``."""

    lower: Array
    upper: Array
    torque: Array


def capsules(hand: Hand, angle: ArrayLike) -> Capsules:
    """The capsules at ``angle`` (dof,): see ``physics.ligament.capsule_torque``; deviations narrowed by flexed MCP joints."""
    m = mechanics(hand)
    y = np.asarray(angle, dtype=np.float64)[m.moving]
    nothing = np.zeros(len(y))
    if hand.capsule is None:
        return Capsules(nothing, nothing, nothing)
    left = np.where(m.tightened_by >= 0, between(1.0, m.range_fraction, y[m.tightened_by], m.taut_at), 1.0)
    bounds = left * m.limits[:, 0], left * m.limits[:, 1], left * m.width
    return Capsules(*strain(y, *bounds), capsule_torque(y, *bounds, *m.torque_at_limit.T))


def energy(hand: Hand, state: State, gravity: Sequence[float] = WEIGHTLESS) -> Energy:
    """Energies of a state in joules; friction, muscles and the capsules' drag are what changes their sum."""
    y_speed = state.speed[mechanics(hand).moving]
    weight = mechanics(hand).mass @ centres_of_mass(hand, state.angle) @ np.asarray(gravity, dtype=np.float64)
    return Energy(
        kinetic=float(0.5 * y_speed @ mass_matrix(hand, state.angle) @ y_speed),
        gravity=-float(weight),
        passive=_passive(hand, state.angle, None)[2],
    )
