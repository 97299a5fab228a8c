"""Files that are whole or not there: written beside their place, then moved into it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside ``path``, with its suffix; it takes the place of ``path`` when the block ends well.

    When the block fails, or the place cannot be written, nothing is left behind and an older file stays as it was.
    """
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(f"cannot write {path}: it is a folder; give a file name")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"cannot write {path}: the folder {path.parent} does not exist; create it first")
    part = path.with_name(f".{path.stem}-{uuid4().hex[:8]}{path.suffix}")
    try:
        try:
            part.touch(exist_ok=False)
        except OSError as error:
            raise type(error)(f"cannot write {path}: {error.strerror}; choose a folder that you may write to") from error
        yield part
        try:
            part.replace(path)
        except OSError as error:
            raise type(error)(f"cannot write {path}: {error.strerror}; close programs that hold it open, or choose another name") from error
    finally:
        part.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file (UTF-8, the line ends of ``text``), whole or not at all."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8", newline="")
