"""Figure 5 and the three skins: the colours say where and how far the skin rises."""

import numpy as np
import pytest

import handlab as hl
from handlab.show.bulge_figure import bulge_figure, close_up, colours, upright
from handlab.show.section_picture import Cut, Plane, dashes, muscle_cuts
from handlab.show.skins_figure import differences, skins_figure, three
from handlab.studies.swelling import swelling


@pytest.fixture(scope="module")
def found(hand):
    clip = hl.simulate(hand, "key-pinch", fps=4)
    return swelling(hand, clip.angle[-1], clip.contraction[-1], "DI1")


def test_colours_tell_rising_from_sinking_and_little_from_much():
    down, none, little, much = colours(np.array([-1.5, 0.0, 0.8, 2.2])).astype(int)
    assert np.ptp(none) < 10
    assert down[2] - down[0] > 100
    assert little[0] - little[2] > 60
    assert much.sum() < little.sum() - 100


def test_the_camera_stands_near_the_bulge_with_the_fingertips_up(hand, found):
    aim = close_up(hand, found)
    axes = np.stack([aim.right, aim.up, aim.to_eye])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_allclose(aim.focus, found.off[found.most[1]])
    assert aim.up[0] > 0.8  # x is distal
    assert aim.to_eye @ upright(hand, found)[0] == pytest.approx(np.cos(np.deg2rad(15)))


def test_a_cut_across_the_muscle_shows_it_round_and_thicker_when_it_contracts(hand, found):
    out, _, side = upright(hand, found)
    plane = Plane(found.on[found.most[1]], side, out)
    rest = np.where([name in found.muscles for name in hand.muscle_names], 0.0, found.contraction)

    def area(contraction):
        rings = muscle_cuts(hand, plane, found.angle, contraction, found.muscles)
        return sum(abs(0.5 * np.sum(r[:, 0] * np.roll(r[:, 1], -1) - r[:, 1] * np.roll(r[:, 0], -1))) for r in rings)

    assert 30e-6 < area(rest) < 250e-6
    assert 1.15 * area(rest) < area(found.contraction) < 2.0 * area(rest)
    top = max(ring[:, 1].max() for ring in plane.cut(found.on, hand.skin.faces))
    bottom = max(ring[np.abs(ring[:, 0]) < 1e-3][:, 1].max(initial=-1.0) for ring in plane.cut(found.off, hand.skin.faces))
    assert top >= 0.0 > bottom > -0.004  # the plane goes through the place that rises most


def test_a_cut_is_drawn_to_scale():
    plane = Plane(np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]))
    cut = Cut(plane, (400, 300), 0.04)
    cut.fill([np.array([[-0.01, -0.005], [0.01, -0.005], [0.01, 0.005], [-0.01, 0.005]])], "#000000")
    dark = np.asarray(cut.picture()).sum(axis=2) < 300
    assert dark.sum() == pytest.approx(200 * 100, rel=0.03)  # 10 pixels a millimetre
    pieces = dashes(np.array([[0.0, 0.0], [10.0, 0.0]]), 2.0)
    assert [tuple(piece[0]) for piece in pieces] == [(0.0, 0.0), (3.0, 0.0), (6.0, 0.0), (9.0, 0.0)]
    assert pieces[-1][-1][0] == 10.0


@pytest.mark.xdist_group("pictures")
def test_the_figure_shows_one_pose_twice_and_colour_only_in_the_third_picture(hand, tmp_path):
    image = bulge_figure(hand, path=tmp_path / "bulge.png", size=(900, 600))
    assert (tmp_path / "bulge.png").stat().st_size > 20_000
    left, middle, right = (np.asarray(image)[60:340, k * 300 : (k + 1) * 300].astype(int) for k in range(3))
    changed = np.abs(left - middle).max(axis=2) > 6
    assert 0.02 < changed.mean() < 0.5  # the flesh moved, the hand did not
    strong = right[..., 0] - right[..., 2] > 110
    assert 0.02 < strong.mean() < 0.3
    assert (left[..., 0] - left[..., 2] > 110).mean() < 0.01
    cut = np.asarray(image)[370:560, :540].astype(int)
    assert ((cut[..., 0] - cut[..., 1] > 80) & (cut[..., 2] < 120)).sum() > 1000  # the muscle


@pytest.mark.xdist_group("pictures")
def test_three_skins_stand_side_by_side_and_their_differences_below(hand, tmp_path):
    clip = hl.simulate(hand, "fist", fps=4)
    blend, springs, muscles = three(hand, clip)
    assert 0.002 < differences(hand, blend, springs).max() < 0.02
    assert 0.001 < differences(hand, springs, muscles).max() < 0.006
    image = np.asarray(skins_figure(hand, clip, tmp_path / "skins.png", size=(900, 675))).astype(int)
    spread = np.ptp(image, axis=2) > 90
    first, second = image[60:300, :300], image[60:300, 300:600]
    assert (np.abs(first - second).max(axis=2) > 12).mean() > 0.02
    assert spread[380:600, 340:600].sum() > 500 and spread[380:600, :300].sum() < 50


def test_an_unknown_clip_or_view_is_refused_before_anything_is_drawn(hand):
    for figure in (bulge_figure, skins_figure):
        with pytest.raises(LookupError, match="key-pinch"):
            figure(hand, "keypinch")
        with pytest.raises(LookupError, match="did you mean"):
            figure(hand, view="palmar")
