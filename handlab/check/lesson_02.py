"""Checks of lesson 02, "Lever arms and torque". What is right is measured on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.check.answers import listing, number, one, reference
from handlab.check.lesson import Exercises
from handlab.check.verdict import Open, Wrong, is_open
from handlab.physics.torque import along, joint_torque, torque_about_axis, torque_printed, torque_printed_of_sum
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import keyframes
from handlab.simulation.play import simulate
from handlab.studies.excursion import potential_excursion, required_excursion
from handlab.studies.torque_parts import Part, torque_parts

EXERCISES = Exercises("02")

# Axis, arm and force: parallel to the axis, oblique, and one that does not turn the joint at all.
PROBES = (
    ((0.0, 0.0, 1.0), (0.0, -0.0111, 0.0), (50.0, 0.0, 0.0)),
    ((0.0, 0.0, 1.0), (0.004, -0.0111, 0.002), (50.0, 3.0, 5.0)),
    ((0.0, 0.6, 0.8), (0.01, 0.002, 0.0), (-3.0, 20.0, 7.0)),
    ((1.0, 0.0, 0.0), (0.01, 0.0, 0.0), (0.0, 4.0, 0.0)),
)
AXIS = (1.0, 0.0, 0.0)
FLEXOR, EXTENSOR = (0.3, 0.2, 0.0), (-0.2, 0.1, 0.0)  # N m, of the exercise "antagonists"
ADDUCTORS = ("PI1", "PI2", "PI3")
OPPONENT_AT = "mcp2.flexion_extension"
PULLEY = 0.0079, 0.0120, 0.015  # m: arm before, arm after, shortening that is left, of the exercise "pulley"
JOINTS = ("mcp2.flexion_extension", "pip2.flexion_extension", "dip2.flexion_extension")
WORK = 2.0 / 3.0  # of F_max l0, the area under the active curve


def returned(own: Any, *arguments: Any) -> Array:
    """What a student's function gives, as an array. Raises ``Open`` for the placeholder and ``Wrong`` for no function."""
    if not callable(own):
        raise Wrong("Hand over the function itself, without brackets behind its name.")
    value = own(*arguments)
    if is_open(value):
        raise Open
    return np.asarray(value, dtype=np.float64)


@EXERCISES.register("own_torque")
def own_torque(torque: Callable[..., Any]) -> str:
    """A function of axis, arm and force that gives the torque about the axis: (2), sound reading."""
    for axis, arm, force in PROBES:
        value = returned(torque, np.array(axis), np.array(arm), np.array(force))
        if value.shape != ():
            raise Wrong(
                f"The torque about an axis is one number; yours has shape {value.shape}. Which part of the vector lies along the axis?"
            )
        right = float(torque_about_axis(axis, arm, force))
        if abs(value - right) < 1e-9:
            continue
        if abs(value + right) < 1e-9:
            raise Wrong("The sign is the other way round: arm x force, in this order.")
        if abs(value - float(torque_printed(axis, arm, force))) < 1e-9:
            raise Wrong(
                "That is the printed reading: the length of arm x force. The bearing of the joint takes up all but the part along the axis."
            )
        if abs(value - np.linalg.norm(arm) * np.linalg.norm(force)) < 1e-9:
            raise Wrong("Arm times force is right only if they are at right angles to each other and to the axis.")
        raise Wrong(
            f"For axis {axis}, arm {arm} and force {force} your function gives {float(value):.4f} N m; the package has {right:.4f}."
        )
    return "Only the part along the axis turns the joint; the rest presses on the bearing."


@EXERCISES.register("antagonists")
def antagonists(printed: Any, sound: Any) -> str:
    """Net torque in N m of a flexor and an extensor, as printed in (2'') and about the axis."""
    summed = np.add(FLEXOR, EXTENSOR)
    right = float(torque_printed_of_sum(AXIS, summed)), float(along(AXIS, summed))
    given = number(printed, "The printed torque", "N m"), number(sound, "The torque about the axis", "N m")
    if abs(given[0] - np.linalg.norm(FLEXOR) - np.linalg.norm(EXTENSOR)) < 1e-3:
        raise Wrong("Add the two vectors first; then take the length.")
    for value, expected, what in zip(given, right, ("printed torque", "torque about the axis"), strict=True):
        if abs(value - expected) > 2e-3:
            raise Wrong(f"{value:g} N m is not the {what}.")
    return f"{right[0] / right[1]:.1f} times too much: what cancels about the axis may add up across it."


