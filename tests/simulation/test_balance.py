import numpy as np
import pytest
from scipy.optimize import approx_fprime

from handlab.simulation.balance import contraction_for, other_torque, settled, tangent, total_torque, unbalanced
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skeleton import pose, rest

SOME = {"FDP2": 0.3, "EDC2": 0.2, "ECRB": 0.4, "FCR": 0.3, "APB": 0.5, "DI1": 0.2}


def test_the_relaxed_hand_is_balanced_without_contraction(hand):
    assert np.abs(unbalanced(hand, rest(hand).angle, {})).max() < 1e-12


def test_where_a_hand_comes_to_rest_no_torque_is_left(hand):
    state = settled(hand, SOME, seconds=20.0)
    assert np.abs(state.speed).max() < 1e-6
    assert np.abs(unbalanced(hand, state.angle, SOME)).max() < 1e-6


def test_away_from_balance_torque_is_left(hand):
    assert np.abs(unbalanced(hand, rest(hand).angle, SOME)).max() > 0.01


def test_a_held_joint_takes_up_its_torque(hand):
    torque = unbalanced(hand, rest(hand).angle, SOME, hold=["wrist"])
    assert np.all(torque[:2] == 0.0)


def test_contractions_are_found_for_a_posture_that_muscles_can_hold(hand):
    state = settled(hand, SOME, seconds=20.0)
    found = contraction_for(hand, state.angle)
    assert found.worst < 1e-3
    assert found.contraction.min() >= 0.0 and found.contraction.max() <= 1.0
    again = settled(hand, found.contraction, start=state, seconds=5.0)
    assert np.rad2deg(np.abs(again.angle - state.angle)).max() < 3.0


def test_the_solution_is_the_best_there_is(hand, rng):
    """No random change of the contractions within [0, 1] lowers the sum that is minimised."""
    angle = pose(hand, {"mcp2.flexion_extension": 1.2, "pip3.flexion_extension": 1.5, "wrist.flexion_extension": -0.3}).angle
    found = contraction_for(hand, angle, effort=1e-2)

    def cost(c):
        return np.sum(total_torque(hand, angle[mechanics(hand).moving], c) ** 2) + 1e-4 * np.sum(c**2)

    best = cost(found.contraction)
    for _ in range(300):
        other = np.clip(found.contraction + rng.normal(0, 10 ** rng.uniform(-4, -1), 42), 0, 1)
        assert cost(other) >= best - 1e-12


def test_a_stop_takes_up_what_presses_against_it(hand):
    state = settled(hand, {"EDC2": 1.0, "ECRB": 0.5}, hold=["wrist"])
    k = hand.moving_names.index("pip2.flexion_extension")
    assert total_torque(hand, state.angle[mechanics(hand).moving], np.zeros(42))[k] > 0.0  # stiffness alone would flex it
    assert np.abs(unbalanced(hand, state.angle, {"EDC2": 1.0, "ECRB": 0.5}, hold=["wrist"])).max() < 1e-4


def test_only_the_muscles_that_are_asked_for_contract(hand):
    found = contraction_for(hand, pose(hand, {"mcp2.flexion_extension": 1.0}).angle, hold=["wrist"], muscles=["FDP2", "FDS2", "EDC2"])
    contracting = {hand.muscles[hand.muscle_names[k]].abbreviation for k in np.flatnonzero(found.contraction)}
    assert contracting <= {"FDP2", "FDS2", "EDC2"} and contracting


def test_a_weight_decides_where_torque_is_left(hand):
    angle = pose(hand, {f"{joint}2.flexion_extension": value for joint, value in (("mcp", 0.0), ("pip", 1.8), ("dip", 0.0))}).angle
    k = hand.moving_names.index("pip2.flexion_extension")
    plain = contraction_for(hand, angle, hold=["wrist"], muscles=["FDP2", "EDC2"])
    weighted = contraction_for(hand, angle, hold=["wrist"], muscles=["FDP2", "EDC2"], weight={"pip2.flexion_extension": 100.0})
    assert abs(weighted.unbalanced[k]) < abs(plain.unbalanced[k])


def test_contractions_stay_near_those_that_are_given(hand):
    given = {"FDP2": 0.5, "EDC2": 0.5}
    angle = settled(hand, given, seconds=20.0).angle
    found = contraction_for(hand, angle, near=given)
    assert found.contraction[hand.muscle_names.index("flexor_digitorum_profundus_index")] == pytest.approx(0.5, abs=0.02)


def test_the_tangent_is_the_slope_of_the_torque(hand, rng):
    m = mechanics(hand)
    y = rng.uniform(*m.limits.T)
    contraction = rng.uniform(size=42)
    matrix = tangent(hand, coupled(hand, y), contraction)
    for k in range(len(y)):
        slope = approx_fprime(y, lambda v, k=k: total_torque(hand, v, contraction)[k], 1e-7)
        np.testing.assert_allclose(matrix[k], slope, rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-6)


def test_joint_stiffness_pulls_back_to_the_relaxed_hand(hand, rng):
    m = mechanics(hand)
    y = rng.uniform(*m.limits.T)
    assert np.dot(other_torque(hand, y), y - m.rest_y) < 0.0
