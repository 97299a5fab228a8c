"""A panel of lessons: one bone, one muscle, and the step of time with which its motion is computed."""

from __future__ import annotations

from functools import cached_property
from typing import Any, get_args

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.physics.muscle import muscle_force
from handlab.physics.one_bone import RULES, Motion, Rule, march
from handlab.physics.rotation import largest_step
from handlab.show.colours import FAINT, INK
from handlab.show.figure_panel import FigurePanel
from handlab.show.figures import drawing, line
from handlab.show.main_thread import OnMain
from handlab.simulation.mechanics import moments_of_inertia
from handlab.simulation.skeleton import pose

FINEST = 1.0 / 40.0  # step of the reference curve, in units of J / mu
BEHIND = {"facecolor": "white", "edgecolor": "none", "alpha": 0.9, "pad": 2.0}  # of words that a curve may cross
TOO_FAST = 3.0  # an overshooting step at the edge of what is stable reaches twice the right speed
LOG_STEPS = (-1.0, 1.5)  # of the slider: 0.1 ms to 30 ms


class StepPanel(FigurePanel):
    """A finger held straight beyond one joint, a muscle that pulls for half of the time, and sliders for step and rule.

    ``dof`` the rotation, ``muscle`` what turns it with ``contraction`` (0 to 1) until ``seconds`` / 2; ``rule`` one of
    ``handlab.physics.one_bone.RULES``. ``set(step_ms=3, rule="explicit")`` does what the sliders do; ``figure()`` is the plot.
    """

    hint = "panel.set(step_ms=3)"

    def __init__(
        self,
        hand: Hand,
        dof: str = "mcp2.flexion_extension",
        muscle: str = "FDP2",
        *,
        contraction: float = 0.1,
        seconds: float = 0.1,
        step_ms: float = 0.1,
        rule: Rule = "implicit",
    ) -> None:
        self.hand, self.seconds, self.contraction = hand, seconds, contraction
        self.dof, self.muscle = hand.dofs[dof], hand.muscles[muscle]
        straight = pose(hand, dict.fromkeys(hand.moving_names, 0.0))
        row, column = hand.muscle_names.index(self.muscle.name), hand.dof_names.index(self.dof.name)
        self.inertia = float(moments_of_inertia(hand, straight.angle)[column])
        self.friction = float(np.broadcast_to(hand.friction, len(hand.dof_names))[column])
        self.arm = float(hand.lever_arm[row, column])
        if self.arm == 0.0:
            raise ValueError(f"{self.muscle.abbreviation} has no lever arm at {self.dof.name!r}; choose another muscle or rotation")
        self._force, self._length = float(hand.max_force[row]), self.muscle.rest_length
        self._rule, self._step_ms = rule, step_ms
        self.set(step_ms=step_ms, rule=rule)

    @property
    def limit_ms(self) -> float:
        """2 J / mu in milliseconds."""
        return 1e3 * float(largest_step(self.inertia, self.friction))

    @property
    def step_ms(self) -> float:
        """Step of time, milliseconds."""
        return self._step_ms

    @property
    def rule(self) -> Rule:
        """Name of the rule."""
        return self._rule

    def torque(self, time: float, angle: float) -> float:
        """Of the muscle alone, N m."""
        pull = self.contraction if time < 0.5 * self.seconds - 1e-12 else 0.0
        return self.arm * float(muscle_force(pull, 1.0 - self.arm * angle / self._length, self._force))

    def set(self, *, step_ms: float | None = None, rule: Rule | None = None) -> None:
        """Compute the motion again with another step, another rule, or both."""
        step = self._step_ms if step_ms is None else float(step_ms)
        motion = self._march(self._rule if rule is None else rule, 1e-3 * step)
        self.motion, self._step_ms, self._rule = motion, step, self._rule if rule is None else rule
        self._refresh()

    def _march(self, rule: Rule, dt: float) -> Motion:
        return march(rule, self.torque, self.inertia, self.friction, dt, self.seconds)

    @cached_property
    def reference(self) -> Motion:
        """The same motion with a step far below J / mu."""
        return self._march("leapfrog", self.seconds / round(self.seconds / (FINEST * self.inertia / self.friction)))

    @property
    def ran_away(self) -> float | None:
        """When (seconds) the bone was more than three times as fast as it ever is with tiny steps; ``None``: never."""
        fast = np.abs(self.motion.speed) > TOO_FAST * np.abs(self.reference.speed).max()
        return float(self.motion.time[int(np.argmax(fast))]) if fast.any() else None

    def text(self) -> str:
        """The read-out."""
        end, right = np.rad2deg(self.motion.angle[-1]), np.rad2deg(self.reference.angle[-1])
        lines = [f"{self.rule}: {RULES[self.rule]}", f"step {self.step_ms:.3g} ms; 2J/mu is {self.limit_ms:.3g} ms"]
        if self.ran_away is not None:
            lines.append(f"the bone has run away: after {1e3 * self.ran_away:.3g} ms it is more than {TOO_FAST:g} times too fast")
        else:
            lines.append(f"after {1e3 * self.seconds:g} ms: {end:.2f} degrees (tiny steps: {right:.2f})")
        return "\n".join(lines)

    def __repr__(self) -> str:
        """The read-out."""
        return f"StepPanel of {self.dof.name}, {self.muscle.abbreviation} at {self.contraction:g}\n{self.text()}"

    def figure(self) -> Any:
        """Angle and speed over time, with tiny steps and with the step of the panel."""
        with drawing(figsize=(15, 6)) as figure:
            axes = figure.subplots(1, 2)
            for panel, name in zip(axes, ("angle", "speed"), strict=True):
                unit = "degrees" if name == "angle" else "degrees per second"
                right, own = np.rad2deg(getattr(self.reference, name)), np.rad2deg(getattr(self.motion, name))
                panel.plot(1e3 * self.reference.time, right, color="0.3", linewidth=2.0, linestyle=":", label="tiny steps")
                self._own(panel, own, right)
                panel.set(title=name, xlabel="time (ms)", ylabel=unit, xlim=(0.0, 1e3 * self.seconds))
            axes[0].legend(loc="upper left", frameon=True, facecolor="white", framealpha=0.9, edgecolor="none")
            how = {"transform": axes[0].get_xaxis_transform(), "va": "bottom", "fontsize": 13, "color": INK, "bbox": BEHIND}
            axes[0].text(490.0 * self.seconds, 0.02, f"{self.muscle.abbreviation} pulls ", ha="right", **how)
            axes[0].text(510.0 * self.seconds, 0.02, " lets go", ha="left", **how)
            note = f"step {self.step_ms:.3g} ms,  2J/µ = {self.limit_ms:.3g} ms"
            figure.suptitle(note if self.ran_away is None else f"{note}:  RUN AWAY", fontsize=17)
        return figure

    def _own(self, panel: Any, own: Array, right: Array) -> None:
        room = np.ptp(right)
        low, high = float(right.min() - room), float(right.max() + room)
        marker = "o" if len(own) < 80 else ""
        shown = np.clip(own, low - 9.0 * room, high + 9.0 * room)  # a drawing program stumbles over 1e12
        panel.plot(1e3 * self.motion.time, shown, label=f"{self.rule}, {self.step_ms:.3g} ms", marker=marker, markersize=7, **line(1))
        panel.set_ylim(low, high)
        panel.axvline(500.0 * self.seconds, color=FAINT, linewidth=1.2)

    def controls(self) -> Any:
        """Sliders and choices."""
        import ipywidgets

        return ipywidgets.HBox([self.step_slider, self.rule_choice])

    def follow(self) -> None:
        """Move the controls to what has been set."""
        self.step_slider.value, self.rule_choice.value = self._step_ms, self._rule

    @cached_property
    def step_slider(self) -> Any:
        """The slider of the step, on a logarithmic scale."""
        import ipywidgets

        low, high = LOG_STEPS
        slider = ipywidgets.FloatLogSlider(
            value=self._step_ms, base=10, min=low, max=high, step=0.02, description="step, ms", readout_format=".2f"
        )
        slider.layout.width = "45%"
        move: OnMain[float] = OnMain(lambda value: self.set(step_ms=value))
        return self.observe(slider, move)

    @cached_property
    def rule_choice(self) -> Any:
        """The choice of the rule."""
        import ipywidgets

        choice = ipywidgets.ToggleButtons(options=list(get_args(Rule)), value=self._rule, style={"button_width": "6em"})
        move: OnMain[Rule] = OnMain(lambda value: self.set(rule=value))
        return self.observe(choice, move)
