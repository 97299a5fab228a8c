"""A panel of lessons: a joint that bends, cut lengthwise, with the skin worn in different ways."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show.colours import FAINT, INK, IVORY
from handlab.show.figure_panel import FigurePanel
from handlab.show.figures import drawing, line
from handlab.show.main_thread import OnMain
from handlab.simulation.kinematics import posed_bone, relative_transforms
from handlab.simulation.skeleton import pose
from handlab.studies import knuckle
from handlab.studies.places import joint_place

SHOWN = 0.030  # m to either side of the joint
WAYS = ("linear", "blend", "springs")
MEASURES = ("volume of the piece", "ink on the back", "ink on the palm side")


class KnucklePanel(FigurePanel):
    """A joint such as ``"pip2"`` in a hand that is straight otherwise, with a slider for its flexion in degrees.

    ``measured`` has, for every way to wear the skin, the volume of the piece around the joint and the lengths of lines of ink on the
    dorsal and palmar skin, each in percent of those of the straight finger. ``set(bend_deg=45)`` does what the slider does.
    """

    hint = "panel.set(bend_deg=45)"

    def __init__(self, hand: Hand, joint: str = "pip2", *, bend_deg: float = 90.0) -> None:
        self.hand, self.joint = hand, joint
        self.dof = hand.dofs[f"{joint}.flexion_extension"]
        self._piece = knuckle.piece(hand, joint)
        self._ink = {side: knuckle.ink(hand, joint, side) for side in ("dorsal", "palmar")}
        self._straight = {way: self._numbers(knuckle.worn(hand, self._state(0.0), way)) for way in WAYS}
        self.set(bend_deg=bend_deg)

    def _state(self, degrees: float) -> Any:
        return pose(self.hand, dict.fromkeys(self.hand.moving_names, 0.0) | {self.dof.name: float(np.deg2rad(degrees))})

    def _numbers(self, skin: Array) -> Array:
        lengths = [knuckle.ink_length(skin, self._ink[side]) for side in ("dorsal", "palmar")]
        return np.array([knuckle.piece_volume(skin, self._piece), *lengths])

    @property
    def limits_deg(self) -> tuple[float, float]:
        """How far the slider goes."""
        low, high = np.rad2deg(self.hand.limits[self.hand.dof_names.index(self.dof.name)])
        return max(0.0, float(low)), float(high)

    @property
    def bend_deg(self) -> float:
        """Flexion, degrees."""
        return self._bend_deg

    def set(self, *, bend_deg: float) -> None:
        """Bend the joint."""
        low, high = self.limits_deg
        if not low - 1e-6 <= float(bend_deg) <= high + 1e-6:
            raise ValueError(f"bend_deg is {bend_deg:g}; {self.dof.name} can be bent from {low:g} to {high:g} degrees here")
        self._bend_deg = float(bend_deg)
        self.state = self._state(self._bend_deg)
        self.skin = {way: knuckle.worn(self.hand, self.state, way) for way in WAYS}
        self.measured = {way: 100.0 * self._numbers(self.skin[way]) / self._straight[way] for way in WAYS}
        self._refresh()

    def text(self) -> str:
        """The read-out."""
        rows = [
            f"{way}: " + ", ".join(f"{name} {value:.1f} %" for name, value in zip(MEASURES, self.measured[way], strict=True))
            for way in WAYS
        ]
        return "\n".join([f"{self.joint} bent by {self.bend_deg:.0f} degrees, in percent of the straight finger", *rows])

    def _plane(self) -> tuple[Array, Array, Array]:
        """Middle (3,) of the joint, normal (3,) of the cut, and the two directions (3, 2) of the picture: distal, palmar."""
        place = joint_place(self.hand, self.joint)
        moved = relative_transforms(self.hand, self.state.angle)[self.hand.body_names.index(self.hand.joints[self.joint].parent)]
        turn = moved[:3, :3]
        normal, distal = turn @ place.flexion, turn @ place.distal
        return turn @ place.centre + moved[:3, 3], normal, np.stack([distal, np.cross(normal, distal)], axis=1)

    def figure(self) -> Any:
        """The section, and bars for the three measures."""
        with drawing(figsize=(16, 7)) as figure:
            left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
            centre, normal, across = self._plane()
            for name, bone in self.hand.bones.items():
                for ring in knuckle.section(posed_bone(self.hand, name, self.state.angle), bone.faces, centre, normal):
                    left.fill(*(1e3 * (ring - centre) @ across).T, facecolor=IVORY, edgecolor=FAINT, linewidth=1.0, zorder=1)
            for k, way in enumerate(WAYS):
                for i, ring in enumerate(knuckle.section(self.skin[way], self.hand.skin.faces, centre, normal)):
                    closed = 1e3 * (np.vstack([ring, ring[:1]]) - centre) @ across
                    left.plot(*closed.T, label=way if i == 0 else None, zorder=2 + k, **line(k))
                for side in ("dorsal", "palmar"):
                    dots = 1e3 * (knuckle.ink_points(self.skin[way], self._ink[side])[[0, -1]] - centre) @ across
                    left.plot(*dots.T, "o^s"[k], color=line(k)["color"], markersize=10, zorder=9)
            reach = 1e3 * SHOWN
            left.set(title=f"{self.joint} at {self.bend_deg:.0f} degrees, cut lengthwise; marks end the ink", aspect="equal")
            left.set(xlabel="mm, distal to the right", ylabel="mm, palmar upward", xlim=(-reach, reach), ylim=(-0.75 * reach, 1.1 * reach))
            left.legend(loc="lower right")
            self._bars(right)
        return figure

    def _bars(self, axes: Any) -> None:
        wide = 0.26
        for k, way in enumerate(WAYS):
            at = np.arange(len(MEASURES)) + (k - 1) * wide
            bars = axes.barh(
                at, self.measured[way], 0.9 * wide, color=line(k)["color"], hatch=("", "//", "..")[k], edgecolor="white", zorder=2
            )
            axes.bar_label(bars, [f"{way} {value:.0f}" for value in self.measured[way]], padding=4, fontsize=13)
        axes.axvline(100.0, color=INK, linewidth=1.5, linestyle=":", zorder=3)
        axes.set(yticks=range(len(MEASURES)), yticklabels=[name.replace(" ", "\n", 1) for name in MEASURES], xlim=(0.0, 205.0))
        axes.set(title="compared with the straight finger", xlabel="percent")
        axes.invert_yaxis()

    def controls(self) -> Any:
        """Sliders and choices."""
        return self.slider

    def follow(self) -> None:
        """Move the controls to what has been set."""
        self.slider.value = self._bend_deg

    @cached_property
    def slider(self) -> Any:
        """The slider of the flexion; it acts when it is let go, for springs take a moment."""
        import ipywidgets

        low, high = self.limits_deg
        slider = ipywidgets.FloatSlider(
            value=self._bend_deg, min=low, max=high, step=5.0, description="bend, deg", readout_format=".0f", continuous_update=False
        )
        slider.layout.width = "60%"
        move: OnMain[float] = OnMain(lambda value: self.set(bend_deg=value))
        return self.observe(slider, move)
