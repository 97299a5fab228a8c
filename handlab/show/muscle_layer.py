"""Muscles, tendons and painted grids in a scene: red bellies with their fibres, pale ends, and the dots of Figure 4."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, Index
from handlab.show import look
from handlab.show.colours import BLUE, GREEN
from handlab.show.gl import pyvista
from handlab.show.moments import Moment
from handlab.show.scene import Picture, Scene
from handlab.show.surface import Normals
from handlab.simulation.geometric_muscle import GeometricMuscles, geometric_muscles, shape
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.muscle_below import influenced
from handlab.simulation.muscle_surface import skeletons, surface_points
from handlab.simulation.skin import blend
from handlab.simulation.tendons import Tube, tendons

MUSCLE = "vec3 spread = vec3(0.34, 0.16, 0.12); vec3 low = vec3(0.36, 0.28, 0.26); vec2 gloss = vec2(0.10, 0.16);"
FLESH, DARK, SINEW = np.array([186.0, 70.0, 60.0]), np.array([128.0, 32.0, 32.0]), np.array([232.0, 222.0, 200.0])
BUNDLE = 5  # points of a section that a drawn bundle of fibres takes
ROUND = 8  # corners of a tendon's section
TENDON = "#E4EBEE"
SHEEN = "vec3 spread = vec3(0.30, 0.27, 0.25); vec3 low = vec3(0.40, 0.42, 0.44); vec2 gloss = vec2(0.16, 0.22);"
GRID_ABOVE = 0.0006  # metres: grids are drawn this far above the skin


class MuscleLayer:
    """Geometric muscles and tendons drawn into a ``Scene`` with points that are replaced in place.

    ``only``: names of the muscles to draw, all if not given. Actors: ``muscle NAME``, ``tendon NAME``.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        muscles: GeometricMuscles | None = None,
        only: tuple[str, ...] | None = None,
        bellies: bool = True,
        sinews: bool = True,
    ) -> None:
        self.scene = scene
        self.hand: Hand = scene.hand
        self.muscles = geometric_muscles(self.hand) if muscles is None else muscles
        wanted = self.muscles.names if only is None else tuple(self.muscles.names[self.muscles.index(name)] for name in only)
        self._drawn: list[tuple[int, Any, Normals]] = []
        self._tubes: list[tuple[int, Any, Normals]] = []
        points = surface_points(self.muscles, self.muscles.rest)
        if bellies:
            for g, kept in enumerate(skeletons(self.muscles)):
                if self.muscles.names[g] in wanted:
                    mesh, normals = _mesh(points[g], kept.faces)
                    mesh.point_data["tone"] = tones(kept.u, kept.v, bundles=round(np.count_nonzero(kept.u == kept.u[0]) / (2 * BUNDLE)))
                    self._add(mesh, f"muscle {self.muscles.names[g]}", MUSCLE, scalars="tone", rgb=True)
                    self._drawn.append((g, mesh, normals))
        if sinews:
            for k, tube in enumerate(tendons(self.hand, self.hand.bind)):
                mesh, normals = _mesh(tube_points(tube), tube_faces(len(tube.points)))
                self._add(mesh, f"tendon {tube.name}", SHEEN, color=TENDON)
                self._tubes.append((k, mesh, normals))

    def _add(self, mesh: Any, name: str, material: str, **how: Any) -> None:
        actor = self.scene.plotter.add_mesh(
            mesh, name=name, copy_mesh=False, reset_camera=False, render=False, show_scalar_bar=False, **how
        )
        actor.prop.interpolation = "Phong"
        look.paint(actor, material)

    def pose(self, angle: ArrayLike, contraction: ArrayLike | None = None) -> None:
        """Muscles at ``angle`` (dof,) rad and ``contraction`` (muscle,), none if not given; tendons where the bones take them."""
        if self._drawn:
            activity = np.zeros(len(self.hand.muscles)) if contraction is None else contraction
            points = surface_points(self.muscles, shape(self.muscles, relative_transforms(self.hand, angle), activity))
            for g, mesh, normals in self._drawn:
                _move(mesh, points[g], normals)
        if self._tubes:
            tubes = tendons(self.hand, angle, contraction)
            for k, mesh, normals in self._tubes:
                _move(mesh, tube_points(tubes[k]), normals)


def tones(u: Array, v: Array, *, bundles: int) -> Any:
    """Colours (n, 3) of a muscle's surface: ``bundles`` of fibres across ``v``, pale towards both ends of ``u``."""
    bundle = 0.5 + 0.5 * np.cos(np.pi * bundles * (v + 1.0))[:, None]
    pale = np.clip(1.0 - np.minimum(u, 1.0 - u) / 0.14, 0.0, 1.0)[:, None] ** 1.5
    red = DARK + bundle * (FLESH - DARK)
    return np.round((1.0 - pale) * red + pale * SINEW).astype(np.uint8)


