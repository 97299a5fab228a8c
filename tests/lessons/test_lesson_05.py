"""The checks of "A finger with antagonists": right answers pass, and every common slip is told for what it is."""

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson
from handlab.check.verdict import Outcome

RIGHT, WRONG, NOTED, OPEN = Outcome.RIGHT, Outcome.WRONG, Outcome.NOTED, Outcome.OPEN
MUSCLES = ["FDP3", "FDS3", "EDC3", "LUM2", "DI2", "DI3"]
# Arms in mm at MCP, PIP and DIP, rest lengths in mm and strengths in percent, typed from the table of the paper.
ARMS = np.array([[11.1, 7.9, 4.1], [11.9, 6.2, 0.0], [-8.6, -2.8, -2.2], [9.3, -1.8, -0.7], [3.7, -2.6, -1.6], [3.7, -2.6, -1.6]]) / 1000


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="module")
def finger(hand):
    """(rows of the six muscles, columns of the three flexions)."""
    rows = [hand.muscle_names.index(hand.muscles[name].name) for name in MUSCLES]
    return rows, [hand.dof_names.index(f"{joint}3.flexion_extension") for joint in ("mcp", "pip", "dip")]


def said(exercise, *answers):
    return lesson("05").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG
    return verdict.text


def at_rest(hand, finger, contraction, *, hold=("wrist",), seconds=6):
    """MCP, PIP and DIP in degrees by a long simulation, not by ``settle``."""
    clip = hl.simulate(hand, contraction or {"FDP3": 0.0}, seconds=seconds, hold=hold, start=hl.rest(hand))
    return np.rad2deg(clip.angle[-1, finger[1]])


def test_the_arms_of_the_lesson_are_those_of_the_table(hand, finger):
    np.testing.assert_allclose(hand.lever_arm[np.ix_(*finger)], ARMS, atol=1e-9)


def test_the_torque_of_own_lines_passes_and_its_slips_are_told(hand, finger):
    rows, columns = finger
    l0, strongest, relaxed, kappa = hand.rest_length[rows], hand.max_force[rows], hand.relaxed[columns], hand.stiffness[columns]

    def own(angle, contraction, spring=-1.0, stretch=1.0):
        ratio = 1 - ARMS @ (angle - relaxed) / l0
        force = strongest * (contraction * np.maximum(0, 1 - 4 * (ratio - 1.1) ** 2) + stretch * 2.77 * np.maximum(0, ratio - 1) ** 2)
        return ARMS.T @ force + spring * kappa * (angle - relaxed)

    assert said("torque", own).outcome is RIGHT
    assert "stiffness of the joints is missing" in hint(
        "torque", lambda a, c: own(a, c, spring=0.0) if not np.allclose(a, relaxed) else own(a, c)
    )
    assert "pushes away" in hint("torque", lambda a, c: own(a, c, spring=1.0))
    assert "passive part" in hint("torque", lambda a, c: own(a, c, stretch=0.0))
    assert "other way round" in hint("torque", lambda a, c: -own(a, c))
    assert "shape" in hint("torque", lambda a, c: own(a, c)[:2])
    assert "without brackets" in hint("torque", own(relaxed, np.ones(6)))
    assert said("torque", lambda a, c: ...).outcome is OPEN


@pytest.fixture(scope="module")
def signs(hand, finger):
    relaxed = np.rad2deg(hand.relaxed[finger[1]])
    changes = {name: at_rest(hand, finger, {name: 0.3}) - relaxed for name in MUSCLES[:5]}
    return {name: "".join("+" if by > 0 else "-" for by in change) for name, change in changes.items()}


def test_what_muscles_do_alone_is_measured_and_the_extensor_bends_the_pip(signs):
    assert signs == {"FDP3": "+++", "FDS3": "++-", "EDC3": "-+-", "LUM2": "+--", "DI2": "+--"}
    assert said("alone", signs).outcome is RIGHT
    assert "EDC3: the PIP" in hint("alone", signs | {"EDC3": "---"})
    assert "FDS3: the DIP" in hint("alone", signs | {"FDS3": "++0"})
    assert "three signs" in hint("alone", signs | {"FDS3": "++"})
    assert "keys" in hint("alone", {"FDS3": "++0"})


