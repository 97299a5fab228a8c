"""The paper's step, compiled: every rotation on its own with a scalar moment of inertia J (section 4.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled
from handlab.simulation.inertia_kernel import look_up
from handlab.simulation.skeleton_kernel import dof_inertia, pose
from handlab.simulation.torque_kernel import muscle_torque, passive_torque

if TYPE_CHECKING:
    from handlab.simulation.inertia_tables import InertiaTables
    from handlab.simulation.mechanics import Mechanics

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

IMPLICIT, EXPLICIT, PRINTED = 0, 1, 2  # friction
TENSOR, TABLE, NEAREST = 0, 1, 2  # inertia


@compiled
def advance_decoupled(
    path_y: Array, path_speed: Array, contraction: Array, dt: float, m: Mechanics, tables: InertiaTables, gravity: Array,
    held: Flags, pushing: bool, friction: int, source: int, refresh: int,
) -> None:  # fmt: skip
    """March n substeps of ``dt`` from ``path_y[0]``, ``path_speed[0]`` (k,); fill rows 1 to n of both (n + 1, k).

    ``contraction`` (n, m) holds over each substep; ``gravity`` (3,). Inertia from the pose and gravity's torque are renewed
    every ``refresh`` substeps, inertia from ``tables`` every time. Friction and slopes at the end of the step (IMPLICIT), friction at
    its beginning (EXPLICIT), or against the muscle's torque (PRINTED, (2')).
    """
    parent, first, count, driver, ratio, offset = m.parent, m.first, m.dof_count, m.driver, m.ratio, m.offset
    moving, dofs, bodies = path_y.shape[1], ratio.shape[0], parent.shape[0]
    y, speed = path_y[0].copy(), path_speed[0].copy()
    angle, inertia_dof, inertia = np.empty(dofs), np.empty(dofs), np.empty(moving)
    transform, axis, anchor = np.empty((bodies, 4, 4)), np.empty((dofs, 3)), np.empty((dofs, 3))
    carried, weight = np.empty((bodies, 10)), np.zeros(moving)
    torque, slope, drag, stop = np.empty(moving), np.empty(moving), np.empty(moving), np.empty((moving, 2))
    heavy = gravity[0] != 0.0 or gravity[1] != 0.0 or gravity[2] != 0.0
    for n in range(contraction.shape[0]):
        if n % refresh == 0 and (source == TENSOR or heavy):
            for d in range(dofs):
                angle[d] = offset[d] + ratio[d] * y[driver[d]]
            pose(angle, parent, first, count, m.axis, m.anchor, transform, axis, anchor)
            dof_inertia(transform, axis, anchor, m, carried, inertia_dof)
            for k in range(moving):
                inertia[k] = 0.0
                weight[k] = 0.0
            for b in range(bodies):
                for d in range(first[b], first[b] + count[b]):
                    k = driver[d]
                    inertia[k] += ratio[d] * ratio[d] * inertia_dof[d]
                    # a . ((centre - anchor) x m g) of all that it carries
                    mass = carried[b, 0]
                    x, z, w = carried[b, 1] - mass * anchor[d, 0], carried[b, 2] - mass * anchor[d, 1], carried[b, 3] - mass * anchor[d, 2]
                    weight[k] += ratio[d] * (
                        axis[d, 0] * (z * gravity[2] - w * gravity[1])
                        + axis[d, 1] * (w * gravity[0] - x * gravity[2])
                        + axis[d, 2] * (x * gravity[1] - z * gravity[0])
                    )
        if source != TENSOR:
            look_up(tables, y, source == NEAREST, inertia)
        for k in range(moving):
            torque[k] = weight[k]
        muscle_torque(y, contraction[n], m, pushing, torque)
        passive_torque(y, m, torque, slope, drag, stop)
        for k in range(moving):
            if held[k]:
                speed[k] = 0.0
            else:
                if friction == IMPLICIT:
                    speed[k] = (inertia[k] * speed[k] + dt * torque[k]) / (inertia[k] + dt * (drag[k] + dt * slope[k]))
                elif friction == EXPLICIT:
                    speed[k] += dt / inertia[k] * (torque[k] - drag[k] * speed[k])
                else:
                    left = abs(torque[k]) - drag[k] * abs(speed[k])
                    speed[k] += dt / inertia[k] * (left if torque[k] > 0.0 else (-left if torque[k] < 0.0 else 0.0))
                y[k] += dt * speed[k]
                if y[k] < stop[k, 0]:
                    y[k] = stop[k, 0]
                    speed[k] = max(0.0, speed[k])
                elif y[k] > stop[k, 1]:
                    y[k] = stop[k, 1]
                    speed[k] = min(0.0, speed[k])
            path_y[n + 1, k] = y[k]
            path_speed[n + 1, k] = speed[k]
