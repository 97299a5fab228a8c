import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handlab.physics.muscle import active_force_length, active_slope, muscle_force, passive_force_length, passive_slope

EXAMPLES = json.loads((Path(__file__).parents[1] / "data" / "equations_examples.json").read_text())
ratios = st.floats(0.0, 3.0)


@pytest.mark.parametrize(("reading", "column"), [("printed", "printed"), ("sound", "clipped")])
def test_the_active_curve_gives_the_worked_numbers(reading, column):
    example = EXAMPLES["F_contr"]
    np.testing.assert_allclose(active_force_length(example["ratio"], reading=reading), example[column], atol=1e-12)


def test_the_passive_curve_gives_the_worked_numbers():
    np.testing.assert_allclose(passive_force_length(EXAMPLES["F_stretch"]["ratio"]), EXAMPLES["F_stretch"]["value"], atol=1e-12)


def test_a_muscle_at_0_6_of_its_rest_length_pulls_nothing():
    assert float(muscle_force(1.0, 0.6, 54.0)) == pytest.approx(0.0, abs=1e-12)
    assert float(muscle_force(1.0, 0.61, 54.0)) > 0.5


def test_a_relaxed_muscle_that_is_not_stretched_pulls_nothing():
    assert float(muscle_force(0.0, 1.0, 54.0)) == 0.0
    assert float(muscle_force(0.0, 0.8, 54.0)) == 0.0


def test_half_contraction_at_1_2_of_the_rest_length_gives_the_worked_number():
    example = EXAMPLES["eq1"]
    assert float(muscle_force(example["c"], example["ratio"], 1.0)) == pytest.approx(example["F_over_Fmax"], abs=1e-12)


def test_full_contraction_is_strongest_where_the_worked_example_says():
    ratio = np.linspace(1.0, 1.6, 60001)
    force = muscle_force(1.0, ratio, 1.0)
    assert ratio[force.argmax()] == pytest.approx(EXAMPLES["total_c1"]["argmax"], abs=1e-4)
    assert force.max() == pytest.approx(EXAMPLES["total_c1"]["max"], abs=1e-5)


def test_the_passive_force_reaches_the_maximum_where_the_active_one_ends():
    assert float(passive_force_length(1.6)) == pytest.approx(1.0, abs=0.005)
    assert float(active_force_length(1.6)) == pytest.approx(0.0, abs=1e-12)


@given(st.floats(0, 1), ratios, st.floats(0.1, 500))
def test_no_muscle_pushes(contraction, ratio, max_force):
    assert float(muscle_force(contraction, ratio, max_force)) >= 0.0


def test_the_printed_curve_lets_a_muscle_push():
    assert float(muscle_force(1.0, 0.5, 100.0, reading="printed")) == pytest.approx(-44.0, abs=1e-9)


@given(ratios)
def test_slopes_are_the_slopes_of_the_curves(ratio):
    step = 1e-6
    for curve, slope, corners in ((active_force_length, active_slope, (0.6, 1.6)), (passive_force_length, passive_slope, ())):
        if all(abs(ratio - corner) > 2 * step for corner in corners):
            difference = (curve(ratio + step) - curve(ratio - step)) / (2 * step)
            assert float(slope(ratio)) == pytest.approx(float(difference), abs=1e-5)


def test_an_unknown_reading_is_refused():
    with pytest.raises(ValueError, match="'sound' or 'printed'"):
        active_force_length(1.0, reading="guessed")
