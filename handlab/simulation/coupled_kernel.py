"""The whole skeleton at once, compiled: M(y) y'' + h(y, y') = torque, in the moving coordinates.

M by composite rigid bodies, h (velocity terms and gravity) by the recursive Newton-Euler method, elimination along the tree
(Featherstone, Rigid Body Dynamics Algorithms, 2008). Spatial vectors are written about the origin of the hand's frame, so nothing
is transformed on the way: (angular, linear) of velocities, (moment, force) of forces.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled
from handlab.simulation.skeleton_kernel import composites, gather, pose
from handlab.simulation.torque_kernel import muscle_torque, passive_torque

if TYPE_CHECKING:
    from handlab.simulation.mechanics import Mechanics

Array = NDArray[np.float64]
Unsigned = NDArray[np.uint32]
Flags = NDArray[np.bool_]

ROUNDS = 4  # over all coordinates that run into a hard stop in one substep; each round uses the last one's speeds


class Workspace(NamedTuple):
    """Room for one evaluation of the equation of motion, kept from step to step; shapes as in ``Mechanics``."""

    angle: Array
    transform: Array
    axis: Array
    anchor: Array
    carried: Array
    screw: Array
    velocity: Array
    acceleration: Array
    force: Array
    momentum: Array


@compiled
def workspace(bodies: int, dofs: int) -> Workspace:
    """Room for ``bodies`` and degrees of freedom."""
    return Workspace(
        np.empty(dofs), np.empty((bodies, 4, 4)), np.empty((dofs, 3)), np.empty((dofs, 3)), np.empty((bodies, 10)), np.empty((dofs, 6)),
        np.zeros((bodies, 6)), np.zeros((bodies, 6)), np.empty((bodies, 6)), np.empty((1, 6)),
    )  # fmt: skip


@compiled
def apply_inertia(carried: Array, b: int, motion: Array, i: int, out: Array, o: int) -> None:
    """Row ``o`` of ``out``: spatial momentum of body ``carried[b]`` (see ``composites``) that moves with row ``i`` of ``motion``."""
    wx, wy, wz, x, y, z = motion[i, 0], motion[i, 1], motion[i, 2], motion[i, 3], motion[i, 4], motion[i, 5]
    mass, mx, my, mz = carried[b, 0], carried[b, 1], carried[b, 2], carried[b, 3]
    xy, xz, yz = carried[b, 7], carried[b, 8], carried[b, 9]
    out[o, 0] = carried[b, 4] * wx + xy * wy + xz * wz + my * z - mz * y
    out[o, 1] = xy * wx + carried[b, 5] * wy + yz * wz + mz * x - mx * z
    out[o, 2] = xz * wx + yz * wy + carried[b, 6] * wz + mx * y - my * x
    out[o, 3] = mass * x + wy * mz - wz * my
    out[o, 4] = mass * y + wz * mx - wx * mz
    out[o, 5] = mass * z + wx * my - wy * mx


@compiled
def mass_and_bias(y: Array, speed: Array, gravity: Array, m: Mechanics, room: Workspace, mass: Array, bias: Array) -> None:
    """Fill the lower half of ``mass`` (k, k), where it is not 0, and ``bias`` (k,): M y'' + bias = torque."""
    parent, first, count, driver, ratio, offset = m.parent, m.first, m.dof_count, m.driver, m.ratio, m.offset
    ancestor_start, ancestor = m.ancestor_start, m.ancestor
    angle, transform, axis, anchor, carried = room.angle, room.transform, room.axis, room.anchor, room.carried
    screw, velocity, acceleration, force, momentum = room.screw, room.velocity, room.acceleration, room.force, room.momentum
    dofs, bodies, moving = ratio.shape[0], parent.shape[0], y.shape[0]
    for d in range(dofs):
        angle[d] = offset[d] + ratio[d] * y[driver[d]]
    pose(angle, parent, first, count, m.axis, m.anchor, transform, axis, anchor)
    composites(transform, m, carried)
    for b in range(bodies):
        above = parent[b]
        v0 = v1 = v2 = v3 = v4 = v5 = a0 = a1 = a2 = 0.0
        a3, a4, a5 = -gravity[0], -gravity[1], -gravity[2]
        if above >= 0:
            v0, v1, v2 = velocity[above, 0], velocity[above, 1], velocity[above, 2]
            v3, v4, v5 = velocity[above, 3], velocity[above, 4], velocity[above, 5]
            a0, a1, a2 = acceleration[above, 0], acceleration[above, 1], acceleration[above, 2]
            a3, a4, a5 = acceleration[above, 3], acceleration[above, 4], acceleration[above, 5]
        for d in range(first[b], first[b] + count[b]):
            x, z, w = axis[d, 0], axis[d, 1], axis[d, 2]
            px, py, pz = anchor[d, 0], anchor[d, 1], anchor[d, 2]
            lx, ly, lz = py * w - pz * z, pz * x - px * w, px * z - py * x
            screw[d, 0], screw[d, 1], screw[d, 2], screw[d, 3], screw[d, 4], screw[d, 5] = x, z, w, lx, ly, lz
            q = ratio[d] * speed[driver[d]]
            # the axis itself is carried along: its rate of change is v x s
            a0 += q * (v1 * w - v2 * z)
            a1 += q * (v2 * x - v0 * w)
            a2 += q * (v0 * z - v1 * x)
            a3 += q * (v1 * lz - v2 * ly + v4 * w - v5 * z)
            a4 += q * (v2 * lx - v0 * lz + v5 * x - v3 * w)
            a5 += q * (v0 * ly - v1 * lx + v3 * z - v4 * x)
            v0, v1, v2, v3, v4, v5 = v0 + q * x, v1 + q * z, v2 + q * w, v3 + q * lx, v4 + q * ly, v5 + q * lz
        velocity[b, 0], velocity[b, 1], velocity[b, 2], velocity[b, 3], velocity[b, 4], velocity[b, 5] = v0, v1, v2, v3, v4, v5
        acceleration[b, 0], acceleration[b, 1], acceleration[b, 2] = a0, a1, a2
        acceleration[b, 3], acceleration[b, 4], acceleration[b, 5] = a3, a4, a5
        apply_inertia(carried, b, acceleration, b, force, b)
        apply_inertia(carried, b, velocity, b, momentum, 0)
        h0, h1, h2, h3, h4, h5 = momentum[0, 0], momentum[0, 1], momentum[0, 2], momentum[0, 3], momentum[0, 4], momentum[0, 5]
        force[b, 0] += v1 * h2 - v2 * h1 + v4 * h5 - v5 * h4
        force[b, 1] += v2 * h0 - v0 * h2 + v5 * h3 - v3 * h5
        force[b, 2] += v0 * h1 - v1 * h0 + v3 * h4 - v4 * h3
        force[b, 3] += v1 * h5 - v2 * h4
        force[b, 4] += v2 * h3 - v0 * h5
        force[b, 5] += v0 * h4 - v1 * h3
    gather(parent, carried)
    gather(parent, force)
    for k in range(moving):
        bias[k] = 0.0
        mass[k, k] = 0.0
        for j in range(ancestor_start[k], ancestor_start[k + 1]):
            mass[k, ancestor[j]] = 0.0
    for b in range(bodies):
        for d in range(first[b], first[b] + count[b]):
            c, k = ratio[d], driver[d]
            if c == 0.0:
                continue
            pull = 0.0
            for i in range(6):
                pull += screw[d, i] * force[b, i]
            bias[k] += c * pull
            apply_inertia(carried, b, screw, d, momentum, 0)
            h0, h1, h2, h3, h4, h5 = momentum[0, 0], momentum[0, 1], momentum[0, 2], momentum[0, 3], momentum[0, 4], momentum[0, 5]
            above, last = b, d
            while above >= 0:
                for e in range(last, first[above] - 1, -1):
                    j = driver[e]
                    value = screw[e, 0] * h0 + screw[e, 1] * h1 + screw[e, 2] * h2 + screw[e, 3] * h3 + screw[e, 4] * h4 + screw[e, 5] * h5
                    value *= c * ratio[e]
                    if j == k and e != d:
                        value *= 2.0  # a follower and its driver: both halves of the matrix fall on the diagonal
                    mass[max(j, k), min(j, k)] += value
                above = parent[above]
                if above >= 0:
                    last = first[above] + count[above] - 1


@compiled
def factor(a: Array, ancestor_start: Unsigned, ancestor: Unsigned) -> None:
    """A = L' D L in the lower half of ``a`` (k, k), from the last coordinate to the first: nothing is filled in."""
    for k in range(a.shape[0] - 1, -1, -1):
        for p in range(ancestor_start[k], ancestor_start[k + 1]):
            i = ancestor[p]
            part = a[k, i] / a[k, k]
            for r in range(p, ancestor_start[k + 1]):
                j = ancestor[r]
                a[i, j] -= part * a[k, j]
            a[k, i] = part


