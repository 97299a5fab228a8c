"""Checks of lesson 07, "Springs and the stable step". What is right is computed on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from handlab.check.answers import number, one, said
from handlab.check.lesson import Exercises
from handlab.check.own_lines import compare, values
from handlab.check.spring_nets import MASS, STIFFNESS, fewest, network, row_limit_ms, saving, single_limit_ms, stiff_alone
from handlab.check.verdict import Open, Wrong, is_open
from handlab.physics.springs import leapfrog, spring_force
from handlab.simulation.hairy_skin import TISSUE
from handlab.simulation.soft_skin import YOUNG
from handlab.studies import shaking

EXERCISES = Exercises("07")

ROW = 40
PROBES = (  # node, other, k, rest length
    (np.array([0.0, 0.0, 0.0]), np.array([0.003, 0.004, 0.0]), 2.0, 0.004),
    (np.array([0.01, -0.02, 0.005]), np.array([0.012, -0.02, 0.006]), 10.0, 0.005),
)
LEAPS = ((0.001, 0.02, 1e-3), (0.0002, -0.05, 5e-3))  # x, v, dt
PREDICTED = 0.005  # an answer that is computed may be off by this part
DOUBLE, SOFT, STIFF = 2.0, 5e3, 140e6  # times, Pa, Pa
MOST_HEAVIER, SAVED = 5, 0.02  # nodes, part of the steps
WORDS = ("together", "against")


@EXERCISES.register("guess", guess=True)
def guess(steps: Any) -> str:
    """Any number of steps."""
    number(steps, "The guess", "steps")
    return "You will compute it below."


@EXERCISES.register("force")
def force(own: Callable[..., Any]) -> str:
    """A function (node, other, k, rest) that returns the force on node (3,)."""
    for node, other, k, rest in PROBES:
        way = other - node
        length = float(np.linalg.norm(way))
        right = spring_force(node, other, k, rest)
        slips = {
            "The force points away. A stretched spring pulls its mass towards the other end.": -right,
            "That is k times the whole length. A spring at its rest length pulls nothing.": k * way,
            "The direction is missing its length: divide the way by its length, so that it only points.": k * (length - rest) * way,
        }
        theirs = values(own, node.copy(), other.copy(), k, rest)
        if theirs.shape == ():
            raise Wrong("That is one number. A force has a direction: hand back an array of three numbers.")
        compare(theirs, right, slips, "The force", "N")
    return "Your lines and the package agree to nine digits."


def pull(x: Any) -> Any:
    """Acceleration of the single mass."""
    return -STIFFNESS * x / MASS


@EXERCISES.register("leap")
def leap(own: Callable[..., Any]) -> str:
    """A function (x, v, acceleration, dt) that returns the new place and the new velocity."""
    if not callable(own):
        raise Wrong("Hand over the function itself, without brackets.")
    for x, v, dt in LEAPS:
        answer = own(x, v, pull, dt)
        if answer is None or is_open(answer):
            raise Open
        given = np.asarray(answer, dtype=np.float64).ravel()
        if given.shape != (2,):
            raise Wrong("Hand back two things: the new place, then the new velocity.")
        place, velocity = (float(part) for part in leapfrog(x, v, pull, dt))
        slips = {
            "The place is moved with the old velocity. The leapfrog takes the new one.": np.array([x + dt * v, velocity]),
            "The velocity came first. Hand back the place, then the velocity.": np.array([velocity, place]),
            "The acceleration is taken at the new place. It belongs to the old one.": np.array([x + dt * v, v + dt * pull(x + dt * v)]),
            "The change of velocity came back instead of the velocity: add the old one.": np.array([x + dt * (velocity - v), velocity - v]),
        }
        compare(given, np.array([place, velocity]), slips, "The place", "m")
    return "Your lines and the package agree to nine digits."


@EXERCISES.register("limit")
def limit(longest_ms: Any, stiffer_ms: Any) -> str:
    """The longest step of one mass (tried), and with a spring twice as stiff (predicted), milliseconds."""
    right, stiffer = single_limit_ms(), single_limit_ms(DOUBLE * STIFFNESS)
    said(
        right,
        {
            "this is in seconds. Give milliseconds.": right / 1e3,
            "that is 1/omega; the mass holds out twice as long.": right / 2.0,
            "that is the time of a whole swing, 2 pi/omega.": np.pi * right,
        },
        longest_ms,
        "The longest step",
        "ms",
    )
    said(
        stiffer,
        {
            "this is in seconds. Give milliseconds.": stiffer / 1e3,
            "the stiffness stands under a root: twice as much does not halve the step.": right / 2.0,
            "a stiffer spring swings faster. Does that allow longer steps?": right * np.sqrt(2.0),
        },
        stiffer_ms,
        "The step with double stiffness",
        "ms",
        PREDICTED,
    )
    return f"2/omega: {right:.1f} ms, and 1/sqrt(2) of it, {stiffer:.1f} ms. No trial was needed for the second."


@EXERCISES.register("damping")
def damping(word: Any) -> str:
    """What damping does to the longest step."""
    if one(word, ("longer", "shorter", "same"), "answer") != "same":
        raise Wrong("Try it: swings(step_ms, damping=200) for steps just below and just above the limit.")
    return "The same. Damping calms what swings slowly; at the limit the step throws the mass over faster than damping can brake it."


@EXERCISES.register("row")
def row(one_ms: Any, forty_ms: Any, neighbours: Any) -> str:
    """Longest steps of 1 and 40 masses, and how neighbours move in the swing that explodes first."""
    for answer, count, what in ((one_ms, 1, "The longest step of 1 mass"), (forty_ms, ROW, f"The longest step of {ROW} masses")):
        right = row_limit_ms(count)
        said(
            right,
            {"this is in seconds. Give milliseconds.": right / 1e3, "the two numbers are swapped.": row_limit_ms(ROW + 1 - count)},
            answer,
            what,
            "ms",
        )
    if one(neighbours, WORDS, "answer") != "against":
        raise Wrong("Look at the left plot with a step that is a little too long, and compare neighbours.")
    ratio = row_limit_ms(1) / row_limit_ms(ROW)
    return f"The step shrinks by {ratio:.2f}, and no more for a thousand masses: neighbours against each other is the worst that can be."


@EXERCISES.register("finer")
def finer(steps_factor: Any, work_factor: Any) -> str:
    """Factors of steps and of work when every edge is cut in two."""
    said(
        2.0,
        {
            "omega is the square root of stiffness over mass.": 4.0,
            "more nodes alone cost no more steps (see the row), and fewer not at all.": 1.0,
        },
        steps_factor,
        "The factor of the steps",
        "times",
        PREDICTED,
    )
    said(
        8.0,
        {"that is the number of nodes and springs. Each of them also makes more steps.": 4.0, "there are also more springs.": 2.0},
        work_factor,
        "The factor of the work",
        "times",
        PREDICTED,
    )
    return "Twice the steps, for four times as many springs: a net twice as fine costs eight times the work."


@EXERCISES.register("fastest")
def fastest(own: Callable[..., Any]) -> str:
    """A function (K, mass) that returns the largest omega."""
    uneven = STIFFNESS * (2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)), MASS * np.array([1.0, 3.0, 2.0])
    skin = shaking.stiffness(network()), np.repeat(network().mass, 3)
    exact = float(np.sqrt(np.linalg.eigvals(uneven[0] / uneven[1][:, None]).real.max()))
    for (matrix, mass), right in ((uneven, exact), (skin, network().frequency)):
        answer = values(own, matrix, mass)
        bare = float(np.sqrt(np.linalg.norm(uneven[0], 2))) if matrix is uneven[0] else np.nan
        said(
            right,
            {
                "that is omega squared. Take the square root.": right**2,
                "the masses are missing: divide every row by its mass.": bare,
                "this is a frequency in swings per second. Hand back omega.": right / (2.0 * np.pi),
            },
            answer,
            "omega",
            "rad/s",
            0.01,
        )
    return f"Your few lines find {network().frequency:.0f} rad/s for {len(skin[1])} rows, as the package does."


@EXERCISES.register("steps")
def steps(predicted_steps: Any, stable_steps: Any) -> str:
    """Predicted number of steps, and the smallest stable whole number."""
    right, found = shaking.predicted(network()), fewest()
    said(
        right,
        {
            "the longest step is 2/omega, not 1/omega.": 2.0 * right,
            "omega is in rad/s already: no 2 pi.": right / (2.0 * np.pi),
            "that is the longest step in milliseconds. How many of them are in 1/60 s?": 2e3 / network().frequency,
            "that is for a whole second. A picture lasts 1/60 s.": 60.0 * right,
            "this is the number the package takes, with a reserve. Give the least possible.": float(network().substeps(shaking.FRAME)),
        },
        predicted_steps,
        "The prediction",
        "steps",
        PREDICTED,
    )
    if number(stable_steps, "The smallest stable number", "steps") != found:
        raise Wrong(f"The smallest stable number is not {stable_steps}. Try whole numbers around your prediction.")
    border = shaking.border(network())
    return f"{right:.2f} predicted, {found} measured; halving gives {border:.2f}, {100.0 * abs(border / right - 1.0):.2f} percent off."


@EXERCISES.register("double")
def double(double_steps: Any, double_stable: Any, tissue_percent: Any) -> str:
    """Prediction and smallest stable number with both stiffnesses doubled; percent of more steps if only the tissue is."""
    stiff = (DOUBLE * YOUNG, DOUBLE * TISSUE)
    right, before = shaking.predicted(network(*stiff)), shaking.predicted(network())
    said(
        right,
        {
            "twice the stiffness is not twice the omega: there is a root.": DOUBLE * before,
            "stiffer needs more steps, not fewer.": before / np.sqrt(DOUBLE),
            "that is with the skin alone twice as stiff.": shaking.predicted(network(DOUBLE * YOUNG)),
        },
        double_steps,
        "The prediction",
        "steps",
        0.002,
    )
    if number(double_stable, "The smallest stable number", "steps") != fewest(*stiff):
        raise Wrong(f"The smallest stable number is not {double_stable}. Give soft_skin both young and tissue, and try whole numbers.")
    tissue = 100.0 * (shaking.predicted(network(YOUNG, DOUBLE * TISSUE)) / before - 1.0)
    given = number(tissue_percent, "The growth with stiffer tissue", "percent")
    if abs(100.0 * given - tissue) < 0.05 < abs(given - tissue):
        raise Wrong("The growth with stiffer tissue is a part of one here. Give percent.")
    if abs(given - tissue) > 0.05 + 0.02 * abs(tissue):
        raise Wrong(f"With stiffer tissue alone the steps do not grow by {given:.3g} percent. Only tissue=... changes.")
    skin = 100.0 * (shaking.predicted(network(DOUBLE * YOUNG)) / before - 1.0)
    which = "the edges of the skin set" if skin > tissue else "what ties the skin down sets"
    return f"sqrt(2) times as many: {right:.2f}. Stiffer tissue alone costs {tissue:.1f} percent, stiffer skin {skin:.1f}: {which} it."


def nodes(answer: Any) -> list[int]:
    """Numbers of nodes that an answer names. Raises ``Wrong``."""
    count = len(network().mass)
    if isinstance(answer, str) or not isinstance(answer, Iterable):
        raise Wrong(f"Give a list of numbers of nodes, like [10, 20]; this is {answer!r}.")
    found = sorted({int(number(node, "A node", "its number")) for node in answer})
    if not found or found[0] < 0 or found[-1] >= count:
        raise Wrong(f"Give one to {MOST_HEAVIER} numbers of nodes between 0 and {count - 1}.")
    if len(found) > MOST_HEAVIER:
        raise Wrong(f"These are {len(found)} nodes; {MOST_HEAVIER} have to do.")
    return found


@EXERCISES.register("repair")
def repair(many: Any, heavier: Any) -> str:
    """How many nodes swing by more than a half in the fastest swing, and which ones to make twice as heavy."""
    swing = np.linalg.norm(shaking.worst_pattern(network()), axis=1)
    count = int((swing > 0.5).sum())
    if number(many, "The number of nodes", "nodes") != count:
        raise Wrong(f"Not {many} nodes. The pattern has x, y and z of each: take the length of these three, and count those above 0.5.")
    chosen = nodes(heavier)
    saved = saving(tuple(chosen))
    if saved < SAVED:
        raise Wrong(f"With these the net needs {100.0 * saved:.2f} percent fewer steps. Choose the nodes that swing farthest.")
    grams = 1e6 * float(network().mass[chosen].sum())
    return f"{grams:.0f} milligrams in the right places save {100.0 * saved:.1f} percent of all the work, for {len(swing)} nodes."


@EXERCISES.register("doubt")
def doubt(soft_steps: Any, stiff_steps: Any, longest_us: Any) -> str:
    """Steps at the softest and the stiffest published skin, and the longest time of a step in microseconds."""
    soft, stiff = (shaking.predicted(network(young)) for young in (SOFT, STIFF))
    simple = {"only the skin changes; the tissue below it stays as it is, and sets a limit of its own.": stiff_alone(SOFT)}
    said(soft, simple, soft_steps, "The number at 5 kPa", "steps", 0.03)
    said(stiff, {"140 MPa is 140e6 Pa.": shaking.predicted(network(STIFF / 1e3))}, stiff_steps, "The number at 140 MPa", "steps", 0.03)
    most = 1e6 * shaking.FRAME / stiff
    said(
        most,
        {"this is in milliseconds. Give microseconds.": most / 1e3, "that is the time for a whole picture.": 1e6 * shaking.FRAME},
        longest_us,
        "The time of a step",
        "microseconds",
        0.03,
    )
    return f"{soft:.0f} to {stiff:.0f} steps: what is known of skin decides whether it can be shown live. Compare {most:.1f} with yours."
