"""The checks of "How hard can a muscle pull?": right answers pass, and every common slip is told for what it is."""

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson
from handlab.check.verdict import Outcome

RIGHT, WRONG, OPEN = Outcome.RIGHT, Outcome.WRONG, Outcome.OPEN


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


def said(exercise, *answers):
    return lesson("01").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG, verdict
    return verdict.text


def active(ratio):
    return max(0.0, 1 - 4 * (ratio - 1.1) ** 2)


def passive(ratio):
    return 2.77 * max(0.0, ratio - 1) ** 2


def test_the_force_passes_and_every_slip_is_told():
    assert said("own_force", lambda c, x: c * active(x) + passive(x)).outcome is RIGHT
    assert said("own_force", lambda c, x: ...).outcome is OPEN
    assert "pushes" in hint("own_force", lambda c, x: c * (1 - 4 * (x - 1.1) ** 2) + passive(x))
    assert "scaled the stretch" in hint("own_force", lambda c, x: c * (active(x) + passive(x)))
    assert "passive part is missing" in hint("own_force", lambda c, x: c * active(x))
    assert "slack" in hint("own_force", lambda c, x: c * active(x) + 2.77 * (x - 1) ** 2)
    assert "contraction is missing" in hint("own_force", lambda c, x: active(x) + passive(x))
    assert "the package has" in hint("own_force", lambda c, x: 1.0)
    assert "without brackets" in hint("own_force", 0.5)


def test_the_printed_curve_pushes_with_22_newtons():
    """Worked number: 1 - 4 (0.5 - 1.1)^2 = -0.44."""
    assert said("push", -22.0, 0.0).outcome is RIGHT
    assert "part of the maximum force" in hint("push", -0.44, 0.0)
    assert "sign" in hint("push", 22.0, 0.0)
    assert "filaments" in hint("push", -22.0, -22.0)
    assert said("push", -20.0, 0.0).outcome is WRONG


def test_the_peaks_are_those_of_the_formula():
    """Worked numbers: 1.1, and 1.3252 for the sum (8 * 0.1 + ... = 0 solved by hand: 8 (x - 1.1) = 5.54 (x - 1))."""
    total = (8 * 1.1 - 5.54) / (8 - 5.54)
    assert total == pytest.approx(1.3252, abs=1e-4)
    assert said("peak", 1.1, total).outcome is RIGHT
    assert said("peak", 1.104, total).outcome is RIGHT
    assert said("peak", 1.106, total).outcome is WRONG
    assert "exchanged" in hint("peak", total, 1.1)
    assert "text of the paper" in hint("peak", 1.0, total)
    assert said("guess_peak", 1.0).outcome is Outcome.NOTED
    assert said("guess_peak", "long").outcome is WRONG


def test_twice_the_contraction_is_twice_the_force_only_if_the_finger_is_held(hand):
    row, column = hand.muscle_names.index(hand.muscles["FDP2"].name), hand.dof_names.index("mcp2.flexion_extension")
    clip = {c: hl.simulate(hand, {"FDP2": c}, seconds=2, hold=["wrist"]) for c in (0.1, 0.2)}
    free = clip[0.2].force[-1, row] / clip[0.1].force[-1, row]
    angle = (clip[0.2].angle[-1, column] - hand.relaxed[column]) / (clip[0.1].angle[-1, column] - hand.relaxed[column])
    assert 1.1 < angle < free < 1.8
    assert said("twice", 2.0, free, angle).outcome is RIGHT
    assert "other way round" in hint("twice", 0.5, free, angle)
    from_zero = clip[0.2].angle[-1, column] / clip[0.1].angle[-1, column]
    assert "where the finger began" in hint("twice", 2.0, free, from_zero)
    assert "wrist held" in hint("twice", 2.0, 2.0, angle)


