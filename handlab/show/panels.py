"""Panels of lessons: ``MusclePanel``, a hand with a few sliders, and ``Postures``, hands side by side.

Everything a slider does, ``panel.set(FDP2=0.3)`` does too.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property, partial
from html import escape
from importlib.util import find_spec
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand, Muscle
from handlab.show.main_thread import OnMain
from handlab.show.views import view_name
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import keyframes
from handlab.simulation.play import simulate
from handlab.simulation.skeleton import contraction_of, rest
from handlab.simulation.state import State

FPS = 60.0
PICTURE_HEIGHT = 420  # pixels
# The viewer of a panel moves by the panel's sliders alone: what would start a clip or another motion beside them is put away.
BARE = "handlab-bare"
BARE_STYLE = (
    f"<style>.{BARE} .hl-clips, .{BARE} .hl-curves, .{BARE} .hl-bar.bottom {{ display: none; }} "
    f".{BARE} .hl {{ grid-template-rows: minmax(0, 1fr) !important; }}</style>"
)
MOST_SECONDS = 60.0  # of recorded motion; older ones are forgotten
VISIBLE_DEG = 0.5  # an assumption: a smaller rotation cannot be seen
OVER_TIME = ("contraction", "angle", "speed", "fibre_length", "force", "torque")


class MusclePanel:
    """Sliders for some muscles, the hand that they move, and a read-out in degrees and millimetres.

    ``muscles`` by name or abbreviation; ``hold`` joints that are held; ``seconds`` for which a change is given time to act;
    ``start`` the posture to begin with, the relaxed hand if not given. ``state`` is the hand as it stands, ``clip`` all that it
    did since the last ``reset``: ``hl.curves(panel.clip)``. Without ipywidgets everything works but the sliders.
    """

    def __init__(
        self, hand: Hand, muscles: Iterable[str], *, hold: Iterable[str] = ("wrist",), seconds: float = 1.0, start: State | None = None
    ) -> None:
        names = [muscles] if isinstance(muscles, str) else list(muscles)
        if not names:
            raise ValueError("a panel needs at least one muscle, like MusclePanel(hand, ['FDP2'])")
        self.hand = hand
        self.muscles: dict[str, Muscle] = {hand.muscles[name].abbreviation: hand.muscles[name] for name in names}
        self.hold = (hold,) if isinstance(hold, str) else tuple(hold)
        self.seconds = seconds
        self.start = rest(hand) if start is None else start
        self._past: list[Clip] = []
        self._contraction = dict.fromkeys(self.muscles, 0.0)
        self.state = self.start
        self._moving_sliders = False

    @property
    def contraction(self) -> Mapping[str, float]:
        """Contraction of every slider's muscle, by abbreviation."""
        return dict(self._contraction)

    def set(self, **changes: float) -> None:
        """Set contractions in [0, 1], such as ``set(FDP2=0.3)``, and let the hand move for ``seconds``.

        Raises ``ValueError`` for a value outside, or a muscle that has no slider here.
        """
        wanted = dict(self._contraction)
        for name, value in changes.items():
            abbreviation = self.hand.muscles[name].abbreviation
            if abbreviation not in wanted:
                raise ValueError(f"{name!r} has no slider in this panel; it has {', '.join(wanted)}")
            wanted[abbreviation] = float(contraction_of(self.hand, {name: value}).max())
        clip = simulate(self.hand, keyframes(wanted), seconds=self.seconds, fps=FPS, hold=self.hold, start=self.state)
        self._contraction = wanted
        self._past.append(clip)
        while sum(one.time[-1] for one in self._past) > MOST_SECONDS:
            del self._past[0]
        self.state = clip.states[-1]
        self._refresh()

    def reset(self) -> None:
        """All contractions zero, the hand back where it began, the record empty."""
        self._contraction = dict.fromkeys(self.muscles, 0.0)
        self._past.clear()
        self.state = self.start
        self._refresh()

    @property
    def clip(self) -> Clip:
        """What the hand did since the last ``reset`` (at most the last minute), as one recorded motion."""
        if not self._past:
            return simulate(self.hand, keyframes(self._contraction), seconds=self.seconds, fps=FPS, hold=self.hold, start=self.state)
        begin = np.cumsum([0.0, *(one.time[-1] for one in self._past[:-1])])
        # the last frame of a motion is the first of the next one
        cut = [one if k == 0 else shortened(one) for k, one in enumerate(self._past)]
        time = np.concatenate([one.time + at for one, at in zip(cut, begin, strict=True)])
        joined: dict[str, Any] = {name: np.concatenate([getattr(one, name) for one in cut]) for name in OVER_TIME}
        return replace(cut[0], time=time, **joined)

    @property
    def moved(self) -> dict[str, float]:
        """How far every rotation that visibly changed has come since ``start``, in degrees by name."""
        by = np.rad2deg(self.state.angle - self.start.angle)
        return {name: float(one) for name, one in zip(self.hand.dof_names, by, strict=True) if abs(one) > VISIBLE_DEG}

    def text(self) -> str:
        """The read-out: what has moved, and the fibre lengths of the muscles that have sliders."""
        moved = [f"{name}: {by:+.1f} degrees" for name, by in self.moved.items()] or ["no joint has moved"]
        fibres = [f"{name}: fibre {1000 * now:.1f} mm, at rest {1000 * slack:.1f} mm" for name, now, slack in self.lengths()]
        return "\n".join([*moved, *fibres])

    def lengths(self) -> list[tuple[str, float, float]]:
        """(abbreviation, fibre length, resting length) of the muscles that have sliders, metres."""
        rows = [self.hand.muscle_names.index(muscle.name) for muscle in self.muscles.values()]
        now: Array = self.state.fibre_length
        return [(name, float(now[k]), float(self.hand.rest_length[k])) for name, k in zip(self.muscles, rows, strict=True)]

    def __repr__(self) -> str:
        """The read-out."""
        held = f", {' '.join(self.hold)} held" if self.hold else ""
        return f"MusclePanel of {', '.join(self.muscles)}{held}\n{self.text()}"

    @cached_property
    def sliders(self) -> dict[str, Any]:
        """One slider for each muscle, by abbreviation (ipywidgets)."""
        import ipywidgets

        made = {}
        for name, muscle in self.muscles.items():
            slider = ipywidgets.FloatSlider(
                value=self._contraction[name], min=0.0, max=1.0, step=0.01, description=name, tooltip=muscle.latin
            )
            self._follow(slider, OnMain(partial(self._slid, name)))
            made[name] = slider
        return made

    @staticmethod
    def _follow(slider: Any, move: OnMain[float]) -> None:
        slider.observe(lambda change: move(change["new"]), "value")

    def _slid(self, name: str, value: float) -> None:
        if self._moving_sliders:
            return
        try:
            self.set(**{name: value})
        except Exception as error:
            self._readout.value = f"<b>{escape(str(error))}</b>"
            raise

    @cached_property
    def widget(self) -> Any:
        """The panel as one widget: the hand, its sliders, the read-out."""
        import ipywidgets

        again = ipywidgets.Button(description="Relax", tooltip="All contractions to zero, the hand back where it began")
        back: OnMain[Any] = OnMain(lambda _: self.reset())
        again.on_click(back)
        controls = ipywidgets.VBox([*self.sliders.values(), again, self._readout])
        picture = self._picture.widget
        picture.layout.width, controls.layout.width = "55%", "45%"
        self._refresh()
        return ipywidgets.HBox([picture, controls, ipywidgets.HTML(BARE_STYLE)])

    @cached_property
    def _readout(self) -> Any:
        import ipywidgets

        return ipywidgets.HTML()

    @cached_property
    def _picture(self) -> Any:
        return picture_of(self.hand, self.start)

    def _refresh(self) -> None:
        if "sliders" in self.__dict__:
            self._moving_sliders = True
            try:
                for name, slider in self.sliders.items():
                    slider.value = self._contraction[name]
            finally:
                self._moving_sliders = False
        if "_readout" in self.__dict__:
            self._readout.value = "<br>".join(escape(line) for line in self.text().splitlines())
        if "_picture" in self.__dict__:
            self._picture.show(self.state)

    def _repr_mimebundle_(self, **how: Any) -> Any:
        try:
            return self.widget._repr_mimebundle_(**how)
        except ImportError:
            first = next(iter(self.muscles))
            return {"text/plain": f"{self!r}\nFor sliders: pip install 'handlab[lab]'. Without them: panel.set({first}=0.3)"}


