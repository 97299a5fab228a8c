"""Checks of lesson 12, "Another hand, same contraction". What is right is computed on fresh hands, never written down here."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Array, Hand
from handlab.check.answers import number, one, reference, said
from handlab.check.lesson import Exercises
from handlab.check.own_lines import compare, values
from handlab.check.verdict import Wrong
from handlab.fitting.enlarged import enlarged
from handlab.fitting.retarget import retarget
from handlab.simulation.play import simulate
from handlab.simulation.settle import settle
from handlab.studies import measures, size

EXERCISES = Exercises("12")

SMALL = 0.7
RULER = 1.0 / 30.0  # by which a ruler on a book makes lengths too small
POWERS = {"section": 2, "force": 2, "torque": 3, "mass": 3, "inertia": 5}
HINTS = {
    "section": "A section is an area.",
    "force": "A muscle pulls as strongly as its section is large.",
    "torque": "Torque is force times lever arm, and the lever arm grows as well.",
    "mass": "Mass is density times volume.",
    "inertia": "Mass times distance squared: both grow.",
}
BEND, MEETING = "pip2.flexion_extension", "pinch"
PREDICTED_DEG, MEASURED_DEG, MEASURED_MM = 5.0, 0.5, 0.1
PREDICTED, MEASURED = 0.08, 0.02  # parts by which a ratio may be off


@cache
def child() -> Hand:
    """The child's hand, fresh."""
    return load_hand("child")


@cache
def small(mechanics: Any = "scaled") -> Hand:
    """The reference hand, 0.7 times as long."""
    return enlarged(reference(), SMALL, mechanics=mechanics)


@cache
def bent_deg(hand: Hand) -> float:
    """Where the PIP joint of the index finger comes to rest."""
    found = settle(hand, size.PULL, hold=("wrist",), look_for_others=False).state
    return float(np.rad2deg(found.angle[hand.dof_names.index(BEND)]))


@cache
def ratio(hand: Hand) -> float:
    """Half time over that of the reference hand."""
    return size.half_time(hand) / size.half_time(reference())


@cache
def doubted() -> Hand:
    """The small hand with a friction that grows like its torque."""
    return small().with_(friction=reference().friction * SMALL**3)


@cache
def fists_apart_deg() -> Array:
    """How far (T, dof) the fists of reference hand and child are apart."""
    angles = [simulate(hand, "fist", hold=("wrist",)).angle for hand in (reference(), child())]
    return np.rad2deg(np.abs(angles[0] - angles[1]))


@cache
def sags() -> float:
    """Of the small hand over the reference hand."""
    return size.sag(small()) / size.sag(reference())


@cache
def gaps_mm() -> tuple[float, float, float]:
    """Between the pulps where thumb and index finger meet: reference hand; man, the same contractions; man, adapted ones."""
    meeting, man = simulate(reference(), MEETING, hold=("wrist",)), load_hand("man")
    played = [simulate(man, keys, hold=("wrist",)) for keys in (MEETING, retarget(meeting, man, hold=("wrist",)))]
    first, second, third = (1e3 * measures.pulp_gap(clip.hand, clip.skin(-1), 1, 2) for clip in (meeting, *played))
    return first, second, third


def told(right: float, answer: Any, what: str, hint: str) -> None:
    """Raise ``Wrong`` with ``hint`` unless a power is right."""
    if abs(number(answer, what, "powers of L") - right) > 1e-6:
        raise Wrong(f"{what} is not {float(answer):g}. {hint}")


@EXERCISES.register("guess", guess=True)
def guess(word: Any) -> str:
    """More, less or the same."""
    one(word, ("more", "less", "same"), "answer")
    return "You will predict it in section 3, and test it."


@EXERCISES.register("powers")
def powers(*answers: Any) -> str:
    """Powers of section, force, torque, mass, inertia."""
    if len(answers) != len(POWERS):
        raise Wrong(f"Give five numbers: {', '.join(POWERS)}.")
    for answer, (name, right) in zip(answers, POWERS.items(), strict=True):
        told(right, answer, f"The power of the {name}", HINTS[name])
    return "2, 2, 3, 3, 5."


