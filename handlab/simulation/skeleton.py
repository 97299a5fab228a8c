"""Muscles move bones: contraction -> force -> torque -> angle (section 4.1), in the moving coordinates y.

angle = C y + c0, torque_y = C' (R' F) + passive. ``coupled``: M y'' + h = torque with the full mass matrix; ``decoupled``: J y'' = torque
for every coordinate on its own, as in the paper. ``laws.Laws`` says which.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import ceil, isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand, frozen
from handlab.anatomy.terms import find
from handlab.simulation.coupled_kernel import advance_coupled
from handlab.simulation.decoupled_kernel import advance_decoupled
from handlab.simulation.inertia_tables import inertia_tables
from handlab.simulation.kinematics import body_transforms
from handlab.simulation.laws import FRICTION, INERTIA, SOUND, Laws
from handlab.simulation.mechanics import coupled, fibre_lengths, mechanics
from handlab.simulation.skin import blend
from handlab.simulation.state import State

# In ``decoupled`` the moments of inertia are taken from the pose every 4 ms, in which they change little.
INERTIA_EVERY = 5


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
    if not (values.min() >= 0.0 and values.max() <= 1.0):
        wrong = np.flatnonzero(~((values >= 0.0) & (values <= 1.0)))
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


def integrate(
    hand: Hand, y: Array, speed: Array, contraction: Array, dt: float, held: NDArray[np.bool_], laws: Laws = SOUND
) -> tuple[Array, Array]:
    """Moving coordinates and speeds (n + 1, moving) over n substeps of ``dt`` with ``contraction`` (n, muscle)."""
    m, gravity, pushing = mechanics(hand), np.array(laws.gravity), laws.force == "printed"
    path_y, path_speed = np.empty((len(contraction) + 1, len(y))), np.empty((len(contraction) + 1, len(y)))
    path_y[0], path_speed[0] = y, speed
    if laws.dynamics == "coupled":
        advance_coupled(path_y, path_speed, contraction, dt, m, gravity, held, pushing)
    else:
        friction, source = FRICTION.index(laws.friction), INERTIA.index(laws.inertia)
        tables = inertia_tables(hand)
        advance_decoupled(path_y, path_speed, contraction, dt, m, tables, gravity, held, pushing, friction, source, INERTIA_EVERY)
    return path_y, path_speed


def substeps_of(seconds: float, laws: Laws) -> int:
    """How many equal substeps, none longer than ``laws.substep``, make ``seconds``."""
    return max(1, ceil(seconds / laws.substep - 1e-6))


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
    """The relaxed hand, ``hand.relaxed``: where its joints' springs are slack; nothing moves.

    Fibres have their rest length there, unless ``hand.fibre_rest`` is another posture.
    """
    y = mechanics(hand).relaxed
    return state_at(hand, y, np.zeros(len(y)), 0.0)


def pose(hand: Hand, angles: Mapping[str, float]) -> State:
    """A hand at rest with some angles (rad, by name of the degree of freedom) set; all others stay as in ``rest``.

    Followers take the angle that their driver gives them. Raises ``ValueError`` for a follower, or an angle further outside its limits than
    the capsule gives (2 degrees).
    """
    y, stop = np.array(mechanics(hand).relaxed), mechanics(hand).hard_stop
    limits = mechanics(hand).limits
    slack = 1e-9  # a limit that went through degrees and back is still the limit
    for name, value in angles.items():
        dof = hand.dofs[name]
        if dof.driver is not None:
            raise ValueError(f"{dof.name!r} follows {dof.driver!r}; set that one instead")
        k = hand.moving_names.index(dof.name)
        angle = number(value, f"angle of {dof.name!r}")
        low, high = limits[k]
        if not low - stop - slack <= angle <= high + stop + slack:
            degrees = f"{np.rad2deg(low):.0f} to {np.rad2deg(high):.0f} degrees"
            raise ValueError(f"angle of {dof.name!r} is {angle:g} rad; its limits are {low:.4f} to {high:.4f} rad ({degrees})")
        y[k] = min(max(angle, low - stop), high + stop)
    return state_at(hand, y, np.zeros(len(y)), 0.0)


def step(
    hand: Hand,
    state: State,
    contraction: Mapping[str, float] | ArrayLike,
    dt: float,
    *,
    hold: Iterable[str] = (),
    laws: Laws = SOUND,
) -> State:
    """The state ``dt`` seconds later under constant contractions in [0, 1]; ``state`` itself does not change.

    ``contraction`` is a mapping by muscle name or abbreviation (missing muscles: 0) or an array (muscle,). Any ``dt`` is
    stable under the sound laws: it is cut into equal substeps of at most ``laws.substep``.
    """
    dt = number(dt, "dt")
    if not isfinite(dt) or dt <= 0.0:
        raise ValueError(f"dt is {dt:g}; give a positive number of seconds, such as 1/60")
    values = contraction_of(hand, contraction)
    if state.angle.shape != (len(hand.dof_names),):
        raise ValueError(f"the state has {state.angle.shape} angles, this hand {len(hand.dof_names)}; begin with rest(hand)")
    moving = mechanics(hand).moving
    substeps = substeps_of(dt, laws)
    path_y, path_speed = integrate(
        hand, state.angle[moving], state.speed[moving], np.tile(values, (substeps, 1)), dt / substeps, held_coordinates(hand, hold), laws
    )
    return state_at(hand, path_y[-1], path_speed[-1], state.time + dt)


def centres_of_mass(hand: Hand, angle: ArrayLike) -> Array:
    """Centres (body, 3) of the rigid bodies at ``angle``."""
    transform = body_transforms(hand, angle)
    result: Array = np.einsum("bij,bj->bi", transform[:, :3, :3], mechanics(hand).centre) + transform[:, :3, 3]
    return result
