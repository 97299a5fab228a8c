import numpy as np
import pytest

from handlab.simulation.balance import contraction_for, settled
from handlab.simulation.reach import reach
from handlab.simulation.skeleton import pose, rest

FLAT = {f"{joint}{finger}.flexion_extension": 0.0 for finger in range(2, 6) for joint in ("mcp", "pip", "dip")}
FLAT |= {"wrist.flexion_extension": 0.0, "wrist.deviation": 0.0}


def off(hand, state, target):
    return max(abs(np.rad2deg(state.angle[hand.dof_names.index(name)] - value)) for name, value in target.items())


def test_the_flat_hand_is_reached_where_static_balance_drifts_off(hand):
    found = reach(hand, FLAT)
    assert np.rad2deg(found.worst) < 3.0
    assert found.contraction.min() >= 0.0 and found.contraction.max() <= 1.0
    assert off(hand, settled(hand, contraction_for(hand, pose(hand, FLAT).angle).contraction), FLAT) > 2 * np.rad2deg(found.worst)


def test_what_is_reported_is_where_the_relaxed_hand_settles(hand):
    found = reach(hand, {"mcp2.flexion_extension": 1.0})
    assert off(hand, settled(hand, found.contraction, seconds=6.0), {"mcp2.flexion_extension": 1.0}) < 1.0


def test_a_posture_that_muscles_made_is_found_again(hand):
    state = settled(hand, {"FDP2": 0.1, "EDC3": 0.1, "APB": 0.2}, hold=["wrist"], seconds=8.0)
    target = {name: state.angle[k] for k, name in enumerate(hand.dof_names) if name in hand.moving_names and not name.startswith("wrist")}
    assert np.rad2deg(reach(hand, target, hold=["wrist"]).worst) < 1.0


def test_held_joints_and_forbidden_muscles_stay_out_of_it(hand):
    found = reach(hand, {"mcp2.flexion_extension": 1.2, "wrist.flexion_extension": 0.2}, hold=["wrist"], muscles=["FDP2", "LUM1", "EDC2"])
    assert found.state.angle[0] == 0.2
    contracting = {hand.muscles[hand.muscle_names[k]].abbreviation for k in np.flatnonzero(found.contraction)}
    assert contracting <= {"FDP2", "LUM1", "EDC2"}


def test_the_relaxed_hand_needs_no_contraction(hand):
    angle = rest(hand).angle
    target = {name: angle[hand.dof_names.index(name)] for name in hand.moving_names}
    assert reach(hand, target).contraction.max() == pytest.approx(0.0, abs=1e-3)
