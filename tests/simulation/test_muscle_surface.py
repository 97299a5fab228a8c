"""The drawn surface of a muscle: closed, the same triangles, the volume of its ellipsoids."""

import numpy as np
import pytest
import trimesh

import handlab as hl
from handlab.physics.bulge import ellipsoid_volume
from handlab.physics.distance import winding
from handlab.simulation.geometric_kernel import volume_of
from handlab.simulation.geometric_muscle import ellipsoids, geometric_muscles
from handlab.simulation.muscle_surface import skeletons, surface, surface_points, tube_faces


@pytest.fixture(scope="module")
def muscles(hand):
    return geometric_muscles(hand)


def test_every_surface_is_closed_and_faces_outwards(muscles):
    for name, mesh in zip(muscles.names, surface(muscles, muscles.rest), strict=True):
        one = trimesh.Trimesh(mesh.points, mesh.faces, process=False)
        assert one.is_watertight, name
        assert one.is_winding_consistent, name
        assert one.euler_number == 2, name
        assert one.volume > 0.0, name
        assert volume_of(mesh.points, mesh.faces) == pytest.approx(one.volume, rel=1e-9)


def test_a_surface_surrounds_the_middles_of_its_ellipsoids(muscles):
    for g, mesh in enumerate(surface(muscles, muscles.rest)):
        corners = np.ascontiguousarray(mesh.points[mesh.faces])
        assert np.all(winding(np.ascontiguousarray(muscles.rest.centre[muscles.segments[g]]), corners) > 0.5), muscles.names[g]


def test_the_drawn_volume_is_near_that_of_the_ellipsoids_and_stays(hand, muscles):
    rest = [mesh.volume for mesh in surface(muscles, muscles.rest)]
    for g, part in enumerate(muscles.segments):
        assert 0.75 < rest[g] / ellipsoid_volume(muscles.rest.half[part]).sum() < 1.25
    for name in ("fist", "key-pinch", "spread"):
        angle = hl.simulate(hand, hl.keyframes(name)).angle[-1]
        for contraction in (0.0, 1.0):
            found = surface(muscles, ellipsoids(hand, angle, np.full(len(hand.muscles), contraction)))
            np.testing.assert_allclose([mesh.volume for mesh in found] / np.array(rest), 1.0, atol=0.02)


def test_faces_are_the_same_arrays_in_every_frame(hand, muscles):
    one, other = surface(muscles, muscles.rest), surface(muscles, ellipsoids(hand, hand.relaxed))
    assert all(a.faces is b.faces and a.points.shape == b.points.shape for a, b in zip(one, other, strict=True))
    assert any(np.abs(a.points - b.points).max() > 1e-3 for a, b in zip(one, other, strict=True))


def test_places_along_and_across_cover_the_surface(muscles):
    for kept, points in zip(skeletons(muscles), surface_points(muscles, muscles.rest), strict=True):
        assert len(kept.u) == len(kept.v) == len(points)
        assert (kept.u.min(), kept.u.max()) == (0.0, 1.0)
        assert kept.v.min() == pytest.approx(-1.0, abs=0.03)


def test_a_tube_of_rings_is_a_closed_ball():
    faces = tube_faces(4, 6)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(edge) for edge in edges} == {tuple(edge[::-1]) for edge in edges}
    assert 26 - len(edges) // 2 + len(faces) == 2