@EXERCISES.register("words")
def words(directions: Any, rotation: Any) -> str:
    """Which way each palmar interosseus turns its finger, and the rotation at which APL has its longest arm."""
    hand = reference()
    if not isinstance(directions, Mapping):
        raise Wrong(f"Give a dictionary with the keys {', '.join(ADDUCTORS)}; this is {type(directions).__name__}.")
    given = {hand.muscles[one(key, hand.muscles, "muscle")].abbreviation: value for key, value in directions.items()}
    for muscle in ADDUCTORS:
        if muscle not in given:
            raise Wrong(f"The answer for {muscle} is missing.")
        arm = next(row for row in hand.muscles[muscle].lever_arms if row.dof.endswith(".deviation"))
        right = "radial" if arm.used > 0 else "ulnar"
        if one(given[muscle], ("radial", "ulnar"), "direction") != right:
            raise Wrong(f"{muscle} turns {arm.dof} the other way. Adduction goes towards the middle finger, from whichever side.")
    longest = max(hand.muscles["APL"].lever_arms, key=lambda row: abs(row.used))
    if one(rotation, hand.dof_names, "degree of freedom") != longest.dof:
        raise Wrong(f"{rotation} is not where APL has its longest arm. hand.muscles['APL'] lists all of them.")
    return f"All three adduct. And the 'long abductor of the thumb' has its longest arm at {longest.dof}: names are not directions."


@EXERCISES.register("measure")
def measure(arm_mm: Any) -> str:
    """Lever arm of FDP2 at pip2 in millimetres, from the lengths in two poses."""
    hand = reference()
    right = 1000.0 * hand.lever_arm[hand.muscle_names.index(hand.muscles["FDP2"].name), hand.dof_names.index("pip2.flexion_extension")]
    given = number(arm_mm, "The lever arm", "millimetres")
    slips = {
        f"{given:g} would turn the finger the other way: a flexor shortens in flexion.": -right,
        "That is the arm in metres.": right / 1000.0,
        "Divide by radians, not by degrees.": right * np.pi / 180.0,
        "That is the change of length. Divide it by the angle.": None,
    }
    if abs(given - right) < 0.01:
        return f"{right:.1f} mm, without looking at any table: a lever arm is excursion per radian. So it is measured on people, too."
    for text, slip in slips.items():
        if slip is not None and abs(given - slip) < 1e-3 * abs(slip):
            raise Wrong(text)
    raise Wrong(f"{given:.3g} mm is not what the lengths say. Only pip2 may change between the two poses.")


@EXERCISES.register("all_torques")
def all_torques(torque: Callable[..., Any]) -> str:
    """A function of hand and forces (muscle,) that gives the torques (dof,)."""
    hand = reference()
    random = np.random.default_rng(2)
    for _ in range(3):
        force = random.random(len(hand.muscle_names)) * hand.max_force
        value, right = returned(torque, hand, force), joint_torque(hand.lever_arm, force)
        if value.shape != right.shape:
            raise Wrong(f"The result has shape {value.shape}; give one torque for each of the {len(right)} rotations, shape {right.shape}.")
        if np.abs(value - right).max() < 1e-9:
            continue
        if np.abs(value - joint_torque(np.abs(hand.lever_arm), force)).max() < 1e-9:
            raise Wrong("The signs are lost: an extensor works against a flexor.")
        if np.abs(value + right).max() < 1e-9:
            raise Wrong("The sign is the other way round. Positive arm, positive torque.")
        raise Wrong("Every rotation gets the sum of arm times force over all muscles.")
    return "One matrix for lengths and for torques: that is the principle of virtual work."


@cache
def fist() -> Clip:
    """The clip of the lesson."""
    return simulate(reference(), keyframes("fist"))


