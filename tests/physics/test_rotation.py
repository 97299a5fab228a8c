import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handlab.physics.muscle import muscle_force
from handlab.physics.rotation import explicit_speed, fibre_length, implicit_speed, length_printed, turned
from handlab.physics.torque import friction_opposing, friction_printed

EXAMPLES = json.loads((Path(__file__).parents[1] / "data" / "equations_examples.json").read_text())
INDEX = EXAMPLES["chain"]["poses"][0]["J_total_MCP"]
MU = 0.015


def test_one_step_gives_the_worked_numbers():
    example = EXAMPLES["euler_step"]
    speed = explicit_speed(example["omega_old"], example["T"], example["J"], example["dt"])
    assert float(speed) == pytest.approx(example["omega_new"], rel=1e-5)
    by = float(turned(0.0, speed, example["dt"]))
    assert by == pytest.approx(example["d_phi"], rel=1e-5)
    assert 1000 * float(length_printed(example["l_old_mm"] / 1000, by, example["r_mm"] / 1000)) == pytest.approx(
        example["l_new_mm"], abs=1e-7
    )


def test_the_printed_length_update_shortens_an_extensor_that_flexion_stretches():
    assert float(length_printed(0.06, 0.5, -0.01)) == pytest.approx(0.055)
    assert float(fibre_length([0.06], [[-0.01]], [0.5], [0.0])[0]) == pytest.approx(0.065)


def test_the_deep_flexor_in_a_fist_has_the_worked_length():
    arms = np.array([[0.0111, 0.0079, 0.0041]])
    length = fibre_length([0.066], arms, [np.pi / 2, 1.74533, 1.16937], [0, 0, 0])
    assert 1000 * float(length[0]) == pytest.approx(29.98, abs=0.005)


def test_a_whole_recording_of_angles_gives_lengths_row_by_row():
    arms, angles = np.array([[0.01, -0.005], [0.0, 0.02]]), np.array([[0.1, 0.2], [0.3, 0.4], [0.0, 0.0]])
    rows = [fibre_length([0.05, 0.06], arms, row, [0.1, 0.0]) for row in angles]
    np.testing.assert_allclose(fibre_length([0.05, 0.06], arms, angles, [0.1, 0.0]), rows, atol=1e-15)


def simulate(step, dt, seconds=0.2):
    """The worked simulation: index MCP, FDP2 alone at c = 0.1."""
    angle = speed = 0.0
    for _ in range(round(seconds / dt)):
        length = 0.066 - 0.0111 * angle
        torque = 0.0111 * float(muscle_force(0.1, length / 0.066, 54.0, reading="sound" if abs(angle) < 100 else "printed"))
        speed = float(step(speed, torque, dt))
        angle += dt * speed
    return angle


def implicit(speed, torque, dt):
    return implicit_speed(speed, torque, INDEX, dt, MU)


def explicit(speed, torque, dt):
    return explicit_speed(speed, friction_opposing(torque, speed, MU), INDEX, dt)


@pytest.mark.parametrize(
    ("step", "dt", "name"),
    [
        (explicit, 1e-5, "explicit_dt_1e-5"),
        (explicit, 1e-4, "explicit_dt_1e-4"),
        (implicit, 1e-4, "implicit_dt_1e-4"),
        (implicit, 1 / 240, "implicit_dt_1_240"),
        (implicit, 1 / 60, "implicit_dt_1_60"),
        (explicit, 1 / 240, "explicit_dt_1_240"),
    ],
)
def test_the_worked_simulation_ends_at_the_worked_angle(step, dt, name):
    expected = EXAMPLES["simulation"]["results"][name]["phi_rad"]
    digits = 5e-5 if name == "explicit_dt_1_240" else 1e-6  # printed with four and with six digits
    assert simulate(step, dt) == pytest.approx(expected, abs=digits)


def test_the_explicit_step_at_60_hz_diverges():
    assert abs(simulate(explicit, 1 / 60)) > 1e6


def test_printed_friction_runs_away_and_opposing_friction_brakes():
    example = EXAMPLES["simulation"]["results"]["braking_omega_after_20ms"]
    printed = opposing = 5.0
    dt = 1e-5
    for _ in range(2000):
        printed = float(explicit_speed(printed, friction_printed(-0.02, printed, MU), INDEX, dt))
        opposing = float(explicit_speed(opposing, friction_opposing(-0.02, opposing, MU), INDEX, dt))
    assert printed == pytest.approx(example["printed"], rel=0.01)
    assert opposing == pytest.approx(example["opposing"], rel=0.01)


@given(st.floats(-50, 50), st.floats(1e-7, 1e-2), st.floats(1e-5, 1.0), st.floats(0, 1), st.floats(0, 10))
def test_friction_and_spring_taken_implicitly_never_speed_a_bone_up(speed, inertia, dt, friction, stiffness):
    after = float(implicit_speed(speed, 0.0, inertia, dt, friction, stiffness))
    assert abs(after) <= abs(speed) and after * speed >= 0.0


def test_the_implicit_step_is_of_first_order():
    """Against the analytic braking speed exp(-mu t / J)."""
    errors, steps = [], np.array([1e-5, 2e-5, 4e-5])
    for dt in steps:
        speed = 5.0
        for _ in range(round(4e-3 / dt)):
            speed = float(implicit_speed(speed, 0.0, INDEX, dt, MU))
        errors.append(abs(speed - 5.0 * np.exp(-MU * 4e-3 / INDEX)))
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 0.9 < order < 1.1
