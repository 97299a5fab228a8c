"""The checks of "Another hand, same contraction": right answers pass, and every common slip is told for what it is."""

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson
from handlab.check.verdict import Outcome
from handlab.fitting.enlarged import enlarged
from handlab.studies import measures, size

RIGHT, WRONG = Outcome.RIGHT, Outcome.WRONG


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="module")
def child():
    return hl.load_hand("child")


@pytest.fixture(scope="module")
def small(hand):
    return enlarged(hand, 0.7)


def said(exercise, *answers):
    return lesson("12").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG, verdict
    return verdict.text


def test_any_of_the_three_words_is_a_guess():
    assert said("guess", "more").outcome is Outcome.NOTED
    assert "answer" in hint("guess", "perhaps")


def test_the_powers_pass_and_each_has_its_hint():
    assert said("powers", 2, 2, 3, 3, 5).outcome is RIGHT
    for k, (wrong, word) in enumerate(((1, "area"), (3, "section"), (2, "lever arm"), (2, "volume"), (4, "both grow"))):
        answers = [2, 2, 3, 3, 5]
        answers[k] = wrong
        assert word in hint("powers", *answers)
    assert "five numbers" in hint("powers", 2)


def test_a_power_is_a_ratio_of_logarithms():
    assert said("power", lambda r, L: np.log10(r) / np.log10(L)).outcome is RIGHT
    assert said("power", lambda r, L: ...).outcome is Outcome.OPEN
    assert "their logarithm" in hint("power", lambda r, L: np.log(r))
    assert "Turn the fraction" in hint("power", lambda r, L: np.log(L) / np.log(r))
    assert "fraction of logarithms" in hint("power", lambda r, L: np.log(r / L))
    assert "exponent" in hint("power", lambda r, L: r / L)


def test_the_child_grows_nearly_by_the_laws(hand, child):
    before, after, L = size.strengths(hand), size.strengths(child), child.growth.length
    found = [float(np.log(after[name] / before[name]) / np.log(L)) for name in ("force", "torque", "inertia")]
    for power, law in zip(found, (2, 3, 5), strict=True):
        assert power == pytest.approx(law, abs=0.7)
    assert said("child", *found).outcome is RIGHT
    assert "with L" in hint("child", after["force"] / before["force"], *found[1:])
    assert "power of the inertia" in hint("child", *found[:2], 4)
    assert "three powers" in hint("child", 2)


def test_the_child_bends_its_finger_as_far(hand, child):
    column = hand.dof_names.index("pip2.flexion_extension")
    rests = []
    for one in (hand, child):
        clip = hl.simulate(one, {"FDP2": 0.3, "FDS2": 0.3}, seconds=4, hold=["wrist"])  # not by settle: by waiting
        rests.append(float(np.rad2deg(clip.angle[-1, column])))
    assert rests[1] == pytest.approx(rests[0], abs=3)
    assert said("angles", rests[0], rests[1]).outcome is RIGHT
    assert "springs of the joint" in hint("angles", 0.33 * rests[0], rests[1])
    assert "radians" in hint("angles", rests[0], np.deg2rad(rests[1]))
    assert "bent_deg(child)" in hint("angles", rests[0], rests[1] + 4)


def test_the_child_is_sooner_there(hand, child):
    L, ratio = child.growth.length, size.half_time(child) / size.half_time(hand)
    assert ratio == pytest.approx(L, rel=0.1)
    assert said("times", L, ratio).outcome is RIGHT
    assert "root is missing" in hint("times", L**2, ratio)
    assert "less time" in hint("times", 1 / L, ratio)
    assert "torques" in hint("times", L**3, ratio)
    assert "goes above" in hint("times", L, 1 / ratio)


def test_two_fists_are_a_few_degrees_apart(hand, child):
    off = np.rad2deg(np.abs(np.subtract(*(hl.simulate(one, "fist", hold=["wrist"]).angle for one in (hand, child)))))
    most, end = off.max(), off[-1].max()
    assert 20 > most > end > 0.1
    assert said("apart", most, end).outcome is RIGHT
    assert "swapped" in hint("apart", end, most)
    assert "radians" in hint("apart", np.deg2rad(most), end)
    assert "mean" in hint("apart", off.mean(), end)


def test_kept_mechanics_are_hardly_faster(hand):
    ratio = size.half_time(enlarged(hand, 0.7, mechanics="kept")) / size.half_time(hand)
    assert 0.9 < ratio < 1.0
    assert said("kept", 0, 2, ratio).outcome is RIGHT
    assert "know of L" in hint("kept", 3, 2, ratio)
    assert "mass stays" in hint("kept", 0, 5, ratio)
    assert "inertia alone" in hint("kept", 0, 2, 0.7)


def test_what_friction_is_assumed_to_do_decides(hand, small):
    ratio = size.half_time(small.with_(friction=hand.friction * 0.7**3)) / size.half_time(hand)
    assert 0.9 < ratio < 1.05
    assert said("doubt", ratio).outcome is RIGHT
    assert "Take doubted" in hint("doubt", 0.7)
    assert "is not" in hint("doubt", 0.5)


def test_weight_bothers_large_hands_more(hand, small):
    ratio = size.sag(small) / size.sag(hand)
    assert ratio == pytest.approx(0.7, rel=0.15)
    assert said("weight", 4, ratio).outcome is RIGHT
    assert "its arm grows" in hint("weight", 3, ratio)
    assert "above the line" in hint("weight", 4, 1 / ratio)


def test_adapted_contractions_bring_the_pulps_as_near_again(hand):
    man = hl.load_hand("man")
    told = hl.simulate(hand, "pinch", hold=["wrist"])
    gap = 1000 * measures.pulp_gap(hand, told.skin(-1), 1, 2)
    clips = [hl.simulate(man, keys, hold=["wrist"]) for keys in ("pinch", hl.retarget(told, man, hold=["wrist"]))]
    same, adapted = (1000 * measures.pulp_gap(man, clip.skin(-1), 1, 2) for clip in clips)
    goal = gap * man.growth.length
    assert abs(adapted - goal) < 1.0
    assert abs(adapted - goal) < 0.5 * abs(same - goal)
    assert said("repair", same, adapted).outcome is RIGHT
    assert "swapped" in hint("repair", adapted, same)
    assert "metres" in hint("repair", same / 1000, adapted)
    assert "pulp_gap the man" in hint("repair", same + 1, adapted)


def test_errors_of_size_multiply():
    torque, inertia = (100 * (1 - (29 / 30) ** p) for p in (3, 5))
    assert said("error", torque, inertia).outcome is RIGHT
    assert said("error", 10, 16.7).outcome is RIGHT
    assert "error of the length" in hint("error", 3.333, inertia)
    assert "what is left" in hint("error", 100 - torque, inertia)
    assert "part of one" in hint("error", torque / 100, inertia)
    assert "swapped" in hint("error", inertia, torque)
