"""Muscles for moving pictures: a quarter of the points of ``muscle_layer``, all in one mesh, placed by one sparse product."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array
from handlab.show.flesh import STRIDE, bellies
from handlab.show.surface import Normals
from handlab.simulation.geometric_muscle import OVERLAP, Ellipsoids, GeometricMuscles, geometric_muscles, shape
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.muscle_surface import TIP, Skeleton, skeletons

if TYPE_CHECKING:
    from handlab.show.scene import Scene

ACTOR = "muscle bellies"


class LiveMuscles:
    """All geometric muscles of a scene's hand as the actor ``muscle bellies``, whose points are replaced in place."""

    def __init__(self, scene: Scene) -> None:
        from handlab.show.muscle_layer import MUSCLE

        self.hand = scene.hand
        self.muscles = geometric_muscles(self.hand)
        self._product = Product(self.muscles)
        _, arrays = bellies(self.hand)
        points = self._product.points(self.muscles.rest)
        self._normals = Normals(arrays["faces"], len(points))
        self._mesh = scene.mesh(points, arrays["faces"], self._normals)
        self._mesh.point_data["tone"] = arrays["tone"]
        scene.add(self._mesh, ACTOR, MUSCLE, scalars="tone", rgb=True)

    def pose(self, angle: ArrayLike, contraction: ArrayLike | None = None) -> None:
        """Muscles at ``angle`` (dof,) rad and ``contraction`` (muscle,), none if not given."""
        activity = np.zeros(len(self.hand.muscles)) if contraction is None else contraction
        points = self._product.points(shape(self.muscles, relative_transforms(self.hand, angle), activity))
        self._mesh.points[:] = points
        self._mesh.point_data["Normals"][:] = self._normals.of(points)
        self._mesh.GetPoints().Modified()
        self._mesh.GetPointData().GetNormals().Modified()


class Product:
    """Every second point of every second ring of all muscles as one sparse matrix times centres and half-axes of the segments.

    Without the last correction of the volume, as in the viewer (``flesh``).
    """

    def __init__(self, muscles: GeometricMuscles) -> None:
        from scipy.sparse import block_array, block_diag, csr_array

        spines, girths, segment, end = [], [], [], []
        for part, fibres, kept in zip(muscles.segments, muscles.fibres, skeletons(muscles), strict=True):
            rows = drawn(kept)
            spines.append(csr_array(kept.spine[rows]))
            girths.append(csr_array(kept.girth[rows]))
            own = np.arange(part.start, part.stop).reshape(fibres, -1)
            segment.append(np.concatenate([own[:, :1], own, own[:, -1:]], axis=1).ravel())
            end.append(np.tile([-1.0, *[0.0] * own.shape[1], 1.0], fibres))
        self._segment, self._end = np.concatenate(segment), np.concatenate(end)
        self._thin = np.where(self._end == 0.0, 1.0, TIP)
        first = np.cumsum([0, *(len(own) for own in segment)])
        # half-axes of one muscle stand together: across, then outwards
        self._axes = np.concatenate([np.concatenate([2 * np.arange(a, b), 2 * np.arange(a, b) + 1]) for a, b in pairwise(first)])
        self._weights: Any = block_array([[block_diag(spines), block_diag(girths)]]).tocsr()

    def points(self, ellipsoids: Ellipsoids) -> Array:
        """Points (n, 3) of all muscles."""
        centre, frame, half = (values[self._segment] for values in ellipsoids)
        place = centre + frame[:, :, 0] * (self._end * half[:, 0] / OVERLAP)[:, None]
        axes = np.swapaxes(frame[:, :, 1:] * (half[:, None, 1:] * self._thin[:, None, None]), 1, 2).reshape(-1, 3)
        result: Array = self._weights @ np.concatenate([place, axes[self._axes]])
        return result


def drawn(kept: Skeleton) -> Any:
    """Rows of the points of a surface that are drawn: rings, sections, and both tips."""
    body = len(kept.u) - 2
    ring = int(np.count_nonzero(kept.u[:body] == kept.u[0]))
    return np.concatenate([np.arange(body).reshape(-1, ring)[::STRIDE, ::STRIDE].ravel(), [body, body + 1]])
