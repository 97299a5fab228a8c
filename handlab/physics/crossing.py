"""Triangles that cross: edges through faces, lines that meet a surface, overlaps in the plane. Arrays in, arrays out, compiled."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]

FLAT = 1e-9  # metres: a point this near to a triangle's plane lies in it, so that a flat cap does not cross itself


@compiled
def _six_volumes(a: Array, b: Array, c: Array, d: Array) -> float:
    """Six times the signed volume of a tetrahedron."""
    ux, uy, uz = a[0] - d[0], a[1] - d[1], a[2] - d[2]
    vx, vy, vz = b[0] - d[0], b[1] - d[1], b[2] - d[2]
    wx, wy, wz = c[0] - d[0], c[1] - d[1], c[2] - d[2]
    return float(ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx))


@compiled
def _double_area(a: Array, b: Array, c: Array) -> float:
    """Length of the normal of a triangle."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    return math.sqrt((uy * vz - uz * vy) ** 2 + (uz * vx - ux * vz) ** 2 + (ux * vy - uy * vx) ** 2)


@compiled
def self_crossings(points: Array, faces: Index, flat: float) -> Mask:
    """Which triangles (M,) of a mesh are pierced by an edge of a triangle with which they share no corner of that edge.

    ``points`` (N, 3), ``faces`` (M, 3). Where two triangles cross, an edge of one pierces the other, so none is missed,
    apart from triangles in one plane. ``flat``: distance to a plane that counts as none.
    """
    m = faces.shape[0]
    low, high = np.empty((m, 3)), np.empty((m, 3))
    for t in range(m):
        for i in range(3):
            a, b, c = points[faces[t, 0], i], points[faces[t, 1], i], points[faces[t, 2], i]
            low[t, i], high[t, i] = min(a, b, c), max(a, b, c)
    order = np.argsort(low[:, 0])
    starts = low[order, 0]
    widest = (high[:, 0] - low[:, 0]).max()
    pierced = np.zeros(m, dtype=np.bool_)
    for t in range(m):
        for side in range(3):
            v, w = faces[t, side], faces[t, (side + 1) % 3]
            if v > w:  # every edge of a closed mesh comes twice, once in each direction
                continue
            p, q = points[v], points[w]
            x0, x1 = min(p[0], q[0]), max(p[0], q[0])
            for k in range(np.searchsorted(starts, x0 - widest), np.searchsorted(starts, x1, side="right")):
                s = order[k]
                if high[s, 0] < x0 or high[s, 1] < min(p[1], q[1]) or low[s, 1] > max(p[1], q[1]):
                    continue
                if high[s, 2] < min(p[2], q[2]) or low[s, 2] > max(p[2], q[2]):
                    continue
                f, g, h = faces[s, 0], faces[s, 1], faces[s, 2]
                if v in (f, g, h) or w in (f, g, h):
                    continue
                a, b, c = points[f], points[g], points[h]
                thick = flat * _double_area(a, b, c)
                above, below = _six_volumes(a, b, c, p), _six_volumes(a, b, c, q)
                if abs(above) <= thick or abs(below) <= thick or (above > 0.0) == (below > 0.0):
                    continue
                one, two, three = _six_volumes(p, q, a, b), _six_volumes(p, q, b, c), _six_volumes(p, q, c, a)
                if (one > 0.0 and two > 0.0 and three > 0.0) or (one < 0.0 and two < 0.0 and three < 0.0):
                    pierced[s] = True
    return pierced


@compiled
def leaving(origins: Array, direction: Array, corners: Array) -> Array:
    """How far (N,) each line from ``origins`` (N, 3) runs along the unit ``direction`` (3,) until it first leaves the surface.

    ``corners`` (M, 3, 3) of triangles that face outwards; infinity where the line leaves through none (Moeller and Trumbore 1997).
    """
    result = np.full(origins.shape[0], np.inf)
    dx, dy, dz = direction[0], direction[1], direction[2]
    for t in range(corners.shape[0]):
        ax, ay, az = corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2]
        ux, uy, uz = corners[t, 1, 0] - ax, corners[t, 1, 1] - ay, corners[t, 1, 2] - az
        vx, vy, vz = corners[t, 2, 0] - ax, corners[t, 2, 1] - ay, corners[t, 2, 2] - az
        px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
        volume = ux * px + uy * py + uz * pz
        if volume >= 0.0:  # a face that looks towards the line's origin
            continue
        for i in range(origins.shape[0]):
            sx, sy, sz = origins[i, 0] - ax, origins[i, 1] - ay, origins[i, 2] - az
            first = (sx * px + sy * py + sz * pz) / volume
            if first < 0.0 or first > 1.0:
                continue
            qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
            second = (dx * qx + dy * qy + dz * qz) / volume
            if second < 0.0 or first + second > 1.0:
                continue
            far = (vx * qx + vy * qy + vz * qz) / volume
            if 0.0 <= far < result[i]:
                result[i] = far
    return result


@compiled
def overlapping(corners: Array, least: float) -> Mask:
    """Which triangles ``corners`` (M, 3, 2) of a plane overlap another one by more than ``least`` in every direction.

    Separating axes: two triangles overlap unless they lie apart across the direction of one of their six sides.
    """
    m = corners.shape[0]
    low, high = np.empty((m, 2)), np.empty((m, 2))
    for t in range(m):
        for i in range(2):
            low[t, i], high[t, i] = corners[t, :, i].min(), corners[t, :, i].max()
    order = np.argsort(low[:, 0])
    found = np.zeros(m, dtype=np.bool_)
    for rank in range(m):
        s = order[rank]
        for other in range(rank + 1, m):
            t = order[other]
            if low[t, 0] >= high[s, 0] - least:
                break
            if low[t, 1] >= high[s, 1] - least or high[t, 1] <= low[s, 1] + least:
                continue
            apart = False
            for side in range(6):
                owner, i = (s, side) if side < 3 else (t, side - 3)
                x = corners[owner, (i + 1) % 3, 1] - corners[owner, i, 1]
                y = corners[owner, i, 0] - corners[owner, (i + 1) % 3, 0]
                length = math.sqrt(x * x + y * y)
                if length == 0.0:
                    continue
                low_s, high_s, low_t, high_t = np.inf, -np.inf, np.inf, -np.inf
                for c in range(3):
                    here = (corners[s, c, 0] * x + corners[s, c, 1] * y) / length
                    there = (corners[t, c, 0] * x + corners[t, c, 1] * y) / length
                    low_s, high_s = min(low_s, here), max(high_s, here)
                    low_t, high_t = min(low_t, there), max(high_t, there)
                if min(high_s, high_t) - max(low_s, low_t) <= least:
                    apart = True
                    break
            if not apart:
                found[s] = found[t] = True
    return found
