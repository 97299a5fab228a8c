"""Where the joints' axes send the digits: flexed fingers converge on the scaphoid tubercle, the thumb turns about two skew axes."""

from itertools import pairwise

import numpy as np
import pytest
import pyvista as pv

from handlab.simulation.kinematics import posed_axes, posed_bone
from handlab.simulation.skeleton import pose

FINGERS = {2: "index", 3: "middle", 4: "ring", 5: "little"}
FLEXED = {"mcp": 80.0, "pip": 100.0, "dip": 60.0}  # degrees: the fingertip is at the palm
NEAR = 0.015


@pytest.fixture(scope="module")
def tubercle(hand):
    """The most distal, palmar and radial point of the scaphoid, wrist straight."""
    points = posed_bone(hand, "scaphoid", hand.zero)
    return points[np.argmax(points @ [1.0, 1.0, 1.0])]


def pointing(hand, finger, degrees):
    """PIP centre and tip of the distal phalanx of one flexed finger, wrist straight."""
    wanted = {f"{joint}{finger}.flexion_extension": np.deg2rad(value) for joint, value in degrees.items()}
    angle = pose(hand, {"wrist.flexion_extension": 0.0, "wrist.deviation": 0.0, **wanted}).angle
    _, anchor = posed_axes(hand, angle)
    pip, dip = (anchor[hand.dof_names.index(f"{joint}{finger}.flexion_extension")] for joint in ("pip", "dip"))
    bone = posed_bone(hand, f"distal_phalanx_{finger}", angle)
    return pip, bone[np.argmax(np.linalg.norm(bone - dip, axis=1))]


def missed_by(line, target):
    """Distance from a target to the line through two points, and how far beyond the second it is passed."""
    start, end = line
    along = (end - start) / np.linalg.norm(end - start)
    beyond = target - end
    return float(np.linalg.norm(beyond - along * (beyond @ along))), float(beyond @ along)


def test_the_tubercle_of_the_scaphoid_lies_palmar_and_radial_at_the_wrist(tubercle):
    assert -0.01 < tubercle[0] < 0.01 and 0.006 < tubercle[1] < 0.016 and 0.004 < tubercle[2] < 0.014


@pytest.mark.parametrize("finger", FINGERS, ids=FINGERS.values())
def test_each_finger_flexed_alone_points_at_the_scaphoid_tubercle(hand, tubercle, finger):
    """The line from PIP to tip, seen from the palm (the plane of distal and radial), passes within 15 mm, on the far side of the tip."""
    from_the_palm = [0, 2]
    distance, beyond = missed_by([point[from_the_palm] for point in pointing(hand, finger, FLEXED)], tubercle[from_the_palm])
    assert distance < NEAR
    assert 0.02 < beyond < 0.06


@pytest.mark.parametrize("finger", FINGERS, ids=FINGERS.values())
def test_the_tip_of_a_flexed_finger_is_at_the_palm_and_points_back(hand, finger):
    pip, tip = pointing(hand, finger, FLEXED)
    assert tip[0] < pip[0] - 0.008  # back towards the wrist
    assert abs(tip[1]) < 0.03  # at the height of the palm


def test_the_fingers_flexed_together_do_not_fan_out(hand):
    """Neighbouring tips keep 8 to 22 mm between them: they neither cross nor spread as the straight fingers do."""
    tips = [pointing(hand, finger, FLEXED)[1] for finger in FINGERS]
    for one, other in pairwise(tips):
        assert 0.008 < one[2] - other[2] < 0.022


def axis_of(hand, name):
    """Unit direction and a point of an axis in the zero posture."""
    axis, anchor = posed_axes(hand, hand.zero)
    row = hand.dof_names.index(f"cmc1.{name}")
    return axis[row], anchor[row]


def inside(hand, bone, axis, anchor):
    """The stretch of an axis inside a bone: points (N, 3), by VTK's signed distance."""
    surface = pv.make_tri_mesh(posed_bone(hand, bone, hand.zero), np.array(hand.bones[bone].faces))
    points = anchor + np.linspace(-0.03, 0.03, 601)[:, None] * axis
    return points[pv.PolyData(points).compute_implicit_distance(surface)["implicit_distance"] < 0.0]


def test_the_thumb_flexes_about_an_axis_through_the_trapezium(hand):
    axis, anchor = axis_of(hand, "flexion_opposition")
    through = inside(hand, "trapezium", axis, anchor)
    assert 0.006 < np.ptp(through @ axis) < 0.020
    assert np.linalg.norm(anchor - through.mean(axis=0)) < 0.004  # it is the bone's middle, not an edge
    assert not len(inside(hand, "metacarpal_1", axis, anchor))


def test_the_thumb_abducts_about_an_axis_through_the_base_of_its_metacarpal(hand):
    axis, anchor = axis_of(hand, "abduction_adduction")
    through = inside(hand, "metacarpal_1", axis, anchor)
    assert 0.006 < np.ptp(through @ axis) < 0.020
    bone = posed_bone(hand, "metacarpal_1", hand.zero)
    _, anchors = posed_axes(hand, hand.zero)
    along = anchors[hand.dof_names.index("mcp1.flexion_extension")] - hand.joints["cmc1"].centre
    share = (through @ along - (bone @ along).min()) / np.ptp(bone @ along)
    assert share.min() > 0.02 and share.max() < 0.30
    assert not len(inside(hand, "trapezium", axis, anchor))


def test_the_two_axes_of_the_thumb_neither_meet_nor_stand_square(hand):
    """Skew lines: distance by the common perpendicular; the angle between them is not 90 degrees."""
    (flexion, one), (abduction, other) = axis_of(hand, "flexion_opposition"), axis_of(hand, "abduction_adduction")
    perpendicular = np.cross(flexion, abduction)
    distance = abs((other - one) @ perpendicular) / np.linalg.norm(perpendicular)
    assert 0.006 < distance < 0.016
    off_square = abs(90.0 - np.rad2deg(np.arccos(abs(flexion @ abduction))))
    assert 4.0 < off_square < 20.0
