"""The tone of the skin at every point: paler in the palm, redder in creases and over fingertips, nails pink.

It is painted from the shape alone, once per hand, so any hand that has bones and joints gets it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.records import Array, Hand
from handlab.show.colours import SKIN, SKIN_DEEP, SKIN_PALE, SKIN_PALM
from handlab.show.surface import Normals, hollowness


def complexion(hand: Hand) -> NDArray[np.uint8]:
    """Tones (Nf, 3) of the fine skin, 0 to 255."""
    fine = hand.skin_fine
    normals = Normals(fine.faces, len(fine.points)).of(fine.points)
    hollow = hollowness(fine.points, fine.faces, normals)
    tone = np.tile(np.array(SKIN, dtype=np.float64), (len(fine.points), 1))
    mix(tone, SKIN_PALM, 0.55 * np.clip(0.3 + 0.9 * normals[:, 1], 0.0, 1.0))
    mix(tone, SKIN_DEEP, 0.22 * near_tips(hand))
    mix(tone, SKIN_DEEP, 0.50 * np.clip(hollow, 0.0, 1.0))
    mix(tone, SKIN_PALE, 0.18 * np.clip(-hollow, 0.0, 1.0))
    return np.asarray(np.clip(tone, 0, 255), dtype=np.uint8)


def mix(tone: Array, colour: tuple[int, int, int], amount: Any) -> None:
    """Blend ``colour`` into ``tone`` (N, 3) by ``amount`` (N,) from 0 to 1."""
    amount = np.asarray(amount, dtype=np.float64)[:, None]
    tone *= 1.0 - amount
    tone += amount * np.asarray(colour, dtype=np.float64)


def near_tips(hand: Hand) -> Array:
    """1 at the fingertips, falling to 0 over 25 mm (N,)."""
    points = hand.skin_fine.points
    distance = np.full(len(points), np.inf)
    for digit in range(1, 6):
        bone = hand.bones[f"distal_phalanx_{digit}"].points
        tip = bone[np.argmax(np.linalg.norm(bone, axis=1))]  # the wrist centre is the origin
        distance = np.minimum(distance, np.linalg.norm(points - tip, axis=1))
    result: Array = np.clip(1.0 - distance / 0.025, 0.0, 1.0)
    return result
