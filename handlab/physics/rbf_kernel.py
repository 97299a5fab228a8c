"""The biharmonic sum over many points, in blocks that stay in the cache."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]

BLOCK = 256


@compiled
def evaluate(points: Array, centre: Array, weight: Array, linear: Array, shift: Array, out: Array) -> None:
    """out = sum_i weight_i |x - centre_i| + linear x + shift for ``points`` (M, 3); coordinates lie in rows, so that roots run abreast."""
    n, count = points.shape[0], centre.shape[0]
    x, y, z = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    u, v, w = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    for begin in range(0, n, BLOCK):
        size = min(BLOCK, n - begin)
        for k in range(size):
            a, b, c = points[begin + k, 0], points[begin + k, 1], points[begin + k, 2]
            x[k], y[k], z[k] = a, b, c
            u[k] = linear[0, 0] * a + linear[0, 1] * b + linear[0, 2] * c + shift[0]
            v[k] = linear[1, 0] * a + linear[1, 1] * b + linear[1, 2] * c + shift[1]
            w[k] = linear[2, 0] * a + linear[2, 1] * b + linear[2, 2] * c + shift[2]
        # two centres at a time: half as many passes over the sums
        for i in range(0, count - 1, 2):
            sx, sy, sz = centre[i, 0], centre[i, 1], centre[i, 2]
            tx, ty, tz = centre[i + 1, 0], centre[i + 1, 1], centre[i + 1, 2]
            wx, wy, wz = weight[i, 0], weight[i, 1], weight[i, 2]
            qx, qy, qz = weight[i + 1, 0], weight[i + 1, 1], weight[i + 1, 2]
            for k in range(size):
                dx, dy, dz = x[k] - sx, y[k] - sy, z[k] - sz
                ex, ey, ez = x[k] - tx, y[k] - ty, z[k] - tz
                r = math.sqrt(dx * dx + dy * dy + dz * dz)
                s = math.sqrt(ex * ex + ey * ey + ez * ez)
                u[k] += wx * r + qx * s
                v[k] += wy * r + qy * s
                w[k] += wz * r + qz * s
        if count % 2:
            sx, sy, sz = centre[count - 1, 0], centre[count - 1, 1], centre[count - 1, 2]
            wx, wy, wz = weight[count - 1, 0], weight[count - 1, 1], weight[count - 1, 2]
            for k in range(size):
                dx, dy, dz = x[k] - sx, y[k] - sy, z[k] - sz
                r = math.sqrt(dx * dx + dy * dy + dz * dz)
                u[k] += wx * r
                v[k] += wy * r
                w[k] += wz * r
        for k in range(size):
            out[begin + k, 0], out[begin + k, 1], out[begin + k, 2] = u[k], v[k], w[k]


@compiled
def jacobian(points: Array, centre: Array, weight: Array, linear: Array, out: Array) -> None:
    """out (M, 3, 3): derivative of the sum by x; at a centre its own kink is left out (the mean of both sides)."""
    for k in range(points.shape[0]):
        for a in range(3):
            for b in range(3):
                out[k, a, b] = linear[a, b]
        for i in range(centre.shape[0]):
            dx, dy, dz = points[k, 0] - centre[i, 0], points[k, 1] - centre[i, 1], points[k, 2] - centre[i, 2]
            r = math.sqrt(dx * dx + dy * dy + dz * dz)
            if r > 0.0:
                dx, dy, dz = dx / r, dy / r, dz / r
                for a in range(3):
                    out[k, a, 0] += weight[i, a] * dx
                    out[k, a, 1] += weight[i, a] * dy
                    out[k, a, 2] += weight[i, a] * dz