def shortened(clip: Clip) -> Clip:
    """A clip without its first frame."""
    later: dict[str, Any] = {name: getattr(clip, name)[1:] for name in ("time", *OVER_TIME)}
    return replace(clip, **later)


class Postures:
    """States of a hand beside each other, by title: ``Postures(hand, {"zero": zero, "relaxed": hl.rest(hand)}, view="radial")``."""

    def __init__(self, hand: Hand, states: Mapping[str, State], *, view: str = "palm") -> None:
        self.hand = hand
        self.states = dict(states)
        self.view = view_name(view)

    def __repr__(self) -> str:
        """The titles."""
        return f"Postures from {self.view}: {', '.join(self.states)}"

    @cached_property
    def widget(self) -> Any:
        """All of them as one widget; each can be turned by itself."""
        import ipywidgets

        columns = []
        for title, state in self.states.items():
            picture = picture_of(self.hand, state, self.view)
            picture.show(state)
            column = ipywidgets.VBox([ipywidgets.HTML(f"<b>{escape(title)}</b>"), picture.widget])
            column.layout.width = f"{100 // len(self.states)}%"
            columns.append(column)
        return ipywidgets.HBox([*columns, ipywidgets.HTML(BARE_STYLE)])

    def _repr_mimebundle_(self, **how: Any) -> Any:
        try:
            return self.widget._repr_mimebundle_(**how)
        except ImportError:
            return {"text/plain": f"{self!r}\nTo see them: pip install 'handlab[lab]', or hl.sheet(hand, states)"}


def picture_of(hand: Hand, state: State, view: str = "palm") -> Any:
    """What shows the hand: the live viewer without its own sliders, or, where anywidget is missing, drawn pictures.

    Both have ``widget`` and ``show(state)``.
    """
    if find_spec("anywidget") is None:
        from handlab.show.picture_widget import PictureWidget

        return PictureWidget(hand, view=view)
    from handlab.show.widget import HandView

    shown = HandView(hand, state, height=PICTURE_HEIGHT, panels=False, view=view)
    shown.widget.add_class(BARE)
    return shown
