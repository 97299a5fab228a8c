"""Checks of lesson 06, "Thumb, wrist and key frames". What is right is measured on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.check.answers import listing, number, one, reference
from handlab.check.lesson import Exercises
from handlab.check.trials import (
    CLOSED_AT,
    CLOSING,
    GRIP,
    GRIP_SECONDS,
    MIDDLE,
    OPEN_AGAIN,
    PULP,
    WRIST,
    balancing,
    column,
    deflection,
    finger_sums,
    gap_without,
    held_clip,
    motion,
    pulls,
    row,
    settled,
    shift,
)
from handlab.check.verdict import Open, Wrong, is_open
from handlab.simulation.keyframes import keyframes
from handlab.simulation.skeleton import contraction_of, rest
from handlab.studies import measures

EXERCISES = Exercises("06")

DIRECTIONS = ("distal", "proximal", "palmar", "dorsal", "radial", "ulnar")
ASKED = {"abduction": "cmc1.abduction_adduction", "flexion": "cmc1.flexion_opposition"}
FLEXED, EXTENDED, STRONG = 60.0, -60.0, -30.0  # degrees of the wrist
CLIP, TURNING = "opposition-little", "cmc1.axial_rotation"
ALMOST = 0.85  # a gap of this part of the widest one counts as the widest too
SUMS = (195.0, 240.0)  # degrees of a closed finger
TOUCH = 0.006  # m
STAYS, NEVER = 3.0, 5.0  # degrees that the wrist may be off at the end, and ever
SIX = ("FDP2", "FDP3", "FDP4", "FDP5", "FPL", "OPP")
PROBES = ((GRIP, 30), (GRIP, -1), ({"FDP2": 0.3, "FDP3": 0.1, "FPL": 0.4}, -1))
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
    return f"Without {hand.muscles[given].abbreviation} {1e3 * lost[given]:.0f} mm stay open. The pronation of {right:.1f} degrees comes by itself."


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
def insufficient(flexed_N: Any, extended_N: Any, fibre: Any) -> str:
    """Force of both flexors of the middle finger with the wrist at +60 and at -30, and why."""
    given = {FLEXED: number(flexed_N, "The first force", "N"), STRONG: number(extended_N, "The second force", "N")}
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
    return f"Half the contraction, {right:.0f} percent of the way: the fibre gets weaker as it gets shorter, and the joint gets stiffer."


def contractions(answer: Any, allowed: Iterable[str], what: str) -> dict[str, float]:
    """Contractions by abbreviation, of allowed muscles only. Raises ``Wrong``."""
    hand = reference()
    if not isinstance(answer, Mapping):
        raise Wrong(f"Give a dictionary like {{{next(iter(allowed))!r}: 0.05, ...}}; this is {type(answer).__name__}.")
    values: dict[str, float] = {}
    for key, value in answer.items():
        abbreviation = hand.muscles[one(key, hand.muscles, "muscle")].abbreviation
        if abbreviation not in allowed:
            raise Wrong(f"{abbreviation} is not one of {what}: {', '.join(allowed)}.")
        values[abbreviation] = number(value, f"The contraction of {abbreviation}", "parts of 1")
    try:
        contraction_of(hand, values)
    except ValueError as error:
        raise Wrong(f"{str(error)[:1].upper()}{str(error)[1:]}.") from None
    return values


@EXERCISES.register("fist")
def fist(values: Any) -> str:
    """Six contractions that close the hand with the wrist held."""
    hand = reference()
    state = motion(contractions(values, SIX, "the six sliders"), 2.0, hold=("wrist",)).states[-1]
    for finger, total in zip(("index", "middle", "ring", "little"), finger_sums(state), strict=True):
        if total < SUMS[0] - 0.5:
            raise Wrong(f"The {finger} finger is not closed: {total:.0f} degrees instead of {SUMS[0]:.0f}.")
        if total > SUMS[1] + 0.5:
            raise Wrong(f"The {finger} finger is cramped: {total:.0f} degrees. Less will do.")
    away = min(abs(measures.pulp_to_bodies(hand, state.skin, 1, (body,))) for body in PULP)
    if away > TOUCH + 0.0005:
        raise Wrong(f"The fingers are closed. The pulp of the thumb is {1e3 * away:.0f} mm from their middle phalanges; bring it nearer.")
    return "A fist. Watch how little contraction it takes: nothing is squeezed yet."


@EXERCISES.register("runaway")
def runaway(wrist_end_deg: Any, lost_percent: Any) -> str:
    """Flexion of the free wrist under the grip in degrees, and the force that it costs in percent."""
    held, free = motion(GRIP, GRIP_SECONDS, hold=("wrist",)), motion(GRIP, GRIP_SECONDS)
    end = float(np.rad2deg(free.angle[-1, WRIST[0]]))
    both = [row("FDP3"), row("FDS3")]
    lost = float(100.0 * (1.0 - free.force[-1, both].sum() / held.force[-1, both].sum()))
    value = number(wrist_end_deg, "The angle of the wrist", "degrees")
    if abs(np.rad2deg(value) - end) < 1.0 and abs(value - end) > 1.0:
        raise Wrong(f"{value:.3g} is in radians. Give degrees.")
    if abs(value - 15.0 - end) < 1.0 or abs(value + end + 15.0) < 1.0:
        raise Wrong("That is how far it has turned. Where does it end, counted from the straight wrist?")
    if abs(value - end) > 1.0:
        raise Wrong(f"The wrist does not end at {value:.1f} degrees. All eight flexors at {GRIP['FDP2']:g}, 3 s, nothing held.")
    part = number(lost_percent, "The loss", "percent")
    if abs(part + lost - 100.0) < 2.0 and abs(part - lost) > 2.0:
        raise Wrong("That is what is left. How much is lost?")
    if abs(part - lost) > 2.0:
        raise Wrong(f"The force lost is not {part:.1f} percent. Add the forces of FDP3 and FDS3 in the last frame, free over held.")
    return f"Nobody holds the wrist, and {lost:.0f} percent of the grip are gone: the fingers have pulled their own fibres short."


@EXERCISES.register("brace")
def brace(own: Callable[..., Any]) -> str:
    """A function (clip, frame) that gives the contractions of ECRB and ECU."""
    if not callable(own):
        raise Wrong("Hand over the function itself, without brackets: brace, not brace(...).")
    for grip, frame in PROBES:
        clip = motion(grip, GRIP_SECONDS, hold=("wrist",))
        theirs = own(clip, frame)
        if is_open(theirs):
            raise Open
        compare_brace(np.asarray(theirs, dtype=np.float64), balancing(clip, frame))
    return "Your lines balance both axes, in three grips."


def compare_brace(theirs: Array, right: Array) -> None:
    """Raise ``Wrong`` with the likely slip."""
    if theirs.shape != right.shape:
        raise Wrong(f"The result has shape {theirs.shape}; give two contractions, of ECRB and of ECU.")
    if np.abs(theirs - right).max() < 1e-6:
        return
    slips = {
        "The sign is the other way round: the extensors have to give the opposite of the torque.": -right,
        "The order is ECRB, then ECU.": right[::-1],
    }
    for text, values in slips.items():
        if np.abs(theirs - values).max() < 1e-6:
            raise Wrong(text)
    text = f"{theirs[0]:.3f} and {theirs[1]:.3f} leave a torque; {right[0]:.3f} and {right[1]:.3f} would not"
    raise Wrong(f"For one of the grips {text}. Is a row of A an axis, and is each lever arm multiplied by the force of its muscle?")


@EXERCISES.register("mend")
def mend(mended: Any) -> str:
    """Contractions of ECRB and ECU with which the wrist stays under the grip."""
    values = contractions(mended, ("ECRB", "ECU"), "the two extensors")
    off = deflection(motion(GRIP | values, GRIP_SECONDS))[-1]
    if abs(off[0]) > STAYS:
        raise Wrong(f"The wrist ends {abs(off[0]):.0f} degrees too far in {'flexion' if off[0] > 0 else 'extension'}.")
    if abs(off[1]) > STAYS:
        raise Wrong(f"Flexion is right. The wrist ends {abs(off[1]):.0f} degrees too far to the {'radial' if off[1] > 0 else 'ulnar'} side.")
    return "The wrist stays, and the grip keeps its force. Both extensors have to work, or it tilts to one side."


@EXERCISES.register("between")
def between(natural_value: Any, own_value: Any) -> str:
    """Values at 1.25 s of the natural spline and of the monotone cubic."""
    from scipy.interpolate import CubicSpline

    natural = float(CubicSpline([0, 0.5, 1, 1.5], [0, 1, 0.2, 0.2], bc_type="natural")(1.25))
    own = float(keyframes({"FDP3": [(0, 0), (0.5, 1), (1, 0.2), (1.5, 0.2)]}).at(1.25)[row("FDP3")])
    first, second = number(natural_value, "The value of the spline", "parts of 1"), number(own_value, "The other value", "parts of 1")
    if abs(first - own) < 2e-3 and abs(second - natural) < 2e-3:
        raise Wrong("These two are swapped: first the natural spline.")
    if abs(first - natural) > 2e-3:
        raise Wrong(f"The natural spline does not go through {first:.4g} at 1.25 s.")
    if abs(second - own) > 2e-3:
        raise Wrong(f"The curve of this laboratory does not go through {second:.4g} at 1.25 s.")
    return f"Between two keys of {own:g} the natural spline lets the muscle drop to {natural:.3f}; elsewhere it even passes 1."


@EXERCISES.register("keys")
def keys(wrist_keys: Any) -> str:
    """Key frames of ECRB and ECU with which the free wrist stays during the whole grip."""
    hand = reference()
    if not isinstance(wrist_keys, Mapping):
        raise Wrong(f"Give a dictionary of key frames like {{'ECRB': [(0, 0), (1.5, 0.1)], ...}}; this is {type(wrist_keys).__name__}.")
    named = {hand.muscles[one(key, hand.muscles, "muscle")].abbreviation: track for key, track in wrist_keys.items()}
    if not set(named) <= {"ECRB", "ECU"}:
        raise Wrong(f"Only ECRB and ECU, please; {listing(set(named) - {'ECRB', 'ECU'})} stays as it is.")
    try:
        tracks = keyframes(CLOSING | named)
    except (ValueError, TypeError) as error:
        raise Wrong(f"{str(error)[:1].upper()}{str(error)[1:]}.") from None
    clip = motion(tracks, OPEN_AGAIN)
    off = deflection(clip)
    worst = np.abs(off).max(axis=0)
    if worst.max() > NEVER:
        k = int(worst.argmax())
        frame = int(np.abs(off[:, k]).argmax())
        side = (("extension", "flexion"), ("ulnar deviation", "radial deviation"))[k][int(off[frame, k] > 0.0)]
        raise Wrong(f"At {clip.time[frame]:.1f} s the wrist is {worst[k]:.0f} degrees off, in {side}.")
    closed = finger_sums(clip.states[int(np.searchsorted(clip.time, CLOSED_AT - 1e-9))]).min()
    return f"The wrist never leaves its place by more than {worst.max():.1f} degrees, while every finger closes to {closed:.0f} or more."


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
        raise Wrong(f"{listing(innocent & {'FCR', 'FCU'})} runs at the edge of the wrist, outside the tunnel: it may well have a large arm there.")
    if innocent:
        raise Wrong(f"{listing(innocent)} fits a tendon in the middle of the wrist: a large arm for flexion, a small one to the side.")
    if missed:
        raise Wrong("There is another tendon of the tunnel whose sideways arm is larger than its flexion arm.")
    return f"{listing(named)}: the lines for flexion and for the side stand in each other's place. The default reading has them turned back."
