"""Compiled limits of the skin, once per frame: out of bone, no triangle inverted, no edge stretched too far."""

from __future__ import annotations

import math

import numpy as np

from handlab.physics.compiled import compiled
from handlab.simulation.soft_look_kernel import Array, Index, Node, Value, beside, lacking, near_bone, touched

A_LITTLE = 1.0 - 1e-6  # long edges are made a little shorter than they must be: rounding left them too long, pass after pass
A_BIT_MORE = 1.01  # likewise: shadows are made a little larger than they must be
LEAST_SLOPE = 1e-3  # of what it is at rest: a triangle that is but a point is not thrown far
UNIT = 1e-6  # m, of the values of ``bone_field``: a constant of this module, so that kernels on disk notice when it changes


@compiled
def unfold(position: Array, faces: Node, plane: Array, least: float, look: Node, many: int, last: Index, now: int) -> int:
    """Turn triangles back that have turned over, in place; returns how many were found among the first ``many`` of the list ``look``.

    ``plane`` (3, M): rest normals, as long as twice the area, carried along with the skin. The area of a triangle's shadow on its plane,
    negative when it has turned over, stays above ``least`` of its rest area: what it lacks is made good by the smallest motion of its
    corners that does so to first order. That tends to nothing as the lack does, so skin does not snap, and moves no triangle's middle.
    ``last`` (n,) becomes ``now`` where a node is moved.
    """
    bad = 0
    for q in range(many):
        f = look[q]
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = position[0, j] - position[0, i], position[1, j] - position[1, i], position[2, j] - position[2, i]
        bx, by, bz = position[0, k] - position[0, i], position[1, k] - position[1, i], position[2, k] - position[2, i]
        mx, my, mz = plane[0, f], plane[1, f], plane[2, f]
        along = (ay * bz - az * by) * mx + (az * bx - ax * bz) * my + (ax * by - ay * bx) * mz
        square = mx * mx + my * my + mz * mz
        if along >= least * square:
            continue
        bad += 1
        size = math.sqrt(square)
        mx, my, mz = mx / size, my / size, mz / size
        jx, jy, jz = by * mz - bz * my, bz * mx - bx * mz, bx * my - by * mx
        kx, ky, kz = my * az - mz * ay, mz * ax - mx * az, mx * ay - my * ax
        ix, iy, iz = -jx - kx, -jy - ky, -jz - kz
        steep = ix * ix + iy * iy + iz * iz + jx * jx + jy * jy + jz * jz + kx * kx + ky * ky + kz * kz
        g = (A_BIT_MORE * least * size - along / size) / max(steep, LEAST_SLOPE * size)
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
    return bad


