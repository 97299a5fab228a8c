"""Compiled skin: all leapfrog substeps of a frame, and what is measured after them.

Arrays of nodes are (3, n), one contiguous row per axis; edges are two ``uint32`` arrays: signed ones would keep the test for negative
indices in the loop and cost a tenth.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Node = NDArray[np.uint32]


@compiled
def leapfrog(
    position: Array,
    velocity: Array,
    force: Array,
    first: Node,
    second: Node,
    stiffness: Array,
    rest: Array,
    slack: float,
    anchor: Array,
    hold: Array,
    inverse_mass: Array,
    dt: float,
    steps: int,
    damping: float,
) -> None:
    """``steps`` Verlet leapfrog steps of ``dt`` in place (equations, section 13): position and half-step velocity (3, n).

    ``anchor`` (10, n): centre of the mirrored pair at the beginning (rows 0-2), its way until the end of the frame (3-5), arm from
    the centre to the mirror image (6-8), rest length of both springs (9); ``hold`` (n,) stiffness of one of them. Centres move evenly
    during the frame; damping acts on the speed relative to them. Edges (e,): ``stiffness``, ``rest``; pressed ones have ``slack`` k.
    """
    nodes, edges = position.shape[1], first.shape[0]
    lost = 0.5 * damping * dt
    kept, gained, dragged = (1.0 - lost) / (1.0 + lost), dt / (1.0 + lost), 2.0 * lost / (1.0 + lost) / (dt * steps)
    # Edges in three loops: only the last, which adds to nodes, cannot do several edges at once.
    way, pull = np.empty((3, edges)), np.empty(edges)
    for step in range(steps):
        share = step / steps
        for i in range(nodes):
            x = position[0, i] - anchor[0, i] - share * anchor[3, i]
            y = position[1, i] - anchor[1, i] - share * anchor[4, i]
            z = position[2, i] - anchor[2, i] - share * anchor[5, i]
            ax, ay, az = x + anchor[6, i], y + anchor[7, i], z + anchor[8, i]
            bx, by, bz = x - anchor[6, i], y - anchor[7, i], z - anchor[8, i]
            a = anchor[9, i] / math.sqrt(ax * ax + ay * ay + az * az) - 1.0
            b = anchor[9, i] / math.sqrt(bx * bx + by * by + bz * bz) - 1.0
            k = hold[i]
            force[0, i] = k * (a * ax + b * bx)
            force[1, i] = k * (a * ay + b * by)
            force[2, i] = k * (a * az + b * bz)
        for e in range(edges):
            i, j = first[e], second[e]
            way[0, e] = position[0, j] - position[0, i]
            way[1, e] = position[1, j] - position[1, i]
            way[2, e] = position[2, j] - position[2, i]
        for e in range(edges):
            x, y, z = way[0, e], way[1, e], way[2, e]
            strain = 1.0 - rest[e] / math.sqrt(x * x + y * y + z * z)
            pull[e] = stiffness[e] * (max(strain, 0.0) + slack * min(strain, 0.0))
        for e in range(edges):
            i, j = first[e], second[e]
            x, y, z = pull[e] * way[0, e], pull[e] * way[1, e], pull[e] * way[2, e]
            force[0, i] += x
            force[1, i] += y
            force[2, i] += z
            force[0, j] -= x
            force[1, j] -= y
            force[2, j] -= z
        for i in range(nodes):
            push = gained * inverse_mass[i]
            x = kept * velocity[0, i] + push * force[0, i] + dragged * anchor[3, i]
            y = kept * velocity[1, i] + push * force[1, i] + dragged * anchor[4, i]
            z = kept * velocity[2, i] + push * force[2, i] + dragged * anchor[5, i]
            velocity[0, i], velocity[1, i], velocity[2, i] = x, y, z
            position[0, i] += dt * x
            position[1, i] += dt * y
            position[2, i] += dt * z


@compiled
def framed(before: Array, centre: Array, arm: Array, share: float, anchor: Array) -> None:
    """Fill ``anchor`` (10, n) of ``leapfrog``: centres ``before`` and at the end, arms, and rest lengths, ``share`` of the arms."""
    for d in range(3):
        for i in range(centre.shape[1]):
            anchor[d, i] = before[d, i]
            anchor[3 + d, i] = centre[d, i] - before[d, i]
            anchor[6 + d, i] = arm[d, i]
    for i in range(centre.shape[1]):
        anchor[9, i] = share * math.sqrt(arm[0, i] ** 2 + arm[1, i] ** 2 + arm[2, i] ** 2)


@compiled
def volume_and_area(position: Array, faces: Node, normal: Array) -> float:
    """Enclosed volume in m^3 of points (3, n); ``normal`` (3, n) receives unit normals, weighted by the area of the triangles."""
    total = 0.0
    normal[:, :] = 0.0
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = position[0, j] - position[0, i], position[1, j] - position[1, i], position[2, j] - position[2, i]
        bx, by, bz = position[0, k] - position[0, i], position[1, k] - position[1, i], position[2, k] - position[2, i]
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        total += position[0, i] * nx + position[1, i] * ny + position[2, i] * nz
        for v in (i, j, k):
            normal[0, v] += nx
            normal[1, v] += ny
            normal[2, v] += nz
    for v in range(normal.shape[1]):
        size = math.sqrt(normal[0, v] ** 2 + normal[1, v] ** 2 + normal[2, v] ** 2)
        if size > 0.0:
            normal[0, v] /= size
            normal[1, v] /= size
            normal[2, v] /= size
    return total / 6.0
