"""What a mesh needs to be drawn smoothly: normals from its own points, and neighbours to smooth values over."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Index


class Normals:
    """Vertex normals of one topology, again and again for new points."""

    def __init__(self, faces: Index, count: int) -> None:
        from scipy.sparse import csr_array

        self._faces = [np.ascontiguousarray(faces[:, i]) for i in range(3)]
        triangles = len(faces)
        where = (faces.T.ravel(), np.tile(np.arange(triangles), 3))
        self._gather: Any = csr_array((np.ones(3 * triangles, np.float32), where), shape=(count, triangles))

    def of(self, points: Any) -> Any:
        """Unit normals (N, 3), float32, of ``points`` (N, 3), every triangle weighted by its area."""
        points = np.asarray(points, dtype=np.float32)
        corners = [points[index] for index in self._faces]
        summed = self._gather @ np.cross(corners[1] - corners[0], corners[2] - corners[0])
        return summed / np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), np.float32(1e-20))


def averaging(faces: Index, count: int) -> Any:
    """Sparse matrix (N, N) that replaces the value at every vertex by the mean of its neighbours."""
    from scipy.sparse import coo_array, diags_array

    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    rows, columns = np.concatenate([edges, edges[:, ::-1]]).T
    touching = coo_array((np.ones(len(rows)), (rows, columns)), shape=(count, count)).tocsr()
    touching.data[:] = 1.0  # an inner edge was counted from both of its triangles
    return diags_array(1.0 / np.maximum(touching.sum(axis=1), 1.0)) @ touching


def hollowness(points: Array, faces: Index, normals: Any) -> Array:
    """How hollow the surface is at every vertex (N,): 1 in creases, -1 on ridges, scale-free and smoothed a little."""
    mean = averaging(faces, len(points))
    height = np.einsum("ij,ij->i", mean @ points - points, normals)
    for _ in range(2):
        height = mean @ height
    result: Array = np.clip(height / np.percentile(np.abs(height), 97), -1.0, 1.0)
    return result
