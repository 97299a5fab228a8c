"""The whole skeleton at once, compiled: M(y) y'' + h(y, y') = torque, in the moving coordinates.

M by composite rigid bodies, h (velocity terms and gravity) by the recursive Newton-Euler method, elimination along the tree
(Featherstone, Rigid Body Dynamics Algorithms, 2008). Spatial vectors are written about the origin of the hand's frame, so nothing
is transformed on the way: (angular, linear) of velocities, (moment, force) of forces.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled
from handlab.simulation.skeleton_kernel import composites, gather, pose
from handlab.simulation.torque_kernel import muscle_torque, passive_torque

if TYPE_CHECKING:
    from handlab.simulation.mechanics import Mechanics

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

ROUNDS = 4  # over all coordinates that run into a hard stop in one substep; each round uses the last one's speeds


@compiled
def apply_inertia(s: Array, v: Array, out: Array) -> None:
    """Spatial momentum ``out`` (6,) of a body ``s`` (10,) (see ``composites``) that moves with ``v`` (6,)."""
    wx, wy, wz, x, y, z = v[0], v[1], v[2], v[3], v[4], v[5]
    out[0] = s[4] * wx + s[7] * wy + s[8] * wz + s[2] * z - s[3] * y
    out[1] = s[7] * wx + s[5] * wy + s[9] * wz + s[3] * x - s[1] * z
    out[2] = s[8] * wx + s[9] * wy + s[6] * wz + s[1] * y - s[2] * x
    out[3] = s[0] * x + wy * s[3] - wz * s[2]
    out[4] = s[0] * y + wz * s[1] - wx * s[3]
    out[5] = s[0] * z + wx * s[2] - wy * s[1]


@compiled
def mass_and_bias(y: Array, speed: Array, gravity: Array, m: Mechanics, mass: Array, bias: Array) -> None:
    """Fill the lower half of ``mass`` (k, k), where it is not 0, and ``bias`` (k,): M y'' + bias = torque."""
    parent, first, count, driver, ratio, offset = m.parent, m.first, m.count, m.driver, m.ratio, m.offset
    ancestor_start, ancestor = m.ancestor_start, m.ancestor
    dofs, bodies, moving = ratio.shape[0], parent.shape[0], y.shape[0]
    angle = np.empty(dofs)
    for d in range(dofs):
        angle[d] = offset[d] + ratio[d] * y[driver[d]]
    transform, axis, anchor = np.empty((bodies, 4, 4)), np.empty((dofs, 3)), np.empty((dofs, 3))
    pose(angle, parent, first, count, m.axis, m.anchor, transform, axis, anchor)
    carried = np.empty((bodies, 10))
    composites(transform, m, carried)
    screw, velocity, acceleration, force = np.empty((dofs, 6)), np.zeros((bodies, 6)), np.zeros((bodies, 6)), np.empty((bodies, 6))
    momentum = np.empty(6)
    for b in range(bodies):
        v, a = velocity[b], acceleration[b]
        if parent[b] < 0:
            a[3], a[4], a[5] = -gravity[0], -gravity[1], -gravity[2]
        else:
            v[:] = velocity[parent[b]]
            a[:] = acceleration[parent[b]]
        for d in range(first[b], first[b] + count[b]):
            s = screw[d]
            s[0], s[1], s[2] = axis[d, 0], axis[d, 1], axis[d, 2]
            s[3] = anchor[d, 1] * s[2] - anchor[d, 2] * s[1]
            s[4] = anchor[d, 2] * s[0] - anchor[d, 0] * s[2]
            s[5] = anchor[d, 0] * s[1] - anchor[d, 1] * s[0]
            q = ratio[d] * speed[driver[d]]
            # the axis itself is carried along: its rate of change is v x s
            a[0] += q * (v[1] * s[2] - v[2] * s[1])
            a[1] += q * (v[2] * s[0] - v[0] * s[2])
            a[2] += q * (v[0] * s[1] - v[1] * s[0])
            a[3] += q * (v[1] * s[5] - v[2] * s[4] + v[4] * s[2] - v[5] * s[1])
            a[4] += q * (v[2] * s[3] - v[0] * s[5] + v[5] * s[0] - v[3] * s[2])
            a[5] += q * (v[0] * s[4] - v[1] * s[3] + v[3] * s[1] - v[4] * s[0])
            for i in range(6):
                v[i] += q * s[i]
        apply_inertia(carried[b], a, force[b])
        apply_inertia(carried[b], v, momentum)
        f, h = force[b], momentum
        f[0] += v[1] * h[2] - v[2] * h[1] + v[4] * h[5] - v[5] * h[4]
        f[1] += v[2] * h[0] - v[0] * h[2] + v[5] * h[3] - v[3] * h[5]
        f[2] += v[0] * h[1] - v[1] * h[0] + v[3] * h[4] - v[4] * h[3]
        f[3] += v[1] * h[5] - v[2] * h[4]
        f[4] += v[2] * h[3] - v[0] * h[5]
        f[5] += v[0] * h[4] - v[1] * h[3]
    gather(parent, carried)
    gather(parent, force)
    for k in range(moving):
        bias[k] = 0.0
        mass[k, k] = 0.0
        for j in range(ancestor_start[k], ancestor_start[k + 1]):
            mass[k, ancestor[j]] = 0.0
    for b in range(bodies):
        for d in range(first[b], first[b] + count[b]):
            c = ratio[d]
            if c == 0.0:
                continue
            s, f, k = screw[d], force[b], driver[d]
            bias[k] += c * (s[0] * f[0] + s[1] * f[1] + s[2] * f[2] + s[3] * f[3] + s[4] * f[4] + s[5] * f[5])
            apply_inertia(carried[b], s, momentum)
            above, last = b, d
            while above >= 0:
                for e in range(last, first[above] - 1, -1):
                    t, j = screw[e], driver[e]
                    value = c * ratio[e] * (
                        t[0] * momentum[0] + t[1] * momentum[1] + t[2] * momentum[2] + t[3] * momentum[3] + t[4] * momentum[4] + t[5] * momentum[5]
                    )  # fmt: skip
                    if j == k and e != d:
                        value *= 2.0  # a follower and its driver: both halves of the matrix fall on the diagonal
                    mass[max(j, k), min(j, k)] += value
                above = parent[above]
                if above >= 0:
                    last = first[above] + count[above] - 1


@compiled
def factor(a: Array, ancestor_start: Index, ancestor: Index) -> None:
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
def solve(a: Array, ancestor_start: Index, ancestor: Index, x: Array) -> None:
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
    y: Array, speed: Array, dt: float, stop: Array, held: Flags, a: Array, ancestor_start: Index, ancestor: Index, column: Array
) -> None:
    """Impulses at the hard stops: what would pass one in this substep ends at it, and its neighbours feel that. ``column`` (k,) is used up."""
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
    for k in range(moving):
        if held[k]:
            speed[k] = 0.0
    for n in range(contraction.shape[0]):
        mass_and_bias(y, speed, gravity, m, mass, bias)
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
            if held[k]:
                continue
            y[k] += dt * speed[k]
            if y[k] < stop[k, 0]:
                y[k] = stop[k, 0]
                speed[k] = max(0.0, speed[k])
            elif y[k] > stop[k, 1]:
                y[k] = stop[k, 1]
                speed[k] = min(0.0, speed[k])
        path_y[n + 1] = y
        path_speed[n + 1] = speed
