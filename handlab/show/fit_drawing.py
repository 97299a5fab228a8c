"""The small drawing of a hand that shows which point is wanted: the reference hand, palm or back, shaded from its own shape."""

from __future__ import annotations

import io
from functools import cache
from typing import NamedTuple

import numpy as np

from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Array
from handlab.fitting.alignment import frame_towards, likely_view
from handlab.fitting.landmarks import NAMES, source_points
from handlab.fitting.raster import pixels
from handlab.show.complexion import complexion
from handlab.show.surface import Normals

HEIGHT = 520  # pixels of the drawing
FINER = 2  # drawn so many times as large, then reduced: smooth edges
MARGIN = 0.03
LOW = 0.42  # light in the shade
PALE = 0.25  # of white mixed in: marks must stand out


class Drawing(NamedTuple):
    """``png`` of the right hand, fingers up; ``size`` (width, height); ``places``: name -> (x, y), parts of width and height."""

    png: bytes
    size: tuple[int, int]
    places: dict[str, tuple[float, float]]


@cache
def drawing(view: str) -> Drawing:
    """The drawing of the palm ("palmar") or the back ("dorsal")."""
    hand = load_hand()
    fine = hand.skin_fine
    frame = frame_towards(likely_view(hand, view), np.zeros(3))
    flat = frame.flat(fine.points) * [1.0, -1.0]
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = FINER * HEIGHT * (1 - 2 * MARGIN) / (high[1] - low[1])
    corner = low - MARGIN * (high[1] - low[1])
    shape = (FINER * HEIGHT, FINER * int(np.ceil((high[0] - low[0]) * scale / FINER + 2 * MARGIN * HEIGHT)))
    row, column, triangle, share = pixels((flat - corner) * scale, fine.faces, shape)
    corners = fine.faces[triangle]
    order = np.argsort((share * frame.height(fine.points)[corners]).sum(axis=1), kind="stable")  # the nearest is written last
    row, column, share, corners = row[order], column[order], share[order], corners[order]
    shade = _shaded(Normals(fine.faces, len(fine.points)).of(fine.points), frame.towards, frame.up, frame.across)
    colour = shade[:, None] * ((1 - PALE) * complexion(hand).astype(np.float64) + PALE * 255.0)
    sheet = np.zeros((*shape, 4))
    sheet[row, column, :3] = (share[:, :, None] * colour[corners]).sum(axis=1)
    sheet[row, column, 3] = 255.0
    small = sheet.reshape(HEIGHT, FINER, shape[1] // FINER, FINER, 4)
    cover = small[..., 3:].sum(axis=(1, 3))
    mean = (small[..., :3] * small[..., 3:]).sum(axis=(1, 3)) / np.maximum(cover, 1.0)
    size = (shape[1] // FINER, HEIGHT)
    places = (frame.flat(source_points(hand, view, NAMES, "exact")) * [1.0, -1.0] - corner) * scale / FINER / np.array(size)
    return Drawing(
        _png(np.concatenate([mean, cover / FINER**2], axis=2)),
        size,
        dict(zip(NAMES, ((round(float(x), 4), round(float(y), 4)) for x, y in places), strict=True)),
    )


def _shaded(normals: Array, towards: Array, up: Array, across: Array) -> Array:
    """Light from the upper left, and darker towards the outline so that fingers part."""
    light = 0.80 * towards + 0.42 * up - 0.42 * across
    lit = np.clip(normals @ (light / np.linalg.norm(light)), 0.0, 1.0)
    rim = np.clip(normals @ towards, 0.0, 1.0) ** 0.6
    result: Array = (LOW + (1.04 - LOW) * lit) * (0.55 + 0.45 * rim)
    return result


def _png(sheet: Array) -> bytes:
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(np.clip(np.rint(sheet), 0, 255).astype(np.uint8), "RGBA").save(stream, format="PNG")
    return stream.getvalue()
