"""Checks of lesson 06, "Thumb, wrist and key frames". What is right is measured on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np

from handlab.check import grips
from handlab.check.answers import listing, number, one, reference
from handlab.check.lesson import Exercises
from handlab.check.trials import (
    GRIP,
    MIDDLE,
    column,
    finger_sums,
    gap_without,
    held_clip,
    motion,
    pulls,
    row,
    settled,
    shift,
)
from handlab.check.verdict import Wrong
from handlab.simulation.keyframes import keyframes
from handlab.simulation.skeleton import rest

EXERCISES = Exercises("06")

DIRECTIONS = ("distal", "proximal", "palmar", "dorsal", "radial", "ulnar")
ASKED = {"abduction": "cmc1.abduction_adduction", "flexion": "cmc1.flexion_opposition"}
FLEXED, EXTENDED, STRONG = 60.0, -60.0, -30.0  # degrees of the wrist
CLIP, TURNING = "opposition-little", "cmc1.axial_rotation"
ALMOST = 0.85  # a gap of this part of the widest one counts as the widest too
SHOWN = ("FCR", "FDS2", "FDP2", "FPL", "FCU")  # muscles of the exercise "doubt"


@EXERCISES.register("directions")
def directions(answer: Any) -> str:
    """Main direction of the thumb's pulp for palmar abduction and for flexion of CMC 1."""
    if not isinstance(answer, Mapping) or set(answer) != set(ASKED):
        raise Wrong("Give a dictionary with the keys 'abduction' and 'flexion'.")
    for name, rotation in ASKED.items():
        by = shift(rotation)
        k = int(np.abs(by).argmax())
        right = (("proximal", "distal"), ("dorsal", "palmar"), ("ulnar", "radial"))[k][int(by[k] > 0.0)]
        given = one(answer[name], DIRECTIONS, "direction")
        if name == "abduction" and given == "radial":
            raise Wrong("abduction: that would be spreading. The axis of this joint lifts the thumb elsewhere; look at the largest number.")
        if given != right:
            raise Wrong(f"{name}: {given} is not where most of the way goes. Which of the three numbers is largest, and what is its sign?")
    return "Palmar abduction leaves the plane of the palm, flexion sweeps across it. Neither is what the fingers mean by these words."


@cache
def most_turned() -> tuple[str, float, float]:
    """The rotation that APL turns most, its change, and that of palmar abduction, in degrees."""
    clip = motion({"APL": 0.2}, 2.0)
    by = np.rad2deg(np.abs(clip.angle[-1] - clip.angle[0]))
    return reference().dof_names[int(by.argmax())], float(by.max()), float(by[column(ASKED["abduction"])])


@EXERCISES.register("name")
def name(rotation: Any) -> str:
    """The rotation that the long abductor of the thumb turns most with the wrist free."""
    right, most, abduction = most_turned()
    given = one(rotation, reference().dof_names, "degree of freedom")
    if given != right and given == ASKED["abduction"]:
        raise Wrong("That is what its name says, and it does turn. Another rotation turns further.")
    if given != right:
        raise Wrong(f"{given} is not the one. Take the last angles minus the first ones, without their signs, and find the largest.")
    return f"{most:.0f} degrees of {right}, {abduction:.0f} of palmar abduction: its tendon runs far beside the axis of the wrist."


@cache
def gaps() -> dict[str, float]:
    """Gap of both pulps in metres by the muscle that is silent."""
    hand, keys = reference(), keyframes(CLIP)
    regions = ("thenar", "long thumb muscles", "hypothenar")
    return {muscle: gap_without(CLIP, muscle) for muscle in keys.keyed if hand.muscles[muscle].region in regions}


