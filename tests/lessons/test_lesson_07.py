"""The checks of "Springs and the stable step": right answers pass, and every common slip is told for what it is."""

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson
from handlab.check.verdict import Outcome
from handlab.simulation.soft_skin import soft_skin
from handlab.studies import shaking

RIGHT, WRONG = Outcome.RIGHT, Outcome.WRONG


@pytest.fixture(scope="module")
def net():
    return soft_skin(hl.load_hand())


def said(exercise, *answers):
    return lesson("07").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG, verdict
    return verdict.text


def test_any_number_of_steps_is_a_guess():
    assert said("guess", 1).outcome is Outcome.NOTED
    assert "one number" in hint("guess", "many")


def force(kind="right"):
    def own(node, other, k, rest):
        way = other - node
        length = np.sqrt((way**2).sum())
        return {
            "right": k * (1 - rest / length) * way,
            "away": -k * (1 - rest / length) * way,
            "no rest": k * way,
            "no unit": k * (length - rest) * way,
            "number": k * (length - rest),
            "other": way,
            "open": ...,
        }[kind]

    return own


def test_the_force_passes_and_its_slips_are_told():
    assert said("force", force()).outcome is RIGHT
    assert said("force", force("open")).outcome is Outcome.OPEN
    for kind, word in (
        ("away", "points away"),
        ("no rest", "rest length pulls nothing"),
        ("no unit", "direction"),
        ("number", "one number"),
    ):
        assert word in hint("force", force(kind))
    assert "the package has" in hint("force", force("other"))
    assert "without brackets" in hint("force", np.zeros(3))


def leap(kind="right"):
    def own(x, v, acceleration, dt):
        new = v + dt * acceleration(x)
        late = v + dt * acceleration(x + dt * v)
        return {
            "right": (x + dt * new, new),
            "array": np.array([x + dt * new, new]),
            "old": (x + dt * v, new),
            "swapped": (new, x + dt * new),
            "late": (x + dt * v, late),
            "change": (x + dt * (new - v), new - v),
            "one": new,
            "open": (..., ...),
        }[kind]

    return own


def test_the_leapfrog_passes_and_its_slips_are_told():
    assert said("leap", leap()).outcome is RIGHT
    assert said("leap", leap("array")).outcome is RIGHT
    assert said("leap", leap("open")).outcome is Outcome.OPEN
    for kind, word in (
        ("old", "old velocity"),
        ("swapped", "came first"),
        ("late", "new place"),
        ("change", "add the old"),
        ("one", "two things"),
    ):
        assert word in hint("leap", leap(kind))


def test_the_limits_of_one_mass_are_two_over_omega():
    """m = 0.1 g, k = 2 N/m: 2 sqrt(m / k) = 14.142 ms; with 4 N/m 10 ms."""
    assert said("limit", 14.142, 10.0).outcome is RIGHT
    assert said("limit", 14.0, 10.0).outcome is RIGHT
    assert "is not 13.8" in hint("limit", 13.8, 10.0)
    assert "seconds" in hint("limit", 0.01414, 10.0)
    assert "1/omega" in hint("limit", 7.07, 10.0)
    assert "whole swing" in hint("limit", 44.4, 10.0)
    assert "under a root" in hint("limit", 14.1, 7.07)
    assert "allow longer" in hint("limit", 14.1, 20.0)
    assert "is not 10.2" in hint("limit", 14.1, 10.2)


def test_damping_leaves_the_limit_as_it_is():
    assert said("damping", "same").outcome is RIGHT
    assert "Try it" in hint("damping", "longer")
    assert hint("damping", "samey")


def test_a_row_is_limited_by_neighbours_that_move_against_each_other():
    """Between walls: omega = sqrt(2 k / m) for one mass, 10 ms; nearly 2 sqrt(k / m) for forty, 7.076 ms."""
    assert said("row", 10.0, 7.08, "against").outcome is RIGHT
    assert said("row", 9.85, 7.0, "Against").outcome is RIGHT
    assert "swapped" in hint("row", 7.08, 10.0, "against")
    assert "seconds" in hint("row", 0.01, 7.08, "against")
    assert "40 masses is not 5" in hint("row", 10.0, 5.0, "against")
    assert "left plot" in hint("row", 10.0, 7.08, "together")


def test_a_net_twice_as_fine_costs_eight_times_the_work():
    assert said("finer", 2, 8).outcome is RIGHT
    assert "square root" in hint("finer", 4, 16)
    assert "see the row" in hint("finer", 1, 4)
    assert "also makes more steps" in hint("finer", 2, 4)


