"""``PaintPanel``: click a grid of points on the skin, and see the muscle that it makes (section 4.2, Figure 4)."""

from __future__ import annotations

import io
import threading
from collections import OrderedDict
from collections.abc import Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from handlab.anatomy.grids import MuscleGrid, load_grids
from handlab.anatomy.records import Hand
from handlab.anatomy.terms import find
from handlab.show.main_thread import OnMain
from handlab.show.paint_picture import PaintPicture
from handlab.show.painting import Painting, Settings, influenced_by
from handlab.show.scene import Picture
from handlab.show.views import Camera
from handlab.simulation.geometric_muscle import muscles_of
from handlab.simulation.grid_rows import nearest_bones

QUALITY = 88  # of the JPEG: about 25 kB a picture
KEPT_CAMERAS = 64  # pictures whose clicks are still understood
LOOKS = ("view", "skin", "contraction")


class PaintPanel:
    """A picture to click on, settings, and the muscle that comes of both. Everything a click does, a method does too.

    ``name`` of the muscle; ``drive``: the pseudo muscle that moves it, by name or abbreviation; further settings as in
    ``painting.Settings``, and ``view``, ``skin`` (``translucent``, ``solid``, ``mesh``), ``contraction`` of what is drawn.
    In the picture: a click adds a point, row after row from origin to insertion; dragging a point moves it; dragging beside the points
    turns the hand; the wheel goes nearer. Raises ``ValueError`` or ``UnknownName`` for settings that can be no muscle's.
    """

    def __init__(self, hand: Hand, name: str, drive: str, *, size: tuple[int, int] = (560, 640), **settings: Any) -> None:
        self.hand = hand
        looks = {key: settings.pop(key) for key in LOOKS if key in settings}
        self.painting = Painting(hand, Settings(name, drive))
        self.painting.set(**settings)
        self.canvas = PaintPicture(hand, size=size)
        self.contraction = 0.0
        self.said = ""
        self._cameras: OrderedDict[int, Camera] = OrderedDict()
        self._pictures = 0
        self._answered: dict[str, int] = {}
        self._written: set[Path] = set()
        self._waiting: list[Mapping[str, Any]] = []
        self._lock = threading.Lock()
        self.set(**looks)

    # What code calls.

    def set(self, **changes: Any) -> None:
        """Change settings, such as ``set(thickness_mm=(2, 7), bones=("trapezium", None, "proximal_phalanx_1"))``, or what is seen.

        Raises ``ValueError`` or ``UnknownName`` for what can be no muscle's; then nothing is changed.
        """
        looks = {key: changes.pop(key) for key in LOOKS if key in changes}
        contraction = float(looks.pop("contraction", self.contraction))
        if not 0.0 <= contraction <= 1.0:
            raise ValueError(f"contraction is {contraction:g}; contraction values lie between 0 and 1")
        kept = self.canvas.skin
        self.canvas.look(**looks)
        try:
            if changes:
                self.painting.set(**changes)
        except (ValueError, KeyError):
            self.canvas.look(skin=kept)
            raise
        self.contraction, self.said = contraction, ""
        self._refresh()

    def add(self, points: ArrayLike) -> None:
        """Points (..., 3) on the skin in metres, bind posture, row after row. One off the skin raises; then none is added."""
        self.painting.add(points)
        self._refresh()

    def click(self, x: float, y: float) -> bool:
        """What a click at (x, y) does, fractions of the picture from its upper left corner. Returns whether it met the skin."""
        return self._handle({"kind": "click", "x": x, "y": y})

    def undo(self) -> None:
        """Take back the last change of the points."""
        self._handle({"kind": "undo"})

    def clear(self) -> None:
        """Take all points away; ``undo`` brings them back."""
        self._handle({"kind": "clear"})

    def save(self, folder: str | Path, *, overwrite: bool = False) -> Path:
        """Write the grid as JSON into ``folder``, for ``load_grids``. Raises ``ValueError`` while it is no muscle."""
        return self.painting.save(folder, overwrite=overwrite)

    @property
    def problem(self) -> str | None:
        """Why what is painted makes no muscle, or None."""
        return self.painting.problem

    @property
    def grid(self) -> MuscleGrid:
        """The painted grid. Raises ``ValueError`` while it is no muscle."""
        return self.painting.required().grid

    def picture(self) -> Picture:
        """What the panel shows (height, width, 3): grid in blue, influenced skin points as green dots."""
        return self.canvas.draw(self.painting, self.contraction)

    def text(self) -> str:
        """The read-out."""
        chosen, result = self.painting.settings, self.painting.result
        whole = len(self.painting.rows)
        lines = [f"{chosen.name}, driven by {chosen.drive}: {len(self.painting.points)} points, {whole} whole rows of {chosen.columns}"]
        if self.painting.problem is not None:
            lines.append(f"No muscle: {self.painting.problem}. Drag a point, undo, or change a setting; nothing is lost")
        if missing := self.painting.missing:
            lines.append(f"{missing} more {'click' if missing == 1 else 'clicks'} for {'a whole row' if whole > 1 else 'two rows'}")
        if result is not None:
            thick = 1e3 * result.muscle.fitted[0].thickness
            rows = " > ".join("+".join(row) for row in self.painting.carriers)
            lines.append(
                f"{result.length_mm:.1f} mm long, {thick.min():.1f} to {thick.max():.1f} mm thick, {result.volume_ml:.2f} ml at rest"
            )
            lines.append(f"lies below {len(result.influenced)} of {len(self.hand.skin.points)} skin points; rows ride on {rows}")
            lines.append(f"fitted in {result.seconds:.2f} s")
        return "\n".join([*lines, self.said] if self.said else lines)

    def __repr__(self) -> str:
        """The read-out."""
        return f"PaintPanel of {self.text()}"

    # What the page sends, on whatever thread. Every message is heeded, in order; a picture is drawn once for all that are there.

    def _hear(self, _widget: Any, message: Any, _buffers: Any) -> None:
        if isinstance(message, dict):
            with self._lock:
                self._waiting.append(message)
            self._work(None)

    @cached_property
    def _work(self) -> OnMain[None]:
        return OnMain(lambda _: self._heed())

    def _heed(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, []
        for message in waiting:
            page, number = str(message.get("page", "")), int(message.get("n", 0))
            if number and number <= self._answered.get(page, 0):
                continue  # sent a second time
            self._handle(message, draw=False)
            if number:
                self._answered[page] = number
        if waiting:
            self._refresh()

    def _handle(self, message: Mapping[str, Any], *, draw: bool = True) -> bool:
        """Do what a message asks; what goes wrong is said in the read-out. Returns whether it did something."""
        self.said = ""
        try:
            done = self._do(message)
        except (ValueError, KeyError, TypeError, OSError) as error:
            self.said, done = str(error), False
        if draw:
            self._refresh()
        return done

    def _do(self, message: Mapping[str, Any]) -> bool:
        kind = find(str(message.get("kind")), ("hello", "click", "move", "turn", "zoom", "undo", "clear"), kind="message")
        if kind in ("click", "move"):
            place = self.canvas.pick(float(message["x"]), float(message["y"]), self._cameras.get(int(message.get("picture", 0))))
            if place is None:
                self.said = "That was beside the hand; nothing was changed."
                return False
            if kind == "click":
                self.painting.add(place)
            else:
                self.painting.move(int(message["mark"]), place)
        elif kind == "turn":
            self.canvas.turn(float(message["dx"]), float(message["dy"]))
        elif kind == "zoom":
            self.canvas.zoom(float(message["by"]), float(message.get("x", 0.5)), float(message.get("y", 0.5)))
        elif kind in ("undo", "clear"):
            (self.painting.undo if kind == "undo" else self.painting.clear)()
        return True

    def _refresh(self) -> None:
        if "widget" in self.__dict__:
            self._controls.show()
            self._send()

    def _send(self) -> None:
        from PIL import Image

        file = io.BytesIO()
        Image.fromarray(self.picture()).save(file, format="JPEG", quality=QUALITY)
        self._pictures += 1
        self._cameras[self._pictures] = self.canvas.camera
        while len(self._cameras) > KEPT_CAMERAS:
            self._cameras.popitem(last=False)
        places, seen = self.canvas.places(self.painting.points)
        marks = [[round(float(x), 5), round(float(y), 5), bool(front)] for (x, y), front in zip(places, seen, strict=True)]
        told = {"kind": "picture", "picture": self._pictures, "marks": marks, "columns": self.painting.settings.columns}
        self.canvas_widget.send({**told, "answered": dict(self._answered)}, buffers=[file.getvalue()])

    @cached_property
    def canvas_widget(self) -> Any:
        """The picture that can be clicked on (anywidget)."""
        from handlab.show.paint_widgets import canvas_class

        made = canvas_class()(width=self.canvas.size[0], height=self.canvas.size[1])
        _ = self._work  # remembers this thread: all drawing happens here
        made.on_msg(self._hear)
        return made

    @cached_property
    def _controls(self) -> Any:
        from handlab.show.paint_widgets import Controls

        return Controls(self)

    @cached_property
    def widget(self) -> Any:
        """Picture, settings and read-out as one widget."""
        import ipywidgets

        controls = self._controls.box
        self._controls.show()
        grid = load_grids()[0]  # what is compiled is loaded now: the first fit of a user must not wait for it
        influenced_by(self.hand, muscles_of(self.hand, [grid]))
        nearest_bones(self.hand, grid.points_on(self.hand.skin, self.hand.skin.points, self.hand.side))
        return ipywidgets.HBox([self.canvas_widget, controls])

    def _slid(self, name: str, value: Any) -> None:
        """A setting was changed in the page: a wrong one is told and put back."""
        try:
            self.set(**{name: value})
        except (ValueError, KeyError) as error:
            self.said = str(error)
            self._refresh()

    def _save_into(self, folder: str) -> None:
        """The button: its own files may be written again, others not."""
        try:
            file = Path(folder).expanduser() / f"{self.grid.name}.json"
            self._written.add(self.save(Path(folder).expanduser(), overwrite=file in self._written))
            self.said = f"Saved as {file}"
        except (ValueError, OSError) as error:
            self.said = str(error)
        self._refresh()

    def follow(self, name: str) -> OnMain[Any]:
        """A callback on this thread for a setting that a control of the page changes."""
        return OnMain(partial(self._slid, name))

    def _repr_mimebundle_(self, **how: Any) -> Any:
        try:
            return self.widget._repr_mimebundle_(**how)
        except ImportError:
            hint = "For clicking: pip install 'handlab[lab]'. Without it: panel.click(0.6, 0.7), panel.picture(), panel.set(columns=2)"
            return {"text/plain": f"{self!r}\n{hint}"}
