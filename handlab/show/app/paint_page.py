"""The page "Paint a muscle" of the app: each tab paints on the hand that is live, and what it uses moves there, for all who look."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from typing import TYPE_CHECKING

from handlab.show.app.own_hand import MOST_ROOMS, said, word_of

if TYPE_CHECKING:
    from aiohttp.web import Request, Response

    from handlab.anatomy.grids import MuscleGrid
    from handlab.anatomy.records import Hand
    from handlab.show.app.server import App
    from handlab.show.paint_room import PaintRoom
    from handlab.show.session import Session

FIRST = ("my_muscle", "flexor_pollicis_brevis")  # what a new room calls its muscle, and what drives it


class PaintRooms:
    """The rooms of all tabs. The page sends everything with each message: one that was closed, because there are too many, opens again."""

    def __init__(self, app: App) -> None:
        self.app = app
        self._rooms: OrderedDict[str, PaintRoom] = OrderedDict()

    def room(self, word: str, hand: Hand, *, fresh: bool) -> PaintRoom:
        """The room of a tab; a ``fresh`` page gets one for the ``hand`` that is live now."""
        from handlab.show.paint_room import PaintRoom
        from handlab.show.painting import Painting, Settings

        if fresh or word not in self._rooms:
            self._rooms[word] = PaintRoom(Painting(hand, Settings(*FIRST)), use=self._use)
            while len(self._rooms) > MOST_ROOMS:
                self._rooms.popitem(last=False)
        self._rooms.move_to_end(word)
        return self._rooms[word]

    async def ask(self, request: Request) -> Response:
        """A message of a page, as JSON."""
        from aiohttp import web

        word, message = word_of(request), await said(request)
        self._loop = asyncio.get_running_loop()
        hand = (await self.app.session()).hand
        fresh = isinstance(message, dict) and message.get("kind") == "hello"
        try:
            room = await asyncio.to_thread(self.room, word, hand, fresh=fresh)
        except ValueError as error:  # a skin that is open
            return web.json_response({"good": False, "text": f"This hand cannot be painted on: {error}."})
        return web.json_response(await asyncio.to_thread(room.ask, message))

    def _use(self, grid: MuscleGrid) -> str:
        """The muscle goes to the live hand, in all pages. Runs beside the loop, which must not wait for what is computed anew."""
        from handlab.show.flesh import packed_layers
        from handlab.simulation.painted import with_painted

        async def live() -> Session:
            session: Session = await self.app.session()
            return session

        async def adopt(before: Hand, after: Hand) -> bool:
            session = await live()
            if session.hand is before:
                self.app.live.paint(after, grid)
            return session.hand is after

        done = False
        while not done:  # unless another page was faster
            before = asyncio.run_coroutine_threadsafe(live(), self._loop).result().hand
            after = with_painted(before, grid)
            packed_layers(after)
            done = asyncio.run_coroutine_threadsafe(adopt(before, after), self._loop).result()
        return "the live hand has the muscle"