def power(kind="right"):
    def own(K, mass):
        x = np.ones(len(mass)) * (-1.0) ** np.arange(len(mass))
        for _ in range(300):
            x = K @ x if kind == "no mass" else (K @ x) / mass
            square = np.linalg.norm(x)
            x = x / square
        omega = np.sqrt(square)
        return {"square": square, "hertz": omega / 2 / np.pi, "low": 0.9 * omega}.get(kind, omega)

    return own


def test_the_fastest_swing_passes_and_its_slips_are_told():
    assert said("fastest", power()).outcome is RIGHT
    for kind, word in (("square", "square root"), ("no mass", "masses are missing"), ("hertz", "swings per second"), ("low", "is not")):
        assert word in hint("fastest", power(kind))
    assert said("fastest", lambda K, mass: ...).outcome is Outcome.OPEN


def test_the_steps_of_the_skin_are_predicted_and_measured(net):
    right = net.frequency / 120
    stable = int(np.ceil(right))
    assert not shaking.grows(net, stable)
    assert shaking.grows(net, stable - 1)
    assert said("steps", right, stable).outcome is RIGHT
    assert f"{right:.2f} predicted" in said("steps", right, stable).text
    assert "2/omega" in hint("steps", 2 * right, stable)
    assert "2 pi" in hint("steps", right / 2 / np.pi, stable)
    assert "whole second" in hint("steps", 60 * right, stable)
    assert "reserve" in hint("steps", net.substeps(1 / 60), stable)
    assert "milliseconds" in hint("steps", 2000 / net.frequency, stable)
    assert "Try whole numbers" in hint("steps", right, stable - 1)
    assert "Try whole numbers" in hint("steps", right, stable + 1)
    assert "is not" in hint("steps", 1.02 * right, stable)


def test_double_stiffness_is_the_root_of_two_and_is_measured(net):
    hand = hl.load_hand()
    double, skin, tissue = (soft_skin(hand, young, tissue=below) for young, below in ((2e5, 3e4), (2e5, 15e3), (1e5, 3e4)))
    right, before = shaking.predicted(double), shaking.predicted(net)
    assert right == pytest.approx(np.sqrt(2) * before, rel=1e-4)
    stable = int(np.ceil(right))
    percent = 100 * (shaking.predicted(tissue) / before - 1)
    assert said("double", right, stable, percent).outcome is RIGHT
    assert "there is a root" in hint("double", 2 * before, stable, percent)
    assert "more steps" in hint("double", before / np.sqrt(2), stable, percent)
    assert "skin alone" in hint("double", shaking.predicted(skin), stable, percent)
    assert "both young and tissue" in hint("double", right, stable + 1, percent)
    assert "Give percent" in hint("double", right, stable, percent / 100)
    assert "do not grow by" in hint("double", right, stable, percent + 1)


def test_a_few_heavier_nodes_in_the_right_place_save_steps(net):
    swing = np.linalg.norm(shaking.worst_pattern(net), axis=1)
    many, order = int((swing > 0.5).sum()), np.argsort(-swing)
    assert said("repair", many, order[:3].tolist()).outcome is RIGHT
    assert said("repair", many, np.array(order[:5])).outcome is RIGHT
    assert "take the length" in hint("repair", many + 1, order[:3])
    assert "swing farthest" in hint("repair", many, order[-3:])
    assert "6 nodes" in hint("repair", many, order[:6])
    assert "between 0 and" in hint("repair", many, [len(swing)])
    assert "list of numbers" in hint("repair", many, 7)
    assert said("repair", many, [...]).outcome is Outcome.OPEN


def test_what_is_known_of_skin_spans_a_factor_of_the_steps():
    hand = hl.load_hand()
    soft, stiff = (shaking.predicted(soft_skin(hand, young)) for young in (5e3, 140e6))
    assert stiff > 30 * soft
    micro = 1e6 / 60 / stiff
    assert said("doubt", soft, stiff, micro).outcome is RIGHT
    assert "sets a limit" in hint("doubt", shaking.predicted(soft_skin(hand)) * np.sqrt(0.05), stiff, micro)
    assert "140e6" in hint("doubt", soft, shaking.predicted(soft_skin(hand, 140e3)), micro)
    assert "milliseconds" in hint("doubt", soft, stiff, micro / 1000)
    assert "whole picture" in hint("doubt", soft, stiff, 1e6 / 60)
