"""Compiled skin: all leapfrog substeps of a frame, and the anchors they follow.

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
def carried(quaternion: Array, index: Node, weight: Array, points: Array, arms: Array, turn: Array, centre: Array, arm: Array) -> None:
    """Carry ``points``, ``arms`` (n, 3) of the bind posture by blended dual quaternions (b, 8) into ``centre``, ``arm`` (3, n).

    ``turn`` (4, n) receives the unit quaternion w x y z that turns every node. The sum of quaternions is written out here, in ``turned``
    and in ``skin_kernel.blend_dual``: shared as a function of arrays it makes the blend 3.3 times slower.
    """
    count = points.shape[0]
    dual = np.empty((4, count))
    for n in range(count):
        first = index[n, 0]
        w0, x0, y0, z0 = quaternion[first, 0], quaternion[first, 1], quaternion[first, 2], quaternion[first, 3]
        w, x, y, z, dw, dx, dy, dz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(index.shape[1]):
            g = weight[n, k]
            if g == 0.0:
                break
            b = index[n, k]
            if w0 * quaternion[b, 0] + x0 * quaternion[b, 1] + y0 * quaternion[b, 2] + z0 * quaternion[b, 3] < 0.0:
                g = -g
            w += g * quaternion[b, 0]
            x += g * quaternion[b, 1]
            y += g * quaternion[b, 2]
            z += g * quaternion[b, 3]
            dw += g * quaternion[b, 4]
            dx += g * quaternion[b, 5]
            dy += g * quaternion[b, 6]
            dz += g * quaternion[b, 7]
        turn[0, n], turn[1, n], turn[2, n], turn[3, n] = w, x, y, z
        dual[0, n], dual[1, n], dual[2, n], dual[3, n] = dw, dx, dy, dz
    # Three loops that do several nodes at once: one loop over all these arrays would not.
    for n in range(count):
        w, x, y, z = turn[0, n], turn[1, n], turn[2, n], turn[3, n]
        size = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
        turn[0, n], turn[1, n], turn[2, n], turn[3, n] = w * size, x * size, y * size, z * size
        dual[0, n] *= size
        dual[1, n] *= size
        dual[2, n] *= size
        dual[3, n] *= size
    for n in range(count):
        w, x, y, z = turn[0, n], turn[1, n], turn[2, n], turn[3, n]
        p, q, r = arms[n, 0], arms[n, 1], arms[n, 2]
        a, b_, c = y * r - z * q + w * p, z * p - x * r + w * q, x * q - y * p + w * r
        arm[0, n] = p + 2.0 * (y * c - z * b_)
        arm[1, n] = q + 2.0 * (z * a - x * c)
        arm[2, n] = r + 2.0 * (x * b_ - y * a)
    for n in range(count):
        w, x, y, z = turn[0, n], turn[1, n], turn[2, n], turn[3, n]
        dw, dx, dy, dz = dual[0, n], dual[1, n], dual[2, n], dual[3, n]
        p, q, r = points[n, 0], points[n, 1], points[n, 2]
        a, b_, c = y * r - z * q + w * p, z * p - x * r + w * q, x * q - y * p + w * r
        centre[0, n] = p + 2.0 * (y * c - z * b_ + w * dx - dw * x + y * dz - z * dy)
        centre[1, n] = q + 2.0 * (z * a - x * c + w * dy - dw * y + z * dx - x * dz)
        centre[2, n] = r + 2.0 * (x * b_ - y * a + w * dz - dw * z + x * dy - y * dx)


@compiled
def turned(quaternion: Array, index: Node, weight: Array, turn: Array) -> None:
    """``turn`` (4, n): unit quaternions w x y z of nodes that dual quaternions (b, 8) blend, as in ``carried``."""
    for n in range(index.shape[0]):
        first = index[n, 0]
        w0, x0, y0, z0 = quaternion[first, 0], quaternion[first, 1], quaternion[first, 2], quaternion[first, 3]
        w, x, y, z = 0.0, 0.0, 0.0, 0.0
        for k in range(index.shape[1]):
            g = weight[n, k]
            if g == 0.0:
                break
            b = index[n, k]
            if w0 * quaternion[b, 0] + x0 * quaternion[b, 1] + y0 * quaternion[b, 2] + z0 * quaternion[b, 3] < 0.0:
                g = -g
            w += g * quaternion[b, 0]
            x += g * quaternion[b, 1]
            y += g * quaternion[b, 2]
            z += g * quaternion[b, 3]
        size = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
        turn[0, n], turn[1, n], turn[2, n], turn[3, n] = w * size, x * size, y * size, z * size


@compiled
def lifted(
    node: Node,
    ellipsoid: Node,
    share: Array,
    local: Array,
    below: Array,
    points: Array,
    turn: Array,
    centre_of: Array,
    frame: Array,
    half: Array,
    most: float,
    centre: Array,
) -> None:
    """Move ``centre`` (3, n) of nodes that lie on muscles as the muscles' surfaces move.

    Tie t joins ``node[t]`` to ``ellipsoid[t]`` with ``share[t]``; its foot has the place ``local`` (t, 3) in half-axes of the ellipsoid
    (``centre_of``, ``frame``, ``half``) and ``below`` (t, 3) metres from the node's bind place ``points`` (n, 3). The node moves by the
    shares of how far each foot is from where the node's own rotation would carry it; at most ``most`` metres in all.
    """
    # ties come node by node
    t, ties = 0, node.shape[0]
    while t < ties:
        i = node[t]
        w, x, y, z = turn[0, i], turn[1, i], turn[2, i], turn[3, i]
        sx, sy, sz = 0.0, 0.0, 0.0
        while t < ties and node[t] == i:
            s, g = ellipsoid[t], share[t]
            u, v, o = local[t, 0] * half[s, 0], local[t, 1] * half[s, 1], local[t, 2] * half[s, 2]
            p, q, r = below[t, 0], below[t, 1], below[t, 2]
            a, b, c = y * r - z * q + w * p, z * p - x * r + w * q, x * q - y * p + w * r
            p, q, r = p + 2.0 * (y * c - z * b), q + 2.0 * (z * a - x * c), r + 2.0 * (x * b - y * a)
            sx += g * (centre_of[s, 0] + frame[s, 0, 0] * u + frame[s, 0, 1] * v + frame[s, 0, 2] * o - centre[0, i] - p)
            sy += g * (centre_of[s, 1] + frame[s, 1, 0] * u + frame[s, 1, 1] * v + frame[s, 1, 2] * o - centre[1, i] - q)
            sz += g * (centre_of[s, 2] + frame[s, 2, 0] * u + frame[s, 2, 1] * v + frame[s, 2, 2] * o - centre[2, i] - r)
            t += 1
        # a smooth limit: next to nothing for a few millimetres, never beyond ``most``
        g = 1.0 / math.sqrt(1.0 + (sx * sx + sy * sy + sz * sz) / (most * most))
        centre[0, i] += g * sx
        centre[1, i] += g * sy
        centre[2, i] += g * sz


@compiled
def columns(
    centre: Array,
    arm: Array,
    faces: Node,
    first: Node,
    second: Node,
    degree: Array,
    area: Array,
    depth: Array,
    swelling: float,
    low: float,
    high: float,
    reach: float,
    passes: int,
) -> None:
    """Columns of tissue keep their volume, in place: shorter where the net of ``centre`` (3, n) is stretched, longer where it is pressed.

    A column's length changes by (area / area now) ** 0.75, evened out along the edges ``passes`` times, between ``low`` and ``high``,
    and by 1 + ``swelling``, less below taut skin; of columns deeper than ``reach`` only so much of the depth. ``degree`` (n,)
    counts the edges of each node.
    """
    nodes = centre.shape[1]
    now, mean = np.zeros(nodes), np.empty(nodes)
    weight = 0.5 / degree
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = centre[0, j] - centre[0, i], centre[1, j] - centre[1, i], centre[2, j] - centre[2, i]
        bx, by, bz = centre[0, k] - centre[0, i], centre[1, k] - centre[1, i], centre[2, k] - centre[2, i]
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        a = math.sqrt(nx * nx + ny * ny + nz * nz) / 6.0
        now[i] += a
        now[j] += a
        now[k] += a
    for i in range(nodes):
        now[i] = min(max(now[i] / area[i], 0.2), 5.0) - 1.0
    for _ in range(passes):
        mean[:] = 0.0
        for e in range(first.shape[0]):
            i, j = first[e], second[e]
            mean[i] += now[j]
            mean[j] += now[i]
        for i in range(nodes):
            now[i] = 0.5 * now[i] + weight[i] * mean[i]
    for i in range(nodes):
        # what fills the volume goes where skin is loose, not below taut skin
        loose = min(max(1.0 - 2.0 * now[i], 0.0), 2.0)
        ratio = 1.0 + now[i]
        g = min(max(1.0 / math.sqrt(ratio * math.sqrt(ratio)), low), high) * (1.0 + loose * swelling) - 1.0
        g *= min(1.0, reach / depth[i])
        for d in range(3):
            centre[d, i] += g * arm[d, i]
            arm[d, i] += g * arm[d, i]


@compiled
def framed(before: Array, centre: Array, arm: Array, share: float, anchor: Array) -> None:
    """Fill ``anchor`` (10, n) of ``leapfrog``: centres ``before`` and at the end, arms, and rest lengths, ``share`` of the arms."""
    for i in range(centre.shape[1]):
        for d in range(3):
            anchor[d, i] = before[d, i]
            anchor[3 + d, i] = centre[d, i] - before[d, i]
            anchor[6 + d, i] = arm[d, i]
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
