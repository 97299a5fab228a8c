"""The checks of "Lever arms and torque": right answers pass, and every common slip is told for what it is."""

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
    return lesson("02").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG, verdict
    return verdict.text


def test_the_torque_is_the_part_along_the_axis():
    assert said("own_torque", lambda a, r, f: a @ np.cross(r, f)).outcome is RIGHT
    assert said("own_torque", lambda a, r, f: np.linalg.det([a, r, f])).outcome is RIGHT
    assert said("own_torque", lambda a, r, f: ...).outcome is OPEN
    assert "arm x force" in hint("own_torque", lambda a, r, f: a @ np.cross(f, r))
    assert "printed reading" in hint("own_torque", lambda a, r, f: np.sign(a @ np.cross(r, f)) * np.linalg.norm(np.cross(r, f)))
    assert "one number" in hint("own_torque", lambda a, r, f: np.cross(r, f))
    assert "right angles" in hint("own_torque", lambda a, r, f: np.linalg.norm(r) * np.linalg.norm(f))
    assert "brackets" in hint("own_torque", 1.0)


def test_antagonists_cancel_about_the_axis_only():
    """Worked number of (2''): (0.1, 0.3, 0) about x."""
    assert said("antagonists", 0.3162, 0.1).outcome is RIGHT
    assert "vectors first" in hint("antagonists", np.linalg.norm([0.3, 0.2]) + np.linalg.norm([0.2, 0.1]), 0.1)
    assert "torque about the axis" in hint("antagonists", 0.3162, 0.3162)


def test_adduction_is_ulnar_at_one_finger_and_radial_at_another():
    right = {"PI1": "ulnar", "PI2": "radial", "PI3": "radial"}
    assert said("words", right, "wrist.deviation").outcome is RIGHT
    assert said("words", {"palmar_interosseus_1": "ulnar", "PI2": "radial", "PI3": "radial"}, "wrist.deviation").outcome is RIGHT
    assert "middle finger" in hint("words", {**right, "PI2": "ulnar"}, "wrist.deviation")
    assert "PI3" in hint("words", {"PI1": "ulnar", "PI2": "radial"}, "wrist.deviation")
    assert "lists all" in hint("words", right, "cmc1.abduction_adduction")
    assert said("words", {"PI1": ..., "PI2": ..., "PI3": ...}, ...).outcome is OPEN
    assert "dictionary" in hint("words", "ulnar", "wrist.deviation")


def test_a_lever_arm_is_excursion_per_radian():
    """Table 1 prints 7.9 mm."""
    assert said("measure", 7.9).outcome is RIGHT
    assert "shortens" in hint("measure", -7.9)
    assert "metres" in hint("measure", 0.0079)
    assert "radians" in hint("measure", 7.9 * np.pi / 180)
    assert said("measure", 8.0).outcome is WRONG


def test_torques_of_all_joints_are_the_transposed_arms_times_the_forces():
    assert said("all_torques", lambda hand, force: force @ hand.lever_arm).outcome is RIGHT
    assert "signs are lost" in hint("all_torques", lambda hand, force: np.abs(hand.lever_arm).T @ force)
    assert "other way round" in hint("all_torques", lambda hand, force: -hand.lever_arm.T @ force)
    assert "shape" in hint("all_torques", lambda hand, force: force)
    assert "sum of arm times force" in hint("all_torques", lambda hand, force: 0 * force[:31])


def test_the_largest_opponent_is_read_from_the_recorded_forces(hand):
    clip = hl.simulate(hand, hl.keyframes("fist"))
    k = hand.dof_names.index("mcp2.flexion_extension")
    torque = {row.abbreviation: hand.lever_arm[i, k] * clip.force[-1, i] for i, row in enumerate(hand.muscles.values())}
    worst = min(torque, key=torque.get)
    share = -torque[worst] / torque["FDP2"]
    assert 0.1 < share < 1.0
    assert said("opponent", worst, share).outcome is RIGHT
    assert said("opponent", worst, -share).outcome is RIGHT
    assert "extends mcp2 most" in hint("opponent", "FDP2", share)
    assert said("opponent", worst, 1.2 * share).outcome is WRONG
    assert said("guess_opponent", "EDC2").outcome is Outcome.NOTED
    assert said("guess_opponent", "EDC9").outcome is WRONG


