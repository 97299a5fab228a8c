"""The biharmonic sum over many points, in blocks that stay in the cache."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled, fused

Array = NDArray[np.float64]

BLOCK = 128  # points: their six rows stay in the first cache, whatever else has been there before
LINE = 8  # numbers in a line of the cache: rows that begin with one are read in one go
TINY = 1e-300  # m^2, keeps the root of nothing finite

# 1/sqrt(d) from half the bits of d, then one step of Newton's: g with d g g within 0.13 % of MIDDLE. What is left is a cubic.
HALVED = np.int64(0x5FE40007B8D80000)
STEP = 2.389269251912676
MIDDLE = 2.0180282337959623
CUBIC = (0.703941194814157, 0.17441311846516044, 0.0648206986857195, 0.02676733844429065)  # 1/sqrt(MIDDLE - h), |h| < 0.0027


@fused
def evaluate(points: Array, centre: Array, weight: Array, linear: Array, shift: Array, out: Array) -> None:
    """out = sum_i weight_i |x - centre_i| + linear x + shift for ``points`` (3 M,), x y z after one another, like ``out``.

    Three centres at a time: the processor has one unit for roots and several for products, so two distances come from roots and
    the third from products alone (``_root``), in the meantime. Coordinates lie in rows, so that eight points run abreast.
    """
    n, count = len(points) // 3, centre.shape[0]
    room = np.empty(6 * BLOCK + LINE)
    first = (-room.ctypes.data // 8) % LINE
    rows = room[first : first + 6 * BLOCK]
    x, y, z = rows[:BLOCK], rows[BLOCK : 2 * BLOCK], rows[2 * BLOCK : 3 * BLOCK]
    u, v, w = rows[3 * BLOCK : 4 * BLOCK], rows[4 * BLOCK : 5 * BLOCK], rows[5 * BLOCK :]
    ux, uy, uz, u0 = linear[0, 0], linear[0, 1], linear[0, 2], shift[0]
    vx, vy, vz, v0 = linear[1, 0], linear[1, 1], linear[1, 2], shift[1]
    wx, wy, wz, w0 = linear[2, 0], linear[2, 1], linear[2, 2], shift[2]
    for begin in range(0, n, BLOCK):
        size = min(BLOCK, n - begin)
        given, found = points[3 * begin : 3 * (begin + size)], out[3 * begin : 3 * (begin + size)]
        for k in range(size):
            p, q, r = given[3 * k], given[3 * k + 1], given[3 * k + 2]
            x[k], y[k], z[k] = p, q, r
            u[k] = ux * p + uy * q + uz * r + u0
            v[k] = vx * p + vy * q + vz * r + v0
            w[k] = wx * p + wy * q + wz * r + w0
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
            found[3 * k], found[3 * k + 1], found[3 * k + 2] = u[k], v[k], w[k]


@fused
def _root(d: float) -> float:
    """sqrt(d), d > 0, within 1e-13 of itself, by products alone."""
    g = np.int64(HALVED - (np.float64(d).view(np.int64) >> 1)).view(np.float64)
    g *= STEP - d * g * g
    t = d * g
    h = MIDDLE - t * g
    return t * (CUBIC[0] + h * (CUBIC[1] + h * (CUBIC[2] + h * CUBIC[3])))


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
