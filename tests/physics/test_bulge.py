"""How a geometric muscle changes shape, against numbers worked out beside the code."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handlab.physics import bulge

NUMBERS = json.loads((Path(__file__).parents[1] / "data" / "equations_examples.json").read_text(encoding="utf-8"))["kahler"]
LENGTHS = st.lists(st.floats(1e-3, 1e-1), min_size=1, max_size=8)


def test_a_linear_muscle_slides_along_its_old_line_to_the_fixed_end():
    row = NUMBERS["contraction"]
    np.testing.assert_allclose(bulge.arc_length(row["P"]), row["t"], atol=1e-6)
    found = bulge.contracted(row["P"], row["c"])
    np.testing.assert_allclose(found, row["Q"], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(np.diff(found, axis=0), axis=1), row["new_lengths"], atol=1e-6)


def test_no_point_of_a_linear_muscle_reaches_the_fixed_end():
    line = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [20.0, 0.0, 0.0]]
    np.testing.assert_allclose(bulge.contracted(line, 1.0)[:, 0], [0.0, 0.1, 0.2], atol=1e-12)


def test_a_sphincter_shrinks_to_its_centre():
    row = NUMBERS["sphincter"]
    np.testing.assert_allclose(bulge.sphincter([row["p"]], row["p_star"], row["c"])[0], row["q"], atol=1e-12)


def test_the_three_ways_to_swell_give_the_numbers_worked_out():
    row = NUMBERS["bulge"]
    ratio = row["length_ratio"]
    np.testing.assert_allclose(bulge.recalled_bulge(ratio), row["recalled_factor"], atol=2e-6)
    np.testing.assert_allclose(bulge.volume_bulge(ratio), row["volume_both_axes"], atol=2e-6)
    np.testing.assert_allclose(bulge.volume_bulge(ratio, height_only=True), row["volume_height_only"], atol=4e-6)


@given(st.floats(0.3, 1.5))
def test_the_volume_laws_keep_the_volume_and_the_recalled_one_does_not(q):
    rest = np.array([4.0, 2.0, 1.0])
    both, height = bulge.volume_bulge(q), bulge.volume_bulge(q, height_only=True)
    before = bulge.ellipsoid_volume(rest)
    np.testing.assert_allclose(bulge.ellipsoid_volume(rest * [q, both, both]), before, rtol=1e-12)
    np.testing.assert_allclose(bulge.ellipsoid_volume(rest * [q, 1.0, height]), before, rtol=1e-12)
    if 0.55 < q < 0.95:
        assert bulge.ellipsoid_volume(rest * [q, 1.0, bulge.recalled_bulge(q)]) > 1.02 * before


@given(LENGTHS, st.floats(0.0, 1.0))
def test_contraction_creates_neither_length_nor_volume(lengths, contraction):
    rest = np.array(lengths)
    volume = rest * np.linspace(1.0, 2.0, len(rest))
    share = bulge.shares(rest, contraction)
    moved = bulge.volumes(rest, volume, contraction)
    assert share.sum() == pytest.approx(1.0, abs=1e-12)
    assert share.min() > 0.0
    assert moved.sum() == pytest.approx(volume.sum(), rel=1e-12)
    assert moved.min() > 0.0


def test_contraction_moves_volume_from_the_ends_into_the_belly():
    rest = np.full(6, 0.01)
    volume = np.array([1.0, 3.0, 5.0, 5.0, 3.0, 1.0])
    moved, share = bulge.volumes(rest, volume, 1.0), bulge.shares(rest, 1.0)
    assert np.all(moved[[0, 5]] < 0.7 * volume[[0, 5]])
    assert np.all(moved[[2, 3]] > 1.05 * volume[[2, 3]])
    assert np.all(share[[2, 3]] < 1.0 / 6.0)
    assert np.all(share[[0, 5]] > 1.0 / 6.0)


def test_the_bell_is_highest_in_the_middle_and_even():
    found = bulge.bell([1.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(found, [0.4375, 0.9375, 0.9375, 0.4375])


@pytest.mark.parametrize("line", [[[0.0, 0.0, 0.0]], [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0]]])
def test_a_fibre_of_one_point_is_refused(line):
    with pytest.raises(ValueError, match="two different points"):
        bulge.arc_length(line)
