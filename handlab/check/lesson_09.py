"""Checks of lesson 09, "What the skin adds". What is right is measured on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.check.answers import number, reference
from handlab.check.lesson import Exercises
from handlab.check.own_lines import compare, values
from handlab.check.verdict import Open, Wrong, is_open
from handlab.simulation.play import simulate
from handlab.simulation.skeleton import pose
from handlab.simulation.soft_skin import soft_skin
from handlab.simulation.state import State
from handlab.studies import knuckle, measures
from handlab.studies.shaking import FRAME

EXERCISES = Exercises("09")

JOINT, BEND_DEG, FIST_DEG = "pip2", 90.0, 80.0
WRIST_GIRTH = 0.05
MUSCLE = "DI1"
POINTS = 0.15  # percentage points by which a measured percentage may be off
LEAST_LINE, MOST_LINE = 5.0, 80.0  # mm: more is no line across a finger's joint


@cache
def state(name: str) -> State:
    """The postures of the lesson."""
    hand = reference()
    angles = dict.fromkeys(hand.moving_names, 0.0)
    if name == "bent":
        angles[f"{JOINT}.flexion_extension"] = float(np.deg2rad(BEND_DEG))
    elif name == "fist":
        angles |= {f"{joint}{k}.flexion_extension": float(np.deg2rad(FIST_DEG)) for joint in ("mcp", "pip") for k in (2, 3, 4, 5)}
    elif name == "pinch":
        return simulate(hand, "key-pinch", hold=["wrist"]).states[-1]
    return pose(hand, angles)


@cache
def skin(way: str, name: str, *, keeping: bool = True) -> Array:
    """Points of the skin in a posture; ``keeping``: whether springs keep the volume of the hand."""
    network = None if keeping else replace(soft_skin(reference()), compliance=float("inf"))
    return knuckle.worn(reference(), state(name), way, network=network)


def whole(way: str, name: str, *, keeping: bool = True) -> float:
    """Volume of the hand in percent of the stored one."""
    hand = reference()
    return 100.0 * knuckle.signed_volume(skin(way, name, keeping=keeping), hand.skin.faces) / hand.skin.volume


@cache
def change(way: str, joint: str, name: str, girth: float = knuckle.GIRTH) -> float:
    """By how many percent the piece at a joint grows from the flat hand to a posture."""
    part = knuckle.piece(reference(), joint, girth=girth)
    before, after = (knuckle.piece_volume(skin(way, one), part) for one in ("flat", name))
    return 100.0 * (after / before - 1.0)


def longer(way: str, side: str = "dorsal") -> float:
    """By how many percent the ink gets longer from flat to bent."""
    line = knuckle.ink(reference(), JOINT, side)
    before, after = (knuckle.ink_length(skin(way, one), line) for one in ("flat", "bent"))
    return 100.0 * (after / before - 1.0)


@cache
def rise(way: str) -> float:
    """How far the skin rises at most when the muscle contracts, metres."""
    hand = reference()
    row = hand.muscle_names.index(hand.muscles[MUSCLE].name)
    contraction = np.zeros((2, len(hand.muscles)))
    contraction[1, row] = 1.0
    before, after = (knuckle.worn(hand, state("pinch"), way, contraction=one) for one in contraction)
    return float(((after - before) * measures.vertex_normals(before, hand.skin.faces)).sum(axis=1).max())


def percent(answer: Any, right: float, what: str, others: dict[str, float] | None = None) -> None:
    """Raise ``Wrong`` unless a percentage is right; ``others`` are numbers that come of a slip, by the sentence that helps."""
    given = number(answer, what, "percent")
    if abs(given - right) <= POINTS:
        return
    if abs(100.0 * given - right) <= POINTS:
        raise Wrong(f"{what}: this is a part of one. Give percent.")
    for text, slip in (others or {}).items():
        if abs(given - slip) <= POINTS:
            raise Wrong(f"{what}: {text}")
    raise Wrong(f"{what} is not {given:.4g} percent.")


@EXERCISES.register("mine", guess=True)
def mine(length_mm: Any) -> str:
    """Length of the student's own line in the bent finger, millimetres."""
    given = number(length_mm, "The length", "millimetres")
    if not LEAST_LINE <= given <= MOST_LINE:
        raise Wrong(f"{given:g} mm: the line was 20 mm long. Give its length in the bent finger in millimetres.")
    gain = round(100.0 * (given / 20.0 - 1.0))
    told = f"{abs(gain)} percent {'longer' if gain > 0 else 'shorter'}" if gain else "as long as before"
    return f"Your skin is {told} there. Compare with the model below."


