"""The page "Your own hand" of the app: each tab has a room of its own, a word that only it knows, and nothing is written to disk."""

from __future__ import annotations

import asyncio
import json
import re
from collections import OrderedDict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from handlab.show.outfits import SOFT

if TYPE_CHECKING:
    from aiohttp.web import Request, Response

    from handlab.fitting.result import Fit
    from handlab.show.app.server import App
    from handlab.show.fit_room import FitRoom

MOST_ROOMS = 4  # photographs in memory at once: 50 megapixels are 150 MB
MOST_BYTES = 120_000_000  # of a photograph
MOST_WORDS = 4_000_000  # bytes of a message: clicks are a few kilobytes, a file of points is at most a megabyte
WORD = re.compile(r"[A-Za-z0-9_-]{8,64}")
GIVEN = "given-on-the-command-line"


class OwnHands:
    """The rooms of all tabs. The oldest is closed when there are too many; its page sends its picture again when it comes back."""

    def __init__(self, app: App) -> None:
        self.app = app
        self._rooms: OrderedDict[str, FitRoom] = OrderedDict()

    def room(self, word: str) -> FitRoom:
        """The room of a tab, opened when it is first asked for."""
        from handlab.show.fit_room import FitRoom

        if word not in self._rooms:
            self._rooms[word] = FitRoom(move=self._move)
            others = [name for name in self._rooms if name not in (word, GIVEN)]
            for name in others[: max(len(others) - MOST_ROOMS + 1, 0)]:
                del self._rooms[name]
        self._rooms.move_to_end(word)
        return self._rooms[word]

    def give(self, picture: Path) -> str:
        """A room with a picture in it, for the page that the command opens. Raises what ``load_picture`` raises."""
        from handlab.fitting.pictures import load_picture

        load_picture(picture)  # says what is wrong by the file's own name
        self.room(GIVEN).open(picture.read_bytes(), picture.name)
        return GIVEN

    async def ask(self, request: Request) -> Response:
        """A message of a page, as JSON; or a photograph, as it is, with its name in the address."""
        from aiohttp import web

        word = word_of(request)
        if request.content_type == "application/octet-stream":
            message, data = {"kind": "picture", "name": request.query.get("name", "")}, await received(request, MOST_BYTES)
        else:
            message, data = await said(request), None
        if isinstance(message, dict) and message.get("kind") == "reference":
            await self.app.change(await asyncio.to_thread(self.app.load))
            reply = {"good": True}
        else:
            self._loop = asyncio.get_running_loop()
            reply = await asyncio.to_thread(self.room(word).ask, message, data)
        return web.json_response(reply)

    def _move(self, fit: Fit) -> str:
        """The hand of a fit goes live in all pages. Runs beside the loop."""
        from handlab.show.session import Session

        session = Session(fit.hand, wear=SOFT)
        session.scene()  # what takes time is kept with the hand
        asyncio.run_coroutine_threadsafe(self.app.change(session), self._loop).result()
        return "the hand is live"


def word_of(request: Request) -> str:
    """The word of a tab in the address."""
    from aiohttp import web

    word = request.match_info["word"]
    if not WORD.fullmatch(word):
        raise web.HTTPNotFound
    return word


async def said(request: Request) -> Any:
    """A message as JSON."""
    from aiohttp import web

    try:
        return json.loads(await received(request, MOST_WORDS))
    except (ValueError, RecursionError):
        raise web.HTTPBadRequest(text="handlab: this is no message.\n") from None


async def received(request: Request, most: int) -> bytes:
    """The body of a request; refused as soon as it is larger than ``most`` bytes."""
    from aiohttp import web

    refusal = web.HTTPRequestEntityTooLarge(most, request.content_length or 0, text=f"handlab: up to {most // 1_000_000} MB can be read.\n")
    if (request.content_length or 0) > most:
        raise refusal
    body = bytearray()
    async for part in request.content.iter_chunked(1 << 18):
        body += part
        if len(body) > most:
            raise refusal
    return bytes(body)
