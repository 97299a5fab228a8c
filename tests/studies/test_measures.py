"""Measures of a posture against VTK, on the real hand pushed into itself by known amounts."""

import numpy as np
import pytest
import pyvista as pv
import trimesh

import handlab
from handlab.anatomy.mirror import mirrored
from handlab.simulation.kinematics import posed_bone
from handlab.studies import measures

MM = 1e-3


@pytest.fixture(scope="module")
def hand():
    return handlab.load_hand()


@pytest.fixture(scope="module")
def skin(hand):
    return np.array(hand.skin.points)


def poly(points, faces):
    return pv.PolyData(np.array(points), np.hstack([np.full((len(faces), 1), 3), faces]).ravel())


def depth(points, mesh):
    """VTK: how deep points lie in a closed surface."""
    return -np.asarray(pv.PolyData(np.array(points)).compute_implicit_distance(mesh)["implicit_distance"])


def between(one, other):
    """VTK: least distance of points to a surface that need not be closed."""
    _, near = other.find_closest_cell(np.array(one), return_closest_point=True)
    return np.linalg.norm(one - near, axis=1)


def patch(hand, skin, k):
    """The pulp's own triangles."""
    return poly(skin, hand.skin.faces[np.isin(hand.skin.faces, measures.pulps(hand)[k]).all(axis=1)])


def shifted(hand, skin, k, by):
    """The skin with one fingertip carried off, and the points that were carried."""
    moved = skin.copy()
    carried = np.flatnonzero(hand.skin.weights[:, hand.body_names.index(f"distal_phalanx_{k}")] > 0.5)
    moved[carried] += by
    return moved, carried


def fingertip(hand, skin, m):
    """The last two segments of a finger as a closed surface of their own."""
    faces = measures.segment_faces(hand)
    own = np.unique(np.concatenate([faces[f"{kind}_phalanx_{m}"] for kind in ("middle", "distal")]))
    return poly(skin, hand.skin.faces[own]).clean().fill_holes(0.1).compute_normals(auto_orient_normals=True, split_vertices=False)


def into(hand, skin, k, m, overlap):
    """By how much fingertip ``k`` must be carried towards fingertip ``m`` so that its deepest point lies ``overlap`` deep in it."""
    own, other = (skin[measures.pulps(hand)[i]].mean(axis=0) for i in (k, m))
    towards = (other - own) / np.linalg.norm(other - own)
    closed = fingertip(hand, skin, m)
    carried = np.flatnonzero(hand.skin.weights[:, hand.body_names.index(f"distal_phalanx_{k}")] > 0.999)
    low, high = 0.0, float(np.linalg.norm(other - own))
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if depth(skin[carried] + middle * towards, closed).max() < overlap else (low, middle)
    return low * towards


# ---------------------------------------------------------------- normals and pulps


def test_vertex_normals_point_outwards_and_are_weighted_by_area(hand, skin):
    found = measures.vertex_normals(skin, hand.skin.faces)
    faces = trimesh.Trimesh(skin, hand.skin.faces, process=False)
    for i in np.linspace(0, len(skin) - 1, 60).astype(int):
        mine = (hand.skin.faces == i).any(axis=1)
        expected = (faces.area_faces[mine, None] * faces.face_normals[mine]).sum(axis=0)
        np.testing.assert_allclose(found[i], expected / np.linalg.norm(expected), atol=1e-9)
    assert (depth(skin + 0.0005 * found, poly(skin, hand.skin.faces)) < 0).mean() > 0.995


def test_digits_have_numbers_and_names():
    assert [measures.digit_number(name) for name in ("thumb", "index", "middle", "ring", "little", 4)] == [1, 2, 3, 4, 5, 4]


