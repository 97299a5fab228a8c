"""A panel of lessons: masses between two walls, joined by springs, and the step of time with which they swing."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.physics.springs import leapfrog, stable_step
from handlab.show.colours import FAINT, INK, VERMILION
from handlab.show.figure_panel import FigurePanel
from handlab.show.figures import drawing, line
from handlab.show.main_thread import OnMain

MOST_MASSES = 40
STEPS_MS = (0.1, 20.0)  # of the slider
SEED = 3
PUSH = 1e-3  # m: the first disturbance
TALLEST = 1e6  # times the push: what is drawn of a chain that explodes
CALM = 30.0  # times the push: near the limit a stable chain swings out a few times as far


class SpringPanel(FigurePanel):
    """A row of ``masses`` between two walls, each of ``mass`` kg, joined by springs of ``stiffness`` N/m.

    They get a random push of a millimetre and swing for ``steps`` leapfrog steps of ``step_ms``. ``damping`` in 1/s.
    ``set(masses=2, step_ms=8)`` does what the sliders do; ``figure()`` is the plot.
    """

    hint = "panel.set(step_ms=3)"

    def __init__(
        self, masses: int = 1, *, mass: float = 1e-4, stiffness: float = 2.0, step_ms: float = 1.0, damping: float = 0.0, steps: int = 400
    ) -> None:
        self.mass, self.steps, self.damping = mass, steps, 0.0
        self._masses, self._stiffness, self._step_ms = 1, stiffness, step_ms
        self.set(masses=masses, stiffness=stiffness, step_ms=step_ms, damping=damping)

    def set(
        self, *, masses: int | None = None, step_ms: float | None = None, stiffness: float | None = None, damping: float | None = None
    ) -> None:
        """Let the chain swing again with other numbers; what is not given stays."""
        count = self._masses if masses is None else int(masses)
        if not 1 <= count <= MOST_MASSES:
            raise ValueError(f"masses is {count}; give 1 to {MOST_MASSES}")
        wanted = {"step_ms": (step_ms, self._step_ms), "stiffness": (stiffness, self._stiffness), "damping": (damping, self.damping)}
        values = {name: float(old if new is None else new) for name, (new, old) in wanted.items()}
        for name, value in values.items():
            if not np.isfinite(value) or value < 0.0 or (value == 0.0 and name != "damping"):
                raise ValueError(f"{name} is {value:g}; give {'0 or ' if name == 'damping' else ''}a positive number")
        self._masses, self._step_ms, self._stiffness, self.damping = count, values["step_ms"], values["stiffness"], values["damping"]
        self._swing()
        self._refresh()

    @property
    def masses(self) -> int:
        """How many."""
        return self._masses

    @property
    def step_ms(self) -> float:
        """Step of time, milliseconds."""
        return self._step_ms

    @property
    def matrix(self) -> Array:
        """K (n, n) N/m: 2 k on the diagonal, -k beside it."""
        n = self._masses
        result: Array = self._stiffness * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
        return result

    @property
    def limit_ms(self) -> float:
        """Largest stable step in milliseconds, 2 / omega_max."""
        return 1e3 * stable_step(float(np.sqrt(np.linalg.eigvalsh(self.matrix)[-1] / self.mass)))

    def _swing(self) -> None:
        matrix, dt = self.matrix, 1e-3 * self._step_ms
        position = PUSH * np.random.default_rng(SEED).uniform(-1.0, 1.0, self._masses)
        velocity, farthest, pattern = np.zeros_like(position), [np.abs(position).max()], position
        for _ in range(self.steps):
            position, velocity = leapfrog(position, velocity, lambda x: -(matrix @ x) / self.mass, dt, self.damping)
            farthest.append(np.abs(position).max())
            pattern = position
            if farthest[-1] > TALLEST * PUSH:
                break
        self.farthest, self.pattern = np.array(farthest), pattern

    @property
    def exploded(self) -> bool:
        """Whether the masses end much farther out than they began."""
        return bool(self.farthest[-1] > CALM * PUSH)

    def text(self) -> str:
        """The read-out."""
        lines = [f"{self.masses} masses of {1e3 * self.mass:g} g, springs of {self._stiffness:g} N/m, step {self.step_ms:.3g} ms"]
        if self.exploded:
            return "\n".join([*lines, f"after {len(self.farthest) - 1} steps: exploded"])
        return "\n".join([*lines, f"after {len(self.farthest) - 1} steps: {1e3 * self.farthest[-1]:.2g} mm from rest at most"])

    def figure(self) -> Any:
        """Where the masses end, and how far they were from rest at every step."""
        with drawing(figsize=(15, 5.5)) as figure:
            left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.2))
            size = np.abs(self.pattern).max()
            shown = np.concatenate([[0.0], self.pattern / size, [0.0]])
            left.axhline(0.0, color=FAINT, linewidth=1.2)
            left.plot(np.arange(len(shown)), shown, marker="o", markersize=13, markevery=range(1, len(shown) - 1), **line(0))
            left.set(title="where the masses are at the end", xlabel="wall  <  number of the mass  >  wall", ylabel="part of the farthest")
            left.set(ylim=(-1.25, 1.25), xticks=range(0, len(shown), max(1, len(shown) // 8)))
            height = 1e3 * np.maximum(self.farthest, 1e-9 * PUSH)
            right.semilogy(height, color=VERMILION if self.exploded else INK)
            right.set(title="EXPLODED" if self.exploded else "swings on", xlabel="step", ylabel="farthest from rest (mm)")
            right.set(ylim=(min(0.05, height.min()), max(50.0, 2.0 * height.max())))
        return figure

    def controls(self) -> Any:
        """Sliders and choices."""
        import ipywidgets

        return ipywidgets.HBox([self.masses_slider, self.step_slider])

    def follow(self) -> None:
        """Move the controls to what has been set."""
        self.masses_slider.value, self.step_slider.value = self._masses, self._step_ms

    @cached_property
    def masses_slider(self) -> Any:
        """The slider of the number of masses."""
        import ipywidgets

        slider = ipywidgets.IntSlider(value=self._masses, min=1, max=MOST_MASSES, description="masses")
        move: OnMain[int] = OnMain(lambda value: self.set(masses=value))
        return self.observe(slider, move)

    @cached_property
    def step_slider(self) -> Any:
        """The slider of the step."""
        import ipywidgets

        low, high = STEPS_MS
        slider = ipywidgets.FloatSlider(value=self._step_ms, min=low, max=high, step=0.05, description="step, ms", readout_format=".2f")
        slider.layout.width = "55%"
        move: OnMain[float] = OnMain(lambda value: self.set(step_ms=value))
        return self.observe(slider, move)
