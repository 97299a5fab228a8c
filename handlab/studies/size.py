"""What size does to a hand that moves: how strong it is, how soon it is there, how far it sags."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.simulation.dynamics import mass_matrix
from handlab.simulation.play import simulate
from handlab.simulation.settle import settle

PULL: Mapping[str, float] = {"FDP2": 0.3, "FDS2": 0.3}
KNUCKLE = "mcp2.flexion_extension"
SECONDS, FPS = 1.5, 1200.0  # by then every hand is at rest; a frame for every substep
EARTH = 9.81  # m/s^2


def path(hand: Hand, contraction: Mapping[str, float] = PULL, rotation: str = KNUCKLE, hold: Iterable[str] = ("wrist",)) -> Array:
    """Times (n,) s and angles (n,) rad as two rows (2, n): a rotation from the relaxed hand on, under constant contraction."""
    clip = simulate(hand, contraction, seconds=SECONDS, fps=FPS, hold=hold)
    return np.stack([clip.time, clip.angle[:, hand.dof_names.index(hand.dofs[rotation].name)]])


def half_time(hand: Hand, contraction: Mapping[str, float] = PULL, rotation: str = KNUCKLE, hold: Iterable[str] = ("wrist",)) -> float:
    """Seconds until a rotation is half way from where it begins to where it is after 1.5 s."""
    time, angle = path(hand, contraction, rotation, hold)
    share = (angle - angle[0]) / (angle[-1] - angle[0])
    after = int(np.argmax(share >= 0.5))
    return float(np.interp(0.5, share[after - 1 : after + 1], time[after - 1 : after + 1]))


def strengths(hand: Hand, rotation: str = KNUCKLE, muscle: str = "FDP2") -> dict[str, float]:
    """Length (m, wrist centre to middle tip), greatest ``force`` of a muscle (N), its ``torque`` (N m) and the ``inertia`` (kg m^2) there.

    The inertia is that of the straight hand, of everything that hangs on the rotation.
    """
    row, column = hand.muscle_names.index(hand.muscles[muscle].name), hand.dof_names.index(hand.dofs[rotation].name)
    tip = hand.skin.points[hand.feature_points["tip_middle"]["palmar"]]
    force = float(hand.max_force[row])
    moving = hand.moving_names.index(hand.dof_names[column])
    return {
        "length": float(np.linalg.norm(tip - hand.joints["wrist"].centre)),
        "force": force,
        "torque": force * abs(float(hand.lever_arm[row, column])),
        "inertia": float(mass_matrix(hand, hand.zero)[moving, moving]),
    }


def sag(hand: Hand, gravity: float = EARTH) -> float:
    """By how many radians the wrist of a silent hand flexes when its palm is turned down."""
    wrist = hand.dof_names.index("wrist.flexion_extension")
    rests = [settle(hand, {}, gravity=(0.0, g, 0.0), look_for_others=False).state.angle[wrist] for g in (0.0, gravity)]
    return float(rests[1] - rests[0])
