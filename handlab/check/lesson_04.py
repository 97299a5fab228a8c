"""Checks of lesson 04, "Inertia of a chain". What is right is computed or measured on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.check.answers import number, one, reference
from handlab.check.lesson import Exercises
from handlab.check.own_lines import compare, values
from handlab.check.verdict import Wrong
from handlab.physics.inertia import composite_tensor, cylinder_about_end, from_points, rod_about_end
from handlab.physics.inertia_table import linear_entry, nearest_entry, three_levels
from handlab.physics.polyhedron import mass_properties, refined
from handlab.simulation.inertia_tables import fist, tensor_inertia, wrist_constant
from handlab.simulation.keyframes import keyframes
from handlab.simulation.kinematics import body_transforms, posed_axes
from handlab.simulation.laws import Laws
from handlab.simulation.mechanics import mechanics
from handlab.simulation.play import simulate
from handlab.simulation.skeleton import centres_of_mass

EXERCISES = Exercises("04")

# The phalanges of an index finger as rods: the worked example of the lesson.
MASS = np.array([0.01192, 0.00556, 0.00304])
LENGTH = np.array([0.04259, 0.02514, 0.01798])
RADIUS = np.array([0.009, 0.008, 0.007])
BONE, BODY, AXIS = "middle_phalanx_2", "middle_phalanx_2", "pip2.flexion_extension"
BENDS_DEG = ((0.0, 0.0), (45.0, 30.0), (90.0, 60.0), (20.0, 70.0))
TABLE_DIP_DEG, TABLE_STEP_DEG, TABLE_TO_DEG = 30.0, 5.0, 110.0
CLIP = "wave"  # of the named clips the one whose joints move fastest
FINGER = ("proximal_phalanx_2", "middle_phalanx_2", "distal_phalanx_2")
LEFT_OUT_OF = "mcp2.flexion_extension"


@EXERCISES.register("bone")
def bone(rod: Callable[..., Any], cylinder: Callable[..., Any]) -> str:
    """Two functions: rod(mass, length) and cylinder(mass, length, radius), each about its end."""
    m, length, radius = MASS[1], LENGTH[1], RADIUS[1]
    right = rod_about_end(m, length)
    slips = {
        "That is the rod about its middle. A joint is at its end.": right / 4.0,
        "The length is squared.": right / length,
        "That is a point at the far end. The mass is spread along the rod: one third.": 3.0 * right,
    }
    compare(values(rod, m, length), right, slips, "rod")
    both = cylinder_about_end(m, length, radius)
    slips = {
        "That is the rod again. The thickness is missing.": right,
        "m r^2 / 2 belongs to a turn about the cylinder's own axis. Across it, it is a quarter.": right + m * radius**2 / 2.0,
        "m r^2 / 4 comes on top, with a plus.": right - m * radius**2 / 4.0,
    }
    compare(values(cylinder, m, length, radius), both, slips, "cylinder")
    return "Both agree with the package. The paper says cylinder and prints the rod."


@EXERCISES.register("thickness")
def thickness(percent: Any) -> str:
    """By how many percent the cylinder exceeds the rod: three numbers."""
    right = 100.0 * (cylinder_about_end(MASS, LENGTH, RADIUS) / rod_about_end(MASS, LENGTH) - 1.0)
    theirs = np.asarray(percent, dtype=np.float64)
    if theirs.shape != right.shape:
        raise Wrong("Give three numbers, one for each phalanx.")
    if np.allclose(100.0 * theirs, right, rtol=0.02):
        raise Wrong("These are fractions. Give percent.")
    if np.allclose(theirs, right + 100.0, rtol=0.02):
        raise Wrong("These are cylinder / rod in percent. How much MORE is it?")
    if not np.allclose(theirs, right, atol=0.1):
        raise Wrong(f"The middle phalanx comes out at {theirs[1]:.2f} %. Divide the difference by the rod's moment.")
    return f"The shorter the bone, the more its thickness counts: {right[0]:.1f}, {right[1]:.1f} and {right[2]:.1f} %."


@cache
def three_ways(refinements: int) -> tuple[float, float, float]:
    """J* of the bone of the exercise: literal, mass / N, exact; of its mesh refined so many times."""
    hand = reference()
    points, faces = hand.bones[BONE].points, hand.bones[BONE].faces
    for _ in range(refinements):
        points, faces = refined(points, faces)
    axes, anchors = posed_axes(hand, hand.bind)
    d, mass = hand.dof_names.index(AXIS), hand.bodies[BODY].mass
    solid = mass_properties(points, faces, mass=mass)
    exact = axes[d] @ solid.inertia @ axes[d] + mass * np.sum(np.cross(solid.centre - anchors[d], axes[d]) ** 2)
    sums = [from_points(mass, points, axes[d], anchors[d], literal=literal) for literal in (True, False)]
    return sums[0], sums[1], float(exact)


@EXERCISES.register("vertices")
def vertices(literal: Any, shared: Any, exact: Any) -> str:
    """By which factor each of the three sums changes when every triangle is cut into four."""
    before, after = three_ways(0), three_ways(1)
    names = ("literal", "mass / N", "exact")
    for name, answer, old, new in zip(names, (literal, shared, exact), before, after, strict=True):
        value = number(answer, f"The factor of {name!r}", "new / old")
        if abs(value - new / old) > 0.002 * new / old:
            if abs(value - old / new) < 0.002 * old / new:
                raise Wrong(f"{name}: that is old / new. Divide the other way round.")
            raise Wrong(f"{name}: the factor is not {value:.4g}. Put the fine mesh into the same function.")
    return (
        f"The literal sum is {after[0] / before[0]:.2f} times as large: it counts vertices. With mass / N it stays near, but it is "
        f"{before[1] / before[2] - 1.0:+.0%} off: a surface has no inside. The integral does not care about the mesh."
    )


@EXERCISES.register("chain")
def chain(own: Callable[..., Any]) -> str:
    """A function of mass (3,), length (3,), PIP and DIP angle that gives J of three rods about the first joint."""
    for alpha, beta in np.deg2rad(BENDS_DEG):
        right = three_levels(tuple(MASS), tuple(LENGTH), alpha, beta)
        ends = np.cumsum(LENGTH * np.exp(1j * np.array([0.0, alpha, alpha + beta])))
        apart = np.sum(rod_about_end(MASS, LENGTH))
        middles = ends - 0.5 * LENGTH * np.exp(1j * np.array([0.0, alpha, alpha + beta]))
        unbent = three_levels(tuple(MASS), tuple(LENGTH), alpha, beta - alpha)
        slips = {
            "That is every rod about its own end. The middle one is far away from the MCP joint: where is its middle?": np.asarray(apart),
            "The own moment of each rod about its middle, m l^2 / 12, is missing.": np.asarray(np.sum(MASS * np.abs(middles) ** 2)),
            "The distal phalanx points along alpha + beta: it is bent against the middle one, not against the first.": unbent,
            "Use the middles of the rods, not their ends.": np.asarray(np.sum(MASS * (LENGTH**2 / 12.0 + np.abs(ends) ** 2))),
            "About the middle a rod has m l^2 / 12; one third is for its end.": np.asarray(apart + np.sum(MASS * np.abs(middles) ** 2)),
        }
        compare(values(own, MASS, LENGTH, alpha, beta), right, slips, "J")
    return "Your chain and the package agree in four postures: a straight finger has nearly twice the moment of a hooked one."


@EXERCISES.register("hook", guess=True)
def hook(times: Any) -> str:
    """A guess: by which factor the moment of a straight finger exceeds that of a hooked one."""
    if number(times, "Your guess", "times") <= 0.0:
        raise Wrong("A factor is positive: 1 would mean no change.")
    return "Now bend the finger below, and look."


def table_worst() -> tuple[float, float]:
    """Largest errors (nearest, linear) in percent of the table of the exercise."""
    grid = np.deg2rad(np.arange(0.0, TABLE_TO_DEG + 1.0, TABLE_STEP_DEG))
    fine = np.linspace(0.0, grid[-1], 11001)
    beta = np.deg2rad(TABLE_DIP_DEG)
    table, exact = (three_levels(tuple(MASS), tuple(LENGTH), alpha, beta) for alpha in (grid, fine))
    step = float(grid[1])
    found = [read(table, [0.0], step, fine[:, None]) for read in (nearest_entry, linear_entry)]
    nearest, linear = (100.0 * float(np.abs(values / exact - 1.0).max()) for values in found)
    return nearest, linear


@EXERCISES.register("table")
def table(nearest: Any, linear: Any) -> str:
    """The largest error of both ways to read the table, percent."""
    right = table_worst()
    given = number(nearest, "The error of the nearest entry", "percent"), number(linear, "The error of the line", "percent")
    if all(abs(a - b) < 0.1 * b for a, b in zip(given, right[::-1], strict=True)):
        raise Wrong("The other way round: first the nearest entry, then the line.")
    for name, value, should in zip(("nearest", "linear"), given, right, strict=True):
        if abs(100.0 * value - should) < 0.1 * should:
            raise Wrong(f"{name}: {value:.3g} is a fraction. Give percent.")
        if name == "nearest" and abs(value - 2.0 * should) < 0.2 * should:
            raise Wrong("nearest: twice as much as it should be. np.floor takes the entry below; round to the nearest one.")
        if abs(value - should) > 0.1 * should:
            raise Wrong(f"{name}: the largest error is not {value:.3g} %. Take the largest |table / exact - 1| over all fine angles.")
    gain = right[0] / right[1]
    return f"{right[0]:.1f} % and {right[1]:.3f} %: a line between entries costs one multiplication and gains a factor of {gain:.0f}."


def finger_bodies(posture: int) -> tuple[Array, Array, Array, Array, Array]:
    """Mass (3,), centre (3, 3), own tensor (3, 3, 3), rotation (3, 3, 3) and a point (3,) of the index finger in a random posture."""
    hand, m = reference(), mechanics(reference())
    y = np.random.default_rng(posture).uniform(*m.limits.T)
    angle = hand.coupling @ y + hand.coupling_offset
    rows = [hand.body_names.index(name) for name in FINGER]
    about = posed_axes(hand, angle)[1][hand.dof_names.index(LEFT_OUT_OF)]
    return m.mass[rows], centres_of_mass(hand, angle)[rows], m.inertia[rows], body_transforms(hand, angle)[rows, :3, :3], about


@EXERCISES.register("tensor")
def tensor(own: Callable[..., Any]) -> str:
    """A function of mass, centre, inertia, rotation and about that gives the composite tensor (3, 3)."""
    for posture in (4, 5):
        mass, centre, inertia, turn, about = finger_bodies(posture)
        right = composite_tensor(mass, centre, inertia, about, rotation=turn)
        back = np.swapaxes(turn, 1, 2)
        away = centre - about
        square = np.einsum("b,bi,bj->ij", mass, away, away)
        spread = np.sum(mass * np.sum(away**2, axis=1)) * np.eye(3)
        turned = (turn @ inertia @ back).sum(axis=0)
        slips = {
            "The tensors are still in the frames of the bones: turn them, R I R'.": composite_tensor(mass, centre, inertia, about),
            "Turned the wrong way round: it is R I R', and you have R' I R.": composite_tensor(mass, centre, inertia, about, rotation=back),
            "The parallel axis theorem is missing: every body turns about the joint, not about its own centre.": turned,
            "Only the far-away part is there. Add each body's own tensor.": spread - square,
            "The parallel axis theorem has two parts: m (|d|^2 1 - d d'). The second is missing.": turned + spread,
            "The parallel axis theorem has two parts: m (|d|^2 1 - d d'). The first is missing.": turned - square,
            "Distances count from the joint: centre - about.": composite_tensor(mass, centre, inertia, np.zeros(3), rotation=turn),
        }
        compare(values(own, mass, centre, inertia, turn, about), right, slips, "The tensor")
    return "Your tensor serves every axis through the joint at once, in any posture. No table does."


@EXERCISES.register("left_out")
def left_out(dof: Any) -> str:
    """The rotation that changes the moment of MCP flexion although the tables do not know it."""
    hand, m = reference(), mechanics(reference())
    answer = one(dof, hand.dofs, "degree of freedom")
    k = hand.moving_names.index(LEFT_OUT_OF)
    if answer == LEFT_OUT_OF:
        raise Wrong("A joint's own angle turns the axis and all it carries together: nothing changes between them.")
    if answer not in hand.moving_names:
        raise Wrong(f"{answer} follows another rotation. Look for one that moves by itself.")
    column = hand.moving_names.index(answer)
    if answer.startswith(("pip2", "dip2")):
        raise Wrong(f"{answer} changes it most, but the tables know it: they were made for it.")
    ends = []
    for limit in m.limits[column]:
        y = np.array(m.relaxed)
        y[column] = limit
        ends.append(tensor_inertia(hand, y)[k])
    straight = tensor_inertia(hand, m.relaxed)[k]
    less = 1.0 - min(ends) / straight
    if less < 1e-3:
        raise Wrong(f"{answer} changes nothing at {LEFT_OUT_OF}: the index finger beyond the knuckle keeps its shape.")
    return f"Spread to its limit, the finger has {less:.1%} less moment about the flexion axis: what leans towards an axis turns easily."


@EXERCISES.register("wrist")
def wrist(percent: Any) -> str:
    """How much too large the constant is in the fist, percent, about the flexion axis."""
    hand = reference()
    k = hand.moving_names.index("wrist.flexion_extension")
    true, constant = float(tensor_inertia(hand, fist(hand))[k]), float(wrist_constant(hand, "relaxed")[0])
    value, right = number(percent, "The error", "percent"), 100.0 * (constant / true - 1.0)
    if abs(value - 100.0 * (1.0 - true / constant)) < 0.5 or abs(value - 100.0 * (true / constant - 1.0)) < 0.5:
        raise Wrong("An error is measured in parts of the true value. Divide by the fist's moment, not by the constant.")
    if abs(100.0 * value - right) < 0.5:
        raise Wrong("That is a fraction. Give percent.")
    if abs(value - right) > 0.5:
        raise Wrong(f"{value:.1f} % is not what a fresh hand gives. Compare constant / true - 1 in the fist, about the flexion axis.")
    return f"{right:.0f} %: for a fist the constant is far too sluggish. No finer table would mend it."


@EXERCISES.register("guess", guess=True)
def guess(degrees: Any) -> str:
    """A guess in degrees."""
    if number(degrees, "Your guess", "degrees") < 0.0:
        raise Wrong("A difference in degrees is not negative.")
    return "Now let the hand move."


def heavier(hand: Hand, factor: float) -> Hand:
    """Another hand with ``factor`` times the mass."""
    return hand.with_(
        bodies={name: replace(body, mass=factor * body.mass, inertia=factor * body.inertia) for name, body in hand.bodies.items()}
    )


def moved(hand: Hand, inertia: str) -> Array:
    """Angles (T, dof) in degrees of the clip of the exercise, decoupled."""
    return np.rad2deg(simulate(hand, keyframes(CLIP), laws=Laws(dynamics="decoupled", inertia=inertia)).angle)


@cache
def apart(divided_by: float) -> float:
    """Largest difference in degrees between tables (nearest) and tensors, with the friction divided."""
    hand = reference().with_(friction=np.asarray(reference().friction) / divided_by)
    return float(np.abs(moved(hand, "nearest table") - moved(hand, "tensor")).max())


@EXERCISES.register("motion")
def motion(by_table: Any, by_mass: Any) -> str:
    """Largest differences in degrees: tables against tensors, twice the mass against once."""
    right = apart(1.0), float(np.abs(moved(heavier(reference(), 2.0), "tensor") - moved(reference(), "tensor")).max())
    given = number(by_table, "The difference of the tables", "degrees"), number(by_mass, "The difference of the masses", "degrees")
    for name, value, should in zip(("tables", "masses"), given, right, strict=True):
        if abs(np.rad2deg(value) - should) < 0.02 * should:
            raise Wrong(f"{name}: that is in radians. Give degrees.")
        if abs(value - should) > 0.02 * should + 1e-4:
            raise Wrong(f"{name}: {value:.4g} degrees is not what fresh hands do. Take the largest |difference| of all angles.")
    verdict = "No table changes the motion by one degree" if right[0] < 1.0 else "The tables do change the motion by a degree"
    return f"{verdict}: {right[0]:.3f} degrees. Even twice the mass changes it by {right[1]:.2f} degrees only."


@EXERCISES.register("friction")
def friction(divisor: Any) -> str:
    """By what the friction must be divided until the tables change the motion by one degree."""
    value = number(divisor, "The divisor", "times")
    if value < 1.0:
        raise Wrong("Divide the friction by a number above 1: less friction, not more.")
    if value > 1e4:
        raise Wrong("That leaves hardly any friction at all. It takes less.")
    found = apart(value)
    if not 0.8 < found < 1.25:
        more = "more" if found < 1.0 else "less"
        raise Wrong(f"With friction / {value:g} the difference is {found:.2f} degrees. Divide by {more}.")
    return f"Friction / {value:g}: {found:.2f} degrees. Inertia hardly matters as long as friction wins, and in a finger it wins."
