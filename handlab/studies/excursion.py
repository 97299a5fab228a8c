"""How far a muscle must shorten for its joints, and how far its fibre can: required and potential excursion (Brand)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.simulation.mechanics import moving_limits

# From the ends of the active force-length curve: a fibre that pulls between 0.6 and 1.6 of its rest length can shorten by all of it.
ACTIVE_RANGE = (0.6, 1.6)
# Rows of joints from the forearm outwards, as a muscle passes them.
LEVELS = {
    "wrist": ("wrist",),
    "CMC": ("cmc1", "cmc4", "cmc5"),
    "MCP": ("mcp1", "mcp2", "mcp3", "mcp4", "mcp5"),
    "PIP and IP": ("ip1", "pip2", "pip3", "pip4", "pip5"),
    "DIP": ("dip2", "dip3", "dip4", "dip5"),
}


def required_excursion(hand: Hand) -> Mapping[str, Array]:
    """Excursion (muscle,) in metres at every level of joints when each of its rotations goes from limit to limit.

    |r| times the range of every moving coordinate, r with what follows it (R C). Limits of single joints: no hand reaches all of them
    at once, so this is the most that can ever be asked.
    """
    low, high = moving_limits(hand).T
    travel = np.abs(hand.lever_arm @ hand.coupling) * (high - low)
    joint = [name.partition(".")[0] for name in hand.moving_names]
    return {level: travel[:, [k for k, name in enumerate(joint) if name in joints]].sum(axis=1) for level, joints in LEVELS.items()}


def potential_excursion(hand: Hand) -> Array:
    """What an active fibre can shorten by (muscle,), metres: from 1.6 to 0.6 of its rest length, which is its rest length."""
    result: Array = (ACTIVE_RANGE[1] - ACTIVE_RANGE[0]) * hand.rest_length
    return result
