"""Clicks of lesson 11 with one that is wrong. Which one is for the student to find."""

from __future__ import annotations

from functools import cache

import numpy as np

from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Array, frozen
from handlab.fitting.landmarks import NAMES, source_points

WRONG = "dip_ring"
OFF = np.array([-0.030, 0.0, 0.0])  # m: one crease nearer to the wrist


@cache
def misplaced() -> Array:
    """The child's feature points (26, 3) m, one of them wrong."""
    points = source_points(load_hand("child"), "palmar", NAMES, "exact").copy()
    points[NAMES.index(WRONG)] += OFF
    return frozen(points)
