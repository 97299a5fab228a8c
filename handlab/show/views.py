"""From where a hand is looked at, and how far away the camera must be for all of it to be in the picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import radians, tan
from types import MappingProxyType
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find

# A long lens: little perspective, as in anatomical plates.
LENS_DEG = 16.0
MARGIN = 0.93

# From the hand to the camera, and what is up in the picture, for a right hand: x distal, y palmar, z radial.
DIRECTIONS: Mapping[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = MappingProxyType(
    {
        "palm": ((0.12, 1.0, 0.0), (1.0, 0.0, 0.0)),
        "back": ((0.12, -1.0, 0.0), (1.0, 0.0, 0.0)),
        "radial": ((0.06, 0.0, 1.0), (1.0, 0.0, 0.0)),
        "ulnar": ((0.06, 0.0, -1.0), (1.0, 0.0, 0.0)),
        "front": ((1.0, 0.25, 0.0), (0.0, -1.0, 0.0)),
        "oblique": ((0.35, 0.80, 0.75), (1.0, 0.0, 0.0)),
        "oblique back": ((0.35, -0.80, 0.75), (1.0, 0.0, 0.0)),
    }
)
FOUR_SIDES = ("palm", "radial", "back", "ulnar")


@dataclass(frozen=True)
class Camera:
    """Unit vectors ``to_eye``, ``up``, ``right`` (3,), the point ``focus`` (3,) in the middle, ``distance`` in metres."""

    to_eye: Array
    up: Array
    right: Array
    focus: Array
    distance: float

    @property
    def position(self) -> Array:
        """Where the eye is (3,)."""
        result: Array = self.focus + self.distance * self.to_eye
        return result


def view_name(name: str) -> str:
    """The view that ``name`` means; an unknown one is answered with the nearest three."""
    return find(name, DIRECTIONS, kind="view")


def directions(hand: Hand, view: str) -> tuple[Array, Array, Array]:
    """Unit vectors to the eye, up and right. A left hand is seen in the mirror: its radial view shows its thumb side too."""
    to_eye, above = (np.array(v) for v in DIRECTIONS[view_name(view)])
    if hand.side == "left":
        to_eye[2], above[2] = -to_eye[2], -above[2]
    to_eye /= np.linalg.norm(to_eye)
    right = np.cross(above, to_eye)
    right /= np.linalg.norm(right)
    return to_eye, np.cross(to_eye, right), right


def camera(hand: Hand, view: str, clouds: Iterable[Any], aspect: float, *, distance: float | None = None) -> Camera:
    """The camera of ``view`` that sees all points of ``clouds`` (each (N, 3), metres) in a picture of ``aspect`` = width / height.

    ``distance`` overrides the one that just fits, so that several views can share a scale.
    """
    to_eye, up, right = directions(hand, view)
    points = np.concatenate([np.asarray(cloud, dtype=np.float64) for cloud in clouds])
    x, y, depth = points @ right, points @ up, points @ to_eye
    middle = np.array([(values.min() + values.max()) / 2 for values in (x, y, depth)])
    focus = middle[0] * right + middle[1] * up + middle[2] * to_eye
    reach = tan(radians(LENS_DEG / 2)) * MARGIN
    # A point is in the picture if its offset is at most reach * (its distance from the eye).
    fits = np.maximum(np.abs(x - middle[0]) / (reach * aspect), np.abs(y - middle[1]) / reach) + (depth - middle[2])
    return Camera(to_eye, up, right, focus, float(fits.max()) if distance is None else distance)


def same_scale(hand: Hand, views: Iterable[str], clouds: Iterable[Any], aspect: float) -> dict[str, Camera]:
    """A camera for every view, all equally far away."""
    names, kept = [view_name(view) for view in views], list(clouds)
    farthest = max(camera(hand, name, kept, aspect).distance for name in names)
    return {name: camera(hand, name, kept, aspect, distance=farthest) for name in names}
