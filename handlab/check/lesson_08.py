"""Checks of lesson 08, "A geometric muscle". What is right is computed or measured on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from handlab.check.answers import number, reference
from handlab.check.lesson import Exercises
from handlab.check.own_lines import compare, values
from handlab.check.swelling import CMC, FPB, arm_ratio, covered_points, painted, rise, swollen
from handlab.check.verdict import Wrong
from handlab.physics.bulge import RECALLED_FACTOR, ellipsoid_volume, volume_bulge
from handlab.simulation.geometric_muscle import geometric_muscles
from handlab.simulation.muscle_below import influenced
from handlab.simulation.muscle_surface import skeletons
from handlab.studies.fibre_arm import fibre_arms, fibre_lengths

EXERCISES = Exercises("08")

MCP = "mcp1.flexion_extension"
CARPUS = ("scaphoid", "trapezium", "trapezoid", "capitate")  # where its heads come from, with the retinaculum between them
DEEP, ABOVE = "opponens_digiti_minimi", "abductor_digiti_minimi"
HALF = np.array([[0.006, 0.004, 0.002], [0.005, 0.003, 0.003]])
RATIOS = np.array([0.6, 0.7, 1.0, 1.2])
RECALLED_AT = 0.7
DEPTHS = np.array([0.001, 0.004, 0.006, 0.009, 0.02])
ARM_OFF_MM = 4.0  # a painted path may pass the axis by so much nearer or farther than the table says
LEAST_SHARE = 0.5  # the part of the muscle's way from carpus to phalanx that a painted one must cover


@EXERCISES.register("ellipsoid")
def ellipsoid(volume: Callable[..., Any], thicker: Callable[..., Any]) -> str:
    """Two functions: volume(half) of half-axes (n, 3), and the factor thicker(q) for both axes across the fibre."""
    right = ellipsoid_volume(HALF)
    slips = {
        "That is the box around it. An ellipsoid fills pi / 6 of its box.": 8.0 * np.prod(HALF, axis=1),
        "Half-axes, not whole axes: without dividing by 8.": right / 8.0,
        "4/3, not 3/4.": right * 9.0 / 16.0,
    }
    compare(values(volume, HALF), right, slips, "volume", "m^3")
    factor = volume_bulge(RATIOS)
    slips = {
        "1 / q is for the height alone. Here width and height grow, both by the same factor.": 1.0 / RATIOS,
        "Shorter must mean thicker, not thinner.": np.sqrt(RATIOS),
        "That is the cube root. The length does not grow: only two axes do.": RATIOS ** (-1.0 / 3.0),
        "That is the remembered formula of the next exercise; it keeps no volume.": 1.0 + RECALLED_FACTOR * (1.0 - RATIOS),
    }
    compare(values(thicker, RATIOS), factor, slips, "thicker", "")
    return f"At {RATIOS[0]:g} of its length a segment is {factor[0] - 1.0:.0%} thicker both ways, and holds what it held."


@EXERCISES.register("recalled")
def recalled(gain_percent: Any, same_at: Any) -> str:
    """Volume gained at q = 0.7 when the thickness grows by 1 + 2 (1 - q), and the other q at which none is gained."""
    gain = number(gain_percent, "The gain", "percent")
    right = 100.0 * (RECALLED_AT * (1.0 + RECALLED_FACTOR * (1.0 - RECALLED_AT)) - 1.0)
    if abs(gain - right) > 0.05:
        if abs(gain - (100.0 * (1.0 + RECALLED_FACTOR * (1.0 - RECALLED_AT)) - 100.0)) < 0.05:
            raise Wrong("That is how much thicker it is. It is also shorter.")
        if abs(gain - 100.0 - right) < 0.05:
            raise Wrong("That is the new volume. How much was gained?")
        if abs(gain - right / 100.0) < 0.0005:
            raise Wrong("That is a fraction. Give percent.")
        raise Wrong(f"Not {gain:g} %. The volume goes as length times thickness, with the width as it was.")
    q = number(same_at, "The other q", "1")
    other = 1.0 / RECALLED_FACTOR
    if abs(q - 1.0) < 1e-6:
        raise Wrong("At q = 1 nothing has changed yet. There is another one.")
    if abs(q - other) > 1e-3:
        raise Wrong(f"At q = {q:g} the volume is {q * (1.0 + RECALLED_FACTOR * (1.0 - q)):.3f} of that at rest. Solve q (3 - 2 q) = 1.")
    return f"It gains up to 12.5 % on the way to q = {other:g}, and loses beyond. Remembered formulas deserve a check."


@EXERCISES.register("fit")
def fit(own: Callable[..., Any]) -> str:
    """A function of depth, skin distance, gap, least and most that gives the thickness."""
    skin_distance, gap, least, most = 0.002, 0.0004, 0.0015, 0.006
    right = np.clip(DEPTHS - skin_distance - gap, least, most)
    slips = {
        "The muscle cannot be thicker than its most.": np.maximum(DEPTHS - skin_distance - gap, least),
        "Where there is little room it still has its least thickness.": np.minimum(DEPTHS - skin_distance - gap, most),
        "The gap to the bone is missing.": np.clip(DEPTHS - skin_distance, least, most),
        "The skin distance is missing.": np.clip(DEPTHS - gap, least, most),
        "Take the distances off before you clamp: they are room that the muscle does not have.": np.clip(DEPTHS, least, most)
        - skin_distance
        - gap,
    }
    theirs = np.concatenate([np.atleast_1d(values(own, d, skin_distance, gap, least, most)) for d in DEPTHS])
    compare(theirs, right, slips, "thickness", "m")
    return "The three rules in one line: as much as there is room for, never more than most, never less than least."


@EXERCISES.register("paint")
def paint(grid: Any) -> str:
    """A grid that flexor pollicis brevis could have."""
    muscle = painted(grid)
    hand, own = reference(), muscle.fitted[0].grid
    if FPB not in muscle.drives[0]:
        raise Wrong(f"It is driven by {' and '.join(muscle.drives[0])}. Let FPB drive it.")
    first, last = own.bones[0], own.bones[-1]
    if max(last, key=lambda name: last[name]) in CARPUS and "proximal_phalanx_1" in first:
        raise Wrong("It begins at the phalanx and ends at the wrist. Paint from the origin to the insertion: the first end stays.")
    if not set(first) & set(CARPUS):
        raise Wrong(f"Its first row rides on {' and '.join(first)}. The muscle begins at the wrist, on the trapezium and its neighbours.")
    if "proximal_phalanx_1" not in last:
        raise Wrong(f"Its last row rides on {' and '.join(last)}. The muscle must cross the MCP joint: it ends on the proximal phalanx.")
    if not own.on_bone[0] or not own.on_bone[1]:
        raise Wrong("Both of its ends are on bone.")
    length = 1e3 * float(fibre_lengths(hand, muscle, own.name, hand.bind).mean())
    shipped = 1e3 * float(fibre_lengths(hand, geometric_muscles(hand), FPB, hand.bind).mean())
    if length < LEAST_SHARE * shipped:
        raise Wrong(f"It is {length:.0f} mm long; from the wrist to the phalanx it is about {shipped:.0f} mm. Paint the whole way.")
    felt, ml = len(influenced(hand, muscle, own.name)), 1e6 * skeletons(muscle)[0].volume[0]
    return f"It fits: {length:.0f} mm long, {ml:.1f} ml in {len(muscle.owner)} ellipsoids, influencing {felt} skin points."


@EXERCISES.register("refused")
def refused(text: Any) -> str:
    """What the package says to a grid whose first two rows are swapped."""
    if not isinstance(text, str):
        raise Wrong(f"Give the text of the message, panel.problem; this is {text!r}.")
    if "crosses itself" not in text:
        raise Wrong("This message is about something else. Swap the first two rows of a grid that was good, and change nothing else.")
    return "Without the check the fibres would run forth and back, and the arms would be nonsense that looks like numbers."


@EXERCISES.register("arm")
def arm(own: Callable[..., Any]) -> str:
    """A function own(length, step) that gives r = -dL/d(angle) at 0 from a function length(angle)."""

    def circle(angle: float) -> float:
        return 0.05 - 0.009 * angle

    def bent(angle: float) -> float:
        return 0.05 - 0.007 * angle + 0.02 * angle**2

    step = 1e-3
    for length, right in ((circle, 0.009), (bent, 0.007)):
        forward = -(length(step) - length(0.0)) / step
        slips = {
            "The sign: a muscle with a positive arm gets SHORTER when the angle grows.": np.asarray(-right),
            "From -step to +step are two steps.": np.asarray(2.0 * right),
            "You have the length lost, not the length lost per angle.": np.asarray(2.0 * right * step),
        }
        theirs = values(own, length, step)
        if abs(float(theirs) - forward) < 1e-9 < abs(forward - right):
            raise Wrong("That looks to one side only, and a bend of the curve gets in. Go a step to either side of 0.")
        near = np.asarray(right) if abs(float(theirs) - right) < 1e-9 else theirs
        compare(near, np.asarray(right), slips, "the arm", "m")
    return "A lever arm without a lever: only the length that is lost. Engineers call this virtual work, surgeons tendon excursion."


@EXERCISES.register("state")
def state(grid: Any, cmc_mm: Any, mcp_mm: Any) -> str:
    """Lever arms of the student's own muscle about both flexion axes, the mean of its fibres, millimetres."""
    muscle, hand = painted(grid), reference()
    said = []
    for rotation, answer in ((CMC, cmc_mm), (MCP, mcp_mm)):
        value = number(answer, f"The arm at {rotation}", "mm")
        right = 1e3 * float(fibre_arms(hand, muscle, muscle.names[0], rotation).mean())
        table = 1e3 * float(hand.lever_arm[hand.muscle_names.index(FPB), hand.dof_names.index(rotation)])
        if abs(value - right) > 0.1:
            for factor, text in (
                (1e-3, "That is in metres. Give millimetres."),
                (-1.0, "The sign is the other way round: it flexes."),
                (np.pi / 180.0, "The angle was in degrees. Turn by radians."),
            ):
                if abs(value - factor * right) < 0.02 * abs(factor * right) + 1e-9:
                    raise Wrong(f"{rotation}: {text}")
            raise Wrong(f"{rotation}: not {value:g} mm for the muscle that you painted. Turn this rotation alone, from hand.bind.")
        if abs(right - table) > ARM_OFF_MM:
            where = "nearer to" if right > table else "farther from"
            raise Wrong(
                f"{rotation}: {right:.1f} mm is right for what you painted, but the table says {table:.1f} mm. Bring its path {where} "
                "the axis: move the origin along the wrist, or change the skin distance."
            )
        said.append(f"{right:.1f} mm (table: {table:.1f})")
    return f"CMC {said[0]}, MCP {said[1]}. A few millimetres of paint are a few millimetres of arm."


