"""Two hands under one contraction: one scale in the pictures, and curves that are those of the clips."""

from types import SimpleNamespace

import numpy as np
import pytest

import handlab as hl
from handlab.show import two_hands as module
from handlab.show.two_hands import hand_length_mm, measured, pictures, telling, two_hands
from handlab.simulation.dynamics import mass_matrix

DOF = "mcp2.flexion_extension"


@pytest.fixture(scope="module")
def child():
    return hl.load_hand("child")


@pytest.fixture(scope="module")
def played(hand, child):
    return [hl.simulate(one, "fist", hold=["wrist"]) for one in (hand, child)]


def test_the_curves_are_torque_inertia_and_angle_of_the_rotation(played):
    torque, inertia, angle = measured(played, DOF)
    for clip, (time, values), (moment, kg_mm2), (_, degrees) in zip(played, torque, inertia, angle, strict=True):
        hand = clip.hand
        k, column = hand.dof_names.index(DOF), hand.moving_names.index(DOF)
        assert len(time) == len(values) == len(degrees) == len(clip)
        np.testing.assert_allclose(values, clip.force @ hand.lever_arm[:, k], rtol=1e-9, atol=1e-12)
        for at, value in ((0, kg_mm2[0]), (-1, kg_mm2[-1])):
            assert value == pytest.approx(1e6 * mass_matrix(hand, clip.angle[at])[column, column], rel=0.02)
        assert moment[-1] == clip.time[-1]
        assert np.deg2rad(degrees[-1]) == pytest.approx(clip.states[-1].angle[k])
    assert 0.2 < torque[1][1][-1] / torque[0][1][-1] < 0.5
    assert 0.08 < inertia[1][1][-1] / inertia[0][1][-1] < 0.25


def test_a_rotation_that_follows_shows_the_inertia_of_its_driver(played):
    follower = measured(played[:1], "mcp3.axial_rotation")[1][0][1]
    np.testing.assert_array_equal(follower, measured(played[:1], "mcp3.flexion_extension")[1][0][1])


def test_moments_lie_where_the_posture_changes_and_not_where_it_stands_still(played):
    at = telling(played[0], 3)
    assert at[0] == 0.0
    way = np.abs(np.diff(played[0].angle, axis=0)).sum(axis=1)
    half = way[played[0].time[1:] <= at[1]].sum() / way.sum()
    assert half == pytest.approx(0.5, abs=0.05)
    assert at[1] < 0.5 * played[0].time[-1]
    assert list(telling(played[0], 1)) == [played[0].time[-1]]
    still = SimpleNamespace(time=np.linspace(0, 1, 11), angle=np.zeros((11, 3)))
    assert list(telling(still, 3)) == [0.0, 0.5, 1.0]


@pytest.mark.xdist_group("pictures")
def test_both_hands_are_drawn_at_one_scale(played):
    strip, px_per_mm = pictures(played, np.array([0.0]), "palm", "solid")
    width = strip.shape[1] // 2
    for clip, tile in zip(played, (strip[:, :width], strip[:, width:]), strict=True):
        flesh = tile[..., 0].astype(int) - tile[..., 2] > 20
        rows, columns = np.flatnonzero(flesh.any(axis=1)), np.flatnonzero(flesh.any(axis=0))
        assert rows[0] > 0.05 * len(tile) and rows[-1] < 0.95 * len(tile)  # room for the words
        skin = 1e3 * clip.skin(0)
        assert (columns[-1] - columns[0]) / px_per_mm == pytest.approx(np.ptp(skin[:, 2]), rel=0.04)
        assert (rows[-1] - rows[0]) / px_per_mm == pytest.approx(np.ptp(skin[:, 0]), rel=0.10)  # seen from a little above


@pytest.mark.xdist_group("pictures")
def test_the_figure_names_both_hands_and_their_sizes(hand, child, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "TILE", (96, 180))
    figure = two_hands(hand, child, {"FDP2": 0.3}, tmp_path / "two.png", joint="pip2", moments=2)
    assert (tmp_path / "two.png").stat().st_size > 20_000
    strip, *plots = figure.get_axes()
    assert [axes.get_title("left") for axes in plots] == ["muscle torque (N m)", "moment of inertia (kg mm²)", "angle (degrees)"]
    words = [text.get_text() for text in strip.texts]
    assert words.count("child") == 2 and words.count("reference") == 2 and "50 mm" in words
    assert {text.get_text() for text in plots[0].get_legend().get_texts()} == {"reference", "child"}
    assert "pip2.flexion_extension" in figure.get_suptitle()
    assert f"{hand_length_mm(hand):.0f} and {hand_length_mm(child):.0f} mm" in figure.get_supxlabel()
    torque = measured([hl.simulate(one, {"FDP2": 0.3}, seconds=1.0, hold=["wrist"]) for one in (hand, child)], "pip2.flexion_extension")[0]
    assert f"× {torque[1][1][-1] / torque[0][1][-1]:.2f}" in [text.get_text() for text in plots[0].texts]


def test_mistakes_are_told_before_anything_is_drawn(hand, child, tmp_path):
    with pytest.raises(ValueError, match="give 1 to 6"):
        two_hands(hand, child, moments=0)
    with pytest.raises(LookupError, match="fist"):
        two_hands(hand, child, "fits")
    with pytest.raises(LookupError, match="mcp2"):
        two_hands(hand, child, joint="mcp22")
    with pytest.raises(LookupError, match="did you mean"):
        two_hands(hand, child, view="palmar")
    with pytest.raises(ValueError, match="png"):
        two_hands(hand, child, path=tmp_path / "two.svg")