def test_the_deep_flexors_go_slack_with_fibres_at_rest_in_the_flat_hand(hand):
    """By hand: FDP2 loses 11.1 * 75 + 7.9 * 95 + 4.1 * 45 degrees of 66 mm."""
    taken = 11.1 * np.deg2rad(75) + 7.9 * np.deg2rad(95) + 4.1 * np.deg2rad(45)
    assert 1 - taken / 66 < 0.6
    assert said("closed", {"FDP2", "FDP3", "FDP4", "FDP5"}, set()).outcome is RIGHT
    assert "1 more" in hint("closed", {"FDP2", "FDP3", "FDP4"}, set())
    assert "FDS3 can still" in hint("closed", {"FDP2", "FDP3", "FDP4", "FDP5", "FDS3"}, set())
    assert "set()" in hint("closed", "FDP2", set())
    assert "relaxed" in hint("closed", {"FDP2", "FDP3", "FDP4", "FDP5"}, {"FDP2"})


def test_the_range_of_lengths_is_that_of_the_limits(hand):
    """FCR by hand: 17.5 mm over 75 degrees of flexion and 10.5 mm over 20 degrees of radial deviation, of 52 mm."""
    fcr = 1 - (17.5 * np.deg2rad(75) + 10.5 * np.deg2rad(20)) / 52
    flat = hand.with_fibre_rest("flat")
    low, high = np.array([hand.dofs[name].limits for name in hand.moving_names]).T
    short = []
    for k, row in enumerate(flat.lever_arm @ flat.coupling):
        pose = hl.pose(flat, dict(zip(hand.moving_names, np.where(row > 0, high, low), strict=True)))
        short.append(pose.fibre_length[k] / hand.rest_length[k])
    count = int(np.sum(np.array(short) < 0.6))
    assert 12 <= count <= 25
    assert said("doubt", fcr, count).outcome is RIGHT
    assert "too few" in hint("doubt", fcr, count - 1)
    assert "too many" in hint("doubt", fcr, count + 3)
    assert "limits of flexion" in hint("doubt", 1 - 17.5 * np.deg2rad(75) / 52, count)


def test_the_speed_factor_and_the_fastest_shortening(hand):
    clip = hl.simulate(hand, hl.keyframes("fist"))
    row = hand.muscle_names.index(hand.muscles["FDP2"].name)
    fastest = -np.min(np.diff(clip.fibre_length[:, row]) / np.diff(clip.time)) / hand.rest_length[row]
    assert 0.1 < fastest < 3.0
    own = lambda v: (1 - v / 10) / (1 + v / 2.5)  # noqa: E731
    assert said("speed", own, fastest).outcome is RIGHT
    assert "divided by the largest" in hint("speed", lambda v: (1 - v) / (1 + v / 0.25), fastest)
    assert "positive" in hint("speed", own, -fastest)
    assert "metres a second" in hint("speed", own, fastest * hand.rest_length[row])
    assert said("speed", own, 2 * fastest).outcome is WRONG
    assert said("speed", lambda v: ..., fastest).outcome is OPEN


def test_a_tendon_of_27_centimetres_stretches_by_an_eighth_of_the_fibre():
    assert said("tendon", 270, 0.033 * 270 / 66).outcome is RIGHT
    assert said("tendon", 220, 0.11).outcome is RIGHT
    assert "parts of the rest length" in hint("tendon", 270, 0.033 * 270)
    assert "give millimetres" in hint("tendon", 27, 0.0135)
    assert "does not follow" in hint("tendon", 270, 0.2)


def euler(command, dt, tau):
    a, values = 0.0, []
    for c in command:
        values.append(a)
        a += dt * (c - a) / tau
    return values


def test_the_activation_follows_its_command(hand):
    assert said("delay", euler).outcome is RIGHT
    assert said("delay", lambda command, dt, tau: ...).outcome is OPEN
    assert "itself" in hint("delay", lambda command, dt, tau: command)
    assert "the equation gives" in hint("delay", lambda command, dt, tau: euler(command, dt, 2 * tau))
    assert "shape" in hint("delay", lambda command, dt, tau: [0.0])
    assert "brackets" in hint("delay", [0.0])
