"""Skin of the reference hand: the fine one for the eye, the even one for physics, and how the first sits on the second."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pyacvd
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from .skeleton import polydata

FOREARM_END = -0.045  # the skin is cut here (frame of the placed bones) and capped
EVEN_POINTS = 1500
CAP_RINGS = 4
TEXTURE_MARGIN = 0.004  # between charts, so that filtering does not bleed


@dataclass
class FineMesh:
    """Closed triangle mesh with texture coordinates per corner."""

    points: np.ndarray
    faces: np.ndarray
    texture: np.ndarray  # (M, 3, 2)


def fine_skin(points: np.ndarray, quads: np.ndarray, texture: np.ndarray, texture_quads: np.ndarray) -> FineMesh:
    """The source's quads up to the forearm cut, capped, then one Loop subdivision: nails and creases stay."""
    keep = (points[quads][:, :, 0] > FOREARM_END - 0.004).all(axis=1)
    corners = np.vstack([quads[keep][:, [0, 1, 2]], quads[keep][:, [0, 2, 3]]])
    uv = texture[np.vstack([texture_quads[keep][:, [0, 1, 2]], texture_quads[keep][:, [0, 2, 3]]])]
    used, faces = np.unique(corners, return_inverse=True)
    points, faces = points[used].copy(), faces.reshape(-1, 3)
    faces, uv = _largest_part(faces, uv)
    used, faces = np.unique(faces, return_inverse=True)
    points, faces = points[used], faces.reshape(-1, 3)
    rim = _boundary(faces)
    points[rim, 0] = FOREARM_END
    points, faces, uv = _loop_subdivide(points, faces, uv)
    rim = _boundary(faces)
    points[rim, 0] = FOREARM_END
    return _with_cap(points, faces, uv, rim)


def packed_texture(fine: FineMesh) -> np.ndarray:
    """The charts of the texture laid side by side in the unit square, each scaled to its area on the skin."""
    faces = np.unique(np.round(fine.texture.reshape(-1, 2), 6), axis=0, return_inverse=True)[1]
    label = _parts(faces.reshape(-1, 3))
    area = np.linalg.norm(np.cross(*(fine.points[fine.faces[:, i]] - fine.points[fine.faces[:, 0]] for i in (1, 2))), axis=1)
    packed = np.zeros_like(fine.texture)
    charts = sorted(np.unique(label), key=lambda chart: -area[label == chart].sum())
    x = y = row = 0.0
    for number, chart in enumerate(charts):
        uv = fine.texture[label == chart]
        side = np.stack([uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]], axis=1)
        uv = (uv - uv.min(axis=(0, 1))) * np.sqrt(area[label == chart].sum() / np.abs(np.linalg.det(side)).sum())
        width, height = uv.max(axis=(0, 1))
        if number == 1:  # the hand fills the first row, the small charts stand above it
            x, y, row = 0.0, row + TEXTURE_MARGIN, 0.0
        packed[label == chart] = uv + np.array([x, y])
        x, row = x + width + TEXTURE_MARGIN, max(row, height)
    size = packed.max()
    return TEXTURE_MARGIN + packed / size * (1 - 2 * TEXTURE_MARGIN)


def even_skin(fine: FineMesh) -> tuple[np.ndarray, np.ndarray]:
    """About 3,000 even triangles by centroidal clustering (pyacvd) of the fine skin."""
    mesh = polydata(fine.points, fine.faces).subdivide(2, "linear")  # clusters need many small triangles each
    clustering = pyacvd.Clustering(mesh)
    clustering.cluster(EVEN_POINTS)
    even = clustering.create_mesh().compute_normals(auto_orient_normals=True, consistent_normals=True, split_vertices=False)
    if not even.is_manifold or even.n_open_edges:
        raise RuntimeError("the even skin is not closed")
    points, faces = np.asarray(even.points, float), even.faces.reshape(-1, 4)[:, 1:].astype(np.int64)
    end = fine.points[:, 0].min()
    points[points[:, 0] < end + 0.0015, 0] = end  # the cap is flat
    order = np.lexsort(np.round(points, 5).T[::-1])  # distal last: a fixed, explainable order
    rank = np.argsort(order)
    faces = rank[faces]
    faces = np.array([np.roll(face, -int(np.argmin(face))) for face in faces])
    return points[order], faces[np.lexsort(faces.T[::-1])]


