"""Crossing edges, lines that leave a surface and overlaps in the plane, against VTK and shapes reckoned by hand."""

import numpy as np
import pytest
import pyvista as pv

from handlab.physics.crossing import FLAT, leaving, overlapping, self_crossings


def arrays(mesh):
    return np.asarray(mesh.points, dtype=np.float64), mesh.faces.reshape(-1, 4)[:, 1:].astype(np.int64)


@pytest.fixture(scope="module")
def ball():
    return arrays(pv.Icosphere(radius=0.02, nsub=3))


def test_a_ball_does_not_cross_itself(ball):
    assert not self_crossings(*ball, FLAT).any()


@pytest.mark.parametrize("shift", [0.005, 0.019, 0.0399])
def test_two_balls_cross_where_both_surfaces_meet(ball, shift):
    points, faces = ball
    two = np.vstack([points, points + np.array([shift, 0.0003, 0.0001])])
    found = self_crossings(two, np.vstack([faces, faces + len(points)]), FLAT)
    cut = pv.Icosphere(radius=0.02, nsub=3)
    other = cut.copy()
    other.points += np.array([shift, 0.0003, 0.0001], dtype=np.float32)
    line, *_ = cut.intersection(other, split_first=False, split_second=False)
    assert found.any() == (line.n_points > 0)
    middles = two[np.vstack([faces, faces + len(points)])[found]].mean(axis=1)
    if line.n_points:
        distance = np.linalg.norm(np.asarray(line.points)[:, None] - middles[None], axis=2)
        assert distance.min(axis=0).max() < 0.003  # nothing is marked away from the curve of intersection
        assert distance.min(axis=1).max() < 0.006  # and all of the curve is covered


def test_two_balls_apart_do_not_cross(ball):
    points, faces = ball
    assert not self_crossings(np.vstack([points, points + np.array([0.041, 0, 0])]), np.vstack([faces, faces + len(points)]), FLAT).any()


def test_one_point_pushed_through_the_other_side_is_found(ball):
    points, faces = ball
    pushed = points.copy()
    top = int(points[:, 2].argmax())
    pushed[top] = [0.0011, 0.0007, -0.03]
    found = self_crossings(pushed, faces, FLAT)
    assert 1 <= found.sum() <= 30
    assert pushed[faces[found]].mean(axis=1)[:, 2].min() < -0.015


def test_a_flat_cap_does_not_cross_itself():
    disc = pv.Disc(inner=0.0, outer=0.02, r_res=5, c_res=40).triangulate().clean()
    points, faces = arrays(disc)
    turned = points @ np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0].T  # flat up to rounding only
    both = np.vstack([faces, faces[:, ::-1]])  # every edge in both directions
    assert not self_crossings(turned, both, FLAT).any()


def test_lines_leave_a_ball_where_geometry_says(ball):
    points, faces = ball
    mesh = pv.Icosphere(radius=0.02, nsub=3)
    rng = np.random.default_rng(5)
    origins = rng.uniform(-0.009, 0.009, (40, 3))
    for direction in rng.normal(size=(5, 3)):
        direction /= np.linalg.norm(direction)
        far = leaving(origins, direction, np.ascontiguousarray(points[faces]))
        b = origins @ direction
        exact = -b + np.sqrt(b**2 + 0.02**2 - np.einsum("ij,ij->i", origins, origins))
        np.testing.assert_allclose(far, exact, atol=2e-4)  # the ball has facets
        for origin, length in zip(origins[:10], far[:10], strict=True):
            hit, _ = mesh.ray_trace(origin, origin + 0.1 * direction)
            assert np.linalg.norm(hit[0] - origin) == pytest.approx(length, abs=1e-7)


def test_a_line_that_leaves_nowhere_runs_for_ever_and_one_from_outside_leaves_at_the_far_side(ball):
    points, faces = ball
    triangles = np.ascontiguousarray(points[faces])
    origins = np.array([[0.05, 0.0, 0.0], [-0.05, 0.0011, 0.0007]])
    assert leaving(origins, np.array([1.0, 0.0, 0.0]), triangles)[0] == np.inf
    assert leaving(origins, np.array([1.0, 0.0, 0.0]), triangles)[1] == pytest.approx(0.07, abs=2e-4)


TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


@pytest.mark.parametrize(
    ("other", "overlap"),
    [
        (TRIANGLE + np.array([0.3, 0.3]), True),
        (TRIANGLE * 0.2 + [0.1, 0.1], True),  # one inside the other
        (TRIANGLE[::-1] + np.array([0.1, 0.0]), True),  # whichever way round
        (TRIANGLE + np.array([1.0, 0.0]), False),  # corner to corner
        (np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), False),  # side by side
        (np.array([[1.0 - 1e-3, 0.0], [1.0, 1.0], [0.0, 1.0 - 1e-3]]), True),  # the same, a thousandth too near
        (TRIANGLE + np.array([0.8, 0.8]), False),  # boxes overlap, triangles do not
        (TRIANGLE + np.array([5.0, 0.0]), False),
    ],
)
def test_triangles_overlap_when_no_line_parts_them(other, overlap):
    assert overlapping(np.array([TRIANGLE, other]), 1e-6).tolist() == [overlap, overlap]
    assert overlapping(np.array([other, TRIANGLE]), 1e-6).tolist() == [overlap, overlap]


def test_overlaps_among_many_triangles_are_those_that_sampling_finds():
    rng = np.random.default_rng(8)
    many = rng.uniform(0, 1, (60, 1, 2)) + rng.uniform(-0.06, 0.06, (60, 3, 2))
    found = overlapping(many, 1e-9)
    x, y = np.meshgrid(np.linspace(-0.1, 1.1, 1500), np.linspace(-0.1, 1.1, 1500))
    inside = np.zeros((60, *x.shape), dtype=bool)
    for t, (a, b, c) in enumerate(many):
        sign = np.sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        inside[t] = np.all(
            [sign * ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) > 0 for p, q in ((a, b), (b, c), (c, a))], axis=0
        )
    twice = inside.sum(axis=0) > 1
    sampled = np.array([(inside[t] & twice).any() for t in range(60)])
    assert not (sampled & ~found).any()
    assert (found & ~sampled).sum() <= 3  # overlaps thinner than the samples
    assert 10 < sampled.sum() < 60


def test_a_crumpled_ball_crosses_itself_where_solving_every_edge_against_every_triangle_says():
    points, faces = arrays(pv.Icosphere(radius=0.02, nsub=2))
    rng = np.random.default_rng(3)
    points = points * rng.uniform(0.6, 1.4, (len(points), 1)) + rng.normal(0, 0.003, points.shape)
    expected = np.zeros(len(faces), dtype=bool)
    a, b, c = (points[faces[:, i]] for i in range(3))
    for p, q in {(min(v, w), max(v, w)) for face in faces.tolist() for v, w in zip(face, [*face[1:], face[0]], strict=True)}:
        free = np.flatnonzero(~np.isin(faces, [p, q]).any(axis=1))
        edge = np.broadcast_to(points[p] - points[q], (len(free), 3))
        system = np.stack([(b - a)[free], (c - a)[free], edge], axis=2)
        u, v, t = np.linalg.solve(system, (points[p] - a[free])[:, :, None])[:, :, 0].T
        expected[free] |= (u > 0) & (v > 0) & (u + v < 1) & (t > 0) & (t < 1)
    assert 20 < expected.sum() < len(faces)
    np.testing.assert_array_equal(self_crossings(points, faces, FLAT), expected)


def test_a_line_through_two_balls_ends_at_the_first_wall_whichever_ball_is_listed_first(ball):
    points, faces = ball
    near, far = points[faces], (points + np.array([0.1, 0.0, 0.0]))[faces]
    for order in ((near, far), (far, near)):
        found = leaving(np.array([[0.001, 0.0011, 0.0007]]), np.array([1.0, 0.0, 0.0]), np.concatenate(order))
        assert found[0] == pytest.approx(0.019, abs=2e-4)
