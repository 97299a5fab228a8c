"""The picture to paint a muscle on: a hand that turns, the grid in blue, influenced skin points as green dots (Figure 4)."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import radians, tan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.physics.distance import closest
from handlab.show.colours import BLUE, GREEN, VERMILION
from handlab.show.gl import pyvista
from handlab.show.muscle_layer import GRID_ABOVE, MuscleLayer
from handlab.show.painting import Painting
from handlab.show.scene import Picture, Scene
from handlab.show.views import LENS_DEG, Camera, camera, view_name
from handlab.simulation.geometric_kernel import first_hit
from handlab.simulation.grid_rows import finer_points
from handlab.simulation.kinematics import rotation
from handlab.simulation.muscle_fit import checked_skin

SKINS = ("translucent", "solid", "mesh")
MESH = "#7B8794"
CHORD = 8  # pieces of a line between two points, each laid on the skin
SLACK = 0.002  # metres: a point that lies deeper behind the skin in front of it is on the far side
NEAREST, FARTHEST = 0.15, 2.0  # metres from the eye to the middle of the picture
TURN = 3.0  # radians for a way across the whole picture


class PaintPicture:
    """A hand in its bind posture on an off-screen canvas, and a camera that turns about it. Places are fractions of the picture.

    ``x`` counts from the left, ``y`` from the top, both 0 to 1. Draw on the thread that made it.
    """

    def __init__(self, hand: Hand, *, view: str = "palm", skin: str = "translucent", size: tuple[int, int] = (560, 640)) -> None:
        self.hand = hand
        self.size = size
        self.skin = find(skin, SKINS, kind="way to draw the skin")
        self._corners = np.ascontiguousarray(hand.skin.points[hand.skin.faces])
        self._scene: Scene | None = None
        self._muscles: set[str] = set()
        self.view = view_name(view)
        self.camera = self._camera()

    def _camera(self) -> Camera:
        return camera(self.hand, self.view, [self.hand.skin.points], self.size[0] / self.size[1])

    def look(self, *, view: str | None = None, skin: str | None = None) -> None:
        """Look from a named side, or at another kind of skin: ``translucent``, ``solid`` or ``mesh``. Raises ``UnknownName``."""
        named = None if view is None else view_name(view)
        if skin is not None:
            self.skin = find(skin, SKINS, kind="way to draw the skin")
        if named is not None:
            self.view = named
            self.camera = self._camera()

    def turn(self, dx: float, dy: float) -> None:
        """Turn the hand as if it were dragged by fractions of the picture, to the right and downwards."""
        eye = self.camera
        both = (rotation(eye.up, np.zeros(3), -TURN * dx) @ rotation(eye.right, np.zeros(3), -TURN * dy))[:3, :3]
        to_eye, up, right = both @ eye.to_eye, both @ eye.up, both @ eye.right
        self.camera = Camera(to_eye, up, right, eye.focus, eye.distance)

    def zoom(self, factor: float, x: float = 0.5, y: float = 0.5) -> None:
        """Go nearer by ``factor``; what lies at (x, y) stays there."""
        if not (np.isfinite(factor) and factor > 0.0):
            raise ValueError(f"zoom is {factor}; give a positive number, above 1 to go nearer")
        eye = self.camera
        distance = float(np.clip(eye.distance / factor, NEAREST, FARTHEST))
        aside = (eye.distance - distance) * self._offset(eye, x, y)
        self.camera = replace(eye, distance=distance, focus=eye.focus + aside)

    def _offset(self, eye: Camera, x: float, y: float) -> Array:
        """From the middle of the picture to (x, y), in a plane one metre before the eye (3,)."""
        reach = tan(radians(LENS_DEG / 2))
        result: Array = reach * ((2.0 * x - 1.0) * self.size[0] / self.size[1] * eye.right + (1.0 - 2.0 * y) * eye.up)
        return result

    def pick(self, x: float, y: float, eye: Camera | None = None) -> Array | None:
        """The place (3,) on the skin at (x, y), metres, or None beside the hand. ``eye``: the camera of an earlier picture."""
        if not (0.0 <= x <= 1.0 and 0.0 <= y <= 1.0):
            return None
        seen = self.camera if eye is None else eye
        way = self._offset(seen, x, y) - seen.to_eye
        way /= np.linalg.norm(way)
        start = seen.position
        far = float(first_hit(start[None], way[None], self._corners)[0][0])
        return start + far * way if np.isfinite(far) else None

    def places(self, points: ArrayLike) -> tuple[Array, Any]:
        """Fractions (n, 2) of points (n, 3) in the picture, and whether (n,) they are on the side that is seen."""
        wanted, eye = np.asarray(points, dtype=np.float64).reshape(-1, 3), self.camera
        way = wanted - eye.position
        deep = -(way @ eye.to_eye)
        reach = tan(radians(LENS_DEG / 2))
        x = 0.5 + 0.5 * (way @ eye.right) / (deep * reach * self.size[0] / self.size[1])
        y = 0.5 - 0.5 * (way @ eye.up) / (deep * reach)
        length = np.linalg.norm(way, axis=1, keepdims=True)
        first = first_hit(np.tile(eye.position, (len(way), 1)), np.ascontiguousarray(way / length), self._corners)[0]
        return np.stack([x, y], axis=1), first > length[:, 0] - SLACK

    def draw(self, painting: Painting, contraction: float = 0.0) -> Picture:
        """The picture (height, width, 3) of what is painted; ``contraction`` of the painted muscle's drive."""
        scene = self._ready()
        scene.set(skin="hidden" if self.skin == "mesh" else self.skin, view=self.camera)
        self._mesh.visibility = self.skin == "mesh"
        self._draw_muscle(scene, painting, contraction)
        lines = self._lines(painting)
        self._replace("grid", lines, color=BLUE if painting.problem is None else VERMILION, line_width=3)
        found: Any = [] if painting.result is None else painting.result.influenced
        dots = self.hand.skin.points[found] + GRID_ABOVE * checked_skin(self.hand)[found] if len(found) else None
        cloud = None if dots is None else pyvista().PolyData(dots)
        self._replace("influenced points", cloud, color=GREEN, point_size=8, render_points_as_spheres=True)
        return scene.picture()

    def _ready(self) -> Scene:
        if self._scene is None:
            self._scene = Scene(self.hand, skin="translucent", size=self.size, quality="live")
            faces = np.column_stack([np.full(len(self.hand.skin.faces), 3), self.hand.skin.faces])
            self._mesh = self._scene.plotter.add_mesh(
                pyvista().PolyData(self.hand.skin.points, faces),
                style="wireframe",
                color=MESH,
                opacity=0.35,
                line_width=1,
                name="skin mesh",
                reset_camera=False,
                render=False,
            )
        return self._scene

    def _replace(self, name: str, mesh: Any, **how: Any) -> None:
        plotter = self._ready().plotter
        if mesh is None:
            plotter.remove_actor(name, reset_camera=False, render=False)
        else:
            plotter.add_mesh(mesh, name=name, reset_camera=False, render=False, **how)

    def _draw_muscle(self, scene: Scene, painting: Painting, contraction: float) -> None:
        for name in self._muscles:
            scene.plotter.remove_actor(name, reset_camera=False, render=False)
        self._muscles = set()
        if painting.result is not None:
            muscle = painting.result.muscle
            pull = np.zeros(len(self.hand.muscles))
            pull[[self.hand.muscle_names.index(name) for name in muscle.drives[0]]] = contraction
            MuscleLayer(scene, muscles=muscle, sinews=False).pose(self.hand.bind, pull)
            self._muscles = {f"muscle {name}" for name in muscle.names}

    def _lines(self, painting: Painting) -> Any:
        """Rows and columns of the grid, as it was divided, a little above the skin; of a grid that is not whole, what there is."""
        whole, columns = painting.rows, painting.settings.columns
        rest = painting.points[whole.size // 3 :]
        grid = finer_points(self.hand, whole, painting.settings.finer) if len(whole) > 1 else whole
        ways = [*grid, *(grid.transpose(1, 0, 2) if len(grid) > 1 else ()), *([rest] if len(rest) > 1 else ())]
        ways += [np.stack([whole[-1, k], rest[k]]) for k in range(len(rest))] if len(whole) and columns else []
        if not ways:
            return None
        share = np.linspace(0.0, 1.0, CHORD, endpoint=False)[:, None]
        fine = [np.concatenate([*(a + share * (b - a) for a, b in pairwise(way)), way[-1:]]) for way in ways]
        points = self._lifted(np.concatenate(fine))
        begin = np.cumsum([0, *(len(way) for way in fine[:-1])])
        lines = [np.concatenate([[len(way)], start + np.arange(len(way))]) for start, way in zip(begin, fine, strict=True)]
        return pyvista().PolyData(points, lines=np.concatenate(lines))

    def _lifted(self, points: Array) -> Array:
        _, triangle, place = closest(np.ascontiguousarray(points), self._corners)
        up = checked_skin(self.hand)[self.hand.skin.faces[triangle]].mean(axis=1)
        result: Array = place + GRID_ABOVE * up
        return result

    def close(self) -> None:
        """Give back the canvas."""
        if self._scene is not None:
            self._scene.close()
            self._scene = None
