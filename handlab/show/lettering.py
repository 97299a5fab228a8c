"""Words on pictures, with the typeface that comes with matplotlib (found without importing it)."""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any


@cache
def face(size: int, *, bold: bool = False) -> Any:
    """A Pillow font of ``size`` pixels."""
    from PIL import ImageFont

    spec = find_spec("matplotlib")
    for folder in (spec.submodule_search_locations or []) if spec else []:
        path = Path(folder) / "mpl-data" / "fonts" / "ttf" / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")
        if path.is_file():
            return ImageFont.truetype(str(path), size)
    return ImageFont.load_default(size)


def write(draw: Any, where: tuple[float, float], text: str, size: float, *, colour: str, bold: bool = False, anchor: str = "ls") -> float:
    """Write ``text`` with its ``anchor`` (Pillow's: l/m/r, then a/m/s) at ``where``; its width in pixels."""
    font = face(max(6, round(size)), bold=bold)
    draw.text(where, text, font=font, fill=colour, anchor=anchor)
    return float(draw.textlength(text, font=font))


def fit(draw: Any, text: str, size: float, width: float, *, bold: bool = False) -> float:
    """The largest size up to ``size`` at which ``text`` is at most ``width`` pixels wide."""
    wide = float(draw.textlength(text, font=face(max(6, round(size)), bold=bold)))
    return size if wide <= width else float(int(size * width / wide))
