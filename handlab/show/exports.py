"""The slow half of a session: a wish becomes a file. Films are drawn in a process of their own, so any thread may call this."""

from __future__ import annotations

import asyncio
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from handlab.show.session import Wish


def fulfilled(wish: Wish) -> dict[str, Any]:
    """The reply to a wish: a ``file`` with its bytes under ``data``, or an ``answer`` that says why there is none."""
    from handlab.show.app.files import MIME, write

    try:
        with TemporaryDirectory(prefix="handlab-") as place:
            folder = Path(place)
            path = folder / f"{wish.name}.{wish.format}"
            asyncio.run(write(wish, path, folder))
            return {"kind": "file", "name": path.name, "mime": MIME[wish.format], "data": path.read_bytes()}
    except Exception as error:  # a full disk, a crashed driver: the hand lives on
        sentence = " ".join(str(error).split()) or type(error).__name__
        return {"kind": "answer", "good": False, "text": f"no .{wish.format}: {sentence}"}
