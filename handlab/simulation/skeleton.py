"""Muscles move bones: contraction -> force -> torque -> angle (section 4.1.1), in the moving coordinates y.

angle = C y + c0, torque_y = C' (R' F + passive), inertia C' J C with one moment of inertia J per degree of freedom.
Friction and joint stiffness are taken at the end of a substep (stable at any length), the muscles at its beginning.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import ceil, isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.anatomy.terms import find
from handlab.physics.ligament import TAUT_AT
from handlab.physics.muscle import ACTIVE_CURVATURE, ACTIVE_PEAK, PASSIVE_CURVATURE
from handlab.physics.rotation import fibre_length
from handlab.simulation.kinematics import body_transforms, tree
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skeleton_kernel import advance
from handlab.simulation.skin import blend
from handlab.simulation.state import State

# Explicit muscles would be stable even at 1/60 s, because friction and stiffness are implicit; accuracy asks for less than
# 1 ms. With half of this the angles of a smooth clip move by less than 0.1 degree. Every usual frame rate is a whole number of
# substeps: 24, 25, 30, 40, 50, 60, 100, 120.
SUBSTEP = 1.0 / 1200.0
# The moments of inertia change with the pose, little in 4 ms.
INERTIA_EVERY = 5

CURVES = (ACTIVE_PEAK, ACTIVE_CURVATURE, PASSIVE_CURVATURE)


@dataclass(frozen=True)
class Mechanics:
    """What a step needs of a hand, in moving coordinates k: see ``skeleton_kernel.advance`` for the shapes."""

    moving: Index
    arm: Array
    arm_transposed: Array
    length_at_zero: Array
    rest_length: Array
    max_force: Array
    friction: Array
    stiffness: Array
    rest_y: Array
    limits: Array
    collateral_deviation: Index
    collateral_flexion: Index
    range_fraction: float
    stiffness_factor: float
    coupling: Array
    offset: Array
    mass: Array
    centre: Array
    inertia: Array


@per_hand
def mechanics(hand: Hand) -> Mechanics:
    """The arrays of a hand. Followers of ``fibre_rest`` take the angle that their driver gives them."""
    coupling, offset = hand.coupling, hand.coupling_offset
    moving = frozen([hand.dof_names.index(name) for name in hand.moving_names], np.int64)
    rest_y = hand.fibre_rest[moving]
    arm = hand.lever_arm @ coupling
    square = coupling**2
    friction = np.broadcast_to(np.asarray(hand.friction, dtype=np.float64), len(coupling))
    deviation, flexion = collateral_pairs(hand)
    to_zero = tree(hand).bind_inverse
    turn, shift = to_zero[:, :3, :3], to_zero[:, :3, 3]
    bodies = hand.bodies.values()
    centre = np.array([body.centre for body in bodies])
    inertia = np.array([body.inertia for body in bodies])
    return Mechanics(
        moving=moving,
        arm=frozen(arm),
        arm_transposed=frozen(arm.T),
        length_at_zero=frozen(hand.rest_length + arm @ rest_y),
        rest_length=hand.rest_length,
        max_force=hand.max_force,
        friction=frozen(square.T @ friction),
        stiffness=frozen(square.T @ hand.stiffness),
        rest_y=frozen(rest_y),
        limits=frozen(moving_limits(hand)),
        collateral_deviation=deviation,
        collateral_flexion=flexion,
        range_fraction=float(hand.collateral["range_fraction_at_90"]) if hand.collateral else 1.0,
        stiffness_factor=float(hand.collateral["stiffness_factor_at_90"]) if hand.collateral else 1.0,
        coupling=coupling,
        offset=offset,
        mass=frozen([body.mass for body in bodies]),
        centre=frozen(np.einsum("bij,bj->bi", turn, centre) + shift),
        inertia=frozen(turn @ inertia @ np.transpose(turn, (0, 2, 1))),
    )


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


def collateral_pairs(hand: Hand) -> tuple[Index, Index]:
    """Moving coordinates (pair,) of finger MCP deviation, and of the flexion that tightens their ligaments."""
    column = {name: k for k, name in enumerate(hand.moving_names)}
    pairs = [
        (column[name], column[f"{joint}.flexion_extension"])
        for joint, name in ((name.partition(".")[0], name) for name in hand.moving_names)
        if joint.startswith("mcp") and name.endswith(".deviation") and f"{joint}.flexion_extension" in column
    ]
    if not hand.collateral:
        pairs = []
    table = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return frozen(table[:, 0], np.int64), frozen(table[:, 1], np.int64)


def contraction_of(hand: Hand, contraction: Mapping[str, float] | ArrayLike) -> Array:
    """Contraction values (muscle,) from a mapping by name or abbreviation, where a missing muscle is 0, or from an array.

    Raises ``ValueError`` for values outside [0, 1], and the error of an unknown name with the nearest three.
    """
    if isinstance(contraction, Mapping):
        values = np.zeros(len(hand.muscle_names))
        given: dict[str, str] = {}
        for name, value in contraction.items():
            full = hand.muscles[name].name
            if full in given:
                raise ValueError(f"{given[full]!r} and {name!r} are the same muscle, {full!r}; give it once")
            given[full] = name
            values[hand.muscle_names.index(full)] = number(value, f"contraction of {full!r}")
    else:
        values = np.array(contraction, dtype=np.float64)
        if values.shape != (len(hand.muscle_names),):
            raise ValueError(f"contraction has shape {values.shape}; give {len(hand.muscle_names)} values, or a mapping by muscle name")
    wrong = np.flatnonzero(~((values >= 0.0) & (values <= 1.0)))
    if len(wrong):
        name, value = hand.muscle_names[wrong[0]], values[wrong[0]]
        raise ValueError(f"contraction of {name!r} is {value:g}; contraction values lie between 0 and 1")
    return values


def number(value: object, what: str) -> float:
    """A float, or an error that says what was not a number."""
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise ValueError(f"{what} is {value!r}; give a number") from None


def held_coordinates(hand: Hand, hold: Iterable[str]) -> NDArray[np.bool_]:
    """Moving coordinates (moving,) that an examiner's hand holds: joints (``"wrist"``) or degrees of freedom by name.

    Holding a follower holds what it follows. An unknown name is answered with the nearest three.
    """
    names = (hold,) if isinstance(hold, str) else tuple(hold)
    held = np.zeros(len(hand.moving_names), dtype=bool)
    known = {**{name: [dof.name for dof in joint.dofs] for name, joint in hand.joints.items()}, **{name: [name] for name in hand.dof_names}}
    for name in names:
        for dof in known[find(name, known, kind="joint or degree of freedom")]:
            driver = hand.dofs[dof]
            while driver.driver is not None:
                driver = hand.dofs[driver.driver]
            held[hand.moving_names.index(driver.name)] = True
    return held


def integrate(hand: Hand, y: Array, speed: Array, contraction: Array, dt: float, held: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Moving coordinates and speeds (n + 1, moving) over n substeps of ``dt`` with ``contraction`` (n, muscle)."""
    m, t = mechanics(hand), tree(hand)
    path_y, path_speed = np.empty((len(contraction) + 1, len(y))), np.empty((len(contraction) + 1, len(y)))
    path_y[0], path_speed[0] = y, speed
    advance(
        path_y, path_speed, contraction, dt, INERTIA_EVERY,
        m.arm, m.arm_transposed, m.length_at_zero, m.rest_length, m.max_force, CURVES,
        m.friction, m.stiffness, m.rest_y, m.limits, held,
        m.collateral_deviation, m.collateral_flexion, m.range_fraction, m.stiffness_factor, TAUT_AT,
        m.coupling, m.offset, *t.arrays, m.mass, m.centre, m.inertia,
    )  # fmt: skip
    return path_y, path_speed


