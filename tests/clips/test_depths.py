"""Depth of flesh in flesh, as the tests of the clips measure it: against ray counting and against balls of known overlap."""

import numpy as np
import pytest
import pyvista as pv

from handlab.anatomy.records import Skin, frozen
from handlab.physics.distance import winding
from handlab.simulation.skeleton import pose
from handlab.simulation.skin import blend
from handlab.studies import measures

CRUSHED = {
    f"{joint}{k}.flexion_extension": np.deg2rad(degrees)
    for k in (2, 3, 4, 5)
    for joint, degrees in (("mcp", 90), ("pip", 110), ("dip", 85))
}


def crossings(points, corners, direction):
    """Winding number by counting the triangles that a ray leaves through, minus those that it enters through (Moeller, Trumbore)."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(direction, v)
    det = np.einsum("ij,ij->i", u, p)
    count = []
    for point in points:
        t = point - a
        q = np.cross(t, u)
        with np.errstate(divide="ignore", invalid="ignore"):
            s, r, far = np.einsum("ij,ij->i", t, p) / det, (q @ direction) / det, np.einsum("ij,ij->i", v, q) / det
        hit = (s >= 0) & (r >= 0) & (s + r <= 1) & (far > 0)
        count.append(-np.sign(det[hit]).sum())  # out through a triangle whose normal goes along
    return np.array(count)


def test_the_winding_number_counts_how_often_a_point_is_inside(hand):
    """A hand crushed beyond what flesh allows winds twice about some places; rays count the same."""
    skin = blend(hand, pose(hand, CRUSHED).angle)
    corners = np.ascontiguousarray(skin[hand.skin.faces])
    rng = np.random.default_rng(4)
    points = skin[rng.integers(0, len(skin), 400)] + rng.normal(0.0, 0.003, (400, 3))
    direction = np.array([0.31, -0.74, 0.59])
    counted = crossings(points, corners, direction)
    assert set(np.unique(counted)) >= {0.0, 1.0, 2.0}
    np.testing.assert_allclose(winding(points, corners), counted, atol=1e-6)


@pytest.mark.parametrize("overlap", [0.0005, 0.002, 0.006])
def test_two_balls_are_as_deep_in_one_another_as_their_centres_say(hand, overlap):
    """Analytic: radii r + s minus the distance of the centres, at the points on the line between them."""
    ball = pv.Icosphere(radius=0.02, nsub=4)
    one, faces = np.array(ball.points, dtype=float), ball.faces.reshape(-1, 4)[:, 1:]
    pole = one[np.argmax(one[:, 0])] / 0.02  # a point of the mesh, so that the deepest place is one of its points
    other = -one + pole * (0.04 - overlap)
    skin = np.vstack([one, other])
    both = np.vstack([faces, faces[:, ::-1] + len(one)])
    made = hand.with_(skin=Skin(frozen(skin), frozen(both, np.int64), hand.skin.weights))
    depth = measures.flesh_depth(made, skin)
    assert depth.max() == pytest.approx(overlap, abs=1.5e-4)
    reach = np.sqrt(0.02**2 - (0.02 - overlap / 2) ** 2)  # of the lens about the line
    touched = depth > 0
    across = np.linalg.norm(skin[touched] - np.outer(skin[touched] @ pole, pole), axis=1)
    assert touched.any() and across.max() < reach + 1e-3
    assert not measures.flesh_depth(made, np.vstack([one, other + pole * (overlap + 0.001)])).any()
