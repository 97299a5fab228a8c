"""Compiled kinematics and inertia of the skeleton: functions of arrays.

Shapes: body b, degree of freedom d. Everything in SI units. What a hand is comes as one record, ``mechanics.Mechanics``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

if TYPE_CHECKING:
    from handlab.simulation.mechanics import Mechanics

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]


@compiled
def pose(
    angle: Array,
    parent: Index,
    first: Index,
    count: Index,
    axis: Array,
    anchor: Array,
    transform: Array,
    posed_axis: Array,
    posed_anchor: Array,
) -> None:
    """Product of exponentials: fill ``transform`` (b, 4, 4), ``posed_axis`` (d, 3) and ``posed_anchor`` (d, 3) from ``angle`` (d,).

    Body b hangs on ``parent[b]`` (-1: fixed) by the degrees of freedom ``first[b]`` to ``first[b] + count[b] - 1``;
    ``axis`` and ``anchor`` (d, 3) are written in the zero posture.
    """
    rotation = np.empty((3, 3))
    for b in range(parent.shape[0]):
        here = transform[b]
        if parent[b] < 0:
            for i in range(4):
                for j in range(4):
                    here[i, j] = 1.0 if i == j else 0.0
        else:
            here[:, :] = transform[parent[b]]
        for d in range(first[b], first[b] + count[b]):
            x, y, z = axis[d, 0], axis[d, 1], axis[d, 2]
            p, q, r = anchor[d, 0], anchor[d, 1], anchor[d, 2]
            for i in range(3):
                posed_axis[d, i] = here[i, 0] * x + here[i, 1] * y + here[i, 2] * z
                posed_anchor[d, i] = here[i, 0] * p + here[i, 1] * q + here[i, 2] * r + here[i, 3]
            s, c = np.sin(angle[d]), np.cos(angle[d])
            v = 1.0 - c
            rotation[0, 0], rotation[0, 1], rotation[0, 2] = c + v * x * x, v * x * y - s * z, v * x * z + s * y
            rotation[1, 0], rotation[1, 1], rotation[1, 2] = v * x * y + s * z, c + v * y * y, v * y * z - s * x
            rotation[2, 0], rotation[2, 1], rotation[2, 2] = v * x * z - s * y, v * y * z + s * x, c + v * z * z
            for i in range(3):
                a0, a1, a2 = here[i, 0], here[i, 1], here[i, 2]
                for j in range(3):
                    here[i, j] = a0 * rotation[0, j] + a1 * rotation[1, j] + a2 * rotation[2, j]
                # the anchor stays where it was
                here[i, 3] = posed_anchor[d, i] - here[i, 0] * p - here[i, 1] * q - here[i, 2] * r


@compiled
def relative(transform: Array, bind_inverse: Array, out: Array) -> None:
    """out = transform @ bind_inverse for every body: from the bind posture to the pose, as rows (b, 3, 4)."""
    for b in range(transform.shape[0]):
        for i in range(3):
            for j in range(4):
                value = transform[b, i, 3] if j == 3 else 0.0
                for k in range(3):
                    value += transform[b, i, k] * bind_inverse[b, k, j]
                out[b, i, j] = value


@compiled
def composites(transform: Array, m: Mechanics, total: Array) -> None:
    """Fill ``total`` (b, 10): mass, first moment (3) and inertia tensor about the origin (xx yy zz xy xz yz) of each posed body alone."""
    masses, centres, inertias = m.mass, m.centre, m.inertia
    rotated = np.empty((3, 3))
    for b in range(masses.shape[0]):
        t = transform[b]
        mass, cx, cy, cz = masses[b], centres[b, 0], centres[b, 1], centres[b, 2]
        x = t[0, 0] * cx + t[0, 1] * cy + t[0, 2] * cz + t[0, 3]
        y = t[1, 0] * cx + t[1, 1] * cy + t[1, 2] * cz + t[1, 3]
        z = t[2, 0] * cx + t[2, 1] * cy + t[2, 2] * cz + t[2, 3]
        for i in range(3):
            for j in range(3):
                rotated[i, j] = t[i, 0] * inertias[b, 0, j] + t[i, 1] * inertias[b, 1, j] + t[i, 2] * inertias[b, 2, j]
        total[b, 0] = mass
        total[b, 1] = mass * x
        total[b, 2] = mass * y
        total[b, 3] = mass * z
        total[b, 4] = rotated[0, 0] * t[0, 0] + rotated[0, 1] * t[0, 1] + rotated[0, 2] * t[0, 2] + mass * (y * y + z * z)
        total[b, 5] = rotated[1, 0] * t[1, 0] + rotated[1, 1] * t[1, 1] + rotated[1, 2] * t[1, 2] + mass * (x * x + z * z)
        total[b, 6] = rotated[2, 0] * t[2, 0] + rotated[2, 1] * t[2, 1] + rotated[2, 2] * t[2, 2] + mass * (x * x + y * y)
        total[b, 7] = rotated[0, 0] * t[1, 0] + rotated[0, 1] * t[1, 1] + rotated[0, 2] * t[1, 2] - mass * x * y
        total[b, 8] = rotated[0, 0] * t[2, 0] + rotated[0, 1] * t[2, 1] + rotated[0, 2] * t[2, 2] - mass * x * z
        total[b, 9] = rotated[1, 0] * t[2, 0] + rotated[1, 1] * t[2, 1] + rotated[1, 2] * t[2, 2] - mass * y * z


@compiled
def gather(parent: Index, total: Array) -> None:
    """Add each row of ``total`` (b, ...) to its parent's, from the tips to the forearm: what each body carries."""
    for b in range(parent.shape[0] - 1, 0, -1):
        if parent[b] >= 0:
            for i in range(total.shape[1]):
                total[parent[b], i] += total[b, i]


@compiled
def dof_inertia(transform: Array, posed_axis: Array, posed_anchor: Array, m: Mechanics, total: Array, out: Array) -> None:
    """Fill ``out`` (d,) with the moment of inertia of all bodies that each degree of freedom carries, about its posed axis.

    ``total`` (b, 10) is filled with what each body carries: see ``composites``.
    """
    parent, first, count = m.parent, m.first, m.count
    composites(transform, m, total)
    gather(parent, total)
    for b in range(parent.shape[0]):
        for d in range(first[b], first[b] + count[b]):
            ax, ay, az = posed_axis[d, 0], posed_axis[d, 1], posed_axis[d, 2]
            px, py, pz = posed_anchor[d, 0], posed_anchor[d, 1], posed_anchor[d, 2]
            s = total[b]
            # about the origin: a' I a; then to the anchor: sum m |(c - p) x a|^2 = sum m |c x a|^2 - 2 M (c x a).(p x a) + M |p x a|^2
            about = ax * ax * s[4] + ay * ay * s[5] + az * az * s[6] + 2.0 * (ax * ay * s[7] + ax * az * s[8] + ay * az * s[9])
            ux, uy, uz = py * az - pz * ay, pz * ax - px * az, px * ay - py * ax
            cx, cy, cz = s[2] * az - s[3] * ay, s[3] * ax - s[1] * az, s[1] * ay - s[2] * ax
            out[d] = about - 2.0 * (cx * ux + cy * uy + cz * uz) + s[0] * (ux * ux + uy * uy + uz * uz)
