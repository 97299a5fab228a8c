"""Photographs as people have them: JPEG, PNG, HEIC and a few more, turned upright, checked before they are unpacked."""

from __future__ import annotations

import io
import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.fitting.heic import is_heic, readable

Picture = NDArray[np.uint8]  # (rows, columns, 3), red, green, blue
FORMATS = ("JPEG", "PNG", "WEBP", "TIFF", "BMP")  # JPEG with several pictures in it (MPO) counts as JPEG
KNOWN = "JPEG, PNG, HEIC, WebP, TIFF and BMP"
MOST_PIXELS = 64_000_000  # a little more than the 50 megapixels of large phone cameras; three bytes each
LEAST_SIDE = 64  # pixels; a hand needs a few hundred
LONGEST_SIDE = 30_000


def load_picture(source: str | os.PathLike[str] | bytes | NDArray[Any]) -> Picture:
    """A photograph as pixels (rows, columns, 3), turned upright as its EXIF data say.

    ``source``: a path, the bytes of a file (from an upload), or pixels as an array (rows, columns[, 3 or 4]). Transparent parts
    become white, grey and 16-bit pictures are converted. The size is read before anything is unpacked.
    Raises ``FileNotFoundError``, ``IsADirectoryError``, or ``ValueError`` in one sentence for a file that is empty, no picture, cut
    off, larger than 64 megapixels, smaller than 64 pixels, or HEIC without the library that reads it.
    """
    if isinstance(source, np.ndarray):
        return _from_array(source)
    data, name = (source, "the picture") if isinstance(source, bytes) else _read(Path(source))
    if not data:
        raise ValueError(f"{name} is empty (0 bytes); copy it from the camera again")
    return _checked(_decoded(data, name), name)


def _read(path: Path) -> tuple[bytes, str]:
    if path.is_dir():
        raise IsADirectoryError(f"{path} is a folder; give the picture in it")
    if not path.is_file():
        raise FileNotFoundError(f"there is no picture {path}; check the name and the folder")
    return path.read_bytes(), path.name


def _decoded(data: bytes, name: str) -> Picture:
    from PIL import Image, ImageFile, ImageOps, UnidentifiedImageError

    Image.init()  # else the rarer formats are unknown until the first failure
    formats = list(FORMATS)
    if is_heic(data):
        if not readable(data):
            raise _RefusedError(
                f'{name} is a HEIC picture; reading it needs one more package: pip install "handlab[photo]" (or let the phone save JPEG)'
            )
        formats.append("HEIF")
    strict, ImageFile.LOAD_TRUNCATED_IMAGES = ImageFile.LOAD_TRUNCATED_IMAGES, False  # another package may have allowed half pictures
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # damaged EXIF data and large sizes warn; both are dealt with here
            with Image.open(io.BytesIO(data), formats=formats) as picture:
                _check_size(picture.size, name)
                picture.load()
                upright: Any = _upright(ImageOps, picture)
                return np.asarray(_in_colour(Image, upright))
    except UnidentifiedImageError as error:
        if is_heic(data):
            raise ValueError(f"{name} is damaged or cut off; copy it from the telephone again") from error
        raise ValueError(f"{name} is not a picture that can be read ({KNOWN} can); open it in a viewer and save it as JPEG") from error
    except Image.DecompressionBombError as error:
        raise ValueError(_too_large(name, "far too many")) from error
    except (OSError, SyntaxError, ValueError, EOFError, IndexError, TypeError, OverflowError, RuntimeError) as error:
        if isinstance(error, _RefusedError):
            raise
        raise ValueError(f"{name} is damaged or cut off ({error}); copy it from the camera again") from error
    finally:
        ImageFile.LOAD_TRUNCATED_IMAGES = strict


class _RefusedError(ValueError):
    """A picture that could be read but must not be."""


def _check_size(size: tuple[int, int], name: str) -> None:
    width, height = size
    if width * height > MOST_PIXELS or max(size) > LONGEST_SIDE:
        raise _RefusedError(_too_large(name, f"{width} x {height} ="))
    if min(size) < LEAST_SIDE:
        raise _RefusedError(f"{name} has {width} x {height} pixels; a hand needs a few hundred on each side")


def _too_large(name: str, size: str) -> str:
    return f"{name} claims {size} pixels; up to {MOST_PIXELS // 1_000_000} million can be read: make it smaller in a picture editor"


def _upright(operations: Any, picture: Any) -> Any:
    """Turned as EXIF says; EXIF data that cannot be read say nothing."""
    try:
        return operations.exif_transpose(picture)
    except (ValueError, TypeError, KeyError, SyntaxError, OSError, ZeroDivisionError):
        return picture


def _in_colour(image: Any, picture: Any) -> Any:
    """Red, green, blue, 8 bits; transparency on white, 16-bit grey scaled to 8."""
    if picture.mode.startswith(("I", "F")):
        grey = np.asarray(picture, np.float64)
        top = 255.0 / 65535.0 if grey.max() > 255 else 1.0
        return image.fromarray(np.clip(grey * top, 0, 255).astype(np.uint8)).convert("RGB")
    if picture.mode in ("RGBA", "LA", "PA") or "transparency" in picture.info:
        clear = picture.convert("RGBA")
        return image.alpha_composite(image.new("RGBA", clear.size, (255, 255, 255, 255)), clear).convert("RGB")
    return picture.convert("RGB")


def _from_array(pixels: NDArray[Any]) -> Picture:
    if pixels.ndim not in (2, 3) or (pixels.ndim == 3 and pixels.shape[2] not in (3, 4)):
        raise ValueError(f"an array of shape {pixels.shape} is no picture; it must be (rows, columns) or (rows, columns, 3 or 4)")
    if pixels.dtype != np.uint8:
        raise ValueError(f"the pixels are {pixels.dtype}; they must be uint8, 0 to 255")
    _check_size((pixels.shape[1], pixels.shape[0]), "the picture")
    if pixels.ndim == 2:
        pixels = np.repeat(pixels[:, :, None], 3, axis=2)
    return _checked(pixels[:, :, :3], "the picture")


def _checked(pixels: Picture, name: str) -> Picture:
    if pixels.ndim != 3 or pixels.shape[2] != 3:
        raise ValueError(f"{name} could not be turned into red, green and blue; save it as JPEG")
    result = np.ascontiguousarray(pixels)
    result = result.copy() if result is pixels and result.flags.writeable else result
    result.setflags(write=False)
    return result