@EXERCISES.register("power")
def power(own: Callable[..., Any]) -> str:
    """A function (ratio, L) that returns the power."""
    for times, p in ((0.7, 2.0), (1.3, 5.0), (0.6, 2.7)):
        right, grown = np.asarray(p), times**p
        slips = {
            "Both need their logarithm.": np.asarray(np.log(grown)),
            "Turn the fraction over: the logarithm of L goes below.": np.asarray(1.0 / p),
            "The logarithm of a fraction is not the fraction of logarithms.": np.asarray(np.log(grown / times)),
            "That is the ratio over L. The power stands in the exponent.": np.asarray(grown / times),
        }
        compare(values(own, grown, times), right, slips, "The power", "")
    return "Any base of the logarithm will do: it cancels."


@EXERCISES.register("child")
def the_child(*answers: Any) -> str:
    """Powers of force, torque and inertia of the child."""
    names = ("force", "torque", "inertia")
    if len(answers) != len(names):
        raise Wrong("Give three powers: force, torque, inertia.")
    growth = child().growth
    assert growth is not None
    before, after = size.strengths(reference()), size.strengths(child())
    right = {name: float(np.log(after[name] / before[name]) / np.log(growth.length)) for name in names}
    for answer, name in zip(answers, names, strict=True):
        slips = {
            "that is the ratio. Hand it to power, with L.": after[name] / before[name],
            "that is with the length of the hand. L is child.growth.length.": right[name]
            * float(np.log(growth.length) / np.log(after["length"] / before["length"])),
        }
        said(right[name], slips, answer, f"The power of the {name}", "", 0.003)
    return (
        f"{right['force']:.2f}, {right['torque']:.2f} and {right['inertia']:.2f}: near 2, 3 and 5, for a child has proportions of its own."
    )


@EXERCISES.register("angles")
def angles(predicted: Any, measured: Any) -> str:
    """PIP angle of the child, predicted and measured, degrees."""
    grown, right = bent_deg(reference()), bent_deg(child())
    given, found = number(predicted, "The prediction", "degrees"), number(measured, "What is measured", "degrees")
    if abs(given - grown) > PREDICTED_DEG:
        raise Wrong(f"{given:.0f} degrees: muscles pull with L^3 of the torque. With which power do the springs of the joint hold against?")
    if abs(np.rad2deg(found) - right) <= MEASURED_DEG:
        raise Wrong("The measured angle is in radians. Give degrees.")
    if abs(found - right) > MEASURED_DEG:
        raise Wrong(f"The child's finger does not rest at {found:.1f} degrees. Take bent_deg(child).")
    return f"{grown:.1f} and {right:.1f} degrees: what balances in a large hand balances in a small one."


@EXERCISES.register("times")
def times(predicted: Any, measured: Any) -> str:
    """Ratio of half times, predicted from L and measured."""
    growth = child().growth
    assert growth is not None
    length, right = growth.length, ratio(child())
    slips = {
        "the root is missing: a time is the root of angle over acceleration.": length**2,
        "smaller is faster: the child needs less time.": 1.0 / length,
        "the acceleration grows; time goes with one over its root.": 1.0 / length**2,
        "that is the ratio of the torques.": length**3,
        "that is the ratio of the inertias.": length**5,
    }
    said(length, slips, predicted, "The prediction", "times", PREDICTED)
    said(right, {"turn the fraction over: the child goes above.": 1.0 / right}, measured, "What is measured", "times", MEASURED)
    return f"{length:.2f} predicted, {right:.2f} measured. Keep it in mind: section 6 asks whether the reason was the right one."


@EXERCISES.register("apart")
def apart(most: Any, end: Any) -> str:
    """How many degrees two fists are apart, at most and at the end."""
    off = fists_apart_deg()
    way, rest = float(off.max()), float(off[-1].max())
    for answer, right, other, what in ((most, way, rest, "The largest difference"), (end, rest, way, "The difference at the end")):
        slips = {
            "this is in radians. Give degrees.": float(np.deg2rad(right)),
            "that is the mean; give the largest.": float(off.mean()),
            "the two are swapped.": other,
        }
        said(right, slips, answer, what, "degrees", 0.02)
    return f"{way:.1f} degrees on the way, because the child is ahead, and {rest:.1f} at the end, because it has other proportions."


