"""How long a time step may be before the printed explicit step runs away: dt < 2 J / mu, joint by joint."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.simulation.mechanics import mechanics, moments_of_inertia
from handlab.simulation.skeleton import rest
from handlab.simulation.state import State


def moving_inertia(hand: Hand, state: State | None = None) -> Array:
    """J (moving,) in kg m^2 at ``state`` (default: relaxed): of a coordinate and all that follows it, C' J C (section 4.1.2)."""
    angle = (rest(hand) if state is None else state).angle
    result: Array = (hand.coupling**2).T @ moments_of_inertia(hand, angle)
    return result


def step_limits(hand: Hand, state: State | None = None) -> Array:
    """Longest stable step (moving,) in seconds of (3), (4) and (2') as printed, 2 J / mu, from friction alone.

    A spring k taken explicitly too asks for less: dt mu / J + dt^2 k / (2 J) < 2. It counts at the wrist, hardly at a finger.
    """
    result: Array = 2.0 * moving_inertia(hand, state) / mechanics(hand).friction
    return result


def speed_factor(dt: ArrayLike, rate: ArrayLike, *, implicit: bool) -> Array:
    """What one step of friction alone multiplies the speed by: 1 - rate dt as printed, 1 / (1 + rate dt) implicitly; rate = mu / J.

    Below -1 the speed grows with every step and changes its sign each time.

    >>> float(speed_factor(1 / 60, 300.0, implicit=False)), round(float(speed_factor(1 / 60, 300.0, implicit=True)), 4)
    (-4.0, 0.1667)
    """
    slowed = np.asarray(dt, dtype=np.float64) * np.asarray(rate)
    result: Array = 1.0 / (1.0 + slowed) if implicit else 1.0 - slowed
    return result