@EXERCISES.register("constant")
def constant(times: Any) -> str:
    """How many times the arm of the shipped muscle at one end of the CMC joint's range is that at the other."""
    value = number(times, "The ratio", "1")
    if (0.0 < value < 1.0) and abs(1.0 / value - arm_ratio()) < 0.05 * arm_ratio():
        raise Wrong("Divide the larger one by the smaller one.")
    if abs(value - arm_ratio()) > 0.02 * arm_ratio():
        raise Wrong(f"Not {value:.3g}. Take hand.limits of {CMC}, its lower and its upper end, and the mean of the fibres.")
    return f"{arm_ratio():.1f} times: the table's one number holds in the middle of the range, not at its ends."


@EXERCISES.register("guess", guess=True)
def guess(percent: Any) -> str:
    """By how many percent the belly gets thicker, before it is measured."""
    value = number(percent, "The guess", "percent")
    if not -100.0 <= value <= 1000.0:
        raise Wrong("Give percent: 0 is no change, 100 is twice as thick.")
    return "You will measure it in the next cell."


@EXERCISES.register("belly")
def belly(thicker_percent: Any, volume_percent: Any) -> str:
    """How much thicker the thickest ellipsoid gets at full contraction, and by how much the whole volume changes, percent."""
    still, full = (swollen(c).half for c in (0.0, 1.0))
    right = 100.0 * (full[:, 2].max() / still[:, 2].max() - 1.0)
    gained = 100.0 * (ellipsoid_volume(full).sum() / ellipsoid_volume(still).sum() - 1.0)
    value, volume = number(thicker_percent, "The gain", "percent"), number(volume_percent, "The change of volume", "percent")
    if abs(value - right) > 0.1:
        if abs(value - 100.0 - right) < 0.1:
            raise Wrong("That is the new thickness in percent of the old one. How much was gained?")
        if abs(value - right / 100.0) < 0.001:
            raise Wrong("That is a fraction. Give percent.")
        raise Wrong(f"The thickest ellipsoid does not gain {value:.3g} %. The third half-axis is the thickness; take the largest of each.")
    if abs(volume - gained) > 0.05:
        raise Wrong(f"The volume does not change by {volume:.3g} %. Add up ellipsoid_volume over all of them, before and after.")
    return f"{right:.0f} % thicker, and the volume changes by {abs(gained):.2f} %: what the belly gains the tendinous ends have given."


