"""What a painter is spared: the skin over a place, more rows, and the bones below them."""

import numpy as np
import pytest
import pyvista

from handlab.anatomy.grids import load_grids
from handlab.simulation.grid_rows import finer_bones, finer_points, finer_values, nearest_bones, on_skin, skin_over


@pytest.fixture(scope="module")
def mesh(hand):
    return pyvista.PolyData(hand.skin.points, np.column_stack([np.full(len(hand.skin.faces), 3), hand.skin.faces]))


@pytest.fixture(scope="module")
def rows(hand):
    grid = next(grid for grid in load_grids() if grid.name == "flexor_pollicis_brevis")
    return grid.points_on(hand.skin, hand.skin.points, hand.side)[::3]


@pytest.mark.parametrize("way", [(0, 1, 0), (0, -1, 0), (0.3, 0.8, 0.6)])
def test_the_skin_over_a_bone_is_what_vtk_meets_first_from_the_eye(hand, mesh, way):
    unit = np.array(way) / np.linalg.norm(way)
    for name in ("trapezium", "metacarpal_3", "proximal_phalanx_1"):
        inside = hand.bones[name].points.mean(axis=0)
        hits, _ = mesh.ray_trace(inside + 0.3 * unit, inside)
        expected = hits[np.linalg.norm(hits - inside - 0.3 * unit, axis=1).argmin()]
        found = skin_over(hand, [inside], way)
        assert found.shape == (1, 3)
        np.testing.assert_allclose(found[0], expected, atol=1e-6)


def test_a_place_beside_the_hand_has_no_skin_over_it(hand):
    with pytest.raises(ValueError, match="another side"):
        skin_over(hand, [[0.0, 0.0, 0.5]])


def test_finer_rows_keep_the_painted_ones_and_lie_on_the_skin_between_them(hand, mesh, rows):
    for finer in (1, 2, 4):
        fine = finer_points(hand, rows, finer)
        assert fine.shape == (finer * (len(rows) - 1) + 1, *rows.shape[1:])
        np.testing.assert_allclose(fine[::finer], rows, atol=1e-9)
        place = mesh.find_closest_cell(fine.reshape(-1, 3), return_closest_point=True)[1]
        np.testing.assert_allclose(fine.reshape(-1, 3), place, atol=1e-6)
        way = rows[-1, 1] - rows[0, 1]
        assert np.all(np.diff(fine[:, 1] @ way) > 0), "none turns back"


def test_points_that_fall_together_are_left_to_the_check_of_the_grid(hand, rows):
    twice = np.stack([rows[0], rows[0]])
    np.testing.assert_allclose(finer_points(hand, twice, 3), twice, atol=1e-9)


def test_values_and_bones_of_finer_rows_lie_between():
    np.testing.assert_allclose(finer_values([1.0, 3.0, 2.0], 2), [1.0, 2.0, 3.0, 2.5, 2.0])
    np.testing.assert_allclose(finer_values([1.0, 3.0], 1), [1.0, 3.0])
    bones = finer_bones([{"trapezium": 1.0}, {"metacarpal_1": 1.0}, {"metacarpal_1": 1.0}], 4)
    assert [round(row.get("metacarpal_1", 0.0), 6) for row in bones] == [0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0, 1.0]
    crowd = finer_bones([{"a": 0.6, "b": 0.4}, {"c": 0.7, "d": 0.3}], 2)
    assert all(len(row) <= 2 and sum(row.values()) == pytest.approx(1.0) for row in crowd)
    assert set(crowd[1]) == {"a", "c"}


def test_the_nearest_bone_is_the_one_below(hand):
    names = ("metacarpal_3", "proximal_phalanx_2", "distal_phalanx_1", "hamate")
    over = np.array([skin_over(hand, [hand.bones[name].points.mean(axis=0)] * 2) for name in names])
    found = nearest_bones(hand, over)
    assert found[:3] == names[:3]
    assert found == tuple(min(hand.bones, key=lambda one: np.linalg.norm(hand.bones[one].points - row[0], axis=1).min()) for row in over), (
        "nearest by corners: the meshes are fine enough"
    )


def test_on_skin_moves_nothing_that_is_there(hand):
    corners = hand.skin.points[::97]
    np.testing.assert_allclose(on_skin(hand, corners[None]), corners[None], atol=1e-12)