def coupled(hand: Hand, y: ArrayLike) -> Array:
    """All angles (..., dof) of moving coordinates (..., moving): C y + c0."""
    result: Array = np.asarray(y, dtype=np.float64) @ hand.coupling.T + hand.coupling_offset
    return result


def fibre_lengths(hand: Hand, angle: ArrayLike) -> Array:
    """Fibre lengths (..., muscle) in metres at angles (..., dof): l0 - R (angle - fibre_rest)."""
    return fibre_length(hand.rest_length, hand.lever_arm, angle, coupled(hand, mechanics(hand).rest_y))


def state_at(hand: Hand, y: Array, speed: Array, time: float) -> State:
    """The state of moving coordinates and their speeds (moving,)."""
    angle = coupled(hand, y)
    return State(
        time=time,
        angle=frozen(angle),
        speed=frozen(hand.coupling @ speed),
        fibre_length=frozen(fibre_lengths(hand, angle)),
        skin=blend(hand, angle),
    )


def rest(hand: Hand) -> State:
    """The relaxed hand: every fibre at its resting length, nothing moves."""
    y = mechanics(hand).rest_y
    return state_at(hand, y, np.zeros(len(y)), 0.0)


def pose(hand: Hand, angles: Mapping[str, float]) -> State:
    """A hand at rest with some angles (rad, by name of the degree of freedom) set; all others stay as in ``rest``.

    Followers take the angle that their driver gives them. Raises ``ValueError`` for a follower, or an angle outside its limits.
    """
    y = np.array(mechanics(hand).rest_y)
    limits = mechanics(hand).limits
    slack = 1e-9  # a limit that went through degrees and back is still the limit
    for name, value in angles.items():
        dof = hand.dofs[name]
        if dof.driver is not None:
            raise ValueError(f"{dof.name!r} follows {dof.driver!r}; set that one instead")
        k = hand.moving_names.index(dof.name)
        angle = number(value, f"angle of {dof.name!r}")
        low, high = limits[k]
        if not low - slack <= angle <= high + slack:
            degrees = f"{np.rad2deg(low):.0f} to {np.rad2deg(high):.0f} degrees"
            raise ValueError(f"angle of {dof.name!r} is {angle:g} rad; its limits are {low:.4f} to {high:.4f} rad ({degrees})")
        y[k] = min(max(angle, low), high)
    return state_at(hand, y, np.zeros(len(y)), 0.0)