@EXERCISES.register("kept")
def kept(torque: Any, inertia: Any, measured: Any) -> str:
    """Powers of torque and inertia with kept mechanics, and the ratio of half times."""
    told(0.0, torque, "The power of the torque", "Muscles and lever arms stay as they are: does the torque know of L at all?")
    told(2.0, inertia, "The power of the inertia", "The mass stays; only the distance in m times distance squared grows.")
    right = ratio(small("kept"))
    slips = {
        "that is what inertia alone would make of it. Measure.": SMALL,
        "turn the fraction over.": 1.0 / right if abs(right - 1.0) > 0.05 else np.nan,
        "that is the ratio with mechanics that grow along.": ratio(small()),
    }
    said(right, slips, measured, "The ratio of times", "times", MEASURED)
    return f"{right:.2f}: half the inertia, and hardly faster. Something else sets the time."


@EXERCISES.register("doubt")
def doubt(measured: Any) -> str:
    """Ratio of half times if friction grows like L^3."""
    right = ratio(doubted())
    slips = {
        "that is with the friction of the package. Take doubted.": ratio(small()),
        "that is with kept mechanics.": ratio(small("kept")),
    }
    if abs(right - ratio(small("kept"))) < 2 * MEASURED:
        slips.popitem()
    said(right, slips, measured, "The ratio", "times", MEASURED)
    return f"{right:.2f} instead of {ratio(small()):.2f}: whether a child's finger is faster hangs on a number that was assumed."


@EXERCISES.register("weight")
def weight(power: Any, measured: Any) -> str:
    """Power of the torque of the weight, and the ratio of the sags."""
    told(4.0, power, "The power of the torque of the weight", "Weight grows like mass; and its arm grows, too.")
    right = sags()
    said(right, {"the small hand goes above the line.": 1.0 / right}, measured, "The ratio of the sags", "times", MEASURED)
    return f"{right:.2f}. L^4 over L^3 leaves L = {SMALL:g}, as long as the springs of the wrist are nearly straight lines."


@EXERCISES.register("repair")
def repair(same: Any, adapted: Any) -> str:
    """Gap of the pulps on the man with the same and with adapted contractions, millimetres."""
    gap, *right = gaps_mm()
    for answer, goal, other, what in ((same, right[0], right[1], "The gap"), (adapted, right[1], right[0], "The gap with adapted ones")):
        given = number(answer, what, "millimetres")
        if abs(given - goal) <= MEASURED_MM:
            continue
        if abs(1e3 * given - goal) <= MEASURED_MM:
            raise Wrong(f"{what} is in metres here. Give millimetres.")
        if abs(given - other) <= MEASURED_MM:
            raise Wrong("The two are swapped: first with the contractions of the reference hand.")
        raise Wrong(f"{what} is not {given:.2f} mm. Give pulp_gap the man, and the skin of the man's clip.")
    growth = load_hand("man").growth
    assert growth is not None
    return f"{right[0]:.1f} and {right[1]:.1f} mm, where {gap:.1f} mm times L would be {gap * growth.length:.1f}: they mean the same again."


@EXERCISES.register("error")
def error(torque: Any, inertia: Any) -> str:
    """Percent by which torque and inertia come out too small."""
    for answer, name in ((torque, "torque"), (inertia, "inertia")):
        power = POWERS[name]
        right = 100.0 * (1.0 - (1.0 - RULER) ** power)
        slips = {
            "this is a part of one. Give percent.": right / 100.0,
            "that is what is left. Give what is lost.": 100.0 - right,
            "that is the error of the length.": 100.0 * RULER,
            "the sign is turned: give how much is lost, as a positive number.": -right,
            "the two are swapped.": 100.0 * (1.0 - (1.0 - RULER) ** POWERS["inertia" if name == "torque" else "torque"]),
        }
        said(right, slips, answer, f"The error of the {name}", "percent", 0.08)  # p times the error of the length is near enough
    return "About three and five times the error of the length. Now look for the book below your ruler."
