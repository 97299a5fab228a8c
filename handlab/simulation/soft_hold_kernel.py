"""Compiled limits of the skin, once per frame: out of bone, no triangle inverted, no edge stretched too far."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Node = NDArray[np.uint32]
Value = NDArray[np.int16]
A_LITTLE = 1.0 - 1e-6  # long edges are made a little shorter than they must be: rounding left them too long, pass after pass
A_BIT_MORE = 1.01  # likewise: shadows are made a little larger than they must be
LEAST_SLOPE = 1e-3  # of what it is at rest: a triangle that is but a point is not thrown far
UNIT = 1e-6  # m, of the values of ``bone_field``: a constant of this module, so that kernels on disk notice when it changes


@compiled
def unfold(position: Array, turn: Array, faces: Node, normal: Array, least: float, passes: int, last: Index, clock: Index) -> int:
    """Turn triangles back that have turned over, in place; returns how many were found, in all passes.

    The mean of its corners' rotations ``turn`` (4, n) carries a triangle's rest plane along. The area of its shadow on that plane,
    negative when it has turned over, stays above ``least`` of its rest area: what it lacks is made good by the smallest motion of its
    corners that does so to first order. That tends to nothing as the lack does, so skin does not snap, and moves no triangle's middle.
    ``normal`` (M, 3): of the rest shape, as long as twice its area. Only triangles are looked at of which a node has moved since the
    last pass: ``last`` (n,) when, on the clock of ``limited``.
    """
    found = 0
    for _ in range(passes):
        bad = 0
        since = clock[2]
        clock[0] += 1
        now = clock[0]
        clock[2] = now
        for f in range(faces.shape[0]):
            i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
            if last[i] < since and last[j] < since and last[k] < since:
                continue
            ax, ay, az = position[0, j] - position[0, i], position[1, j] - position[1, i], position[2, j] - position[2, i]
            bx, by, bz = position[0, k] - position[0, i], position[1, k] - position[1, i], position[2, k] - position[2, i]
            nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            w, x, y, z = turn[0, i], turn[1, i], turn[2, i], turn[3, i]
            g = math.copysign(1.0, w * turn[0, j] + x * turn[1, j] + y * turn[2, j] + z * turn[3, j])
            w, x, y, z = w + g * turn[0, j], x + g * turn[1, j], y + g * turn[2, j], z + g * turn[3, j]
            g = math.copysign(1.0, w * turn[0, k] + x * turn[1, k] + y * turn[2, k] + z * turn[3, k])
            w, x, y, z = w + g * turn[0, k], x + g * turn[1, k], y + g * turn[2, k], z + g * turn[3, k]
            square = w * w + x * x + y * y + z * z
            # rest normal, carried, times the square of the quaternion: no division where nothing is wrong
            p, q, r = normal[f, 0], normal[f, 1], normal[f, 2]
            a, b, c = y * r - z * q + w * p, z * p - x * r + w * q, x * q - y * p + w * r
            mx = square * p + 2.0 * (y * c - z * b)
            my = square * q + 2.0 * (z * a - x * c)
            mz = square * r + 2.0 * (x * b - y * a)
            size = p * p + q * q + r * r
            along = nx * mx + ny * my + nz * mz
            if along >= least * square * size:
                continue
            bad += 1
            g = 1.0 / (square * math.sqrt(size))
            mx, my, mz = g * mx, g * my, g * mz
            jx, jy, jz = by * mz - bz * my, bz * mx - bx * mz, bx * my - by * mx
            kx, ky, kz = my * az - mz * ay, mz * ax - mx * az, mx * ay - my * ax
            ix, iy, iz = -jx - kx, -jy - ky, -jz - kz
            steep = ix * ix + iy * iy + iz * iz + jx * jx + jy * jy + jz * jz + kx * kx + ky * ky + kz * kz
            g = (A_BIT_MORE * least * math.sqrt(size) - g * along) / max(steep, LEAST_SLOPE * math.sqrt(size))
            position[0, i] += g * ix
            position[1, i] += g * iy
            position[2, i] += g * iz
            position[0, j] += g * jx
            position[1, j] += g * jy
            position[2, j] += g * jz
            position[0, k] += g * kx
            position[1, k] += g * ky
            position[2, k] += g * kz
            last[i] = last[j] = last[k] = now
        found += bad
        if bad == 0:
            break
    return found


@compiled
def shorten(position: Array, first: Node, second: Node, longest: Array, passes: int, last: Index, clock: Index) -> int:
    """Pull the ends of edges together that are longer than ``longest`` (e,), in place; returns how many were found, in all passes."""
    found = 0
    for _ in range(passes):
        bad = 0
        clock[0] += 1
        for e in range(first.shape[0]):
            i, j = first[e], second[e]
            x, y, z = position[0, j] - position[0, i], position[1, j] - position[1, i], position[2, j] - position[2, i]
            square = x * x + y * y + z * z
            if square > longest[e] * longest[e]:
                bad += 1
                last[i] = last[j] = clock[0]
                g = 0.5 * (1.0 - A_LITTLE * longest[e] / math.sqrt(square))
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
    value: Value,
    start: Index,
    size: Index,
    origin: Array,
    spacing: float,
    last: Index,
    clock: Index,
) -> int:
    """Move nodes and the middles of triangles out of bone, in place; returns how many were too near.

    Pair p asks that the middle of the nodes ``corner[p]`` (p, 3), three times the same for a node, stays ``clearance[p]`` metres outside
    the bones of ``body[p]``: the field of ``bone_field``, in the bind posture, looked up where ``transform`` (b, 4, 4) carries it back to.
    Pairs come body by body. Only those are looked up of which a node has moved since the last time: ``last`` (n,), see ``limited``.
    """
    moved = 0
    third, per, to_unit = 1.0 / 3.0, 1.0 / spacing, 1.0 / UNIT
    safe = 1.8 * spacing  # a corner of a cell is at most the root of three spacings from any place in it, and the field a distance
    since = clock[1]
    clock[0] += 1
    now = clock[0]
    clock[1] = now
    pair, pairs = 0, corner.shape[0]
    while pair < pairs:
        b = body[pair]
        end = pair
        while end < pairs and body[end] == b:
            end += 1
        t = transform[b]
        txx, txy, txz, tx = t[0, 0], t[0, 1], t[0, 2], t[0, 3]
        tyx, tyy, tyz, ty = t[1, 0], t[1, 1], t[1, 2], t[1, 3]
        tzx, tzy, tzz, tz = t[2, 0], t[2, 1], t[2, 2], t[2, 3]
        ox, oy, oz, begin = origin[b, 0], origin[b, 1], origin[b, 2], start[b]
        nx, ny, nz = size[b, 0], size[b, 1], size[b, 2]
        for p in range(pair, end):
            i, j, k = corner[p, 0], corner[p, 1], corner[p, 2]
            if last[i] < since and last[j] < since and last[k] < since:
                continue
            x, y, z = position[0, i], position[1, i], position[2, i]
            if j != i:
                x, y, z = (
                    third * (x + position[0, j] + position[0, k]),
                    third * (y + position[1, j] + position[1, k]),
                    third * (z + position[2, j] + position[2, k]),
                )
            x, y, z = x - tx, y - ty, z - tz
            u = (txx * x + tyx * y + tzx * z - ox) * per
            v = (txy * x + tyy * y + tzy * z - oy) * per
            w = (txz * x + tyz * y + tzz * z - oz) * per
            if u < 0.0 or v < 0.0 or w < 0.0 or u >= nx - 1 or v >= ny - 1 or w >= nz - 1:
                continue
            iu, iv, iw = int(u), int(v), int(w)
            at = begin + (iu * ny + iv) * nz + iw
            if value[at] > to_unit * (clearance[p] + safe):
                continue
            fu, fv, fw = u - iu, v - iv, w - iw
            c000, c001, c010, c011 = float(value[at]), float(value[at + 1]), float(value[at + nz]), float(value[at + nz + 1])
            at += ny * nz
            c100, c101, c110, c111 = float(value[at]), float(value[at + 1]), float(value[at + nz]), float(value[at + nz + 1])
            c00, c01 = c000 + fw * (c001 - c000), c010 + fw * (c011 - c010)
            c10, c11 = c100 + fw * (c101 - c100), c110 + fw * (c111 - c110)
            c0, c1 = c00 + fv * (c01 - c00), c10 + fv * (c11 - c10)
            lack = clearance[p] - UNIT * (c0 + fu * (c1 - c0))
            if lack <= 0.0:
                continue
            moved += 1
            gu = c1 - c0
            gv = (1.0 - fu) * (c01 - c00) + fu * (c11 - c10)
            gw = (1.0 - fu) * ((1.0 - fv) * (c001 - c000) + fv * (c011 - c010)) + fu * ((1.0 - fv) * (c101 - c100) + fv * (c111 - c110))
            square = gu * gu + gv * gv + gw * gw
            if square < 1e-6:
                continue
            g = lack / math.sqrt(square)
            gu, gv, gw = g * gu, g * gv, g * gw
            x, y, z = txx * gu + txy * gv + txz * gw, tyx * gu + tyy * gv + tyz * gw, tzx * gu + tzy * gv + tzz * gw
            position[0, i] += x
            position[1, i] += y
            position[2, i] += z
            last[i] = now
            if j != i:
                for n in (j, k):
                    position[0, n] += x
                    position[1, n] += y
                    position[2, n] += z
                    last[n] = now
        pair = end
    return moved


@compiled
def limited(
    position: Array,
    transform: Array,
    turn: Array,
    corner: Node,
    body: Node,
    clearance: Array,
    value: Value,
    start: Index,
    size: Index,
    origin: Array,
    spacing: float,
    first: Node,
    second: Node,
    longest: Array,
    faces: Node,
    normal: Array,
    least: float,
    passes: int,
    rounds: int,
    bone_rounds: int,
) -> int:
    """All limits in place, round after round until none is broken; returns how many triangles were found inverted in the last round.

    Later rounds look only at what has moved: every look at the bones and every pass over the triangles has a number, ``clock[0]``
    the newest, ``clock[1]`` and ``clock[2]`` the last one of each; ``last`` (n,) is the number of the pass that moved a node.
    """
    last, clock = np.zeros(position.shape[1], np.int64), np.zeros(3, np.int64)
    faults = 0
    for k in range(rounds):
        if k < bone_rounds:
            out_of_bone(position, transform, corner, body, clearance, value, start, size, origin, spacing, last, clock)
        long = shorten(position, first, second, longest, passes, last, clock)
        faults = unfold(position, turn, faces, normal, least, passes, last, clock)
        if long == 0 and faults == 0:
            break
    return faults


@compiled
def nearest_bone(
    position: Array,
    transform: Array,
    corner: Node,
    body: Node,
    value: Value,
    start: Index,
    size: Index,
    origin: Array,
    spacing: float,
    least: Array,
) -> None:
    """Lower ``least`` (p,) to what the field has at the nearest grid point for every pair; see ``out_of_bone``. For building."""
    for p in range(corner.shape[0]):
        b, at = body[p], start[body[p]]
        inside = True
        for d in range(3):
            u = -origin[b, d]
            for e in range(3):
                x = (position[e, corner[p, 0]] + position[e, corner[p, 1]] + position[e, corner[p, 2]]) / 3.0
                u += transform[b, e, d] * (x - transform[b, e, 3])
            iu = round(u / spacing)
            if iu < 0 or iu >= size[b, d]:
                inside = False
                break
            at += iu * (size[b, 1] * size[b, 2] if d == 0 else size[b, 2] if d == 1 else 1)
        if inside:
            least[p] = min(least[p], UNIT * value[at])