def _mesh(points: Array, faces: Index) -> tuple[Any, Normals]:
    normals = Normals(faces, len(points))
    mesh = pyvista().PolyData(np.array(points, dtype=np.float32), np.column_stack([np.full(len(faces), 3), faces]))
    mesh.point_data.active_normals = normals.of(points)
    return mesh, normals


def _move(mesh: Any, points: Array, normals: Normals) -> None:
    mesh.points[:] = points
    mesh.point_data["Normals"][:] = normals.of(points)
    mesh.GetPoints().Modified()
    mesh.GetPointData().GetNormals().Modified()


def tube_points(tube: Tube) -> Array:
    """Points of a closed tube about a line: rings of ``ROUND``, then both ends."""
    line = tube.points
    along = np.gradient(line, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    side = np.empty_like(line)
    last = np.cross(along[0], [0.0, 0.0, 1.0]) + 1e-6
    for k, way in enumerate(along):  # carried along without twist
        last = last - (last @ way) * way
        last = last / max(float(np.linalg.norm(last)), 1e-12)
        side[k] = last
    up = np.cross(along, side)
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
    rings = line[:, None] + tube.radius * (np.cos(turn)[:, None] * side[:, None] + np.sin(turn)[:, None] * up[:, None])
    return np.concatenate([rings.reshape(-1, 3), line[[0, -1]]])


def tube_faces(count: int) -> Index:
    """Triangles of ``tube_points`` of a line of ``count`` points."""
    from handlab.simulation.muscle_surface import tube_faces as rings

    return rings(count, ROUND)


def picture(
    hand: Hand,
    angle: ArrayLike | None = None,
    contraction: ArrayLike | None = None,
    *,
    view: str = "palm",
    skin: str = "translucent",
    size: tuple[int, int] = (800, 900),
    only: tuple[str, ...] | None = None,
    sinews: bool = True,
    skin_points: Array | None = None,
) -> Picture:
    """A still of the muscles in a hand: (height, width, 3). ``only``: muscles to draw; ``skin_points``: instead of the blended skin."""
    pose = np.asarray(hand.bind if angle is None else angle, dtype=np.float64)
    points = blend(hand, pose) if skin_points is None else skin_points
    with Scene(hand, skin=skin, view=view, size=size, quality="still") as scene:
        layer = MuscleLayer(scene, only=only, sinews=sinews)
        layer.pose(pose, contraction)
        scene.pose(Moment(0.0, points, pose))
        scene.frame([points])
        return scene.picture()


def grid_picture(
    hand: Hand, name: str, *, muscles: GeometricMuscles | None = None, view: str = "palm", size: tuple[int, int] = (800, 900)
) -> Picture:
    """Figure 4: the skin as a wireframe, the grid of one muscle in blue, the skin points that it influences as green dots."""
    pv = pyvista()
    found = geometric_muscles(hand) if muscles is None else muscles
    one = found.fitted[found.index(name)]
    with Scene(hand, skin="hidden", bones=True, view=view, size=size, quality="film") as scene:
        MuscleLayer(scene, muscles=found, only=(name,), sinews=False)
        faces = np.column_stack([np.full(len(hand.skin.faces), 3), hand.skin.faces])
        scene.plotter.add_mesh(
            pv.PolyData(hand.skin.points, faces), style="wireframe", color="#7B8794", opacity=0.35, line_width=1, name="skin mesh"
        )
        line = _grid_lines(one.painted + GRID_ABOVE * _columns(one.outward))
        scene.plotter.add_mesh(line, color=BLUE, line_width=5, name="grid")
        dots = hand.skin.points[influenced(hand, found, name)]
        if len(dots):
            scene.plotter.add_mesh(pv.PolyData(dots), color=GREEN, point_size=14, render_points_as_spheres=True, name="influenced points")
        scene.frame([hand.skin.points])
        return scene.picture()


def _columns(outward: Array) -> Array:
    """Directions at the columns of a grid from those at its fibres."""
    wide = np.concatenate([outward[:, :1], outward, outward[:, -1:]], axis=1)
    result: Array = (wide[:, 1:] + wide[:, :-1]) / 2
    return result


def _grid_lines(grid: Array) -> Any:
    """Rows and columns of a grid (rows, columns, 3) as one mesh of lines."""
    rows, columns = grid.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    lines = [np.concatenate([[len(way)], way]) for way in (*number, *number.T)]
    return pyvista().PolyData(grid.reshape(-1, 3), lines=np.concatenate(lines))
