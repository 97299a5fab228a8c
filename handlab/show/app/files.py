"""Files that a page asked for: made in a folder of this run, fetched once by the page, then deleted."""

from __future__ import annotations

import asyncio
import secrets
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from handlab.show.session import Wish

DRAWN = ("png", "mp4", "gif")
MOST_KEPT = 8
MIME = {"png": "image/png", "mp4": "video/mp4", "gif": "image/gif", "glb": "model/gltf-binary", "html": "text/html", "csv": "text/csv"}
CAMERA = ("eye", "up", "focus")


@dataclass(frozen=True)
class Made:
    """A file on disk under the name that the user will see."""

    path: Path
    name: str
    mime: str


class Files:
    """The folder of one run. One file is made at a time: two films at once would leave no processor to the hand."""

    def __init__(self) -> None:
        self._folder: TemporaryDirectory[str] | None = None
        self._made: dict[str, Made] = {}
        self._one = asyncio.Lock()

    @property
    def folder(self) -> Path:
        """Made when first needed: a full disk must not keep the hand from starting."""
        if self._folder is None:
            self._folder = TemporaryDirectory(prefix="handlab-", ignore_cleanup_errors=True)
        return Path(self._folder.name)

    async def fulfil(self, wish: Wish) -> dict[str, Any]:
        """Make the file of a wish; the reply says from where the page fetches it.

        Raises ``DrawingFailed``, ``OSError`` or ``ValueError`` with one sentence.
        """
        async with self._one:
            word = secrets.token_urlsafe(16)
            path = self.folder / f"{word}.{wish.format}"
            try:
                await write(wish, path, self.folder)
            except BaseException:
                path.unlink(missing_ok=True)
                raise
            self._made[word] = Made(path, f"{wish.name}.{wish.format}", MIME[wish.format])
            while len(self._made) > MOST_KEPT:
                self.drop(next(iter(self._made)))
        made = self._made[word]
        return {"kind": "file", "name": made.name, "mime": made.mime, "address": f"handlab/data/file/{word}"}

    def find(self, word: str) -> Made | None:
        """A file by the word in its address."""
        return self._made.get(word)

    def drop(self, word: str) -> None:
        """Delete a file."""
        made = self._made.pop(word, None)
        if made is not None:
            made.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Delete all."""
        if self._folder is not None:
            self._folder.cleanup()


async def write(wish: Wish, path: Path, folder: Path) -> None:
    """Pictures and films in a process of their own, everything else beside the loop."""
    if wish.format in DRAWN:
        from handlab.show.app.drawing import draw

        await draw(wish.story.clip, path, arguments(wish), folder)
        return
    from handlab.show.save import save

    what = wish.story.clip if wish.story.clip is not None else wish.story.state
    given = arguments(wish) if wish.format == "html" else {}
    seen = {key: given[key] for key in ("view", "skin", "bones", "layers") if key in given}
    await asyncio.to_thread(save, what, path, hand=wish.story.hand, **seen)


def arguments(wish: Wish) -> dict[str, Any]:
    """What of a page's ``look`` may steer the drawing, as plain values; anything else is left out."""
    look = wish.look
    how: dict[str, Any] = {key: str(look[key]) for key in ("view", "skin") if isinstance(look.get(key), str)}
    how |= {key: look[key] for key in ("bones", "muscles") if isinstance(look.get(key), bool)}
    if isinstance(look.get("layers"), list | tuple):
        how["layers"] = [str(one) for one in look["layers"]][:2]
    camera = look.get("camera")
    if isinstance(camera, dict) and all(isinstance(camera.get(key), list | tuple) for key in CAMERA):
        how["camera"] = {**{key: [float(value) for value in camera[key]] for key in CAMERA}, "distance": float(camera.get("distance", 0))}
    size = look.get("size")
    if isinstance(size, list | tuple) and len(size) == 2:
        how["size"] = [max(min(int(side), 1920), 64) for side in size]
    return how
