"""Is a mesh a surface that encloses a body: closed, manifold, consistently oriented, in one piece, free of crossings?"""

from __future__ import annotations

import numpy as np

from handlab.anatomy.records import Array, FineSkin, Index, Mesh
from handlab.physics.crossing import FLAT, overlapping, self_crossings

TEXTURE_TOUCH = 1e-6  # texture coordinates are stored with seven digits: less than this is contact, not overlap


def faults(mesh: Mesh) -> tuple[str, ...]:
    """What keeps a mesh from being the surface of one body, in words; empty for a good one."""
    found = []
    faces = mesh.faces
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    number: Index = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)[1].astype(np.int64)
    use = np.bincount(number)
    if (use == 1).any():
        found.append(f"{int((use == 1).sum())} open edges")
    if (use > 2).any():
        found.append(f"{int((use > 2).sum())} edges with more than two triangles")
    direction = np.zeros(len(use), dtype=np.int64)
    np.add.at(direction, number, np.where(sides[:, 0] < sides[:, 1], 1, -1))
    if (turned := int((direction[use == 2] != 0).sum())) > 0:
        found.append(f"{turned} edges between triangles of opposite orientation")
    if len(np.unique(faces)) != len(mesh.points):
        found.append("points without triangle")
    if (pinched := _fans(faces, number) - len(np.unique(faces))) > 0:
        found.append(f"{pinched} points at which parts merely touch")
    if (pieces := parts(faces)) > 1:
        found.append(f"{pieces} pieces")
    if not found and (handles := 1 - (len(mesh.points) - len(use) + len(faces)) // 2) > 0:  # Euler: V - E + F = 2 - 2 handles
        found.append(f"{handles} tunnels through it")
    if mesh.volume <= 0.0:
        found.append("triangles face inwards")
    return tuple(found)


def parts(faces: Index) -> int:
    """Number of connected pieces."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    used, corner = np.unique(faces, return_inverse=True)
    corner = corner.reshape(-1, 3)
    pairs = np.vstack([corner[:, [0, 1]], corner[:, [1, 2]]])
    return int(connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(used),) * 2), directed=False)[0])


def _fans(faces: Index, number: Index) -> int:
    """Number of fans of triangles around points: one for each point of a manifold. ``number``: edge of each side."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    count = faces.size
    corner = np.arange(count).reshape(-1, 3)
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()  # corners at the two ends of each side
    order = np.argsort(number, kind="stable")
    same = number[order][1:] == number[order][:-1]
    one, other = order[:-1][same], order[1:][same]
    point = faces.ravel()
    links = []
    for a in (start, end):
        for b in (start, end):
            meet = point[a[one]] == point[b[other]]
            links.append(np.stack([a[one][meet], b[other][meet]]))
    pairs = np.hstack(links)
    return int(connected_components(coo_matrix((np.ones(pairs.shape[1]), pairs), shape=(count, count)), directed=False)[0])


def edge_lengths(mesh: Mesh) -> Array:
    """Length of every edge in metres."""
    sides = np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=2).reshape(-1, 2)
    edges = np.unique(np.sort(sides, axis=1), axis=0)
    result: Array = np.linalg.norm(mesh.points[edges[:, 0]] - mesh.points[edges[:, 1]], axis=1)
    return result


def crossed(mesh: Mesh) -> int:
    """Number of triangles that an edge of the same closed mesh pierces."""
    return int(self_crossings(mesh.points, mesh.faces, FLAT).sum())


def overlapping_in_texture(skin: FineSkin) -> int:
    """Number of triangles that share texture with another one."""
    return int(overlapping(skin.texture, TEXTURE_TOUCH).sum())