@EXERCISES.register("volume")
def volume(own: Callable[..., Any]) -> str:
    """A function (points, faces) that returns the volume inside."""
    hand = reference()
    for mesh in (hand.skin, hand.bones["capitate"], hand.bones["distal_phalanx_2"]):
        points = mesh.points + np.array([0.05, -0.02, 0.03])  # somewhere else, so that the origin does not matter
        right = knuckle.signed_volume(points, mesh.faces)
        a, b, c = (points[mesh.faces[:, k]] for k in range(3))
        each = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
        slips = {
            "The sixth is missing: a pyramid has a sixth of a . (b x c).": np.asarray(6.0 * right),
            "That is twice as much: a sixth, not a third.": np.asarray(2.0 * right),
            "The sign is turned: corners run counter-clockwise seen from outside; keep the order a, b, c.": np.asarray(-right),
            "The pyramids that count as negative have to be taken off: leave out abs.": np.asarray(np.abs(each).sum()),
        }
        theirs = values(own, points, mesh.faces)
        if theirs.shape != ():
            raise Wrong(f"Hand back one number, the sum; this has shape {theirs.shape}.")
        compare(theirs, np.asarray(right), slips, "The volume", "m^3")
    return f"The hand of this laboratory, with its piece of forearm, has {1e6 * hand.skin.volume:.0f} cubic centimetres."


@EXERCISES.register("loss")
def loss(linear_percent: Any, blend_percent: Any) -> str:
    """Percent of its volume that the piece loses from flat to bent, with averaged matrices and with averaged turns."""
    if is_open([linear_percent, blend_percent]):
        raise Open
    right = {way: -change(way, JOINT, "bent") for way in ("linear", "blend")}
    for answer, way in ((linear_percent, "linear"), (blend_percent, "blend")):
        other = "blend" if way == "linear" else "linear"
        slips = {
            "that is the change; a loss counts positive.": -right[way],
            "that is what is left; give what is lost.": 100.0 - right[way],
            "the two are swapped.": right[other],
            "that is with springs.": -change("springs", JOINT, "bent"),
        }
        percent(answer, right[way], f"The loss with {way!r}", slips)
    return f"{right['linear']:.0f} and {right['blend']:.0f} percent: no flesh can vanish like that, it would have to go somewhere."


@EXERCISES.register("springs")
def springs(piece_percent: Any, whole_blend: Any, whole_springs: Any) -> str:
    """Loss of the piece with springs; volume of the fist, blended and with springs, in percent of the stored hand."""
    right = -change("springs", JOINT, "bent")
    percent(piece_percent, right, "The loss of the piece", {"that is the change; a loss counts positive.": -right})
    for answer, way in ((whole_blend, "blend"), (whole_springs, "springs")):
        found = whole(way, "fist")
        slips = {
            "that is what is lost; give what is left.": 100.0 - found,
            "the two are swapped.": whole("springs" if way == "blend" else "blend", "fist"),
        }
        percent(answer, found, f"The whole fist with {way!r}", slips)
    blend = -change("blend", JOINT, "bent")
    verdict = "more than blending" if right > blend + 1.0 else "less than blending" if right < blend - 1.0 else "about as much as blending"
    return f"The whole is kept, but this piece loses {right:.0f} percent, {verdict} ({blend:.0f}). Where has that volume gone?"


@EXERCISES.register("broken")
def broken(left_percent: Any) -> str:
    """Volume of the fist with springs that do not keep it."""
    right = whole("springs", "fist", keeping=False)
    slips = {
        "that is the fist of the whole net; give worn(...) the broken one with network=broken.": whole("springs", "fist"),
        "that is what is lost; give what is left.": 100.0 - right,
        "that is the blended fist.": whole("blend", "fist"),
    }
    percent(left_percent, right, "The volume of the broken fist", slips)
    return f"{100.0 - right:.1f} percent are missing ({100.0 - whole('blend', 'fist'):.1f} blended): springs alone keep no volume."


@EXERCISES.register("wrist")
def wrist(springs_percent: Any, blend_percent: Any) -> str:
    """By how many percent the piece at the wrist grows from flat to fist, with springs and blended."""
    right = {way: change(way, "wrist", "fist", WRIST_GIRTH) for way in ("springs", "blend")}
    for answer, way in ((springs_percent, "springs"), (blend_percent, "blend")):
        other = "blend" if way == "springs" else "springs"
        slips = {"the two are swapped.": right[other], "that is the volume in percent; give how much it grows.": 100.0 + right[way]}
        percent(answer, right[way], f"The growth with {way!r}", slips if abs(right["springs"] - right["blend"]) > 2 * POINTS else None)
    return (
        f"{right['springs']:+.1f} percent at a joint that does not move. The sum is right, and its parts are not: that is where it hides."
    )


