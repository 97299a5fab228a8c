"""The warp of a whole hand: bones stay bones, joints keep their rules, masses are right; retargeting."""

import clicks as c
import numpy as np
import people
import pytest
from scipy.spatial.transform import Rotation

import handlab as hl
from handlab.fitting.alignment import diameter, fitting_plane, frame_towards, similarity, tilted
from handlab.fitting.articulation import articulated, hand_frame
from handlab.fitting.bodies import weighed
from handlab.fitting.bones import FoldedWarp, rebuilt, sound_bones, thinnest
from handlab.fitting.fit import fit_points, warp_to
from handlab.fitting.landmarks import NAMES, source_points
from handlab.fitting.mistakes import FitError
from handlab.fitting.retarget import retarget, wanted_angles
from handlab.fitting.warp import landmark_warp, warp_hand
from handlab.physics import rbf
from handlab.physics.filling import filled
from handlab.studies import measures

MM_PER_PX = 1.0 / c.PX_PER_MM


@pytest.fixture(scope="module")
def hand():
    return people.hand()


def marks(hand, view="palmar"):
    return {name: hand.skin.points[row[view]].copy() for name, row in hand.feature_points.items()}


# ------------------------------------------------------------------ alignment and lifting


def test_the_worked_example_of_the_fitting_plane_and_the_diameters_comes_out():
    import json
    from pathlib import Path

    row = json.loads((Path(__file__).parents[1] / "data" / "equations_examples.json").read_text())["lift"]
    source = np.array(row["source_mm"])
    picture = np.array(row["pixels"]) * row["mm_per_px"]
    assert diameter(picture)[1] == pytest.approx(row["target_diameter_mm"], abs=1e-2)
    origin = source.mean(axis=0)
    normal = np.linalg.svd(source - origin)[2][2]
    assert diameter(frame_towards(normal, origin).flat(source))[1] == pytest.approx(row["source_diameter_mm"], abs=1e-3)
    height = frame_towards(normal, origin).height(source)
    height *= np.sign(height[0] * row["source_heights_mm"][0])
    np.testing.assert_allclose(height, row["source_heights_mm"], atol=1e-4)
    np.testing.assert_allclose(height * diameter(picture)[1] / row["source_diameter_mm"], row["target_heights_mm"], atol=2e-4)


@pytest.mark.parametrize("mirror", [False, True])
def test_a_similarity_is_found_exactly(mirror):
    rng = np.random.default_rng(0)
    plane = rng.normal(size=(9, 2))
    turn = Rotation.from_euler("z", 2.1).as_matrix()[:2, :2] @ np.diag([1.0, -1.0 if mirror else 1.0])
    found = similarity(plane, 1.7 * plane @ turn.T + [3.0, -4.0], mirror=mirror)
    assert found.scale == pytest.approx(1.7)
    np.testing.assert_allclose(found.matrix, turn, atol=1e-12)
    assert found.scatter < 1e-12


def test_a_tilt_of_the_very_same_hand_is_found_exactly_and_doubted_in_another_hand(hand):
    points = source_points(hand, "palmar")
    start = fitting_plane(points, "palmar")
    seen = frame_towards(start.towards + 0.2 * start.across - 0.1 * start.up, start.origin)
    frame, found = tilted(points, start, 1e3 * seen.flat(points))
    assert np.degrees(np.arccos(min(1.0, frame.towards @ seen.towards))) < 1e-4
    assert found.scatter < 1e-6
    noisy = 1e3 * seen.flat(points) + 4.0 * np.random.default_rng(0).normal(size=(26, 2))
    frame, found = tilted(points, start, noisy)
    assert np.degrees(np.arccos(frame.towards @ start.towards)) < 0.7 * np.degrees(np.hypot(0.2, 0.1))


# ------------------------------------------------------------------ joints and masses


def test_a_hand_moved_as_a_whole_keeps_joints_angles_and_masses(hand):
    turn, shift = Rotation.from_euler("xyz", [0.4, -0.3, 1.0]).as_matrix(), np.array([0.1, -0.2, 0.05])
    warp = rbf.fitted(source_points(hand, "palmar"), source_points(hand, "palmar") @ turn.T + shift)
    made = warp_hand(hand, warp, 1.0).hand
    assert np.abs(made.skin.points - hand.skin.points).max() < 1e-6
    assert np.degrees(np.abs(made.bind - hand.bind).max()) < 1e-3
    for name, body in hand.bodies.items():
        assert made.bodies[name].mass == pytest.approx(body.mass, rel=1e-3)


