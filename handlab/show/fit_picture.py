"""A photograph on the fitting page: whole for fitting, smaller for the screen, small for comparing outlines; and what is drawn over it."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.records import Array, Hand, frozen
from handlab.fitting.outline import hand_mask
from handlab.fitting.pictures import Picture, load_picture
from handlab.fitting.result import Fit
from handlab.fitting.texture import project_texture

SHOWN = 2400  # pixels on the longer side of what the page shows
ENOUGH = 12  # points that tell what colour the hand has
COMPARED = 480  # on the longer side of that in which hand and background are told apart while points come
TINTED = 1600  # on the longer side of that from which the skin takes its colour
QUALITY = 86
LINE, CASING = (86, 180, 233), (16, 32, 48)


class Photo:
    """``pixels`` (rows, columns, 3) upright, ``size`` (width, height), ``name``, ``data``: the file, which knows the camera.

    Raises what ``load_picture`` raises.
    """

    def __init__(self, data: bytes | NDArray[Any], name: str) -> None:
        self.name = name
        self.data = data if isinstance(data, bytes) else b""
        self.pixels: Picture = load_picture(data)
        self.size = (self.pixels.shape[1], self.pixels.shape[0])
        self.shown: Any = self._smaller(SHOWN)
        self._small, self.step = self.reduced(COMPARED)
        self._mask: tuple[int, NDArray[np.bool_] | None] = (0, None)

    def reduced(self, longest: int) -> tuple[Picture, float]:
        """The picture with at most ``longest`` pixels on its longer side, and how many of its own pixels make one of these."""
        step = max(1.0, max(self.size) / longest)
        return (self.pixels, 1.0) if step == 1.0 else (np.asarray(self._smaller(longest)), step)

    def mask(self, points_px: Array) -> NDArray[np.bool_] | None:
        """Small pixels that show the hand; None where it cannot be told from the background. Once there are enough points, more of
        them change nothing."""
        if self._mask[0] < ENOUGH or len(points_px) < ENOUGH:
            try:
                self._mask = len(points_px), hand_mask(self._small, points_px / self.step)
            except ValueError:
                self._mask = 0, None
        return self._mask[1]

    def jpeg(self) -> bytes:
        """What the page shows."""
        return _jpeg(self.shown)

    def _smaller(self, longest: int) -> Any:
        from PIL import Image

        factor = longest / max(self.size)
        whole = self.shown if longest < SHOWN else Image.fromarray(np.asarray(self.pixels))
        if factor >= 1.0:
            return whole
        return whole.resize((max(round(self.size[0] * factor), 1), max(round(self.size[1] * factor), 1)), Image.Resampling.BOX)


def overlaid(photo: Photo, outline: Array) -> bytes:
    """The photograph with the outline (K, 2) px over it, as JPEG."""
    from PIL import ImageDraw

    picture = photo.shown.copy()
    factor = picture.size[0] / photo.size[0]
    pen, line = ImageDraw.Draw(picture), [(float(x), float(y)) for x, y in np.vstack([outline, outline[:1]]) * factor]
    width = max(2, round(max(picture.size) / 420))
    pen.line(line, fill=CASING, width=2 * width, joint="curve")
    pen.line(line, fill=LINE, width=width, joint="curve")
    return _jpeg(picture)


def in_colours(fit: Fit, photo: Photo) -> Hand:
    """The hand of a fit with its photograph on the skin; unseen skin continues what is seen.

    As it is where hand and background cannot be told apart.
    """
    fine = fit.hand.skin_fine
    pixels, step = photo.reduced(TINTED)
    height = fit.aligned.frame.height(fit.lying(fine.points))
    try:
        sheet = project_texture(fine, fit.to_picture(fine.points) / step, height, pixels, hand=hand_mask(pixels, fit.clicks / step))
    except ValueError:
        return fit.hand
    return fit.hand.with_(picture=frozen(sheet.pixels, np.uint8))


def _jpeg(picture: Any) -> bytes:
    stream = io.BytesIO()
    picture.save(stream, format="JPEG", quality=QUALITY)
    return stream.getvalue()