def test_a_pulp_is_the_palmar_side_of_its_fingertip(hand, skin):
    normals = trimesh.Trimesh(skin, hand.skin.faces, process=False).vertex_normals
    for k, points in measures.pulps(hand).items():
        bone = hand.bones[f"distal_phalanx_{k}"].points
        assert 5 <= len(points) <= 40
        assert np.linalg.norm(skin[points] - bone.mean(axis=0), axis=1).max() < 20 * MM
        if k > 1:  # fingers lie nearly flat: palmar is y
            assert normals[points, 1].mean() > 0.6
            assert skin[points, 1].mean() > bone[:, 1].mean() + 3 * MM
        assert (hand.skin.weights[points, hand.body_names.index(f"distal_phalanx_{k}")] > 0.9).all()


def test_every_triangle_moves_mainly_with_some_body(hand):
    faces = measures.segment_faces(hand)
    assert set(faces) == set(hand.body_names)
    np.testing.assert_array_equal(np.unique(np.concatenate(list(faces.values()))), np.arange(len(hand.skin.faces)))
    thumb = hand.skin.points[hand.skin.faces[faces["distal_phalanx_1"]]].mean(axis=(0, 1))
    assert np.linalg.norm(thumb - hand.bones["distal_phalanx_1"].points.mean(axis=0)) < 8 * MM


# ---------------------------------------------------------------- gaps between fingertips


@pytest.mark.parametrize(("k", "m"), [(1, 2), (2, 3), (3, 4), (1, 5)])
def test_the_gap_of_open_fingertips_is_the_distance_of_their_surfaces(hand, skin, k, m):
    expected = min(
        between(skin[measures.pulps(hand)[k]], patch(hand, skin, m)).min(),
        between(skin[measures.pulps(hand)[m]], patch(hand, skin, k)).min(),
    )
    assert measures.pulp_gap(hand, skin, k, m) == pytest.approx(expected, abs=1e-8)
    assert expected > 5 * MM
    assert measures.pulp_gap(hand, skin, m, k) == measures.pulp_gap(hand, skin, k, m)


@pytest.mark.parametrize("overlap", [0.5 * MM, 1.5 * MM, 3 * MM])
def test_a_fingertip_pushed_into_its_neighbour_has_a_gap_as_negative_as_it_is_deep(hand, skin, overlap):
    by = into(hand, skin, 2, 3, overlap)
    moved, carried = shifted(hand, skin, 2, by)
    carried = carried[hand.skin.weights[carried].max(axis=1) > 0.999]  # what the joint's fold does is another matter
    found = measures.skin_distance(hand, moved, carried, measures.segment_faces(hand)["distal_phalanx_3"])
    assert found.min() == pytest.approx(-overlap, abs=0.3 * MM)
    assert measures.flesh_depth(hand, moved)[carried].max() == pytest.approx(overlap, abs=0.3 * MM)
    surely = hand.skin.weights.max(axis=1) > 0.6
    finger = np.isin(hand.skin.weights.argmax(axis=1), [hand.body_names.index(f"{kind}_phalanx_2") for kind in ("middle", "distal")])
    expected = depth(moved[surely & finger], fingertip(hand, skin, 3)).max()
    assert measures.digit_depths(hand, moved)[1, 3] == pytest.approx(expected, abs=0.4 * MM)


def test_an_open_hand_has_no_flesh_in_flesh(hand, skin):
    assert measures.flesh_depth(hand, skin).max() == 0.0
    assert measures.digit_depths(hand, skin).max() == 0.0
    assert measures.digit_depths(hand, skin).shape == (5, 6)


@pytest.mark.parametrize("deep", [0.7 * MM, 2 * MM, 4 * MM])
def test_a_fingertip_pressed_into_the_palm_is_as_deep_as_vtk_says(hand, skin, deep):
    """The fingertip turned over and carried onto the palm, which stays as it is."""
    tip = np.flatnonzero(hand.skin.weights[:, hand.body_names.index("distal_phalanx_3")] > 0.5)
    centre = skin[tip].mean(axis=0)
    turned = centre + (skin[tip] - centre) * [-1.0, -1.0, 1.0]  # half a turn about z: the pulp looks at the palm
    over = np.array([0.045, 0.06, -0.005]) - centre
    whole = poly(skin, hand.skin.faces)
    low, high = 0.0, 0.06
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if depth(turned + over - [0, middle, 0], whole).max() < deep else (low, middle)
    moved = skin.copy()
    moved[tip] = turned + over - [0, low, 0]
    expected = depth(moved[tip], whole)
    found = measures.flesh_depth(hand, moved)[tip]
    pulp = np.isin(tip, measures.pulps(hand)[3])
    assert expected[pulp].max() == pytest.approx(deep, abs=0.2 * MM)
    np.testing.assert_allclose(found[pulp], np.maximum(expected[pulp], 0.0), atol=0.3 * MM)
    assert measures.pulp_to_palm(hand, moved, 3) == pytest.approx(-expected[pulp].max(), abs=0.1 * MM)
    assert measures.digit_depths(hand, moved)[2, 0] == pytest.approx(deep, abs=0.2 * MM)