@pytest.mark.parametrize("side", ["right", "left"])
def test_joints_of_a_warped_hand_keep_the_rules_of_the_reference_hand(side):
    hand = hl.load_hand(side=side)
    target = {name: place * [1.2, 1.0, 0.9] + [0, 0, 0.06 * place[0]] for name, place in marks(hand).items()}
    made = warp_to(hand, target, view="palmar", marks="stored").hand
    for name, joint in made.joints.items():
        axes = np.array([dof.axis for dof in joint.dofs])
        np.testing.assert_allclose(np.linalg.norm(axes, axis=1) if len(axes) else 1.0, 1.0, atol=1e-9)
        if name != "cmc1":
            np.testing.assert_allclose(axes @ axes.T, np.eye(len(axes)), atol=1e-6)
    for k in (2, 3, 4, 5):  # zero: phalanges in line with their metacarpal
        line = [made.joints[f"{name}{k}"].centre for name in ("cmc", "mcp", "pip", "dip")]
        ways = np.diff(line, axis=0)
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        assert np.degrees(np.arccos(min(1.0, ways[0] @ ways[1]))) < 1e-3
        assert np.degrees(np.arccos(min(1.0, ways[1] @ ways[2]))) < 6.0
    palm = made.joints["mcp3"].centre - made.joints["wrist"].centre
    assert np.degrees(np.arccos(palm[0] / np.linalg.norm(palm))) < 1e-3
    np.testing.assert_allclose(made.joints["wrist"].centre, 0.0, atol=1e-12)
    assert (
        np.linalg.det(np.stack([made.dofs[f"wrist.{n}"].axis for n in ("flexion_extension", "deviation")] + [np.array([1.0, 0, 0])])) != 0
    )


def test_nothing_moves_nothing(hand):
    bones = np.concatenate([bone.points for bone in hand.bones.values()])
    turn, origin = hand_frame(hand, lambda p: p, bones, bones)
    np.testing.assert_allclose(turn, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(origin, 0.0, atol=1e-12)
    joints, bind = articulated(hand, lambda p: p, bones, bones)
    np.testing.assert_allclose(bind, hand.bind, atol=1e-7)
    for name, joint in joints.items():
        np.testing.assert_allclose(joint.centre, hand.joints[name].centre, atol=1e-7)


def test_masses_agree_with_those_that_another_method_gave_the_reference_hand(hand):
    """The stored ones were found by VTK's test of inside and outside."""
    for name, body in weighed(hand).items():
        assert body.mass == pytest.approx(hand.bodies[name].mass, rel=1e-5)
        np.testing.assert_allclose(body.centre, hand.bodies[name].centre, atol=1e-6)
        np.testing.assert_allclose(body.inertia, hand.bodies[name].inertia, rtol=1e-4, atol=1e-11)


def test_a_filled_box_has_its_volume():
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], dtype=float)
    faces = np.array(
        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    )
    turn = Rotation.from_euler("xyz", [0.3, 0.5, 0.7]).as_matrix()
    inside = filled(corner @ turn.T, faces, 0.05)
    assert len(inside) * 0.05**3 == pytest.approx(6.0, rel=0.01)
    back = inside @ turn
    assert (back > -1e-9).all()
    assert (back < np.array([1, 2, 3]) + 1e-9).all()


# ------------------------------------------------------------------ bones stay bones


def test_a_point_pushed_through_its_neighbour_is_refused_with_the_bones_and_the_points_to_look_at(hand):
    target = marks(hand)
    target["pip_index"] = target["mcp_index"] - [0.020, 0.0, 0.0]
    with pytest.raises(FoldedWarp, match=r"proximal_phalanx_2|metacarpal_2") as error:
        warp_to(hand, target, view="palmar", marks="stored")
    assert error.value.bones
    points = c.clicks(hand)
    points["pip_index"] = tuple(np.array(points["mcp_index"]) + 0.4 * (np.array(points["wrist_radial"]) - points["mcp_index"]))
    with pytest.raises(FitError, match=r"fold|thin|back to front|away from") as refusal:
        fit_points(hand, points, MM_PER_PX, view="palmar", sure=True)
    assert "pip_index" in refusal.value.names
    assert len(refusal.value.landmarks) == 26


