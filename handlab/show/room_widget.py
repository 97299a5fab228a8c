"""The page of a room in a notebook: the same ES module as in the app, and a room that answers what it asks.

A message may arrive on any thread and in parts; the room is asked on the thread that made the page, message after message.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from handlab.show.main_thread import OnMain

Ask = Callable[[Mapping[str, Any], bytes | None], dict[str, Any]]

GLUE = """
export default {
  render({ model, el }) {
    const box = document.createElement("div"), asked = new Map();
    box.style.cssText = `height:${model.get("height")}px;border:1px solid #d5dbe1;border-radius:8px;overflow:hidden`;
    el.append(box);
    const page = Math.random().toString(36).slice(2), PART = 4e6; // a notebook's socket takes messages of 10 MB at most
    let count = 0, shown = null;
    const hear = (told) => {
      if (told.page === page) { asked.get(told.id)?.(told.reply); asked.delete(told.id); }
      else if (told.kind === "changed" && shown) shown.then((one) => one.retell(told.told));
    };
    const ask = (message, bytes) => new Promise((done) => {
      const id = ++count, of = Math.max(1, Math.ceil((bytes?.byteLength ?? 0) / PART));
      asked.set(id, done);
      for (let k = 0; k < of; k++) {
        const part = bytes ? [bytes.slice(k * PART, (k + 1) * PART)] : [];
        model.send({ page, id, message, part: k, of, data: !!bytes }, undefined, part);
      }
    });
    model.on("msg:custom", hear);
    shown = ENTRY(box, { ask });
    return async () => { model.off("msg:custom", hear); (await shown).dispose(); };
  },
};
"""


@cache
def widget_class(module: str, entry: str) -> Any:
    """The anywidget class of ``module`` (text without exports), begun by its function ``entry``. ``ImportError`` without anywidget."""
    import anywidget
    import traitlets

    class RoomWidget(anywidget.AnyWidget):  # type: ignore[misc, unused-ignore]
        """What the notebook shows."""

        _esm = module + GLUE.replace("ENTRY", entry)
        height = traitlets.Int(640).tag(sync=True)

    return RoomWidget


class RoomPage:
    """``widget`` is the page, begun by the function ``entry`` of ``module``; ``ask`` answers its messages. It never raises."""

    def __init__(self, module: str, entry: str, ask: Ask, *, height: int) -> None:
        self._ask = ask
        self._waiting: list[tuple[dict[str, Any], bytes]] = []
        self._parts: dict[tuple[str, int], list[bytes]] = {}
        self._lock = threading.Lock()
        self._work: OnMain[None] = OnMain(lambda _: self._heed())
        self.widget = widget_class(module, entry)(height=height)
        self.widget.on_msg(self.hear)

    def hear(self, _widget: Any, told: Any, buffers: Any) -> None:
        """A message of the page, or a part of one."""
        if not isinstance(told, Mapping) or not isinstance(told.get("message"), Mapping):
            return
        key = str(told.get("page")), int(told.get("id", 0))
        with self._lock:
            parts = self._parts.setdefault(key, [])
            parts.append(b"".join(bytes(one) for one in buffers or []))
            if len(parts) < int(told.get("of", 1)):
                return
            self._waiting.append((dict(told), b"".join(self._parts.pop(key))))
        self._work(None)

    def _heed(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, []
        for told, data in waiting:
            reply = self._ask(told["message"], data if told.get("data") else None)
            self.widget.send({"page": told.get("page"), "id": told.get("id"), "reply": reply})

    def tell(self, told: Any) -> None:
        """Something that code has changed shows in all pages."""
        self.widget.send({"kind": "changed", "told": told})
