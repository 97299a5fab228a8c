"""Feature points exactly above the joints that they mark."""

import numpy as np
import people
import pytest

from handlab.fitting import marks
from handlab.fitting.landmarks import NAMES


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
