"""Hands of one shape and another size: every law of growth exactly, and the same as the warp makes of them."""

import numpy as np
import pytest

import handlab as hl
from handlab.fitting.enlarged import enlarged, with_mechanics_of
from handlab.fitting.warp import warp_hand
from handlab.physics import rbf
from handlab.simulation.dynamics import mass_matrix
from handlab.simulation.kinematics import body_transforms


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.mark.parametrize("size", [0.6, 1.5])
def test_every_quantity_grows_with_its_power(hand, size):
    other = enlarged(hand, size)
    np.testing.assert_allclose(other.skin.points, size * hand.skin.points)
    np.testing.assert_allclose(other.max_force, size**2 * hand.max_force)
    np.testing.assert_allclose(other.lever_arm, size * hand.lever_arm)
    np.testing.assert_allclose(other.rest_length, size * hand.rest_length)
    assert other.skin.volume == pytest.approx(size**3 * hand.skin.volume)
    for angle in (hand.zero, hand.relaxed):
        np.testing.assert_allclose(mass_matrix(other, angle), size**5 * mass_matrix(hand, angle), rtol=1e-8, atol=1e-16)
        places = [body_transforms(one, angle)[:, :3, 3] for one in (hand, other)]
        np.testing.assert_allclose(places[1], size * places[0], atol=1e-12)
    assert other.growth.length == size


def test_kept_muscles_move_a_hand_of_other_inertia(hand):
    other = enlarged(hand, 0.7, mechanics="kept")
    assert other.muscles is hand.muscles and other.growth is None
    np.testing.assert_array_equal(other.stiffness, hand.stiffness)
    np.testing.assert_allclose(mass_matrix(other, hand.zero), 0.49 * mass_matrix(hand, hand.zero), rtol=1e-8, atol=1e-16)


@pytest.mark.parametrize("mechanics", ["scaled", "kept"])
def test_the_warp_makes_the_same_of_points_that_grew(hand, mechanics):
    corner = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
    warped = warp_hand(hand, rbf.fitted(corner, 0.8 * corner), 0.8, mechanics=mechanics).hand
    own = enlarged(hand, 0.8, mechanics=mechanics)
    np.testing.assert_allclose(own.skin.points, warped.skin.points, atol=2e-6)
    np.testing.assert_allclose(own.lever_arm, warped.lever_arm, rtol=2e-3, atol=1e-6)
    np.testing.assert_allclose(own.stiffness, warped.stiffness, rtol=1e-6)
    for ours, theirs in zip(own.bodies.values(), warped.bodies.values(), strict=True):
        assert ours.mass == pytest.approx(theirs.mass, rel=0.03)
    angles = [hl.simulate(one, "fist", hold=["wrist"]).angle[-1] for one in (own, warped)]
    assert np.abs(np.rad2deg(np.subtract(*angles))).max() < 1.0


def test_a_child_with_the_muscles_of_a_woman_has_her_strength_and_its_own_shape(hand):
    child = hl.load_hand("child")
    other = with_mechanics_of(child, hand)
    assert other.muscles is hand.muscles
    np.testing.assert_array_equal(other.skin.points, child.skin.points)
    for name, body in other.bodies.items():
        assert body.mass == hand.bodies[name].mass
        np.testing.assert_array_equal(body.centre, child.bodies[name].centre)
        ratio = body.mass / child.bodies[name].mass
        np.testing.assert_allclose(body.inertia, ratio * child.bodies[name].inertia)


def test_an_enlarged_hand_is_saved_and_comes_back(hand, tmp_path):
    other = enlarged(hand, 0.7)
    again = hl.load_hand(other.save(tmp_path / "small"))
    np.testing.assert_allclose(again.skin.points, other.skin.points, atol=1e-8)
    np.testing.assert_allclose(again.lever_arm, other.lever_arm)
    np.testing.assert_allclose(again.max_force, other.max_force)


def test_sizes_that_no_hand_has_are_refused(hand):
    for size in (0, -1, 10, float("nan"), "0.7"):
        with pytest.raises(ValueError, match=r"between 0\.3 and 3"):
            enlarged(hand, size)
    with pytest.raises(ValueError, match="'scaled' or 'kept'"):
        enlarged(hand, 0.7, mechanics="big")
    with pytest.raises(ValueError, match="size of its own"):
        enlarged(hl.load_hand("child"), 0.7)
