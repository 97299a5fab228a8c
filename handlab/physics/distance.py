"""Distances to triangles and winding numbers: arrays in, arrays out, compiled."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@compiled
def closest(points: Array, corners: Array) -> tuple[Array, Index, Array]:
    """Nearest place on triangles ``corners`` (M, 3, 3) to each of ``points`` (N, 3).

    Returns distance (N,), triangle (N,) and place (N, 3). Regions of a triangle as in Ericson, Real-Time Collision
    Detection, 5.1.5.
    """
    n = points.shape[0]
    distance = np.full(n, np.inf)
    triangle = np.zeros(n, dtype=np.int64)
    place = np.zeros((n, 3))
    q = np.empty(3)
    for i in range(n):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        best = np.inf
        for t in range(corners.shape[0]):
            ax, ay, az = corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2]
            ux, uy, uz = corners[t, 1, 0] - ax, corners[t, 1, 1] - ay, corners[t, 1, 2] - az
            vx, vy, vz = corners[t, 2, 0] - ax, corners[t, 2, 1] - ay, corners[t, 2, 2] - az
            wx, wy, wz = px - ax, py - ay, pz - az
            uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
            d1, d2 = ux * wx + uy * wy + uz * wz, vx * wx + vy * wy + vz * wz
            d3, d4, d5, d6 = d1 - uu, d2 - uv, d1 - uv, d2 - vv
            vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
            if d1 <= 0.0 and d2 <= 0.0:
                s, r = 0.0, 0.0
            elif d3 >= 0.0 and d4 <= d3:
                s, r = 1.0, 0.0
            elif d6 >= 0.0 and d5 <= d6:
                s, r = 0.0, 1.0
            elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
                s, r = d1 / (d1 - d3), 0.0
            elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
                s, r = 0.0, d2 / (d2 - d6)
            elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
                r = (d4 - d3) / ((d4 - d3) + (d5 - d6))
                s = 1.0 - r
            else:
                s, r = vb / (va + vb + vc), vc / (va + vb + vc)
            q[0], q[1], q[2] = ax + s * ux + r * vx, ay + s * uy + r * vy, az + s * uz + r * vz
            square = (px - q[0]) ** 2 + (py - q[1]) ** 2 + (pz - q[2]) ** 2
            if square < best:
                best = square
                triangle[i] = t
                place[i, 0], place[i, 1], place[i, 2] = q[0], q[1], q[2]
        distance[i] = math.sqrt(best)
    return distance, triangle, place


@compiled
def winding(points: Array, corners: Array) -> Array:
    """How often the surface ``corners`` (M, 3, 3) winds about each point: 1 inside once, 2 inside two parts of it, 0 outside.

    Sum of solid angles over 4 pi (van Oosterom and Strackee 1983).
    """
    result = np.zeros(points.shape[0])
    for i in range(points.shape[0]):
        total = 0.0
        for t in range(corners.shape[0]):
            ax, ay, az = corners[t, 0, 0] - points[i, 0], corners[t, 0, 1] - points[i, 1], corners[t, 0, 2] - points[i, 2]
            bx, by, bz = corners[t, 1, 0] - points[i, 0], corners[t, 1, 1] - points[i, 1], corners[t, 1, 2] - points[i, 2]
            cx, cy, cz = corners[t, 2, 0] - points[i, 0], corners[t, 2, 1] - points[i, 1], corners[t, 2, 2] - points[i, 2]
            la = math.sqrt(ax * ax + ay * ay + az * az)
            lb = math.sqrt(bx * bx + by * by + bz * bz)
            lc = math.sqrt(cx * cx + cy * cy + cz * cz)
            volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
            ab, bc, ca = ax * bx + ay * by + az * bz, bx * cx + by * cy + bz * cz, cx * ax + cy * ay + cz * az
            below = la * lb * lc + ab * lc + bc * la + ca * lb
            total += 2.0 * math.atan2(volume, below)
        result[i] = total / (4.0 * math.pi)
    return result