@compiled
def shorten(position: Array, first: Node, second: Node, rest: Array, most: float, last: Index, since: int, now: int) -> int:
    """Pull the ends of edges together that are longer than ``most`` times ``rest`` (e,), in place, in turn; returns how many.

    Edges are passed over whose ends no pass has moved from ``since`` on.
    """
    bad = 0
    for e in range(first.shape[0]):
        i, j = first[e], second[e]
        if last[i] < since and last[j] < since:
            continue
        x, y, z = position[0, j] - position[0, i], position[1, j] - position[1, i], position[2, j] - position[2, i]
        square = x * x + y * y + z * z
        longest = most * rest[e]
        if square > longest * longest:
            bad += 1
            last[i] = last[j] = now
            g = 0.5 * (1.0 - A_LITTLE * longest / math.sqrt(square))
            position[0, i] += g * x
            position[1, i] += g * y
            position[2, i] += g * z
            position[0, j] -= g * x
            position[1, j] -= g * y
            position[2, j] -= g * z
    return bad


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
    look: Node,
    many: int,
    last: Index,
    now: int,
) -> int:
    """Move nodes and the middles of triangles out of bone, in place; returns how many were too near.

    Pair p asks that the middle of the nodes ``corner[p]`` (p, 3), three times the same for a node, stays ``clearance[p]`` metres outside
    the bones of ``body[p]``: the field of ``bone_field``, in the bind posture, looked up where ``transform`` (b, 4, 4) carries it back to.
    Only the first ``many`` of the list ``look`` are looked at. ``last`` (n,) becomes ``now`` where a node is moved.
    """
    moved = 0
    third, per = 1.0 / 3.0, 1.0 / spacing
    for q in range(many):
        p = look[q]
        b, i, j, k = body[p], corner[p, 0], corner[p, 1], corner[p, 2]
        t = transform[b]
        ny, nz = size[b, 1], size[b, 2]
        x, y, z = position[0, i], position[1, i], position[2, i]
        if j != i:
            x, y, z = (
                third * (x + position[0, j] + position[0, k]),
                third * (y + position[1, j] + position[1, k]),
                third * (z + position[2, j] + position[2, k]),
            )
        x, y, z = x - t[0, 3], y - t[1, 3], z - t[2, 3]
        u = (t[0, 0] * x + t[1, 0] * y + t[2, 0] * z - origin[b, 0]) * per
        v = (t[0, 1] * x + t[1, 1] * y + t[2, 1] * z - origin[b, 1]) * per
        w = (t[0, 2] * x + t[1, 2] * y + t[2, 2] * z - origin[b, 2]) * per
        if u < 0.0 or v < 0.0 or w < 0.0 or u >= size[b, 0] - 1 or v >= ny - 1 or w >= nz - 1:
            continue
        iu, iv, iw = int(u), int(v), int(w)
        at = start[b] + (iu * ny + iv) * nz + iw
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
        x = t[0, 0] * gu + t[0, 1] * gv + t[0, 2] * gw
        y = t[1, 0] * gu + t[1, 1] * gv + t[1, 2] * gw
        z = t[2, 0] * gu + t[2, 1] * gv + t[2, 2] * gw
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
    return moved


@compiled
def limited(
    position: Array,
    transform: Array,
    corner: Node,
    body: Node,
    clearance: Array,
    group: Index,
    near: Value,
    floor: Value,
    value: Value,
    start: Index,
    size: Index,
    origin: Array,
    spacing: float,
    first: Node,
    second: Node,
    rest: Array,
    most: float,
    faces: Node,
    fan_start: Node,
    fan: Node,
    plane: Array,
    least: float,
    passes: int,
    rounds: int,
    bone_rounds: int,
) -> int:
    """All limits in place, round after round until none is broken; returns how many triangles were found inverted in the last round.

    Later rounds look only at what has moved: passes are counted by ``now``, and ``last`` (n,) is the one that moved a node.
    """
    last, look = np.zeros(position.shape[1], np.int64), np.empty(1 + max(corner.shape[0], faces.shape[0]), np.uint32)
    mark = np.zeros((faces.shape[0] + 7) // 8 * 8, np.uint8)
    now, bones_at, edges_at, faces_at, faults = 0, 0, 0, 0, 0
    for k in range(rounds):
        if k < bone_rounds:
            if k == 0:
                many = near_bone(position, transform, corner, group, near, floor, start, size, origin, spacing, look)
            else:
                many = touched(corner, last, bones_at, look)
            now += 1
            bones_at = now
            out_of_bone(position, transform, corner, body, clearance, value, start, size, origin, spacing, look, many, last, now)
        long, faults = 0, 0
        for _ in range(passes):
            now += 1
            bad = shorten(position, first, second, rest, most, last, edges_at, now)
            edges_at = now
            long += bad
            if bad == 0:
                break
        for _ in range(passes):
            many = lacking(position, faces, plane, least, look) if faces_at == 0 else beside(last, faces_at, fan_start, fan, mark, look)
            now += 1
            faces_at = now
            bad = unfold(position, faces, plane, least, look, many, last, now)
            faults += bad
            if bad == 0:
                break
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
