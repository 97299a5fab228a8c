"""An impossible place or format is refused before any work is done, and long work shows its progress."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")


def checked(path: str | os.PathLike[str], formats: Iterable[str]) -> Path:
    """The path to write to, if that can work.

    Raises ``ValueError`` for a suffix that is none of ``formats``, ``OSError`` for a place that cannot be written to.
    """
    out, known = Path(path).expanduser(), tuple(formats)
    if out.suffix.lower() not in known:
        what = f"the format {out.suffix!r}" if out.suffix else "a format: the file name has no suffix"
        raise ValueError(f"cannot write {what} ({out.name!r}); the formats are {', '.join(known)}")
    folder = out.parent
    if not folder.is_dir():
        raise FileNotFoundError(f"the folder {str(folder)!r} does not exist; make it first, or choose another place for {out.name!r}")
    if out.is_dir():
        raise IsADirectoryError(f"{str(out)!r} is a folder; choose a file name")
    try:
        # Asking the file system beats reading its permission bits: a full quota or a read-only disk says no too.
        with tempfile.NamedTemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise PermissionError(f"cannot write into the folder {str(folder)!r} ({error.strerror}); choose another place") from error
    return out


def pair(size: str) -> tuple[int, int]:
    """``"800x600"`` as two numbers."""
    try:
        width, height = (int(number) for number in size.lower().replace("×", "x").split("x"))
    except ValueError:
        raise ValueError(f"size is {size!r}; write width x height in pixels, such as 800x600") from None
    return width, height


def progress(items: Iterable[T], what: str, total: int) -> Iterable[T]:
    """The items, with a bar on the terminal once it takes longer than a second."""
    from tqdm.auto import tqdm

    bar: Iterable[T] = tqdm(items, desc=what, total=total, unit="frame", delay=1.0, leave=False, mininterval=0.5, dynamic_ncols=True)
    return bar
