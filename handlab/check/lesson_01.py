"""Checks of lesson 01, "How hard can a muscle pull?". What is right is measured on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.check.answers import listing, number, one, reference
from handlab.check.lesson import Exercises
from handlab.check.verdict import Open, Wrong, is_open
from handlab.physics.muscle import active_force_length, muscle_force, passive_force_length
from handlab.simulation.keyframes import keyframes
from handlab.simulation.mechanics import moving_limits
from handlab.simulation.play import simulate
from handlab.simulation.skeleton import pose
from handlab.studies.excursion import ACTIVE_RANGE
from handlab.studies.grip import FIST_DEG

EXERCISES = Exercises("01")

PROBES = ((0.0, 0.8), (1.0, 0.5), (1.0, 0.8), (0.5, 1.2), (1.0, 1.1), (0.3, 1.5), (1.0, 1.7), (0.0, 1.3))
PUSHED = 0.5, 50.0  # fibre ratio and maximum force in N of the exercise "push"
WEAK, DOUBLE = 0.1, 0.2  # contractions of the exercise "twice"
FINGER = ("mcp2", "pip2", "dip2")
SHAPE, FASTEST = 0.25, 10.0  # force-velocity curve as the lesson gives it: no unit, and rest lengths a second
STRAIN = 0.033  # of a tendon at the maximum force of its muscle, as the lesson gives it
TAU, COMMAND = 0.04, 0.3  # s, and the contraction of the exercise "delay"


def probe(own: Any, *arguments: float) -> float:
    """What a student's function gives for numbers. Raises ``Open`` for the placeholder and ``Wrong`` for no function."""
    if not callable(own):
        raise Wrong("Hand over the function itself, without brackets behind its name.")
    value = own(*arguments)
    if is_open(value):
        raise Open
    return number(value, "What the function returns", "parts of the maximum force")


@EXERCISES.register("own_force")
def own_force(force: Callable[..., Any]) -> str:
    """A function of contraction and fibre ratio that gives force over maximum force (1')."""
    for contraction, ratio in PROBES:
        value = probe(force, contraction, ratio)
        right = float(muscle_force(contraction, ratio, 1.0))
        if abs(value - right) < 1e-9:
            continue
        active, passive = float(active_force_length(ratio)), float(passive_force_length(ratio))
        where = f"At contraction {contraction:g} and ratio {ratio:g}"
        slips = {
            f"{where} your muscle pushes. A muscle can only pull: what is below 0 is 0.": float(
                muscle_force(contraction, ratio, 1.0, reading="printed")
            ),
            f"{where} the contraction has scaled the stretch as well. A stretched fibre pulls back without being told to.": contraction
            * (active + passive),
            f"{where} the passive part is missing.": contraction * active,
            f"{where} the fibre is slack (shorter than at rest) and yet pulls back. The passive part begins at ratio 1.": contraction
            * active
            + 2.77 * (ratio - 1.0) ** 2,
            f"{where} the contraction is missing in front of the active part.": active + passive,
        }
        for text, slip in slips.items():
            if abs(value - slip) < 1e-9:
                raise Wrong(text)
        raise Wrong(f"{where} your function gives {value:.4f}; the package has {right:.4f}.")
    return "Your lines and the package agree, from the slack fibre to the overstretched one."


@EXERCISES.register("push")
def push(printed: Any, sound: Any) -> str:
    """Force in newtons of a fibre that is too short, as printed and with the guard."""
    ratio, strongest = PUSHED
    answers = number(printed, "The printed force", "newtons"), number(sound, "The guarded force", "newtons")
    right = float(muscle_force(1.0, ratio, strongest, reading="printed")), float(muscle_force(1.0, ratio, strongest))
    if abs(answers[0] - right[0] / strongest) < 1e-6:
        raise Wrong(f"{answers[0]:g} has no unit: it is a part of the maximum force. Newtons are asked for.")
    if abs(answers[0] + right[0]) < 1e-6:
        raise Wrong("The size is right. Which sign has it?")
    if abs(answers[0] - right[0]) > 0.05:
        raise Wrong(f"{answers[0]:g} N is not what the printed curve gives at ratio {ratio:g}. Put the number into it, without any guard.")
    if abs(answers[1] - right[1]) > 0.05:
        raise Wrong(f"{answers[1]:g} N: what can a fibre do whose filaments have nothing left to pull along?")
    return f"Printed, the muscle would push with {-right[0]:g} N. The paper relies on joints that never let a fibre get so short."


