"""Required excursion is the range of fibre lengths; potential excursion is what the active curve allows."""

import numpy as np
import pytest

import handlab as hl
from handlab.physics.muscle import active_force_length
from handlab.studies.excursion import LEVELS, potential_excursion, required_excursion


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


def test_fdp2_needs_the_sum_of_its_arms_times_the_ranges_of_its_joints(hand):
    """By hand: 145 and 55 degrees of wrist, 120 and 30 of MCP, 110 of PIP, 90 of DIP."""
    expected_mm = {
        "wrist": 13.0 * np.deg2rad(145) + 0.5 * np.deg2rad(55),
        "CMC": 0.0,
        "MCP": 11.1 * np.deg2rad(120) + 1.1 * np.deg2rad(30),
        "PIP and IP": 7.9 * np.deg2rad(110),
        "DIP": 4.1 * np.deg2rad(90),
    }
    row = hand.muscle_names.index(hand.muscles["FDP2"].name)
    found = {level: 1000 * metres[row] for level, metres in required_excursion(hand).items()}
    assert found == pytest.approx(expected_mm, abs=1e-9)


def test_no_posture_asks_for_more_and_the_extreme_ones_ask_for_all_of_it(hand):
    required = sum(required_excursion(hand).values())
    random = np.random.default_rng(1)
    low, high = np.array([hand.dofs[name].limits for name in hand.moving_names]).T
    lengths = []
    for kind in range(400):
        share = random.random(len(low)) if kind else np.zeros(len(low))
        lengths.append(hl.pose(hand, dict(zip(hand.moving_names, low + share * (high - low), strict=True))).fibre_length)
    assert (np.ptp(lengths, axis=0) <= required + 1e-12).all()
    for name in ("FDS4", "ECU", "DI4", "OPP"):
        k = hand.muscle_names.index(hand.muscles[name].name)
        pull = (hand.lever_arm @ hand.coupling)[k]
        ends = [np.where(pull * sign > 0, high, low) for sign in (1, -1)]
        short, long = (hl.pose(hand, dict(zip(hand.moving_names, end, strict=True))).fibre_length[k] for end in ends)
        assert long - short == pytest.approx(required[k], rel=1e-9)


def test_every_joint_that_moves_belongs_to_one_level(hand):
    levels = [joint for joints in LEVELS.values() for joint in joints]
    assert len(levels) == len(set(levels))
    assert {name.partition(".")[0] for name in hand.moving_names} <= set(levels)


def test_the_potential_is_the_range_in_which_the_active_curve_is_not_zero(hand):
    ratio = np.linspace(0.0, 2.5, 25001)
    pulling = ratio[active_force_length(ratio) > 0]
    assert np.allclose(potential_excursion(hand), np.ptp(pulling) * hand.rest_length, rtol=1e-3)