@cache
def parts() -> tuple[Part, ...]:
    """All that acts on the knuckle of the index finger at the end of the fist."""
    clip = fist()
    return torque_parts(clip.hand, clip.states[-1], clip.contraction[-1], OPPONENT_AT)


@EXERCISES.register("guess_opponent", guess=True)
def guess_opponent(muscle: Any) -> str:
    """Any muscle."""
    one(muscle, reference().muscles, "muscle")
    return "Now look at the list below."


@EXERCISES.register("opponent")
def opponent(muscle: Any, share: Any) -> str:
    """The muscle that extends mcp2 most in the fist, and its torque over that of FDP2, without sign."""
    hand = reference()
    name = hand.muscles[one(muscle, hand.muscles, "muscle")].abbreviation
    known = {row.abbreviation for row in hand.muscles.values()}
    muscles = {part.name: part.torque for part in parts() if part.name in known}
    right = min(muscles, key=lambda key: muscles[key])
    if name != right:
        raise Wrong(f"{name} is not the muscle that extends mcp2 most. Minus is extension, and joint stiffness is no muscle.")
    expected = abs(muscles[right] / muscles["FDP2"])
    if abs(abs(number(share, "The share", "parts of the torque of FDP2")) - expected) > 0.02:
        raise Wrong(f"{share} is not the torque of {right} divided by that of FDP2, both at mcp2.")
    return f"{right} takes {expected:.0%} of it back: a closed fist is a balance of flexors, extensors and passive structures."


@EXERCISES.register("pulley")
def pulley(torque: Any, before: Any, after: Any) -> str:
    """Factor of the torque, and angles in degrees before and after a pulley has torn."""
    near, far, shortening = PULLEY
    if abs(number(torque, "The factor of the torque", "times") - far / near) > 0.01:
        raise Wrong("The force is the same; the torque grows with the arm.")
    for value, arm, when in ((before, near, "before"), (after, far, "after")):
        right = float(np.rad2deg(shortening / arm))
        given = number(value, f"The angle {when}", "degrees")
        if abs(given - np.deg2rad(right)) < 0.01:
            raise Wrong(f"{given:.3g} is the angle in radians. Give degrees.")
        if abs(given - right) > 0.5:
            raise Wrong(f"{given:.3g} degrees {when}: the angle is the shortening divided by the arm.")
    return "More torque, less motion: the tendon bowstrings and the finger no longer closes. Their product, the work, stays the same."


@cache
def required() -> Array:
    """Excursion (muscle,) in metres that all joints together ask for."""
    hand = reference()
    total: Array = np.sum(list(required_excursion(hand).values()), axis=0)
    return total


@EXERCISES.register("required")
def required_of(own: Callable[..., Any]) -> str:
    """A function of the hand that gives the required excursions (muscle,) in metres."""
    hand = reference()
    value, right = returned(own, hand), required()
    if value.shape != right.shape:
        raise Wrong(f"The result has shape {value.shape}; give one excursion for each of the {len(right)} muscles.")
    if np.abs(value - right).max() < 1e-9:
        return "Arm times range, added up over all joints that the tendon passes."
    signed = (hand.lever_arm @ hand.coupling) @ np.ptp([hand.dofs[name].limits for name in hand.moving_names], axis=1)
    if np.abs(np.abs(value) - np.abs(signed)).max() < 1e-9:
        raise Wrong("Flexion of one joint may cancel extension of another here. Each has to be possible: add sizes, without sign.")
    k = int(np.abs(value - right).argmax())
    raise Wrong(f"{hand.muscle_names[k]} comes out at {1000 * value[k]:.1f} mm; the package has {1000 * right[k]:.1f} mm.")


