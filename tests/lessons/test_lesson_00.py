"""The checks of "Meet the hand": right answers pass, and every common slip is told for what it is."""

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson
from handlab.check.verdict import Outcome

RIGHT, WRONG = Outcome.RIGHT, Outcome.WRONG
SEEN = {"FDP2": {"mcp2", "pip2", "dip2"}, "ODM": {"cmc4", "cmc5"}, "LUM1": {"mcp2", "pip2", "dip2"}}


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


def said(exercise, *answers):
    return lesson("00").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG
    return verdict.text


def test_the_knuckle_of_the_middle_finger_is_the_head_of_its_metacarpal():
    assert said("knuckles", "mcp3", "metacarpal_3").outcome is RIGHT
    assert said("knuckles", "MCP3", "Metacarpal 3").outcome is RIGHT


@pytest.mark.parametrize(
    ("joint", "bone", "word"),
    [
        ("pip3", "proximal_phalanx_3", "nearer to the wrist"),
        ("mcp2", "metacarpal_2", "index finger"),
        ("mcp3", "proximal_phalanx_3", "glides"),
        ("mcp3", "capitate", "Which bone carries"),
        ("mpc3", "metacarpal_3", "mcp3"),
        (3, "metacarpal_3", "in quotes"),
    ],
)
def test_a_wrong_knuckle_is_told_apart(joint, bone, word):
    assert word in hint("knuckles", joint, bone)


def test_a_right_angle_is_half_pi(hand):
    assert said("radians", hl.pose(hand, {"pip2.flexion_extension": np.pi / 2})).outcome is RIGHT
    assert "np.deg2rad" in hint("radians", hl.pose(hand, {"pip2.flexion_extension": 1.0}))
    moved = hl.pose(hand, {"pip2.flexion_extension": np.pi / 2, "dip2.flexion_extension": 1.0})
    assert "dip2.flexion_extension" in hint("radians", moved)
    assert said("radians", 1.57).outcome is WRONG


def measured(hand, flexion_deg):
    start = hl.pose(hand, {"mcp2.flexion_extension": np.deg2rad(flexion_deg)})
    clip = hl.simulate(hand, {"DI1": 0.5}, seconds=1, hold=["wrist", "mcp2.flexion_extension"], start=start)
    return np.rad2deg(clip.angle[-1, hand.dof_names.index("mcp2.deviation")])


def test_the_measured_spread_passes_and_its_slips_are_told(hand):
    straight, fist = measured(hand, 0), measured(hand, 90)
    assert 0.0 < fist < 0.5 * straight
    assert said("spread", straight, fist).outcome is RIGHT
    assert said("spread", straight + 0.25, fist).outcome is RIGHT
    assert said("spread", straight + 0.4, fist).outcome is WRONG
    assert "radians" in hint("spread", np.deg2rad(straight), np.deg2rad(fist))
    assert "right way round" in hint("spread", fist, straight)
    assert said("spread", "far", fist).outcome is WRONG
    assert said("spread", float("nan"), fist).outcome is WRONG


def test_the_equation_passes_in_any_form(hand):
    assert said("own_length", lambda hand, angle: hand.rest_length - hand.lever_arm @ (angle - hand.fibre_rest)).outcome is RIGHT
    by_sum = lambda hand, angle: [l0 - sum(r * (angle - hand.fibre_rest)) for l0, r in zip(hand.rest_length, hand.lever_arm, strict=True)]  # noqa: E731
    assert said("own_length", by_sum).outcome is RIGHT


@pytest.mark.parametrize(
    ("own", "word"),
    [
        (lambda hand, angle: hand.rest_length + hand.lever_arm @ (angle - hand.fibre_rest), "sign"),
        (lambda hand, angle: hand.rest_length - np.abs(hand.lever_arm) @ (angle - hand.fibre_rest), "comes out at"),
        (lambda hand, angle: hand.rest_length - hand.lever_arm @ angle, "relaxed posture"),
        (lambda hand, angle: -hand.lever_arm @ (angle - hand.fibre_rest), "length at rest"),
        (lambda hand, angle: 1000 * (hand.rest_length - hand.lever_arm @ (angle - hand.fibre_rest)), "millimetres"),
        (lambda hand, angle: hand.rest_length - hand.lever_arm @ np.rad2deg(angle - hand.fibre_rest), "degrees"),
        (lambda hand, angle: angle, "shape"),
        (lambda hand, angle: hand.lever_arm @ hand.lever_arm, "could not be read"),
        (3.0, "without brackets"),
    ],
)
def test_a_slip_in_the_equation_is_recognised(own, word):
    assert word in hint("own_length", own)


