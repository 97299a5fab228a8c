"""A panel of lessons: a hand of any size beside the reference hand, what the laws of growth expect of it, and how it moves."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from handlab.anatomy.records import Hand
from handlab.fitting.enlarged import enlarged
from handlab.fitting.warp import MECHANICS, Mechanics
from handlab.show.colours import BLACK, BLUE, FAINT, ORANGE
from handlab.show.figure_panel import FigurePanel
from handlab.show.figures import drawing, line
from handlab.show.main_thread import OnMain
from handlab.studies import size as study

SIZES = (0.5, 1.5)
POWERS = {"length": 1, "force": 2, "torque": 3, "inertia": 5, "half time": 1}
SHOWN = 0.12  # s of the motion


class SizePanel(FigurePanel):
    """``hand`` times ``size`` under the same contraction: both deep flexors of the index finger at 30 percent, wrist held.

    ``mechanics``: "scaled", muscles and masses grow with the hand, or "kept", they stay as they are, as in the paper. ``ratios`` has what
    length, force, torque, inertia and the time to half way are, over those of the reference hand. ``set(size=0.7)`` does what the slider
    does.
    """

    hint = "panel.set(size=0.7)"

    def __init__(self, hand: Hand, *, size: float = 1.0, mechanics: Mechanics = "scaled") -> None:
        self.hand = hand
        self._path, self._before = study.path(hand), self._measure(hand)
        self._size, self._mechanics = 1.0, mechanics
        self.set(size=size, mechanics=mechanics)

    @staticmethod
    def _measure(hand: Hand) -> dict[str, float]:
        return {**study.strengths(hand), "half time": study.half_time(hand)}

    def set(self, *, size: float | None = None, mechanics: Mechanics | None = None) -> None:
        """Make the hand again; what is not given stays."""
        wanted = self._size if size is None else float(size)
        if not SIZES[0] <= wanted <= SIZES[1]:
            raise ValueError(f"size is {wanted:g}; give {SIZES[0]:g} to {SIZES[1]:g}")
        how = self._mechanics if mechanics is None else mechanics
        self.other = enlarged(self.hand, wanted, mechanics=how)
        self._size, self._mechanics = wanted, how
        after = self._measure(self.other)
        self.ratios = {name: after[name] / self._before[name] for name in POWERS}
        self._refresh()

    @property
    def size(self) -> float:
        """How many times as long as the reference hand."""
        return self._size

    @property
    def mechanics(self) -> Mechanics:
        """Whether muscles and masses grew along."""
        return self._mechanics

    def text(self) -> str:
        """The read-out."""
        rows = [f"{name} × {ratio:.3f} (law of growth: {self._size ** POWERS[name]:.3f})" for name, ratio in self.ratios.items()]
        return "\n".join([f"size L = {self._size:g}, mechanics {self._mechanics}", *rows])

    def figure(self) -> Any:
        """Ratios beside the laws of growth, and the knuckle over time."""
        with drawing(figsize=(16, 7)) as figure:
            left, right = figure.subplots(1, 2)
            at = np.arange(len(POWERS))
            bars = left.barh(at, list(self.ratios.values()), 0.55, color=BLUE, zorder=2, label="this hand")
            left.bar_label(bars, [f"{ratio:.2f}" for ratio in self.ratios.values()], padding=18)
            laws = [self._size**power for power in POWERS.values()]
            left.plot(laws, at, "D", color=ORANGE, markeredgecolor=BLACK, markersize=13, linestyle="", zorder=4, label="law of growth")
            left.axvline(1.0, color=BLACK, linewidth=1.5, linestyle=":")
            left.set_yticks(at, [f"{name}, L{'' if power == 1 else '²³⁴⁵'[power - 2]}" for name, power in POWERS.items()])
            left.set(title=f"L = {self._size:g}, mechanics {self._mechanics}", xlabel="times the reference hand")
            left.set(xlim=(0.0, 1.75 * max(*laws, *self.ratios.values(), 1.0)))
            left.invert_yaxis()
            left.legend(loc="upper right", labelcolor=FAINT, handlelength=1.6)
            for k, (name, hand, (time, angle)) in enumerate(
                (("reference", self.hand, self._path), (f"{self._size:g} times as large", self.other, study.path(self.other)))
            ):
                right.plot(1e3 * time, np.rad2deg(angle), label=name, **line(k))
                half = study.half_time(hand)
                right.plot(1e3 * half, np.rad2deg(np.interp(half, time, angle)), "os"[k], color=line(k)["color"], markersize=14)
            right.set(title="index knuckle (MCP), marks: half way", xlabel="ms", ylabel="degrees", xlim=(0.0, 1e3 * SHOWN))
            right.legend(loc="lower right")
        return figure

    def controls(self) -> Any:
        """The slider and the choice."""
        import ipywidgets

        return ipywidgets.HBox([self.slider, self.choice])

    def follow(self) -> None:
        """Move the controls to what has been set."""
        self.slider.value, self.choice.value = self._size, self._mechanics

    @cached_property
    def slider(self) -> Any:
        """The slider of the size."""
        import ipywidgets

        low, high = SIZES
        slider = ipywidgets.FloatSlider(value=self._size, min=low, max=high, step=0.05, description="size", continuous_update=False)
        slider.layout.width = "55%"
        move: OnMain[float] = OnMain(lambda value: self.set(size=value))
        return self.observe(slider, move)

    @cached_property
    def choice(self) -> Any:
        """Which mechanics."""
        import ipywidgets

        move: OnMain[Mechanics] = OnMain(lambda value: self.set(mechanics=value))
        return self.observe(ipywidgets.Dropdown(options=list(MECHANICS), value=self._mechanics, description="mechanics"), move)