@EXERCISES.register("guess_peak", guess=True)
def guess_peak(ratio: Any) -> str:
    """Any ratio: being wrong here is the point."""
    number(ratio, "Your guess", "parts of the rest length")
    return "Now look for it."


@cache
def peaks() -> tuple[float, float]:
    """Fibre ratios with the largest active and, between the ends of the active range, the largest total force at full contraction."""
    ratio = np.linspace(*ACTIVE_RANGE, 100001)
    total = active_force_length(ratio) + passive_force_length(ratio)
    return float(ratio[np.argmax(active_force_length(ratio))]), float(ratio[np.argmax(total)])


@EXERCISES.register("peak")
def peak(active: Any, total: Any) -> str:
    """Two fibre ratios: of the largest active force, and of the largest total force up to 1.6."""
    right = peaks()
    given = number(active, "The first ratio", "parts of the rest length"), number(total, "The second ratio", "parts of the rest length")
    if abs(given[0] - right[1]) < 0.005 and abs(given[1] - right[0]) < 0.005:
        raise Wrong("These two are exchanged: the first is that of the active part alone.")
    if abs(given[0] - 1.0) < 0.005:
        raise Wrong("That is the rest length, where the text of the paper expects the maximum. What does its formula say?")
    for value, expected, what in zip(given, right, ("the active part", "both parts together"), strict=True):
        if abs(value - expected) > 0.005:
            raise Wrong(f"{value:g} is not the largest of {what}. Look between 0.6 and 1.6, in steps of 0.001.")
    return f"The fitted curve peaks 10 % beyond the rest length, the sum of both even at {right[1]:.3f}: a stretched muscle helps itself."


@cache
def doubled() -> tuple[float, float, float]:
    """What twice the contraction does to FDP2: force with the finger held, force and MCP angle with the finger free, as factors."""
    hand = reference()
    row, column = hand.muscle_names.index(hand.muscles["FDP2"].name), hand.dof_names.index("mcp2.flexion_extension")
    found = []
    for hold in (("wrist", *FINGER), ("wrist",)):
        clips = [simulate(hand, {"FDP2": value}, seconds=2.0, hold=hold) for value in (WEAK, DOUBLE)]
        force = [clip.force[-1, row] for clip in clips]
        turned = [clip.angle[-1, column] - clip.angle[0, column] for clip in clips]
        found.append((force[1] / force[0], turned[1] / turned[0] if turned[0] else np.nan))
    return float(found[0][0]), float(found[1][0]), float(found[1][1])


@EXERCISES.register("twice")
def twice(held: Any, free: Any, angle: Any) -> str:
    """Three factors: force held, force free, angle free."""
    right = doubled()
    names = ("force of the held finger", "force of the free finger", "angle of the free finger")
    for value, expected, what in zip((held, free, angle), right, names, strict=True):
        factor = number(value, f"The factor for the {what}", "times")
        if abs(factor - 1.0 / expected) < 0.02:
            raise Wrong(f"The {what}: divide the other way round, strong by weak.")
        if what.startswith("angle") and abs(factor - expected) > 0.02:
            raise Wrong(f"{factor:.2f} is not the factor of the {what}. Count from where the finger began, not from zero.")
        if abs(factor - expected) > 0.02:
            raise Wrong(f"{factor:.2f} is not the factor of the {what}. Is the wrist held, and is it the last moment of two seconds?")
    return (
        f"Held, twice the contraction is twice the force. Free, the fibre shortens and force grows {right[1]:.2f} times, the angle "
        f"{right[2]:.2f} times. Contraction is neither force nor shortening nor angle."
    )


