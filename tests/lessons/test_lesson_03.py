"""The checks of "One bone turns": right answers pass, and every common slip is told for what it is."""

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson
from handlab.check.verdict import Outcome
from handlab.simulation.mechanics import moments_of_inertia

RIGHT, WRONG = Outcome.RIGHT, Outcome.WRONG
MU = 0.015


@pytest.fixture(scope="module")
def inertia():
    hand = hl.load_hand()
    straight = hl.pose(hand, dict.fromkeys(hand.moving_names, 0.0))
    return dict(zip(hand.dof_names, moments_of_inertia(hand, straight.angle), strict=True))


@pytest.fixture(scope="module")
def J(inertia):
    return inertia["mcp2.flexion_extension"]


def said(exercise, *answers):
    return lesson("03").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG
    return verdict.text


def test_any_guess_in_degrees_is_noted():
    assert said("guess", 90).outcome is Outcome.NOTED
    assert "one number" in hint("guess", "far")


def explicit(J):
    def step(angle, speed, pull, dt):
        speed = speed + dt * (pull - MU * speed) / J
        return angle + dt * speed, speed

    return step


def implicit(J):
    def step(angle, speed, pull, dt):
        speed = (speed + dt * pull / J) / (1 + dt * MU / J)
        return angle + dt * speed, speed

    return step


def slip(J, name):
    """The steps that students write."""

    def step(angle, speed, pull, dt):
        change = {
            "no friction": pull,
            "friction pushes": pull + MU * speed,
            "printed": np.sign(pull) * (abs(pull) - MU * abs(speed)),
        }.get(name, pull - MU * speed)
        new = speed + dt * change * (J if name == "times J" else 1 / J)
        if name == "old speed":
            return angle + dt * speed, new
        if name == "angle stands":
            return angle, new
        if name == "change only":
            return dt * new, new
        return (new, angle + dt * new) if name == "swapped" else (angle + dt * new, new)

    return step


def test_the_step_passes(J):
    assert said("step", explicit(J)).outcome is RIGHT
    assert said("step", lambda *given: np.array(explicit(J)(*given))).outcome is RIGHT


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("no friction", "missing"),
        ("friction pushes", "friction pushes"),
        ("printed", "printed friction"),
        ("times J", "divided"),
        ("old speed", "old speed"),
        ("angle stands", "stands still"),
        ("change only", "Add it to the old angle"),
        ("swapped", "speed came first"),
    ],
)
def test_a_slip_in_the_step_is_recognised(J, name, word):
    assert word in hint("step", slip(J, name))


def test_other_wrong_steps_are_told_with_numbers_or_with_their_form(J):
    assert "the package has" in hint("step", lambda angle, speed, pull, dt: (1.0, 2.0))
    assert "two numbers" in hint("step", lambda angle, speed, pull, dt: 1.0)
    assert "without brackets" in hint("step", explicit(J)(0.0, 1.0, 0.0, 1e-4))
    assert "comes later" in hint("step", implicit(J))
    assert said("step", lambda angle, speed, pull, dt: ...).outcome is Outcome.OPEN
    assert said("step", lambda angle, speed, pull, dt: (..., ...)).outcome is Outcome.OPEN


def test_a_step_that_is_right_in_one_case_only_does_not_pass(J):
    """Without a muscle the printed friction differs; with speed and torque of one sign it does not."""
    only_along = slip(J, "printed")
    same_sign = only_along(0.3, 2.0, 0.05, 1e-4)
    assert same_sign == pytest.approx(explicit(J)(0.3, 2.0, 0.05, 1e-4))
    assert said("step", only_along).outcome is WRONG


def test_the_repaired_step_passes_and_the_explicit_one_does_not(J):
    assert said("repair", implicit(J)).outcome is RIGHT
    assert "takes the old speed" in hint("repair", explicit(J))
    assert said("repair", lambda *given: ...).outcome is Outcome.OPEN


