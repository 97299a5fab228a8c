"""Lever arms from paths: against the cross product of mechanics, against the motion of single points, and against the table."""

import numpy as np
import pytest

import handlab as hl
from handlab.simulation.geometric_muscle import geometric_muscles, muscles_of
from handlab.simulation.kinematics import posed_axes, posed_points
from handlab.simulation.muscle_paint import paint
from handlab.studies.fibre_arm import fibre_arms, fibre_lengths, fibre_path


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="module")
def straight(hand):
    """A muscle of one segment, from the trapezium to the first phalanx of the thumb."""
    from handlab.anatomy.grids import load_grids

    grid = next(grid for grid in load_grids() if grid.name == "flexor_pollicis_brevis")
    rows = grid.points_on(hand.skin, hand.skin.points, hand.side)[[0, -1]]
    painted = paint(hand, "straight", rows, drives="FPB", thickness=(0.001, 0.004), bones=("trapezium", "proximal_phalanx_1"))
    return muscles_of(hand, [painted])


@pytest.mark.parametrize("rotation", ["cmc1.flexion_opposition", "cmc1.abduction_adduction", "mcp1.flexion_extension"])
def test_the_arm_of_a_straight_fibre_is_axis_times_place_cross_pull(hand, straight, rotation):
    """T = <a, r x F> with F = 1 N along the fibre at its insertion: equation (2) of the paper."""
    dof = hand.dof_names.index(rotation)
    angle = hand.bind.copy()
    angle[dof] += 0.2
    axes, anchors = posed_axes(hand, angle)
    path = fibre_path(hand, straight, "straight", angle)
    pull = path[:, 0] - path[:, -1]
    pull /= np.linalg.norm(pull, axis=1, keepdims=True)
    expected = np.cross(path[:, -1] - anchors[dof], pull) @ axes[dof]
    found = fibre_arms(hand, straight, "straight", rotation, angle)
    np.testing.assert_allclose(found, expected, atol=1e-7)
    assert np.abs(found).max() > 1e-3


def test_points_of_a_path_ride_on_their_bones(hand, straight):
    angle = hand.bind + 0.1
    home, moved = (fibre_path(hand, straight, "straight", at) for at in (hand.bind, angle))
    np.testing.assert_allclose(moved[:, 0], posed_points(hand, "carpus", home[:, 0], angle), atol=1e-12)
    np.testing.assert_allclose(moved[:, -1], posed_points(hand, "proximal_phalanx_1", home[:, -1], angle), atol=1e-12)


def test_a_rotation_that_a_muscle_does_not_cross_changes_nothing(hand):
    muscles = geometric_muscles(hand)
    for name, rotation in (("flexor_pollicis_brevis", "ip1.flexion_extension"), ("opponens_pollicis", "mcp1.flexion_extension")):
        np.testing.assert_allclose(fibre_arms(hand, muscles, name, rotation), 0.0, atol=1e-9)
    with pytest.raises(KeyError, match="flexor_pollicis_brevis"):
        fibre_arms(hand, muscles, "flexor_polliciss_brevis", "ip1.flexion_extension")
    with pytest.raises(KeyError, match="mcp1"):
        fibre_arms(hand, muscles, "flexor_pollicis_brevis", "mcp1.flexion")


def test_lengths_are_those_of_the_ellipsoids_in_the_bind_posture(hand):
    muscles = geometric_muscles(hand)
    for k, name in enumerate(muscles.names):
        rows = muscles.chains.length[muscles.segments[k]].reshape(muscles.fibres[k], -1)
        np.testing.assert_allclose(fibre_lengths(hand, muscles, name, hand.bind), rows.sum(axis=1), rtol=1e-9)