@EXERCISES.register("too_far")
def too_far(muscles: Any) -> str:
    """Muscles of the thumb and its ball whose joints ask for more than the fibre can give."""
    hand = reference()
    asked = [row for row in hand.muscles.values() if row.region in ("long thumb muscles", "thenar")]
    over = required() > potential_excursion(hand)
    right = {row.abbreviation for row in asked if over[hand.muscle_names.index(row.name)]}
    if isinstance(muscles, str) or not isinstance(muscles, Iterable):
        raise Wrong("Give a set of names in quotes, like {'EPL', 'ADP'}, or set() if there are none.")
    named = {hand.muscles[one(muscle, hand.muscles, "muscle")].abbreviation for muscle in muscles}
    outside = named - {row.abbreviation for row in asked}
    if outside:
        raise Wrong(f"{listing(outside)} {'is' if len(outside) == 1 else 'are'} not of the thumb.")
    if named - right:
        raise Wrong(f"{listing(named - right)} can serve all joints. Look at bar and diamond.")
    if right - named:
        raise Wrong("At least one more bar of the thumb passes its diamond.")
    return f"Only {listing(right)}: it passes the wrist and three joints of the thumb. Bend all of them at once, and the tip weakens."


@EXERCISES.register("work")
def work(strongest: Any, farthest: Any, hardest: Any, joule: Any) -> str:
    """The muscles with the largest force, excursion and work, and that work in joules."""
    hand = reference()
    length = hand.rest_length
    ranked = {"strongest": hand.max_force, "farthest": length, "most work": hand.max_force * length}
    for (what, values), given in zip(ranked.items(), (strongest, farthest, hardest), strict=True):
        right = hand.muscle_names[int(np.argmax(values))]
        if one(given, hand.muscles, "muscle") != right:
            raise Wrong(f"{what}: not {given}. Height is force, width is excursion; the dashed lines are work.")
    right_joule = WORK * float(np.max(ranked["most work"]))
    value = number(joule, "The work", "J")
    if abs(value - right_joule / WORK) < 0.02:
        raise Wrong("The force is not the largest all the way. The area under the active curve is two thirds.")
    if abs(value - right_joule) > 0.02:
        raise Wrong(f"{value:.3g} J is not two thirds of maximum force times rest length, in newtons and metres.")
    return f"{right_joule:.1f} J would lift 100 g of chocolate by {right_joule / 0.981:.0f} metres (at 20 N per percent, an assumption)."


@EXERCISES.register("lumbrical")
def lumbrical(row_mm: Any) -> str:
    """Effective lever arms of LUM1 in millimetres at mcp2, pip2 and dip2 while the tendon of FDP2 is taut."""
    hand = reference()
    arms = {
        name: np.array([hand.lever_arm[hand.muscle_names.index(hand.muscles[name].name), hand.dof_names.index(joint)] for joint in JOINTS])
        for name in ("LUM1", "FDP2")
    }
    right = 1000.0 * (arms["LUM1"] - arms["FDP2"])
    given = np.asarray(row_mm, dtype=np.float64)
    if given.shape != right.shape:
        raise Wrong("Give three numbers in millimetres: mcp2, pip2, dip2.")
    if np.abs(given - 1000.0 * (arms["LUM1"] + arms["FDP2"])).max() < 0.05:
        raise Wrong("The lumbrical pulls the deep flexor's tendon forward, to the fingertip: it takes its arm away.")
    if np.abs(1000.0 * given - right).max() < 0.05:
        raise Wrong("These are metres.")
    if np.abs(given - right).max() > 0.05:
        raise Wrong("Each of the three is the lumbrical's own arm minus that of FDP2 at the same joint.")
    return f"At pip2 its arm is {right[1]:.1f} instead of {1000 * arms['LUM1'][1]:.1f} mm: on a taut tendon it is a far better extensor."


@EXERCISES.register("doubt")
def doubt(muscles: Any) -> str:
    """Muscles of which a printed lever arm has the other sign than the one that is used."""
    hand = reference()
    right = {row.abbreviation for row in hand.muscles.values() if any(arm.printed * arm.used < 0 for arm in row.lever_arms)}
    if isinstance(muscles, str) or not isinstance(muscles, Iterable):
        raise Wrong("Give a set of names in quotes, like {'EPL', 'ADP'}.")
    named = {hand.muscles[one(muscle, hand.muscles, "muscle")].abbreviation for muscle in muscles}
    if named - right:
        raise Wrong(f"{listing(named - right)}: no sign of an arm differs between the two readings. Zero has no sign.")
    if right - named:
        raise Wrong(f"{len(right - named)} more: compare the signs of both matrices, row by row.")
    return f"{listing(right)}: each has its reason in hand.muscles[...], and your own hand is a witness."
