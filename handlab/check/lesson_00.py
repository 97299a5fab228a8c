"""Checks of lesson 00, "Meet the hand". What is right is measured on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.check.answers import VISIBLE_DEG, joints, listing, number, one, reference
from handlab.check.lesson import Exercises
from handlab.check.verdict import Open, Wrong, is_open
from handlab.simulation.mechanics import fibre_lengths
from handlab.simulation.play import simulate
from handlab.simulation.skeleton import pose
from handlab.simulation.state import State

EXERCISES = Exercises("00")

PREDICTED = ("FDP2", "ODM", "LUM1")  # the muscles of the exercise "predict, then name"
PREDICTED_AT = 0.3  # contraction of their sliders
WRIST_FLEXED, WRIST_EXTENDED = 60.0, -40.0  # degrees, of the exercise "fist"
PROBES = ({"pip2.flexion_extension": 1.0}, {"wrist.deviation": -0.4, "mcp5.flexion_extension": 1.2}, {"cmc1.abduction_adduction": 0.1})
DORSAL_INTEROSSEI = ("DI1", "DI2", "DI3", "DI4")


@EXERCISES.register("knuckles")
def knuckles(joint: Any, bone: Any) -> str:
    """The joint behind the knuckle of the middle finger, and the bone that the knuckle is."""
    hand = reference()
    joint, bone = one(joint, hand.joints, "joint"), one(bone, hand.bones, "bone")
    if joint.startswith(("pip", "dip")):
        raise Wrong(f"{joint} lies inside the finger. The big knuckles, where the fingers leave the hand, are nearer to the wrist.")
    if joint != "mcp3":
        raise Wrong(f"{joint} is the {hand.joints[joint].english}. Bend only the middle finger at its root and feel which bump stays.")
    if bone == "proximal_phalanx_3":
        raise Wrong("The proximal phalanx glides down the front of the knuckle. The bump that stays is the bone behind it.")
    if bone != "metacarpal_3":
        raise Wrong(f"{bone} does not meet the joint mcp3. Which bone carries the middle finger?")
    return "The knuckle is the head of metacarpal III: when mcp3 flexes, the phalanx glides off it and leaves it bare."


@EXERCISES.register("radians")
def radians(bent: Any) -> str:
    """A pose with the PIP joint of the index finger at 90 degrees and everything else relaxed."""
    if not isinstance(bent, State):
        raise Wrong(f"Hand over what hl.pose(...) returned; this is {type(bent).__name__}.")
    hand = reference()
    target = pose(hand, {"pip2.flexion_extension": np.pi / 2})
    off = np.rad2deg(bent.angle - target.angle)
    wrong = [name for name, by in zip(hand.dof_names, off, strict=True) if abs(by) > VISIBLE_DEG]
    if wrong == ["pip2.flexion_extension"]:
        at = np.rad2deg(bent.angle[hand.dof_names.index("pip2.flexion_extension")])
        raise Wrong(f"pip2 stands at {at:.1f} degrees. Angles go in as radians: np.deg2rad turns degrees into them.")
    if wrong:
        raise Wrong(f"Only pip2 was to leave the relaxed posture, but {listing(wrong)} differ from what they should be.")
    return "90 degrees are 1.571 rad. SI units inside, degrees only where people read."


@cache
def reachable_deviation(flexion_deg: float) -> float:
    """How far (degrees) the first dorsal interosseus brings the index finger radially while its MCP joint is held at a flexion."""
    hand = reference()
    start = pose(hand, {"mcp2.flexion_extension": np.deg2rad(flexion_deg)})
    clip = simulate(hand, {"DI1": 0.5}, seconds=1.0, hold=["wrist", "mcp2.flexion_extension"], start=start)
    return float(np.rad2deg(clip.angle[-1, hand.dof_names.index("mcp2.deviation")]))


@EXERCISES.register("spread")
def spread(straight: Any, fist: Any) -> str:
    """Radial deviation of the index finger in degrees, with the MCP joint straight and flexed."""
    answers = {0.0: number(straight, "The deviation of the straight finger", "degrees")}
    answers[90.0] = number(fist, "The deviation in the fist", "degrees")
    right = {flexion: reachable_deviation(flexion) for flexion in answers}
    if all(abs(answers[a] - right[b]) < 0.3 for a, b in ((0.0, 90.0), (90.0, 0.0))):
        raise Wrong("These two are the right way round on the paper but not in the answer: the first is the straight finger's.")
    for flexion, value in answers.items():
        where = "with mcp2 straight" if flexion == 0.0 else "with mcp2 at 90 degrees"
        if abs(np.rad2deg(value) - right[flexion]) < 0.3:
            raise Wrong(f"{value:.3g} {where} is the angle in radians. Give degrees.")
        if abs(value - right[flexion]) >= 0.3:
            raise Wrong(f"{value:.1f} degrees {where} is not what a fresh hand does. Hold mcp2.flexion_extension, read mcp2.deviation.")
    loss = 1.0 - right[90.0] / right[0.0]
    return f"Flexion takes {loss:.0%} of the sideways range: over the broad palmar part of the head the collateral ligaments tighten."


@EXERCISES.register("own_length")
def own_length(length: Callable[..., Any]) -> str:
    """A function of hand and angles (dof,) that gives fibre lengths (muscle,)."""
    hand = reference()
    if not callable(length):
        raise Wrong("Hand over the function itself, without brackets: own_length, not own_length(...).")
    for angles in PROBES:
        angle = pose(hand, angles).angle
        theirs = length(hand, angle)
        if is_open(theirs):
            raise Open
        compare_lengths(np.asarray(theirs, dtype=np.float64), angle)
    return "Your lines and the package agree in all 42 muscles to a nanometre, in three postures."


def compare_lengths(theirs: Array, angle: Array) -> None:
    """Raise ``Wrong`` with the likely slip unless fibre lengths (muscle,) are those at ``angle`` (dof,)."""
    hand = reference()
    right = fibre_lengths(hand, angle)
    rest, from_zero = hand.rest_length, hand.lever_arm @ angle
    slips = {
        "The sign is the other way round: with a positive lever arm a muscle gets shorter when the angle grows.": 2.0 * rest - right,
        "These are changes of length. Add the length at rest.": right - rest,
        "Count the angles from the relaxed posture, hand.fibre_rest, not from the straight hand.": rest - from_zero,
        "These are millimetres. The package has metres.": 1000.0 * right,
        "The angles went in as degrees.": rest + np.rad2deg(1.0) * (right - rest),
    }
    if theirs.shape != right.shape:
        raise Wrong(f"The result has shape {theirs.shape}; give one length for each of the {len(right)} muscles, shape {right.shape}.")
    if np.abs(theirs - right).max() < 1e-9:
        return
    for text, values in slips.items():
        if np.abs(theirs - values).max() < 1e-9 * max(1.0, float(np.abs(values).max())):
            raise Wrong(text)
    k = int(np.abs(theirs - right).argmax())
    raise Wrong(f"{hand.muscle_names[k]} comes out at {1000 * theirs[k]:.2f} mm; the package has {1000 * right[k]:.2f} mm.")


@cache
def moved_joints(muscle: str) -> frozenset[str]:
    """Joints whose angle changes visibly when one muscle contracts and the wrist is held, measured on the relaxed hand."""
    hand = reference()
    clip = simulate(hand, {muscle: PREDICTED_AT}, seconds=2.0, hold=["wrist"])
    travel = np.rad2deg(np.abs(clip.angle - clip.angle[0]).max(axis=0))
    return frozenset(name.partition(".")[0] for name, by in zip(hand.dof_names, travel, strict=True) if by > VISIBLE_DEG)


def by_muscle(answer: Any) -> dict[str, set[str]]:
    """Joints that an answer names for each muscle of the exercise."""
    if not isinstance(answer, Mapping):
        raise Wrong(f"Give a dictionary with the keys {', '.join(PREDICTED)}; this is {type(answer).__name__}.")
    full = {one(key, reference().muscles, "muscle"): value for key, value in answer.items()}
    wanted = {muscle: reference().muscles[muscle].name for muscle in PREDICTED}
    missing = [muscle for muscle, name in wanted.items() if name not in full]
    if missing:
        raise Wrong(f"The answer for {listing(missing)} is missing.")
    return {muscle: joints(full[name]) for muscle, name in wanted.items()}


@EXERCISES.register("predict", guess=True)
def predict(prediction: Any) -> str:
    """Any guess that names joints: being wrong here is the point."""
    named = by_muscle(prediction)
    empty = [muscle for muscle, guess in named.items() if not guess]
    if empty:
        raise Wrong(f"Every muscle moves something. Guess at least one joint for {listing(empty)}.")
    return "Now move the sliders, and compare."


@EXERCISES.register("name")
def name(seen: Any) -> str:
    """The joints that each slider moves, with the wrist held."""
    for muscle, named in by_muscle(seen).items():
        moved = moved_joints(muscle)
        if "wrist" in named:
            raise Wrong(f"{muscle}: the wrist is held in this panel, so it cannot move.")
        if named - moved:
            raise Wrong(f"{muscle}: {listing(named - moved)} stayed where it was. Look at the read-out below the sliders.")
        if moved - named:
            more = len(moved - named)
            hint = " Not every joint that moves has a lever arm: some follow another one." if muscle == "ODM" else ""
            raise Wrong(f"{muscle}: {more} more joint{'s' * (more > 1)} moved.{hint}")
    return (
        "FDP2 passes three joints on its way to the fingertip and turns them all. ODM ends on metacarpal V, but CMC 4 follows CMC 5. "
        "LUM1 flexes the MCP joint and extends the two beyond it."
    )


@cache
def fist_ratio(wrist_deg: float) -> float:
    """Fibre length of FDP2 over its rest length with the index finger closed as far as it goes and the wrist at an angle."""
    hand = reference()
    closed = {name: hand.dofs[name].limits[1] for name in (f"{joint}2.flexion_extension" for joint in ("mcp", "pip", "dip"))}
    state = pose(hand, {"wrist.flexion_extension": np.deg2rad(wrist_deg), **closed})
    k = hand.muscle_names.index(hand.muscles["FDP2"].name)
    return float(state.fibre_length[k] / hand.rest_length[k])


@EXERCISES.register("fist")
def fist(flexed: Any, extended: Any, pulls_with_wrist: Any) -> str:
    """Two ratios, and ``"flexed"`` or ``"extended"``."""
    given = {WRIST_FLEXED: number(flexed, "The first ratio", "parts of the rest length")}
    given[WRIST_EXTENDED] = number(extended, "The second ratio", "parts of the rest length")
    for wrist, value in given.items():
        right = fist_ratio(wrist)
        if 5.0 < value < 100.0:
            raise Wrong(f"{value:.3g} looks like millimetres. Divide the fibre length by the rest length.")
        if abs(value - right) > 0.01:
            raise Wrong(
                f"{value:.3f} is not the ratio at {wrist:+.0f} degrees of wrist. Are mcp2, pip2 and dip2 at their upper limits, in radians?"
            )
    choice = one(pulls_with_wrist, ("flexed", "extended"), "wrist position")
    if choice == "flexed":
        raise Wrong("Compare both ratios with 0.6, below which a fibre cannot pull. Then try it: make a fist, and flex your wrist.")
    return (
        f"With the wrist flexed the fibre would have to shorten to {fist_ratio(WRIST_FLEXED):.2f} of its rest length, far below 0.6: it is "
        "actively insufficient, and the grip opens. This is why a strong grip extends the wrist."
    )


@cache
def spreading(reading: str) -> dict[str, str]:
    """Finger joint that each dorsal interosseus spreads most, in a reading of Table 1."""
    hand = reference(reading)
    column = {f"mcp{digit}": hand.dof_names.index(f"mcp{digit}.deviation") for digit in range(2, 6)}
    row = {muscle: hand.muscle_names.index(hand.muscles[muscle].name) for muscle in DORSAL_INTEROSSEI}
    return {muscle: max(column, key=lambda joint: abs(hand.lever_arm[k, column[joint]])) for muscle, k in row.items()}


@EXERCISES.register("doubt")
def doubt(suspect: Any, belongs_to: Any) -> str:
    """The dorsal interosseus whose printed row is at the wrong joint, and the joint where it belongs."""
    hand = reference()
    suspect, belongs = one(suspect, hand.muscles, "muscle"), one(belongs_to, hand.joints, "joint")
    printed, sound = spreading("printed"), spreading("sound")
    (guilty,) = (muscle for muscle in DORSAL_INTEROSSEI if printed[muscle] != sound[muscle])
    if suspect != hand.muscles[guilty].name:
        raise Wrong(f"{hand.muscles[suspect].abbreviation} is where anatomy books have it. Which finger has no muscle to spread it?")
    if belongs == printed[guilty]:
        raise Wrong(f"{belongs} is where the table puts it. The little finger has an abductor of its own, ADM; which finger goes without?")
    if belongs != sound[guilty]:
        raise Wrong(f"{belongs} already has its spreading muscle. Count again: index, middle to both sides, and ...?")
    return f"{guilty} ends on the ring finger. The table moves the little finger with it. The default reading has {belongs}."
