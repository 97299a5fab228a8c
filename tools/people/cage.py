"""The fine skin as a linear function of its cage: one Loop step and a cap, both read off the triangles of the fine skin.

A person is stored as the cage alone (a quarter of the points); any such cage gives a closed fine skin whose points
and triangles are numbered as those of the reference hand.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, vstack

CAP_RINGS = 4  # as in tools/reference_hand/skin.py


def cage_faces(fine_faces: np.ndarray) -> np.ndarray:
    """Triangles (K, 3) of the cage. Fine triangles stand in four blocks (three corners, middle), those of the cap after them."""
    count = _cage_count(fine_faces)
    corner, second, third = (fine_faces[i * count : (i + 1) * count] for i in range(3))
    return np.stack([corner[:, 0], second[:, 1], third[:, 2]], axis=1)


def fine_from_cage(fine_faces: np.ndarray) -> csr_matrix:
    """S (fine points, cage points): fine = S @ cage. Loop's weights (1987), the rim along itself, the cap's rings by shares."""
    faces = cage_faces(fine_faces)
    count, n = len(faces), int(faces.max()) + 1
    middle = fine_faces[:count, 1], fine_faces[count : 2 * count, 2], fine_faces[2 * count : 3 * count, 0]
    edge_of = np.stack(middle, axis=1)  # fine point in the middle of sides (0, 1), (1, 2), (2, 0)
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
    shared = np.bincount(edge_of.ravel(), minlength=int(fine_faces.max()) + 1)
    rows, columns, values = [], [], []

    def put(row: np.ndarray, column: np.ndarray, value: np.ndarray | float) -> None:
        rows.append(row)
        columns.append(column)
        values.append(np.broadcast_to(value, np.shape(row)))

    inner = shared[edge_of] == 2
    for side in range(3):
        a, b, opposite, e, both = (*sides[:, side].T, faces[:, (side + 2) % 3], edge_of[:, side], inner[:, side])
        for end in (a, b):
            put(e, end, np.where(both, 0.375 / 2, 0.5))  # each of the two triangles brings half
        put(e[both], opposite[both], 0.125)
    ends = np.unique(np.sort(sides.reshape(-1, 2), axis=1), axis=0)
    open_side = np.sort(sides.reshape(-1, 2), axis=1)[~inner.ravel()]
    rim = np.unique(open_side)
    valence = np.bincount(ends.ravel(), minlength=n)
    beta = (0.625 - (0.375 + 0.25 * np.cos(2 * np.pi / valence)) ** 2) / valence
    free = np.ones(n, bool)
    free[rim] = False
    every = np.arange(n)
    put(every[free], every[free], (1 - valence * beta)[free])
    for a, b in (ends.T, ends.T[::-1]):
        put(a[free[a]], b[free[a]], beta[a[free[a]]])
    put(rim, rim, 0.75)
    for a, b in (open_side.T, open_side.T[::-1]):
        put(a, b, 0.125)
    total = int(fine_faces.max()) + 1
    smooth = csr_matrix(coo_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(total, n)))
    return _with_cap(smooth, fine_faces, 4 * count)


def _with_cap(smooth: csr_matrix, fine_faces: np.ndarray, first: int) -> csr_matrix:
    """Rows of the cap's rings: each point lies on the way from its point of the rim to the rim's middle."""
    cap = fine_faces[first:]
    known = int(fine_faces[:first].max()) + 1
    rim = cap[: len(cap) // (2 * CAP_RINGS - 1), 1]  # first come the triangles (next, outer, inner) of the outermost ring
    size = len(rim)
    middle = smooth[rim].mean(axis=0)
    blocks = [smooth[:known]]
    for ring in range(1, CAP_RINGS):
        share = ring / CAP_RINGS
        blocks.append(csr_matrix((1 - share) * smooth[rim] + share * np.ones((size, 1)) @ middle))
    return csr_matrix(vstack([*blocks, csr_matrix(middle)]))


def flat_rim(cage: np.ndarray, fine_faces: np.ndarray) -> np.ndarray:
    """The cage with its open rim laid into one plane, the mean plane of the rim's points."""
    faces = cage_faces(fine_faces)
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, count = np.unique(sides, axis=0, return_counts=True)
    rim = np.unique(edges[count == 1])
    middle = cage[rim].mean(axis=0)
    normal = np.linalg.svd(cage[rim] - middle)[2][2]
    flat = cage.copy()
    flat[rim] -= ((cage[rim] - middle) @ normal)[:, None] * normal
    return flat


def _cage_count(fine_faces: np.ndarray) -> int:
    """Triangles of the cage: as long as the blocks' corners agree (point ``e01`` of block one is that of block two)."""
    for count in range(len(fine_faces) // 4, 0, -1):
        a, b, _, d = (fine_faces[i * count : (i + 1) * count] for i in range(4))
        if len(d) == count and (a[:, 1] == b[:, 0]).all() and (d == np.stack([a[:, 1], b[:, 2], a[:, 2]], axis=1)).all():
            return count
    raise ValueError("these triangles are not a subdivided cage with a cap")