def bind(fine: np.ndarray, points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangle, barycentric coordinates and height of fine points over the even skin.

    Solves fine = sum b_i (p_i + h n_i) by Newton on the nearest triangles; the best solution wins.
    """
    normals = vertex_normals(points, faces)
    centres = points[faces].mean(axis=1)
    _, candidates = cKDTree(centres).query(fine, k=24)
    best = np.full(len(fine), np.inf)
    triangle = np.zeros(len(fine), dtype=np.int64)
    barycentric, height = np.full((len(fine), 3), 1 / 3), np.zeros(len(fine))
    for column in range(candidates.shape[1]):
        face = candidates[:, column]
        p, n = points[faces[face]], normals[faces[face]]
        x = np.zeros((len(fine), 3))  # b1, b2, h
        x[:, :2] = 1 / 3
        for _ in range(12):
            b = np.stack([1 - x[:, 0] - x[:, 1], x[:, 0], x[:, 1]], axis=1)
            q = p + x[:, 2, None, None] * n
            residual = (b[:, :, None] * q).sum(axis=1) - fine
            jacobian = np.stack([q[:, 1] - q[:, 0], q[:, 2] - q[:, 0], (b[:, :, None] * n).sum(axis=1)], axis=2)
            x -= np.linalg.solve(jacobian, residual[:, :, None])[:, :, 0]
        b = np.stack([1 - x[:, 0] - x[:, 1], x[:, 0], x[:, 1]], axis=1)
        outside = np.maximum(0, -b.min(axis=1))
        missed = np.linalg.norm((b[:, :, None] * (p + x[:, 2, None, None] * n)).sum(axis=1) - fine, axis=1)
        cost = outside * 0.01 + np.abs(x[:, 2])
        cost[~np.isfinite(cost) | (outside > 1.0) | ~(missed < 1e-8)] = np.inf
        better = cost < best - 1e-9
        best[better], triangle[better] = cost[better], face[better]
        barycentric[better], height[better] = b[better], x[better, 2]
    if not np.isfinite(best).all():
        raise RuntimeError(f"{int((~np.isfinite(best)).sum())} fine points could not be bound to the even skin")
    return triangle, barycentric, height


def vertex_normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit vertex normals, faces weighted by area."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for i in range(3):
        np.add.at(normals, faces[:, i], area)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _parts(faces: np.ndarray) -> np.ndarray:
    """Label of each face's connected part."""
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]]])
    size = int(faces.max()) + 1
    return connected_components(coo_matrix((np.ones(len(edges)), edges.T), shape=(size, size)))[1][faces[:, 0]]


def _largest_part(faces: np.ndarray, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    part = _parts(faces)
    keep = part == np.argmax(np.bincount(part))
    return faces[keep], uv[keep]


def _edges(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unique edges, the edge number of each face's side (i, i + 1), and how many faces share each edge."""
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, number, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    return edges, number.reshape(-1, 3), count


def _boundary(faces: np.ndarray) -> np.ndarray:
    """Points of the single open rim, in order."""
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    known = {tuple(side) for side in sides.tolist()}
    following = {a: b for a, b in known if (b, a) not in known}
    start = min(following)
    rim = [start]
    while following[rim[-1]] != start:
        rim.append(following[rim[-1]])
    if len(rim) != len(following):
        raise RuntimeError("the skin has more than one opening")
    return np.array(rim)


def _loop_subdivide(points: np.ndarray, faces: np.ndarray, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One step of Loop's scheme (1987) for points; texture coordinates are halved linearly within each face."""
    edges, number, count = _edges(faces)
    n = len(points)
    middle = points[edges].mean(axis=1)
    opposite = np.zeros((len(edges), 3))
    for side in range(3):
        np.add.at(opposite, number[:, side], points[faces[:, (side + 2) % 3]])
    inner = count == 2
    middle[inner] = 0.75 * middle[inner] + 0.125 * opposite[inner]
    around, valence = np.zeros((n, 3)), np.zeros(n)
    for a, b in ((0, 1), (1, 0)):
        np.add.at(around, edges[:, a], points[edges[:, b]])
        np.add.at(valence, edges[:, a], 1.0)
    beta = (0.625 - (0.375 + 0.25 * np.cos(2 * np.pi / valence)) ** 2) / valence
    moved = (1 - valence * beta)[:, None] * points + beta[:, None] * around
    rim = np.unique(edges[~inner])
    along = np.zeros((n, 3))
    for a, b in ((0, 1), (1, 0)):
        np.add.at(along, edges[~inner][:, a], points[edges[~inner][:, b]])
    moved[rim] = 0.75 * points[rim] + 0.125 * along[rim]
    e = number + n
    a, b, c = faces.T
    new = np.concatenate(
        [np.stack(t, axis=1) for t in ((a, e[:, 0], e[:, 2]), (e[:, 0], b, e[:, 1]), (e[:, 2], e[:, 1], c), (e[:, 0], e[:, 1], e[:, 2]))]
    )
    half = (uv + np.roll(uv, -1, axis=1)) / 2
    ua, ub, uc = uv[:, 0], uv[:, 1], uv[:, 2]
    h0, h1, h2 = half[:, 0], half[:, 1], half[:, 2]
    new_uv = np.concatenate([np.stack(t, axis=1) for t in ((ua, h0, h2), (h0, ub, h1), (h2, h1, uc), (h0, h1, h2))])
    return np.vstack([moved, middle]), new, new_uv


def _with_cap(points: np.ndarray, faces: np.ndarray, uv: np.ndarray, rim: np.ndarray) -> FineMesh:
    """Close the forearm with rings towards its middle; the cap gets a disc of its own in the texture."""
    middle = points[rim].mean(axis=0)
    rings, news = [rim], []
    total = len(points)
    for ring in range(1, CAP_RINGS):
        news.append(middle + (points[rim] - middle) * (1 - ring / CAP_RINGS))
        rings.append(total + np.arange(len(rim)))
        total += len(rim)
    news.append(middle[None])
    cap = []
    for outer, inner in pairwise(rings):
        o2, i2 = np.roll(outer, -1), np.roll(inner, -1)
        cap += [np.stack([o2, outer, inner], axis=1), np.stack([o2, inner, i2], axis=1)]
    last = rings[-1]
    cap.append(np.stack([np.roll(last, -1), last, np.full(len(last), total)], axis=1))
    points = np.vstack([points, *news])
    cap_faces = np.vstack(cap)
    flat = (points[:, 1:] - middle[1:]) / np.abs(points[rim, 1:] - middle[1:]).max()
    return FineMesh(points, np.vstack([faces, cap_faces]), np.concatenate([uv, flat[cap_faces]]))
