"""How far the camera was from the table: as the picture's file tells, or as most people hold a telephone."""

from __future__ import annotations

import io
import math
import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

FILM_DIAGONAL_MM = 43.27  # of 36 x 24 mm film, to which "focal length in 35 mm film" refers (EXIF 2.3, CIPA DC-008)
EXIF_PART, FOCAL_35, FOCAL, WIDTH, HEIGHT = 0x8769, 0xA405, 0x920A, 0xA002, 0xA003  # EXIF tags
SENSOR_DOTS, SENSOR_UNIT = 0xA20E, 0xA210  # pixels on the sensor per unit: 2 inch, 3 centimetre
UNIT_MM = {2.0: 25.4, 3.0: 10.0, 4.0: 1.0, 5.0: 0.001}
CROPPED = 0.02  # a picture whose sides differ by more from those in its EXIF data was cut: its focal length says nothing
NEAREST_MM, FARTHEST_MM = 150.0, 5000.0
# A whole hand and a ruler fill the picture of a telephone from about this distance (an assumption).
ASSUMED_MM = 600.0
# A file's dots per inch that agree so well with a ruler or coin in the picture are those of a scanner: cameras write 72 or 96.
SAME_SCALE = 0.03


class Camera(NamedTuple):
    """``distance_mm`` from the table; None: a scanner, which sees without perspective. ``how`` it is known."""

    distance_mm: float | None
    how: str


def camera(picture: Any, mm_per_px: float, size: tuple[int, int]) -> Camera:
    """From where ``picture`` (a file, its bytes, or anything else, which tells nothing) of ``size`` (width, height) was taken.

    ``mm_per_px``: its scale on the table. The focal length in the file tells the distance; dots per inch that agree with the scale tell a
    scanner; of all other pictures it is assumed that a camera ``ASSUMED_MM`` away took them.
    """
    told = camera_distance_mm(picture, mm_per_px, size)
    if told is not None:
        return Camera(told, "focal length in the file")
    if scan_mm_per_px(picture, mm_per_px) is not None:
        return Camera(None, "a scanner, as its dots per inch tell")
    return Camera(ASSUMED_MM, "assumed")


def camera_distance_mm(picture: Any, mm_per_px: float, size: tuple[int, int] | None = None) -> float | None:
    """Distance in mm from a picture's focal length (file or bytes) and its scale on the table; None where the file does not say so.

    A lens of focal length f (in pixels) shows ``mm_per_px`` at the distance f * mm_per_px. ``size`` (width, height): of the picture, the
    file's own if not given. Telephones write whole millimetres: good to some 3 %. None for pictures that were cut after they were taken.
    """
    found, tags, _ = _notes(picture)
    size = size or found
    part = {**tags, **tags.get(EXIF_PART, {})}
    noted = _number(part, WIDTH) or size[0], _number(part, HEIGHT) or size[1]
    if min(size) < 1 or abs(min(noted) / max(noted) * max(size) / min(size) - 1.0) > CROPPED:
        return None
    focal_px = _number(part, FOCAL_35) / FILM_DIAGONAL_MM * math.hypot(*size)
    if not focal_px:  # cameras with large sensors write the size of their pixels instead
        dots = _number(part, SENSOR_DOTS) / UNIT_MM.get(_number(part, SENSOR_UNIT) or 2.0, 25.4)
        focal_px = _number(part, FOCAL) * dots * max(size) / max(noted)
    distance = focal_px * mm_per_px
    return distance if NEAREST_MM <= distance <= FARTHEST_MM else None


def scan_mm_per_px(picture: Any, mm_per_px: float) -> float | None:
    """Millimetres per pixel by the dots per inch in a file (or its bytes); None without, or where a ruler says otherwise."""
    dots = _notes(picture)[2]
    if min(dots) <= 0.0 or abs(dots[0] / dots[1] - 1.0) > 1e-3:
        return None
    return 25.4 / dots[0] if abs(math.log(25.4 / dots[0] / mm_per_px)) < SAME_SCALE else None


def _notes(picture: Any) -> tuple[tuple[int, int], dict[int, Any], tuple[float, float]]:
    """Size, EXIF tags (those of the part for the camera under ``EXIF_PART``) and dots per inch of a file; zeros where it says nothing."""
    nothing: tuple[tuple[int, int], dict[int, Any], tuple[float, float]] = (0, 0), {}, (0.0, 0.0)
    if not isinstance(picture, str | os.PathLike | bytes):
        return nothing
    from PIL import Image

    from handlab.fitting.heic import readable

    try:
        data = picture if isinstance(picture, bytes) else Path(picture).read_bytes()
        readable(data)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data)) as opened:
                exif = opened.getexif()
                dots = opened.info.get("dpi", (0.0, 0.0))
                return opened.size, {**exif, EXIF_PART: dict(exif.get_ifd(EXIF_PART))}, (float(dots[0]), float(dots[1]))
    except (OSError, ValueError, TypeError, KeyError, IndexError, SyntaxError, ZeroDivisionError, Image.DecompressionBombError):
        return nothing


def _number(tags: Mapping[int, Any], tag: int) -> float:
    """The value of a tag, 0 where there is none that can be used."""
    try:
        value = float(tags.get(tag, 0.0))
    except (TypeError, ValueError, ZeroDivisionError):
        return 0.0
    return value if math.isfinite(value) and value > 0.0 else 0.0
