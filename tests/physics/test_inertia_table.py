"""Tables of the paper's rods: worked numbers, and how far a table in steps of five degrees is off."""

import json
from pathlib import Path

import numpy as np
import pytest

from handlab.physics.inertia_table import linear_entry, nearest_entry, second_level, table_of, third_level, three_levels, two_levels

EXAMPLES = json.loads((Path(__file__).parents[1] / "data" / "equations_examples.json").read_text())
MASS, LENGTH = EXAMPLES["eq5"]["m_kg"], EXAMPLES["eq5"]["l_m"]
STEP = np.deg2rad(5.0)
GRID = np.deg2rad(np.arange(0.0, 111.0, 5.0))
OTHER = np.deg2rad(np.arange(0.0, 91.0, 5.0))


@pytest.mark.parametrize("pose", EXAMPLES["chain"]["poses"], ids=lambda pose: f"PIP {pose['alpha_PIP_deg']}")
def test_closed_forms_of_the_chain_give_the_worked_numbers(pose):
    alpha, beta = np.deg2rad([pose["alpha_PIP_deg"], pose["beta_DIP_deg"]])
    assert second_level(MASS[1], LENGTH[:2], alpha) == pytest.approx(pose["J_middle_star"], rel=1e-5)
    assert third_level(MASS[2], LENGTH, alpha, beta) == pytest.approx(pose["J_distal_star"], rel=1e-5)
    assert three_levels(MASS, LENGTH, alpha, beta) == pytest.approx(pose["J_total_MCP"], rel=1e-5)
    assert two_levels(MASS[1:], LENGTH[1:], beta) == pytest.approx(pose["J_total_PIP"], rel=1e-5)


def test_rods_of_many_points_have_the_moments_of_the_closed_forms():
    share = (np.arange(4000) + 0.5) / 4000
    for alpha, beta in ((0.3, 1.1), (1.9, 0.0), (-0.4, 0.7)):
        first = LENGTH[0] * np.array([1.0, 0.0])
        second = first + LENGTH[1] * np.array([np.cos(alpha), np.sin(alpha)])
        whole = np.array([np.cos(alpha + beta), np.sin(alpha + beta)])
        middle = first + np.outer(share, second - first)
        distal = second + np.outer(share, LENGTH[2] * whole)
        assert second_level(MASS[1], LENGTH[:2], alpha) == pytest.approx(MASS[1] * (middle**2).sum(axis=1).mean(), rel=1e-6)
        assert third_level(MASS[2], LENGTH, alpha, beta) == pytest.approx(MASS[2] * (distal**2).sum(axis=1).mean(), rel=1e-6)


def worst(read, table, exact, *angles):
    """Largest relative error of a table at random ``angles``."""
    return np.abs(read(table, [0.0] * len(angles), STEP, np.stack(angles, axis=-1)) / exact(*angles) - 1.0).max()


def test_two_levels_in_steps_of_five_degrees_err_as_the_worked_example_says():
    """The fractions of J2* between 0 and 110 degrees: half a step to the nearest, a square of it by a straight line."""
    fine = np.linspace(0.0, GRID[-1], 20_001)
    table = table_of(lambda alpha: second_level(MASS[1], LENGTH[:2], alpha), GRID)
    exact = lambda alpha: second_level(MASS[1], LENGTH[:2], alpha)  # noqa: E731
    assert worst(nearest_entry, table, exact, fine) == pytest.approx(EXAMPLES["table_error"]["max_rel_nearest"], rel=0.02)
    assert worst(linear_entry, table, exact, fine) == pytest.approx(EXAMPLES["table_error"]["max_rel_linear"], rel=0.02)


def test_three_levels_in_steps_of_five_degrees_err_by_percents_to_the_nearest_and_by_tenths_of_a_thousandth_linearly():
    rng = np.random.default_rng(5)
    alpha, beta = rng.uniform(0.0, GRID[-1], 20_000), rng.uniform(0.0, OTHER[-1], 20_000)
    table = table_of(lambda a, b: three_levels(MASS, LENGTH, a, b), GRID, OTHER)
    exact = lambda a, b: three_levels(MASS, LENGTH, a, b)  # noqa: E731
    assert table.shape == (23, 19)
    assert 0.02 < worst(nearest_entry, table, exact, alpha, beta) < 0.04
    assert 0.0003 < worst(linear_entry, table, exact, alpha, beta) < 0.0008


def test_halving_the_step_halves_the_error_of_the_nearest_entry_and_quarters_that_of_the_line():
    fine = np.linspace(0.0, np.pi / 2, 40_001)
    exact = two_levels(MASS[:2], LENGTH[:2], fine)
    errors = {read: [] for read in (nearest_entry, linear_entry)}
    for entries in (19, 37, 73):
        grid = np.linspace(0.0, np.pi / 2, entries)
        table = table_of(lambda alpha: two_levels(MASS[:2], LENGTH[:2], alpha), grid)
        for read, list_of in errors.items():
            list_of.append(np.abs(read(table, [0.0], grid[1], fine[:, None]) - exact).max())
    np.testing.assert_allclose(np.log2(np.divide(errors[nearest_entry][:-1], errors[nearest_entry][1:])), 1.0, atol=0.1)
    np.testing.assert_allclose(np.log2(np.divide(errors[linear_entry][:-1], errors[linear_entry][1:])), 2.0, atol=0.1)


def test_at_an_entry_both_readings_give_it_and_beyond_the_ends_the_last_one_holds():
    table = table_of(lambda a, b: 10.0 * a + b, [0.0, 1.0, 2.0], [5.0, 6.0])
    for read in (nearest_entry, linear_entry):
        np.testing.assert_allclose(read(table, [0.0, 5.0], 1.0, [[1.0, 6.0], [2.0, 5.0], [-3.0, 9.0], [9.0, 5.0]]), [16.0, 25.0, 6.0, 25.0])
    assert nearest_entry(table, [0.0, 5.0], 1.0, [0.6, 5.4]) == pytest.approx(15.0)
    assert linear_entry(table, [0.0, 5.0], 1.0, [0.6, 5.4]) == pytest.approx(11.4)


def test_a_table_with_one_entry_is_refused():
    with pytest.raises(ValueError, match="two or more angles"):
        linear_entry(np.ones((1, 3)), [0.0, 0.0], 1.0, [0.0, 0.0])
