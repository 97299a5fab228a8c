"""One bone against what can be computed on paper: exact solutions, stability limits, orders, power."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from handlab.physics.one_bone import RULES, RUN_AWAY, march
from handlab.physics.rotation import explicit_step, implicit_speed, largest_step, leapfrog_first, leapfrog_speed, printed_step, turned
from handlab.physics.torque import friction_opposing, friction_printed

EXAMPLES = json.loads((Path(__file__).parents[1] / "data" / "equations_examples.json").read_text())
INDEX = EXAMPLES["chain"]["poses"][0]["J_total_MCP"]
MU = 0.015
TAU = INDEX / MU
SOUND = ("explicit", "implicit", "leapfrog")


def nothing(time, angle):
    return 0.0


def spring(time, angle):
    return -0.08 * (angle - 0.3)


def test_the_leapfrog_gives_the_worked_numbers_of_the_mass_on_a_spring():
    """Section 13 of the facts: mass for inertia, no friction."""
    example = EXAMPLES["leapfrog"]
    m, k, dt = example["m"], example["k"], example["dt"]
    positions, speeds = [example["x"][0]], []
    for n in range(len(example["v_half"])):
        force = -k * positions[-1]
        speeds.append(float(leapfrog_first(0.0, force, m, dt, 0.0) if n == 0 else leapfrog_speed(speeds[-1], force, m, dt, 0.0)))
        positions.append(float(turned(positions[-1], speeds[-1], dt)))
    np.testing.assert_allclose(positions[:4], example["x"], rtol=1e-6)
    np.testing.assert_allclose(speeds, example["v_half"], rtol=1e-5)


def test_the_damped_leapfrog_is_the_printed_recursion():
    """(1 - g dt/2) v + dt a over 1 + g dt/2 with g = mu / J."""
    g, dt, a = MU / INDEX, 1e-3, 700.0
    expected = ((1 - g * dt / 2) * 3.0 + dt * a) / (1 + g * dt / 2)
    assert float(leapfrog_speed(3.0, a * INDEX, INDEX, dt, MU)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("case", EXAMPLES["friction"]["cases"])
def test_a_step_of_each_rule_has_the_worked_friction(case):
    torque, speed, dt = case["T_muscle"], case["omega"], 1e-4
    for step, name in ((printed_step, "printed"), (explicit_step, "opposing")):
        angle, after = step(0.2, speed, torque, INDEX, dt, MU)
        assert float(after) == pytest.approx(speed + dt * case[name] / INDEX, rel=1e-12)
        assert float(angle) == pytest.approx(0.2 + dt * float(after), rel=1e-12)


@pytest.mark.parametrize("body", EXAMPLES["stability"])
def test_the_limit_of_the_step_is_the_worked_one(body):
    row = EXAMPLES["stability"][body]
    assert float(largest_step(row["J"], MU)) == pytest.approx(row["explicit_limit_dt_s"], rel=5e-4)
    assert float(explicit_step(0.0, 1.0, 0.0, row["J"], 1 / 60, MU)[1]) == pytest.approx(row["factor_at_1_over_60"], rel=5e-4)


@pytest.mark.parametrize("rule", SOUND)
def test_a_steady_torque_gives_the_exact_angle_and_speed(rule):
    torque, seconds = 0.03, 0.02
    moved = march(rule, lambda time, angle: torque, INDEX, MU, 1e-6, seconds)
    decay = np.exp(-seconds / TAU)
    assert moved.angle[-1] == pytest.approx(torque / MU * (seconds - TAU * (1 - decay)), rel=1e-3)
    assert moved.speed[-1] == pytest.approx(torque / MU * (1 - decay), rel=1e-3)


@pytest.mark.parametrize(("rule", "order"), [("explicit", 1), ("implicit", 1), ("leapfrog", 2)])
def test_a_rule_has_its_order_of_accuracy(rule, order):
    """A spring and a changing torque, against scipy at 1e-12; angle and speed."""

    def pull(time, angle):
        return spring(time, angle) + 0.02 * np.sin(80.0 * time)

    seconds, steps = 0.01, np.array([2e-4, 1e-4, 5e-5, 2.5e-5])
    exact = solve_ivp(lambda t, s: [s[1], (pull(t, s[0]) - MU * s[1]) / INDEX], (0, seconds), [0.1, 2.0], rtol=1e-12, atol=1e-14).y[:, -1]
    for k, name in enumerate(("angle", "speed")):
        errors = [abs(getattr(march(rule, pull, INDEX, MU, dt, seconds, angle=0.1, speed=2.0), name)[-1] - exact[k]) for dt in steps]
        assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(order, abs=0.1), name


@pytest.mark.parametrize(("factor", "grows"), [(0.98, False), (1.02, True)])
def test_the_explicit_step_explodes_where_theory_says(factor, grows):
    moved = march("explicit", nothing, INDEX, MU, factor * float(largest_step(INDEX, MU)), 3.0, speed=1.0)
    after = abs(float(moved.speed[-1]))
    assert after > 1e3 if grows else after < 1e-3


@pytest.mark.parametrize("factor", [0.3, 1.0, 6.0, 700.0])
def test_the_implicit_step_brakes_without_turning_back_however_long_it_is(factor):
    moved = march("implicit", nothing, INDEX, MU, factor * TAU, 20 * factor * TAU, speed=10.0)
    assert (np.diff(moved.speed) < 0).all() and (moved.speed > 0).all()
    assert moved.speed[1] == pytest.approx(10.0 / (1.0 + factor), rel=1e-12)


@pytest.mark.parametrize("factor", [0.5, 1.9, 6.0])
def test_the_leapfrog_rings_above_the_limit_but_decays_at_any_step(factor):
    dt = factor * TAU
    half = [float(leapfrog_first(10.0, 0.0, INDEX, dt, MU))]
    for _ in range(60):
        half.append(float(leapfrog_speed(half[-1], 0.0, INDEX, dt, MU)))
    rings = np.sign(half[1]) != np.sign(half[0])
    assert rings == (dt > float(largest_step(INDEX, MU)))
    assert abs(half[-1]) < 1e-6 < 0.5 * abs(half[0])


@pytest.mark.parametrize("rule", ["implicit", "leapfrog"])
@pytest.mark.parametrize("dt", [1e-5, 1e-3])
def test_a_bone_coasts_speed_times_inertia_over_friction(rule, dt):
    moved = march(rule, nothing, INDEX, MU, dt, 40 * TAU, speed=10.0)
    assert moved.angle[-1] == pytest.approx(10.0 * TAU, rel=1e-9)


def test_with_printed_friction_a_bone_without_muscles_never_stops():
    moved = march("printed", nothing, INDEX, MU, 1e-4, 1.0, speed=3.0)
    assert np.array_equal(moved.speed, np.full(len(moved.speed), 3.0))
    assert abs(march("explicit", nothing, INDEX, MU, 1e-4, 1.0, speed=3.0).speed[-1]) < 1e-9


def test_braking_with_printed_friction_runs_away_to_the_worked_speed():
    example = EXAMPLES["simulation"]["results"]["braking_omega_after_20ms"]
    for rule, name in (("printed", "printed"), ("explicit", "opposing")):
        moved = march(rule, lambda time, angle: -0.02, INDEX, MU, 1e-5, 0.02, speed=5.0)
        assert moved.speed[-1] == pytest.approx(example[name], rel=0.01)


FINITE = st.floats(-50, 50).filter(lambda value: value == 0.0 or abs(value) > 1e-6)


@given(st.floats(-1, 1).filter(lambda value: abs(value) > 1e-6), FINITE, st.floats(1e-4, 1.0))
def test_opposing_friction_never_gives_power_and_printed_friction_gives_it_exactly_against_the_muscle(torque, speed, friction):
    opposing = (float(friction_opposing(torque, speed, friction)) - torque) * speed
    printed = (float(friction_printed(torque, speed, friction)) - torque) * speed
    assert opposing <= 0.0
    if abs(friction * speed) > 1e-9 * abs(torque):  # smaller friction is lost in rounding
        assert (printed > 0.0) is (torque * speed < 0.0)


def test_a_bone_that_has_run_away_is_given_up_before_its_numbers_overflow():
    moved = march("printed", lambda time, angle: -0.02, INDEX, MU, 1e-4, 10.0, speed=5.0)
    assert RUN_AWAY < abs(moved.speed[-1]) < 2 * RUN_AWAY
    assert np.isfinite(moved.angle).all() and len(moved.time) == len(moved.angle) == len(moved.speed) < 3000


@pytest.mark.parametrize("rule", RULES)
def test_a_mirrored_bone_moves_mirrored(rule):
    one = march(rule, lambda time, angle: 0.02 - 0.1 * angle, INDEX, MU, 1e-3, 0.1, angle=0.1, speed=1.0)
    other = march(rule, lambda time, angle: -0.02 - 0.1 * angle, INDEX, MU, 1e-3, 0.1, angle=-0.1, speed=-1.0)
    np.testing.assert_allclose(other.angle, -one.angle, rtol=1e-12)
    assert np.ptp(one.angle) > 0.01


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"rule": "euler"}, "printed, explicit, implicit, leapfrog"),
        ({"dt": 0.0}, "dt is 0"),
        ({"dt": float("nan")}, "dt is nan"),
        ({"seconds": -1.0}, "seconds is -1"),
        ({"inertia": 0.0}, "inertia is 0"),
        ({"friction": -0.1}, "friction is -0.1"),
    ],
)
def test_a_march_that_cannot_be_made_is_refused_by_name(change, word):
    asked = {"rule": "implicit", "torque": nothing, "inertia": INDEX, "friction": MU, "dt": 1e-3, "seconds": 0.1, **change}
    with pytest.raises(ValueError, match=word):
        march(**asked)


def test_without_friction_the_implicit_speed_is_the_explicit_one():
    assert float(implicit_speed(1.0, 0.1, INDEX, 1e-3, 0.0)) == pytest.approx(1.0 + 1e-3 * 0.1 / INDEX, rel=1e-12)