def required(hand):
    low, high = np.array([hand.dofs[name].limits for name in hand.moving_names]).T
    return np.abs(hand.lever_arm @ hand.coupling) @ (high - low)


def test_required_excursion_adds_sizes_and_not_signed_arms(hand):
    assert said("required", required).outcome is RIGHT
    low, high = np.array([hand.dofs[name].limits for name in hand.moving_names]).T
    assert "without sign" in hint("required", lambda hand: (hand.lever_arm @ hand.coupling) @ (high - low))
    assert "mm" in hint("required", lambda hand: 1.1 * required(hand))
    assert "shape" in hint("required", lambda hand: 0.1)
    assert said("required", lambda hand: ...).outcome is OPEN


def test_the_thumb_muscles_that_are_asked_for_too_much(hand):
    over = required(hand) > hand.rest_length
    right = {
        row.abbreviation
        for row, too in zip(hand.muscles.values(), over, strict=True)
        if too and row.region in ("thenar", "long thumb muscles")
    }
    assert said("too_far", right).outcome is RIGHT
    assert "At least one more" in hint("too_far", set())
    assert "can serve" in hint("too_far", right | {"APB"})
    assert "not of the thumb" in hint("too_far", right | {"FCU"})
    assert "set of names" in hint("too_far", "FPL")


def test_a_torn_pulley_trades_motion_for_torque():
    assert said("pulley", 12 / 7.9, np.rad2deg(15 / 7.9), np.rad2deg(15 / 12)).outcome is RIGHT
    assert "torque grows" in hint("pulley", 7.9 / 12, 108.8, 71.6)
    assert "radians" in hint("pulley", 1.519, 15 / 7.9, 71.6)
    assert "after" in hint("pulley", 1.519, 108.8, 108.8)


def test_a_lumbrical_on_a_taut_tendon_has_its_arms_minus_those_of_the_deep_flexor():
    """Worked numbers: -1.8, -9.7 and -4.8 mm."""
    assert said("lumbrical", [-1.8, -9.7, -4.8]).outcome is RIGHT
    assert "takes its arm away" in hint("lumbrical", [20.4, 6.1, 3.4])
    assert "metres" in hint("lumbrical", [-0.0018, -0.0097, -0.0048])
    assert "minus" in hint("lumbrical", [9.3, -1.8, -0.7])
    assert "three numbers" in hint("lumbrical", 4.0)


def test_the_strongest_the_farthest_and_the_hardest_working(hand):
    """Table: FCU 6.7 % and 42 mm, ECRL 3.5 % and 93 mm."""
    joule = 2 / 3 * 3.5 * hand.newton_per_percent * 0.093
    assert said("work", "FCU", "ECRL", "ECRL", joule).outcome is RIGHT
    assert "two thirds" in hint("work", "FCU", "ECRL", "ECRL", 1.5 * joule)
    assert "dashed lines" in hint("work", "FCU", "ECRL", "FCU", joule)
    assert said("work", "FCR", "ECRL", "ECRL", joule).outcome is WRONG


def test_three_muscles_have_an_arm_of_the_other_sign_in_the_table(hand):
    printed = hl.load_hand(reading="printed").lever_arm
    right = {row.abbreviation for row, p, u in zip(hand.muscles.values(), printed, hand.lever_arm, strict=True) if (p * u < 0).any()}
    assert said("doubt", right).outcome is RIGHT
    assert "1 more" in hint("doubt", right - {"EIP"})
    assert "no sign" in hint("doubt", right | {"FDP2"})
    assert "quotes" in hint("doubt", "EIP")
