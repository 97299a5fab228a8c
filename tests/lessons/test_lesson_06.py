"""The checks of "Thumb, wrist and key frames": right answers pass, and every common slip is told for what it is."""

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson
from handlab.check.verdict import Outcome
from handlab.physics.muscle import active_force_length
from handlab.studies import measures

RIGHT, WRONG = Outcome.RIGHT, Outcome.WRONG
FLEXORS = [f"{muscle}{digit}" for muscle in ("FDP", "FDS") for digit in (2, 3, 4, 5)]
FIST = dict.fromkeys(("FDP2", "FDP3", "FDP4", "FDP5"), 0.2) | {"FPL": 0.1, "OPP": 0.1}


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


def said(exercise, *answers):
    return lesson("06").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG
    return verdict.text


def row(hand, muscle):
    return hand.muscle_names.index(hand.muscles[muscle].name)


def degrees(hand, angle, *names):
    return np.rad2deg([angle[hand.dof_names.index(name)] for name in names])


def middle(hand, angle):
    return float(degrees(hand, angle, *(f"{joint}3.flexion_extension" for joint in ("mcp", "pip", "dip"))).sum())


def test_palmar_abduction_is_not_radial_and_flexion_sweeps_across_the_palm(hand):
    """The axis and the anchor of the joint say so: velocity of the tip is axis x (tip - anchor), here by finite rotation of the bone."""
    assert said("directions", {"abduction": "palmar", "flexion": "ulnar"}).outcome is RIGHT
    assert "spreading" in hint("directions", {"abduction": "radial", "flexion": "ulnar"})
    assert "flexion:" in hint("directions", {"abduction": "palmar", "flexion": "distal"})
    assert "keys" in hint("directions", {"abduction": "palmar"})
    assert "keys" in hint("directions", "palmar")


def test_the_directions_follow_from_the_axes_of_the_saddle_joint(hand):
    from handlab.simulation.kinematics import body_transforms, posed_bone

    relaxed = hl.rest(hand).angle
    tip = posed_bone(hand, "distal_phalanx_1", relaxed).mean(axis=0)
    for name, way in (("cmc1.abduction_adduction", [0, 1, 0]), ("cmc1.flexion_opposition", [0, 0, -1])):
        dof = hand.dofs[name]
        frame = body_transforms(hand, relaxed)[hand.body_names.index("carpus")]
        velocity = np.cross(frame[:3, :3] @ dof.axis, tip - (frame[:3, :3] @ dof.anchor + frame[:3, 3]))
        assert velocity @ np.array(way) > 0.7 * np.linalg.norm(velocity), name


def test_the_long_abductor_of_the_thumb_turns_the_wrist_most(hand):
    clip = hl.simulate(hand, {"APL": 0.2}, seconds=2)
    most = hand.dof_names[int(np.abs(clip.angle[-1] - clip.angle[0]).argmax())]
    assert most == "wrist.deviation"
    assert said("name", most).outcome is RIGHT
    assert "name says" in hint("name", "cmc1.abduction_adduction")
    assert "largest" in hint("name", "ip1.flexion_extension")
    assert said("name", "thumb").outcome is WRONG


def test_opposition_cannot_do_without_the_opponens(hand):
    clip = hl.simulate(hand, "opposition-little", hold=["wrist"])
    turned = float(degrees(hand, clip.angle[-1] - clip.angle[0], "cmc1.axial_rotation")[0])
    flexed = float(degrees(hand, clip.angle[-1] - clip.angle[0], "cmc1.flexion_opposition")[0])
    assert turned == pytest.approx(17 / 53 * flexed, rel=1e-6), "the coupling of the saddle joint"
    assert turned > 3.0
    assert said("opposition", "OPP", turned).outcome is RIGHT
    assert said("opposition", "OPP", -turned).outcome is RIGHT, "the sign is not asked"
    assert "Compare all gaps" in hint("opposition", "EPB", turned)
    assert "Compare all gaps" in hint("opposition", "FDP3", turned)
    assert "radians" in hint("opposition", "OPP", np.deg2rad(turned))
    assert "does not turn" in hint("opposition", "OPP", turned + 3)


def at_rest(hand, wrist_deg, contraction):
    """By a long simulation, not by ``settle``."""
    start = hl.pose(hand, {"wrist.flexion_extension": np.deg2rad(wrist_deg)})
    return hl.simulate(hand, contraction, seconds=4, hold=["wrist"], start=start)