@EXERCISES.register("ink")
def ink(blend_percent: Any, springs_percent: Any) -> str:
    """By how many percent the line on the back gets longer, blended and with springs."""
    for answer, way in ((blend_percent, "blend"), (springs_percent, "springs")):
        right = longer(way)
        slips = {
            "that is the length in percent; give how much is added.": 100.0 + right,
            "the two are swapped.": longer("springs" if way == "blend" else "blend"),
            "that is the line on the palm side.": longer(way, "palmar"),
        }
        percent(answer, right, f"The stretch with {way!r}", slips)
    return f"{longer('blend'):.0f} percent and {longer('springs'):.0f}. Put the number of your own finger beside them."


@EXERCISES.register("slide")
def slide(proximal_mm: Any, distal_mm: Any) -> str:
    """How far the ends of the ink with springs are from where blending has them, millimetres."""
    line = knuckle.ink(reference(), JOINT, "dorsal")
    ends = [knuckle.ink_points(skin(way, "bent"), line)[[0, -1]] for way in ("blend", "springs")]
    right = 1e3 * np.linalg.norm(ends[1] - ends[0], axis=1)
    for answer, k, what in ((proximal_mm, 0, "The proximal end"), (distal_mm, 1, "The distal end")):
        given = number(answer, what, "millimetres")
        if abs(given - right[k]) <= 0.05:
            continue
        if abs(1e3 * given - right[k]) <= 0.05:
            raise Wrong(f"{what}: this is in metres. Give millimetres.")
        if abs(given - right[1 - k]) <= 0.05:
            raise Wrong("The two are swapped: first the proximal end.")
        raise Wrong(f"{what} is not {given:.3g} mm from its blended place. Take the length of the difference of two points, in 'bent'.")
    return f"{right[0]:.1f} and {right[1]:.1f} mm: skin from beside the joint is drawn in, so less of it has to stretch."


@EXERCISES.register("bulge")
def bulge(muscles_mm: Any, springs_mm: Any) -> str:
    """How far the skin rises when the first dorsal interosseus contracts, with muscles and with springs alone, millimetres."""
    if is_open([muscles_mm, springs_mm]):
        raise Open
    right = 1e3 * rise("springs and muscles")
    given, plain = number(muscles_mm, "The rise", "millimetres"), number(springs_mm, "The rise with plain springs", "millimetres")
    if abs(1e3 * given - right) <= 0.05:
        raise Wrong("The rise is in metres here. Give millimetres.")
    if abs(given - right) > 0.05:
        raise Wrong(f"The skin does not rise by {given:.3g} mm. Same posture, {MUSCLE} at 0 and at 1; along the normal of the skin before.")
    if abs(plain - 1e3 * rise("springs")) > 0.05:
        raise Wrong(f"With plain 'springs' it is not {plain:.3g} mm. Do they know anything of muscles?")
    return f"{right:.1f} mm, while no bone moves. Plain springs have nothing below them but bone."


@EXERCISES.register("count")
def count(forces: Any) -> str:
    """Spring forces in a second of film."""
    network = soft_skin(reference())
    edges, nodes, steps = len(network.stiffness), len(network.mass), network.substeps(FRAME)
    right = round(steps / FRAME) * (edges + 2 * nodes)
    slips = {
        "the springs that tie each node down are missing, two for each.": round(steps / FRAME) * edges,
        "each node has two springs to what is below.": round(steps / FRAME) * (edges + nodes),
        "that is for one picture.": steps * (edges + 2 * nodes),
        "that is one step for each picture.": round(1.0 / FRAME) * (edges + 2 * nodes),
    }
    given = number(forces, "The number of forces", "forces in a second")
    if abs(given - right) > 0.005 * right:
        for text, slip in slips.items():
            if abs(given - slip) <= 0.005 * slip:
                raise Wrong(f"The number of forces: {text}")
        raise Wrong(f"It is not {given:.3g}. Pictures in a second, times steps in a picture, times springs.")
    return f"{right / 1e6:.0f} million in a second; blending moves {round(1.0 / FRAME) * nodes / 1e3:.0f} thousand points."