def fist_ratios(hand: Hand) -> Array:
    """Fibre ratios (muscle,) in the fist of the lesson, wrist straight."""
    closed = {f"{joint}{k}.flexion_extension": np.deg2rad(value) for joint, value in FIST_DEG.items() for k in range(2, 6)}
    ratio: Array = pose(hand, {"wrist.flexion_extension": 0.0, **closed}).fibre_length / hand.rest_length
    return ratio


def powerless(hand: Hand, ratio: Array) -> set[str]:
    """Abbreviations of the muscles whose fibres are too short to pull."""
    return {muscle.abbreviation for muscle, value in zip(hand.muscles.values(), ratio, strict=True) if value <= ACTIVE_RANGE[0]}


@EXERCISES.register("closed")
def closed(flat: Any, relaxed: Any) -> str:
    """Two sets of muscles without active force in the fist: fibres at rest in the flat hand, and in the relaxed one."""
    hand = reference()
    right = {name: powerless(hand, fist_ratios(hand.with_fibre_rest(name))) for name in ("flat", "relaxed")}
    for name, given in (("flat", flat), ("relaxed", relaxed)):
        if isinstance(given, str) or not isinstance(given, Iterable):
            raise Wrong(f"Give a set of names in quotes for the {name} posture, like {{'FDP2', 'ECU'}}, or set() if there are none.")
        named = {hand.muscles[one(muscle, hand.muscles, "muscle")].abbreviation for muscle in given}
        if named - right[name]:
            raise Wrong(f"At rest in the {name} hand, {listing(named - right[name])} can still pull in this fist.")
        if right[name] - named:
            raise Wrong(f"At rest in the {name} hand, {len(right[name] - named)} more muscles are at or below {ACTIVE_RANGE[0]:g}.")
    return f"With the paper's choice {listing(right['flat'])} go slack before the fist closes. At rest in the relaxed hand they pull."


def shortest_ratio(hand: Hand) -> Array:
    """Smallest fibre ratio (muscle,) that any posture within the limits can give."""
    arm, at = hand.lever_arm @ hand.coupling, hand.fibre_rest[[hand.dof_names.index(name) for name in hand.moving_names]]
    low, high = moving_limits(hand).T
    most = np.maximum(arm * (low - at), arm * (high - at)).sum(axis=1)
    ratio: Array = 1.0 - most / hand.rest_length
    return ratio


@EXERCISES.register("doubt")
def doubt(shortest: Any, count: Any) -> str:
    """Smallest fibre ratio of FCR with fibres at rest in the flat hand, and how many of the 42 can get too short to pull."""
    hand = reference().with_fibre_rest("flat")
    ratio = shortest_ratio(hand)
    row = hand.muscle_names.index(hand.muscles["FCR"].name)
    if abs(number(shortest, "The ratio of FCR", "parts of the rest length") - ratio[row]) > 0.005:
        raise Wrong(
            "Put the wrist to its limits of flexion and of deviation, on the side to which FCR pulls. With fibres at rest in the flat hand."
        )
    right = int((ratio < ACTIVE_RANGE[0]).sum())
    given = number(count, "The count", "muscles")
    if given != right:
        raise Wrong(
            f"{given:g} is too {'few' if given < right else 'many'}. Every rotation may stand at the limit to which the muscle pulls."
        )
    return f"{right} of 42 can leave the range. 'Usually never' holds for usual postures, not for the joints' limits."


@cache
def fastest_shortening() -> float:
    """Largest speed at which FDP2 shortens in the clip "fist", in rest lengths a second, from frame to frame."""
    hand = reference()
    clip = simulate(hand, keyframes("fist"))
    row = hand.muscle_names.index(hand.muscles["FDP2"].name)
    return float(-(np.diff(clip.fibre_length[:, row]) / np.diff(clip.time)).min() / hand.rest_length[row])


