"""``FitPanel``: a photograph becomes a hand by clicking, in a notebook (section 5)."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from handlab.anatomy.records import Hand
from handlab.fitting.result import Fit
from handlab.show.fit_clicks import Clicks, read
from handlab.show.fit_keepsakes import keepsake
from handlab.show.fit_room import FitRoom
from handlab.show.module import FIT, joined
from handlab.show.room_widget import RoomPage


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
        if picture is not None:
            self._open(picture)

    # What code calls.

    def set(self, **changes: Any) -> None:
        """Change clicks: ``landmarks`` (name -> (x, y) px or None), ``scale``, ``view``, ``side``, ``camera_mm``, ``sure``, ``mirror``,
        ``outline``.

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

    # What the page asks, and what it is told.

    def _asked(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        reply = self.room.ask(message, data)
        if message.get("kind") == "picture" and reply["good"]:
            self._find_clicks()
            reply["clicks"] = self.room.clicks.to_json()
        return reply

    def _tell(self) -> None:
        """A change made by code shows in the page."""
        if "page" in self.__dict__:
            self.page.tell(self.room.clicks.to_json())

    def _moved(self, fit: Fit) -> str:
        from handlab.show.widget import HandView

        self.view = HandView(fit.hand)
        self.widget.children = [self.page.widget, self.view.widget]
        return "The hand is live below; in code it is panel.hand."

    @cached_property
    def page(self) -> RoomPage:
        """The page to click on."""
        return RoomPage(joined(FIT), "fit", self._asked, height=self.height)

    @cached_property
    def widget(self) -> Any:
        """The page, and below it the live hand once it moves."""
        import ipywidgets

        return ipywidgets.VBox([self.page.widget])

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
