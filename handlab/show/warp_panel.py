"""A panel of lessons: one feature point of a hand is dragged away, the warp follows, and bones that fold are marked."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.fitting.landmarks import NAMES, source_points
from handlab.physics import rbf
from handlab.show.colours import BLACK, BLUE, FAINT, IVORY, RULE, VERMILION
from handlab.show.figure_panel import FigurePanel
from handlab.show.figures import drawing
from handlab.show.main_thread import OnMain

MOST_MM = 80.0
GRID_MM = 10.0  # between the lines of the grid
SHOWN = 8  # bones with the least determinants
WORDS = {"distal_mm": "distal, mm", "radial_mm": "to thumb, mm"}
PICTURE = (2, 0)  # the palm as a picture: radial to the right, distal up


class WarpPanel(FigurePanel):
    """``hand`` with a feature point ``point`` dragged by ``distal_mm`` towards the fingertips and ``radial_mm`` towards the thumb.

    All other feature points stay. ``warp`` is the map that follows, ``least`` the least determinant of its Jacobian on each bone,
    ``folded`` how many points of bones have a negative one. ``set(distal_mm=20)`` does what the slider does.
    """

    hint = "panel.set(distal_mm=20)"

    def __init__(self, hand: Hand, point: str = "pip_index", *, distal_mm: float = 0.0, radial_mm: float = 0.0) -> None:
        self.hand = hand
        self.source = source_points(hand, "palmar", NAMES, "exact")
        self._bones = np.concatenate([bone.points for bone in hand.bones.values()])
        self._owner = np.repeat(list(hand.bones), [len(bone.points) for bone in hand.bones.values()])
        self._point = "pip_index"
        self._drag = {"distal_mm": 0.0, "radial_mm": 0.0}
        self.set(point=point, distal_mm=distal_mm, radial_mm=radial_mm)

    def set(self, *, point: str | None = None, distal_mm: float | None = None, radial_mm: float | None = None) -> None:
        """Drag again; what is not given stays."""
        name = self._point if point is None else find(point, NAMES, kind="feature point")
        drag = dict(self._drag)
        for key, value in (("distal_mm", distal_mm), ("radial_mm", radial_mm)):
            if value is None:
                continue
            if not abs(float(value)) <= MOST_MM:
                raise ValueError(f"{key} is {value:g}; give -{MOST_MM:g} to {MOST_MM:g} millimetres")
            drag[key] = float(value)
        self._point, self._drag = name, drag
        self.target = self.source.copy()
        thumb = 1.0 if self.hand.side == "right" else -1.0
        self.target[NAMES.index(name)] += 1e-3 * np.array([drag["distal_mm"], 0.0, thumb * drag["radial_mm"]])
        self.warp = rbf.fitted(self.source, self.target)
        self.determinant = np.linalg.det(rbf.jacobian(self.warp, self._bones))
        self._refresh()

    @property
    def point(self) -> str:
        """The feature point that is dragged."""
        return self._point

    @property
    def folded(self) -> int:
        """How many points of bones have a negative determinant."""
        return int(np.count_nonzero(self.determinant < 0.0))

    @property
    def least(self) -> dict[str, float]:
        """The least determinant on every bone, the worst bone first."""
        found = {name: float(self.determinant[self._owner == name].min()) for name in self.hand.bones}
        return dict(sorted(found.items(), key=lambda row: row[1]))

    def text(self) -> str:
        """The read-out."""
        name, value = next(iter(self.least.items()))
        verdict = f"FOLDED at {self.folded} points of bones" if self.folded else "no bone folds"
        distal, radial = self._drag["distal_mm"], self._drag["radial_mm"]
        return (
            f"{self._point} dragged by {distal:+.0f} mm distal, {radial:+.0f} mm to the thumb: {verdict}\n"
            f"least determinant {value:.2f}, in {name}"
        )

    def figure(self) -> Any:
        """The warped palm with a grid that was square, and the worst bones."""
        with drawing(figsize=(16, 9)) as figure:
            left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
            self._palm(left)
            worst = list(self.least.items())[:SHOWN]
            values = np.array([value for _, value in worst])
            bars = right.barh(range(len(worst)), values, color=np.where(values < 0.0, VERMILION, BLUE), zorder=2)
            for bar, value in zip(bars, values, strict=True):
                bar.set_hatch("//" if value < 0.0 else "")
            right.bar_label(bars, [f"{value:.2f}" for value in values], padding=5)
            right.axvline(0.0, color=BLACK, linewidth=2.5)
            right.set_yticks(range(len(worst)), [name.replace("_", " ") for name, _ in worst])
            right.set(xlim=(min(-0.6, 1.25 * values.min()), 1.3), xlabel="least determinant (1: nothing changed, below 0: folded)")
            right.set_title("FOLDED" if self.folded else "the worst bones")
            right.invert_yaxis()
        return figure

    def _palm(self, axes: Any) -> None:
        skin, faces = 1e3 * self.warp(self.hand.skin.points), self.hand.skin.faces
        axes.triplot(*skin[:, PICTURE].T, faces, color=IVORY, linewidth=0.7, zorder=0)
        for row in self._grid():
            axes.plot(*(1e3 * self.warp(row)[:, PICTURE].T), color=RULE, linewidth=1.3, zorder=1)
        bones = 1e3 * self.warp(self._bones)[:, PICTURE]
        bad = self.determinant < 0.0
        axes.plot(*bones[~bad].T, ".", color=FAINT, markersize=2.0, zorder=2)
        axes.plot(*bones[bad].T, "x", color=VERMILION, markersize=11, markeredgewidth=3.5, zorder=5, label="folded")
        axes.plot(*(1e3 * self.target[:, PICTURE].T), "o", color=BLUE, markersize=8, zorder=4)
        i = NAMES.index(self._point)
        start, end = 1e3 * self.source[i, PICTURE], 1e3 * self.target[i, PICTURE]
        axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": BLACK, "linewidth": 3.0, "mutation_scale": 25}, zorder=6)
        axes.plot(*start, "o", markerfacecolor="none", markeredgecolor=BLACK, markersize=12, markeredgewidth=2.5, zorder=6)
        axes.set(title=self._point, xlabel="mm, radial to the right", ylabel="mm, distal upward", aspect="equal")
        x, y = (1e3 * self.hand.skin.points[:, k] for k in PICTURE)
        axes.set(xlim=(x.min() - 12.0, x.max() + 12.0), ylim=(y.min() + 20.0, y.max() + 25.0))
        axes.grid(visible=False)
        if bad.any():
            axes.legend(loc="lower right")

    def _grid(self) -> list[Array]:
        """Straight lines (n, 3) in the plane of the palm, before the warp."""
        low, high = self.hand.skin.points.min(axis=0), self.hand.skin.points.max(axis=0)
        depth = float(self.source[:, 1].mean())
        rows = []
        for along, across in (PICTURE, PICTURE[::-1]):
            for at in np.arange(low[across], high[across], 1e-3 * GRID_MM):
                row = np.full((120, 3), depth)
                row[:, along] = np.linspace(low[along], high[along], 120)
                row[:, across] = at
                rows.append(row)
        return rows

    def controls(self) -> Any:
        """The choice of a point, and sliders."""
        import ipywidgets

        return ipywidgets.VBox([self.choice, ipywidgets.HBox(list(self.sliders.values()))])

    def follow(self) -> None:
        """Move the controls to what has been set."""
        self.choice.value = self._point
        for name, slider in self.sliders.items():
            slider.value = self._drag[name]

    @cached_property
    def choice(self) -> Any:
        """Which feature point is dragged."""
        import ipywidgets

        move: OnMain[str] = OnMain(lambda value: self.set(point=value))
        return self.observe(ipywidgets.Dropdown(options=list(NAMES), value=self._point, description="point"), move)

    @cached_property
    def sliders(self) -> dict[str, Any]:
        """The sliders by name, ``distal_mm`` and ``radial_mm`` (ipywidgets)."""
        return {name: self.slider_of(name, value, (-MOST_MM, MOST_MM), 1.0, WORDS[name]) for name, value in self._drag.items()}
