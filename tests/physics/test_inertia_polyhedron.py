"""Exact mass properties of closed meshes: against boxes, tetrahedra, trimesh and many points."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

import handlab as hl
from handlab.physics.inertia import from_points
from handlab.physics.polyhedron import mass_properties, refined

CUBE = trimesh.creation.box()
CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
SIDES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


def box(a, b, c, mass):
    return mass / 12.0 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])


@given(st.tuples(*[st.floats(0.001, 10.0)] * 3), st.tuples(*[st.floats(-5.0, 5.0)] * 3))
@settings(max_examples=50, deadline=None)
def test_a_box_anywhere_has_the_mass_centre_and_tensor_of_the_text_book(sides, at):
    found = mass_properties(CUBE.vertices * sides + np.array(at), CUBE.faces, density=700.0)
    mass = 700.0 * np.prod(sides)
    assert found.mass == pytest.approx(mass, rel=1e-9)
    np.testing.assert_allclose(found.centre, at, atol=1e-9)
    exact = box(*sides, mass)
    np.testing.assert_allclose(found.inertia, exact, atol=1e-9 * exact.max())


def test_a_corner_tetrahedron_has_its_known_moments_and_products():
    found = mass_properties(CORNERS, SIDES, mass=1.0)
    assert found.volume == pytest.approx(1.0 / 6.0, rel=1e-12)
    np.testing.assert_allclose(found.centre, [0.25] * 3, atol=1e-14)
    # about the corner: integral of x^2 = V / 10, of x y = V / 20; then to the centre
    exact = np.full((3, 3), -1.0 / 20.0 + 1.0 / 16.0)
    np.fill_diagonal(exact, 2.0 / 10.0 - 2.0 / 16.0)
    np.testing.assert_allclose(found.inertia, exact, atol=1e-14)


def test_every_bone_and_the_skin_have_the_mass_properties_that_trimesh_finds(hand):
    for name, mesh in {**hand.bones, "skin": hand.skin}.items():
        other = trimesh.Trimesh(mesh.points, mesh.faces, process=False)
        other.density = 1100.0
        found = mass_properties(mesh.points, mesh.faces, density=1100.0)
        assert found.volume == pytest.approx(mesh.volume, rel=1e-9), name
        assert found.mass == pytest.approx(other.mass, rel=1e-9), name
        np.testing.assert_allclose(found.centre, other.center_mass, atol=1e-9, err_msg=name)
        np.testing.assert_allclose(found.inertia, other.moment_inertia, atol=1e-7 * np.abs(found.inertia).max(), err_msg=name)


def test_a_grid_of_points_inside_a_bone_has_nearly_its_exact_moment(hand):
    bone = hand.bones["middle_phalanx_2"]
    low, high = bone.points.min(axis=0), bone.points.max(axis=0)
    ticks = [lo + (hi - lo) * (np.arange(n) + 0.5) / n for lo, hi, n in zip(low, high, (40, 20, 20), strict=True)]
    grid = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = grid[winding(*np.moveaxis(bone.points[bone.faces], 1, 0), grid) > 0.5]
    found = mass_properties(bone.points, bone.faces, mass=1.0)
    assert len(inside) / len(grid) * np.prod(high - low) == pytest.approx(found.volume, rel=0.01)
    np.testing.assert_allclose(found.centre, inside.mean(axis=0), atol=1e-4)
    for axis in np.eye(3):
        exact = axis @ found.inertia @ axis + np.sum(np.cross(found.centre - low, axis) ** 2)
        assert from_points(1.0, inside, axis, low) == pytest.approx(exact, rel=0.01)


def winding(a, b, c, points):
    """How often the surface winds around each point (solid angles of van Oosterom and Strackee over 4 pi)."""
    total = np.zeros(len(points))
    for corner in zip(a, b, c, strict=True):
        u, v, w = (p - points for p in corner)
        lu, lv, lw = (np.linalg.norm(p, axis=1) for p in (u, v, w))
        above = np.einsum("ij,ij->i", u, np.cross(v, w))
        below = lu * lv * lw + (u * v).sum(1) * lw + (v * w).sum(1) * lu + (w * u).sum(1) * lv
        total += 2.0 * np.arctan2(above, below)
    return total / (4.0 * np.pi)


def test_a_turned_mesh_has_the_turned_tensor(hand):
    bone = hand.bones["metacarpal_1"]
    turn = trimesh.transformations.rotation_matrix(1.1, [1.0, -2.0, 0.5])[:3, :3]
    one, other = (mass_properties(points, bone.faces, mass=0.02) for points in (bone.points, bone.points @ turn.T))
    np.testing.assert_allclose(other.inertia, turn @ one.inertia @ turn.T, atol=1e-12 * np.trace(one.inertia))


def test_a_finer_mesh_of_the_same_box_changes_nothing_but_the_sum_over_its_vertices():
    """The faces of a box are flat: the polyhedron stays, the vertices do not."""
    fine = trimesh.creation.box()
    fine = fine.subdivide().subdivide()
    lopsided = fine.subdivide(np.flatnonzero(fine.triangles_center[:, 0] > 0.499))
    coarse = mass_properties(CUBE.vertices, CUBE.faces, mass=1.0).inertia
    np.testing.assert_allclose(mass_properties(fine.vertices, fine.faces, mass=1.0).inertia, coarse, atol=1e-12)
    z = ([0.0, 0.0, 1.0], [0.0, 0.0, 0.0])
    sums = [from_points(1.0, mesh.vertices, *z) for mesh in (CUBE, fine, lopsided)]
    assert coarse[2, 2] == pytest.approx(1.0 / 6.0, rel=1e-12)
    assert sums[0] == pytest.approx(0.5), "eight corners: three times too much"
    assert 1.4 * coarse[2, 2] < sums[1] < 2.0 * coarse[2, 2]
    assert abs(sums[2] / sums[1] - 1.0) > 0.03


@pytest.mark.parametrize(
    ("faces", "words"),
    [
        (SIDES[:3], "open: 3 edges"),
        (SIDES[:, ::-1], "counter-clockwise"),
        (np.vstack([SIDES[:3], SIDES[3:, ::-1]]), "turn all faces outward"),
    ],
)
def test_a_mesh_that_is_open_or_turned_is_refused(faces, words):
    with pytest.raises(ValueError, match=words):
        mass_properties(CORNERS, faces, mass=1.0)


@pytest.mark.parametrize("given", [{}, {"mass": 1.0, "density": 1.0}])
def test_mass_or_density_is_asked_for(given):
    with pytest.raises(ValueError, match="either mass in kg or density"):
        mass_properties(CORNERS, SIDES, **given)


def test_a_refined_bone_has_four_times_the_faces_and_the_same_mass_properties(hand):
    bone = hand.bones["distal_phalanx_3"]
    points, faces = refined(bone.points, bone.faces)
    assert len(faces) == 4 * len(bone.faces)
    assert len(points) == len(bone.points) + 3 * len(bone.faces) // 2, "one new point for each edge"
    one, other = (mass_properties(*mesh, density=1000.0) for mesh in ((bone.points, bone.faces), (points, faces)))
    np.testing.assert_allclose(other.inertia, one.inertia, atol=1e-12 * one.inertia.max())
    assert other.volume == pytest.approx(one.volume, rel=1e-12)
