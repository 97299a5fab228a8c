"""The compiled part of geometric muscles: where every ellipsoid is, and where a line meets a surface."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LONGEST = 32  # control points of one fibre, at most
STILL = 1e-12  # squared metres below which a direction means nothing


class Chains(NamedTuple):
    """Fibres of all muscles as arrays: ``f`` fibres, ``n`` control points, ``s`` segments, in order from fixed to other end.

    ``first_node``, ``nodes``, ``grid`` (f,); segments of fibre k begin at ``first_node[k] - k``. ``drive`` (grid, drives): rows of
    the contraction, or -1. ``free`` (f,): 1 where the last point hangs on no bone.
    ``body`` (n, 2), ``share`` (n, 2): bodies that carry a point; ``point``, ``outward`` (n, 3) in the bind posture.
    ``length``, ``width``, ``height`` (s,): rest length, half width and half height in metres; ``low``, ``high`` (s,): bounds of the
    half height; ``bell`` (s,), ``surplus`` (s,): bell weight, and what it is above the fibre's mean; ``confined`` (s,): 1 where
    neighbours leave no room sideways.
    """

    first_node: Index
    nodes: Index
    grid: Index
    free: Index
    drive: Index
    body: Index
    share: Array
    point: Array
    outward: Array
    length: Array
    width: Array
    height: Array
    low: Array
    high: Array
    bell: Array
    surplus: Array
    confined: Index


@compiled
def shape_into(
    chains: Chains,
    transforms: Array,
    contraction: Array,
    recalled: bool,
    overlap: float,
    shortening: float,
    transfer: float,
    free_shortening: float,
    centre: Array,
    frame: Array,
    half: Array,
) -> None:
    """Fill ``centre`` (s, 3), ``frame`` (s, 3, 3), ``half`` (s, 3) from ``transforms`` (body, 4, 4) and ``contraction`` (muscle,)."""
    first_node, nodes, grid, free, drive = chains.first_node, chains.nodes, chains.grid, chains.free, chains.drive
    body, share, point, outward = chains.body, chains.share, chains.point, chains.outward
    length, width, height, low, high = chains.length, chains.width, chains.height, chains.low, chains.high
    bell, surplus, confined = chains.bell, chains.surplus, chains.confined
    p, up, arc = np.empty((LONGEST, 3)), np.empty((LONGEST, 3)), np.empty(LONGEST)
    for f in range(first_node.shape[0]):
        start, count = first_node[f], nodes[f]
        s = start - f
        c = 0.0
        for k in range(drive.shape[1]):
            row = drive[grid[f], k]
            if row >= 0:
                c = max(c, contraction[row])
        c = min(max(c, 0.0), 1.0)
        for i in range(count):
            n = start + i
            b, o = body[n, 0], body[n, 1]
            w, v = share[n, 0], share[n, 1]
            x, y, z = point[n, 0], point[n, 1], point[n, 2]
            nx, ny, nz = outward[n, 0], outward[n, 1], outward[n, 2]
            for d in range(3):
                m0, m1, m2, m3 = transforms[b, d, 0], transforms[b, d, 1], transforms[b, d, 2], transforms[b, d, 3]
                if v > 0.0:
                    m0, m1 = w * m0 + v * transforms[o, d, 0], w * m1 + v * transforms[o, d, 1]
                    m2, m3 = w * m2 + v * transforms[o, d, 2], w * m3 + v * transforms[o, d, 3]
                p[i, d] = m0 * x + m1 * y + m2 * z + m3
                up[i, d] = m0 * nx + m1 * ny + m2 * nz
            arc[i] = 0.0
            if i > 0:
                arc[i] = arc[i - 1] + math.sqrt((p[i, 0] - p[i - 1, 0]) ** 2 + (p[i, 1] - p[i - 1, 1]) ** 2 + (p[i, 2] - p[i - 1, 2]) ** 2)
        # How far the last point is along the line: at its end, unless it hangs on no bone.
        reach = arc[count - 1]
        if free[f] == 1:
            reach *= max(1.0 - c, 0.01) if recalled else 1.0 - free_shortening * c
        total = 0.0
        for i in range(count - 1):
            total += length[s + i] * (1.0 - shortening * c * bell[s + i])
        # Inner points are spaced anew along the line; a segment that lengthens anywhere is felt by all, as fibres slide.
        walked, k = 0.0, 0
        ax, ay, az = p[0, 0], p[0, 1], p[0, 2]
        ux, uy, uz = up[0, 0], up[0, 1], up[0, 2]
        for i in range(count - 1):
            e = s + i
            walked += length[e] * (1.0 - shortening * c * bell[e])
            at = reach * walked / total
            while k < count - 2 and arc[k + 1] < at:
                k += 1
            step = arc[k + 1] - arc[k]
            r = min(max((at - arc[k]) / step, 0.0), 1.0) if step > 0.0 else 0.0
            bx, by, bz = p[k, 0] + r * (p[k + 1, 0] - p[k, 0]), p[k, 1] + r * (p[k + 1, 1] - p[k, 1]), p[k, 2] + r * (p[k + 1, 2] - p[k, 2])
            vx, vy, vz = (1 - r) * up[k, 0] + r * up[k + 1, 0], (1 - r) * up[k, 1] + r * up[k + 1, 1], (1 - r) * up[k, 2] + r * up[k + 1, 2]
            dx, dy, dz = bx - ax, by - ay, bz - az
            long = math.sqrt(dx * dx + dy * dy + dz * dz)
            if long * long > STILL:
                dx, dy, dz = dx / long, dy / long, dz / long
            else:
                dx, dy, dz = 1.0, 0.0, 0.0
            zx, zy, zz = ux + vx, uy + vy, uz + vz
            along = zx * dx + zy * dy + zz * dz
            zx, zy, zz = zx - along * dx, zy - along * dy, zz - along * dz
            size = zx * zx + zy * zy + zz * zz
            if size < STILL:  # the fibre runs along the normal: any direction across it will do
                if abs(dx) < 0.7:
                    zx, zy, zz = 1.0 - dx * dx, -dx * dy, -dx * dz
                else:
                    zx, zy, zz = -dx * dy, 1.0 - dy * dy, -dy * dz
                size = zx * zx + zy * zy + zz * zz
            size = math.sqrt(size)
            zx, zy, zz = zx / size, zy / size, zz / size
            q = max(long, 1e-6) / length[e]
            if recalled:
                wide, tall = 1.0, 1.0 + 2.0 * (1.0 - q)
            else:
                area = (1.0 + transfer * c * surplus[e]) / q
                if confined[e] == 1:
                    wide, tall = 1.0, area
                else:
                    wide = tall = math.sqrt(area)
            c_half = min(max(height[e] * tall, low[e]), high[e])
            if not recalled:  # what the height may not take the width takes: the volume stays at the bounds too
                wide *= height[e] * tall / c_half
            # It rests on what is below it: all it gains shows on the side of the skin.
            lift = c_half - height[e]
            centre[e, 0] = 0.5 * (ax + bx) + lift * zx
            centre[e, 1] = 0.5 * (ay + by) + lift * zy
            centre[e, 2] = 0.5 * (az + bz) + lift * zz
            frame[e, 0, 0], frame[e, 1, 0], frame[e, 2, 0] = dx, dy, dz
            frame[e, 0, 1], frame[e, 1, 1], frame[e, 2, 1] = zy * dz - zz * dy, zz * dx - zx * dz, zx * dy - zy * dx
            frame[e, 0, 2], frame[e, 1, 2], frame[e, 2, 2] = zx, zy, zz
            half[e, 0], half[e, 1], half[e, 2] = 0.5 * overlap * long, width[e] * wide, c_half
            ax, ay, az, ux, uy, uz = bx, by, bz, vx, vy, vz


@compiled
def first_hit(origin: Array, direction: Array, corners: Array) -> tuple[Array, Index]:
    """Distance and triangle (N,) at which rays from ``origin`` (N, 3) along unit ``direction`` (N, 3) first meet ``corners`` (M, 3, 3).

    Infinity and -1 where they meet none (Möller and Trumbore 1997).
    """
    n = origin.shape[0]
    distance, triangle = np.full(n, np.inf), np.full(n, -1, dtype=np.int64)
    for i in range(n):
        ox, oy, oz = origin[i, 0], origin[i, 1], origin[i, 2]
        dx, dy, dz = direction[i, 0], direction[i, 1], direction[i, 2]
        for t in range(corners.shape[0]):
            ax, ay, az = corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2]
            ux, uy, uz = corners[t, 1, 0] - ax, corners[t, 1, 1] - ay, corners[t, 1, 2] - az
            vx, vy, vz = corners[t, 2, 0] - ax, corners[t, 2, 1] - ay, corners[t, 2, 2] - az
            px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
            det = ux * px + uy * py + uz * pz
            if abs(det) < 1e-18:
                continue
            sx, sy, sz = ox - ax, oy - ay, oz - az
            a = (sx * px + sy * py + sz * pz) / det
            if a < 0.0 or a > 1.0:
                continue
            qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
            b = (dx * qx + dy * qy + dz * qz) / det
            if b < 0.0 or a + b > 1.0:
                continue
            far = (vx * qx + vy * qy + vz * qz) / det
            if 1e-9 < far < distance[i]:
                distance[i] = far
                triangle[i] = t
    return distance, triangle


@compiled
def volume_of(points: Array, faces: Index) -> float:
    """Volume inside a closed mesh: ``points`` (N, 3), ``faces`` (M, 3)."""
    total = 0.0
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = points[i, 0], points[i, 1], points[i, 2]
        bx, by, bz = points[j, 0], points[j, 1], points[j, 2]
        cx, cy, cz = points[k, 0], points[k, 1], points[k, 2]
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total / 6.0
