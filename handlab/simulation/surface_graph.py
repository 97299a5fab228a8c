"""Edges and areas of a closed triangle mesh, and values that spread along it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Index, Mesh


def edges_of(mesh: Mesh) -> Index:
    """Edges (e, 2) of a closed mesh, each once, lower node first.

    Raises ``ValueError`` where an edge does not belong to exactly two triangles: a network on an open or branching mesh would tear.
    """
    sides = np.sort(np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]), axis=1)
    edges, count = np.unique(sides, axis=0, return_counts=True)
    if (count != 2).any():
        open_, branching = int((count == 1).sum()), int((count > 2).sum())
        raise ValueError(
            f"the mesh has {open_} open edges and {branching} edges of more than two triangles; close it so that every edge belongs to two"
        )
    return np.asarray(edges, dtype=np.int64)


def face_areas(mesh: Mesh) -> Array:
    """Areas (M,) of the triangles in m^2."""
    result: Array = np.linalg.norm(face_normals(mesh), axis=1) / 2.0
    return result


def face_normals(mesh: Mesh) -> Array:
    """Normals (M, 3) of the triangles, as long as twice their area."""
    a, b, c = (mesh.points[mesh.faces[:, k]] for k in range(3))
    result: Array = np.cross(b - a, c - a)
    return result


def node_areas(mesh: Mesh) -> Array:
    """A third of the triangles around every point (N,), m^2."""
    area = np.zeros(len(mesh.points))
    for k in range(3):
        np.add.at(area, mesh.faces[:, k], face_areas(mesh) / 3.0)
    return area


def edge_areas(mesh: Mesh, edges: Index) -> Array:
    """The two triangles at every edge (e,) together, m^2."""
    sides = np.sort(np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]), axis=1)
    count = len(mesh.points)
    area = np.zeros(len(edges))
    np.add.at(area, np.searchsorted(edges @ [count, 1], sides @ [count, 1]), np.tile(face_areas(mesh), 3))
    return area


def diffused(mesh: Mesh, edges: Index, values: ArrayLike, pull: ArrayLike) -> Array:
    """Values (N, k) that spread along the mesh, pulled to ``values`` with ``pull`` (N,): (c + L) w = c w0.

    L weighs an edge by the area at it over its length squared, as ``physics.springs.membrane_stiffness`` does.
    """
    from scipy.sparse import coo_matrix, diags
    from scipy.sparse.linalg import splu

    count = len(mesh.points)
    length = np.linalg.norm(mesh.points[edges[:, 0]] - mesh.points[edges[:, 1]], axis=1)
    weight = edge_areas(mesh, edges) / length**2
    i, j = np.concatenate([edges[:, 0], edges[:, 1]]), np.concatenate([edges[:, 1], edges[:, 0]])
    joined = coo_matrix((np.tile(weight, 2), (i, j)), shape=(count, count)).tocsc()
    laplacian = diags(np.asarray(joined.sum(axis=1)).ravel()) - joined
    hold = np.asarray(pull, dtype=np.float64)
    result: Array = splu((diags(hold) + laplacian).tocsc()).solve(hold[:, None] * np.asarray(values, dtype=np.float64))
    return result
