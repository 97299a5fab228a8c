"""The paint panel in a notebook: the picture that sends clicks, and its controls."""

from __future__ import annotations

from functools import cache, partial
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from handlab.show.main_thread import OnMain
from handlab.show.module import STATIC
from handlab.show.paint_picture import SKINS
from handlab.show.views import DIRECTIONS

if TYPE_CHECKING:
    from handlab.show.paint_panel import PaintPanel

NEAREST = "nearest"
NAMED, WIDE = "124px", "404px"  # the longest label, and a control that shows the longest name of a muscle whole
THICKEST_MM, DEEPEST_MM = 15.0, 15.0  # ends of the sliders; code may go further


@cache
def canvas_class() -> Any:
    """The anywidget class of the picture. Raises ``ImportError`` where anywidget is missing."""
    import anywidget
    import traitlets

    class PaintCanvas(anywidget.AnyWidget):  # type: ignore[misc, unused-ignore]
        """A picture that sends where it was clicked."""

        _esm = (STATIC / "paint.js").read_text(encoding="utf-8")
        width = traitlets.Int(560).tag(sync=True)
        height = traitlets.Int(640).tag(sync=True)

    return PaintCanvas


class Controls:
    """Settings of a panel as ipywidgets: ``box`` holds them all, ``show()`` brings them up to date without moving the muscle."""

    def __init__(self, panel: PaintPanel) -> None:
        import ipywidgets as w

        self.panel = panel
        self._moving = False
        self._rows = 0
        hand, wide = panel.hand, {"description_width": NAMED}
        drives = [(f"{muscle.abbreviation}  {name.replace('_', ' ')}", name) for name, muscle in hand.muscles.items()]
        self.named: dict[str, Any] = {
            "name": w.Text(description="name", continuous_update=False, style=wide),
            "drive": w.Dropdown(options=drives, description="driven by", style=wide),
            "columns": w.IntSlider(min=2, max=8, description="points in a row", style=wide, continuous_update=False),
            "finer": w.IntSlider(min=1, max=6, description="divide rows by", style=wide, continuous_update=False),
            "thickness_mm": w.FloatRangeSlider(min=0.1, max=THICKEST_MM, step=0.1, description="thickness, mm", style=wide),
            "skin_distance_mm": w.FloatSlider(max=DEEPEST_MM, step=0.1, description="skin distance, mm", style=wide),
            "rows_mm": w.Text(description="skin distance, mm", continuous_update=False, style=wide),
            "contraction": w.FloatSlider(max=1.0, step=0.02, description="contraction", style=wide),
            "skin": w.ToggleButtons(options=SKINS, tooltips=[f"{skin} skin" for skin in SKINS], style={"button_width": "98px"}),
        }
        for name, control in self.named.items():
            control.layout.width = WIDE
            self._follow(control, OnMain(self._each_row) if name == "rows_mm" else panel.follow(name))
        self.ends = [w.Checkbox(description=f"{end} on bone", indent=False) for end in ("first row", "last row")]
        for end in self.ends:
            self._follow(end, OnMain(lambda _: panel._slid("on_bone", tuple(one.value for one in self.ends))))
        self.bones = w.VBox()
        self.folder = w.Text(value="muscles", description="folder", style=wide, layout={"width": "300px"})
        buttons = []
        for label, tip in (("Undo", "Take back the last change of the points"), ("Clear", "Take all points away; Undo brings them back")):
            button = w.Button(description=label, tooltip=tip)
            # Through the queue of messages: of a burst of slider moves the last one counts, of clicks every one does.
            button.on_click(partial(self._pressed, label.lower()))
            buttons.append(button)
        save = w.Button(description="Save", tooltip="Write the grid into the folder, as data")
        store: OnMain[Any] = OnMain(lambda _: panel._save_into(self.folder.value))
        save.on_click(store)
        sides = []
        for view in DIRECTIONS:
            side = w.Button(description=view, layout=w.Layout(width="auto"))
            turned: OnMain[Any] = OnMain(partial(self._side, view))
            side.on_click(turned)
            sides.append(side)
        self.readout = w.HTML()
        self.box = w.VBox(
            [
                *self.named.values(),
                w.HBox(self.ends),
                w.HTML("<b>bones that carry the rows</b>"),
                self.bones,
                w.HBox(buttons),
                w.HBox([self.folder, save]),
                w.HBox(sides, layout=w.Layout(flex_flow="row wrap")),
                self.readout,
            ],
            layout=w.Layout(width="420px"),
        )

    def _each_row(self, text: str) -> None:
        try:
            given = tuple(float(one) for one in text.replace(",", " ").split())
        except ValueError:
            given = ()
        if given:
            self.panel._slid("skin_distance_mm", given)
        else:
            self.panel.said = f"{text!r} is no list of distances; write one in millimetres for each row, such as 6, 3, 2"
            self.panel._refresh()

    def _side(self, view: str, _: Any) -> None:
        self.panel.set(view=view)

    def _pressed(self, kind: str, _: Any) -> None:
        self.panel._hear(None, {"kind": kind}, [])

    def _follow(self, control: Any, move: OnMain[Any]) -> None:
        control.observe(lambda change: None if self._moving else move(change["new"]), "value")

    def show(self) -> None:
        """Bring every control to what is set, and the read-out to what is."""
        chosen = self.panel.painting.settings
        self._moving = True
        try:
            self._bone_rows(len(self.panel.painting.rows))
            for name, control in self.named.items():
                value = getattr(chosen, name, None)
                if name in ("contraction", "skin"):
                    value = self.panel.contraction if name == "contraction" else self.panel.canvas.skin
                if name == "thickness_mm":
                    control.max = max(THICKEST_MM, chosen.thickness_mm[1])
                if name in ("skin_distance_mm", "rows_mm"):
                    value = self._distance(name, chosen.skin_distance_mm)
                if value is not None:
                    control.value = value
            for end, value in zip(self.ends, chosen.on_bone, strict=True):
                end.value = value
            for k, choice in enumerate(self.bones.children):
                named = chosen.bones[min(k, len(chosen.bones) - 1)] if len(chosen.bones) == 1 or k < len(chosen.bones) else None
                choice.value = named if isinstance(named, str) else NEAREST
        finally:
            self._moving = False
        lines = [escape(line) for line in self.panel.text().splitlines()]
        loud = {escape(text) for text in (self.panel.said,) if text}
        told = [f"<b>{line}</b>" if line in loud or line.startswith("No muscle") else line for line in lines]
        self.readout.value = f'<div style="line-height:1.4">{"<br>".join(told)}</div>'

    def _distance(self, name: str, given: float | tuple[float, ...]) -> Any:
        """Show the slider where one distance holds for all rows, the list where each row has its own; the value of either."""
        control, each = self.named[name], isinstance(given, tuple)
        control.layout.display = None if each == (name == "rows_mm") else "none"
        if name == "rows_mm":
            return ", ".join(f"{one:g}" for one in np.atleast_1d(given))
        if isinstance(given, tuple):
            return None
        control.max = max(DEEPEST_MM, given)
        return given

    def _bone_rows(self, count: int) -> None:
        """One choice of a bone for every whole row."""
        if count == self._rows:
            return
        import ipywidgets as w

        choices = list(self.bones.children[:count])
        for k in range(len(choices), count):
            options = [(f"{NEAREST} bone", NEAREST), *((name.replace("_", " "), name) for name in self.panel.hand.bones)]
            choice = w.Dropdown(options=options, description=f"row {k + 1}", style={"description_width": NAMED}, layout={"width": WIDE})
            self._follow(choice, OnMain(partial(self._chosen, k)))
            choices.append(choice)
        self.bones.children, self._rows = choices, count

    def _chosen(self, row: int, bone: str) -> None:
        rows = [None if choice.value == NEAREST else choice.value for choice in self.bones.children]
        rows[row] = None if bone == NEAREST else bone
        self.panel._slid("bones", tuple(rows))
