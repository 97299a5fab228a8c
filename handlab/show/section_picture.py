"""A cut through the hand, drawn to scale: skin, bones and muscles as closed lines in a plane."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand, Index
from handlab.show.colours import INK
from handlab.show.lettering import fit, write
from handlab.simulation.geometric_muscle import geometric_muscles, shape
from handlab.simulation.kinematics import posed_bone, relative_transforms
from handlab.simulation.muscle_surface import skeletons, surface_points
from handlab.studies.knuckle import section

FINE = 3  # drawn so many times larger, for smooth lines
BONE, BONE_EDGE, BONE_INK = "#EFE4CB", "#8A7F66", "#5E553F"


@dataclass(frozen=True)
class Plane:
    """``origin`` (3,) m; unit vectors ``right``, ``up`` (3,) of the picture; ``right`` x ``up`` points to the reader."""

    origin: Array
    right: Array
    up: Array

    def cut(self, points: Array, faces: Index) -> list[Array]:
        """Closed lines (k, 2) m in which the plane cuts a closed mesh."""
        rings = section(points, faces, self.origin, np.cross(self.right, self.up))
        return [np.stack([(ring - self.origin) @ self.right, (ring - self.origin) @ self.up], axis=1) for ring in rings]


class Cut:
    """A canvas of ``size`` pixels that shows ``width`` metres of a plane around the point ``middle`` (2,) m of it."""

    def __init__(self, plane: Plane, size: tuple[int, int], width: float, middle: tuple[float, float] = (0.0, 0.0)) -> None:
        from PIL import Image, ImageDraw

        self.plane, self.size = plane, size
        self._scale = FINE * size[0] / width
        self._middle = np.array(middle)
        self._image = Image.new("RGB", (FINE * size[0], FINE * size[1]), "white")
        self._draw: Any = ImageDraw.Draw(self._image)

    def place(self, points: Array) -> Any:
        """Pixels of points (k, 2) m."""
        at = (np.asarray(points) - self._middle) * self._scale
        return np.stack([FINE * self.size[0] / 2 + at[:, 0], FINE * self.size[1] / 2 - at[:, 1]], axis=1)

    def fill(self, rings: Iterable[Array], colour: str, edge: str | None = None, thick: float = 1.0) -> None:
        """Areas, and their edges."""
        for ring in rings:
            self._draw.polygon([tuple(p) for p in self.place(ring)], fill=colour)
            if edge is not None:
                self.line([ring], edge, thick)

    def line(self, rings: Iterable[Array], colour: str, thick: float, *, dashed: bool = False) -> None:
        """Closed lines ``thick`` pixels wide."""
        wide = round(FINE * thick)
        for ring in rings:
            points = self.place(np.concatenate([ring, ring[:1]]))
            for part in dashes(points, 5.0 * wide) if dashed else [points]:
                self._draw.line([tuple(p) for p in part], fill=colour, width=wide, joint="curve")

    def bones(self, hand: Hand, angle: Array) -> None:
        """All bones that the plane cuts."""
        for name, bone in hand.bones.items():
            rings = self.plane.cut(posed_bone(hand, name, angle), bone.faces)
            self.fill(rings, BONE, BONE_EDGE, 1.2)
            for ring in rings:
                place, (wide, high) = self.place(ring), np.ptp(self.place(ring), axis=0)
                if min(wide, high) > 0.09 * FINE * self.size[0]:
                    self._label(name, place.mean(axis=0), 0.9 * wide)

    def _label(self, name: str, where: Any, width: float) -> None:
        text = name.replace("_", " ")
        letters = fit(self._draw, text, 0.025 * FINE * self.size[0], width)
        write(self._draw, (where[0], where[1]), text, letters, colour=BONE_INK, anchor="mm")

    def picture(self) -> Any:
        """The Pillow image."""
        return self._image.resize(self.size, resample=3)


def dashes(points: Any, length: float) -> list[Any]:
    """Pieces of a line (k, 2), each ``length`` long, with gaps half as long."""
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    found = []
    for begin in np.arange(0.0, walked[-1], 1.5 * length):
        end = min(begin + length, walked[-1])
        at = np.concatenate([[begin], walked[(walked > begin) & (walked < end)], [end]])
        found.append(np.stack([np.interp(at, walked, points[:, k]) for k in (0, 1)], axis=1))
    return found


def muscle_cuts(hand: Hand, plane: Plane, angle: Array, contraction: Array, muscles: Iterable[str]) -> list[Array]:
    """Closed lines in which the plane cuts the geometric muscles that the pseudo ``muscles`` drive."""
    every, names = geometric_muscles(hand), set(muscles)
    points = surface_points(every, shape(every, relative_transforms(hand, angle), contraction))
    return [
        ring
        for g, kept in enumerate(skeletons(every))
        if names & set(every.drives[g])
        for ring in plane.cut(points[g], kept.faces)
    ]  # fmt: skip


def scale_bar(draw: Any, where: tuple[float, float], pixels_per_mm: float, letters: float, millimetres: int = 5) -> None:
    """A bar with its length, its left end at ``where``."""
    x, y = where
    end, thick = x + millimetres * pixels_per_mm, max(2, round(0.12 * letters))
    draw.line([(x, y), (end, y)], fill=INK, width=thick)
    for at in (x, end):
        draw.line([(at, y - 0.3 * letters), (at, y + 0.3 * letters)], fill=INK, width=thick)
    write(draw, ((x + end) / 2, y - 0.5 * letters), f"{millimetres} mm", 0.8 * letters, colour=INK, anchor="ms")
