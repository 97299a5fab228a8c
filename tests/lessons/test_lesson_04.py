"""The checks of "Inertia of a chain": right answers pass, and every common slip is told for what it is."""

from dataclasses import replace

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson, lesson_04
from handlab.check.verdict import Outcome
from handlab.simulation.inertia_tables import fist, tensor_inertia, wrist_constant
from handlab.simulation.mechanics import mechanics

RIGHT, WRONG, OPEN = Outcome.RIGHT, Outcome.WRONG, Outcome.OPEN


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


def said(exercise, *answers):
    return lesson("04").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG, verdict
    return verdict.text


def rod(m, length):
    return m * length**2 / 3


def cylinder(m, length, r):
    return m * length**2 / 3 + m * r**2 / 4


def test_rod_and_cylinder_pass_and_their_slips_are_told():
    assert said("bone", rod, cylinder).outcome is RIGHT
    assert "joint is at its end" in hint("bone", lambda m, length: m * length**2 / 12, cylinder)
    assert "squared" in hint("bone", lambda m, length: m * length / 3, cylinder)
    assert "far end" in hint("bone", lambda m, length: m * length**2, cylinder)
    assert "thickness" in hint("bone", rod, lambda m, length, r: rod(m, length))
    assert "quarter" in hint("bone", rod, lambda m, length, r: rod(m, length) + m * r**2 / 2)
    assert "plus" in hint("bone", rod, lambda m, length, r: rod(m, length) - m * r**2 / 4)
    assert "without brackets" in hint("bone", 3.0, cylinder)
    assert said("bone", lambda m, length: ..., cylinder).outcome is OPEN
    assert said("bone", rod, lambda m, length, r: None).outcome is OPEN


def test_thickness_is_the_worked_example():
    assert said("thickness", [3.34912, 7.5947, 11.3678]).outcome is RIGHT
    assert "percent" in hint("thickness", [0.0334912, 0.075947, 0.113678])
    assert "MORE" in hint("thickness", [103.34912, 107.5947, 111.3678])
    assert "three numbers" in hint("thickness", 11.4)
    assert "middle phalanx" in hint("thickness", [3.3, 9.0, 11.4])


def test_a_finer_mesh_multiplies_the_literal_sum_by_four_and_leaves_the_integral():
    before, after = np.array(lesson_04.three_ways(0)), np.array(lesson_04.three_ways(1))
    factors = after / before
    assert 3.9 < factors[0] < 4.1
    assert 0.002 < abs(factors[1] - 1.0) < 0.05
    assert factors[2] == pytest.approx(1.0, abs=1e-12)
    assert said("vertices", *factors).outcome is RIGHT
    assert "other way round" in hint("vertices", *(1.0 / factors))
    assert "fine mesh" in hint("vertices", 1.0, 1.0, 1.0)
    assert said("vertices", factors[0], "near", 1.0).outcome is WRONG


def middles(length, alpha, beta):
    arrows = length * np.exp(1j * np.array([0, alpha, alpha + beta]))
    return np.cumsum(arrows) - arrows / 2, np.cumsum(arrows)


@pytest.mark.parametrize(
    ("own", "word"),
    [
        (lambda m, rods, a, b: np.sum(m * rods**2 / 3), "far away"),
        (lambda m, rods, a, b: np.sum(m * np.abs(middles(rods, a, b)[0]) ** 2), "l^2 / 12, is missing"),
        (lambda m, rods, a, b: np.sum(m * (rods**2 / 12 + np.abs(middles(rods, a, b - a)[0]) ** 2)), "alpha + beta"),
        (lambda m, rods, a, b: np.sum(m * (rods**2 / 12 + np.abs(middles(rods, a, b)[1]) ** 2)), "not their ends"),
        (lambda m, rods, a, b: np.sum(m * (rods**2 / 3 + np.abs(middles(rods, a, b)[0]) ** 2)), "one third is for its end"),
        (lambda m, rods, a, b: 7.0, "comes out at 7"),
        (lambda m, rods, a, b: m, "shape"),
    ],
)
def test_a_slip_in_the_chain_is_recognised(own, word):
    assert word in hint("chain", own)


def test_the_chain_passes_in_any_form():
    assert said("chain", lambda m, rods, a, b: np.sum(m * (rods**2 / 12 + np.abs(middles(rods, a, b)[0]) ** 2))).outcome is RIGHT
    straight = 4.23923e-05
    assert said("chain", lambda m, rods, a, b: straight).outcome is WRONG, "one posture is not enough"


def test_any_positive_factor_and_any_angle_is_a_guess():
    assert said("hook", 1.2).outcome is Outcome.NOTED
    assert "positive" in hint("hook", -1)
    assert said("guess", 0).outcome is Outcome.NOTED
    assert "not negative" in hint("guess", -3)
    assert said("guess", "a lot").outcome is WRONG


