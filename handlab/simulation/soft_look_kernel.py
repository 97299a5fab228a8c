"""Compiled search for what the limits of the skin have to look at: at first everything, several places at once, then what has moved.

Lists go into ``found``, which has room for one more than all; how many there are is returned.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Node = NDArray[np.uint32]
Value = NDArray[np.int16]
Mark = NDArray[np.uint8]


@compiled
def near_bone(
    position: Array,
    transform: Array,
    corner: Node,
    group: Index,
    near: Value,
    floor: Value,
    start: Index,
    size: Index,
    origin: Array,
    spacing: float,
    found: Node,
) -> int:
    """Pairs in a cell in which the field falls below ``near`` (p,), in its units: they may be too near to bone.

    ``floor`` is the least value in each cell; outside the field's box the nearest cell counts, and bone is far from there. Pairs of body
    b are ``group[b]`` to ``group[b + 1]``; other arguments as in ``soft_hold_kernel.out_of_bone``.
    """
    pairs = corner.shape[0]
    middle, at = np.empty((3, pairs)), np.empty(pairs, np.int32)
    third, per = 1.0 / 3.0, 1.0 / spacing
    for p in range(pairs):
        i, j, k = corner[p, 0], corner[p, 1], corner[p, 2]
        middle[0, p] = third * (position[0, i] + position[0, j] + position[0, k])
        middle[1, p] = third * (position[1, i] + position[1, j] + position[1, k])
        middle[2, p] = third * (position[2, i] + position[2, j] + position[2, k])
    for b in range(size.shape[0]):
        t = transform[b]
        xu, yu, zu = per * t[0, 0], per * t[1, 0], per * t[2, 0]
        xv, yv, zv = per * t[0, 1], per * t[1, 1], per * t[2, 1]
        xw, yw, zw = per * t[0, 2], per * t[1, 2], per * t[2, 2]
        ou = -per * origin[b, 0] - xu * t[0, 3] - yu * t[1, 3] - zu * t[2, 3]
        ov = -per * origin[b, 1] - xv * t[0, 3] - yv * t[1, 3] - zv * t[2, 3]
        ow = -per * origin[b, 2] - xw * t[0, 3] - yw * t[1, 3] - zw * t[2, 3]
        nu, nv, nw = size[b, 0] - 1.0, size[b, 1] - 1.0, size[b, 2] - 1.0
        begin, rows, cells = np.int32(start[b]), np.int32(size[b, 1]), np.int32(size[b, 2])
        for p in range(group[b], group[b + 1]):
            x, y, z = middle[0, p], middle[1, p], middle[2, p]
            u = np.int32(min(max(xu * x + yu * y + zu * z + ou, 0.0), nu))
            v = np.int32(min(max(xv * x + yv * y + zv * z + ov, 0.0), nv))
            w = np.int32(min(max(xw * x + yw * y + zw * z + ow, 0.0), nw))
            at[p] = begin + (u * rows + v) * cells + w
    many = 0
    for p in range(pairs):
        found[many] = p
        many += floor[at[p]] < near[p]
    return many


@compiled
def lacking(position: Array, faces: Node, plane: Array, least: float, found: Node) -> int:
    """Triangles whose shadow on their ``plane`` is smaller than ``least`` of their rest area; see ``soft_hold_kernel.unfold``."""
    count = faces.shape[0]
    side, lack = np.empty((6, count)), np.empty(count)
    for f in range(count):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        side[0, f] = position[0, j] - position[0, i]
        side[1, f] = position[1, j] - position[1, i]
        side[2, f] = position[2, j] - position[2, i]
        side[3, f] = position[0, k] - position[0, i]
        side[4, f] = position[1, k] - position[1, i]
        side[5, f] = position[2, k] - position[2, i]
    for f in range(count):
        ax, ay, az, bx, by, bz = side[0, f], side[1, f], side[2, f], side[3, f], side[4, f], side[5, f]
        mx, my, mz = plane[0, f], plane[1, f], plane[2, f]
        along = (ay * bz - az * by) * mx + (az * bx - ax * bz) * my + (ax * by - ay * bx) * mz
        lack[f] = least * (mx * mx + my * my + mz * mz) - along
    many = 0
    for f in range(count):
        found[many] = f
        many += lack[f] > 0.0
    return many


@compiled
def touched(corner: Node, last: Index, since: int, found: Node) -> int:
    """Rows of ``corner`` (p, 3) with a node that was moved by pass ``since`` or a later one: ``last`` (n,) is the pass that moved it."""
    many = 0
    for p in range(corner.shape[0]):
        found[many] = p
        many += (last[corner[p, 0]] >= since) | (last[corner[p, 1]] >= since) | (last[corner[p, 2]] >= since)
    return many


@compiled
def beside(last: Index, since: int, fan_start: Node, fan: Node, mark: Mark, found: Node) -> int:
    """``touched`` for triangles, by looking at the few nodes that moved: those at node v are ``fan[fan_start[v]:fan_start[v + 1]]``.

    ``mark`` holds no ones before and after, one byte for every triangle and as many as fill eight.
    """
    for v in range(last.shape[0]):
        if last[v] >= since:
            for q in range(fan_start[v], fan_start[v + 1]):
                mark[fan[q]] = 1
    many, eight = 0, mark.view(np.uint64)
    for w in range(eight.shape[0]):
        if eight[w] != 0:
            for f in range(8 * w, 8 * w + 8):
                if mark[f]:
                    found[many] = f
                    many += 1
                    mark[f] = 0
    return many
