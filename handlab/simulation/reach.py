"""Contractions whose steady posture comes nearest to a wanted one.

``balance.contraction_for`` asks what would hold the hand at a posture; where nothing holds it exactly, the hand drifts off,
far if the joints are slack. Here the posture that the hand really settles in is brought near the wanted one (Gauss-Newton).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand, frozen
from handlab.physics.muscle import active_force_length
from handlab.simulation.balance import contraction_for, muscle_ratio, settled, stops, tangent
from handlab.simulation.laws import Laws
from handlab.simulation.mechanics import mechanics
from handlab.simulation.skeleton import contraction_of, held_coordinates, pose, rest
from handlab.simulation.state import State

# Degrees of error that one muscle at full contraction is worth, in radians (an assumption: small).
EFFORT = np.deg2rad(0.5)
# Where a hand settles does not depend on its inertia, so the quicker law of motion serves.
QUICK = Laws(dynamics="decoupled")
LARGEST_STEP = 0.3  # of a contraction in one round
SMALLEST_STEP = 0.002
SECONDS = 4.0  # the slowest joint has come to rest: friction over stiffness is below 0.4 s


@dataclass(frozen=True, eq=False)
class Reached:
    """Contractions (muscle,), the ``state`` they settle in, and how far each target is missed, ``off`` by name, in radians."""

    contraction: Array
    state: State
    off: Mapping[str, float]

    @property
    def worst(self) -> float:
        """Largest error, radians."""
        return max(abs(value) for value in self.off.values())


def turn_per_contraction(hand: Hand, angle: ArrayLike, contraction: Array, free: NDArray[np.bool_]) -> Array:
    """How far each moving coordinate settles elsewhere when a muscle contracts more: (moving, muscle), radians.

    ``free`` (moving,): coordinates that are not held.
    """
    m = mechanics(hand)
    y = np.asarray(angle, dtype=np.float64)[m.moving]
    low, high = stops(hand, y)
    loose = free & ~low & ~high
    pull = (m.arm * (active_force_length(muscle_ratio(hand, y)) * m.max_force)[:, None]).T
    turn: Array = np.zeros_like(pull)
    stiffness = tangent(hand, angle, contraction)[np.ix_(loose, loose)]
    turn[loose] = -np.linalg.solve(stiffness, pull[loose])
    # what leans on a stop moves only once it is pulled off; let it count by its own stiffness, or it would never leave
    leaning = free & ~loose
    turn[leaning] = pull[leaning] / np.maximum(m.stiffness[leaning], 0.02)[:, None]
    return turn


def reach(
    hand: Hand,
    target: Mapping[str, float],
    *,
    weight: Mapping[str, float] | None = None,
    hold: Iterable[str] = (),
    muscles: Iterable[str] | None = None,
    near: Mapping[str, float] | ArrayLike | None = None,
    effort: float = EFFORT,
    rounds: int = 40,
) -> Reached:
    """Contractions in [0, 1] that settle nearest to ``target``: angles in radians by name of a moving degree of freedom.

    Angles that are not named are free, but pulled weakly to the relaxed hand. ``weight`` by name (1 if not given); ``hold``,
    ``muscles``, ``near`` and ``effort`` (here in radians) as in ``balance.contraction_for``. A target that ``hold`` holds is
    where the joint is held.
    """
    from scipy.optimize import lsq_linear

    m = mechanics(hand)
    hold = (hold,) if isinstance(hold, str) else tuple(hold)
    allowed = None if muscles is None else tuple(muscles)
    start = pose(hand, target)
    aim = start.angle[m.moving]
    scale = np.full(len(aim), 0.02)
    for name in target:
        scale[hand.moving_names.index(hand.dofs[name].name)] = (weight or {}).get(name, 1.0)
    wanted = np.zeros(len(m.max_force)) if near is None else contraction_of(hand, near)
    may = np.zeros(len(wanted), dtype=bool)
    may[[hand.muscle_names.index(hand.muscles[name].name) for name in (hand.muscle_names if allowed is None else allowed)]] = True
    free = ~held_coordinates(hand, hold)

    def at(contraction: Array) -> tuple[State, float]:
        state = settled(hand, contraction, hold=hold, start=start, seconds=SECONDS, laws=QUICK)
        error = np.where(free, scale * (state.angle[m.moving] - aim), 0.0)
        return state, float(np.sum(error**2) + effort**2 * np.sum((contraction - wanted) ** 2))

    contraction = np.array(contraction_for(hand, start.angle, hold=hold, muscles=allowed, near=near).contraction)
    state, cost = at(contraction)
    step = LARGEST_STEP
    for _ in range(rounds):
        y = state.angle[m.moving]
        turn = turn_per_contraction(hand, state.angle, contraction, free)
        matrix = np.vstack([(scale[:, None] * turn)[free][:, may], effort * np.eye(int(may.sum()))])
        goal = np.concatenate([(scale * (aim - y))[free], effort * (wanted - contraction)[may]])
        bounds = np.maximum(-step, -contraction[may]) - 1e-12, np.minimum(step, 1.0 - contraction[may]) + 1e-12
        change = np.zeros(len(contraction))
        change[may] = lsq_linear(matrix, goal, bounds=bounds, method="bvls", max_iter=1000).x
        tried = np.clip(contraction + change, 0.0, 1.0)
        tried_state, tried_cost = at(tried)
        if tried_cost < cost:
            finished = cost - tried_cost < 1e-7
            contraction, state, cost, step = tried, tried_state, tried_cost, min(LARGEST_STEP, 1.5 * step)
            if finished:
                break
        else:
            step *= 0.4
            if step < SMALLEST_STEP:
                break
    found = settled(hand, contraction, hold=hold, start=start if any(~free) else rest(hand), seconds=SECONDS, laws=QUICK)
    off = {name: float(found.angle[hand.dof_names.index(hand.dofs[name].name)] - value) for name, value in target.items()}
    return Reached(frozen(contraction), found, off)
