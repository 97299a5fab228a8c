"""What size does: exact laws for hands of one shape, found from outside."""

import numpy as np
import pytest

import handlab as hl
from handlab.fitting.enlarged import enlarged
from handlab.studies import size


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


def test_half_way_is_half_way(hand):
    time, angle = size.path(hand)
    half = size.half_time(hand)
    assert np.interp(half, time, angle) == pytest.approx((angle[0] + angle[-1]) / 2, abs=1e-6)
    assert 0.01 < half < 0.1


def test_a_pull_at_another_joint_is_timed_there(hand):
    slow = size.half_time(hand, {"FCR": 0.05}, "wrist.flexion_extension", hold=())
    fast = size.half_time(hand, {"FCR": 0.3}, "wrist.flexion_extension", hold=())
    assert fast < slow


def test_strengths_are_those_of_the_tables(hand):
    found = size.strengths(hand)
    muscle = hand.muscles["FDP2"]
    arm = next(arm for arm in muscle.lever_arms if arm.dof == size.KNUCKLE)
    row = hand.muscle_names.index(muscle.name)
    assert found["force"] == hand.max_force[row]
    assert found["torque"] == pytest.approx(found["force"] * abs(arm.used))
    assert 1e-6 < found["inertia"] < 1e-4


def test_a_silent_hand_sags_as_its_weight_asks(hand):
    """Stiffness times sag is about the torque of the weight about the wrist."""
    wrist = hand.dof_names.index("wrist.flexion_extension")
    sag = size.sag(hand)
    weight = sum(body.mass * 9.81 * body.centre[0] for name, body in hand.bodies.items() if name != "forearm")
    assert hand.stiffness[wrist] * sag == pytest.approx(weight, rel=0.35)
    assert size.sag(enlarged(hand, 1.3)) > sag > size.sag(enlarged(hand, 0.7))
