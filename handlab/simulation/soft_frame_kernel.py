"""Compiled frame of the skin: columns of tissue swell, springs pull, limits hold. In one piece, because every call from Python waits for
the interpreter, which another thread uses at the same time."""

from __future__ import annotations

import math

import numpy as np

from handlab.physics.compiled import compiled
from handlab.simulation.soft_anchor_kernel import swollen
from handlab.simulation.soft_hold_kernel import limited
from handlab.simulation.soft_look_kernel import Array, Index, Node, Value
from handlab.simulation.soft_skin_kernel import framed, leapfrog, volume_and_area


@compiled
def pulled(
    position: Array, velocity: Array, push: Array, normal: Array, before: Array, centre: Array, arm: Array, stretch: Array,
    depth: Array, swelling: float, low: float, high: float, reach: float, share: float,
    first: Node, second: Node, stiffness: Array, rest: Array, slack: float, hold: Array, inverse_mass: Array,
    dt: float, steps: int, damping: float, yielding: float,
    transform: Array, corner: Node, body: Node, clearance: Array, group: Index, near: Value,
    floor: Value, value: Value, start: Index, size: Index, origin: Array, spacing: float,
    longest: Array, most: float, faces: Node, fan_start: Node, fan: Node, plane: Array, least: float,
    passes: int, rounds: int, bone_rounds: int,
) -> tuple[int, float]:  # fmt: skip
    """``position``, ``velocity``, ``push`` (3, n) of a skin ``dt`` seconds later, in place; ``normal`` (3, n) receives its normals.

    Returns how many triangles stay inverted, and the volume in m^3. ``before``: centres at the beginning; ``centre``, ``arm``, ``stretch``
    those of the end before they swell, in place; what limits moved in earlier frames, columns of tissue keep (springs that pulled back
    into the limits in every frame would flicker), and give back at the rate ``yielding`` 1/s. Other arguments as in the kernels called.
    """
    swollen(centre, arm, stretch, depth, swelling, low, high, reach)
    centre += push
    block, force = np.empty((10, position.shape[1])), np.empty_like(position)
    framed(before, centre, arm, share, block)
    leapfrog(position, velocity, force, first, second, stiffness, rest, slack, block, hold, inverse_mass, dt / steps, steps, damping)
    free = position.copy()
    faults = limited(
        position, transform, corner, body, clearance, group, near, floor, value, start, size, origin, spacing,
        first, second, longest, most, faces, fan_start, fan, plane, least, passes, rounds, bone_rounds,
    )  # fmt: skip
    push *= math.exp(-yielding * dt)
    push += position - free
    return faults, volume_and_area(position, faces, normal)
