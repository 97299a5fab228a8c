"""How far the camera likely was where the file does not tell: what lies higher looks larger, so the points themselves say something.

The clicks are laid onto the reference hand as cameras at several distances would have seen it; where least is left over is the distance
that fits best. People differ too, so that this is uncertain: on the backs of fifteen known people it scatters by 0.4 / m in 1 / distance,
as much as people's habits do (45 cm to 1 m), so half of it is believed. Palms tell nothing (0.9 / m): their points lie nearly in one
plane.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.fitting.alignment import conclude
from handlab.fitting.fit import aligned_marks
from handlab.fitting.lens import ASSUMED_MM, Camera
from handlab.fitting.lifting import from_far
from handlab.fitting.mistakes import FitError

TRIED = np.array([0.4, 1.0, 1.6, 2.2, 2.8]) * 1e-3  # 1 / mm
BELIEVED = 0.5
ENOUGH = 24  # of the 26 points
ROUNDS = 3


def camera_by_points(hand: Hand, clicks: Mapping[str, Any], mm_per_px: float, centre_px: ArrayLike, **options: Any) -> Camera | None:
    """The camera that ``likely_distance_mm`` suggests, or none; ``options`` of ``fit_points``, which tells what is wrong with them."""
    how = {key: options[key] for key in ("view", "side", "mirror") if key in options}
    with suppress(FitError):
        distance = likely_distance_mm(hand, clicks, mm_per_px, np.asarray(centre_px), **how)
        return None if distance is None else Camera(distance, "likely by the points")
    return None


def likely_distance_mm(
    hand: Hand,
    clicks: Mapping[str, tuple[float, float]],
    mm_per_px: float,
    centre_px: Array,
    *,
    view: str | None = None,
    side: str | None = None,
    mirror: bool = False,
) -> float | None:
    """The distance from the camera to the table by nearly all points of the back of a hand; None where they tell nothing.

    Raises ``FitError`` and ``FitQuestion`` as ``alignment.conclude``.
    """
    names = tuple(clicks)
    if len(names) < ENOUGH:
        return None
    up = mm_per_px * np.array([1.0, -1.0])
    picture, centre = np.array(list(clicks.values())) * up, np.asarray(centre_px) * up
    own, concluded = conclude(hand, names, picture, view=view, side=side, mirror=mirror)
    if concluded != "dorsal":
        return None
    flip = np.array([-1.0, 1.0]) if mirror else np.ones(2)
    left = [_left_over(own, concluded, names, picture * flip, centre * flip, 1.0 / near) for near in TRIED]
    bend, slope, _ = np.polyfit(TRIED, left, 2)
    if bend <= 0.0:
        return None
    best = float(np.clip(-slope / (2.0 * bend), TRIED[0], TRIED[-1]))
    return 1.0 / (BELIEVED * best + (1.0 - BELIEVED) / ASSUMED_MM)


def _left_over(hand: Hand, view: str, names: tuple[str, ...], picture: Array, centre: Array, distance_mm: float) -> float:
    """What the best similarity leaves over (mm^2 in the size of the reference hand)."""
    found = aligned_marks(hand, view, names, picture, "least squares", None)
    for _ in range(ROUNDS):
        found = aligned_marks(hand, view, names, from_far(found, picture, centre, distance_mm), "least squares", None)
    return float(np.sum(found.fit.residual**2)) / found.fit.scale**2
