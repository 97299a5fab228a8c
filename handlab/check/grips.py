"""Checks of grips, for lesson 06: a fist of six contractions, a wrist that its own fingers pull away, and the brace that keeps it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.check.answers import listing, number, one, reference
from handlab.check.trials import (
    CLOSED_AT,
    CLOSING,
    GRIP,
    GRIP_SECONDS,
    OPEN_AGAIN,
    PULP,
    WRIST,
    balancing,
    deflection,
    finger_sums,
    motion,
    row,
)
from handlab.check.verdict import Open, Wrong, is_open
from handlab.simulation.keyframes import keyframes
from handlab.simulation.skeleton import contraction_of
from handlab.studies import measures

SUMS = (195.0, 240.0)  # degrees of a closed finger
TOUCH = 0.006  # m
STAYS, NEVER = 3.0, 5.0  # degrees that the wrist may be off at the end, and ever
SIX = ("FDP2", "FDP3", "FDP4", "FDP5", "FPL", "OPP")
PROBES = ((GRIP, 30), (GRIP, -1), ({"FDP2": 0.3, "FDP3": 0.1, "FPL": 0.4}, -1))


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


def mend(mended: Any) -> str:
    """Contractions of ECRB and ECU with which the wrist stays under the grip."""
    values = contractions(mended, ("ECRB", "ECU"), "the two extensors")
    off = deflection(motion(GRIP | values, GRIP_SECONDS))[-1]
    if abs(off[0]) > STAYS:
        raise Wrong(f"The wrist ends {abs(off[0]):.0f} degrees too far in {'flexion' if off[0] > 0 else 'extension'}.")
    if abs(off[1]) > STAYS:
        raise Wrong(
            f"Flexion is right. The wrist ends {abs(off[1]):.0f} degrees too far to the {'radial' if off[1] > 0 else 'ulnar'} side."
        )
    return "The wrist stays, and the grip keeps its force. Both extensors have to work, or it tilts to one side."


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
