"""Between the browser and the session: messages in, frames out (``frames``), no faster than the pages can draw."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

from wslink import register
from wslink.websocket import LinkProtocol

from handlab.show.app.frames import Frames
from handlab.show.outfits import BLEND

if TYPE_CHECKING:
    from handlab.anatomy.grids import MuscleGrid
    from handlab.anatomy.records import Hand
    from handlab.show.app.guard import Guard
    from handlab.show.session import Session, Wish

RATE = 60.0  # frames per second at most
SHORTEST = 0.004  # s between two steps, however many messages come
PATIENCE = 0.08  # s between two steps while every page still draws: less than the longest step of a session
PRIVATE = ("answer", "file")  # replies for the page that asked; all others are for every page

PREPARE_AFTER = 0.5  # s: the page draws the hand first
SLOW = 5.0  # s: when preparing takes longer, everything is compiled, and the pages are told
SOON = "The soft skin is getting ready: half a minute, once on this computer. Until then the skin follows the bones alone."

F = TypeVar("F", bound=Callable[..., Any])
called: Callable[[str], Callable[[F], F]] = register  # a page calls the method by this name
Fulfil = Callable[["Wish"], Coroutine[Any, Any, dict[str, Any]]]


class Live(LinkProtocol):  # type: ignore[misc, unused-ignore]
    """The calls that a page makes, and the loop that plays."""

    def __init__(self, guard: Guard, complain: Callable[[str], None], fulfil: Fulfil) -> None:
        super().__init__()
        self.guard = guard
        self.session: Session | None = None
        self.web: Any = None  # wslink's server, once it is there
        self._complain = complain
        self._fulfil = fulfil
        self.frames = Frames(self._looked)
        self._wake = asyncio.Event()
        self._work: set[asyncio.Task[None]] = set()
        self._preparing = False

    async def validateToken(self, token: object, client_id: str) -> bool:
        """Whether a page knows the key."""
        return self.guard.knows(token)

    def _looked(self, fresh: bool) -> None:
        """A page can take a frame; with ``fresh`` it has just come and wants the first."""
        if fresh and self.session is not None:
            self.session.refresh()
            self._dress()
        self._wake.set()

    @called("handlab.message")
    def receive(self, message: Any = None) -> None:
        """A message of a page goes to the session; what it answers comes back."""
        if self.session is None:
            return  # nobody has seen the hand yet
        page = self.web.last_active_client_id
        try:
            self.session.message(message)
        except Exception as error:  # a bug must not end the hand of a whole class
            self._complain(f"the message {str(message)[:80]!r} failed: {type(error).__name__}: {error}")
            self.tell({"kind": "answer", "good": False, "text": f"that did not work: {error}"}, page)
        self._pass_on(page)
        self._dress()
        for wish in self.session.wishes():
            self._start(self._grant(wish, page))
        self._wake.set()

    def change(self, session: Session) -> None:
        """Another hand: every page fetches it anew."""
        self.session, self._preparing = session, False
        self.tell({"kind": "hand"})
        self._start(self.frames.close())

    def paint(self, hand: Hand, grid: MuscleGrid) -> None:
        """The hand goes on with a painted muscle, in every page."""
        assert self.session is not None
        self.session.paint(hand, grid)
        self._pass_on()
        self._dress()
        self._wake.set()

    def tell(self, reply: dict[str, Any], page: str | None = None) -> None:
        """A reply to one page, or to all."""
        self.publish("handlab.note", reply, client_id=page)

    def _pass_on(self, page: str | None = None) -> None:
        assert self.session is not None
        for reply in self.session.replies():
            self.tell(reply, page if reply.get("kind") in PRIVATE else None)

    def _dress(self) -> None:
        """Make the soft skin ready beside the loop, once it is wanted and someone looks."""
        assert self.session is not None
        wardrobe = self.session.wardrobe
        if wardrobe.wear != BLEND and wardrobe.network is None and not self._preparing:
            self._preparing = True
            self._start(self._prepare(self.session))

    async def _prepare(self, session: Session) -> None:
        await asyncio.sleep(PREPARE_AFTER)
        telling = asyncio.get_running_loop().call_later(SLOW, self.tell, {"kind": "answer", "good": True, "text": SOON})
        try:
            await asyncio.to_thread(session.prepare)
        except Exception as error:  # the blended skin lives on
            self._complain(f"no soft skin: {type(error).__name__}: {error}")
            self.tell({"kind": "answer", "good": False, "text": f"no soft skin: {error}"})
            return
        finally:
            telling.cancel()
        session.ready()
        self._preparing = False
        self._dress()  # muscles were painted meanwhile
        self._pass_on()
        self._wake.set()

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._work.add(task)
        task.add_done_callback(self._work.discard)

    async def _grant(self, wish: Wish, page: str) -> None:
        try:
            reply = await self._fulfil(wish)
        except Exception as error:  # whatever a full disk or a driver comes up with, the hand lives on
            sentence = " ".join(str(error).split()) or type(error).__name__
            reply = {"kind": "answer", "good": False, "text": f"no .{wish.format}: {sentence}"}
        self.tell(reply, page)

    def _tick(self, dt: float) -> bytes | None:
        if self.session is None or not self.frames.watched:
            return None
        try:
            frame = self.session.tick(dt)
            self._pass_on()
        except Exception as error:
            self._complain(f"a step failed: {type(error).__name__}: {error}")
            self.tell({"kind": "answer", "good": False, "text": f"the motion stopped ({error}); press reset"})
            return None
        return frame

    async def play(self, session: Session) -> None:
        """Ask the session for frames while something moves and someone looks; otherwise sleep until a message comes."""
        self.session = session
        if self.frames.watched:
            self._dress()  # a page was there before the hand
        before = due = time.perf_counter()
        while True:
            now = time.perf_counter()
            frame = self._tick(now - before)
            before = now
            if frame is None:
                self._wake.clear()
                await self._wake.wait()
                due = time.perf_counter()
                before = due - 1.0 / RATE  # the first frame after a pause shows motion already
                continue
            self.frames.send(frame)
            due = max(due + 1.0 / RATE, now)
            await self._pause(due)
            if self.frames.watched and not self.frames.wanted:
                await self._pause(time.perf_counter() + PATIENCE)  # nobody would see the next frame: its work is for the pages

    async def _pause(self, due: float) -> None:
        """Wait until ``due``, less if a message comes: a slider is answered at once, a burst of messages is not."""
        self._wake.clear()
        await asyncio.sleep(SHORTEST)
        with suppress(TimeoutError):
            async with asyncio.timeout(max(due - time.perf_counter(), 0.0)):
                await self._wake.wait()
