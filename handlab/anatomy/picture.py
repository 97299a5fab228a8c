"""The colours of a hand's skin as a PNG file beside its meshes. Pictures are data here; nothing is drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.meshes import frozen

PICTURE = "skin.png"  # in a hand's folder, if the hand has colours of its own


def write_picture(path: Path, picture: NDArray[np.uint8]) -> None:
    """Write pixels (rows, columns, 3)."""
    from PIL import Image

    Image.fromarray(picture).save(path, optimize=True)


def read_picture(path: Path) -> NDArray[np.uint8]:
    """Pixels (rows, columns, 3) of a PNG file. Raises ``ValueError`` for a broken one."""
    from PIL import Image

    try:
        with Image.open(path, formats=("PNG",)) as picture:
            pixels: NDArray[np.uint8] = frozen(picture.convert("RGB"), np.uint8)
            return pixels
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise ValueError(f"{path} is no picture: {error}; remove it, and the skin has the colours of the reference hand") from error
