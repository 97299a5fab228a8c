"""One drawn hand: skin, bones, lights and a camera that stay, and points that are replaced in place."""

from __future__ import annotations

from collections.abc import Iterable
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.records import Hand
from handlab.anatomy.terms import find
from handlab.show import look
from handlab.show.colours import IVORY, PAPER, SKY_OF_STILLS
from handlab.show.complexion import complexion
from handlab.show.gl import pyvista
from handlab.show.moments import Moment
from handlab.show.surface import Normals
from handlab.show.views import LENS_DEG, Camera, camera, view_name
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.skin import fine_points

Skin = Literal["solid", "translucent", "hidden"]
Quality = Literal["live", "film", "still"]
SKINS: tuple[Skin, ...] = ("solid", "translucent", "hidden")
Picture = NDArray[np.uint8]

PEELS = 10  # layers of skin behind each other that a still sorts: a fist seen from the side has about as many
OCCLUSION_REACH = 0.011  # metres: the dark reaches about a finger's width into a crease


class Scene:
    """A hand on an off-screen canvas.

    ``skin``: ``"solid"``, ``"translucent"`` (drawn in two passes: far side, then near side) or ``"hidden"``;
    ``bones``: whether they are drawn; ``layers``: ``"muscles"``, ``"tendons"``, seen where the skin is not solid;
    ``view``: one of ``views.DIRECTIONS``; ``size``: width and height in pixels.
    ``quality``: ``"live"`` is fastest; ``"film"`` draws at twice the resolution and averages down, for smooth outlines; ``"still"``
    adds ambient occlusion, the soft dark where surfaces meet, and sorts translucent layers by depth.
    ``light``: ``"studio"``, or ``"raking"``, low from one side, in which small relief shows.

    Actors: ``skin``, ``skin far side``, ``skin near side`` one per bone, by its name; ``muscle NAME`` (live: ``muscle bellies``),
    ``tendon NAME``.
    """

    def __init__(
        self,
        hand: Hand,
        *,
        skin: str = "solid",
        bones: bool = True,
        layers: Iterable[str] = (),
        view: str = "palm",
        size: tuple[int, int] = (800, 600),
        quality: Quality = "live",
        light: str = "studio",
    ) -> None:
        self.hand = hand
        self._light = light
        under = tuple(layers)
        self.size = size
        self._quality = quality
        self._fineness = factor = 1 if quality == "live" else 2
        pv = pyvista()
        self.plotter = pv.Plotter(off_screen=True, window_size=[factor * size[0], factor * size[1]], lighting="none")
        self.plotter.render_window.SetMultiSamples(0)  # multi-sampling costs most on a software renderer
        # Translucent actors in the order in which they were added, far side first: what VTK does instead costs twice as much.
        self.plotter.renderer.SetUseOIT(False)
        self.plotter.set_background(PAPER, top=SKY_OF_STILLS)
        self.plotter.add_light(pv.Light(position=(-0.45, 0.65, 0.62), light_type="camera light"))
        self._normals = Normals(hand.skin_fine.faces, len(hand.skin_fine.points))
        self._surface = self.mesh(hand.skin_fine.points, hand.skin_fine.faces, self._normals)
        self._bone_actors = self._add_bones()
        self._flesh = self._add_flesh(under)
        self._skin_actors = self._add_skin()
        self._clouds: list[Any] = [hand.skin_fine.points]
        self.set(skin=skin, bones=bones, view=view)

    def mesh(self, points: Any, faces: Any, normals: Normals) -> Any:
        """A mesh whose points and normals can be replaced in place."""
        mesh = pyvista().PolyData(np.array(points, dtype=np.float32), np.column_stack([np.full(len(faces), 3), faces]))
        mesh.point_data.active_normals = normals.of(points)
        return mesh

    def add(self, mesh: Any, name: str, material: str, density: tuple[float, float] | None = None, **how: Any) -> Any:
        """The actor of a mesh, of one of the materials of ``look``."""
        actor = self.plotter.add_mesh(
            mesh,
            name=name,
            opacity=1.0 if density is None else 0.5,  # the shader replaces it; below 1 puts the actor among the translucent
            copy_mesh=False,
            reset_camera=False,
            render=False,
            show_scalar_bar=False,
            **how,
        )
        # Not through smooth_shading=True: that copies the mesh, and points could no longer be replaced in place.
        actor.prop.interpolation = "Phong"
        look.paint(actor, material, density, self._light)
        return actor

    def _add_bones(self) -> dict[str, Any]:
        return {
            name: self.add(self.mesh(bone.points, bone.faces, Normals(bone.faces, len(bone.points))), name, look.BONE, color=IVORY)
            for name, bone in self.hand.bones.items()
        }

    def _add_flesh(self, layers: tuple[str, ...]) -> list[Any]:
        """Muscles and tendons: before the skin, which is drawn over them."""
        if not layers:
            return []
        from handlab.show.live_flesh import LiveMuscles
        from handlab.show.muscle_layer import MuscleLayer

        fast, muscles, tendons = self._quality == "live", "muscles" in layers, "tendons" in layers
        found: list[Any] = [LiveMuscles(self)] if fast and muscles else []
        if tendons or (muscles and not fast):
            found.append(MuscleLayer(self, bellies=muscles and not fast, sinews=tendons))
        return found

    def _add_skin(self) -> dict[Skin, list[Any]]:
        self._surface.point_data["tone"] = complexion(self.hand)
        tone: Any = {"scalars": "tone", "rgb": True}
        return {
            "solid": [self.add(self._surface, "skin", look.SKIN, **tone)],
            "translucent": [
                self.add(self._surface, "skin far side", look.SKIN, look.FAR_SIDE, culling="front", **tone),
                self.add(self._surface, "skin near side", look.SKIN, look.NEAR_SIDE, culling="back", **tone),
            ],
            "hidden": [],
        }

    def set(self, *, skin: str | None = None, bones: bool | None = None, view: str | Camera | None = None) -> None:
        """Change what is seen, or from where; anything not given stays.

        Raises ``UnknownName`` for an unknown skin or view, with the nearest ones.
        """
        if skin is not None:
            self.skin = skin_name(skin)
        if bones is not None:
            self.bones = bones
        for name, actors in self._skin_actors.items():
            for actor in actors:
                actor.visibility = name == self.skin
        for actor in self._bone_actors.values():
            # Under a solid skin nobody sees them: not drawing them is faster, and hides a bone that would look through.
            actor.visibility = self.bones and self.skin != "solid"
        for name, actor in self.plotter.actors.items():
            if name.startswith(("muscle ", "tendon ")):
                actor.visibility = self.skin != "solid"
        if skin is not None and self._quality == "still":
            self._take_time(self.skin)
        if view is not None:
            self._aim(view)

    def _take_time(self, skin: Skin) -> None:
        # The two exclude each other: occlusion counts translucent skin as a surface and speckles what is behind it.
        if skin == "translucent":
            self.plotter.disable_ssao()
            self.plotter.enable_depth_peeling(PEELS)
        else:
            self.plotter.disable_depth_peeling()
            self.plotter.enable_ssao(radius=OCCLUSION_REACH, bias=0.0008, kernel_size=48, blur=True)

    def _aim(self, view: str | Camera) -> None:
        aspect = self.size[0] / self.size[1]
        aim = view if isinstance(view, Camera) else camera(self.hand, view_name(view), self._clouds, aspect)
        eye = self.plotter.camera
        eye.position, eye.focal_point, eye.up, eye.view_angle = aim.position, aim.focus, aim.up, LENS_DEG
        eye.clipping_range = (max(aim.distance - 0.35, 0.05), aim.distance + 0.35)
        self.view = view

    def frame(self, clouds: Iterable[Any]) -> None:
        """Let the camera see all points of ``clouds`` (each (N, 3)), for instance the skin throughout a clip."""
        self._clouds = list(clouds)
        self._aim(self.view)

    def pose(self, moment: Moment) -> None:
        """Replace the points of the skin and the matrices of the bones in place."""
        points = fine_points(self.hand, moment.skin, moment.raised)
        self._surface.points[:] = points
        self._surface.point_data["Normals"][:] = self._normals.of(points)
        self._surface.GetPoints().Modified()
        self._surface.GetPointData().GetNormals().Modified()
        moved = relative_transforms(self.hand, moment.angle)
        row = {name: k for k, name in enumerate(self.hand.body_names)}
        for name, actor in self._bone_actors.items():
            actor.user_matrix = moved[row[self.hand.bones[name].body]]
        for layer in self._flesh:
            layer.pose(moment.angle, moment.contraction)

    def tint(self, tone: NDArray[np.uint8]) -> None:
        """Other colours (Nf, 3) for the points of the fine skin."""
        self._surface.point_data["tone"][:] = tone
        self._surface.GetPointData().GetArray("tone").Modified()

    def picture(self) -> Picture:
        """What the camera sees: (height, width, 3), 0 to 255."""
        self.plotter.render()
        seen: Picture = np.asarray(self.plotter.screenshot(None, return_img=True))[..., :3]
        return np.ascontiguousarray(seen) if self._fineness == 1 else halved(seen)

    def close(self) -> None:
        """Give back the canvas."""
        self.plotter.close()

    def __enter__(self) -> Self:
        """The scene itself; leaving the block closes it."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Close the scene."""
        self.close()


def halved(picture: Picture) -> Picture:
    """Every two by two pixels averaged to one."""
    four = [picture[i::2, j::2].astype(np.uint16) for i in (0, 1) for j in (0, 1)]
    result: Picture = ((four[0] + four[1] + four[2] + four[3] + 2) >> 2).astype(np.uint8)
    return result


def skin_name(name: str) -> Skin:
    """The way of drawing the skin that ``name`` means."""
    found: Any = find(name, SKINS, kind="way to draw the skin")
    return found  # type: ignore[no-any-return]
