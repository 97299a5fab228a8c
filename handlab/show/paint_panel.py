"""``PaintPanel``: click a grid of points on the skin, and see the muscle that it makes (section 4.2, Figure 4)."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from handlab.anatomy.grids import MuscleGrid
from handlab.anatomy.records import Hand
from handlab.anatomy.terms import find
from handlab.show.module import PAINT, joined
from handlab.show.paint_room import PaintRoom, clicks, facts
from handlab.show.painting import Painting, Settings
from handlab.show.room_widget import RoomPage
from handlab.show.scene import Picture
from handlab.show.views import view_name

SKINS = ("translucent", "solid", "mesh")


class PaintPanel:
    """A hand to click on, settings, and the muscle that comes of both. Everything a click does, a method does too.

    ``name`` of the muscle; ``drive``: the pseudo muscle that moves it, by name or abbreviation; further settings as in
    ``painting.Settings``, and ``view``, ``skin`` (``translucent``, ``solid``, ``mesh``), ``contraction`` of what is drawn.
    On the hand: a click adds a point, row after row from origin to insertion; dragging a point moves it; dragging beside the points
    turns the hand; the wheel goes nearer. Raises ``ValueError`` or ``UnknownName`` for settings that can be no muscle's.
    """

    def __init__(self, hand: Hand, name: str, drive: str, *, height: int = 700, **settings: Any) -> None:
        self.hand = hand
        self.height = height
        self.painting = Painting(hand, Settings(name, drive))
        self.room = PaintRoom(self.painting, use=self._moved, save=self._saved)
        self.live: Any = None
        self._written: set[Path] = set()
        self.set(**settings)

    # What code calls.

    def set(self, **changes: Any) -> None:
        """Change settings, such as ``set(thickness_mm=(2, 7), bones=("trapezium", None, "proximal_phalanx_1"))``, or what is seen.

        Raises ``ValueError`` or ``UnknownName`` for what can be no muscle's; then nothing is changed.
        """
        room = self.room
        view, skin = changes.pop("view", room.view), find(changes.pop("skin", room.skin), SKINS, kind="way to draw the skin")
        contraction = float(changes.pop("contraction", room.contraction))
        if not 0.0 <= contraction <= 1.0:
            raise ValueError(f"contraction is {contraction:g}; contraction values lie between 0 and 1")
        view = view_name(view)
        if changes:
            self.painting.set(**changes)
        room.view, room.skin, room.contraction = view, skin, contraction
        self._tell()

    def add(self, points: ArrayLike) -> None:
        """Points (..., 3) on the skin in metres, bind posture, row after row. One off the skin raises; then none is added."""
        self.painting.add(points)
        self._tell()

    def undo(self) -> None:
        """Take back the last change of the points."""
        self.painting.undo()
        self._tell()

    def clear(self) -> None:
        """Take all points away; ``undo`` brings them back."""
        self.painting.clear()
        self._tell()

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

    def picture(self, size: tuple[int, int] = (560, 640)) -> Picture:
        """What the panel shows (height, width, 3): grid in blue, influenced skin points as green dots."""
        from handlab.show.paint_picture import paint_picture

        room = self.room
        return paint_picture(self.painting, view=room.view, skin=room.skin, contraction=room.contraction, size=size)

    def text(self) -> str:
        """The read-out."""
        painting, chosen = self.painting, self.painting.settings
        whole = len(painting.rows)
        lines = [f"{chosen.name}, driven by {chosen.drive}: {len(painting.points)} points, {whole} whole rows of {chosen.columns}"]
        if painting.problem is not None:
            lines.append(f"No muscle: {painting.problem}. Drag a point, undo, or change a setting; nothing is lost")
        if missing := painting.missing:
            lines.append(f"{missing} more {clicks(missing)} for {'a whole row' if whole > 1 else 'two rows'}")
        if told := facts(painting):
            rows = " > ".join("+".join(row) for row in painting.carriers)
            lines += [", ".join(told[:3]), f"lies {told[3]}; rows ride on {rows}", told[4]]
        return "\n".join(lines)

    def __repr__(self) -> str:
        """The read-out."""
        return f"PaintPanel of {self.text()}"

    # The page, and what it asks for.

    def _tell(self) -> None:
        if "page" in self.__dict__:
            self.page.tell({**self.room.told(), "view": self.room.view})

    def _saved(self, grid: MuscleGrid, folder: str) -> str:
        """The button: its own files may be written again, others not."""
        place = Path(folder).expanduser()
        file = place / f"{grid.name}.json"
        self._written.add(self.save(place, overwrite=file in self._written))
        return f"Saved as {file}"

    def _moved(self, grid: MuscleGrid) -> str:
        from handlab.show.widget import HandView

        self.live = HandView(self.hand, painted=grid, skin="translucent", layers=["muscles"])
        self.widget.children = [self.page.widget, self.live.widget]
        return f"The hand below has it: {self.hand.muscles[grid.drives[0]].abbreviation} makes it swell. In code: painted=panel."

    @cached_property
    def page(self) -> RoomPage:
        """The page to click on."""
        return RoomPage(joined(PAINT), "paint", self.room.ask, height=self.height)

    @cached_property
    def widget(self) -> Any:
        """The page, and below it the live hand once the muscle is used."""
        import ipywidgets

        return ipywidgets.VBox([self.page.widget])

    def _repr_mimebundle_(self, **how: Any) -> Any:
        try:
            return self.widget._repr_mimebundle_(**how)
        except ImportError:
            hint = "For clicking: pip install 'handlab[lab]'. Without it: panel.add(points), panel.picture(), panel.set(columns=2)"
            return {"text/plain": f"{self!r}\n{hint}"}