@EXERCISES.register("opposition")
def opposition(culprit: Any, turned_deg: Any) -> str:
    """The muscle whose loss opens the widest gap, and the axial rotation of the thumb in degrees."""
    hand = reference()
    lost = gaps()
    given = one(culprit, hand.muscles, "muscle")
    if lost.get(given, 0.0) < ALMOST * max(lost.values()):
        raise Wrong(f"Without {hand.muscles[given].abbreviation} the pulps still come nearer than without another one. Compare all gaps.")
    angle = held_clip(CLIP).angle[:, column(TURNING)]
    right = float(np.rad2deg(abs(angle[-1] - angle[0])))
    value = abs(number(turned_deg, "The turning of the thumb", "degrees"))
    if abs(np.rad2deg(value) - right) < 1.0:
        raise Wrong(f"{value:.3g} is in radians. Give degrees.")
    if abs(value - right) > 1.0:
        raise Wrong(f"The thumb does not turn {value:.1f} degrees. Take {TURNING} in the last frame minus the first.")
    open_mm = 1e3 * lost[given]
    return f"Without {hand.muscles[given].abbreviation} {open_mm:.0f} mm stay open. The pronation of {right:.1f} degrees comes by itself."


@EXERCISES.register("tenodesis")
def tenodesis(flexed_deg: Any, extended_deg: Any) -> str:
    """Sum of the flexions of the middle finger in degrees, without contraction, with the wrist flexed and extended."""
    right = {wrist: float(finger_sums(settled(wrist, {}))[1]) for wrist in (FLEXED, EXTENDED)}
    given = {FLEXED: number(flexed_deg, "The first sum", "degrees"), EXTENDED: number(extended_deg, "The second sum", "degrees")}
    if all(abs(given[a] - right[b]) < 3.0 for a, b in ((FLEXED, EXTENDED), (EXTENDED, FLEXED))):
        raise Wrong("These two are swapped: first the flexed wrist, +60.")
    for wrist, value in given.items():
        if abs(np.rad2deg(value) - right[wrist]) < 3.0:
            raise Wrong(f"{value:.3g} at {wrist:+.0f} degrees is in radians. Give degrees.")
        if abs(value - right[wrist]) >= 3.0:
            raise Wrong(f"{value:.0f} degrees at {wrist:+.0f} degrees of the wrist is not what a fresh hand does. Is the wrist held?")
    return f"The wrist alone bends the middle finger by {right[EXTENDED] - right[FLEXED]:.0f} degrees."


@cache
def puller(wrist: float) -> str:
    """Abbreviation of the muscle that pulls hardest at the middle finger without contraction."""
    force = pulls(settled(wrist, {}), {})
    return max(MIDDLE, key=lambda muscle: float(force[row(muscle)]))


@EXERCISES.register("who")
def who(with_wrist_flexed: Any, with_wrist_extended: Any) -> str:
    """The muscles of the middle finger that pull hardest in the two postures of the exercise "tenodesis"."""
    hand = reference()
    for answer, wrist in ((with_wrist_flexed, FLEXED), (with_wrist_extended, EXTENDED)):
        given = hand.muscles[one(answer, hand.muscles, "muscle")].abbreviation
        if given not in MIDDLE:
            raise Wrong(f"{given} does not reach the middle finger.")
        if given == puller(FLEXED if wrist == EXTENDED else EXTENDED):
            raise Wrong(f"{wrist:+.0f} degrees: there the fibre of {given} is slack. Which side of the wrist is stretched?")
        if given != puller(wrist):
            raise Wrong(f"{wrist:+.0f} degrees: {given} pulls, if at all, less than another one.")
    return (
        f"A flexed wrist stretches {puller(FLEXED)} over its back, and the finger opens; an extended one stretches {puller(EXTENDED)}, "
        "and it closes."
    )


@cache
def strength(wrist: float) -> float:
    """Force of FDP3 and FDS3 in newtons with all flexors of the fingers at full contraction."""
    every = dict.fromkeys(GRIP, 1.0)
    force = pulls(settled(wrist, every), every)
    return float(force[row("FDP3")] + force[row("FDS3")])


