import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handlab.physics.ligament import (
    between,
    capsule_energy,
    capsule_slope,
    capsule_torque,
    collateral_energy,
    spring_torque,
    tautness,
)

angles = st.floats(-1.2, 1.7)
BOUNDS = (-0.5, 1.0, 0.1, 0.3, 0.2)  # lower, upper, width, torques at the limits


def test_a_ligament_is_slack_when_straight_and_taut_at_90_degrees():
    np.testing.assert_allclose(tautness(np.deg2rad([-30, 0, 45, 90, 100])), [0, 0, 0.5, 1, 1], atol=1e-12)
    assert float(between(1.0, 0.25, np.pi / 2)) == pytest.approx(0.25)


def test_a_spring_pulls_towards_its_rest():
    assert float(spring_torque(0.04, 1.0, 0.5)) == pytest.approx(-0.02)


def test_a_capsule_is_slack_inside_its_range_and_pulls_with_its_torque_at_the_limit():
    np.testing.assert_array_equal(capsule_torque([-0.399, 0.0, 0.899], *BOUNDS), 0.0)
    np.testing.assert_allclose(capsule_torque([-0.5, 1.0, 1.1, 0.95], *BOUNDS), [0.3, -0.2, -1.6, -0.025], atol=1e-12)


@given(angles)
def test_capsule_torque_and_stiffness_are_slopes_of_its_energy(angle):
    step = 1e-5
    slope = (capsule_energy(angle + step, *BOUNDS) - capsule_energy(angle - step, *BOUNDS)) / (2 * step)
    assert float(capsule_torque(angle, *BOUNDS)) == pytest.approx(-float(slope), rel=1e-5, abs=1e-8)
    curvature = (capsule_torque(angle + step, *BOUNDS) - capsule_torque(angle - step, *BOUNDS)) / (2 * step)
    assert float(capsule_slope(angle, *BOUNDS)) == pytest.approx(-float(curvature), rel=1e-4, abs=1e-4)


@given(angles, st.floats(-30, 30))
def test_the_drag_of_a_capsule_takes_energy_out(angle, speed):
    braked = capsule_torque(angle, *BOUNDS, speed=speed, time=0.01) - capsule_torque(angle, *BOUNDS)
    assert float(braked) * speed <= 0.0


def ligament(flexion, deviation):
    return float(collateral_energy(0.04, 5.0, 0.25, flexion, deviation, 0.02, -0.26, 0.26, 0.07, 0.1, 0.1))


def test_at_90_degrees_a_spread_finger_stores_five_times_as_much_in_its_springs_and_its_capsule_begins_at_a_quarter():
    assert ligament(np.pi / 2, 0.03) == pytest.approx(5.0 * ligament(0.0, 0.03))
    assert ligament(np.pi / 2, 0.25 * 0.26) - 5.0 * 0.5 * 0.04 * (0.25 * 0.26 - 0.02) ** 2 == pytest.approx(0.25 * 0.25 * 0.07 * 0.1)