@EXERCISES.register("layers")
def layers(between: Any, moved_mm: Any) -> str:
    """Skin points above the deep muscle with another one in between, and how far it moves when the one above contracts."""
    covered, points = covered_points(DEEP)
    count = number(between, "The number of skin points", "points")
    if abs(count - covered) > 0.5:
        if abs(count - (points - covered)) < 0.5:
            raise Wrong("Those are the points where it lies on top. How many have another muscle in between?")
        if abs(count - points) < 0.5:
            raise Wrong("Those are all points above it, whatever lies between.")
        raise Wrong(f"Not {count:g}. Compare the owner of the first ellipsoid below each of its points with its own number.")
    if abs(number(moved_mm, "The way", "mm")) > 1e-6:
        raise Wrong(f"{float(moved_mm):.3g} mm is the way of another muscle. Take the centres of {DEEP} alone.")
    return f"{covered} of {points} points have another muscle in between, and it feels nothing of it: layers slide, no spring joins them."


@EXERCISES.register("skin")
def skin(grid: Any, rise_mm: Any) -> str:
    """By how much the student's muscle lifts the skin at full contraction, bones still, at the place where it does most."""
    value = number(rise_mm, "The rise", "mm")
    right = 1e3 * float(rise(painted(grid)).max())
    if abs(value - right) > 0.02 + 0.05 * right:
        if abs(value - right / 1e3) < 1e-5:
            raise Wrong("That is in metres. Give millimetres.")
        raise Wrong(f"Not {value:.3g} mm. Take the way along the normals, contracted less relaxed, and the largest of all skin points.")
    return f"{right:.2f} mm. Small to the eye, but it is your muscle: painted, fitted, swollen, and felt by springs."
