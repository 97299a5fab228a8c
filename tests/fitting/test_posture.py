"""The reference hand in the posture of the photograph, and its marks exactly above the joints."""

import numpy as np
import people
import pytest

from handlab.fitting import marks, posture
from handlab.fitting.alignment import frame_towards
from handlab.fitting.landmarks import NAMES
from handlab.simulation.kinematics import posed_bone
from handlab.simulation.skin import blend


def turned(hand, **degrees):
    angle = np.array(hand.bind)
    for name, value in degrees.items():
        angle[hand.dof_names.index(name.replace("__", "."))] += np.radians(value)
    return angle


def flat(hand, points, view="palmar"):
    frame = frame_towards(np.array([0.0, 1.0 if view == "palmar" else -1.0, 0.0]), np.zeros(3))
    return 1e3 * frame.flat(points)


def test_a_hand_stored_in_another_posture_moves_exactly_as_before():
    hand = people.hand()
    other = posture.rebound(hand, turned(hand, mcp2__deviation=8, mcp5__deviation=-6, cmc1__flexion_opposition=-10))
    goal = turned(hand, mcp2__flexion_extension=40, pip2__flexion_extension=30)
    for name in ("proximal_phalanx_2", "distal_phalanx_2", "metacarpal_1", "hamate"):
        np.testing.assert_allclose(posed_bone(other, name, goal), posed_bone(hand, name, goal), atol=1e-12)
    assert other.skin.faces is hand.skin.faces and other.skin.weights is hand.skin.weights
    assert sum(b.mass for b in other.bodies.values()) == sum(b.mass for b in hand.bodies.values())


def test_with_its_own_angles_a_hand_stays_itself():
    hand = people.hand()
    assert posture.rebound(hand, hand.bind) is hand
    picture = flat(hand, hand.skin.points[[hand.feature_points[name]["palmar"] for name in NAMES]])
    again = posture.as_photographed(hand, "palmar", NAMES, picture)
    assert np.abs(again.skin.points - hand.skin.points).max() < 1e-7


def test_spread_fingers_in_the_picture_spread_the_fingers_of_the_hand():
    hand = people.hand()
    goal = turned(hand, mcp2__deviation=14, mcp5__deviation=-12)
    picture = flat(hand, blend(hand, goal)[[hand.feature_points[name]["palmar"] for name in NAMES]])
    found = posture.as_photographed(hand, "palmar", NAMES, picture)
    change = np.degrees(found.bind - hand.bind)
    assert 5.0 < change[hand.dof_names.index("mcp2.deviation")] < 16.0
    assert -14.0 < change[hand.dof_names.index("mcp5.deviation")] < -4.0
    assert abs(change[hand.dof_names.index("mcp3.deviation")]) < 4.0


def test_followers_keep_following():
    hand = people.hand()
    goal = turned(hand, cmc1__flexion_opposition=-14)
    picture = flat(hand, blend(hand, goal)[[hand.feature_points[name]["palmar"] for name in NAMES]])
    found = posture.as_photographed(hand, "palmar", NAMES, picture)
    moving = [hand.dof_names.index(name) for name in hand.moving_names]
    np.testing.assert_allclose(found.bind - hand.bind, hand.coupling @ (found.bind - hand.bind)[moving], atol=1e-12)
    with pytest.raises(ValueError, match="palmar"):
        posture.as_photographed(hand, "front", NAMES, picture)


@pytest.mark.parametrize("view", ["palmar", "dorsal"])
def test_exact_marks_lie_on_the_skin_above_their_joint_and_near_the_stored_points(view):
    hand = people.hand()
    exact = dict(zip(NAMES, marks.exact_points(hand, view, NAMES), strict=True))
    centres = marks.bound_centres(hand)
    corners = hand.skin.points[hand.skin.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    for name in NAMES:
        stored = hand.skin.points[hand.feature_points[name][view]]
        assert np.linalg.norm(exact[name] - stored) < 0.0032
        off = np.abs(((exact[name] - corners[:, 0]) * normal).sum(axis=1))
        assert off.min() < 1e-9
        if name.startswith("pip"):
            k = ("thumb", "index", "middle", "ring", "little").index(name[4:]) + 1
            along = hand.skin.points[hand.feature_points[f"tip_{name[4:]}"][view]] - centres[f"pip{k}"]
            assert abs((exact[name] - centres[f"pip{k}"]) @ along / np.linalg.norm(along)) < 1e-9


def test_a_ray_that_meets_nothing_gives_the_other_answer():
    hand = people.hand()
    away = np.array([0.0, 0.0, 1.0])
    assert marks.leaves(hand.skin.points, hand.skin.faces, np.array([0.0, 0.0, 1.0]), away, away) is away
