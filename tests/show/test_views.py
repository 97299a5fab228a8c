import numpy as np
import pytest

import handlab as hl
from handlab.show.views import DIRECTIONS, LENS_DEG, camera, directions, same_scale


def projected(view, points):
    """Pinhole camera, written independently of the code: picture coordinates, 1 at the upper edge."""
    offset = points - view.position
    depth = -(offset @ view.to_eye)
    scale = np.tan(np.deg2rad(LENS_DEG / 2))
    return offset @ view.right / depth / scale, offset @ view.up / depth / scale, depth


@pytest.mark.parametrize("name", DIRECTIONS)
@pytest.mark.parametrize("aspect", [0.5, 1.0, 2.0])
def test_every_point_of_the_hand_is_in_the_picture_and_fills_it(hand, name, aspect):
    x, y, depth = projected(camera(hand, name, [hand.skin.points], aspect), hand.skin.points)
    assert (depth > 0).all()
    reach = max(np.abs(x).max() / aspect, np.abs(y).max())
    assert 0.90 < reach < 1.0


@pytest.mark.parametrize("name", DIRECTIONS)
def test_the_axes_of_a_camera_are_square_and_right_handed(hand, name):
    to_eye, up, right = directions(hand, name)
    assert np.allclose(np.stack([right, up, to_eye]) @ np.stack([right, up, to_eye]).T, np.eye(3), atol=1e-12)
    assert np.allclose(np.cross(right, up), to_eye)


def test_the_palm_of_a_right_hand_shows_its_thumb_on_the_right(hand):
    thumb = hand.bones["distal_phalanx_1"].points.mean(axis=0)
    assert thumb @ directions(hand, "palm")[2] > 0.02
    assert thumb @ directions(hand, "back")[2] < -0.02


def test_the_palm_of_a_left_hand_shows_its_thumb_on_the_left():
    left = hl.load_hand(side="left")
    assert left.bones["distal_phalanx_1"].points.mean(axis=0) @ directions(left, "palm")[2] < -0.02


def test_the_thumb_is_nearest_to_the_eye_in_the_radial_view_of_both_hands(hand):
    for one in (hand, hl.load_hand(side="left")):
        to_eye = directions(one, "radial")[0]
        depth = {digit: one.bones[f"metacarpal_{digit}"].points.mean(axis=0) @ to_eye for digit in range(1, 6)}
        assert list(depth) == sorted(depth, key=lambda digit: -depth[digit])


def test_views_of_one_scale_are_equally_far_away(hand):
    cameras = same_scale(hand, ["palm", "radial", "front"], [hand.skin.points], 1.0)
    assert len({round(one.distance, 12) for one in cameras.values()}) == 1
    assert cameras["palm"].distance >= camera(hand, "palm", [hand.skin.points], 1.0).distance


def test_an_unknown_view_is_answered_with_the_nearest_three(hand):
    with pytest.raises(KeyError, match="palm"):
        camera(hand, "plam", [hand.skin.points], 1.0)
