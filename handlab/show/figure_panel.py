"""What the panels of lessons share: controls, the figure that they change, and a read-out."""

from __future__ import annotations

import io
from abc import ABC, abstractmethod
from functools import cached_property
from html import escape
from typing import Any

from handlab.show.main_thread import OnMain

DPI = 90  # the picture fills the width of a cell: fewer dots look soft there, more make a drag of a slider slow


class FigurePanel(ABC):
    """A panel with ``figure()`` and ``text()``; its own ``set(**changes)`` ends with ``_refresh()``.

    ``hint`` says what to write where there are no widgets.
    """

    hint = ""
    set: Any
    _following = False  # sliders are being moved along; they must not compute everything again

    @abstractmethod
    def figure(self) -> Any:
        """The plot (matplotlib)."""

    @abstractmethod
    def text(self) -> str:
        """The read-out."""

    @abstractmethod
    def controls(self) -> Any:
        """Sliders and choices (ipywidgets)."""

    @abstractmethod
    def follow(self) -> None:
        """Move the controls to what has been set."""

    def __repr__(self) -> str:
        """The read-out."""
        return f"{type(self).__name__}\n{self.text()}"

    def observe(self, control: Any, move: OnMain[Any]) -> Any:
        """Let a control act when a person moves it; returns it."""
        control.observe(lambda change: None if self._following else move(change["new"]), "value")
        return control

    def slider_of(self, name: str, value: float, span: tuple[float, float], step: float, text: str) -> Any:
        """A slider from ``span[0]`` to ``span[1]`` that calls ``set(name=...)`` when a person lets it go."""
        import ipywidgets

        slider = ipywidgets.FloatSlider(value=value, min=span[0], max=span[1], step=step, description=text, readout_format=".0f")
        slider.continuous_update, slider.style.description_width, slider.layout.width = False, "initial", "45%"
        change: OnMain[float] = OnMain(lambda moved: self.set(**{name: moved}))
        return self.observe(slider, change)

    @cached_property
    def widget(self) -> Any:
        """Controls, plot and read-out as one widget."""
        import ipywidgets

        parts = [self.controls(), self._picture, self._readout]
        self._refresh()  # now that there is a picture to fill
        return ipywidgets.VBox(parts)

    @cached_property
    def _picture(self) -> Any:
        import ipywidgets

        picture = ipywidgets.Image(format="png")
        picture.layout.max_width = "100%"
        return picture

    @cached_property
    def _readout(self) -> Any:
        import ipywidgets

        return ipywidgets.HTML()

    def _refresh(self) -> None:
        if "_picture" not in self.__dict__:
            return
        from matplotlib import pyplot

        figure, file = self.figure(), io.BytesIO()
        figure.savefig(file, format="png", dpi=DPI)
        pyplot.close(figure)
        self._picture.value = file.getvalue()
        self._readout.value = "<br>".join(escape(one) for one in self.text().splitlines())
        self._following = True
        try:
            self.follow()
        finally:
            self._following = False

    def _repr_mimebundle_(self, **how: Any) -> Any:
        try:
            return self.widget._repr_mimebundle_(**how)
        except ImportError:
            return {"text/plain": f"{self!r}\nFor sliders: pip install 'handlab[lab]'. Without them: {self.hint}, panel.figure()"}
