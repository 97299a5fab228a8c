"""Distances and depths that judge the clips, against VTK and against shapes whose answer is known."""

import numpy as np
import pytest
import pyvista as pv

import handlab
from handlab.anatomy.records import Skin, frozen
from handlab.physics.distance import winding
from handlab.simulation.kinematics import posed_bone
from handlab.simulation.skeleton import pose, rest
from handlab.simulation.skin import blend
from handlab.studies import measures

PINCH = {
    "cmc1.flexion_opposition": 22,
    "cmc1.abduction_adduction": 40,
    "mcp1.flexion_extension": 15,
    "ip1.flexion_extension": 20,
    "mcp2.flexion_extension": 40,
    "pip2.flexion_extension": 45,
    "dip2.flexion_extension": 25,
}
CRUSHED = {f"{joint}{k}.flexion_extension": degrees for k in (2, 3, 4, 5) for joint, degrees in (("mcp", 90), ("pip", 110), ("dip", 85))}


@pytest.fixture(scope="module")
def hand():
    return handlab.load_hand()


def posed(hand, degrees):
    return pose(hand, {name: np.deg2rad(value) for name, value in degrees.items()}).angle


def vtk(points, faces):
    return pv.make_tri_mesh(np.array(points), np.array(faces))


def distance_by_vtk(surface, points):
    """Distance to a surface, without sign."""
    _, nearest = surface.find_closest_cell(points, return_closest_point=True)
    return np.linalg.norm(nearest - points, axis=1)


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
    skin = blend(hand, posed(hand, CRUSHED))
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


def test_flesh_is_nowhere_in_flesh_in_the_relaxed_hand_and_deep_in_a_crushed_one(hand):
    assert measures.flesh_depth(hand, rest(hand).skin).max() < 0.0005
    assert measures.flesh_depth(hand, blend(hand, posed(hand, CRUSHED))).max() > 0.004


def test_the_depth_of_flesh_in_flesh_is_the_distance_that_vtk_finds_to_the_skin_on_the_other_side(hand):
    """Fingertips crushed into the palm: points of a fingertip inside the rest, with the digit itself cut away."""
    skin = blend(hand, posed(hand, CRUSHED))
    depth = measures.flesh_depth(hand, skin)
    main = np.array(hand.body_names)[hand.skin.weights.argmax(axis=1)]
    palm = np.isin(main, measures.PALM)[hand.skin.faces].all(axis=1)
    surface = vtk(skin, hand.skin.faces[palm])
    deep = np.flatnonzero((depth > 0.0015) & np.char.startswith(main, "distal_phalanx"))
    assert len(deep) >= 5
    by_vtk = distance_by_vtk(surface, skin[deep])
    apart = np.abs(depth[deep] - by_vtk)
    # another finger's skin may be nearer than the palm's, and VTK also takes skin that looks away
    assert np.mean(apart < 1e-6) > 0.85 and apart.max() < 0.002


@pytest.mark.parametrize("second", [2, 3])
def test_the_gap_between_two_pulps_is_the_distance_that_vtk_finds(hand, second):
    skin = blend(hand, posed(hand, PINCH))
    pulp, faces = measures.pulps(hand), measures.segment_faces(hand)
    expected = min(
        distance_by_vtk(vtk(skin, hand.skin.faces[faces[f"distal_phalanx_{other}"]]), skin[pulp[one]]).min()
        for one, other in ((1, second), (second, 1))
    )
    assert expected > 0.001
    assert measures.pulp_gap(hand, skin, 1, second) == pytest.approx(expected, abs=2e-6)


def test_the_gap_shrinks_steadily_to_less_than_nothing_as_one_pulp_is_pushed_into_the_other(hand):
    gap = [
        measures.pulp_gap(hand, blend(hand, posed(hand, PINCH | {"mcp2.flexion_extension": 40 + more})), 1, 2) for more in range(0, 13, 2)
    ]
    assert max(gap) > 0.003 and min(gap) < -0.001
    assert np.all(np.diff(gap) < 0.0) and np.all(np.diff(gap) > -0.003)  # no jump where it changes its sign


@pytest.mark.parametrize("turned", [{}, {"cmc1.flexion_opposition": 32, "cmc1.abduction_adduction": 15, "ip1.flexion_extension": -10}])
def test_facing_is_the_angle_that_normals_from_vtk_give(hand, turned):
    skin = blend(hand, posed(hand, PINCH | turned))
    normal = vtk(skin, hand.skin.faces).compute_normals(split_vertices=False, auto_orient_normals=False, consistent_normals=False)
    one, other = (np.array(normal.point_data["Normals"])[measures.pulps(hand)[k]].sum(axis=0) for k in (1, 2))
    expected = np.arccos(-one @ other / np.linalg.norm(one) / np.linalg.norm(other))
    assert np.rad2deg(abs(measures.facing(hand, skin, 1, 2) - expected)) < 4.0  # VTK weights its normals otherwise


def test_pulps_that_look_the_same_way_face_each_other_by_180_degrees(hand):
    skin = np.array(rest(hand).skin)
    normal = measures.pulp_normal(hand, skin, 1)
    assert np.linalg.norm(normal) == pytest.approx(1.0)
    assert measures.facing(hand, skin, 1, 1) == pytest.approx(np.pi)


def test_bones_enter_one_another_as_deep_as_vtk_says(hand):
    """Joints turned past what they allow: the deepest point of either bone in the other, and no pair is overlooked."""
    angle = np.array(rest(hand).angle)
    for name, degrees in (
        ("pip3.flexion_extension", 150),
        ("mcp2.deviation", 45),
        ("cmc1.abduction_adduction", -60),
        ("ip1.flexion_extension", -50),
    ):
        angle[hand.dof_names.index(name)] = np.deg2rad(degrees)
    found = measures.bone_depths(hand, angle)
    surfaces = {name: vtk(posed_bone(hand, name, angle), bone.faces) for name, bone in hand.bones.items()}
    expected = {}
    for a in hand.bones:
        for b in hand.bones:
            if a < b and hand.bones[a].body != hand.bones[b].body:
                depth = max(
                    -pv.PolyData(surfaces[one].points).compute_implicit_distance(surfaces[other])["implicit_distance"].min()
                    for one, other in ((a, b), (b, a))
                )
                if depth > 1e-5:
                    expected[frozenset((a, b))] = depth
    assert len(expected) >= 2 and max(expected.values()) > 0.001
    got = {frozenset(pair): depth for pair, depth in found.items() if depth > 1e-5}
    assert got.keys() == expected.keys()
    for pair, depth in expected.items():
        assert got[pair] == pytest.approx(depth, abs=2e-5)


def test_the_pulps_are_palmar_skin_of_the_last_phalanges(hand):
    for k, points in measures.pulps(hand).items():
        assert 5 <= len(points) <= 30
        bone = hand.bones[f"distal_phalanx_{k}"].points
        distance = distance_by_vtk(vtk(bone, hand.bones[f"distal_phalanx_{k}"].faces), hand.skin.points[points])
        assert distance.min() > 0.001 and distance.max() < 0.012
        assert measures.digit_number(k) == k
    assert measures.digit_number("thumb") == 1 and measures.digit_number("little") == 5