def test_the_wrist_moves_the_fingers(hand):
    flexed, extended = (middle(hand, at_rest(hand, wrist, {"FDP3": 0.0}).angle[-1]) for wrist in (60, -60))
    assert flexed + 50 < extended
    assert said("tenodesis", flexed, extended).outcome is RIGHT
    assert "swapped" in hint("tenodesis", extended, flexed)
    assert "held" in hint("tenodesis", flexed, flexed + 20)
    assert "radians" in hint("tenodesis", np.deg2rad(flexed), extended)


def test_stretched_fibres_do_it_extensor_in_flexion_flexor_in_extension():
    assert said("who", "EDC3", "FDS3").outcome is RIGHT
    assert "slack" in hint("who", "FDS3", "FDS3")
    assert "less than another" in hint("who", "EDC3", "FDP3")
    assert "does not reach" in hint("who", "EDC2", "FDS3")


def test_a_flexed_wrist_makes_a_weak_grip(hand):
    both = [row(hand, "FDP3"), row(hand, "FDS3")]
    force = {wrist: at_rest(hand, wrist, dict.fromkeys(FLEXORS, 1.0)).force[-1, both].sum() for wrist in (60, -30)}
    assert 0.05 < force[60] / force[-30] < 0.4
    assert said("insufficient", force[60], force[-30], "too short").outcome is RIGHT
    assert "together" in hint("insufficient", force[60], force[-30], "too long")
    assert "swapped" in hint("insufficient", force[-30], force[60], "too short")
    assert "+60" in hint("insufficient", 2 * force[60], force[-30], "too short")


def test_half_the_contraction_is_most_of_the_way(hand):
    relaxed = middle(hand, hl.rest(hand).angle)
    some, more = (middle(hand, at_rest(hand, -15, {"FDP3": value}).angle[-1]) - relaxed for value in (0.1, 0.2))
    percent = 100 * some / more
    assert 60 < percent < 90
    assert said("half", percent).outcome is RIGHT
    assert "if contraction were an angle" in hint("half", 50)
    assert "percent" in hint("half", percent / 100)
    assert "changes" in hint("half", 100 * (some + relaxed) / (more + relaxed))


def test_six_sliders_make_a_fist_and_what_is_open_cramped_or_away_is_named(hand):
    clip = hl.simulate(hand, FIST, seconds=2, hold=["wrist"])
    assert 195 < middle(hand, clip.angle[-1]) < 240
    assert min(abs(measures.pulp_to_bodies(hand, clip.skin(-1), 1, (f"middle_phalanx_{k}",))) for k in (2, 3)) < 0.006
    assert said("fist", FIST).outcome is RIGHT
    assert "ring finger is not closed" in hint("fist", FIST | {"FDP4": 0.02})
    assert "little finger is cramped" in hint("fist", FIST | {"FDP5": 0.9})
    assert "pulp of the thumb" in hint("fist", FIST | {"FPL": 0.0, "OPP": 0.0})
    assert "between 0 and 1" in hint("fist", FIST | {"FPL": 1.2})
    assert "six sliders" in hint("fist", FIST | {"FDS2": 0.2})
    assert "dictionary" in hint("fist", 0.2)
    assert said("fist", FIST | {"FPL": ...}).outcome is Outcome.OPEN


@pytest.fixture(scope="module")
def grips(hand):
    """The grip with the wrist held and free."""
    grip = dict.fromkeys(FLEXORS, 0.5)
    return hl.simulate(hand, grip, seconds=3, hold=["wrist"]), hl.simulate(hand, grip, seconds=3)


def test_a_free_wrist_runs_away_and_costs_the_grip_its_force(hand, grips):
    held, free = grips
    both = [row(hand, "FDP3"), row(hand, "FDS3")]
    end = float(degrees(hand, free.angle[-1], "wrist.flexion_extension")[0])
    lost = 100 * (1 - free.force[-1, both].sum() / held.force[-1, both].sum())
    assert end > -10
    assert 30 < lost < 80
    assert said("runaway", end, lost).outcome is RIGHT
    assert "Where does it end" in hint("runaway", end + 15, lost)
    assert "radians" in hint("runaway", np.deg2rad(end), lost)
    assert "does not end" in hint("runaway", end + 5, lost)
    assert "force lost" in hint("runaway", end, lost + 10)


def braced(hand, clip, frame):
    """Cramer's rule, by hand."""
    wrist = [hand.dof_names.index(f"wrist.{name}") for name in ("flexion_extension", "deviation")]
    (a, b), (c, d) = (
        [
            hand.lever_arm[k, axis] * hand.max_force[k] * active_force_length(clip.fibre_length[frame, k] / hand.rest_length[k])
            for k in (row(hand, "ECRB"), row(hand, "ECU"))
        ]
        for axis in wrist
    )
    x, y = -clip.torque[frame, wrist]
    return np.array([x * d - b * y, a * y - c * x]) / (a * d - b * c)