def step(hand: Hand, state: State, contraction: Mapping[str, float] | ArrayLike, dt: float, *, hold: Iterable[str] = ()) -> State:
    """The state ``dt`` seconds later under constant contractions in [0, 1]; ``state`` itself does not change.

    ``contraction`` is a mapping by muscle name or abbreviation (missing muscles: 0) or an array (muscle,). Any ``dt`` is
    stable: it is cut into equal substeps of at most ``SUBSTEP``.
    """
    dt = number(dt, "dt")
    if not isfinite(dt) or dt <= 0.0:
        raise ValueError(f"dt is {dt:g}; give a positive number of seconds, such as 1/60")
    values = contraction_of(hand, contraction)
    if state.angle.shape != (len(hand.dof_names),):
        raise ValueError(f"the state has {state.angle.shape} angles, this hand {len(hand.dof_names)}; begin with rest(hand)")
    moving = mechanics(hand).moving
    substeps = ceil(dt / SUBSTEP - 1e-9)
    path_y, path_speed = integrate(
        hand, state.angle[moving], state.speed[moving], np.tile(values, (substeps, 1)), dt / substeps, held_coordinates(hand, hold)
    )
    return state_at(hand, path_y[-1], path_speed[-1], state.time + dt)


def moments_of_inertia(hand: Hand, angle: ArrayLike) -> Array:
    """J (dof,) in kg m^2: of all that each degree of freedom carries, about its axis, at ``angle`` (section 4.1.2)."""
    from handlab.simulation.kinematics import transforms
    from handlab.simulation.skeleton_kernel import dof_inertia

    m, t = mechanics(hand), tree(hand)
    transform, axis, anchor = transforms(t, angle)
    out = np.empty(len(axis))
    dof_inertia(transform, axis, anchor, t.parent, t.first, t.count, m.mass, m.centre, m.inertia, out)
    return out


def centres_of_mass(hand: Hand, angle: ArrayLike) -> Array:
    """Centres (body, 3) of the rigid bodies at ``angle``."""
    transform = body_transforms(hand, angle)
    result: Array = np.einsum("bij,bj->bi", transform[:, :3, :3], mechanics(hand).centre) + transform[:, :3, 3]
    return result
