"""A picture of a muscle while it is painted: the grid in blue, influenced skin points as green dots (Figure 4)."""

from __future__ import annotations

import numpy as np

from handlab.show.colours import BLUE, GREEN, VERMILION
from handlab.show.gl import pyvista
from handlab.show.muscle_layer import GRID_ABOVE, MuscleLayer
from handlab.show.paint_room import surface_lines
from handlab.show.painting import Painting
from handlab.show.scene import Picture, Scene
from handlab.simulation.muscle_fit import checked_skin

MESH = "#7B8794"


def paint_picture(
    painting: Painting, *, view: str = "palm", skin: str = "translucent", contraction: float = 0.0, size: tuple[int, int] = (560, 640)
) -> Picture:
    """The picture (height, width, 3) of what is painted; ``contraction`` of its drive; ``skin`` translucent, solid or ``mesh``."""
    hand = painting.hand
    scene = Scene(hand, skin="hidden" if skin == "mesh" else skin, view=view, size=size, quality="live")
    try:
        how = {"reset_camera": False, "render": False}
        if skin == "mesh":
            faces = np.column_stack([np.full(len(hand.skin.faces), 3), hand.skin.faces])
            wires = pyvista().PolyData(hand.skin.points, faces)
            scene.plotter.add_mesh(wires, style="wireframe", color=MESH, opacity=0.35, line_width=1, **how)
        if painting.result is not None:
            muscle, found = painting.result.muscle, painting.result.influenced
            pull = np.zeros(len(hand.muscles))
            pull[[hand.muscle_names.index(name) for name in muscle.drives[0]]] = contraction
            MuscleLayer(scene, muscles=muscle, sinews=False).pose(hand.bind, pull)
            if len(found):
                dots = pyvista().PolyData(hand.skin.points[found] + GRID_ABOVE * checked_skin(hand)[found])
                scene.plotter.add_mesh(dots, color=GREEN, point_size=8, render_points_as_spheres=True, **how)
        told = surface_lines(painting)
        for line, outward in zip(told["lines"], told["outward"], strict=True):
            points = np.reshape(line, (-1, 3)) / 1e3 + GRID_ABOVE * np.reshape(outward, (-1, 3))
            way = pyvista().PolyData(points, lines=np.concatenate([[len(points)], np.arange(len(points))]))
            scene.plotter.add_mesh(way, color=BLUE if painting.problem is None else VERMILION, line_width=3, **how)
        return scene.picture()
    finally:
        scene.close()
