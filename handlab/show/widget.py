"""The viewer in a notebook, as an anywidget: the kernel's own connection carries 11 kB a frame; no port, no proxy, no iframe.

The page asks for every frame while something moves (``tick``), so a busy kernel slows the motion down instead of piling up work,
and a resting hand costs nothing. Messages may arrive on any thread: one lock, nothing here draws.
"""

from __future__ import annotations

import threading
import time
from functools import cache
from typing import Any

from handlab.anatomy.records import Hand
from handlab.show.module import viewer_module
from handlab.show.outfits import BLEND, SOFT
from handlab.show.session import Session, Wish
from handlab.simulation.clip import Clip
from handlab.simulation.state import State

FIRST_TICK = 1.0 / 60.0  # a hand that wakes up has not moved since the last tick, however long ago that was

GLUE = """
export default {
  render({ model, el }) {
    const box = document.createElement("div"); // not el itself: the widget's layout takes its height away again
    box.style.height = `${model.get("height")}px`;
    el.append(box);
    const listeners = new Set();
    let arrived;
    const scene = new Promise((done) => { arrived = done; });
    const hear = (message, buffers) => {
      if (message.kind === "scene") arrived(buffers[0]);
      else if (message.kind === "frame") listeners.forEach((listener) => listener(buffers[0]));
      else listeners.forEach((listener) => listener(buffers && buffers.length ? { ...message, data: buffers[0] } : message));
    };
    model.on("msg:custom", hear);
    const transport = {
      ticks: "client", scene, send: (message) => model.send(message),
      onMessage: (listener) => { listeners.add(listener); return () => listeners.delete(listener); },
    };
    const ready = mount(box, transport, { embedded: true, ...model.get("options") });
    model.send({ kind: "hello" });
    return async () => { model.off("msg:custom", hear); (await ready).dispose(); };
  },
};
"""


@cache
def widget_class() -> Any:
    """The anywidget class. Raises ``ImportError`` where anywidget is missing."""
    import anywidget
    import traitlets

    class HandWidget(anywidget.AnyWidget):  # type: ignore[misc, unused-ignore]
        """What the notebook shows."""

        _esm = viewer_module(exports=False) + GLUE
        height = traitlets.Int(680).tag(sync=True)
        options = traitlets.Dict().tag(sync=True)

    return HandWidget


