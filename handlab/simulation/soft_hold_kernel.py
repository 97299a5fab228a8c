"""Compiled limits of the skin, once per frame: out of bone, no triangle inverted, no edge stretched too far."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Node = NDArray[np.uint32]


@compiled
def unfold(position: Array, turn: Array, faces: Node, corner: Array, least: float, part: float, passes: int) -> int:
    """Turn triangles back that have turned over, in place; returns how many were found, in all passes.

    A triangle has turned over when the cosine between its normal and its rest normal, carried by the mean of its corners' rotations
    ``turn`` (4, n), is below ``least``. Its corners then go ``part`` of the way to its rest shape ``corner`` (M, 9; three corners
    from its middle), carried likewise, about its middle: no momentum comes of it.
    """
    found = 0
    for _ in range(passes):
        bad = 0
        for f in range(faces.shape[0]):
            i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
            ax, ay, az = position[0, j] - position[0, i], position[1, j] - position[1, i], position[2, j] - position[2, i]
            bx, by, bz = position[0, k] - position[0, i], position[1, k] - position[1, i], position[2, k] - position[2, i]
            nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            w, x, y, z = turn[0, i], turn[1, i], turn[2, i], turn[3, i]
            for v in (j, k):
                g = 1.0
                if w * turn[0, v] + x * turn[1, v] + y * turn[2, v] + z * turn[3, v] < 0.0:
                    g = -1.0
                w, x, y, z = w + g * turn[0, v], x + g * turn[1, v], y + g * turn[2, v], z + g * turn[3, v]
            s = 2.0 / (w * w + x * x + y * y + z * z)
            # rest normal, carried
            ux, uy, uz = corner[f, 3] - corner[f, 0], corner[f, 4] - corner[f, 1], corner[f, 5] - corner[f, 2]
            vx, vy, vz = corner[f, 6] - corner[f, 0], corner[f, 7] - corner[f, 1], corner[f, 8] - corner[f, 2]
            p, q, r = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            rest = p * p + q * q + r * r
            a, b, c = y * r - z * q + w * p, z * p - x * r + w * q, x * q - y * p + w * r
            p, q, r = p + s * (y * c - z * b), q + s * (z * a - x * c), r + s * (x * b - y * a)
            along = nx * p + ny * q + nz * r
            if along > 0.0 and along * along >= least * least * (nx * nx + ny * ny + nz * nz) * rest:
                continue
            bad += 1
            mx = (position[0, i] + position[0, j] + position[0, k]) / 3.0
            my = (position[1, i] + position[1, j] + position[1, k]) / 3.0
            mz = (position[2, i] + position[2, j] + position[2, k]) / 3.0
            for d in range(3):
                v = faces[f, d]
                p, q, r = corner[f, 3 * d], corner[f, 3 * d + 1], corner[f, 3 * d + 2]
                a, b, c = y * r - z * q + w * p, z * p - x * r + w * q, x * q - y * p + w * r
                p, q, r = p + s * (y * c - z * b), q + s * (z * a - x * c), r + s * (x * b - y * a)
                position[0, v] += part * (mx + p - position[0, v])
                position[1, v] += part * (my + q - position[1, v])
                position[2, v] += part * (mz + r - position[2, v])
        found += bad
        if bad == 0:
            break
    return found


@compiled
def shorten(position: Array, first: Node, second: Node, longest: Array, passes: int) -> int:
    """Pull the ends of edges together that are longer than ``longest`` (e,), in place; returns how many
    were found, in all passes."""
    found = 0
    for _ in range(passes):
        bad = 0
        for e in range(first.shape[0]):
            i, j = first[e], second[e]
            x, y, z = position[0, j] - position[0, i], position[1, j] - position[1, i], position[2, j] - position[2, i]
            square = x * x + y * y + z * z
            if square > longest[e] * longest[e]:
                bad += 1
                g = 0.5 * (1.0 - longest[e] / math.sqrt(square))
                position[0, i] += g * x
                position[1, i] += g * y
                position[2, i] += g * z
                position[0, j] -= g * x
                position[1, j] -= g * y
                position[2, j] -= g * z
        found += bad
        if bad == 0:
            break
    return found


@compiled
def out_of_bone(
    position: Array,
    transform: Array,
    corner: Node,
    body: Node,
    clearance: Array,
    value: Array,
    start: Index,
    size: Index,
    origin: Array,
    spacing: float,
) -> int:
    """Move nodes and the middles of triangles out of bone, in place; returns how many were too near.

    Pair p asks that the middle of the nodes ``corner[p]`` (p, 3), three times the same for a node, stays ``clearance[p]`` metres outside
    the bones of ``body[p]``: the field of ``bone_field``, in the bind posture, looked up where ``transform`` (b, 4, 4) carries it back to.
    """
    moved = 0
    third = 1.0 / 3.0
    for p in range(corner.shape[0]):
        i, j, k, b = corner[p, 0], corner[p, 1], corner[p, 2], body[p]
        t = transform[b]
        x, y, z = position[0, i], position[1, i], position[2, i]
        if j != i:
            x, y, z = (
                third * (x + position[0, j] + position[0, k]),
                third * (y + position[1, j] + position[1, k]),
                third * (z + position[2, j] + position[2, k]),
            )
        x, y, z = x - t[0, 3], y - t[1, 3], z - t[2, 3]
        u = (t[0, 0] * x + t[1, 0] * y + t[2, 0] * z - origin[b, 0]) / spacing
        v = (t[0, 1] * x + t[1, 1] * y + t[2, 1] * z - origin[b, 1]) / spacing
        w = (t[0, 2] * x + t[1, 2] * y + t[2, 2] * z - origin[b, 2]) / spacing
        nx, ny, nz = size[b, 0], size[b, 1], size[b, 2]
        if u < 0.0 or v < 0.0 or w < 0.0 or u >= nx - 1 or v >= ny - 1 or w >= nz - 1:
            continue
        iu, iv, iw = int(u), int(v), int(w)
        fu, fv, fw = u - iu, v - iv, w - iw
        at = start[b] + (iu * ny + iv) * nz + iw
        c000, c001, c010, c011 = value[at], value[at + 1], value[at + nz], value[at + nz + 1]
        at += ny * nz
        c100, c101, c110, c111 = value[at], value[at + 1], value[at + nz], value[at + nz + 1]
        c00, c01 = c000 + fw * (c001 - c000), c010 + fw * (c011 - c010)
        c10, c11 = c100 + fw * (c101 - c100), c110 + fw * (c111 - c110)
        c0, c1 = c00 + fv * (c01 - c00), c10 + fv * (c11 - c10)
        lack = clearance[p] - (c0 + fu * (c1 - c0))
        if lack <= 0.0:
            continue
        moved += 1
        gu = c1 - c0
        gv = (1.0 - fu) * (c01 - c00) + fu * (c11 - c10)
        gw = (1.0 - fu) * ((1.0 - fv) * (c001 - c000) + fv * (c011 - c010)) + fu * ((1.0 - fv) * (c101 - c100) + fv * (c111 - c110))
        square = gu * gu + gv * gv + gw * gw
        if square < 1e-20:
            continue
        g = lack / math.sqrt(square)
        gu, gv, gw = g * gu, g * gv, g * gw
        x, y, z = (
            t[0, 0] * gu + t[0, 1] * gv + t[0, 2] * gw,
            t[1, 0] * gu + t[1, 1] * gv + t[1, 2] * gw,
            t[2, 0] * gu + t[2, 1] * gv + t[2, 2] * gw,
        )
        position[0, i] += x
        position[1, i] += y
        position[2, i] += z
        if j != i:
            for v in (j, k):
                position[0, v] += x
                position[1, v] += y
                position[2, v] += z
    return moved
