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
    for b in range(parent.shape[0]):
        above = parent[b]
        if above < 0:
            for i in range(4):
                for j in range(4):
                    transform[b, i, j] = 1.0 if i == j else 0.0
        else:
            for i in range(4):
                for j in range(4):
                    transform[b, i, j] = transform[above, i, j]
        for d in range(first[b], first[b] + count[b]):
            x, y, z = axis[d, 0], axis[d, 1], axis[d, 2]
            p, q, r = anchor[d, 0], anchor[d, 1], anchor[d, 2]
            s, c = np.sin(angle[d]), np.cos(angle[d])
            v = 1.0 - c
            xx, xy, xz = c + v * x * x, v * x * y - s * z, v * x * z + s * y
            yx, yy, yz = v * x * y + s * z, c + v * y * y, v * y * z - s * x
            zx, zy, zz = v * x * z - s * y, v * y * z + s * x, c + v * z * z
            for i in range(3):
                a0, a1, a2, shift = transform[b, i, 0], transform[b, i, 1], transform[b, i, 2], transform[b, i, 3]
                posed_axis[d, i] = a0 * x + a1 * y + a2 * z
                here = a0 * p + a1 * q + a2 * r + shift
                posed_anchor[d, i] = here
                b0, b1, b2 = a0 * xx + a1 * yx + a2 * zx, a0 * xy + a1 * yy + a2 * zy, a0 * xz + a1 * yz + a2 * zz
                transform[b, i, 0], transform[b, i, 1], transform[b, i, 2] = b0, b1, b2
                # the anchor stays where it was
                transform[b, i, 3] = here - b0 * p - b1 * q - b2 * r


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
    masses, centres, inertias = m.mass, m.centre, m.inertia
    for b in range(masses.shape[0]):
        mass, cx, cy, cz = masses[b], centres[b, 0], centres[b, 1], centres[b, 2]
        a, d, g = transform[b, 0, 0], transform[b, 1, 0], transform[b, 2, 0]
        e, f, h = transform[b, 0, 1], transform[b, 1, 1], transform[b, 2, 1]
        p, q, r = transform[b, 0, 2], transform[b, 1, 2], transform[b, 2, 2]
        x = a * cx + e * cy + p * cz + transform[b, 0, 3]
        y = d * cx + f * cy + q * cz + transform[b, 1, 3]
        z = g * cx + h * cy + r * cz + transform[b, 2, 3]
        xx, yy, zz, xy, xz, yz = (
            inertias[b, 0, 0], inertias[b, 1, 1], inertias[b, 2, 2], inertias[b, 0, 1], inertias[b, 0, 2], inertias[b, 1, 2]
        )  # fmt: skip
        # rows of R I, then R I R'
        a0, a1, a2 = a * xx + e * xy + p * xz, a * xy + e * yy + p * yz, a * xz + e * yz + p * zz
        d0, d1, d2 = d * xx + f * xy + q * xz, d * xy + f * yy + q * yz, d * xz + f * yz + q * zz
        g0, g1, g2 = g * xx + h * xy + r * xz, g * xy + h * yy + r * yz, g * xz + h * yz + r * zz
        total[b, 0], total[b, 1], total[b, 2], total[b, 3] = mass, mass * x, mass * y, mass * z
        total[b, 4] = a0 * a + a1 * e + a2 * p + mass * (y * y + z * z)
        total[b, 5] = d0 * d + d1 * f + d2 * q + mass * (x * x + z * z)
        total[b, 6] = g0 * g + g1 * h + g2 * r + mass * (x * x + y * y)
        total[b, 7] = a0 * d + a1 * f + a2 * q - mass * x * y
        total[b, 8] = a0 * g + a1 * h + a2 * r - mass * x * z
        total[b, 9] = d0 * g + d1 * h + d2 * r - mass * y * z


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
    parent, first, count = m.parent, m.first, m.dof_count
    composites(transform, m, total)
    gather(parent, total)
    for b in range(parent.shape[0]):
        for d in range(first[b], first[b] + count[b]):
            ax, ay, az = posed_axis[d, 0], posed_axis[d, 1], posed_axis[d, 2]
            px, py, pz = posed_anchor[d, 0], posed_anchor[d, 1], posed_anchor[d, 2]
            # about the origin: a' I a; then to the anchor: sum m |(c - p) x a|^2 = sum m |c x a|^2 - 2 M (c x a).(p x a) + M |p x a|^2
            about = ax * ax * total[b, 4] + ay * ay * total[b, 5] + az * az * total[b, 6]
            about += 2.0 * (ax * ay * total[b, 7] + ax * az * total[b, 8] + ay * az * total[b, 9])
            ux, uy, uz = py * az - pz * ay, pz * ax - px * az, px * ay - py * ax
            mx, my, mz = total[b, 1], total[b, 2], total[b, 3]
            cx, cy, cz = my * az - mz * ay, mz * ax - mx * az, mx * ay - my * ax
            out[d] = about - 2.0 * (cx * ux + cy * uy + cz * uz) + total[b, 0] * (ux * ux + uy * uy + uz * uz)
