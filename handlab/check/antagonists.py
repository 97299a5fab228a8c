"""A finger of six muscles, for lesson 05: how stiff it is, what its lever arms cannot balance, and a hand with two rests."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.check.answers import listing, number, one, reference
from handlab.check.own_lines import compare, values
from handlab.check.trials import column, row
from handlab.check.verdict import Wrong
from handlab.physics.muscle import active_slope, passive_slope
from handlab.simulation.balance import muscle_ratio, tangent
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.settle import settle
from handlab.simulation.skeleton import contraction_of, pose

FINGER = ("FDP3", "FDS3", "EDC3", "LUM2", "DI2", "DI3")  # in the order of the lesson
NAMES = tuple(f"{joint}3.flexion_extension" for joint in ("mcp", "pip", "dip"))
# Probes of own lines: angles in degrees where no capsule is stretched, and contractions.
PROBES = (
    ((33.0, 41.0, 20.5), (0.2, 0.1, 0.5, 1.0, 0.3, 0.0)),
    ((5.0, 60.0, 30.0), (0.0, 0.0, 1.0, 0.0, 0.0, 0.0)),
    ((60.0, 25.0, 15.0), (1.0, 0.4, 0.0, 0.2, 0.0, 0.7)),
    ((70.0, 90.0, 60.0), (1.0, 1.0, 1.0, 1.0, 1.0, 1.0)),
)
UPRIGHT = (-9.81, 0.0, 0.0)
BEGIN = (-40.0, 20.0)  # degrees of the wrist
NEWTONS = 10.0
WRIST = "wrist.flexion_extension"


def columns() -> list[int]:
    """Of MCP, PIP and DIP flexion of the middle finger, among all angles."""
    return [column(name) for name in NAMES]


def rows() -> list[int]:
    """Of the six muscles of the lesson."""
    return [row(name) for name in FINGER]


def arms() -> Array:
    """R (6, 3) in metres."""
    result: Array = reference().lever_arm[np.ix_(rows(), columns())]
    return result


def at(degrees: Iterable[float]) -> Array:
    """Moving coordinates of the relaxed hand whose middle finger stands at three flexions."""
    hand = reference()
    state = pose(hand, dict(zip(NAMES, np.deg2rad(list(degrees)), strict=True)))
    return state.angle[mechanics(hand).moving]


def everything(contraction: Iterable[float]) -> Array:
    """All contractions (muscle,) from those of the six."""
    return contraction_of(reference(), dict(zip(FINGER, contraction, strict=True)))


def flexions(contraction: Mapping[str, float], hold: tuple[str, ...] = ("wrist",)) -> Array:
    """MCP, PIP and DIP flexion (3,) of the middle finger at rest, degrees."""
    state = settle(reference(), contraction, hold=hold, look_for_others=False).state
    result: Array = np.rad2deg(state.angle[columns()])
    return result


def finger_part(matrix: Array) -> Array:
    """What belongs to the three joints, of all moving coordinates."""
    keep = [reference().moving_names.index(name) for name in NAMES]
    return matrix[keep] if matrix.ndim == 1 else np.diag(matrix)[keep]


def chosen(answer: Any) -> set[str]:
    """Muscles of the finger that an answer names, by abbreviation. Raises ``Wrong``."""
    hand = reference()
    names = [answer] if isinstance(answer, str) else answer
    if not isinstance(names, Iterable):
        raise Wrong("Give abbreviations in quotes, like {'DI2'}.")
    found = {hand.muscles[one(name, hand.muscles, "muscle")].abbreviation for name in names}
    if found - set(FINGER):
        raise Wrong(f"{listing(found - set(FINGER))} is not among the six muscles of this finger.")
    return found


def stiffness_at(degrees: Iterable[float], contraction: Iterable[float]) -> Array:
    """Of MCP, PIP and DIP (3,), each with the others held, N m/rad."""
    hand = reference()
    return finger_part(-tangent(hand, coupled(hand, at(degrees)), everything(contraction)))


def stiffness(own: Callable[..., Any]) -> str:
    """A function (angle (3,) rad, contraction (6,)) that gives the stiffness (3,)."""
    hand = reference()
    mine, joint = rows(), hand.stiffness[columns()]
    for degrees, contraction in PROBES:
        theirs = values(own, np.deg2rad(degrees), np.array(contraction))
        right = stiffness_at(degrees, contraction)
        ratio = muscle_ratio(hand, at(degrees))[mine]
        per_metre = hand.max_force[mine] / hand.rest_length[mine]
        active = (arms() ** 2).T @ (per_metre * np.array(contraction) * active_slope(ratio))
        passive = (arms() ** 2).T @ (per_metre * passive_slope(ratio))
        slips = {
            "The joint's own stiffness is missing.": active + passive,
            "The passive slope is missing: what is stretched resists without contraction.": joint + active,
            "The active slope is missing.": joint + passive,
            "The slope of the active curve has the other sign: it rises up to 1.1.": joint - active + passive,
            "The sign is the other way round: what resists a turn counts as positive.": -(joint + active + passive),
        }
        if theirs.shape == right.shape and np.abs(theirs - right).max() < 1e-6:
            continue  # the package differentiates by steps
        compare(theirs, right, slips, "The stiffness of MCP, PIP and DIP", "N m/rad")
    return "Your lines say how stiff each joint is, in every posture you ask for."


@cache
def added() -> tuple[float, float]:
    """What full contraction of all six adds to the stiffness of the MCP: relaxed and straight finger, N m/rad."""
    relaxed = tuple(np.rad2deg(reference().relaxed[columns()]))
    both = [stiffness_at(posture, np.ones(6)) - stiffness_at(posture, np.zeros(6)) for posture in (relaxed, (0.0, 0.0, 0.0))]
    return float(both[0][0]), float(both[1][0])


def stiffen(relaxed: Any, straight: Any) -> str:
    """Stiffness of the MCP that full contraction adds, in the relaxed and in the straight finger, N m/rad."""
    given = number(relaxed, "The first stiffness", "N m/rad"), number(straight, "The second stiffness", "N m/rad")
    right = added()
    if all(abs(a - b) < 0.003 for a, b in zip(given, right[::-1], strict=True)):
        raise Wrong("These two are swapped: first the relaxed finger.")
    for value, expected, what in zip(given, right, ("relaxed", "straight"), strict=True):
        if abs(value + expected) < 0.003:
            raise Wrong(f"The {what} finger: subtract the other way round, contraction 1 minus contraction 0.")
        if abs(value - expected) > 0.003:
            raise Wrong(f"The {what} finger: {value:.3f} N m/rad is not what contraction adds at the MCP. Take the first of three values.")
    return f"{right[0]:+.2f} N m/rad in the relaxed finger, {right[1]:+.2f} in the straight one: there the fitted curve makes it softer."


def culprits(answer: Any) -> str:
    """The muscles that make the straight knuckle softer when they contract."""
    named, nothing = chosen(answer), stiffness_at((0.0, 0.0, 0.0), np.zeros(6))[0]
    adds = {name: float(stiffness_at((0.0, 0.0, 0.0), one)[0] - nothing) for name, one in zip(FINGER, np.eye(6), strict=True)}
    right = {name for name, value in adds.items() if value < 0.0}
    if named - right:
        raise Wrong(f"{listing(named - right)} adds stiffness: its fibre is shorter than 1.1 of its rest length there.")
    if right - named:
        raise Wrong(f"{len(right - named)} more. Let each contract alone, the others at 0.")
    return f"{listing(right)}: stretched beyond 1.1 of their rest length, where the curve falls."


def newtons(answer: Any) -> str:
    """Forces of EDC3 (3,) in newtons that balance 10 N of FDP3 at MCP, PIP and DIP."""
    given = np.asarray(answer, dtype=np.float64)
    table = arms()
    right = -NEWTONS * table[FINGER.index("FDP3")] / table[FINGER.index("EDC3")]
    if given.shape != (3,):
        raise Wrong("Give three forces: for MCP, PIP and DIP.")
    if np.abs(given + right).max() < 0.1:
        raise Wrong("A muscle only pulls: give forces without sign. It is the lever arms that differ in sign.")
    if np.abs(given - NEWTONS**2 / right).max() < 0.1:
        raise Wrong("The other way round: the longer arm needs the smaller force.")
    for name, value, expected in zip(("MCP", "PIP", "DIP"), given, right, strict=True):
        if abs(value - expected) > 0.1:
            raise Wrong(f"{name}: {value:.1f} N would not cancel {NEWTONS:g} N of FDP3 there. Torque is arm times force.")
    listed = ", ".join(f"{value:.0f}" for value in right)
    return f"{listed} N. Whatever force it has, the knuckle extends or the PIP bends, or both: a claw. Others have to help."


def doubt(left_mnm: Any, helpers: Any) -> str:
    """Torque in mN m that the other five leave of 1 N of EDC3, and which of them pull."""
    from scipy.optimize import nnls

    table, k = arms(), FINGER.index("EDC3")
    others = [i for i in range(len(FINGER)) if i != k]
    force, left = nnls(table[others].T, -table[k])
    right = {FINGER[i] for i, value in zip(others, force, strict=True) if value > 1e-9}
    value = number(left_mnm, "What is left", "mN m")
    if abs(1000.0 * value - 1000.0 * left) < 0.02:
        raise Wrong("That is in N m. Give mN m.")
    if abs(value - 1000.0 * left) > 0.02:
        raise Wrong(f"{value:.3g} mN m is not the least that is left. b is the torque that has to be cancelled: minus the row of EDC3.")
    named = chosen(helpers)
    if named != right:
        raise Wrong(f"Not {listing(named) or 'nobody'}. Which of the five forces are above 0?")
    return (
        f"With {listing(right)} most is cancelled; {1000.0 * left:.2f} mN m per newton remain. In a finger the slips of the extensor "
        "share their load anew in each posture; a table of constant arms does not."
    )


@cache
def ends() -> tuple[float, float]:
    """Where the upright wrist without stiffness rests, from extension and from flexion, degrees."""
    hand = reference().without_passive()
    hold = [name for name in hand.moving_names if name != WRIST]
    found = []
    for begin in BEGIN:
        start = pose(hand, {WRIST: np.deg2rad(begin)})
        rest = settle(hand, {}, start, hold=hold, gravity=UPRIGHT, look_for_others=False)
        found.append(float(np.rad2deg(rest.state.angle[column(WRIST)])))
    return found[0], found[1]


def two(from_extension: Any, from_flexion: Any) -> str:
    """Two rests of the upright wrist in degrees."""
    right = ends()
    given = number(from_extension, "The first angle", "degrees"), number(from_flexion, "The second angle", "degrees")
    if all(abs(a - b) < 0.5 for a, b in zip(given, right[::-1], strict=True)):
        raise Wrong("These two are swapped: first the one that begins in extension.")
    for begin, value, expected in zip(BEGIN, given, right, strict=True):
        if abs(value - expected) > 0.5 and abs(np.rad2deg(value) - expected) < 0.5:
            raise Wrong(f"{value:.3g} is in radians. Give degrees.")
        if abs(value - expected) > 0.5:
            raise Wrong(f"From {begin:+.0f} degrees the loose wrist does not end at {value:.1f}. Is it the loose hand, upright?")
    return f"{right[0]:.1f} and {right[1]:.1f} degrees. Between them it stands like a broomstick; its start decides to which side it falls."