def test_the_brace_passes_and_its_slips_are_told(hand):
    assert said("brace", lambda clip, frame: braced(hand, clip, frame)).outcome is RIGHT
    assert said("brace", lambda clip, frame: list(braced(hand, clip, frame))).outcome is RIGHT
    assert "opposite" in hint("brace", lambda clip, frame: -braced(hand, clip, frame))
    assert "order" in hint("brace", lambda clip, frame: braced(hand, clip, frame)[::-1])
    assert "a row of A" in hint("brace", lambda clip, frame: 2 * braced(hand, clip, frame))
    assert "shape" in hint("brace", lambda clip, frame: 0.3)
    assert "a row of A" in hint("brace", lambda clip, frame: braced(hand, clip, -1)), "the frame counts"
    assert "without brackets" in hint("brace", [0.1, 0.2])
    assert said("brace", lambda clip, frame: ...).outcome is Outcome.OPEN


def test_two_extensors_keep_the_wrist_in_place_and_one_does_not(hand, grips):
    ecrb, ecu = (float(value) for value in braced(hand, grips[0], -1))
    assert 0.1 < ecu < ecrb < 1.0
    assert said("mend", {"ECRB": ecrb, "ECU": ecu}).outcome is RIGHT
    assert said("mend", {"extensor_carpi_radialis_brevis": ecrb, "ECU": ecu}).outcome is RIGHT
    assert "too far in flexion" in hint("mend", {"ECRB": 0.0, "ECU": 0.0})
    assert "too far in extension" in hint("mend", {"ECRB": 1.0, "ECU": 1.0})
    assert "radial side" in hint("mend", {"ECRB": ecrb + 0.1, "ECU": 0.0})
    assert "two extensors" in hint("mend", {"ECRB": ecrb, "ECU": ecu, "FDP2": 0.0})
    assert "dictionary" in hint("mend", [ecrb, ecu])


def test_a_natural_spline_leaves_its_keys_and_the_monotone_curve_does_not():
    """0.075 is the worked number of the natural cubic; two keys of 0.2 leave nothing but 0.2 between them."""
    assert said("between", 0.075, 0.2).outcome is RIGHT
    assert "swapped" in hint("between", 0.2, 0.075)
    assert "natural spline" in hint("between", 0.2, 0.2)
    assert "laboratory" in hint("between", 0.075, 0.3)


def test_key_frames_that_follow_the_grip_keep_the_wrist_and_others_do_not(hand):
    closing = {name: [(0, 0), (1.5, 0.3), (2, 0.3), (3.5, 0)] for name in FLEXORS}
    clip = hl.simulate(hand, closing, seconds=4, hold=["wrist"])
    frames = list(range(0, len(clip), 12))
    values = np.clip([braced(hand, clip, frame) for frame in frames], 0, 1)
    keys = {name: [(clip.time[f], values[k, i]) for k, f in enumerate(frames)] for i, name in enumerate(("ECRB", "ECU"))}
    assert said("keys", keys).outcome is RIGHT
    peak = braced(hand, clip, 120)
    ramps = {name: [(0, 0), (1.5, value), (2, value), (3.5, 0)] for name, value in zip(("ECRB", "ECU"), peak, strict=True)}
    assert "in flexion" in hint("keys", ramps), "the flexors turn the wrist most before the fingers are closed"
    assert "in extension" in hint("keys", {"ECRB": 0.3, "ECU": 0.1})
    assert "stays as it is" in hint("keys", keys | {"FDP2": [(0, 0)]})
    assert "between 0 and 1" in hint("keys", {"ECRB": [(0, 2.0)]})
    assert "dictionary" in hint("keys", 0.3)
    assert said("keys", {"ECRB": [(0, ...)]}).outcome is Outcome.OPEN


def test_the_two_swapped_tendons_of_the_carpal_tunnel_are_found(hand):
    assert said("doubt", {"FDP2", "FPL"}).outcome is RIGHT
    assert said("doubt", ["flexor_pollicis_longus", "FDP2"]).outcome is RIGHT
    assert "another tendon" in hint("doubt", "FDP2")
    assert "edge of the wrist" in hint("doubt", {"FDP2", "FPL", "FCU"})
    assert "fits a tendon" in hint("doubt", {"FDP2", "FPL", "FDS2"})
    for name in ("FDP2", "FPL"):
        printed = {arm.dof: abs(arm.printed) for arm in hand.muscles[name].lever_arms}
        assert printed["wrist.deviation"] > 2 * printed["wrist.flexion_extension"]
