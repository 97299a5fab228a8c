"""Compiled anchors: where the skin is tied, which follows from bones and muscles alone, and how columns of tissue take up volume.

Arrays of nodes are (3, n), one contiguous row per axis, as in ``soft_skin_kernel``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Node = NDArray[np.uint32]


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
def stretched(centre: Array, faces: Node, first: Node, second: Node, degree: Array, area: Array, passes: int, stretch: Array) -> None:
    """``stretch`` (n,) receives area now / ``area`` - 1 of the net of ``centre`` (3, n), evened out along the edges ``passes`` times.

    ``degree`` (n,) counts the edges of each node.
    """
    nodes = centre.shape[1]
    mean, weight = np.empty(nodes), 0.5 / degree
    stretch[:] = 0.0
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = centre[0, j] - centre[0, i], centre[1, j] - centre[1, i], centre[2, j] - centre[2, i]
        bx, by, bz = centre[0, k] - centre[0, i], centre[1, k] - centre[1, i], centre[2, k] - centre[2, i]
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        a = math.sqrt(nx * nx + ny * ny + nz * nz) / 6.0
        stretch[i] += a
        stretch[j] += a
        stretch[k] += a
    for i in range(nodes):
        stretch[i] = min(max(stretch[i] / area[i], 0.2), 5.0) - 1.0
    for _ in range(passes):
        mean[:] = 0.0
        for e in range(first.shape[0]):
            i, j = first[e], second[e]
            mean[i] += stretch[j]
            mean[j] += stretch[i]
        for i in range(nodes):
            stretch[i] = 0.5 * stretch[i] + weight[i] * mean[i]


@compiled
def swollen(centre: Array, arm: Array, stretch: Array, depth: Array, swelling: float, low: float, high: float, reach: float) -> None:
    """Columns of tissue keep their volume, in place: shorter where the net of ``centre`` (3, n) is stretched, longer where it is pressed.

    A column's length changes by (1 + ``stretch``) ** -0.75, between ``low`` and ``high``, and by 1 + ``swelling``, less below taut skin;
    of columns deeper than ``reach`` only so much of the depth.
    """
    for i in range(centre.shape[1]):
        # what fills the volume goes where skin is loose, not below taut skin
        loose = min(max(1.0 - 2.0 * stretch[i], 0.0), 2.0)
        ratio = 1.0 + stretch[i]
        g = min(max(1.0 / math.sqrt(ratio * math.sqrt(ratio)), low), high) * (1.0 + loose * swelling) - 1.0
        g *= min(1.0, reach / depth[i])
        for d in range(3):
            centre[d, i] += g * arm[d, i]
            arm[d, i] += g * arm[d, i]


@compiled
def planes(turn: Array, faces: Node, normal: Array, plane: Array) -> None:
    """``plane`` (3, M) receives the rest normals ``normal`` (M, 3), carried by the mean of the corners' rotations ``turn`` (4, n)."""
    count = faces.shape[0]
    mean = np.empty((4, count))
    for f in range(count):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        w, x, y, z = turn[0, i], turn[1, i], turn[2, i], turn[3, i]
        g = math.copysign(1.0, w * turn[0, j] + x * turn[1, j] + y * turn[2, j] + z * turn[3, j])
        w, x, y, z = w + g * turn[0, j], x + g * turn[1, j], y + g * turn[2, j], z + g * turn[3, j]
        g = math.copysign(1.0, w * turn[0, k] + x * turn[1, k] + y * turn[2, k] + z * turn[3, k])
        w, x, y, z = w + g * turn[0, k], x + g * turn[1, k], y + g * turn[2, k], z + g * turn[3, k]
        mean[0, f], mean[1, f], mean[2, f], mean[3, f] = w, x, y, z
    for f in range(count):  # a loop of its own does several triangles at once
        w, x, y, z = mean[0, f], mean[1, f], mean[2, f], mean[3, f]
        p, q, r = normal[f, 0], normal[f, 1], normal[f, 2]
        a, b, c = y * r - z * q + w * p, z * p - x * r + w * q, x * q - y * p + w * r
        g = 2.0 / (w * w + x * x + y * y + z * z)
        plane[0, f] = p + g * (y * c - z * b)
        plane[1, f] = q + g * (z * a - x * c)
        plane[2, f] = r + g * (x * b - y * a)
