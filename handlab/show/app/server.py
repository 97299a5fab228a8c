"""The server: trame with one page, one socket and a few addresses for data, all behind the guard."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from handlab.show.app.files import Files
from handlab.show.app.guard import EVERYWHERE, Guard, warning
from handlab.show.app.own_hand import OwnHands
from handlab.show.app.paint_page import PaintRooms
from handlab.show.app.place import PORT, free_port, open_page, shown_host

STATIC = Path(__file__).parent.parent / "static"
# trame reads the process's command line, which is not meant for it, unless this is set. Frames are a few kilobytes of
# numbers that hardly shrink: compressing them would cost more time than sending them.
TRAME_ARGUMENTS = "--no-ws-compress"
Say = Callable[[str], None]


class App:
    """One hand, one server. ``load`` makes the session; it runs beside the start of the server, so that the page comes at once."""

    def __init__(
        self, load: Callable[[], Any], *, host: str = "127.0.0.1", port: int = PORT, key: str | None = None, say: Say = print
    ) -> None:
        self.host, self.port, self.say = host, port, say
        self.guard = Guard(host, key)
        self.files = Files()
        self.own_hands = OwnHands(self)
        self.paint_rooms = PaintRooms(self)
        self.opens = ""  # what the address says beside the key
        self.live: Any = None
        self.load = load
        self._ready: asyncio.Future[Any] | None = None
        self._server: Any = None
        self._stop: asyncio.Event | None = None

    @property
    def address(self) -> str:
        """The address of the page, with its key."""
        return f"http://{shown_host(self.host)}:{self.port}/index.html?secret={self.guard.key}{self.opens}"

    @property
    def ticket_address(self) -> str:
        """An address that opens the page once, within a minute."""
        return f"http://{shown_host(self.host)}:{self.port}/?ticket={self.guard.ticket()}"

    async def run(self, *, opened: Callable[[App], None] | None = None) -> None:
        """Serve until ``stop`` is called or the process is asked to end. ``opened`` is called when the page can be opened."""
        loop = asyncio.get_running_loop()
        self._stop = asyncio.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            with suppress(NotImplementedError, RuntimeError, ValueError):  # Windows, or not the main thread: Ctrl-C arrives as an exception
                loop.add_signal_handler(number, self._stop.set)
        self._ready = loop.create_task(asyncio.to_thread(self.load))
        self._server = self._made()
        serving = loop.create_task(self._serve())
        stopping = loop.create_task(self._stop.wait())
        playing = loop.create_task(self._play())
        tasks: list[Any] = [serving, stopping, playing]
        try:
            await self._started(serving)
            if opened is not None:
                opened(self)
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in (serving, playing):
                if task.done():
                    task.result()  # raises what ended it
        finally:
            with suppress(Exception):
                await asyncio.wait_for(self.live.frames.close(), 1.0)
            with suppress(Exception):
                await asyncio.wait_for(self._server.stop(), 3.0)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self.files.close()

    def stop(self) -> None:
        """End ``run``."""
        if self._stop is not None:
            self._stop.set()

    async def session(self) -> Any:
        """The session, as soon as the hand is loaded."""
        assert self._ready is not None
        return await asyncio.shield(self._ready)

    async def change(self, session: Any) -> None:
        """Another hand in all pages."""
        self._ready = asyncio.get_running_loop().create_future()
        self._ready.set_result(session)
        self.live.change(session)

    async def _play(self) -> None:
        session = await self.session()
        await self.live.play(session)

    async def _started(self, serving: asyncio.Task[Any]) -> None:
        ready = asyncio.ensure_future(self._server.ready)
        await asyncio.wait([ready, serving], return_when=asyncio.FIRST_COMPLETED)
        if serving.done():
            ready.cancel()
            serving.result()

    async def _serve(self) -> None:
        await self._server.start(
            host=self.host, port=self.port, exec_mode="coroutine", backend="aiohttp", timeout=0,
            thread=True, open_browser=False, show_connection_info=False,
        )  # fmt: skip

    def _made(self) -> Any:
        os.environ["TRAME_ARGS"] = TRAME_ARGUMENTS
        from trame.app import get_server
        from trame_client.ui.html import DivLayout

        from handlab.show.app.live import Live
        from handlab.show.app.routes import TITLE

        server = get_server(f"handlab-{id(self)}", client_type="vue3")
        server.enable_module({"module_scripts": ["handlab/static/app.js"]})
        server.state.trame__title = TITLE
        server.state.trame__favicon = "handlab/icon.svg"
        self.live = Live(self.guard, self.say, self.files.fulfil)
        server.add_protocol_to_configure(lambda protocol: protocol.registerLinkProtocol(self.live))
        server.controller.on_server_bind.add(self._bind)
        DivLayout(server)  # empty: the viewer stands beside what trame manages, which it replaces when a connection ends
        return server

    def _bind(self, web: Any) -> None:
        from aiohttp.web import Request, StreamResponse, middleware

        from handlab.show.app.routes import routes

        @middleware
        async def guarded(request: Request, handler: Any) -> StreamResponse:
            return await self.guard.answer(request, handler)

        self.live.web = web
        self._server.protocol.updateSecret(self.guard.key)
        self._server.protocol.stopServer = lambda: None  # pages come and go; no page ends the server for all others
        web.app.middlewares.append(guarded)
        web.app.add_routes(routes(self))


def start(load: Callable[[], Any], *, host: str, port: int, browser: bool, say: Say = print, picture: Path | None = None) -> None:
    """Find a place, say where it is, open it in a browser, and serve until Ctrl-C.

    ``picture``: a photograph; the page opens where it becomes a hand. Raises ``OSError`` where no port can be had, and what
    ``load_picture`` raises.
    """
    warn = warning(host)
    got = free_port(host, port)
    if got != port and port:
        say(f"Port {port} is taken; using {got}.")
    if warn:
        print(f"handlab: {warn}", file=sys.stderr)  # noqa: T201 (goes with the address that the command prints)

    def opened(app: App) -> None:
        say(f"The hand moves at  {app.address}")
        if host in EVERYWHERE:
            say("From another computer, write this computer's name in place of 127.0.0.1.")
        say("Ctrl-C stops it.")
        trouble = open_page(app.ticket_address) if browser else None
        if trouble:
            say(f"({trouble.replace('PORT', str(app.port))})")

    app = App(load, host=host, port=got, say=lambda text: print(f"handlab: {text}", file=sys.stderr))  # noqa: T201
    if picture is not None:
        app.opens = f"&fit={app.own_hands.give(picture)}"
    with suppress(KeyboardInterrupt):
        asyncio.run(app.run(opened=opened))
    say("Stopped.")