def test_the_distance_to_the_palm_is_that_of_the_surfaces(hand, skin):
    faces = measures.segment_faces(hand)
    palm = poly(skin, hand.skin.faces[np.concatenate([faces[name] for name in measures.PALM])])
    for k in (1, 3, 5):
        assert measures.pulp_to_palm(hand, skin, k) == pytest.approx(between(skin[measures.pulps(hand)[k]], palm).min(), abs=1e-8)
    assert measures.pulp_to_bodies(hand, skin, 2, ("carpus",)) >= measures.pulp_to_palm(hand, skin, 2)


# ---------------------------------------------------------------- facing


def test_a_pulp_faces_what_lies_in_front_of_it(hand, skin):
    """Fingers side by side look past each other; one turned over and laid in front of the other faces it, behind it not."""
    assert np.linalg.norm(measures.pulp_normal(hand, skin, 2)) == pytest.approx(1.0)
    assert np.radians(60) < measures.facing(hand, skin, 2, 3) < np.radians(120)
    tip = np.flatnonzero(hand.skin.weights[:, hand.body_names.index("distal_phalanx_2")] > 0.5)
    pulp, other = measures.pulps(hand)[2], measures.pulps(hand)[3]
    ahead = measures.pulp_normal(hand, skin, 3)
    for distance, most in ((0.02, np.radians(40)), (-0.02, None)):
        moved = skin.copy()
        moved[tip] = skin[tip] * [1.0, -1.0, -1.0]  # half a turn about x
        moved[tip] += skin[other].mean(axis=0) + distance * ahead - moved[pulp].mean(axis=0)
        there, back = measures.facing(hand, moved, 3, 2), measures.facing(hand, moved, 2, 3)
        assert there == pytest.approx(0.0 if most else np.pi, abs=1e-6)
        assert (back < most) if most else (back > np.radians(140))


def test_measures_of_the_left_hand_are_those_of_the_right(hand, skin):
    left = mirrored(hand)
    for k, m in ((1, 2), (2, 3)):
        assert measures.pulp_gap(left, np.array(left.skin.points), k, m) == pytest.approx(measures.pulp_gap(hand, skin, k, m), abs=1e-12)
        assert measures.facing(left, np.array(left.skin.points), k, m) == pytest.approx(measures.facing(hand, skin, k, m), abs=1e-12)


# ---------------------------------------------------------------- bones


def test_no_bone_enters_another_as_the_hand_is_stored(hand):
    assert max(measures.bone_depths(hand, hand.bind).values(), default=0.0) < 0.1 * MM


def test_bones_driven_into_each_other_are_found_with_the_depth_that_vtk_says(hand):
    angle = np.array(hand.bind)
    for name in ("mcp2.flexion_extension", "pip3.flexion_extension", "wrist.deviation"):
        angle[hand.dof_names.index(name)] -= np.radians(70)
    found = measures.bone_depths(hand, angle)
    assert len(found) >= 2
    for (a, b), value in found.items():
        one, other = (poly(posed_bone(hand, name, angle), hand.bones[name].faces) for name in (a, b))
        assert value == pytest.approx(max(depth(one.points, other).max(), depth(other.points, one).max()), abs=1e-6)
        assert hand.bones[a].body != hand.bones[b].body
