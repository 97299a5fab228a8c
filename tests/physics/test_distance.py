"""Distances and winding numbers against VTK, and on shapes that can be reckoned by hand."""

import numpy as np
import pytest
import pyvista as pv
from hypothesis import given
from hypothesis import strategies as st

from handlab.physics.distance import closest, winding

coordinate = st.floats(-2.0, 2.0, allow_nan=False).map(lambda x: round(x, 3))
place = st.tuples(coordinate, coordinate, coordinate)


def corners(mesh):
    return np.ascontiguousarray(np.asarray(mesh.points, dtype=np.float64)[mesh.faces.reshape(-1, 4)[:, 1:]])


@pytest.fixture(scope="module")
def shape():
    """A bent, closed surface with a hole through it."""
    torus = pv.ParametricTorus(ringradius=1.0, crosssectionradius=0.4, u_res=40, v_res=24, w_res=2).triangulate().clean()
    torus.points = np.asarray(torus.points, dtype=np.float64) * [1.0, 1.3, 0.8]
    return torus.compute_normals(auto_orient_normals=True, consistent_normals=True, split_vertices=False)


@pytest.fixture(scope="module")
def scattered():
    return np.random.default_rng(11).uniform(-2.0, 2.0, (4000, 3))


def test_distances_and_places_are_those_of_vtk(shape, scattered):
    distance, triangle, near = closest(scattered, corners(shape))
    _, vtk_near = shape.find_closest_cell(scattered, return_closest_point=True)
    np.testing.assert_allclose(distance, np.linalg.norm(scattered - vtk_near, axis=1), atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(scattered - near, axis=1), distance, atol=1e-12)
    for i in np.linspace(0, len(scattered) - 1, 50).astype(int):  # the place lies on the triangle that is named
        system = np.vstack([corners(shape)[triangle[i]].T, np.ones(3)])
        share, *_ = np.linalg.lstsq(system, np.append(near[i], 1.0), rcond=None)
        np.testing.assert_allclose(system @ share, np.append(near[i], 1.0), atol=1e-9)
        assert share.min() > -1e-9


def test_signs_from_winding_numbers_are_those_of_vtk(shape, scattered):
    number = winding(scattered, corners(shape))
    signed = np.asarray(pv.PolyData(scattered).compute_implicit_distance(shape)["implicit_distance"])
    sure = np.abs(signed) > 1e-6
    np.testing.assert_array_equal(number[sure] > 0.5, signed[sure] < 0.0)
    np.testing.assert_allclose(number[sure], np.round(number[sure]), atol=1e-6)
    assert set(np.round(number[sure])) == {0.0, 1.0}


def test_a_surface_that_faces_inwards_winds_minus_once_and_two_of_them_twice(shape):
    inside = np.array([[1.0, 0.0, 0.0]])
    assert winding(inside, corners(shape))[0] == pytest.approx(1.0, abs=1e-9)
    assert winding(inside, np.ascontiguousarray(corners(shape)[:, ::-1]))[0] == pytest.approx(-1.0, abs=1e-9)
    assert winding(inside, np.concatenate([corners(shape)] * 2))[0] == pytest.approx(2.0, abs=1e-9)


def test_one_face_of_a_cube_fills_a_sixth_of_what_its_centre_sees():
    square = np.array([[1.0, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]])
    face = np.array([square[[0, 1, 2]], square[[0, 2, 3]]])
    assert winding(np.zeros((1, 3)), face)[0] == pytest.approx(1 / 6, abs=1e-12)


@given(point=place, triangle=st.tuples(place, place, place))
def test_no_place_on_a_triangle_is_nearer_than_the_one_found(point, triangle):
    """A quadratic programme on a fine grid of the triangle, for any triangle, flat ones too."""
    p, t = np.array(point), np.array(triangle)
    if np.linalg.norm(np.cross(t[1] - t[0], t[2] - t[0])) < 1e-3:
        return
    distance, _, near = closest(p[None], t[None])
    u, v = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60))
    inside = u + v <= 1.0
    grid = t[0] + u[inside][:, None] * (t[1] - t[0]) + v[inside][:, None] * (t[2] - t[0])
    best = np.linalg.norm(grid - p, axis=1).min()
    step = max(np.linalg.norm(t[1] - t[0]), np.linalg.norm(t[2] - t[0])) / 59
    assert best - 1.5 * step <= distance[0] <= best + 1e-9
    assert np.linalg.norm(near[0] - p) == pytest.approx(distance[0], abs=1e-9)


@pytest.mark.parametrize(
    ("point", "near"),
    [
        ([0.2, 0.2, 3.0], [0.2, 0.2, 0.0]),  # over the face
        ([-1.0, -1.0, 1.0], [0.0, 0.0, 0.0]),  # beyond each corner
        ([3.0, -0.5, 0.0], [1.0, 0.0, 0.0]),
        ([-0.5, 3.0, 0.0], [0.0, 1.0, 0.0]),
        ([0.5, -2.0, 0.0], [0.5, 0.0, 0.0]),  # beyond each side
        ([-2.0, 0.5, 0.0], [0.0, 0.5, 0.0]),
        ([1.0, 1.0, 0.0], [0.5, 0.5, 0.0]),
    ],
)
def test_each_region_around_a_triangle_has_its_nearest_place(point, near):
    triangle = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    distance, _, found = closest(np.array([point]), triangle)
    np.testing.assert_allclose(found[0], near, atol=1e-12)
    assert distance[0] == pytest.approx(np.linalg.norm(np.array(point) - near), abs=1e-12)
