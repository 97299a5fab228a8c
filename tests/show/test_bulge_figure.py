"""Figure 5: the colours say where and how far the skin rises."""

import numpy as np
import pytest

from handlab.show.bulge_figure import bulge_figure, colours


def test_colours_tell_rising_from_sinking_and_little_from_much():
    down, none, little, much = colours(np.array([-1.5, 0.0, 0.8, 2.2])).astype(int)
    assert np.ptp(none) < 10
    assert down[2] - down[0] > 100
    assert little[0] - little[2] > 60
    assert much.sum() < little.sum() - 100


@pytest.mark.xdist_group("pictures")
def test_the_figure_shows_one_pose_twice_and_colour_only_in_the_third_picture(hand, tmp_path):
    image = bulge_figure(hand, path=tmp_path / "bulge.png", size=(900, 450))
    assert (tmp_path / "bulge.png").stat().st_size > 20_000
    left, middle, right = (np.asarray(image)[60:-30, k * 300 : (k + 1) * 300].astype(int) for k in range(3))
    changed = np.abs(left - middle).max(axis=2) > 6
    assert 0.001 < changed.mean() < 0.2  # the flesh moved, the hand did not
    strong = (right[..., 0] - right[..., 2] > 110)[:, 90:]
    assert 50 < strong.sum() < 6000


def test_an_unknown_clip_or_view_is_refused_before_anything_is_drawn(hand):
    with pytest.raises(LookupError, match="key-pinch"):
        bulge_figure(hand, "keypinch")
    with pytest.raises(LookupError, match="did you mean"):
        bulge_figure(hand, view="palmar")
