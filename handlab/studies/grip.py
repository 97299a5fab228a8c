"""What the wrist leaves of the strength of the fingers: active insufficiency of the flexors, passive pull of the extensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.physics.muscle import active_force_length, passive_force_length
from handlab.simulation.mechanics import fibre_lengths
from handlab.simulation.skeleton import pose

# Degrees of flexion of the four fingers in a fist: an assumption, what a closed hand shows.
FIST_DEG = {"mcp": 75.0, "pip": 95.0, "dip": 45.0}
DEEP = ("FDP2", "FDP3", "FDP4", "FDP5")
SUPERFICIAL = ("FDS2", "FDS3", "FDS4", "FDS5")
EXTENSORS = ("EDC2", "EDC3", "EDC4", "EDC5", "EIP", "EDM")


@dataclass(frozen=True, eq=False)
class WristForce:
    """Forces (wrist angle,) in newtons at ``angle_deg``: flexors active at full contraction, extensors by their stretch alone."""

    angle_deg: Array
    deep: Array
    superficial: Array
    extensors: Array

    @property
    def flexors(self) -> Array:
        """All eight long finger flexors."""
        return self.deep + self.superficial


def wrist_force(hand: Hand, wrist_deg: ArrayLike | None = None, *, fingers_deg: Mapping[str, float] = FIST_DEG) -> WristForce:
    """Forces of the long finger muscles while the wrist goes through its range and the fingers stay as they are.

    ``wrist_deg`` (n,) in degrees of flexion (default: limit to limit); ``fingers_deg``: flexion of mcp, pip and dip of all fingers.
    """
    low, high = np.rad2deg(hand.dofs["wrist.flexion_extension"].limits)
    at = np.linspace(low, high, 146) if wrist_deg is None else np.atleast_1d(np.asarray(wrist_deg, dtype=np.float64))
    fingers = {f"{joint}{digit}.flexion_extension": np.deg2rad(value) for joint, value in fingers_deg.items() for digit in range(2, 6)}
    angle = np.tile(pose(hand, fingers).angle, (len(at), 1))
    angle[:, hand.dof_names.index("wrist.flexion_extension")] = np.deg2rad(at)
    ratio = fibre_lengths(hand, angle) / hand.rest_length
    active, passive = active_force_length(ratio) * hand.max_force, passive_force_length(ratio) * hand.max_force

    def of(force: Array, names: tuple[str, ...]) -> Array:
        rows = [hand.muscle_names.index(hand.muscles[name].name) for name in names]
        total: Array = force[:, rows].sum(axis=1)
        return total

    return WristForce(at, of(active, DEEP), of(active, SUPERFICIAL), of(passive, EXTENSORS))
