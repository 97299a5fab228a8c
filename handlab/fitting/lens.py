"""How far the camera was from the table, from what it wrote into the picture."""

from __future__ import annotations

import io
import math
import os
from pathlib import Path
from typing import Any

FILM_DIAGONAL_MM = 43.27  # of 36 x 24 mm film, to which cameras refer their focal length
FOCAL_LENGTH_35MM = 0xA405  # EXIF tags
EXIF_PART = 0x8769
NEAREST_MM, FARTHEST_MM = 150.0, 5000.0


def camera_distance_mm(picture: Any, mm_per_px: float, size: tuple[int, int]) -> float | None:
    """Distance in mm from a picture's EXIF focal length (file or bytes) and its scale on the table; None where it does not say so.

    A lens of focal length f (in pixels) shows ``mm_per_px`` at the distance f * mm_per_px. Of a cropped picture it comes out too short.
    """
    if not isinstance(picture, str | os.PathLike | bytes):
        return None
    from PIL import Image

    try:
        data = picture if isinstance(picture, bytes) else Path(picture).read_bytes()
        with Image.open(io.BytesIO(data)) as opened:
            focal = float(opened.getexif().get_ifd(EXIF_PART).get(FOCAL_LENGTH_35MM, 0))
    except (OSError, ValueError, TypeError, SyntaxError, ZeroDivisionError, Image.DecompressionBombError):
        return None
    distance = focal / FILM_DIAGONAL_MM * math.hypot(*size) * mm_per_px
    return distance if NEAREST_MM <= distance <= FARTHEST_MM else None