def test_the_finger_coasts_speed_times_J_over_mu(J):
    degrees = np.rad2deg(10.0 * J / MU)
    assert 0.5 < degrees < 1.5
    assert said("coast", degrees).outcome is RIGHT
    assert said("coast", 1.015 * degrees).outcome is RIGHT
    assert said("coast", 1.04 * degrees).outcome is WRONG
    assert "radians" in hint("coast", np.deg2rad(degrees))


def test_the_limits_are_two_J_over_mu_and_their_slips_are_told(inertia, J):
    finger, tip = 2000 * J / MU, 2000 * inertia["dip2.flexion_extension"] / MU
    assert 50 < finger / tip < 200
    assert said("limit", finger, tip).outcome is RIGHT
    assert said("limit", 0.98 * finger, tip).outcome is RIGHT
    assert "Try steps" in hint("limit", 0.9 * finger, tip)
    assert "seconds" in hint("limit", finger / 1000, tip)
    assert "change its sign" in hint("limit", finger / 2, tip)
    assert "J_tip" in hint("limit", finger, 3 * tip)
    assert "inertia of its own" in hint("limit", finger, finger)


def test_only_the_wrist_survives_a_step_of_a_frame(inertia):
    way = np.rad2deg(10 * inertia["wrist.flexion_extension"] / MU)
    assert said("sixty", {"wrist"}, way).outcome is RIGHT
    assert said("sixty", "wrist", way).outcome is RIGHT
    assert "mcp2 is not one" in hint("sixty", {"wrist", "mcp2"}, way)
    assert "wrist is missing" in hint("sixty", set(), way)
    assert "coast" in hint("sixty", {"wrist"}, way / 2)
    assert "in quotes" in hint("sixty", 3, way)


def test_printed_friction_pushes_where_torque_and_speed_differ_in_sign():
    """By hand: friction part of B is (0.1 - 0.03) - 0.1 = -0.03, times -2 is +0.06 W; C is the same; E has none."""
    assert said("push", {"B", "C"}, "E").outcome is RIGHT
    assert said("push", "BC", "e").outcome is RIGHT
    assert "another case" in hint("push", {"B"}, "E")
    assert "Case D" in hint("push", {"B", "C", "D"}, "E")
    assert "nothing pulls" in hint("push", {"B", "C"}, "D")
    assert said("push", {"B", "Z"}, "E").outcome is WRONG


def test_the_runaway_speeds_pass_and_their_swap_is_told(J):
    """Exact: d(omega)/dt = (T +- mu omega) / J from 5 rad/s, T = -0.02; a hundredth of a millisecond is nearly exact."""
    tau, balance = J / MU, 0.02 / MU
    printed = balance + (5.0 - balance) * np.exp(0.01 / tau)
    sound = -balance + (5.0 + balance) * np.exp(-0.01 / tau)
    assert printed > 1000
    assert -1.4 < sound < -1.2
    assert said("runaway", printed, sound).outcome is RIGHT
    assert "swapped" in hint("runaway", sound, printed)
    assert "printed rule does not end" in hint("runaway", 1.2 * printed, sound)
    assert "against the motion does not end" in hint("runaway", printed, -sound)


def exact(J, mu, seconds=0.1, pull=0.05):
    tau = J / mu
    return pull / mu * (seconds - tau * (1 - np.exp(-seconds / tau)))


def test_inertia_hardly_matters_and_friction_does(J):
    heavy, stiff = 100 * (exact(2 * J, MU) / exact(J, MU) - 1), 100 * (exact(J, 2 * MU) / exact(J, MU) - 1)
    assert -3 < heavy < -0.5
    assert -52 < stiff < -45
    assert said("matters", heavy, stiff).outcome is RIGHT
    assert "swapped" in hint("matters", stiff, heavy)
    assert "percent" in hint("matters", heavy / 100, stiff / 100)
    assert "less far" in hint("matters", -heavy, stiff)
    assert "friction does not change" in hint("matters", heavy, stiff + 3)


def test_the_orders_are_one_and_two():
    assert said("order", 10, 100).outcome is RIGHT
    assert "implicit" in hint("order", 100, 100)
    assert "leapfrog" in hint("order", 10, 10)
    assert "Turn it round" in hint("order", 0.1, 0.01)
