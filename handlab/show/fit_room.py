"""From a photograph to a hand, by clicking: what stands behind the page of the app and the panel of a notebook.

The page holds the clicks and sends all of them after every change; the host answers each message with one reply. ``ask`` never raises::

    hello                        points in their order, coins; picture and clicks if there are any
    drawings                     the small pictures of palm and back
    picture  name, data          the photograph, upright, as the page shows it
    clicks   clicks              the outline that they give so far, or what is wrong with them
    fit      clicks              the finished hand: report, outline, overlap
    find     view                a guess of all points, to be corrected by hand
    read     name, text          clicks from a file of points
    file     what                "hand" (archive), "picture" (outline over the photo) or "report"
    move     clicks              the hand goes live

Replies have ``good``; where it is false ``text`` says why in plain words, ``names`` which points to look at, ``choices`` what to answer.
"""

from __future__ import annotations

import base64
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Hand
from handlab.anatomy.terms import find
from handlab.fitting.calibration import CARD_MM, COINS, Scale, as_scale, confirmed
from handlab.fitting.landmarks import FEWEST, SIXTEEN, checked, source_points
from handlab.fitting.lens import Camera, camera
from handlab.fitting.mistakes import FitError, FitQuestion
from handlab.fitting.plausible import require_inside
from handlab.fitting.preview import Sketch, sketch
from handlab.fitting.result import Fit
from handlab.show.fit_clicks import Clicks, read, read_file
from handlab.show.fit_keepsakes import FILES, keepsake, rows
from handlab.show.fit_picture import TINTED, Photo, in_colours
from handlab.show.fit_words import plain, points, trouble

LOOKED_AT = 3000
SURE_FROM = 8  # points; what fewer seem to say is not worth a message


class NoPhoto(ValueError):  # noqa: N818 (reads as what it is)
    """Nothing was opened yet, or a host that was started anew has forgotten it."""


Keep = Callable[[Clicks], None]
Move = Callable[[Fit], str]


