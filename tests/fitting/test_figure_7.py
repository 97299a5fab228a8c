"""The numbers on the sheet in the manner of the paper's figure 7, whose truth is a person moved about its own joints."""

from functools import cache

import numpy as np
import people
import pytest

from tools import figure7
from tools.people.rig import blended, moved


@cache
def poses():
    return {pose.title: pose for pose in figure7.compared()}


@pytest.mark.parametrize("title", figure7.POSES)
def test_muscles_bring_the_fitted_hand_into_the_pose_of_the_person(title):
    off = np.abs(list(poses()[title].off.values()))
    assert len(off) == 14
    assert 0.0 < off.mean() < 2.5
    assert off.max() < 15.0  # a thumb that has no muscle strong enough to stretch its last joint, for one


@pytest.mark.parametrize("title", figure7.POSES)
def test_contractions_are_those_of_muscles(title):
    contraction = poses()[title].contraction
    assert contraction.min() >= 0.0 and 0.05 < contraction.max() <= 1.0


def test_the_skin_of_the_fitted_hand_lies_on_the_persons_in_every_pose():
    for pose in poses().values():
        off = 1e3 * np.linalg.norm(figure7._over(pose.our_skin, pose.person_skin) - pose.person_skin, axis=1)
        assert 1.0 < np.mean(off) < 6.0, pose.title


def test_a_person_bends_where_it_is_told_to_and_nowhere_else():
    person, hand = people.everyone(people.FRESH)["man_2"], people.hand()
    rest, bent = (figure7.bends(moved(person, hand, turn)[1]) for turn in ({}, {"pip3.flexion_extension": 40.0}))
    for joint in rest:
        assert bent[joint] - rest[joint] == pytest.approx(40.0 if joint == "pip3" else 0.0, abs=3.0), joint
    still = moved(person, hand, {})[0]
    np.testing.assert_allclose(still, person.skin, atol=1e-12)


def test_one_segments_motion_is_kept_as_it_is_and_two_are_blended_half_way():
    frames = np.stack([np.eye(4), np.eye(4)])
    frames[1, :3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    frames[1, :3, 3] = [0.1, 0.0, 0.0]
    point = np.array([[1.0, 0.0, 0.0]] * 3)
    found = blended(point, np.array([[1.0, 0.0], [0.0, 1.0], [0.5, 0.5]]), frames)
    np.testing.assert_allclose(found[:2], [[1.0, 0.0, 0.0], [0.1, 1.0, 0.0]], atol=1e-12)
    # half of a turn by 90 degrees about the point that it leaves in place, (0.05, 0.05)
    centre, half = np.array([0.05, 0.05]), np.sqrt(0.5)
    expected = centre + np.array([[half, -half], [half, half]]) @ (point[0, :2] - centre)
    np.testing.assert_allclose(found[2, :2], expected, atol=1e-12)