class HandView:
    """A live hand in a notebook: ``view.set(FDP2=0.4)``, ``view.play("fist")``, ``view.show(state)``; ``view.widget`` is the widget.

    ``start`` is a state or a recorded clip; ``hold`` joints that are held; ``wear``, ``muscles``: how the skin is worn and which muscles
    contract, as in ``simulate`` (soft skin by default; it shows a second or two after the page); ``height`` in pixels; ``painted``
    muscles, as in ``simulate``; ``options`` of the viewer: ``skin``, ``bones``, ``view``,
    ``layers`` (``["muscles", "tendons"]``), ``panels`` (false: the hand only).
    """

    def __init__(
        self,
        hand: Hand,
        start: State | Clip | None = None,
        *,
        hold: Any = (),
        wear: str = SOFT,
        muscles: str = "both",
        height: int = 680,
        skin_points: bool = False,
        painted: Any = None,
        **options: Any,
    ) -> None:
        if painted is not None:
            from handlab.simulation.painted import with_painted

            hand = with_painted(hand, painted)
        self.hand = hand
        self.session = Session(hand, start, hold=hold, wear=wear, muscles=muscles, skin_points=skin_points)
        self._preparing: threading.Thread | None = None
        self._lock = threading.RLock()
        self._before: float | None = None
        self.widget = widget_class()(height=height, options=options)
        self.widget.on_msg(self._hear)

    def _hear(self, _widget: Any, message: Any, _buffers: Any) -> None:
        kind = message.get("kind") if isinstance(message, dict) else None
        with self._lock:
            if kind == "hello":
                self.widget.send({"kind": "scene"}, buffers=[self.session.scene()])
                self._push()
                self._dress()
            elif kind == "tick":
                self._tick()
            else:
                self.session.message(message)
                self._pass_on()
                self._dress()
                for wish in self.session.wishes():
                    threading.Thread(target=self._fulfil, args=(wish,), daemon=True).start()

    def _dress(self) -> None:
        """Make the soft skin ready on a thread of its own, once it is wanted."""
        wardrobe = self.session.wardrobe
        if wardrobe.wear != BLEND and wardrobe.network is None and self._preparing is None:
            self._preparing = threading.Thread(target=self._prepare, daemon=True)
            self._preparing.start()

    def _prepare(self) -> None:
        try:
            self.session.prepare()
        except Exception as error:  # the blended skin lives on
            self._tell({"kind": "answer", "good": False, "text": f"no soft skin: {' '.join(str(error).split())}"})
            return
        with self._lock:
            self.session.ready()
            self._preparing = None
            self._dress()  # muscles were painted meanwhile
            self._push()

    def prepare(self) -> None:
        """Wait until the soft skin is ready."""
        if self.session.wardrobe.network is None:
            self.session.prepare()
        with self._lock:
            self.session.ready()

    def _tick(self) -> None:
        now = time.perf_counter()
        dt = FIRST_TICK if self._before is None else now - self._before
        frame = self.session.tick(dt)
        self._before = now if self.session.moving else None
        if frame is None:
            self.widget.send({"kind": "tock"})
        else:
            self.widget.send({"kind": "frame"}, buffers=[frame])
        self._pass_on()

    def _push(self) -> None:
        self.session.refresh()
        self._pass_on()
        self._before = None
        self.widget.send({"kind": "frame"}, buffers=[self.session.frame()])

    def _pass_on(self) -> None:
        for reply in self.session.replies():
            self._tell(reply)

    def _tell(self, reply: dict[str, Any]) -> None:
        data = reply.pop("data", None)
        self.widget.send(reply, buffers=[] if data is None else [data])

    def _fulfil(self, wish: Wish) -> None:
        from handlab.show.exports import fulfilled

        reply = fulfilled(wish)
        with self._lock:
            self._tell(reply)

    def message(self, message: dict[str, Any]) -> None:
        """What a page could send (see ``session``). Raises ``ValueError`` with the sentence that the page would show."""
        with self._lock:
            self.session.message(message)
            wrong = [reply["text"] for reply in self.session.replies_kept() if reply["kind"] == "answer" and not reply["good"]]
            self._push()
        if wrong:
            raise ValueError(wrong[-1])

    def set(self, **contraction: float) -> None:
        """Contractions in [0, 1] by muscle name or abbreviation; other muscles stay as they are."""
        self.message({"kind": "set", "contraction": contraction})

    def hold(self, *joints: str) -> None:
        """The joints that are held from now on; none: all move."""
        self.message({"kind": "hold", "joints": list(joints)})

    def play(self, clip: str | None = None, *, speed: float = 1.0, loop: bool = False) -> None:
        """Play a clip by name, or go on with the one that is loaded."""
        self.message({"kind": "play", "speed": speed, "loop": loop, **({} if clip is None else {"clip": clip})})

    def wear(self, skin: str | None = None, *, muscles: str | None = None) -> None:
        """How the skin is worn (``"blend"``, ``"springs"``, ``"springs and muscles"``), which muscles contract, as in ``simulate``."""
        given = {key: value for key, value in (("skin", skin), ("muscles", muscles)) if value is not None}
        self.message({"kind": "wear", **given})
        self._dress()

    def pause(self) -> None:
        """Stop the clip where it is."""
        self.message({"kind": "pause"})

    def reset(self) -> None:
        """The relaxed hand."""
        self.message({"kind": "reset"})

    def show(self, state: State, contraction: Any = None) -> None:
        """Show a state, at rest; with ``contraction`` the sliders stand there, and the hand moves on from it."""
        with self._lock:
            self.session.put(state, contraction)
            self._push()

    def look(self, **look: Any) -> None:
        """Change ``skin``, ``bones``, ``muscles``, ``tendons`` (false or true) or ``view`` of what is seen."""
        self.widget.options = {**self.widget.options, **look}
        self.widget.send({"kind": "look", **look})

    @property
    def state(self) -> State:
        """The hand as it stands."""
        with self._lock:
            return self.session.present()

    def _repr_mimebundle_(self, **how: Any) -> Any:
        return self.widget._repr_mimebundle_(**how)