@EXERCISES.register("speed")
def speed(factor: Callable[..., Any], fastest: Any) -> str:
    """The force-velocity factor as a function of shortening speed in rest lengths a second, and the largest speed in the clip "fist"."""
    for value in (0.0, 0.5, 2.0, 5.0, FASTEST):
        share = value / FASTEST
        right = (1.0 - share) / (1.0 + share / SHAPE)
        given = probe(factor, value)
        if abs(given - right) > 1e-9:
            if abs(given - (1.0 - value) / (1.0 + value / SHAPE)) < 1e-9:
                raise Wrong(f"The speed has to be divided by the largest one, {FASTEST:g} rest lengths a second.")
            raise Wrong(f"At {value:g} rest lengths a second your function gives {given:.3f}; the curve is at {right:.3f}.")
    right = fastest_shortening()
    given = number(fastest, "The largest speed", "rest lengths a second")
    if abs(given + right) < 0.05 * right:
        raise Wrong("The size is right. Shortening counts as positive here.")
    if abs(given - 0.066 * right) < 0.05 * 0.066 * right:
        raise Wrong("That looks like metres a second. Divide by the rest length.")
    if abs(given - right) > 0.05 * right:
        raise Wrong(f"{given:.3g} rest lengths a second is not the fastest of FDP2 in this clip.")
    left = (1.0 - right / FASTEST) / (1.0 + right / FASTEST / SHAPE)
    return f"At {right:.2f} rest lengths a second {1 - left:.0%} of the active force would be gone. The paper's muscle does not notice."


@EXERCISES.register("tendon")
def tendon(length_mm: Any, loss: Any) -> str:
    """Length of one's own tendon in millimetres, and the stretch at full force in parts of the rest length of FDP2."""
    own, given = number(length_mm, "The length", "millimetres"), number(loss, "The loss", "parts of the rest length")
    if not 120.0 <= own <= 400.0:
        raise Wrong(f"{own:g} mm: give millimetres, from the middle of your forearm to the last joint of your index finger.")
    rest_mm = 1000.0 * reference().muscles["FDP2"].rest_length
    if abs(given - STRAIN * own) < 0.05:
        raise Wrong("These are millimetres. How much is it in parts of the rest length of FDP2?")
    if abs(given - STRAIN * own / rest_mm) > 0.002:
        raise Wrong(f"{given:.3g} does not follow from {own:g} mm, {STRAIN:.1%} of stretch and a rest length of {rest_mm:g} mm.")
    return f"A stiff tendon hides {given:.0%} of the fibre's range. The paper's tendons do not stretch at all."


@EXERCISES.register("delay")
def delay(activation: Callable[..., Any]) -> str:
    """A function (command, dt, tau) that gives the activation (n,) which follows a command (n,)."""
    if not callable(activation):
        raise Wrong("Hand over the function itself, without brackets behind its name.")
    dt = 0.001
    command = np.where(np.arange(400) * dt < 0.2, COMMAND, 0.0)
    given = activation(command, dt, TAU)
    if is_open(given):
        raise Open
    values = np.asarray(given, dtype=np.float64)
    if values.shape != command.shape:
        raise Wrong(f"The result has shape {values.shape}; give one activation for each command, shape {command.shape}.")
    time = dt * np.arange(len(command))
    up = COMMAND * (1.0 - np.exp(-np.minimum(time, 0.2) / TAU))
    right = up * np.exp(-np.maximum(time - 0.2, 0.0) / TAU)
    if np.abs(values - command).max() < 1e-9:
        raise Wrong("This is the command itself. The activation follows it, and never jumps.")
    if np.abs(values - right).max() > 0.02:
        k = int(np.abs(values - right).argmax())
        raise Wrong(f"After {time[k]:.3f} s your activation is {values[k]:.3f}; the equation gives {right[k]:.3f}.")
    return f"After {TAU * 1000:.0f} ms two thirds of the command have arrived. A film at 25 pictures a second shows that as one picture."
