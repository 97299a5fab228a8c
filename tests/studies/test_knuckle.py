"""Volumes of pieces, ink on the skin and sections, against bodies whose measures are known."""

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.records import Mesh
from handlab.studies import knuckle
from handlab.studies.places import joint_place

JOINTS = [f"{joint}{k}" for joint in ("pip", "dip") for k in (2, 3, 4, 5)] + ["ip1"]


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="module")
def flat(hand):
    return hl.pose(hand, dict.fromkeys(hand.moving_names, 0.0))


@pytest.fixture(scope="module")
def bent(hand):
    return hl.pose(hand, dict.fromkeys(hand.moving_names, 0.0) | {"pip2.flexion_extension": np.pi / 2})


def tube(radius=0.01, length=0.04, around=64, along=33):
    """Points and faces of a tube along x, open at both ends, seen counter-clockwise from outside."""
    angle, x = np.arange(around) * 2 * np.pi / around, np.linspace(0.0, length, along)
    points = np.array([[a, radius * np.cos(b), radius * np.sin(b)] for a in x for b in angle])
    at = np.arange(along * around).reshape(along, around)
    a, b, c, d = at[:-1], np.roll(at, -1, axis=1)[:-1], at[1:], np.roll(at, -1, axis=1)[1:]
    return points, np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])


def test_a_tube_with_lids_has_the_volume_of_a_prism():
    points, faces = tube()
    rings = knuckle.rims(faces)
    assert sorted(map(len, rings)) == [64, 64]
    exact = 0.04 * 0.5 * 64 * 0.01**2 * np.sin(2 * np.pi / 64)
    part = knuckle.Piece(faces, tuple(map(np.array, rings)))
    assert abs(knuckle.piece_volume(points, part)) == pytest.approx(exact, rel=1e-12)
    moved = points + np.array([0.3, -0.2, 0.5])
    assert knuckle.piece_volume(moved, part) == pytest.approx(knuckle.piece_volume(points, part), rel=1e-9)


def test_the_signed_volume_of_the_skin_is_that_of_another_library(hand):
    trimesh = pytest.importorskip("trimesh")
    for mesh in (hand.skin, hand.bones["capitate"]):
        other = trimesh.Trimesh(mesh.points, mesh.faces, process=False).volume
        assert knuckle.signed_volume(mesh.points, mesh.faces) == pytest.approx(other, rel=1e-9)


@pytest.mark.parametrize("joint", JOINTS)
def test_the_piece_at_a_finger_joint_is_a_sleeve_with_two_rims(hand, joint):
    part = knuckle.piece(hand, joint)
    assert len(part.rims) == 2
    assert all(6 <= len(rim) <= 40 for rim in part.rims)
    volume = knuckle.piece_volume(hand.skin.points, part)
    assert 1.5e-6 < volume < 12e-6
    middle = hand.skin.points[np.unique(part.faces)] - joint_place(hand, joint).centre
    assert np.linalg.norm(middle, axis=1).max() < knuckle.GIRTH + 0.005


def test_pieces_that_share_a_rim_add_up_to_the_whole(hand):
    """The rest of the skin, closed by the same lids, has the rest of the volume."""
    part = knuckle.piece(hand, "pip3")
    mine = {tuple(face) for face in part.faces.tolist()}
    rest = np.array([face for face in hand.skin.faces.tolist() if tuple(face) not in mine])
    other = knuckle.Piece(rest, tuple(np.array(rim) for rim in knuckle.rims(rest)))
    total = knuckle.piece_volume(hand.skin.points, part) + knuckle.piece_volume(hand.skin.points, other)
    assert total == pytest.approx(hand.skin.volume, rel=1e-9)