@compiled
def solve(a: Array, ancestor_start: Unsigned, ancestor: Unsigned, x: Array) -> None:
    """Solve A x = b in place with the factors of ``factor``."""
    for k in range(x.shape[0] - 1, -1, -1):
        for p in range(ancestor_start[k], ancestor_start[k + 1]):
            x[ancestor[p]] -= a[k, ancestor[p]] * x[k]
    for k in range(x.shape[0]):
        x[k] /= a[k, k]
        for p in range(ancestor_start[k], ancestor_start[k + 1]):
            x[k] -= a[k, ancestor[p]] * x[ancestor[p]]


@compiled
def hold_stops(
    y: Array, speed: Array, dt: float, stop: Array, held: Flags, a: Array, ancestor_start: Unsigned, ancestor: Unsigned, column: Array
) -> None:
    """Impulses at the hard stops: what would pass one in this substep ends at it, and its neighbours feel that.

    ``column`` (k,) is used up.
    """
    for _ in range(ROUNDS):
        none = True
        for k in range(y.shape[0]):
            if held[k]:
                continue
            ahead = y[k] + dt * speed[k]
            if stop[k, 0] <= ahead <= stop[k, 1]:
                continue
            none = False
            reached = ((stop[k, 0] if ahead < stop[k, 0] else stop[k, 1]) - y[k]) / dt
            column[:] = 0.0
            column[k] = 1.0
            solve(a, ancestor_start, ancestor, column)
            impulse = (reached - speed[k]) / column[k]
            for j in range(y.shape[0]):
                speed[j] += impulse * column[j]
        if none:
            return


