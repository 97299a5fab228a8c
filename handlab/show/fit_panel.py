"""``FitPanel``: a photograph becomes a hand by clicking, in a notebook (section 5)."""

from __future__ import annotations

import hashlib
import json
import os
import threading
from collections.abc import Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from handlab.anatomy.records import Hand
from handlab.fitting.result import Fit
from handlab.show.fit_clicks import Clicks, read
from handlab.show.fit_keepsakes import keepsake
from handlab.show.fit_room import FitRoom
from handlab.show.main_thread import OnMain
from handlab.show.module import STATIC

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
      else if (told.kind === "changed" && shown) shown.then((one) => one.retell(told.clicks, told.picture));
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
    shown = fit(box, { ask });
    return async () => { model.off("msg:custom", hear); (await shown).dispose(); };
  },
};
"""


@cache
def widget_class() -> Any:
    """The anywidget class. Raises ``ImportError`` where anywidget is missing."""
    import anywidget
    import traitlets

    class FitWidget(anywidget.AnyWidget):  # type: ignore[misc, unused-ignore]
        """What the notebook shows."""

        _esm = (STATIC / "fit.js").read_text(encoding="utf-8").replace("export async function fit", "async function fit") + GLUE
        height = traitlets.Int(640).tag(sync=True)

    return FitWidget


class FitPanel:
    """A photograph to click on; ``panel.hand`` is the hand, ``panel.fit`` how it came about. What a click does, ``set`` does too.

    ``picture``: a file, its bytes or pixels; without one, the panel asks for it. ``hand``: what is warped, the reference hand if not
    given. ``keep``: the file that clicks are written to after every change and read from when the same picture is opened again, by
    default ``<name of the picture>.points.json`` in the current folder; ``False`` keeps none. Raises what ``load_picture`` raises.
    """

    def __init__(
        self,
        picture: str | os.PathLike[str] | bytes | NDArray[Any] | None = None,
        *,
        hand: Hand | None = None,
        keep: str | os.PathLike[str] | bool = True,
        height: int = 640,
    ) -> None:
        self.height = height
        self.room = FitRoom(hand, keep=self._write, move=self._moved)
        self.view: Any = None
        self.file: Path | None = None
        self._keep = keep
        self._mark = ""
        self._waiting: list[tuple[dict[str, Any], bytes]] = []
        self._parts: dict[tuple[str, int], list[bytes]] = {}
        self._lock = threading.Lock()
        if picture is not None:
            self._open(picture)

    # What code calls.

    def set(self, **changes: Any) -> None:
        """Change clicks: ``landmarks`` (name -> (x, y) px or None), ``scale``, ``view``, ``side``, ``camera_mm``, ``sure``, ``mirror``.

        ``set(landmarks={"tip_index": (812, 240)})`` adds to those that are there. Raises ``ValueError`` for what can be no click.
        """
        known = self.room.clicks.to_json()
        unknown = set(changes) - set(known)
        if unknown:
            raise TypeError(f"there is no {', '.join(sorted(unknown))}; there are {', '.join(known)}")
        if "landmarks" in changes:
            changes["landmarks"] = {**known["landmarks"], **changes["landmarks"]}
        self.room.clicks = read({**known, **changes})
        self._write(self.room.clicks)
        self._tell()

    @property
    def clicks(self) -> Clicks:
        """What was said so far."""
        return self.room.clicks

    @property
    def landmarks(self) -> dict[str, tuple[float, float]]:
        """The points that were clicked: name -> (x, y) px."""
        return self.room.clicks.placed

    @property
    def fit(self) -> Fit:
        """The finished fit. Raises ``FitError`` (it carries the clicks) with what is still missing."""
        return self.room.finish()

    @property
    def hand(self) -> Hand:
        """The hand, ready to move: ``hl.simulate(panel.hand, "fist")``, ``hl.view(panel.hand)``. Raises as ``fit``."""
        return self.fit.hand

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the hand (.zip), the picture with the outline (.jpg) or the report (.txt). An older file of that name is replaced."""
        file = Path(path)
        kinds = {".zip": "hand", ".jpg": "picture", ".txt": "report"}
        if file.suffix.lower() not in kinds:
            raise ValueError(f"{file.name}: a fit is saved as {', '.join(kinds)} (hand, picture with outline, report)")
        content = keepsake(kinds[file.suffix.lower()], self.fit, self.room._photo(), self.clicks)[2]
        _written(file, content)
        return file

    def __repr__(self) -> str:
        """What is there, and what is next."""
        if self.room.photo is None:
            return "FitPanel without a photograph: hl.FitPanel('me.jpg'), or drop one on the panel"
        clicks = self.room.clicks
        scale = "scale known" if clicks.whole_scale else "no scale yet: set(scale={'ruler': [(x, y), (x, y)], 'mm': 100})"
        where = f"; kept in {self.file}" if self.file is not None else ""
        return f"FitPanel of {self.room.photo.name}: {len(clicks.placed)} of 26 points, {scale}, {clicks.view or 'palm or back?'}{where}"

    # The picture and its file of clicks.

    def _open(self, picture: Any) -> None:
        from handlab.fitting.pictures import load_picture

        if isinstance(picture, str | os.PathLike):
            load_picture(picture)  # says what is wrong by the file's own name
            self.room.open(Path(picture).read_bytes(), Path(picture).name)
        else:
            self.room.open(picture, "picture")
        self._find_clicks()

    def _find_clicks(self) -> None:
        """Clicks of an earlier sitting with the same picture; a file of another picture stays untouched."""
        photo = self.room._photo()
        self._mark = hashlib.sha256(photo.pixels.tobytes()).hexdigest()[:16]
        self.file = None
        if self._keep is False:
            return
        if self._keep is not True:
            candidates = [Path(self._keep)]
        else:
            candidates = [Path(f"{Path(photo.name).stem}.points{n}.json") for n in ("", *(f"-{k}" for k in range(2, 100)))]
        for file in candidates:
            try:
                kept = json.loads(file.read_text(encoding="utf-8")) if file.exists() else None
                mine = kept is None or kept.get("picture", {}).get("mark") == self._mark
            except (OSError, ValueError, AttributeError):
                kept, mine = None, False
            if mine:
                self.file = file
                if kept is not None:
                    self.room.clicks = read(kept)
                return
        if self._keep is not True:
            raise ValueError(f"{self._keep} holds something else than clicks in {photo.name}; give another file as keep")

    def _write(self, clicks: Clicks) -> None:
        if self.file is not None:
            photo = self.room._photo()
            about = {"name": photo.name, "width": photo.size[0], "height": photo.size[1], "mark": self._mark}
            _written(self.file, (json.dumps({**clicks.to_json(), "picture": about}, indent=1) + "\n").encode())

    # What the page sends, on whatever thread; it is heeded in order on the thread that made the panel.

    def _hear(self, _widget: Any, told: Any, buffers: Any) -> None:
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

    @cached_property
    def _work(self) -> OnMain[None]:
        return OnMain(lambda _: self._heed())

    def _heed(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, []
        for told, data in waiting:
            message = told["message"]
            reply = self.room.ask(message, data if told.get("data") else None)
            if message.get("kind") == "picture" and reply["good"]:
                self._find_clicks()
                reply["clicks"] = self.room.clicks.to_json()
            self.front.send({"page": told.get("page"), "id": told.get("id"), "reply": reply})

    def _tell(self) -> None:
        """A change made by code shows in the page."""
        if "front" in self.__dict__:
            self.front.send({"kind": "changed", "clicks": self.room.clicks.to_json()})

    def _moved(self, fit: Fit) -> str:
        from handlab.show.widget import HandView

        self.view = HandView(fit.hand)
        self.widget.children = [self.front, self.view.widget]
        return "The hand is live below; in code it is panel.hand."

    @cached_property
    def front(self) -> Any:
        """The page to click on (anywidget)."""
        made = widget_class()(height=self.height)
        _ = self._work  # remembers this thread
        made.on_msg(self._hear)
        return made

    @cached_property
    def widget(self) -> Any:
        """The page, and below it the live hand once it moves."""
        import ipywidgets

        return ipywidgets.VBox([self.front])

    def _repr_mimebundle_(self, **how: Any) -> Any:
        try:
            return self.widget._repr_mimebundle_(**how)
        except ImportError:
            return {"text/plain": f"{self!r}\nFor clicking: pip install 'handlab[lab]'. Without it: panel.set(landmarks=..., scale=...)"}


def _written(file: Path, content: bytes) -> None:
    """Whole or not at all."""
    part = file.with_name(f".{file.name}.part")
    part.write_bytes(content)
    part.replace(file)
