"""A panel of lessons: a hand photographed beside a ruler that lies higher or lower than the hand."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from handlab.anatomy.records import Hand
from handlab.fitting.calibration import as_scale
from handlab.show.colours import BLUE, FAINT, INK, VERMILION
from handlab.show.figure_panel import FigurePanel
from handlab.show.figures import drawing
from handlab.studies.table_photo import RULER_MM, seen, table_photo

RULERS_MM, CAMERAS_MM = (0.0, 60.0), (250.0, 2000.0)
SIDE = 0.35  # of the camera's height: how far the side view reaches to either side


class RulerPanel(FigurePanel):
    """A photograph of ``hand``, with sliders for the heights of ruler and camera above the table in millimetres.

    ``measured_mm`` is how far apart two feature points seem by that ruler, ``true_mm`` how far apart they are, seen from straight above;
    ``error_percent`` compares them. ``set(ruler_mm=20)`` does what the slider does.
    """

    hint = "panel.set(ruler_mm=20)"

    def __init__(
        self,
        hand: Hand,
        *,
        ruler_mm: float = 0.0,
        camera_mm: float = 600.0,
        between: tuple[str, str] = ("mcp_little", "mcp_index"),
    ) -> None:
        self.hand, self.between = hand, between
        self._values = {"ruler_mm": 0.0, "camera_mm": 600.0}
        self.set(ruler_mm=ruler_mm, camera_mm=camera_mm)

    def set(self, *, ruler_mm: float | None = None, camera_mm: float | None = None) -> None:
        """Photograph it again; what is not given stays."""
        wanted = dict(self._values)
        for name, value, (low, high) in (("ruler_mm", ruler_mm, RULERS_MM), ("camera_mm", camera_mm, CAMERAS_MM)):
            if value is None:
                continue
            if not low <= float(value) <= high:
                raise ValueError(f"{name} is {value:g}; give {low:g} to {high:g}")
            wanted[name] = float(value)
        self._values = wanted
        self.photo = table_photo(self.hand, px_per_mm=2.5, ruler_mm=wanted["ruler_mm"], camera_mm=wanted["camera_mm"])
        self._refresh()

    @property
    def measured_mm(self) -> float:
        """How far apart the two points seem by the ruler."""
        a, b = (np.array(self.photo.marks_px[name]) for name in self.between)
        return float(np.linalg.norm(b - a)) * as_scale(self.photo.scale).mm_per_px

    @property
    def true_mm(self) -> float:
        """How far apart they are, seen from straight above."""
        a, b = (self.photo.marks_mm[name] for name in self.between)
        return float(np.linalg.norm((b - a)[:2]))

    @property
    def error_percent(self) -> float:
        """By how many percent the ruler is wrong about them."""
        return 100.0 * (self.measured_mm / self.true_mm - 1.0)

    def text(self) -> str:
        """The read-out."""
        a, b = self.between
        return (
            f"ruler {self._values['ruler_mm']:.0f} mm above the table, camera {self._values['camera_mm']:.0f} mm\n"
            f"{a} to {b}: {self.measured_mm:.1f} mm by the ruler, {self.true_mm:.1f} mm in truth ({self.error_percent:+.1f} %)"
        )

    def figure(self) -> Any:
        """The rays from the side, and the photograph."""
        with drawing(figsize=(16, 8)) as figure:
            left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.0))
            self._rays(left)
            right.imshow(self.photo.pixels)
            right.plot(*np.array([self.photo.marks_px[name] for name in self.between]).T, "-o", color=BLUE, markersize=9)
            right.plot(*self.photo.ruler_px.T, "--s", color=VERMILION, markersize=10)
            right.set_axis_off()
            right.set_title(f"{self.measured_mm:.1f} mm by the ruler, {self.error_percent:+.1f} %")
        return figure

    def _rays(self, axes: Any) -> None:
        camera, ruler = self._values["camera_mm"], self._values["ruler_mm"]
        marks = np.array([self.photo.marks_mm[name] for name in self.between])
        height, half = float(marks[:, 2].mean()), 0.5 * self.true_mm
        hand = np.array([[-half, height], [half, height]])
        bar = np.array([[-0.5 * RULER_MM, ruler], [0.5 * RULER_MM, ruler]])
        for ends, colour, dash, name in ((bar, VERMILION, "--", "ruler"), (hand, BLUE, "-", "hand")):
            foot = seen(np.column_stack([ends[:, 0], np.zeros(2), ends[:, 1]]), camera)[:, 0]
            for x in foot:
                axes.plot([0.0, x], [camera, 0.0], color=colour, linestyle=dash, linewidth=1.6)
            axes.plot(*ends.T, color=colour, linewidth=6.0, solid_capstyle="butt", label=f"{name}, {ends[0, 1]:.0f} mm high")
            axes.plot(foot, [0.0, 0.0], "|", color=colour, markersize=22, markeredgewidth=3)
        axes.axhline(0.0, color=INK, linewidth=2.5)
        axes.plot(0.0, camera, "v", color=INK, markersize=20)
        axes.annotate("camera", (0.0, camera), (18, 0), textcoords="offset points", va="center")
        reach = max(SIDE * camera, 0.75 * RULER_MM)
        axes.set(title="from the side: where the rays meet the table", xlabel="mm", ylabel="mm above the table")
        axes.set(xlim=(-reach, reach), ylim=(-0.06 * camera, 1.08 * camera))
        axes.legend(loc="upper left", labelcolor=FAINT, handlelength=1.4)

    def controls(self) -> Any:
        """Sliders."""
        import ipywidgets

        return ipywidgets.HBox(list(self.sliders.values()))

    def follow(self) -> None:
        """Move the sliders to what has been set."""
        for name, slider in self.sliders.items():
            slider.value = self._values[name]

    @cached_property
    def sliders(self) -> dict[str, Any]:
        """The sliders by name, ``ruler_mm`` and ``camera_mm`` (ipywidgets)."""
        kinds = {"ruler_mm": (RULERS_MM, 1.0, "ruler, mm"), "camera_mm": (CAMERAS_MM, 50.0, "camera, mm")}
        return {name: self.slider_of(name, self._values[name], *kind) for name, kind in kinds.items()}