@compiled
def advance_coupled(
    path_y: Array, path_speed: Array, contraction: Array, dt: float, m: Mechanics, gravity: Array, held: Flags, pushing: bool
) -> None:
    """March n substeps of ``dt`` from ``path_y[0]``, ``path_speed[0]`` (k,); fill rows 1 to n of both (n + 1, k).

    (M + dt drag + dt^2 slope) dv = dt (torque - bias - drag v - dt slope v): friction, springs and capsules at the end of the
    substep (linearly implicit), muscles and velocity terms at its beginning.
    """
    moving, ancestor_start, ancestor = path_y.shape[1], m.ancestor_start, m.ancestor
    y, speed = path_y[0].copy(), path_speed[0].copy()
    mass, bias, change = np.zeros((moving, moving)), np.empty(moving), np.empty(moving)
    torque, slope, drag, stop = np.empty(moving), np.empty(moving), np.empty(moving), np.empty((moving, 2))
    room = workspace(m.parent.shape[0], m.ratio.shape[0])
    for k in range(moving):
        if held[k]:
            speed[k] = 0.0
    for n in range(contraction.shape[0]):
        mass_and_bias(y, speed, gravity, m, room, mass, bias)
        torque[:] = 0.0
        muscle_torque(y, contraction[n], m, pushing, torque)
        passive_torque(y, m, torque, slope, drag, stop)
        for k in range(moving):
            end = drag[k] + dt * slope[k]
            mass[k, k] += dt * end
            change[k] = dt * (torque[k] - bias[k] - end * speed[k])
        for k in range(moving):
            if held[k]:
                change[k] = 0.0
                mass[k, k] = 1.0
            for p in range(ancestor_start[k], ancestor_start[k + 1]):
                if held[k] or held[ancestor[p]]:
                    mass[k, ancestor[p]] = 0.0
        factor(mass, ancestor_start, ancestor)
        solve(mass, ancestor_start, ancestor, change)
        for k in range(moving):
            speed[k] += change[k]
        hold_stops(y, speed, dt, stop, held, mass, ancestor_start, ancestor, change)
        for k in range(moving):
            if not held[k]:
                y[k] += dt * speed[k]
                if y[k] < stop[k, 0]:
                    y[k] = stop[k, 0]
                    speed[k] = max(0.0, speed[k])
                elif y[k] > stop[k, 1]:
                    y[k] = stop[k, 1]
                    speed[k] = min(0.0, speed[k])
            path_y[n + 1, k] = y[k]
            path_speed[n + 1, k] = speed[k]