def test_a_hand_that_moves_as_one_keeps_volume_and_ink(hand, bent):
    part, line = knuckle.piece(hand, "pip2"), knuckle.ink(hand, "pip2")
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    for points in (hand.skin.points, bent.skin):
        moved = points @ turn.T + 0.1
        assert knuckle.piece_volume(moved, part) == pytest.approx(knuckle.piece_volume(points, part), rel=1e-9)
        assert knuckle.ink_length(moved, line) == pytest.approx(knuckle.ink_length(points, line), rel=1e-9)
        assert knuckle.piece_volume(1.1 * points, part) == pytest.approx(1.331 * knuckle.piece_volume(points, part), rel=1e-9)


def test_ink_runs_from_proximal_to_distal_on_its_side_and_through_the_middle(hand):
    place = joint_place(hand, "pip2")
    for side, sign in (("dorsal", -1.0), ("palmar", 1.0)):
        at = knuckle.ink_points(hand.skin.points, knuckle.ink(hand, "pip2", side)) - place.centre
        assert (np.diff(at @ place.distal) > 0.0).all()
        assert np.abs(at @ place.flexion).max() < 1e-12
        assert (sign * (at @ place.palmar) > 0.003).all()
    assert 0.017 < knuckle.ink_length(hand.skin.points, knuckle.ink(hand, "pip2")) < 0.026


def test_averaged_matrices_lose_more_of_a_bent_knuckle_than_dual_quaternions(hand, flat, bent):
    part = knuckle.piece(hand, "pip2")
    kept = {way: np.divide(*(knuckle.piece_volume(knuckle.worn(hand, s, way), part) for s in (bent, flat))) for way in knuckle.WAYS[:2]}
    assert 0.7 < kept["linear"] < kept["blend"] - 0.04 < 0.95


def test_springs_stretch_the_back_less_than_blending_and_all_shorten_the_palm_side(hand, flat, bent):
    dorsal, palmar = knuckle.ink(hand, "pip2", "dorsal"), knuckle.ink(hand, "pip2", "palmar")
    grown = {}
    for way in ("blend", "springs"):
        before, after = (knuckle.worn(hand, state, way) for state in (flat, bent))
        grown[way] = knuckle.ink_length(after, dorsal) / knuckle.ink_length(before, dorsal)
        assert 0.4 < knuckle.ink_length(after, palmar) / knuckle.ink_length(before, palmar) < 0.85
    assert 1.05 < grown["springs"] < grown["blend"] - 0.1 < 1.7


def test_a_sphere_is_cut_in_a_circle_and_missed_in_nothing():
    pv = pytest.importorskip("pyvista")
    ball = pv.Sphere(radius=0.01, theta_resolution=60, phi_resolution=60)
    points, faces = np.asarray(ball.points, float), ball.faces.reshape(-1, 4)[:, 1:]
    normal = np.array([0.0, 0.6, 0.8])
    (ring,) = knuckle.section(points, faces, 0.006 * normal, normal)
    assert np.linalg.norm(ring - 0.006 * normal, axis=1) == pytest.approx(0.008, rel=0.01)
    assert (ring - 0.006 * normal) @ normal == pytest.approx(0.0, abs=1e-9)
    length = np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1).sum()
    assert length == pytest.approx(2 * np.pi * 0.008, rel=0.01)
    assert not knuckle.section(points, faces, 0.02 * normal, normal)


def test_unknown_ways_sides_and_joints_are_told(hand, flat):
    with pytest.raises(KeyError, match="springs"):
        knuckle.worn(hand, flat, "spring")
    with pytest.raises(KeyError, match="dorsal"):
        knuckle.ink(hand, "pip2", "dorsel")
    with pytest.raises(KeyError, match="pip2"):
        knuckle.piece(hand, "pip22")
    with pytest.raises(ValueError, match="longer reach"):
        knuckle.piece(hand, "pip2", 1e-9)


def test_a_mesh_of_the_records_can_be_cut(hand):
    bone = hand.bones["metacarpal_3"]
    assert isinstance(bone, Mesh)
    middle = bone.points.mean(axis=0)
    (ring,) = knuckle.section(bone.points, bone.faces, middle, np.array([1.0, 0.0, 0.0]))
    assert 0.01 < np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1).sum() < 0.06
