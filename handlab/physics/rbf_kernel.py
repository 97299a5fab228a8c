"""The biharmonic sum over many points, in blocks that stay in the cache."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled, fused

Array = NDArray[np.float64]

BLOCK = 256
HALVED = np.int64(0x5FE6EB50C7B537A9)  # minus half the bits of d are those of 1/sqrt(d) within 3.5 %
TINY = 1e-300  # m^2, keeps the root of nothing finite


@fused
def evaluate(points: Array, centre: Array, weight: Array, linear: Array, shift: Array, out: Array) -> None:
    """out = sum_i weight_i |x - centre_i| + linear x + shift for ``points`` (M, 3); coordinates lie in rows, so that roots run abreast.

    Three centres at a time: the processor has one unit for roots and several for products, so two distances come from roots and
    the third from products alone (``_root``), in the meantime.
    """
    n, count = points.shape[0], centre.shape[0]
    x, y, z = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    u, v, w = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    for begin in range(0, n, BLOCK):
        size = min(BLOCK, n - begin)
        for k in range(size):
            x[k], y[k], z[k] = points[begin + k, 0], points[begin + k, 1], points[begin + k, 2]
        for k in range(size):
            u[k] = linear[0, 0] * x[k] + linear[0, 1] * y[k] + linear[0, 2] * z[k] + shift[0]
            v[k] = linear[1, 0] * x[k] + linear[1, 1] * y[k] + linear[1, 2] * z[k] + shift[1]
            w[k] = linear[2, 0] * x[k] + linear[2, 1] * y[k] + linear[2, 2] * z[k] + shift[2]
        for i in range(0, count - 2, 3):
            ax, ay, az = centre[i, 0], centre[i, 1], centre[i, 2]
            bx, by, bz = centre[i + 1, 0], centre[i + 1, 1], centre[i + 1, 2]
            cx, cy, cz = centre[i + 2, 0], centre[i + 2, 1], centre[i + 2, 2]
            au, av, aw = weight[i, 0], weight[i, 1], weight[i, 2]
            bu, bv, bw = weight[i + 1, 0], weight[i + 1, 1], weight[i + 1, 2]
            cu, cv, cw = weight[i + 2, 0], weight[i + 2, 1], weight[i + 2, 2]
            for k in range(size):
                r = math.sqrt((x[k] - ax) ** 2 + (y[k] - ay) ** 2 + (z[k] - az) ** 2)
                s = math.sqrt((x[k] - bx) ** 2 + (y[k] - by) ** 2 + (z[k] - bz) ** 2)
                t = _root(TINY + (x[k] - cx) ** 2 + (y[k] - cy) ** 2 + (z[k] - cz) ** 2)
                u[k] = cu * t + (bu * s + (au * r + u[k]))
                v[k] = cv * t + (bv * s + (av * r + v[k]))
                w[k] = cw * t + (bw * s + (aw * r + w[k]))
        for i in range(count - count % 3, count):
            ax, ay, az = centre[i, 0], centre[i, 1], centre[i, 2]
            au, av, aw = weight[i, 0], weight[i, 1], weight[i, 2]
            for k in range(size):
                r = math.sqrt((x[k] - ax) ** 2 + (y[k] - ay) ** 2 + (z[k] - az) ** 2)
                u[k] += au * r
                v[k] += av * r
                w[k] += aw * r
        for k in range(size):
            out[begin + k, 0], out[begin + k, 1], out[begin + k, 2] = u[k], v[k], w[k]


@fused
def _root(d: float) -> float:
    """sqrt(d), d > 0, within 3e-12 of itself, by products alone: two steps of Householder's method of third order for 1/sqrt(d)."""
    g = np.int64(HALVED - (np.float64(d).view(np.int64) >> 1)).view(np.float64)
    h = 1.0 - d * g * g
    g += g * h * (0.5 + 0.375 * h)
    t = d * g
    h = 1.0 - t * g
    return t + t * h * (0.5 + 0.375 * h)


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
