"""The thumb rows that Table 1 lacks, measured again on the bones."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import handlab
from handlab.simulation.kinematics import posed_bone

sys.path.insert(0, str(Path(__file__).parents[2]))  # tools/ is no part of the package

from tools import thenar_rows


@pytest.fixture(scope="module")
def hand():
    return handlab.load_hand()


@pytest.fixture(scope="module")
def bones(hand):
    return thenar_rows.Bones(hand)


def test_the_table_is_what_the_bones_say(hand):
    stored, made = json.loads(thenar_rows.FILE.read_text(encoding="utf-8")), thenar_rows.table(hand)
    arms = thenar_rows.lever_arms(hand)
    for row in stored["rows"]:
        assert row["used_mm"] == pytest.approx(1e3 * arms[row["muscle"]], abs=0.051)  # one decimal, rounded on any platform
    for content in (stored, made):
        for row in content["rows"]:
            del row["used_mm"]
    assert stored == made


def test_a_line_in_the_plane_of_flexion_has_its_distance_from_the_axis_as_lever_arm(bones):
    """Analytic: origin far proximal, line parallel to the thumb, 7 mm palmar of the axis; dorsal of it, it extends."""
    for height in (0.007, -0.004):
        insertion = bones.joint + 0.002 * bones.distal + height * bones.palmar
        origin = insertion - 0.05 * bones.distal
        assert bones.lever_arm([origin], insertion) == pytest.approx(height, abs=1e-6)
        assert bones.lever_arm([origin + 0.01 * bones.radial, origin], insertion) == pytest.approx(
            height * (1.0 + 5.0 / np.hypot(5.0, 1.0)) / 2.0, abs=1e-6
        )


def test_the_lever_arm_is_the_moment_of_a_unit_pull_about_the_axis(hand, bones):
    """Virtual work: -dL/dangle equals axis . (r x u)."""
    insertion, origin = bones.sesamoid(-1.0), bones.edge("capitate", thenar_rows.DISTAL_PALMAR)
    pull = (origin - insertion) / np.linalg.norm(origin - insertion)
    assert bones.lever_arm([origin], insertion) == pytest.approx(bones.axis @ np.cross(insertion - bones.joint, pull), abs=1e-7)


def test_the_sesamoids_ride_on_the_head_and_lie_6_to_8_mm_palmar_of_the_axis(hand, bones):
    head = posed_bone(hand, "metacarpal_1", bones.angle)
    for side in (1.0, -1.0):
        beyond = bones.sesamoid(side) - bones.joint
        assert 0.006 < beyond @ bones.palmar < 0.008
        assert 0.001 < side * beyond @ bones.radial < 0.004
        assert abs(beyond @ bones.distal) < thenar_rows.SESAMOID_LEVEL
        assert 0.001 < np.linalg.norm(head - bones.sesamoid(side), axis=1).min() < 0.0035


def test_the_mirrored_hand_has_the_same_lever_arms(hand):
    left = thenar_rows.lever_arms(handlab.load_hand(side="left"))
    for muscle, arm in thenar_rows.lever_arms(hand).items():
        assert left[muscle] == pytest.approx(arm, abs=1e-9)