def test_a_guess_is_noted_whatever_it_is_if_it_has_the_form(signs):
    assert said("guess", dict.fromkeys(signs, "000")).outcome is NOTED
    assert said("guess", dict.fromkeys(signs, "yes")).outcome is WRONG
    assert said("guess_stiff", "softer", "stiffer").outcome is NOTED
    assert said("guess_stiff", "harder", "stiffer").outcome is WRONG
    assert said("guess_stiff", ..., "stiffer").outcome is OPEN


def test_a_held_knuckle_lets_the_extensor_open_the_pip(hand, finger):
    free, held = (at_rest(hand, finger, {"EDC3": 1.0}, hold=hold)[1] for hold in (["wrist"], ["wrist", "mcp3"]))
    assert free > 35 and held < 5
    assert said("bouvier", free, held).outcome is RIGHT
    assert "swapped" in hint("bouvier", held, free)
    assert "radians" in hint("bouvier", np.deg2rad(free), held)
    assert "does not rest" in hint("bouvier", free - 5, held)


def test_the_stretched_flexors_hold_the_pip_bent(hand, finger):
    clip = hl.simulate(hand, {"EDC3": 1.0}, seconds=6, hold=["wrist"], start=hl.rest(hand))
    torque = float((ARMS[:2, 1] * clip.force[-1, finger[0][:2]]).sum())
    assert 0.05 < torque < 0.15
    assert said("who", {"FDP3", "FDS3"}, torque).outcome is RIGHT
    assert "another one" in hint("who", {"FDP3"}, torque)
    assert "does not bend" in hint("who", {"FDP3", "FDS3", "DI2"}, torque)
    assert "not among the six" in hint("who", {"FDP2"}, torque)
    assert "N m" in hint("who", {"FDP3", "FDS3"}, 1000 * torque)


def test_the_finger_opens_without_its_extensor(hand, finger):
    opening = {"DI2": 0.4, "DI3": 0.4}
    mcp, pip, dip = at_rest(hand, finger, opening)
    assert mcp > 80 and max(pip, dip) < 5
    assert said("open", opening, mcp).outcome is RIGHT
    assert "keep silent" in hint("open", opening | {"EDC3": 0.1}, mcp)
    assert "PIP still rests" in hint("open", {"LUM2": 1.0}, mcp)
    assert "MCP does not rest" in hint("open", opening, mcp - 20)
    assert "between 0 and 1" in hint("open", {"DI2": 1.4}, mcp)
    assert "dictionary" in hint("open", 0.4, mcp)


def test_a_straight_finger_takes_both(hand, finger):
    straight = {"EDC3": 1.0, "DI2": 0.29, "DI3": 0.32}
    assert np.abs(at_rest(hand, finger, straight)).max() < 5
    assert said("straight", straight).outcome is RIGHT
    assert "MCP rests at -28" in hint("straight", {"EDC3": 1.0})
    assert "too far bent" in hint("straight", {"DI2": 0.3, "DI3": 0.3})
    assert "little finger" in hint("straight", {"EDC3": 1.0, "DI2": 0.1, "DI3": 0.5})
    assert said("straight", {"EDC3": ...}).outcome is OPEN


def test_the_papers_choice_straightens_the_resting_finger(hand, finger):
    flat = hand.with_fibre_rest("flat")
    angle = hl.simulate(flat, {"FDP3": 0.0}, seconds=10, fps=1, hold=["wrist"], start=hl.rest(hand)).angle[-1]
    straighter = float(np.rad2deg(hand.relaxed[finger[1]] - angle[finger[1]]).sum())
    assert 4 < straighter < 15
    assert said("cascade", straighter, "EDC3").outcome is RIGHT
    assert "radians" in hint("cascade", np.deg2rad(straighter), "EDC3")
    assert "positive" in hint("cascade", -straighter, "EDC3")
    assert "not the difference" in hint("cascade", straighter + 5, "EDC3")
    assert "stretched" in hint("cascade", straighter, "FDP3")


@pytest.fixture(scope="module")
def own_stiffness(hand, finger):
    rows, columns = finger
    l0, strongest, relaxed = hand.rest_length[rows], hand.max_force[rows], hand.relaxed[columns]

    def own(angle, contraction, joint=1.0, active=1.0, passive=1.0):
        ratio = 1 - ARMS @ (angle - relaxed) / l0
        slope = active * contraction * np.where(np.abs(ratio - 1.1) < 0.5, -8 * (ratio - 1.1), 0) + passive * 5.54 * np.maximum(
            0, ratio - 1
        )
        return joint * hand.stiffness[columns] + (ARMS**2).T @ (strongest / l0 * slope)

    return own


