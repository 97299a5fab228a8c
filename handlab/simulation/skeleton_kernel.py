"""Compiled kinematics and dynamics of the skeleton: functions of arrays, the laws of ``handlab.physics`` and nothing else.

Shapes: body b, degree of freedom d, moving coordinate k, muscle m, substep n. Everything in SI units.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

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
def dof_inertia(
    transform: Array,
    posed_axis: Array,
    posed_anchor: Array,
    parent: Index,
    first: Index,
    count: Index,
    mass: Array,
    centre: Array,
    inertia: Array,
    out: Array,
) -> None:
    """Fill ``out`` (d,) with the moment of inertia of all bodies that each degree of freedom carries, about its posed axis.

    ``centre`` (b, 3) and ``inertia`` (b, 3, 3, about the centre) are written in the zero posture. Bodies are added from
    the tips to the wrist as mass, first moment and second moment about the origin.
    """
    bodies = parent.shape[0]
    total = np.zeros((bodies, 10))  # m, m c (3), then xx yy zz xy xz yz of the inertia tensor about the origin
    rotated = np.empty((3, 3))
    for b in range(bodies):
        t = transform[b]
        m = mass[b]
        x = t[0, 0] * centre[b, 0] + t[0, 1] * centre[b, 1] + t[0, 2] * centre[b, 2] + t[0, 3]
        y = t[1, 0] * centre[b, 0] + t[1, 1] * centre[b, 1] + t[1, 2] * centre[b, 2] + t[1, 3]
        z = t[2, 0] * centre[b, 0] + t[2, 1] * centre[b, 1] + t[2, 2] * centre[b, 2] + t[2, 3]
        for i in range(3):
            for j in range(3):
                rotated[i, j] = t[i, 0] * inertia[b, 0, j] + t[i, 1] * inertia[b, 1, j] + t[i, 2] * inertia[b, 2, j]
        total[b, 0] += m
        total[b, 1] += m * x
        total[b, 2] += m * y
        total[b, 3] += m * z
        total[b, 4] += rotated[0, 0] * t[0, 0] + rotated[0, 1] * t[0, 1] + rotated[0, 2] * t[0, 2] + m * (y * y + z * z)
        total[b, 5] += rotated[1, 0] * t[1, 0] + rotated[1, 1] * t[1, 1] + rotated[1, 2] * t[1, 2] + m * (x * x + z * z)
        total[b, 6] += rotated[2, 0] * t[2, 0] + rotated[2, 1] * t[2, 1] + rotated[2, 2] * t[2, 2] + m * (x * x + y * y)
        total[b, 7] += rotated[0, 0] * t[1, 0] + rotated[0, 1] * t[1, 1] + rotated[0, 2] * t[1, 2] - m * x * y
        total[b, 8] += rotated[0, 0] * t[2, 0] + rotated[0, 1] * t[2, 1] + rotated[0, 2] * t[2, 2] - m * x * z
        total[b, 9] += rotated[1, 0] * t[2, 0] + rotated[1, 1] * t[2, 1] + rotated[1, 2] * t[2, 2] - m * y * z
    for b in range(bodies - 1, 0, -1):
        if parent[b] >= 0:
            for i in range(10):
                total[parent[b], i] += total[b, i]
    for b in range(bodies):
        for d in range(first[b], first[b] + count[b]):
            ax, ay, az = posed_axis[d, 0], posed_axis[d, 1], posed_axis[d, 2]
            px, py, pz = posed_anchor[d, 0], posed_anchor[d, 1], posed_anchor[d, 2]
            s = total[b]
            # about the origin: a' I a; then to the anchor: sum m |(c - p) x a|^2 = sum m |c x a|^2 - 2 M (c x a).(p x a) + M |p x a|^2
            about = ax * ax * s[4] + ay * ay * s[5] + az * az * s[6] + 2.0 * (ax * ay * s[7] + ax * az * s[8] + ay * az * s[9])
            ux, uy, uz = py * az - pz * ay, pz * ax - px * az, px * ay - py * ax
            cx, cy, cz = s[2] * az - s[3] * ay, s[3] * ax - s[1] * az, s[1] * ay - s[2] * ax
            out[d] = about - 2.0 * (cx * ux + cy * uy + cz * uz) + s[0] * (ux * ux + uy * uy + uz * uz)


@compiled
def muscle_forces(
    contraction: Array, length: Array, rest_length: Array, max_force: Array, curves: tuple[float, float, float], force: Array
) -> None:
    """(1'), sound reading: fill ``force`` (m,) from ``contraction`` (m,) and fibre ``length`` (m,).

    ``curves``: ACTIVE_PEAK, ACTIVE_CURVATURE and PASSIVE_CURVATURE of ``physics.muscle``. They come as arguments because a
    compiled kernel on disk does not notice that a constant of another module has changed.
    """
    peak, curvature, passive = curves
    for i in range(length.shape[0]):
        ratio = length[i] / rest_length[i]
        active = 1.0 - curvature * (ratio - peak) ** 2
        stretch = ratio - 1.0
        total = 0.0
        if active > 0.0:
            total = contraction[i] * active
        if stretch > 0.0:
            total += passive * stretch * stretch
        force[i] = total * max_force[i]


@compiled
def advance(
    path_y: Array, path_speed: Array, contraction: Array, dt: float, refresh: int,
    arm: Array, arm_transposed: Array, length_at_zero: Array, rest_length: Array, max_force: Array, curves: tuple[float, float, float],
    friction: Array, stiffness: Array, rest_y: Array, limits: Array, held: Flags,
    collateral_deviation: Index, collateral_flexion: Index, range_fraction: float, stiffness_factor: float, taut_at: float,
    coupling: Array, offset: Array, parent: Index, first: Index, count: Index, axis: Array, anchor: Array,
    mass: Array, centre: Array, inertia: Array,
) -> None:  # fmt: skip
    """March n substeps of ``dt`` from ``path_y[0]``, ``path_speed[0]`` (k,); fill rows 1 to n of both (n + 1, k).

    ``contraction`` (n, m) holds over each substep. Inertia is taken from the pose every ``refresh`` substeps.
    ``arm`` (m, k) = R C, ``length_at_zero`` (m,) the fibre length at y = 0; ``friction``, ``stiffness``, ``rest_y`` (k,),
    ``limits`` (k, 2), ``held`` (k,); ligaments as pairs of moving coordinates with their range fraction and stiffness
    factor at ``taut_at`` of flexion.
    """
    moving, muscles, dofs, bodies = path_y.shape[1], rest_length.shape[0], coupling.shape[0], parent.shape[0]
    y, speed = path_y[0].copy(), path_speed[0].copy()
    angle, inertia_dof, inertia_y = np.empty(dofs), np.empty(dofs), np.empty(moving)
    transform, posed_axis, posed_anchor = np.empty((bodies, 4, 4)), np.empty((dofs, 3)), np.empty((dofs, 3))
    length, force, torque, spring = np.empty(muscles), np.empty(muscles), np.empty(moving), np.empty(moving)
    for n in range(contraction.shape[0]):
        if n % refresh == 0:
            for d in range(dofs):
                value = offset[d]
                for k in range(moving):
                    value += coupling[d, k] * y[k]
                angle[d] = value
            pose(angle, parent, first, count, axis, anchor, transform, posed_axis, posed_anchor)
            dof_inertia(transform, posed_axis, posed_anchor, parent, first, count, mass, centre, inertia, inertia_dof)
            for k in range(moving):
                value = 0.0
                for d in range(dofs):
                    value += coupling[d, k] * coupling[d, k] * inertia_dof[d]
                inertia_y[k] = value
        for i in range(muscles):
            length[i] = length_at_zero[i]
        for k in range(moving):
            for i in range(muscles):
                length[i] -= arm_transposed[k, i] * y[k]
        muscle_forces(contraction[n], length, rest_length, max_force, curves, force)
        for k in range(moving):
            torque[k] = 0.0
            spring[k] = stiffness[k]
        for i in range(muscles):
            for k in range(moving):
                torque[k] += arm[i, k] * force[i]
        for p in range(collateral_deviation.shape[0]):
            d, f = collateral_deviation[p], collateral_flexion[p]
            u = min(1.0, max(0.0, y[f] / taut_at))
            away = y[d] - rest_y[d]
            torque[f] -= 0.5 * stiffness[d] * (stiffness_factor - 1.0) * 6.0 * u * (1.0 - u) / taut_at * away * away
            spring[d] = stiffness[d] * (1.0 + (stiffness_factor - 1.0) * u * u * (3.0 - 2.0 * u))
        for k in range(moving):
            if held[k]:
                speed[k] = 0.0
                continue
            rate = dt / inertia_y[k]
            pull = torque[k] - spring[k] * (y[k] - rest_y[k])
            speed[k] = (speed[k] + rate * pull) / (1.0 + rate * (friction[k] + dt * spring[k]))
            y[k] += dt * speed[k]
            if y[k] < limits[k, 0]:
                y[k] = limits[k, 0]
                speed[k] = max(0.0, speed[k])
            elif y[k] > limits[k, 1]:
                y[k] = limits[k, 1]
                speed[k] = min(0.0, speed[k])
        for p in range(collateral_deviation.shape[0]):
            d, f = collateral_deviation[p], collateral_flexion[p]
            if held[d]:
                continue
            u = min(1.0, max(0.0, y[f] / taut_at))
            fraction = 1.0 + (range_fraction - 1.0) * u * u * (3.0 - 2.0 * u)
            if y[d] < fraction * limits[d, 0]:
                y[d] = fraction * limits[d, 0]
                speed[d] = max(0.0, speed[d])
            elif y[d] > fraction * limits[d, 1]:
                y[d] = fraction * limits[d, 1]
                speed[d] = min(0.0, speed[d])
        path_y[n + 1] = y
        path_speed[n + 1] = speed
