"""The biharmonic warp against scipy, VTK and what can be said exactly."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import RBFInterpolator
from scipy.spatial.transform import Rotation
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonTransforms import vtkThinPlateSplineTransform

from handlab.physics import rbf

EXAMPLE = json.loads((Path(__file__).parents[1] / "data" / "equations_examples.json").read_text())["rbf"]


def points_like_a_hand(seed, count=26, noise=0.004):
    rng = np.random.default_rng(seed)
    source = rng.normal(size=(count, 3)) * [0.05, 0.04, 0.008] + [0.1, 0.02, -0.3]
    return source, 1.1 * source + noise * rng.normal(size=source.shape), rng.normal(size=(3000, 3)) * 0.1 + [0.1, 0.02, -0.3]


def test_the_worked_example_comes_out():
    warp = rbf.fitted(EXAMPLE["s"], EXAMPLE["t"])
    np.testing.assert_allclose(warp(EXAMPLE["query"]), EXAMPLE["f_query"], atol=1e-6)
    np.testing.assert_allclose(warp.weight[4], EXAMPLE["w_row5"], atol=1e-6)
    np.testing.assert_allclose(warp.shift, EXAMPLE["b_const"], atol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_it_agrees_with_scipy_to_1e_9(seed):
    source, target, query = points_like_a_hand(seed)
    expected = RBFInterpolator(source, target, kernel="linear", degree=1)(query)
    np.testing.assert_allclose(rbf.fitted(source, target)(query), expected, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_it_agrees_with_vtk_to_1e_9(seed):
    source, target, query = points_like_a_hand(seed)
    spline = vtkThinPlateSplineTransform()
    spline.SetBasisToR()
    spline.SetSigma(1.0)
    marks = [vtkPoints(), vtkPoints()]
    for points, values in zip(marks, (source, target), strict=True):
        points.SetDataTypeToDouble()
        for value in values:
            points.InsertNextPoint(*value)
    spline.SetSourceLandmarks(marks[0])
    spline.SetTargetLandmarks(marks[1])
    spline.Update()
    expected = np.array([spline.TransformDoublePoint(*place) for place in query])
    np.testing.assert_allclose(rbf.fitted(source, target)(query), expected, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(5, 40), st.sampled_from([1e-3, 1.0, 1e3]))
def test_an_affine_map_is_reproduced_to_1e_10_in_any_unit(seed, count, unit):
    rng = np.random.default_rng(seed)
    source, query = unit * rng.normal(size=(count, 3)), unit * 3.0 * rng.normal(size=(50, 3))
    linear, shift = rng.normal(size=(3, 3)), unit * rng.normal(size=3)
    warp = rbf.fitted(source, source @ linear.T + shift)
    # randomly drawn points may lie nearly in a plane: then digits are lost in proportion
    thin = np.linalg.svd(source - source.mean(axis=0), compute_uv=False)[2] / unit
    assert np.abs(warp(query) - (query @ linear.T + shift)).max() < 1e-10 * unit * max(1.0, 1.0 / thin)


@pytest.mark.parametrize("seed", range(4))
def test_every_point_goes_to_its_target_and_the_side_conditions_hold(seed):
    source, target, _ = points_like_a_hand(seed)
    warp = rbf.fitted(source, target)
    assert np.abs(warp(source) - target).max() < 1e-12
    assert np.abs(warp.weight.sum(axis=0)).max() < 1e-12
    assert np.abs(warp.weight.T @ source).max() < 1e-12
    assert 1e-4 < np.abs(warp.weight).max() < 10.0


def test_compiled_and_readable_sums_agree():
    source, target, query = points_like_a_hand(7)
    warp = rbf.fitted(source, target)
    np.testing.assert_allclose(warp(query), rbf.warped_numpy(warp, query), atol=1e-12)
    assert warp(query[0]).shape == (3,)
    assert warp(query.reshape(10, 300, 3)).shape == (10, 300, 3)
    assert warp(np.empty((0, 3))).shape == (0, 3)


@pytest.mark.parametrize("centres", [1, 2, 3, 4, 26])
@pytest.mark.parametrize("count", [0, 1, 127, 128, 129, 30_001])
def test_many_points_are_warped_as_few_are(count, centres):
    source, target, _ = points_like_a_hand(5)
    query = np.random.default_rng(0).normal(size=(count, 3)) * 0.1
    warp = rbf.fitted(source[:centres], target[:centres])
    np.testing.assert_allclose(warp(query), rbf.warped_numpy(warp, query), atol=1e-12)


def test_points_that_are_not_three_numbers_each_are_refused():
    warp = rbf.fitted(np.eye(3), np.eye(3))
    for points in (np.zeros((3, 2)), np.zeros(6), 1.0):
        with pytest.raises(ValueError, match=r"\(\.\.\., 3\)"):
            warp(points)


def test_the_jacobian_is_the_derivative():
    source, target, query = points_like_a_hand(3)
    warp, query, step = rbf.fitted(source, target), query[:200], 1e-6
    expected = np.stack([(warp(query + step * e) - warp(query - step * e)) / (2 * step) for e in np.eye(3)], axis=2)
    np.testing.assert_allclose(rbf.jacobian(warp, query), expected, atol=1e-8)


def test_two_targets_that_change_places_fold_the_space_between():
    source = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.4, 0.4, 0.4], [0.6, 0.4, 0.4], [1, 1, 1]], dtype=float)
    target = source.copy()
    target[[4, 5]] = source[[5, 4]]
    warp = rbf.fitted(source, target)
    assert np.linalg.det(rbf.jacobian(warp, [[0.5, 0.4, 0.4]]))[0] < 0
    assert np.linalg.det(rbf.jacobian(warp, [[5.0, 5.0, 5.0]]))[0] > 0.3


@pytest.mark.parametrize(
    ("count", "flatten", "rank"),
    [(26, [1, 1, 0], 2), (4, [1, 1, 0], 2), (3, [1, 1, 1], 2), (2, [1, 1, 1], 1), (9, [1, 0, 0], 1), (1, [1, 1, 1], 0)],
)
def test_flat_or_few_points_continue_as_a_similarity(count, flatten, rank):
    turn = Rotation.random(random_state=1).as_matrix()
    source = np.random.default_rng(0).normal(size=(count, 3)) * flatten
    size = 1.3 if rank else 1.0
    target = size * source @ turn.T + 1.0 if rank else source + 1.0
    warp = rbf.fitted(source, target)
    assert warp.rank == rank
    np.testing.assert_allclose(warp(source), target, atol=1e-12)
    np.testing.assert_allclose(warp.linear @ warp.linear.T, size**2 * np.eye(3), atol=1e-9)
    assert np.linalg.det(warp.linear) == pytest.approx(size**3, rel=1e-9)


def test_points_thin_as_paper_are_not_yet_flat():
    source = np.array(EXAMPLE["s"]) * [1, 1, 1e-3]
    linear = np.array([[1, 0.2, 0.1], [0, 1, 0.3], [0.1, 0, 2.0]])
    warp = rbf.fitted(source, source @ linear.T)
    assert warp.rank == 3
    np.testing.assert_allclose(warp.linear, linear, atol=1e-10)


def test_two_sources_at_one_place_are_named():
    with pytest.raises(ValueError, match="points 1 and 3 lie at one place"):
        rbf.fitted([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1]], np.zeros((5, 3)))


@pytest.mark.parametrize(
    ("source", "target"),
    [(np.zeros((0, 3)), np.zeros((0, 3))), (np.zeros((4, 2)), np.zeros((4, 2))), (np.eye(3), np.eye(4)), ([[np.nan, 0, 0]], [[0, 0, 0]])],
)
def test_what_is_no_set_of_points_is_refused(source, target):
    with pytest.raises(ValueError, match="must"):
        rbf.fitted(source, target)


def test_the_root_by_products_is_the_root():
    from handlab.physics.rbf_kernel import _root

    squares = 10.0 ** np.random.default_rng(0).uniform(-14.0, 4.0, 2000)
    error = np.array([_root(d) for d in squares]) / np.sqrt(squares) - 1.0
    assert np.abs(error).max() < 1.5e-13
    assert np.abs(error).max() > 1e-14  # it is the short way, not the processor's root