def test_the_stiffness_of_own_lines_passes_and_its_slips_are_told(own_stiffness):
    assert said("stiffness", own_stiffness).outcome is RIGHT
    assert "own stiffness" in hint("stiffness", lambda a, c: own_stiffness(a, c, joint=0.0))
    assert "active slope is missing" in hint("stiffness", lambda a, c: own_stiffness(a, c, active=0.0))
    assert "other sign" in hint("stiffness", lambda a, c: own_stiffness(a, c, active=-1.0))
    assert "counts as positive" in hint("stiffness", lambda a, c: -own_stiffness(a, c))
    assert "shape" in hint("stiffness", lambda a, c: own_stiffness(a, c)[:1])
    assert said("stiffness", lambda a, c: ...).outcome is OPEN


def test_a_missing_passive_slope_is_told_where_fibres_are_stretched(own_stiffness, hand, finger):
    relaxed = hand.relaxed[finger[1]]
    assert "passive slope" in hint("stiffness", lambda a, c: own_stiffness(a, c, passive=float(np.allclose(a, relaxed))))


def test_co_contraction_stiffens_the_relaxed_knuckle_and_softens_the_straight_one(own_stiffness, hand, finger):
    relaxed, straight = (
        (own_stiffness(angle, np.ones(6)) - own_stiffness(angle, np.zeros(6)))[0] for angle in (hand.relaxed[finger[1]], np.zeros(3))
    )
    assert 0.2 < relaxed < 0.4 and -0.1 < straight < -0.01
    assert said("stiffen", relaxed, straight).outcome is RIGHT
    assert "swapped" in hint("stiffen", straight, relaxed)
    assert "other way round" in hint("stiffen", -relaxed, -straight)
    assert "straight finger" in hint("stiffen", relaxed, straight + 0.02)


def test_the_culprits_are_the_stretched_flexors():
    assert said("culprits", {"FDP3", "FDS3"}).outcome is RIGHT
    assert "1 more" in hint("culprits", "FDP3")
    assert "adds stiffness" in hint("culprits", {"FDP3", "FDS3", "EDC3"})


def test_one_extensor_cannot_balance_one_flexor_at_three_joints():
    newtons = [111 / 8.6, 79 / 2.8, 41 / 2.2]
    assert said("newtons", newtons).outcome is RIGHT
    assert "without sign" in hint("newtons", [-value for value in newtons])
    assert "other way round" in hint("newtons", [100 / value for value in newtons])
    assert "PIP" in hint("newtons", [newtons[0], 20, newtons[2]])
    assert "three forces" in hint("newtons", newtons[:2])


def test_no_forces_of_all_six_cancel_at_three_joints():
    """Every pair and triple of the other five tried by hand: a least-squares answer without negative forces is one of these."""
    from itertools import combinations

    best, who = np.inf, set()
    for count in (1, 2, 3):
        for some in combinations((0, 1, 3, 4, 5), count):
            force = np.linalg.lstsq(ARMS[list(some)].T, -ARMS[2], rcond=None)[0]
            left = np.linalg.norm(ARMS[list(some)].T @ force + ARMS[2])
            if force.min() > 0 and left < best:
                best, who = left, {MUSCLES[k] for k in some}
    assert 0.0003 < best < 0.001
    assert said("doubt", 1000 * best, who).outcome is RIGHT
    assert "mN m" in hint("doubt", best, who)
    assert "not the least" in hint("doubt", 1000 * best + 0.5, who)
    assert "above 0" in hint("doubt", 1000 * best, {"DI2"})


def test_a_loose_upright_wrist_falls_to_the_side_where_it_begins(hand):
    loose = hand.without_passive()
    hold = [name for name in hand.moving_names if name != "wrist.flexion_extension"]
    ends = []
    for begin in (-40, 20):
        start = hl.pose(loose, {"wrist.flexion_extension": np.deg2rad(begin)})
        laws = hl.Laws(gravity=(-9.81, 0, 0))
        clip = hl.simulate(loose, {"FDP3": 0.0}, seconds=15, fps=1, hold=hold, start=start, laws=laws)
        ends.append(float(np.rad2deg(clip.angle[-1, 0])))
    assert ends[1] - ends[0] > 5
    assert said("two", *ends).outcome is RIGHT
    assert "swapped" in hint("two", *ends[::-1])
    assert "radians" in hint("two", np.deg2rad(ends[0]), ends[1])
    assert "does not end" in hint("two", ends[0] + 3, ends[1])