def test_one_thin_bone_is_rebuilt_as_thick_as_the_hand_asks_for(hand):
    """A warp that squeezes everything around the little finger's last phalanx to half its thickness."""
    bone = hand.bones["distal_phalanx_5"].points
    middle = bone.mean(axis=0)
    box = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], dtype=float) * [0.012, 0.007, 0.007] + middle
    squeezed = middle + (box - middle) * [1.0, 0.45, 1.0]
    far = np.array([[x, y, z] for x in (-0.1, 0.3) for y in (-0.1, 0.1) for z in (-0.1, 0.1)])
    warp = rbf.fitted(np.concatenate([box, far]), np.concatenate([squeezed, far]))
    checked = sound_bones(hand, warp, 1.0)
    assert "distal_phalanx_5" in checked.repaired
    assert checked.thickness["distal_phalanx_5"] < 0.7
    assert thinnest(bone, checked.points["distal_phalanx_5"]) == pytest.approx(1.0, abs=0.02)
    made = warp_hand(hand, warp, 1.0).hand
    assert thinnest(bone, made.bones["distal_phalanx_5"].points) == pytest.approx(1.0, abs=0.02)
    with pytest.raises(FoldedWarp, match="distal_phalanx_5"):
        warp_hand(hand, warp, 1.0, strict=True)


def test_thickness_is_measured_across_the_bone_and_not_along_it(hand):
    points = hand.bones["metacarpal_3"].points
    axis = np.linalg.svd(points - points.mean(axis=0))[2][0]
    shorter = points - 0.5 * np.outer((points - points.mean(axis=0)) @ axis, axis)
    assert thinnest(points, shorter) == pytest.approx(1.0, abs=5e-3)
    assert thinnest(points, 0.6 * points) == pytest.approx(0.6, abs=2e-3)
    np.testing.assert_allclose(rebuilt(points, points, 1.0), points, atol=1e-6)
    turn = Rotation.from_euler("xyz", [0.3, 0.2, -0.4]).as_matrix()
    np.testing.assert_allclose(rebuilt(points, points @ turn.T + 0.1, 1.0), points @ turn.T + 0.1, atol=1e-6)


def test_known_people_need_no_repair_and_keep_their_thickness(hand):
    for person in list(people.everyone().values())[::3]:
        found = warp_to(hand, person.marks["palmar"], view="palmar").bones
        assert not found.repaired
        assert 0.8 < min(found.thickness.values()) < 1.1
        assert min(found.determinant.values()) > 0.3


def test_the_second_layer_keeps_thickness_in_proportion_to_size(hand):
    source = source_points(hand, "palmar")
    towards = fitting_plane(source, "palmar").towards
    warp = landmark_warp(source, 0.8 * source, towards)
    np.testing.assert_allclose(warp(hand.skin.points), 0.8 * hand.skin.points, atol=1e-12)
    assert len(landmark_warp(source, source, towards, rule="printed").centre) == 26
    assert len(warp.centre) == 52


# ------------------------------------------------------------------ retargeting


@pytest.fixture(scope="module")
def child(hand):
    return warp_to(hand, people.everyone()["small_child"].marks["palmar"], view="palmar").hand


def gap(clip):
    return measures.pulp_gap(clip.hand, clip.skin(-1), 1, 2)


def test_told_to_the_same_hand_a_clip_stays_as_it_is(hand):
    clip = hl.simulate(hand, "fist", seconds=1.0, fps=30)
    again = hl.simulate(hand, retarget(clip, hand), seconds=1.0, fps=30)
    assert np.degrees(np.abs(again.angle - clip.angle).max()) < 0.3


def test_a_pinch_told_to_another_hand_closes_as_far_as_its_size_asks_for(hand, child):
    clip = hl.simulate(hand, "pinch", fps=30)
    for other in (child, hl.load_hand("man")):
        plain, told = hl.simulate(other, "pinch", fps=30), hl.simulate(other, retarget(clip, other), fps=30)
        goal = other.growth.length * gap(clip)
        assert abs(gap(told) - goal) < 0.6e-3
        assert abs(gap(told) - goal) < max(0.6 * abs(gap(plain) - goal), 0.2e-3)
        assert (told.contraction >= 0.0).all()
        assert (told.contraction <= 1.0).all()


def test_open_fingers_are_wanted_as_they_are(hand, child):
    rest = np.array(hl.rest(hand).angle)[None]
    np.testing.assert_allclose(wanted_angles(hand, child, rest), rest, atol=np.deg2rad(8.0))
    np.testing.assert_array_equal(wanted_angles(hand, hand, rest), rest)


def test_a_subset_without_any_wrist_still_warps(hand):
    names = tuple(name for name in NAMES if not name.startswith(("wrist", "head")))
    fit = fit_points(hand, c.clicks(hand, names=names), MM_PER_PX, view="palmar")
    assert np.abs(fit.hand.skin.points - hand.skin.points).max() < 1e-6
    assert "no point at the wrist" in " ".join(fit.warnings)
