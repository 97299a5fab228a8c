"""Frames on a socket of their own, no faster than each page can draw.

The socket of wslink carries messages; its client takes every one of them through the browser's main process, twice, which costs more
than all arithmetic of a picture.

Every page has a credit. A frame costs one, and the page gives it back (any short message) when it has drawn. A page without credit (a
tab in the background, a slow line) misses frames and gets the newest one when it is back: nothing ever queues up.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aiohttp.web import Request, WebSocketResponse

CREDIT = 2  # frames on their way to a page at once: one travels while the other is drawn
HEARTBEAT = 30.0  # s: a page that does not answer is gone
LONGEST_MESSAGE = 64  # bytes that a page may send at once


class Frames:
    """The pages that look. ``asked`` is called when one has come or can take a frame again after none could."""

    def __init__(self, asked: Callable[[bool], None]) -> None:
        self._asked = asked
        self._credit: dict[WebSocketResponse, int] = {}
        self._behind: set[WebSocketResponse] = set()
        self._last: bytes | None = None
        self._sending: set[asyncio.Task[None]] = set()

    async def page(self, request: Request) -> WebSocketResponse:
        """A page looks, until it leaves."""
        from aiohttp import web

        socket = web.WebSocketResponse(heartbeat=HEARTBEAT, compress=False, max_msg_size=LONGEST_MESSAGE)
        await socket.prepare(request)
        try:
            self._credit[socket] = CREDIT
            self._asked(True)
            async for _ in socket:
                self._drawn(socket)
        finally:
            self._credit.pop(socket, None)
            self._behind.discard(socket)
        return socket

    @property
    def watched(self) -> bool:
        """Whether any page looks."""
        return bool(self._credit)

    @property
    def wanted(self) -> bool:
        """Whether any page can take a frame now."""
        return any(self._credit.values())

    def send(self, frame: bytes) -> None:
        """The newest frame, to all who can take it."""
        self._last = frame
        for socket, credit in self._credit.items():
            if credit > 0:
                self._send_to(socket, frame)
            else:
                self._behind.add(socket)

    async def close(self) -> None:
        """No more frames: pages that want those of another hand come anew."""
        sockets, self._last = list(self._credit), None
        self._credit.clear()
        self._behind.clear()
        for socket in sockets:
            with suppress(ConnectionError):
                await socket.close()

    def _drawn(self, socket: WebSocketResponse) -> None:
        if socket not in self._credit:
            return  # it is being closed
        starved = not self.wanted
        self._credit[socket] = min(self._credit[socket] + 1, CREDIT)
        if starved:
            self._asked(False)
        if socket in self._behind and self._last is not None:
            self._send_to(socket, self._last)

    def _send_to(self, socket: WebSocketResponse, frame: bytes) -> None:
        self._credit[socket] -= 1
        self._behind.discard(socket)
        task = asyncio.get_running_loop().create_task(self._write(socket, frame))
        self._sending.add(task)
        task.add_done_callback(self._sending.discard)

    async def _write(self, socket: WebSocketResponse, frame: bytes) -> None:
        with suppress(ConnectionError):  # it has just left
            await socket.send_bytes(frame)
