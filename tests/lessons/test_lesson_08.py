"""The checks of "A geometric muscle": right answers pass, and every common slip is told for what it is."""

import dataclasses

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.grids import load_grids
from handlab.check import lesson, swelling
from handlab.check.verdict import Outcome
from handlab.physics.bulge import ellipsoid_volume
from handlab.show.painting import Painting, Settings
from handlab.simulation.geometric_muscle import geometric_muscles
from handlab.simulation.grid_rows import skin_over
from handlab.studies.fibre_arm import fibre_arms

RIGHT, WRONG, OPEN = Outcome.RIGHT, Outcome.WRONG, Outcome.OPEN
BONES = ("trapezium", "metacarpal_1", "proximal_phalanx_1")
FLEXIONS = ("cmc1.flexion_opposition", "mcp1.flexion_extension")


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


def said(exercise, *answers):
    return lesson("08").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG, verdict
    return verdict.text


def path(hand, *, share=0.5, first=0, last=3):
    """Rows of a flexor whose origin lies ``share`` of the way from the trapezium to the capitate."""
    inside = {name: bone.points.mean(axis=0) for name, bone in hand.bones.items()}
    phalanx = hand.bones["proximal_phalanx_1"].points
    base = phalanx[phalanx[:, 0].argsort()[:50]].mean(axis=0)
    origin = (1.0 - share) * inside["trapezium"] + share * inside["capitate"]
    middles = [origin, inside["metacarpal_1"] + [4e-3, 0, -12e-3], base + np.array([3e-3, 0, -3e-3])]
    across = np.array([-0.6, 0, 0.8])
    rows = [[m - w * across, m + w * across] for m, w in zip(middles, (3e-3, 5e-3, 3e-3), strict=True)]
    return skin_over(hand, rows[first:last])


def painted(hand, rows, *, drive="FPB", bones=BONES, **more):
    painting = Painting(hand, Settings("mine", drive))
    painting.set(columns=2, thickness_mm=(1.5, 7), skin_distance_mm=(6, 3, 2), bones=bones, **more)
    painting.add(rows)
    return painting.required().grid


@pytest.fixture(scope="module")
def mine(hand):
    return painted(hand, path(hand))


def test_volume_and_thickening_pass_and_their_slips_are_told():
    volume, thicker = ellipsoid_volume, lambda q: q**-0.5
    assert said("ellipsoid", volume, thicker).outcome is RIGHT
    assert "box" in hint("ellipsoid", lambda half: 8 * half.prod(axis=1), thicker)
    assert "4/3, not 3/4" in hint("ellipsoid", lambda half: 0.75 * np.pi * half.prod(axis=1), thicker)
    assert "Half-axes" in hint("ellipsoid", lambda half: np.pi / 6 * half.prod(axis=1), thicker)
    assert "height alone" in hint("ellipsoid", volume, lambda q: 1 / q)
    assert "not thinner" in hint("ellipsoid", volume, lambda q: q**0.5)
    assert "cube root" in hint("ellipsoid", volume, lambda q: q ** (-1 / 3))
    assert "keeps no volume" in hint("ellipsoid", volume, lambda q: 1 + 2 * (1 - q))
    assert said("ellipsoid", volume, lambda q: ...).outcome is OPEN


def test_the_remembered_formula_gains_12_percent_and_nothing_at_one_half():
    assert said("recalled", 12.0, 0.5).outcome is RIGHT
    q = np.linspace(0.5, 1.0, 1001)
    assert (q * (1 + 2 * (1 - q))).max() == pytest.approx(1.125, abs=1e-6), "the sentence that confirms says 12.5 %"
    assert "also shorter" in hint("recalled", 60.0, 0.5)
    assert "How much was gained" in hint("recalled", 112.0, 0.5)
    assert "fraction" in hint("recalled", 0.12, 0.5)
    assert "another one" in hint("recalled", 12.0, 1.0)
    assert "Solve" in hint("recalled", 12.0, 0.6)


def test_the_thickness_passes_in_any_form_and_its_slips_are_told():
    assert said("fit", lambda d, o, g, least, most: min(max(d - o - g, least), most)).outcome is RIGHT
    assert "than its most" in hint("fit", lambda d, o, g, least, most: max(d - o - g, least))
    assert "least thickness" in hint("fit", lambda d, o, g, least, most: min(d - o - g, most))
    assert "gap" in hint("fit", lambda d, o, g, least, most: np.clip(d - o, least, most))
    assert "skin distance" in hint("fit", lambda d, o, g, least, most: np.clip(d - g, least, most))
    assert "before you clamp" in hint("fit", lambda d, o, g, least, most: np.clip(d, least, most) - o - g)


