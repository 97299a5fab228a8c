"""A panel of lessons: a finger as a chain of bodies, its bends, and its moment of inertia about the first joint."""

from __future__ import annotations

from functools import cached_property, partial
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show.colours import BLACK, BLUE, FAINT, GREEN, IVORY, ORANGE
from handlab.show.figure_panel import FigurePanel
from handlab.show.figures import drawing
from handlab.show.main_thread import OnMain
from handlab.simulation.inertia_tables import from_tables, inertia_tables, tensor_inertia
from handlab.simulation.kinematics import posed_axes
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skeleton import centres_of_mass

JOINTS = ("mcp", "pip", "dip")
KG_MM2 = 1e6
TIP = 1.9  # of the way from the last joint to the centre of the last body: where the fingertip is drawn


class ChainPanel(FigurePanel):
    """A finger (2 index to 5 little) with sliders for its PIP and DIP joints; ``set(pip_deg=45, dip_deg=30)`` does the same.

    ``inertia`` is its moment of inertia about the MCP axis (kg m^2) from the tensors, ``linear`` and ``nearest`` are what tables in
    steps of ``step_deg`` say. ``figure()`` draws the chain and the three of them over the PIP angle.
    """

    hint = "panel.set(pip_deg=45)"

    def __init__(self, hand: Hand, finger: int = 2, *, pip_deg: float = 0.0, dip_deg: float = 0.0, step_deg: float = 5.0) -> None:
        self.hand, self.finger, self.step_deg = hand, finger, step_deg
        self.columns = [hand.moving_names.index(hand.dofs[f"{joint}{finger}.flexion_extension"].name) for joint in JOINTS]
        self._y = np.array(mechanics(hand).relaxed)
        self._tables = inertia_tables(hand, step=float(np.deg2rad(step_deg)))
        self.set(pip_deg=pip_deg, dip_deg=dip_deg)

    def set(self, *, pip_deg: float | None = None, dip_deg: float | None = None) -> None:
        """Bend the finger: degrees, within the limits of its joints."""
        for column, value in zip(self.columns[1:], (pip_deg, dip_deg), strict=True):
            if value is None:
                continue
            low, high = np.rad2deg(mechanics(self.hand).limits[column])
            if not low - 1e-6 <= float(value) <= high + 1e-6:
                raise ValueError(f"{self.hand.moving_names[column]} is {value:g} degrees; its limits are {low:g} to {high:g} degrees")
            self._y[column] = np.deg2rad(float(value))
        self._refresh()

    @property
    def angles_deg(self) -> tuple[float, float]:
        """PIP and DIP angle, degrees."""
        pip, dip = np.rad2deg(self._y[self.columns[1:]])
        return float(pip), float(dip)

    @property
    def inertia(self) -> float:
        """About the MCP axis, from the tensors, kg m^2."""
        return float(tensor_inertia(self.hand, self._y)[self.columns[0]])

    @property
    def linear(self) -> float:
        """The same from the table, linear between entries."""
        return float(from_tables(self.hand, self._y, tables=self._tables)[self.columns[0]])

    @property
    def nearest(self) -> float:
        """The same from the nearest entry of the table."""
        return float(from_tables(self.hand, self._y, nearest=True, tables=self._tables)[self.columns[0]])

    def text(self) -> str:
        """The read-out."""
        pip, dip = self.angles_deg
        exact = self.inertia
        lines = [f"PIP {pip:.0f}, DIP {dip:.0f} degrees: J about the MCP axis is {KG_MM2 * exact:.2f} kg mm^2"]
        for name, value in (("linear", self.linear), ("nearest", self.nearest)):
            lines.append(f"table in steps of {self.step_deg:g} degrees, {name}: {KG_MM2 * value:.2f} ({value / exact - 1.0:+z.2%})")
        return "\n".join(lines)

    def __repr__(self) -> str:
        """The read-out."""
        return f"ChainPanel of finger {self.finger}\n{self.text()}"

    def over_pip(self) -> tuple[Array, Array]:
        """PIP angles (n,) in degrees over its whole range, and J (n, 3) about the MCP axis there: tensors, linear, nearest; kg m^2."""
        column = self.columns[1]
        y = self._y.copy()
        low, high = mechanics(self.hand).limits[column]
        angles = np.linspace(low, high, 221)
        rows = []
        for y[column] in angles:
            rows.append(
                [
                    tensor_inertia(self.hand, y)[self.columns[0]],
                    from_tables(self.hand, y, tables=self._tables)[self.columns[0]],
                    from_tables(self.hand, y, nearest=True, tables=self._tables)[self.columns[0]],
                ]
            )
        return np.rad2deg(angles), np.array(rows)

    def chain(self) -> tuple[Array, Array, Array]:
        """The finger in its plane: joints and fingertip (4, 2) and centres of mass (3, 2) in metres from the MCP joint, masses (3,)."""
        angle = coupled(self.hand, self._y)
        axes, anchors = posed_axes(self.hand, angle)
        dofs = [self.hand.dof_names.index(f"{joint}{self.finger}.flexion_extension") for joint in JOINTS]
        bodies = [self.hand.body_names.index(f"{name}_phalanx_{self.finger}") for name in ("proximal", "middle", "distal")]
        centres = centres_of_mass(self.hand, angle)[bodies]
        joints = anchors[dofs]
        tip = joints[-1] + TIP * (centres[-1] - joints[-1])
        along = joints[1] - joints[0]
        along -= along @ axes[dofs[0]] * axes[dofs[0]]
        along /= np.linalg.norm(along)
        across = np.cross(axes[dofs[0]], along)
        plane = np.stack([along, across], axis=1)
        mass = mechanics(self.hand).mass[bodies]
        return (np.vstack([joints, tip]) - joints[0]) @ plane, (centres - joints[0]) @ plane, mass

    def figure(self) -> Any:
        """The chain with its centres of mass, and J over the PIP angle."""
        with drawing(figsize=(16, 6.5)) as figure:
            left, right = figure.subplots(1, 2, width_ratios=(0.8, 1.0))
            self._chain(left)
            angles, values = self.over_pip()
            styles = ((BLACK, "-", "tensors"), (BLUE, "--", "table, linear"), (ORANGE, "-", "table, nearest"))
            for k in (2, 0, 1):
                colour, dash, label = styles[k]
                right.plot(angles, KG_MM2 * values[:, k], color=colour, linestyle=dash, label=label, linewidth=3.0 if k else 4.5)
            pip, dip = self.angles_deg
            right.plot(pip, KG_MM2 * self.inertia, "o", color=BLACK, markersize=13, zorder=5)
            right.set(title=f"J about the MCP axis, DIP at {dip:.0f} degrees", xlabel="PIP angle (degrees)", ylabel="kg mm²")
            right.legend(loc="upper right")
        return figure

    def _chain(self, axes: Any) -> None:
        joints, centres, mass = (1e3 * self.chain()[0], 1e3 * self.chain()[1], 1e3 * self.chain()[2])
        axes.plot(*joints.T, color=IVORY, linewidth=16, solid_capstyle="round", solid_joinstyle="round", zorder=1)
        axes.plot(*joints[:3].T, "o", color=BLACK, markersize=9, zorder=3)
        rods = np.diff(joints, axis=0) / np.linalg.norm(np.diff(joints, axis=0), axis=1, keepdims=True)
        outside = 30.0 * np.stack([rods[:, 1], -rods[:, 0]], axis=1)  # labels stand on the back of the finger, where nothing bends to
        corner = 0.5 * (outside + outside[[0, 0, 1]])
        beside = {"textcoords": "offset points", "ha": "center", "va": "center", "fontsize": 13}
        for centre, grams, away in zip(centres, mass, outside, strict=True):
            axes.plot([0.0, centre[0]], [0.0, centre[1]], color=FAINT, linewidth=1.5, linestyle="--", zorder=2)
            axes.plot(*centre, "s", color=GREEN, markersize=6.0 + 5.0 * np.sqrt(grams), zorder=4)
            axes.annotate(f"{grams:.1f} g", centre, away, **beside)
        for joint, name, away in zip(joints, ("MCP", "PIP", "DIP"), corner, strict=False):
            axes.annotate(name, joint, away, **beside)
        reach = 1.15 * float(np.abs(1e3 * self._straight).max())
        axes.set(title="the chain", xlabel="mm", ylabel="mm, palmar upward", xlim=(-0.3 * reach, reach), ylim=(-0.25 * reach, 0.75 * reach))
        axes.set_aspect("equal")

    @cached_property
    def _straight(self) -> Array:
        kept = self._y.copy()
        self._y[self.columns[1:]] = 0.0
        straight = self.chain()[0]
        self._y[:] = kept
        return straight

    def controls(self) -> Any:
        """Sliders and choices."""
        import ipywidgets

        return ipywidgets.HBox(list(self.sliders.values()))

    def follow(self) -> None:
        """Move the controls to what has been set."""
        for slider, value in zip(self.sliders.values(), self.angles_deg, strict=True):
            slider.value = value

    @cached_property
    def sliders(self) -> dict[str, Any]:
        """The sliders by name, ``pip_deg`` and ``dip_deg`` (ipywidgets)."""
        import ipywidgets

        made = {}
        for name, column, value in zip(("pip_deg", "dip_deg"), self.columns[1:], self.angles_deg, strict=True):
            low, high = np.rad2deg(mechanics(self.hand).limits[column])
            slider = ipywidgets.FloatSlider(value=value, min=low, max=high, step=1.0, description=name[:3].upper(), continuous_update=False)
            made[name] = self.observe(slider, OnMain(partial(self._slid, name)))
        return made

    def _slid(self, name: str, value: float) -> None:
        self.set(**{name: value})
