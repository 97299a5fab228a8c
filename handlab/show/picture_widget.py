"""The hand as a picture in an ordinary widget: needs no port, no proxy and no script in the page, only a drawing kernel."""

from __future__ import annotations

import io
from functools import cached_property
from typing import Any

from handlab.anatomy.records import Hand
from handlab.show.moments import story
from handlab.simulation.state import State

QUALITY = 85  # of the JPEG: about 10 kB a picture


class PictureWidget:
    """``widget`` shows what ``show(state)`` was given last. Call ``show`` on the thread that made it."""

    def __init__(self, hand: Hand, *, view: str = "palm", skin: str = "solid", size: tuple[int, int] = (420, 420)) -> None:
        self.hand = hand
        self._how: dict[str, Any] = {"view": view, "skin": skin, "size": size}

    @cached_property
    def widget(self) -> Any:
        """An ``ipywidgets.Image``."""
        import ipywidgets

        width, height = self._how["size"]
        return ipywidgets.Image(format="jpeg", width=width, height=height)

    @cached_property
    def _scene(self) -> Any:
        from handlab.show.scene import Scene

        return Scene(self.hand, quality="live", **self._how)

    def show(self, state: State) -> None:
        """Draw a state."""
        from PIL import Image

        self._scene.pose(story(state, self.hand).at(0.0))
        file = io.BytesIO()
        Image.fromarray(self._scene.picture()).save(file, format="JPEG", quality=QUALITY)
        self.widget.value = file.getvalue()