def test_a_painted_flexor_passes_and_what_is_none_is_told(hand, mine):
    assert said("paint", mine).outcome is RIGHT
    shipped = next(grid for grid in load_grids() if grid.name == "flexor_pollicis_brevis")
    assert said("paint", shipped).outcome is RIGHT
    assert "Let FPB drive it" in hint("paint", painted(hand, path(hand), drive="APB"))
    assert "panel.grid" in hint("paint", path(hand))
    assert "from the origin to the insertion" in hint("paint", painted(hand, path(hand)[::-1], bones=BONES[::-1]))
    assert "begins at the wrist" in hint("paint", painted(hand, path(hand, first=1), bones=BONES[1:]))
    assert "cross the MCP joint" in hint("paint", painted(hand, path(hand, last=2), bones=BONES[:2]))
    assert "on bone" in hint("paint", painted(hand, path(hand), on_bone=(True, False)))
    rows = path(hand)
    short = np.stack([rows[2] + 0.35 * (rows[1] - rows[2]), rows[2]])
    short = skin_over(hand, short - [0.0, 0.003, 0.0])
    too_short = dataclasses.replace(painted(hand, short, bones=("metacarpal_1", BONES[2])))
    told = hint("paint", dataclasses.replace(too_short, bones=({"trapezium": 1.0}, {"metacarpal_1": 1.0}, {"proximal_phalanx_1": 1.0})))
    assert "whole way" in told or "paint it over that bone" in told


def test_the_arm_passes_from_both_sides_only():
    assert said("arm", lambda length, step: (length(-step) - length(step)) / (2 * step)).outcome is RIGHT
    assert "SHORTER" in hint("arm", lambda length, step: (length(step) - length(-step)) / (2 * step))
    assert "one side only" in hint("arm", lambda length, step: -(length(step) - length(0)) / step)
    assert "two steps" in hint("arm", lambda length, step: (length(-step) - length(step)) / step)
    assert "per angle" in hint("arm", lambda length, step: length(-step) - length(step))


def arms(hand, grid):
    muscle = swelling.painted(grid)
    return [1e3 * fibre_arms(hand, muscle, muscle.names[0], rotation).mean() for rotation in FLEXIONS]


def test_arms_are_those_of_the_painted_muscle_and_near_the_table(hand, mine):
    cmc, mcp = arms(hand, mine)
    assert said("state", mine, cmc, mcp).outcome is RIGHT
    assert "metres" in hint("state", mine, cmc / 1e3, mcp)
    assert "sign" in hint("state", mine, -cmc, mcp)
    assert "degrees" in hint("state", mine, np.deg2rad(cmc), mcp)
    assert "that you painted" in hint("state", mine, cmc, mcp + 1.0)


def test_an_origin_over_the_trapezium_halves_the_arm_and_the_hint_says_where_to_go(hand, mine):
    """What the note for lecturers says."""
    near = painted(hand, path(hand, share=0.0))
    assert 0.3 < arms(hand, near)[0] / arms(hand, mine)[0] < 0.6
    assert "farther from the axis" in hint("state", near, *arms(hand, near))


def test_the_arm_of_the_shipped_flexor_fits_the_table_in_the_bind_posture_and_changes_over_the_range(hand):
    muscles = geometric_muscles(hand)
    row = hand.muscle_names.index("flexor_pollicis_brevis")
    for rotation in FLEXIONS:
        table = hand.lever_arm[row, hand.dof_names.index(rotation)]
        assert abs(fibre_arms(hand, muscles, "flexor_pollicis_brevis", rotation).mean() - table) < 0.5e-3
    assert 2.5 < swelling.arm_ratio() < 5.0
    assert said("constant", swelling.arm_ratio()).outcome is RIGHT
    assert "smaller one" in hint("constant", 1.0 / swelling.arm_ratio())
    assert "both" not in hint("constant", 1.0)


def test_the_belly_swells_and_the_volume_stays():
    still, full = (swelling.swollen(c).half for c in (0.0, 1.0))
    thicker = 100.0 * (full[:, 2].max() / still[:, 2].max() - 1.0)
    assert 5.0 < thicker < 40.0
    assert said("belly", thicker, 0.0).outcome is RIGHT
    assert "gained" in hint("belly", 100.0 + thicker, 0.0)
    assert "fraction" in hint("belly", thicker / 100.0, 0.0)
    assert "Add up" in hint("belly", thicker, 5.0)
    assert said("guess", 30).outcome is Outcome.NOTED
    assert "percent" in hint("guess", "thicker")


def test_a_swapped_grid_is_refused_in_words(hand):
    rows = path(hand)
    painting = Painting(hand, Settings("broken", "FPB", columns=2))
    painting.add([rows[1], rows[0], rows[2]])
    assert said("refused", painting.problem).outcome is RIGHT
    assert "something else" in hint("refused", "the muscle grid lies off the skin")
    assert "panel.problem" in hint("refused", None)


def test_layers_are_counted_and_do_not_move_each_other():
    verdicts = [said("layers", count, 0.0) for count in range(40)]
    right = [count for count, verdict in enumerate(verdicts) if verdict.outcome is RIGHT]
    assert len(right) == 1
    assert right[0] > 3
    assert "another muscle" in hint("layers", right[0], 0.4)


def test_the_skin_rises_over_a_painted_muscle(mine):
    rise = 1e3 * swelling.rise(swelling.painted(mine)).max()
    assert 0.1 < rise < 3.0
    assert said("skin", mine, rise).outcome is RIGHT
    assert "millimetres" in hint("skin", mine, rise / 1e3)
    assert "normals" in hint("skin", mine, 2.0 * rise)