class FitRoom:
    """One photograph and the clicks in it. ``keep`` is called with the clicks after every change, ``move`` with the finished
    fit; it returns a sentence."""

    def __init__(self, hand: Hand | None = None, *, keep: Keep | None = None, move: Move | None = None) -> None:
        self.hand = load_hand() if hand is None else hand
        self.photo: Photo | None = None
        self.clicks = Clicks()
        self.fit: Fit | None = None
        self._keep, self._move = keep, move
        self._fitted: Clicks | None = None
        self._scales: dict[str, Scale] = {}
        self._lock = threading.RLock()

    def ask(self, message: Any, data: bytes | None = None) -> dict[str, Any]:
        """The reply to a message of a page."""
        start = time.perf_counter()
        kind = message.get("kind") if isinstance(message, Mapping) else None
        with nullcontext() if kind == "drawings" else self._lock:  # these take a second or two at first, and need nothing of the room
            try:
                act = ACTS[find(str(kind), ACTS, kind="message")]
                reply = {"good": True, **act(self, message, data)}
            except FitError as error:
                reply = {"good": False, **trouble(error)}
            except (ValueError, LookupError, TypeError, OSError, ArithmeticError, AttributeError, MemoryError) as error:
                said = " ".join(str(error).split()) or type(error).__name__
                reply = {"good": False, "text": plain(said), "names": [], "choices": []}
                if isinstance(error, NoPhoto):
                    reply["missing"] = "picture"
        return {**reply, "ms": round(1e3 * (time.perf_counter() - start), 1)}

    def open(self, picture: bytes | NDArray[Any], name: str) -> None:
        """Another photograph; clicks of the last are gone. Raises ``ValueError`` where it is none; then all stays as it was."""
        photo = Photo(picture, name)
        self.photo, self.clicks, self.fit, self._fitted = photo, Clicks(), None, None
        self._scales.clear()

    def scale(self) -> Scale:
        """Millimetres per pixel. A coin is looked for once. Raises ``ValueError``."""
        told = self.clicks.camera_mm
        key = repr((self.clicks.scale, told))
        if key not in self._scales:
            self._scales[key] = confirmed(self._measured(), self._photo().data, "auto" if told is None else told or None)
        return self._scales[key]

    def _measured(self) -> Scale:
        """A coin or card is looked for in a picture of at most ``LOOKED_AT`` pixels a side: 50 megapixels would take ten seconds."""
        scale = dict(self.clicks.scale)
        kind = next((one for one in ("coin", "card") if one in scale), None)
        if kind is None:
            return as_scale(scale)
        pixels, step = self._photo().reduced(LOOKED_AT)
        found = as_scale({**scale, kind: [value / step for value in scale[kind]]}, pixels)
        return replace(found, mm_per_px=found.mm_per_px / step)

    def camera(self) -> Camera:
        """As the user says (0: a scanner), as the file tells, or as is likely."""
        if self.clicks.camera_mm is not None:
            return Camera(self.clicks.camera_mm or None, "given")
        return camera(self._photo().data, self.scale().mm_per_px, self._photo().size)

    def sketch(self) -> Sketch:
        """The outline that the clicks give so far. Raises ``FitError``."""
        photo, clicks = self._photo(), self.clicks
        checked(clicks.landmarks)
        require_inside(clicks.placed, *photo.size)
        return sketch(self.hand, clicks.landmarks, self.scale(), **self._how())

    def finish(self) -> Fit:
        """The hand of the clicks as they are. Raises ``FitError``."""
        from handlab.fitting.distance import camera_by_points
        from handlab.fitting.fit import fit_photo

        if self.fit is None or self._fitted != self.clicks:
            photo, clicks = self._photo(), self.clicks
            if not clicks.whole_scale:
                raise FitError("how large is a pixel? Click two marks of a ruler, or a coin, first", clicks.placed)
            how, seen = self._how(), self.camera()
            if seen.how == "assumed":
                seen = camera_by_points(self.hand, clicks.landmarks, self.scale().mm_per_px, **how) or seen
            how["camera_mm"], how["outline"], name = seen.distance_mm, clicks.outline, Path(photo.name).stem
            made = fit_photo(photo.pixels, landmarks=clicks.landmarks, scale=self.scale(), hand=self.hand, name=name, **how)
            made = made.with_picture(photo.pixels, photo.size, seen.how)
            self.fit, self._fitted = replace(made, hand=in_colours(made, photo)), clicks
        return self.fit

    def _how(self) -> dict[str, Any]:
        clicks, photo = self.clicks, self._photo()
        return {
            "view": clicks.view,
            "side": clicks.side,
            "sure": clicks.sure,
            "mirror": clicks.mirror,
            "camera_mm": self.camera().distance_mm,
            "centre_px": np.array(photo.size) / 2.0,
        }

    def _photo(self) -> Photo:
        if self.photo is None:
            raise NoPhoto("there is no photograph yet; open one first")
        return self.photo

    def _took(self, message: Mapping[str, Any]) -> None:
        if "clicks" in message:
            clicks = read(message["clicks"])
            if clicks != self.clicks:
                self.clicks = clicks
                if self._keep is not None:
                    self._keep(clicks)

    # What a page asks.

    def _hello(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        shown = {} if self.photo is None else {"picture": self._picture_told(), "clicks": self.clicks.to_json()}
        return {"points": points(), "coins": list(COINS), "coin_mm": dict(COINS), "card_mm": list(CARD_MM), **shown}

    def _drawings(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        from handlab.show.fit_drawing import drawing

        drawings = {}
        for view in ("palmar", "dorsal"):
            made = drawing(view)
            drawings[view] = {"image": _url(made.png, "png"), "width": made.size[0], "height": made.size[1], "places": made.places}
        threading.Thread(target=warm_up, args=(self.hand,), daemon=True).start()
        return {"drawings": drawings}

    def _picture(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        if data is None:
            raise ValueError("no picture came along; choose it again")
        name = Path(str(message.get("name") or "picture").replace("\\", "/")).name[:120] or "picture"
        try:
            self.open(bytes(data), name)
        except ValueError as error:
            raise ValueError(str(error).replace("the picture", name, 1)) from error
        return {"picture": self._picture_told(), "clicks": self.clicks.to_json()}

    def _picture_told(self) -> dict[str, Any]:
        photo = self._photo()
        return {"name": photo.name, "width": photo.size[0], "height": photo.size[1], "image": _url(photo.jpeg(), "jpeg")}

    def _clicks(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        self._took(message)
        reply: dict[str, Any] = {}
        clicks, photo = self.clicks, self._photo()
        if clicks.whole_scale:
            found = self.scale()
            reply["scale"] = {"mm_per_px": found.mm_per_px, "how": found.how}
            if "coin" in clicks.scale:
                across = clicks.scale["mm"] if "mm" in clicks.scale else COINS[clicks.scale["name"]]
                reply["scale"]["radius_px"] = across / (2.0 * found.mm_per_px)
        if not reply or len(clicks.placed) < 2:
            return reply
        try:
            made = self.sketch()
        except FitError as error:
            at_one_place = len(error.names) == 2 and "one place" in str(error)
            worth = at_one_place or len(clicks.placed) >= SURE_FROM or (isinstance(error, FitQuestion) and len(clicks.placed) > FEWEST + 2)
            return {**reply, "trouble": trouble(error)} if worth else reply
        shown = photo.mask(np.array(list(clicks.placed.values())))
        overlap = None if shown is None else round(made.iou(shown, photo.step), 4)
        outline = np.round(made.outline, 1).tolist()
        return {**reply, "sketch": {"outline": outline, "places": made.places, "side": made.side, "view": made.view, "iou": overlap}}

    def _fit(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        self._took(message)
        return {"result": rows(self.finish(), self._photo())}

    def _find(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        from handlab.fitting.found import find_landmarks

        pixels, step = self._photo().reduced(TINTED)
        found = find_landmarks(pixels, view="dorsal" if message.get("view") == "dorsal" else "palmar")
        return {"landmarks": {name: (x * step, y * step) for name, (x, y) in found.items()}}

    def _read(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        return {"clicks": read_file(str(message.get("name") or "this file")[:120], message.get("text")).to_json()}

    def _file(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        what = find(str(message.get("what")), FILES, kind="file")
        name, mime, content = keepsake(what, self.finish(), self._photo(), self.clicks)
        return {"file": {"name": name, "mime": mime, "data": base64.b64encode(content).decode()}}

    def _moved(self, message: Mapping[str, Any], data: bytes | None) -> dict[str, Any]:
        self._took(message)
        fit = self.finish()
        if self._move is None:
            raise ValueError("this page cannot move a hand; save it and open it with: handlab run --hand FILE")
        return {"said": self._move(fit)}


def warm_up(hand: Hand) -> None:
    """What is compiled or kept with the hand is there before the first click needs it."""
    marks = {name: 8e3 * at[[2, 0]] * [1.0, -1.0] for name, at in zip(SIXTEEN, source_points(hand, "palmar", SIXTEEN), strict=True)}
    with suppress(ValueError):
        sketch(hand, marks, Scale(0.125, "given"), view="palmar", camera_mm=600.0)


def _url(data: bytes, kind: str) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"


ACTS = {
    "hello": FitRoom._hello,
    "drawings": FitRoom._drawings,
    "picture": FitRoom._picture,
    "clicks": FitRoom._clicks,
    "fit": FitRoom._fit,
    "find": FitRoom._find,
    "read": FitRoom._read,
    "file": FitRoom._file,
    "move": FitRoom._moved,
}
