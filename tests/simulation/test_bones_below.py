"""The nearest bone and the balls inside bone, against looking at everything."""

import numpy as np
import pytest

from handlab.physics.distance import closest, winding
from handlab.simulation.bones_below import in_bone, nearest_bone
from handlab.simulation.tendon_kernel import inscribed


@pytest.fixture(scope="module")
def everything(hand):
    """All triangles of all bones, the body of each, and points in, near and far from them."""
    corners = np.concatenate([bone.points[bone.faces] for bone in hand.bones.values()])
    owner = np.repeat(np.arange(len(hand.bones)), [len(bone.faces) for bone in hand.bones.values()])
    rng = np.random.default_rng(7)
    near = corners[rng.integers(len(corners), size=400)].mean(axis=1)
    points = np.concatenate([near, near + rng.normal(0.0, 0.002, near.shape), near + rng.normal(0.0, 0.02, near.shape), near + 0.5])
    return corners, owner, points


def test_the_nearest_bone_is_that_of_the_nearest_of_all_triangles(hand, everything):
    corners, owner, points = everything
    place, distance, found = nearest_bone(hand, points)
    wanted, triangle, foot = closest(points, corners)
    assert np.array_equal(distance, wanted) and np.array_equal(found, owner[triangle]) and np.array_equal(place, foot)


def test_a_point_is_in_bone_where_the_surface_of_all_bones_winds_about_it(hand, everything):
    corners, _, points = everything
    inside = in_bone(hand, points[400:])
    assert np.array_equal(inside, winding(points[400:], corners) > 0.5)
    assert 0.1 < inside[:400].mean() < 0.6 and not inside[-400:].any()


@pytest.mark.parametrize(("bent", "size"), [(0.003, 0.003), (-0.003, 0.005), (0.02, 0.005)])
def test_a_ball_inside_a_round_surface_is_as_large_as_that_or_as_the_largest(bent, size):
    """``bent``: radius of a sphere of points, hollow if negative."""
    way = np.random.default_rng(1).normal(size=(500, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    radius = np.full(500, 0.005)
    inscribed(abs(bent) * way, np.sign(bent) * way, radius)
    np.testing.assert_allclose(radius, size, rtol=1e-9)
