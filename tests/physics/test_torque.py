import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handlab.physics.torque import (
    friction_opposing,
    friction_printed,
    joint_torque,
    torque_about_axis,
    torque_printed,
    torque_printed_of_sum,
)

EXAMPLES = json.loads((Path(__file__).parents[1] / "data" / "equations_examples.json").read_text())


def test_where_arm_and_force_stand_square_to_the_axis_both_readings_agree():
    example = EXAMPLES["eq2_parallel"]
    for law in (torque_about_axis, torque_printed):
        assert float(law([0, 0, 1], example["r_m"], example["F_N"])) == pytest.approx(example["T"], abs=1e-12)


def test_the_printed_torque_of_an_oblique_tendon_is_1_6_percent_too_large():
    example = EXAMPLES["eq2_oblique"]
    arguments = example["a"], example["r_m"], example["F_N"]
    assert float(torque_about_axis(*arguments)) == pytest.approx(example["T_projected"], abs=1e-12)
    assert float(torque_printed(*arguments)) == pytest.approx(example["T_printed"], abs=1e-6)


def test_antagonists_that_add_up_across_the_axis_fool_the_printed_sum():
    assert float(torque_printed_of_sum([1, 0, 0], [0.1, 0.3, 0])) == pytest.approx(np.sqrt(0.1), abs=1e-12)


def test_laws_take_many_vectors_at_once():
    rng = np.random.default_rng(1)
    arm, force = rng.normal(size=(5, 3)), rng.normal(size=(5, 3))
    axis = np.array([0.0, 0.6, 0.8])
    expected = [np.dot(axis, np.cross(a, f)) for a, f in zip(arm, force, strict=True)]
    np.testing.assert_allclose(torque_about_axis(axis, arm, force), expected, atol=1e-14)


@pytest.mark.parametrize("case", EXAMPLES["friction"]["cases"], ids=lambda case: f"T={case['T_muscle']},w={case['omega']}")
def test_friction_gives_the_worked_numbers(case):
    mu = EXAMPLES["friction"]["mu"]
    assert float(friction_opposing(case["T_muscle"], case["omega"], mu)) == pytest.approx(case["opposing"], abs=1e-12)
    assert float(friction_printed(case["T_muscle"], case["omega"], mu)) == pytest.approx(case["printed"], abs=1e-12)


@given(st.floats(-10, 10), st.floats(-100, 100), st.floats(0, 1))
def test_opposing_friction_never_adds_power(torque, speed, mu):
    power = (float(friction_opposing(torque, speed, mu)) - torque) * speed
    assert power <= 1e-9


def test_printed_friction_adds_power_where_torque_and_speed_disagree():
    assert (float(friction_printed(0.1, -2.0, 0.015)) - 0.1) * -2.0 == pytest.approx(0.06, abs=1e-12)


def test_two_antagonists_give_the_worked_torque():
    example = EXAMPLES["eq2pp"]
    force = [example["F_N"][name] for name in ("FDP2", "EDC2")]
    arm = [[example["r_mm"][name] / 1000.0] for name in ("FDP2", "EDC2")]
    torque = joint_torque(arm, force)
    assert torque[0] == pytest.approx(example["T_Nm"], abs=1e-9)
    assert float(friction_opposing(torque[0], 3.0, 0.015)) == pytest.approx(example["T_with_friction_omega_3"], abs=1e-9)
