"""The torque at one degree of freedom, taken apart: which muscle, which ligament, which friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Hand
from handlab.anatomy.terms import find
from handlab.physics.muscle import active_force_length, passive_force_length
from handlab.simulation.mechanics import fibre_lengths, mechanics
from handlab.simulation.skeleton import centres_of_mass, contraction_of
from handlab.simulation.state import State
from handlab.simulation.torque_kernel import passive_torque

NONE = (0.0, 0.0, 0.0)
STEP = 1e-5  # rad, of the central difference


@dataclass(frozen=True)
class Part:
    """One contribution in N m: ``active`` and ``passive`` of a muscle; what is no muscle is all passive."""

    name: str
    active: float
    passive: float

    @property
    def torque(self) -> float:
        """Both together, N m."""
        return self.active + self.passive


def torque_parts(
    hand: Hand, state: State, contraction: Mapping[str, float] | ArrayLike, dof: str, *, gravity: ArrayLike = NONE
) -> tuple[Part, ...]:
    """All that turns a moving degree of freedom at ``state``, largest first; what contributes nothing is left out.

    Muscles by abbreviation, with what reaches the degree of freedom through its followers; then the joint's linear stiffness, its
    ligaments (capsule and collateral), its friction, that of the capsule included, and ``gravity`` (3,) m/s^2. Their sum in N m is the
    net torque, R' F + passive - mu omega + weight. Not in it: a hard stop, and the inertia of other joints. Raises ``ValueError``
    for a follower.
    """
    name = find(dof, hand.dof_names, kind="degree of freedom")
    if hand.dofs[name].driver is not None:
        raise ValueError(f"{name!r} follows {hand.dofs[name].driver!r}; ask for that one instead")
    m, k = mechanics(hand), hand.moving_names.index(name)
    y, speed = np.array(state.angle[m.moving]), state.speed[m.moving]
    ratio = fibre_lengths(hand, state.angle) / hand.rest_length
    pull = m.arm[:, k] * hand.max_force
    active = contraction_of(hand, contraction) * active_force_length(ratio) * pull
    passive = passive_force_length(ratio) * pull
    parts = [Part(muscle.abbreviation, float(a), float(p)) for muscle, a, p in zip(hand.muscles.values(), active, passive, strict=True)]
    held, slope, drag = (np.zeros(len(y)) for _ in range(3))
    passive_torque(y, m, held, slope, drag, np.zeros((len(y), 2)))
    spring = -m.stiffness[k] * (y[k] - m.relaxed[k])
    parts.append(Part("joint stiffness", 0.0, float(spring)))
    parts.append(Part("ligaments", 0.0, float(held[k] - spring)))
    parts.append(Part("friction", 0.0, float(-drag[k] * speed[k])))
    parts.append(Part("weight", 0.0, weight_torque(hand, state, name, gravity)))
    return tuple(sorted((part for part in parts if abs(part.torque) > 1e-12), key=lambda part: -abs(part.torque)))


def weight_torque(hand: Hand, state: State, dof: str, gravity: ArrayLike) -> float:
    """Torque in N m that ``gravity`` (3,) m/s^2 has on a moving degree of freedom: work of all weights per radian of it."""
    weight = np.asarray(gravity, dtype=np.float64)
    if not weight.any():
        return 0.0
    mass = np.array([body.mass for body in hand.bodies.values()])
    by = STEP * hand.coupling[:, hand.moving_names.index(dof)]
    lifted = centres_of_mass(hand, state.angle + by) - centres_of_mass(hand, state.angle - by)
    return float(mass @ lifted @ weight / (2.0 * STEP))
