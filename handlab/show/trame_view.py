"""The hand in pyvista's own notebook view: geometry travels to vtk.js in the browser, which draws it.

The first view of the plain ``client`` back end would be the combined one, which needs a drawing library on the kernel's side, so the
mode is asked for. What changes the scene runs on the thread that made it: from another thread nothing would be seen to move.
"""

from __future__ import annotations

import sys
from math import radians, tan
from typing import Any

import numpy as np

from handlab.anatomy.records import Hand
from handlab.show.gl import pyvista
from handlab.show.main_thread import OnMain
from handlab.show.moments import story
from handlab.show.views import LENS_DEG
from handlab.simulation.clip import Clip
from handlab.simulation.state import State

BROWSER_LENS_DEG = 30.0
# These two look for a download when a server starts; without them trame-vtk works, and works offline.
DOWNLOADERS = ("trame_vtklocal", "trame.widgets.vtklocal")


class TrameView:
    """``show(state)`` moves the hand; ``at(time)`` of a clip too."""

    def __init__(
        self,
        hand: Hand,
        what: State | Clip | None = None,
        *,
        height: int = 680,
        view: str = "palm",
        skin: str = "solid",
        bones: bool = True,
        **_more: Any,
    ) -> None:
        for name in DOWNLOADERS:
            sys.modules.setdefault(name, None)  # type: ignore[arg-type]
        from handlab.show.scene import Scene

        pyvista()  # first: it chooses how VTK draws without a screen
        try:
            import trame_pyvista  # noqa: F401
        except ImportError as error:
            raise ImportError(f'pyvista cannot show itself in a notebook ({error}); pip install "handlab[lab]"') from error
        self.hand = hand
        self._story = story(hand if what is None else what, hand)
        self._scene = Scene(hand, skin=skin, bones=bones, view=view, size=(height * 5 // 4, height))
        self._scene.pose(self._story.at(0.0))
        self._suit_the_browser()
        self._viewer = self._scene.plotter.show(jupyter_backend="trame", jupyter_kwargs={"mode": "client"}, return_viewer=True)
        self._moved = OnMain(self._pose)

    def _suit_the_browser(self) -> None:
        # vtk.js keeps its own lens and light: the camera comes nearer, and what the still's shader does, plain light does here.
        plotter = self._scene.plotter
        eye = plotter.camera
        focus, position = np.array(eye.focal_point), np.array(eye.position)
        eye.position = focus + (position - focus) * tan(radians(LENS_DEG / 2)) / tan(radians(BROWSER_LENS_DEG / 2))
        eye.view_angle = BROWSER_LENS_DEG
        plotter.add_light(pyvista().Light(light_type="headlight", intensity=0.55))
        for actor in plotter.actors.values():
            actor.prop.ambient, actor.prop.diffuse, actor.prop.specular = 0.28, 0.62, 0.06

    def show(self, state: State) -> None:
        """Show a state; may be called from any thread."""
        self._moved(story(state, self.hand).at(0.0))

    def at(self, time: float) -> None:
        """Show a clip ``time`` seconds after its beginning."""
        self._moved(self._story.at(time))

    def _pose(self, moment: Any) -> None:
        self._scene.pose(moment)
        self._viewer.viewer.update()

    def _repr_mimebundle_(self, **how: Any) -> Any:
        return self._viewer._repr_mimebundle_(**how)
