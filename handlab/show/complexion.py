"""The tone of the skin at every point: paler in the palm, redder in creases and over fingertips, nails pink.

It is painted from the shape alone, once per hand, so any hand that has bones and joints gets it; a hand with a picture of its own
shows that.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.records import Array, Hand
from handlab.show.colours import NAIL, SKIN, SKIN_DEEP, SKIN_PALE, SKIN_PALM
from handlab.show.surface import Normals, hollowness
from handlab.simulation.kinematics import posed_axes

LIT = 1.2  # skin in a photograph is lit already, and the viewer's light takes about a sixth again (an assumption)

NAIL_REACH = 0.010  # half of the broadest fingertip, metres
NAIL_WIDTH = 0.68
NAIL_LENGTH = 0.62  # of the distal phalanx
NAIL_MIDDLE = -0.07  # of the distal phalanx, from the tip of its bone


def complexion(hand: Hand) -> NDArray[np.uint8]:
    """Tones (Nf, 3) of the fine skin, 0 to 255."""
    fine = hand.skin_fine
    if hand.picture is not None:
        return pictured(hand.picture, fine.texture, fine.faces, len(fine.points))
    normals = Normals(fine.faces, len(fine.points)).of(fine.points)
    hollow = hollowness(fine.points, fine.faces, normals)
    tone = np.tile(np.array(SKIN, dtype=np.float64), (len(fine.points), 1))
    mix(tone, SKIN_PALM, 0.55 * np.clip(0.3 + 0.9 * normals[:, 1], 0.0, 1.0))
    mix(tone, SKIN_DEEP, 0.22 * near_tips(hand))
    mix(tone, SKIN_DEEP, 0.16 * over_knuckles(hand, normals))
    mix(tone, SKIN_DEEP, 0.50 * np.clip(hollow, 0.0, 1.0))
    mix(tone, SKIN_PALE, 0.18 * np.clip(-hollow, 0.0, 1.0))
    mix(tone, NAIL, 0.75 * nails(hand, normals))
    return np.asarray(np.clip(tone, 0, 255), dtype=np.uint8)


def pictured(picture: NDArray[np.uint8], texture: Array, faces: Any, count: int) -> NDArray[np.uint8]:
    """Tones (``count``, 3) that points have in a picture: the mean of the corners of their triangles."""
    at = np.clip((texture.reshape(-1, 2) * picture.shape[1::-1]).astype(np.int64), 0, np.array(picture.shape[1::-1]) - 1)
    total = np.zeros((count, 3))
    np.add.at(total, faces.ravel(), picture[at[:, 1], at[:, 0]].astype(np.float64))
    corners = np.maximum(np.bincount(faces.ravel(), minlength=count), 1)
    return np.asarray(np.clip(np.rint(LIT * total / corners[:, None]), 0, 255), dtype=np.uint8)


def mix(tone: Array, colour: tuple[int, int, int], amount: Any) -> None:
    """Blend ``colour`` into ``tone`` (N, 3) by ``amount`` (N,) from 0 to 1."""
    amount = np.asarray(amount, dtype=np.float64)[:, None]
    tone *= 1.0 - amount
    tone += amount * np.asarray(colour, dtype=np.float64)


def over_knuckles(hand: Hand, normals: Any) -> Array:
    """1 on the skin over a bending joint of a finger, falling to 0 over 12 mm (N,)."""
    points = hand.skin_fine.points
    _, centres = posed_axes(hand, hand.bind)
    near = np.zeros(len(points))
    for k, name in enumerate(hand.dof_names):
        if name.endswith("flexion_extension") and not name.startswith("wrist"):
            distance = np.linalg.norm(points - centres[k], axis=1)
            near = np.maximum(near, np.clip(1.0 - (distance - 0.008) / 0.012, 0.0, 1.0))
    result: Array = near * np.clip(-normals[:, 1], 0.0, 1.0)
    return result


def nails(hand: Hand, normals: Any) -> Array:
    """1 on the nails, 0 elsewhere, soft at the rim (N,).

    A nail is a rounded rectangle on the back of the fingertip: as long as half of the distal phalanx and a little narrower
    than the finger. Proportions by eye, on the folds that are modelled in the reference skin.
    """
    points = hand.skin_fine.points
    axes, centres = posed_axes(hand, hand.bind)
    painted = np.zeros(len(points))
    for digit in range(1, 6):
        k = hand.dof_names.index(f"{'ip' if digit == 1 else 'dip'}{digit}.flexion_extension")
        bone = hand.bones[f"distal_phalanx_{digit}"].points
        tip = bone[np.argmax(np.linalg.norm(bone - centres[k], axis=1))]
        along, length = (tip - centres[k]) / np.linalg.norm(tip - centres[k]), float(np.linalg.norm(tip - centres[k]))
        across = axes[k] - (axes[k] @ along) * along
        across /= np.linalg.norm(across)
        back = np.cross(along, across)
        offset = points - tip
        own = (np.linalg.norm(offset, axis=1) < length) & (np.abs(offset @ across) < NAIL_REACH)
        half = float(np.abs(offset[own] @ across).max()) * NAIL_WIDTH
        u = (offset @ along - NAIL_MIDDLE * length) / (NAIL_LENGTH * length / 2)
        v = (offset @ across) / half
        inside = np.clip(4.0 * (1.0 - (np.abs(u) ** 3 + np.abs(v) ** 3)), 0.0, 1.0)
        painted = np.maximum(painted, inside * own * (normals @ back > 0.35))
    return painted


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
