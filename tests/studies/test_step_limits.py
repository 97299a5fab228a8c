"""The printed step stays calm just below 2 J / mu and runs away just above it."""

from dataclasses import replace

import numpy as np
import pytest

import handlab as hl
from handlab.simulation.laws import Laws
from handlab.studies.step_limits import moving_inertia, speed_factor, step_limits


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.mark.parametrize("name", ["dip2.flexion_extension", "pip4.flexion_extension", "wrist.deviation"])
def test_a_coasting_joint_is_calm_below_its_limit_and_runs_away_above(hand, name):
    hand = hand.with_(stiffness=np.zeros(len(hand.dof_names)))
    limit = step_limits(hand)[hand.moving_names.index(name)]
    k = hand.dof_names.index(name)
    speed = 1e-9 * hand.coupling[:, hand.moving_names.index(name)]  # so slow that the posture stays the same
    start = replace(hl.rest(hand), speed=speed)
    others = [other for other in hand.moving_names if other != name]
    ends = {}
    for factor in (0.95, 1.05):
        laws = Laws(dynamics="decoupled", friction="explicit", substep=float(factor * limit))
        ends[factor] = abs(hl.step(hand, start, {}, 60 * factor * limit, hold=others, laws=laws).speed[k]) / 1e-9
    assert ends[0.95] < 0.1
    assert ends[1.05] > 10.0


def test_the_limit_of_the_index_tip_is_that_of_its_inertia(hand):
    """Two-sided, against the paper's size of hand: J = 3.3e-7 kg m^2 and mu = 0.015 give 0.044 ms."""
    k = hand.moving_names.index("dip2.flexion_extension")
    assert 1e-7 < moving_inertia(hand)[k] < 6e-7
    mu = float(np.broadcast_to(hand.friction, len(hand.dof_names))[hand.dof_names.index("dip2.flexion_extension")])
    assert step_limits(hand)[k] == pytest.approx(2 * moving_inertia(hand)[k] / mu)


def test_a_fist_has_other_limits_than_the_flat_hand(hand):
    flat = hl.pose(hand, dict.fromkeys(hand.moving_names, 0.0))
    fist = hl.pose(hand, {f"{joint}{k}.flexion_extension": 1.3 for joint in ("mcp", "pip", "dip") for k in range(2, 6)})
    k = hand.moving_names.index("mcp2.flexion_extension")
    assert step_limits(hand, fist)[k] < 0.8 * step_limits(hand, flat)[k]


def test_the_implicit_step_only_ever_slows_down():
    dt = np.geomspace(1e-7, 1.0, 50)
    implicit = speed_factor(dt, 300.0, implicit=True)
    assert ((implicit > 0) & (implicit < 1)).all()
    assert (speed_factor(dt, 300.0, implicit=False) <= implicit).all()
    assert float(speed_factor(2 / 300.0, 300.0, implicit=False)) == pytest.approx(-1.0)