def test_errors_of_the_table_pass_in_percent_and_in_order():
    nearest, linear = lesson_04.table_worst()
    assert 2.0 < nearest < 3.5
    assert 0.025 < linear < 0.045
    assert said("table", nearest, linear).outcome is RIGHT
    assert "other way round" in hint("table", linear, nearest)
    assert "percent" in hint("table", nearest / 100, linear)
    assert "np.floor" in hint("table", 2 * nearest, linear)
    assert "linear" in hint("table", nearest, 3 * linear)


def composite(m, c, tensors, turns, about, *, turn=True, back=False, own=True, one=True, outer=True, count=True):
    total = np.zeros((3, 3))
    for mass, centre, tensor, r in zip(m, c, tensors, turns, strict=True):
        d = centre - (about if count else 0.0)
        r = r.T if back else r
        total += own * (r @ tensor @ r.T if turn else tensor) + mass * (one * (d @ d) * np.eye(3) - outer * np.outer(d, d))
    return total


@pytest.mark.parametrize(
    ("how", "word"),
    [
        ({"turn": False}, "frames of the bones"),
        ({"back": True}, "wrong way round"),
        ({"one": False, "outer": False}, "parallel axis theorem is missing"),
        ({"own": False}, "own tensor"),
        ({"outer": False}, "The second is missing"),
        ({"one": False}, "The first is missing"),
        ({"count": False}, "centre - about"),
    ],
)
def test_a_slip_in_the_tensor_is_recognised(how, word):
    assert word in hint("tensor", lambda *a: composite(*a, **how))


def test_the_tensor_passes():
    assert said("tensor", composite).outcome is RIGHT
    assert "shape" in hint("tensor", lambda *a: np.zeros(3))


def test_the_missing_rotation_is_the_one_that_spreads_the_finger():
    assert said("left_out", "mcp2.deviation").outcome is RIGHT
    assert "own angle" in hint("left_out", "mcp2.flexion_extension")
    assert "tables know it" in hint("left_out", "pip2.flexion_extension")
    assert "follows" in hint("left_out", "mcp2.axial_rotation")
    for other in ("wrist.deviation", "mcp3.flexion_extension", "cmc5.flexion_opposition"):
        assert "changes nothing" in hint("left_out", other)
    assert "mcp2.deviation" in hint("left_out", "mcp2.deviatoin")


def test_the_constant_of_the_wrist_is_far_off_in_a_fist(hand):
    true, constant = tensor_inertia(hand, fist(hand))[0], wrist_constant(hand, "relaxed")[0]
    error = 100.0 * (constant / true - 1.0)
    assert 30.0 < error < 60.0
    assert said("wrist", error).outcome is RIGHT
    assert "true value" in hint("wrist", 100.0 * (true / constant - 1.0))
    assert "fraction" in hint("wrist", error / 100.0)
    assert "fresh hand" in hint("wrist", error + 5.0)


def waved(hand, inertia):
    return np.rad2deg(hl.simulate(hand, hl.keyframes("wave"), laws=hl.Laws(dynamics="decoupled", inertia=inertia)).angle)


def test_no_table_changes_the_wave_by_a_degree_and_neither_does_twice_the_mass(hand):
    heavy = hand.with_(bodies={name: replace(body, mass=2 * body.mass, inertia=2 * body.inertia) for name, body in hand.bodies.items()})
    exact = waved(hand, "tensor")
    by_table, by_mass = (np.abs(other - exact).max() for other in (waved(hand, "nearest table"), waved(heavy, "tensor")))
    assert 0.005 < by_table < 0.2
    assert 0.1 < by_mass < 1.0
    assert said("motion", by_table, by_mass).outcome is RIGHT
    assert "No table changes the motion by one degree" in said("motion", by_table, by_mass).text
    assert "radians" in hint("motion", np.deg2rad(by_table), by_mass)
    assert "fresh hands" in hint("motion", by_table, 0.5 * by_mass)


def test_friction_must_be_many_times_smaller_before_the_tables_matter():
    for divisor, right in ((3.0, False), (200.0, False)):
        assert (said("friction", divisor).outcome is RIGHT) is right
    assert "Divide by more" in hint("friction", 3.0)
    assert "Divide by less" in hint("friction", 200.0)
    assert "above 1" in hint("friction", 0.1)
    assert "hardly any" in hint("friction", 1e6)
    between = np.geomspace(10, 100, 15)
    assert any(said("friction", divisor).outcome is RIGHT for divisor in between)


def test_friction_stops_a_knuckle_in_a_thousandth_of_a_second_a_fingertip_much_sooner_and_the_wrist_later(hand):
    """The claim of the note for lecturers."""
    m = mechanics(hand)
    time = dict(zip(hand.moving_names, tensor_inertia(hand, m.relaxed) / m.friction, strict=True))
    assert 0.5e-3 < time["mcp2.flexion_extension"] < 2e-3
    assert 50.0 < time["mcp2.flexion_extension"] / time["dip2.flexion_extension"] < 200.0
    assert 5.0 < time["wrist.flexion_extension"] / time["mcp2.flexion_extension"] < 60.0