@EXERCISES.register("insufficient")
def insufficient(flexed_force: Any, extended_force: Any, fibre: Any) -> str:
    """Force of both flexors of the middle finger with the wrist at +60 and at -30, and why."""
    given = {FLEXED: number(flexed_force, "The first force", "N"), STRONG: number(extended_force, "The second force", "N")}
    if all(abs(given[a] - strength(b)) < 0.05 * strength(b) for a, b in ((FLEXED, STRONG), (STRONG, FLEXED))):
        raise Wrong("These two are swapped: first the flexed wrist.")
    for wrist, value in given.items():
        if abs(value - strength(wrist)) > 0.05 * strength(wrist):
            raise Wrong(f"{value:.1f} N is not the force at {wrist:+.0f} degrees. Add FDP3 and FDS3 at the end, all eight flexors at 1.")
    if one(fibre, ("too short", "too long"), "answer") != "too short":
        raise Wrong("Both the flexed wrist and the flexed finger bring the ends of the fibre together. Look at its ratio.")
    return f"The flexed wrist leaves {strength(FLEXED) / strength(STRONG):.0%} of the force. This is why a strong grip extends the wrist."


@cache
def at_half() -> float:
    """Percent of the way of the middle finger at contraction 0.2 that is done at 0.1."""
    relaxed = finger_sums(rest(reference()))[1]
    some, more = (finger_sums(settled(None, {"FDP3": value}))[1] - relaxed for value in (0.1, 0.2))
    return float(100.0 * some / more)


@EXERCISES.register("half")
def half(percent: Any) -> str:
    """Percent of the way at 0.2 that is done at 0.1."""
    value, right = number(percent, "The part", "percent"), at_half()
    if abs(100.0 * value - right) < 2.0:
        raise Wrong(f"{value:.3g} is a part of one. Give percent.")
    if abs(value - 50.0) < 2.0:
        raise Wrong("It would be half if contraction were an angle. Measure it.")
    if abs(value - right) > 2.0:
        raise Wrong(f"{value:.1f} percent is not what a fresh hand does. Take changes from the relaxed hand, not the angles themselves.")
    return f"Half the contraction, {right:.0f} percent of the way: a fibre weakens as it shortens, and what it stretches pulls back harder."


EXERCISES.register("fist")(grips.fist)
EXERCISES.register("runaway")(grips.runaway)
EXERCISES.register("brace")(grips.brace)
EXERCISES.register("mend")(grips.mend)
EXERCISES.register("between")(grips.between)
EXERCISES.register("keys")(grips.keys)


@cache
def swapped() -> frozenset[str]:
    """Shown muscles whose printed flexion arm at the wrist is corrected by more than 2 mm."""
    arms = {name: next(arm for arm in reference().muscles[name].lever_arms if arm.dof == "wrist.flexion_extension") for name in SHOWN}
    return frozenset(name for name, arm in arms.items() if abs(arm.used - arm.printed) > 0.002)


@EXERCISES.register("doubt")
def doubt(suspects: Any) -> str:
    """The muscles whose two printed lines at the wrist stand in each other's place."""
    hand = reference()
    names = [suspects] if isinstance(suspects, str) else suspects
    if not isinstance(names, Iterable):
        raise Wrong("Give abbreviations in quotes, like {'FCR'}.")
    named = {hand.muscles[one(name, hand.muscles, "muscle")].abbreviation for name in names}
    innocent, missed = named - swapped(), swapped() - named
    if innocent & {"FCR", "FCU"}:
        raise Wrong(
            f"{listing(innocent & {'FCR', 'FCU'})} runs at the edge of the wrist, outside the tunnel: it may well have a large arm there."
        )
    if innocent:
        raise Wrong(f"{listing(innocent)} fits a tendon in the middle of the wrist: a large arm for flexion, a small one to the side.")
    if missed:
        raise Wrong("There is another tendon of the tunnel whose sideways arm is larger than its flexion arm.")
    return (
        f"{listing(named)}: the lines for flexion and for the side stand in each other's place. The default reading has them turned back."
    )