def test_the_students_function_cannot_pass_by_asking_in_one_posture_only(hand):
    frozen = hl.rest(hand).fibre_length
    assert said("own_length", lambda hand, angle: frozen).outcome is WRONG


def test_any_prediction_that_names_joints_is_noted():
    assert said("predict", {"FDP2": "wrist", "ODM": ["ip1"], "lumbrical_1": {"mcp2.flexion_extension"}}).outcome is Outcome.NOTED
    assert "ODM" in hint("predict", {"FDP2": "wrist", "LUM1": "mcp2"})
    assert "cmc" in hint("predict", {**SEEN, "ODM": "cmc6"}), "an unknown joint is answered with the nearest"
    assert said("predict", {**SEEN, "ODM": set()}).outcome is WRONG


def test_the_joints_that_move_are_those_and_no_others():
    assert said("name", SEEN).outcome is RIGHT
    assert "follow" in hint("name", {**SEEN, "ODM": {"cmc5"}})
    assert "mcp5" in hint("name", {**SEEN, "ODM": {"cmc4", "cmc5", "mcp5"}})
    assert "held" in hint("name", {**SEEN, "FDP2": {"wrist", "mcp2", "pip2", "dip2"}})
    assert "1 more joint moved" in hint("name", {**SEEN, "LUM1": {"mcp2", "pip2"}})
    assert "dip2" not in hint("name", {**SEEN, "LUM1": {"mcp2", "pip2"}}), "a hint is no answer"


def test_the_joints_of_the_exercise_are_those_that_the_arms_and_couplings_reach(hand):
    """The check simulates; this follows the lever arms and the couplings."""
    for muscle, joints in SEEN.items():
        row = hand.lever_arm[hand.muscle_names.index(hand.muscles[muscle].name)]
        reached = {dof.joint for dof, arm in zip(hand.dofs.values(), row, strict=True) if arm}
        followers = {dof.joint for dof in hand.dofs.values() if dof.driver and hand.dofs[dof.driver].joint in reached and dof.ratio}
        assert (reached | followers) - {"wrist"} == joints


def fibre_ratio(hand, wrist_deg):
    """By hand: R (phi - phi0) over the joints that FDP2 crosses."""
    arms = {arm.dof: arm.used for arm in hand.muscles["FDP2"].lever_arms}
    target = {name: hand.dofs[name].limits[1] for name in arms if name.startswith(("mcp2.f", "pip2", "dip2"))}
    target["wrist.flexion_extension"] = np.deg2rad(wrist_deg)
    rest = dict(zip(hand.dof_names, hand.fibre_rest, strict=True))
    shortening = sum(arms[name] * (angle - rest[name]) for name, angle in target.items())
    return 1.0 - shortening / hand.muscles["FDP2"].rest_length


def test_a_closed_finger_with_a_flexed_wrist_has_a_fibre_that_cannot_pull(hand):
    flexed, extended = fibre_ratio(hand, 60), fibre_ratio(hand, -40)
    assert 0.2 < flexed < 0.6 < extended < 1.0
    assert said("fist", flexed, extended, "extended").outcome is RIGHT
    assert "0.6" in hint("fist", flexed, extended, "flexed")
    assert "upper limits" in hint("fist", extended, flexed, "extended")
    assert "millimetres" in hint("fist", flexed * 66, extended * 66, "extended")
    assert said("fist", flexed + 0.02, extended, "extended").outcome is WRONG


def test_the_fourth_dorsal_interosseus_is_printed_at_the_wrong_finger():
    assert said("doubt", "DI4", "mcp4").outcome is RIGHT
    assert said("doubt", "dorsal_interosseus_4", "mcp4").outcome is RIGHT
    assert "abductor of its own" in hint("doubt", "DI4", "mcp5")
    assert said("doubt", "DI4", "mcp3").outcome is WRONG
    assert "Which finger has no muscle" in hint("doubt", "DI1", "mcp4")


def test_a_notebook_that_changes_its_hand_does_not_change_the_answers(hand):
    assert said("spread", 0.0, 0.0).outcome is WRONG
    with pytest.raises(ValueError, match="read-only"):
        hand.lever_arm[0, 0] = 1.0
