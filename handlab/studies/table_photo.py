"""A photograph of a hand on a table, computed: a pinhole camera above it, a ruler beside it, and the truth about every point.

Millimetres throughout; x to the right and y upwards in the picture, height above the table. The camera looks straight down.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand
from handlab.fitting.landmarks import NAMES, source_points
from handlab.fitting.raster import foremost

RULER_MM = 150
MARGIN_MM = 14.0
STRIP_MM, TALL_MM, STROKE_MM = 21.0, 4.2, 0.7  # width of the paper; height of a digit and of its line
# A pen's way through a cell of 4 by 6, upwards: "14 26 20" goes by (1, 4) and (2, 6) to (2, 0).
DIGITS = (
    "10 30 41 45 36 16 05 01 10",
    "14 26 20",
    "05 16 36 45 44 00 40",
    "05 16 36 45 44 33 13 33 42 41 30 10 01",
    "30 36 02 42",
    "46 06 04 34 43 41 30 10 01",
    "36 16 05 01 10 30 41 42 33 03",
    "06 46 10",
    "13 04 05 16 36 45 44 33 13 02 01 10 30 41 42 33",
    "10 30 41 45 36 16 05 04 13 43",
)
SKIN, PAPER, GROUND, INK = (np.array(rgb) for rgb in ((0.87, 0.66, 0.55), (0.97, 0.96, 0.91), (0.10, 0.12, 0.15), (0.12, 0.12, 0.12)))


@dataclass(frozen=True, eq=False)
class TablePhoto:
    """``pixels`` (rows, columns, 3) 0 to 255; ``marks_px`` of the feature points, ``ruler_px`` (2, 2) of its 0 and 150 mm.

    ``marks_mm``: the truth (x, y, height) of every feature point; ``ruler_mm``, ``camera_mm``: heights of ruler and camera above the table;
    ``centre_px``: straight below the camera.
    """

    pixels: NDArray[np.uint8]
    marks_px: Mapping[str, tuple[float, float]]
    marks_mm: Mapping[str, Array]
    ruler_px: Array
    centre_px: Array
    camera_mm: float
    ruler_mm: float

    @property
    def scale(self) -> dict[str, object]:
        """The two clicks on the ruler, as ``hl.fit_photo`` takes them."""
        return {"ruler": [tuple(place) for place in self.ruler_px.tolist()], "mm": RULER_MM}


def seen(points: ArrayLike, camera_mm: float) -> Array:
    """Where on the table (..., 2) mm the camera sees ``points`` (..., 3) (x, y, height), from the foot of its axis: similar triangles.

    >>> seen([100.0, 0.0, 20.0], 600.0).round(3).tolist()
    [103.448, 0.0]
    """
    p = np.asarray(points, dtype=np.float64)
    if not (np.isfinite(p).all() and (p[..., 2] < camera_mm).all()):
        raise ValueError(f"every point must be finite and below the camera, which is {camera_mm:g} mm above the table")
    result: Array = p[..., :2] * (camera_mm / (camera_mm - p[..., 2:]))
    return result


def table_photo(
    hand: Hand,
    *,
    camera_mm: float = 600.0,
    ruler_mm: float = 0.0,
    thickness: float = 1.0,
    view: str = "palmar",
    px_per_mm: float = 3.0,
) -> TablePhoto:
    """Photograph ``hand`` as it is stored, palm up (``view`` "palmar") or down, with a ruler ``ruler_mm`` above the table.

    ``thickness``: heights are multiplied by it, as of a hand that is so many times as thick. ``px_per_mm`` at the height of the table.
    """
    if not 0.0 <= ruler_mm < camera_mm / 2.0:
        raise ValueError(f"ruler_mm is {ruler_mm:g}; a camera {camera_mm:g} mm above the table shows rulers from 0 to below half of that")
    sign = 1.0 if view == "palmar" else -1.0
    turn = 1e3 * np.array([[0.0, 0.0, sign], [1.0, 0.0, 0.0], [0.0, sign * thickness, 0.0]])  # x, y, height from distal, palmar, radial
    skin, marks = hand.skin_fine.points @ turn.T, source_points(hand, view, NAMES, "exact") @ turn.T
    low, high = skin.min(axis=0), skin.max(axis=0)
    middle = np.array([*(low + high)[:2] / 2.0, low[2]])
    skin, marks = skin - middle, marks - middle
    x, y = skin[:, 0].min() - 16.0, skin[:, 1].min()
    ruler = np.array([[x, y, ruler_mm], [x, y + RULER_MM, ruler_mm]])
    faces = hand.skin_fine.faces if hand.side == "right" else hand.skin_fine.faces[:, [0, 2, 1]]
    flat, ends = seen(skin, camera_mm), seen(ruler, camera_mm)
    every = np.vstack([flat, ends, ends - np.array([MARGIN_MM, 0.0])])
    left, top = every.min(axis=0)[0] - MARGIN_MM, every.max(axis=0)[1] + MARGIN_MM
    size = np.ceil((np.array([every.max(axis=0)[0] + MARGIN_MM - left, top - every.min(axis=0)[1] + MARGIN_MM])) * px_per_mm).astype(int)

    def px(places: Array) -> Array:
        result: Array = (places - [left, top]) * [px_per_mm, -px_per_mm]
        return result

    picture = np.tile(GROUND, (int(size[1]), int(size[0]), 1))
    _ruler(picture, px(ends))
    front, _ = foremost(px(flat), skin[:, 2], faces, (int(size[1]), int(size[0])))
    picture[front >= 0] = _shaded(skin, faces, hand.side == "left")[front[front >= 0]]
    return TablePhoto(
        pixels=np.clip(255.0 * picture, 0.0, 255.0).astype(np.uint8),
        marks_px={name: (float(u), float(v)) for name, (u, v) in zip(NAMES, px(seen(marks, camera_mm)), strict=True)},
        marks_mm=dict(zip(NAMES, marks, strict=True)),
        ruler_px=px(ends),
        centre_px=px(np.zeros(2)),
        camera_mm=float(camera_mm),
        ruler_mm=float(ruler_mm),
    )


def _shaded(skin: Array, faces: NDArray[np.int64], flipped: bool) -> Array:
    a, b, c = (skin[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a) * (-1.0 if flipped else 1.0)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    result: Array = SKIN * (0.38 + 0.62 * np.clip(normal @ np.array([-0.38, 0.42, 0.82]), 0.0, 1.0))[:, None]
    return result


def _ruler(picture: Array, ends: Array) -> None:
    """A strip of paper whose right edge runs from 0 (below) to 150 mm: a line for every millimetre, a number for every ten."""
    (x, bottom), top = ends[0], ends[1, 1]
    per_mm = (bottom - top) / RULER_MM
    edge, spare = int(x), int(4 * per_mm)
    picture[max(0, int(top) - spare) : int(bottom) + spare, max(0, int(x - STRIP_MM * per_mm)) : edge] = PAPER
    for tick in range(RULER_MM + 1):
        row = round(bottom - tick * per_mm)
        long = 8.0 if tick % 50 == 0 else 6.0 if tick % 10 == 0 else 4.0 if tick % 5 == 0 else 2.5
        picture[row : row + 1, int(x - long * per_mm) : edge] = INK
        if tick % 10 == 0:
            _number(picture, tick, x - 9.0 * per_mm, row + 0.5, per_mm)


def _number(picture: Array, number: int, right: float, middle: float, per_mm: float) -> None:
    """Write ``number`` left of the column ``right``, about the row ``middle``, with soft edges."""
    unit = TALL_MM * per_mm / 6.0
    left = right - (5.4 * len(str(number)) - 1.4) * unit
    top = max(0, int(middle - 4.0 * unit))
    area = picture[top : int(middle + 4.0 * unit) + 1, max(0, int(left - unit)) : int(right + unit) + 1]
    pixel = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in area.shape[:2]), indexing="ij")[::-1], axis=-1)
    pixel += [max(0, int(left - unit)), top]
    far = np.full(area.shape[:2], np.inf)
    for k, digit in enumerate(str(number)):
        way = np.array([[int(one) for one in place] for place in DIGITS[int(digit)].split()])
        pen = np.array([left, middle]) + ((way + np.array([5.4 * k, -3.0])) * [unit, -unit])
        for a, b in pairwise(pen):
            along = np.clip((pixel - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
            far = np.minimum(far, np.linalg.norm(pixel - a - along[..., None] * (b - a), axis=-1))
    ink = np.clip(0.5 * max(STROKE_MM * per_mm, 1.0) + 0.5 - far, 0.0, 1.0)[..., None]
    area[:] = ink * INK + (1.0 - ink) * area
