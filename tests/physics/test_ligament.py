import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handlab.physics.ligament import between, collateral_torque, spring_torque, tautness, tautness_slope

flexions = st.floats(-0.6, 1.7)


def test_a_ligament_is_slack_when_straight_and_taut_at_90_degrees():
    np.testing.assert_allclose(tautness(np.deg2rad([-30, 0, 45, 90, 100])), [0, 0, 0.5, 1, 1], atol=1e-12)
    assert float(between(1.0, 0.25, np.pi / 2)) == pytest.approx(0.25)


@given(flexions)
def test_the_slope_of_tautness_is_its_slope(flexion):
    step = 1e-6
    assert float(tautness_slope(flexion)) == pytest.approx(
        float(tautness(flexion + step) - tautness(flexion - step)) / (2 * step), abs=1e-5
    )


def test_a_spring_pulls_towards_its_rest():
    assert float(spring_torque(0.04, 1.0, 0.5)) == pytest.approx(-0.02)


@given(flexions, st.floats(-0.3, 0.3), st.floats(-0.1, 0.1))
def test_both_torques_of_a_ligament_are_slopes_of_one_energy(flexion, deviation, rest):
    def energy(f, d):
        return 0.5 * 0.04 * float(between(1.0, 5.0, f)) * (d - rest) ** 2

    step = 1e-5
    on_deviation, on_flexion = collateral_torque(0.04, 5.0, flexion, deviation, rest)
    assert float(on_deviation) == pytest.approx(
        -(energy(flexion, deviation + step) - energy(flexion, deviation - step)) / (2 * step), abs=1e-8
    )
    assert float(on_flexion) == pytest.approx(
        -(energy(flexion + step, deviation) - energy(flexion - step, deviation)) / (2 * step), abs=1e-6
    )


def test_at_90_degrees_deviation_is_as_much_stiffer_as_asked():
    soft, _ = collateral_torque(0.04, 5.0, 0.0, 0.1, 0.0)
    stiff, _ = collateral_torque(0.04, 5.0, np.pi / 2, 0.1, 0.0)
    assert float(stiff / soft) == pytest.approx(5.0)
