"""What the compiled steps need of a hand: one record of arrays in moving coordinates y, with angle = C y + c0."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.physics.ligament import TAUT_AT
from handlab.physics.muscle import ACTIVE_CURVATURE, ACTIVE_PEAK, PASSIVE_CURVATURE
from handlab.physics.rotation import fibre_length
from handlab.simulation.kinematics import transforms, tree
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skeleton_kernel import dof_inertia

# Without a sign: compiled loops need not ask whether an index counts from the end.
Unsigned = NDArray[np.uint32]


class Mechanics(NamedTuple):
    """Arrays of body b, degree of freedom d, moving coordinate k, muscle m; SI units. Kernels take it as one argument.

    Joints: ``parent`` (b,), degrees of freedom ``first`` to ``first + dof_count - 1`` of each body, ``axis``, ``anchor`` (d, 3) and
    ``mass`` (b,), ``centre`` (b, 3), ``inertia`` (b, 3, 3) in the zero posture; ``driver``, ``ratio``, ``offset`` (d,) with
    angle[d] = ratio[d] y[driver[d]] + offset[d]; coordinates ``moving`` (k,) among the degrees of freedom.
    Muscles: ``arm`` (m, k) = R C, once more row by row without zeros: ``arm_value[arm_start[i]:arm_start[i + 1]]`` at ``arm_column``;
    ``length_at_zero`` (m,) the fibre length at y = 0; ``curves`` of ``physics.muscle``; they come as arguments because a compiled kernel
    on disk does not notice that a constant of another module has changed.
    Passive: springs about ``relaxed`` (k,); capsules with ``width``, ``time`` (k,), ``torque_at_limit`` (k, 2), nothing where the width
    is 0; ``hard_stop`` rad past ``limits`` (k, 2); ``tightened_by`` (k,) the flexion that tightens the collateral ligaments of a
    deviation, or -1.
    ``ancestor[ancestor_start[k]:ancestor_start[k + 1]]``: coordinates before k that move what k moves, last one first: where the mass
    matrix is not 0.
    """

    parent: Index
    first: Index
    dof_count: Index
    axis: Array
    anchor: Array
    mass: Array
    centre: Array
    inertia: Array
    driver: Unsigned
    ratio: Array
    offset: Array
    moving: Index
    ancestor_start: Unsigned
    ancestor: Unsigned
    arm: Array
    arm_start: Unsigned
    arm_column: Unsigned
    arm_value: Array
    length_at_zero: Array
    rest_length: Array
    max_force: Array
    curves: tuple[float, float, float]
    rest_y: Array
    relaxed: Array
    friction: Array
    stiffness: Array
    limits: Array
    width: Array
    torque_at_limit: Array
    time: Array
    hard_stop: float
    tightened_by: Index
    range_fraction: float
    stiffness_factor: float
    taut_at: float


@per_hand
def mechanics(hand: Hand) -> Mechanics:
    """The arrays of a hand. Followers of ``fibre_rest`` and ``relaxed`` take the angle that their driver gives them."""
    coupling = hand.coupling
    moving = frozen([hand.dof_names.index(name) for name in hand.moving_names], np.int64)
    driver = np.abs(coupling).argmax(axis=1)
    rest_y, arm, square = hand.fibre_rest[moving], hand.lever_arm @ coupling, coupling**2
    muscle, column = np.nonzero(arm)
    kept = tree(hand)
    turn, shift = kept.bind_inverse[:, :3, :3], kept.bind_inverse[:, :3, 3]
    bodies = hand.bodies.values()
    inertia = np.array([body.inertia for body in bodies])
    start, ancestor = ancestors(hand, driver, coupling)
    capsule = hand.capsule
    friction = np.broadcast_to(np.asarray(hand.friction, dtype=np.float64), len(coupling))
    return Mechanics(
        parent=kept.parent,
        first=kept.first,
        dof_count=kept.count,
        axis=kept.axis,
        anchor=kept.anchor,
        mass=frozen([body.mass for body in bodies]),
        centre=frozen(np.einsum("bij,bj->bi", turn, np.array([body.centre for body in bodies])) + shift),
        inertia=frozen(turn @ inertia @ np.transpose(turn, (0, 2, 1))),
        driver=frozen(driver, np.uint32),
        ratio=frozen(coupling[np.arange(len(coupling)), driver]),
        offset=hand.coupling_offset,
        moving=moving,
        ancestor_start=start,
        ancestor=ancestor,
        arm=frozen(arm),
        arm_start=frozen(np.searchsorted(muscle, np.arange(len(arm) + 1)), np.uint32),
        arm_column=frozen(column, np.uint32),
        arm_value=frozen(arm[muscle, column]),
        length_at_zero=frozen(hand.rest_length + arm @ rest_y),
        rest_length=hand.rest_length,
        max_force=hand.max_force,
        curves=(ACTIVE_PEAK, ACTIVE_CURVATURE, PASSIVE_CURVATURE),
        rest_y=frozen(rest_y),
        relaxed=frozen(hand.relaxed[moving]),
        friction=frozen(square.T @ friction),
        stiffness=frozen(square.T @ hand.stiffness),
        limits=frozen(moving_limits(hand)),
        width=frozen(np.zeros(len(moving)) if capsule is None else capsule.width[moving]),
        torque_at_limit=frozen(np.zeros((len(moving), 2)) if capsule is None else capsule.torque[moving]),
        time=frozen(np.zeros(len(moving)) if capsule is None else capsule.time[moving]),
        hard_stop=0.0 if capsule is None else capsule.hard_stop,
        tightened_by=tightened_by(hand),
        range_fraction=float(hand.collateral["range_fraction_at_90"]) if hand.collateral else 1.0,
        stiffness_factor=float(hand.collateral["stiffness_factor_at_90"]) if hand.collateral else 1.0,
        taut_at=TAUT_AT,
    )


def ancestors(hand: Hand, driver: Index, coupling: Array) -> tuple[Unsigned, Unsigned]:
    """Where the mass matrix is not 0 left of its diagonal, row by row from right to left.

    Two coordinates act on each other if one moves a body on the way from a body that the other moves to the forearm. Elimination from
    the last coordinate to the first fills nothing in (Featherstone 2008, section 6.5), if coordinates come after those they hang on.
    """
    bodies = list(hand.bodies)
    way: dict[str, set[int]] = {}
    column = {name: k for k, name in enumerate(hand.dof_names)}
    for name, body in hand.bodies.items():
        own = {int(driver[column[dof.name]]) for dof in (hand.joints[body.joint].dofs if body.joint else ())}
        way[name] = own | (way[body.parent] if body.parent else set())
    count = coupling.shape[1]
    acts = np.zeros((count, count), dtype=bool)
    for name in bodies:
        for k in way[name]:
            acts[k, list(way[name])] = True
    for k in range(count - 1, -1, -1):  # what elimination fills in where the coordinates do not form a tree
        before = np.flatnonzero(acts[k, :k])
        acts[np.ix_(before, before)] = True
    rows = [np.flatnonzero(acts[k, :k])[::-1] for k in range(count)]
    start = np.concatenate([[0], np.cumsum([len(row) for row in rows])])
    return frozen(start, np.uint32), frozen(np.concatenate(rows), np.uint32)


def moving_limits(hand: Hand) -> Array:
    """Limits (moving, 2): of the coordinate itself and of all that follow it, whichever is reached first."""
    limits = np.tile([-np.inf, np.inf], (len(hand.moving_names), 1))
    for row, (ratios, offset) in enumerate(zip(hand.coupling, hand.coupling_offset, strict=True)):
        k = int(np.argmax(np.abs(ratios)))
        if ratios[k] == 0.0:
            continue  # follows with ratio 0: never moves
        low, high = np.sort((hand.limits[row] - offset) / ratios[k])
        limits[k] = max(limits[k, 0], low), min(limits[k, 1], high)
    return limits


def tightened_by(hand: Hand) -> Index:
    """For each moving coordinate (k,) the flexion that tightens its collateral ligaments: of finger MCP deviations, else -1."""
    column = {name: k for k, name in enumerate(hand.moving_names)}
    found = np.full(len(column), -1)
    for name, k in column.items():
        joint, _, kind = name.partition(".")
        if hand.collateral and joint.startswith("mcp") and kind == "deviation":
            found[k] = column.get(f"{joint}.flexion_extension", -1)
    result: Index = frozen(found, np.int64)
    return result


def coupled(hand: Hand, y: ArrayLike) -> Array:
    """All angles (..., dof) of moving coordinates (..., moving): C y + c0."""
    result: Array = np.asarray(y, dtype=np.float64) @ hand.coupling.T + hand.coupling_offset
    return result


def fibre_lengths(hand: Hand, angle: ArrayLike) -> Array:
    """Fibre lengths (..., muscle) in metres at angles (..., dof): l0 - R (angle - fibre_rest)."""
    return fibre_length(hand.rest_length, hand.lever_arm, angle, coupled(hand, mechanics(hand).rest_y))


def moments_of_inertia(hand: Hand, angle: ArrayLike) -> Array:
    """J (dof,) in kg m^2: of all that each degree of freedom carries, about its axis, at ``angle`` (section 4.1.2)."""
    m = mechanics(hand)
    transform, axis, anchor = transforms(tree(hand), angle)
    bodies, out = np.empty((len(transform), 10)), np.empty(len(axis))
    dof_inertia(transform, axis, anchor, m, bodies, out)
    return out
