"""From grid to muscle: depth against another ray caster, the formula, places of an atlas, and everything that is refused."""

import dataclasses

import numpy as np
import pytest
import pyvista

import handlab as hl
from handlab.anatomy.grids import load_grids
from handlab.anatomy.terms import UnknownName
from handlab.physics.bulge import ellipsoid_volume
from handlab.physics.distance import closest, winding
from handlab.simulation.geometric_kernel import first_hit
from handlab.simulation.geometric_muscle import geometric_muscles
from handlab.simulation.muscle_below import below, influenced
from handlab.simulation.muscle_fit import FAR_SKIN, GAP, REST_SHARE, bone_corners, check_closed, checked_skin, depth_below, fit
from handlab.simulation.muscle_paint import paint

GRIDS = {grid.name: grid for grid in load_grids()}


@pytest.fixture(scope="module")
def muscles(hand):
    return geometric_muscles(hand)


@pytest.fixture(scope="module")
def sphere():
    way = np.random.default_rng(3).normal(size=(250, 3))
    return way / np.linalg.norm(way, axis=1, keepdims=True)


def surface_of(shapes, part, sphere):
    """Points on the ellipsoids of one muscle."""
    points = [shapes.centre[s] + (sphere * shapes.half[s]) @ shapes.frame[s].T for s in range(part.start, part.stop)]
    return np.ascontiguousarray(np.concatenate(points))


def test_rays_meet_what_vtk_says_they_meet(hand, rng):
    bone = hand.bones["hamate"]
    mesh = pyvista.PolyData(bone.points, np.column_stack([np.full(len(bone.faces), 3), bone.faces]))
    start = bone.points.mean(axis=0) + 0.03 * (way := rng.normal(size=(200, 3))) / np.linalg.norm(way, axis=1, keepdims=True)
    aim = bone.points.mean(axis=0) + rng.normal(size=(200, 3)) * 0.006 - start
    aim /= np.linalg.norm(aim, axis=1, keepdims=True)
    found, _ = first_hit(start, aim, np.ascontiguousarray(bone.points[bone.faces]))
    expected = np.full(200, np.inf)
    for k in range(200):
        places, _ = mesh.ray_trace(start[k], start[k] + 0.06 * aim[k])
        if len(places):
            expected[k] = np.linalg.norm(places - start[k], axis=1).min()
    assert 20 < np.isfinite(expected).sum() < 200
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_depth_counts_to_the_bone_or_to_the_far_skin(hand):
    """Over the middle of a metacarpal bone comes first; between two of them the far skin, less what must stay free."""
    m3 = hand.bones["metacarpal_3"].points.mean(axis=0)
    over = (m3 + np.array([0.0, 0.05, 0.0]))[None]
    skin = np.ascontiguousarray(hand.skin.points[hand.skin.faces])
    down = np.array([[0.0, -1.0, 0.0]])
    place = over + first_hit(over, down, skin)[0][:, None] * down
    depth = depth_below(hand, place, -down)
    assert depth[0] == pytest.approx(first_hit(place, down, bone_corners(hand))[0][0], abs=1e-9)
    tip = hand.skin.points[hand.skin.points[:, 1].argmax()]
    aside = tip[None].copy()
    through = first_hit(aside - [[0.0, 1e-5, 0.0]], down, skin)[0][0]
    bone = first_hit(aside, down, bone_corners(hand))[0][0]
    assert depth_below(hand, aside, -down)[0] == pytest.approx(min(bone, through + 1e-5 - FAR_SKIN), abs=3e-5)


def test_thickness_follows_the_formula(hand):
    """h = clamp(d - o - gap, least, share of most), o less only where room is short; centres at depth o + h/2 below the skin."""
    for grid in GRIDS.values():
        full = dataclasses.replace(grid, fullness=np.ones(len(grid.skin_distance)))
        found = fit(hand, full)
        least, most = grid.thickness
        assert np.all(found.thickness >= least - 1e-12)
        assert np.all(found.thickness <= max(least, REST_SHARE * most) + 1e-12)
        plenty = found.depth - grid.skin_distance[:, None] - GAP > REST_SHARE * most
        np.testing.assert_allclose(found.thickness[plenty], max(least, REST_SHARE * most), atol=1e-12)


def test_a_tendinous_row_has_the_least_thickness(hand):
    grid = GRIDS["abductor_digiti_minimi"]
    found = fit(hand, dataclasses.replace(grid, fullness=None))
    np.testing.assert_allclose(found.thickness[[0, -1]], grid.thickness[0], atol=1e-12)
    assert found.thickness[3].min() > 1.5 * grid.thickness[0]


def test_both_ends_sit_on_their_bones(hand, muscles):
    for one in muscles.fitted:
        for row, wanted in ((0, one.grid.on_bone[0]), (-1, one.grid.on_bone[1])):
            if not wanted:
                continue
            corners = np.concatenate([hand.bones[name].points[hand.bones[name].faces] for name in one.grid.bones[row]])
            distance = closest(np.ascontiguousarray(one.point[row]), corners)[0]
            half = one.thickness[row] / 2  # over a hollow of the bone another place may be a little nearer
            assert np.all((distance > 0.6 * half) & (distance < half + 1e-9))


@pytest.mark.parametrize("name", GRIDS)
def test_a_muscle_lies_inside_the_skin_and_hardly_in_bone(hand, muscles, sphere, name):
    points = surface_of(muscles.rest, muscles.of(name), sphere)
    skin = np.ascontiguousarray(hand.skin.points[hand.skin.faces])
    assert np.all(winding(points, skin) > 0.5)
    inside = points[winding(points, bone_corners(hand)) > 0.5]
    assert len(inside) < 0.1 * len(points)
    if len(inside):
        assert closest(np.ascontiguousarray(inside), bone_corners(hand))[0].max() < 1.5e-3


# Where each muscle lies in the hand's frame (x distal, y palmar, z radial), as any atlas shows it: (below, above) by mean centres.
PALMAR_OF = [
    ("lumbrical_2", "dorsal_interosseus_2"),
    ("lumbrical_3", "dorsal_interosseus_3"),
    ("adductor_pollicis_transverse", "dorsal_interosseus_2"),
    ("adductor_pollicis_oblique", "palmar_interosseus_1"),
    ("palmar_interosseus_1", "dorsal_interosseus_2"),
    ("palmar_interosseus_2", "dorsal_interosseus_3"),
    ("palmar_interosseus_3", "dorsal_interosseus_4"),
    ("flexor_digiti_minimi_brevis", "dorsal_interosseus_4"),
    ("abductor_pollicis_brevis", "dorsal_interosseus_1_thumb_head"),
]
RADIAL_TO_ULNAR = [
    ("dorsal_interosseus_1_thumb_head", "dorsal_interosseus_1_index_head"),
    ("dorsal_interosseus_1_index_head", "dorsal_interosseus_2"),
    ("dorsal_interosseus_2", "dorsal_interosseus_3"),
    ("dorsal_interosseus_3", "dorsal_interosseus_4"),
    ("dorsal_interosseus_4", "abductor_digiti_minimi"),
    ("palmar_interosseus_1", "palmar_interosseus_2"),
    ("palmar_interosseus_2", "palmar_interosseus_3"),
    ("lumbrical_1", "lumbrical_2"),
    ("lumbrical_2", "lumbrical_3"),
    ("lumbrical_3", "lumbrical_4"),
    ("abductor_pollicis_brevis", "flexor_pollicis_brevis"),
    ("flexor_pollicis_brevis", "adductor_pollicis_oblique"),
    ("flexor_digiti_minimi_brevis", "abductor_digiti_minimi"),
]


def belly(muscles, name):
    """Mean place (3,) of the middle of a muscle."""
    centre = muscles.rest.centre[muscles.of(name)].reshape(muscles.fibres[muscles.index(name)], -1, 3)
    return centre[:, 1:-2].mean(axis=(0, 1))


@pytest.mark.parametrize(("above", "below_it"), PALMAR_OF)
def test_one_muscle_lies_palmar_of_another(muscles, above, below_it):
    assert belly(muscles, above)[1] > belly(muscles, below_it)[1] + 1e-3


@pytest.mark.parametrize(("radial", "ulnar"), RADIAL_TO_ULNAR)
def test_one_muscle_lies_radial_of_another(muscles, radial, ulnar):
    assert belly(muscles, radial)[2] > belly(muscles, ulnar)[2] + 1e-3


@pytest.mark.parametrize(("finger", "name", "side"), [(2, "dorsal_interosseus_1_index_head", 1), (3, "dorsal_interosseus_2", 1),
                                                      (3, "dorsal_interosseus_3", -1), (4, "dorsal_interosseus_4", -1),
                                                      (2, "palmar_interosseus_1", -1), (4, "palmar_interosseus_2", 1),
                                                      (5, "palmar_interosseus_3", 1), (2, "lumbrical_1", 1), (3, "lumbrical_2", 1),
                                                      (4, "lumbrical_3", 1), (5, "lumbrical_4", 1)])  # fmt: skip
def test_an_interosseous_ends_on_the_side_to_which_it_pulls(hand, muscles, finger, name, side):
    """Its end against the middle of the phalanx's base, and the sign of its lever arm in deviation: radial is positive."""
    end = muscles.fitted[muscles.index(name)].point[-1].mean(axis=0)
    base = hand.bones[f"proximal_phalanx_{finger}"].points
    near = base[np.linalg.norm(base - end, axis=1) < 0.012]
    assert side * (end - near.mean(axis=0))[2] > 5e-4
    drive = hand.muscle_names.index(muscles.drives[muscles.index(name)][0])
    assert side * hand.lever_arm[drive, hand.dof_names.index(f"mcp{finger}.deviation")] > 0.0


def test_the_muscles_of_a_hand_hold_a_believable_volume(muscles):
    volumes = [ellipsoid_volume(muscles.rest.half[part]).sum() for part in muscles.segments]
    assert 10e-6 < sum(volumes) < 40e-6  # of a small woman's hand of some 300 cubic centimetres
    assert min(volumes) > 0.1e-6


def test_skin_points_over_a_muscle_are_those_its_grid_surrounds(hand, muscles):
    dots = hand.skin.points[influenced(hand, muscles, "abductor_digiti_minimi")]
    painted = muscles.fitted[muscles.index("abductor_digiti_minimi")].painted.reshape(-1, 3)
    assert len(dots) > 12
    assert np.linalg.norm(dots[:, None] - painted[None], axis=2).min(axis=1).max() < 0.009
    depth, ellipsoid = below(hand, muscles)
    assert np.all(np.isfinite(depth) == (ellipsoid >= 0))
    assert 0.1 < (ellipsoid >= 0).mean() < 0.5
    assert depth[ellipsoid >= 0].min() >= 0.0


# --- everything that is refused


def test_an_open_skin_and_one_that_is_no_manifold_are_refused(hand):
    faces = hand.skin.faces
    check_closed(faces, len(hand.skin.points))
    with pytest.raises(ValueError, match="is open: 3 edges"):
        check_closed(faces[1:], len(hand.skin.points))
    with pytest.raises(ValueError, match="not a manifold"):
        check_closed(np.concatenate([faces, faces[:1]]), len(hand.skin.points))
    with pytest.raises(ValueError, match="points that it does not have"):
        check_closed(faces, 10)
    open_hand = hand.with_(skin=dataclasses.replace(hand.skin, faces=hand.skin.faces[1:]))
    with pytest.raises(ValueError, match="is open"):
        fit(open_hand, GRIDS["lumbrical_1"])


def test_a_grid_over_the_cut_of_the_forearm_is_refused(hand):
    grid = GRIDS["lumbrical_1"]
    corners = hand.skin.points[hand.skin.faces]
    cut = np.flatnonzero(corners[:, :, 0].max(axis=1) < hand.skin.points[:, 0].min() + 0.002)
    triangle = np.array(grid.triangle)
    triangle[0, 0] = cut[0]
    with pytest.raises(ValueError, match="cut of the forearm"):
        fit(hand, dataclasses.replace(grid, triangle=triangle))


def test_a_grid_that_crosses_itself_is_refused(hand):
    grid = GRIDS["abductor_digiti_minimi"]
    triangle, place = np.array(grid.triangle), np.array(grid.barycentric)
    for columns in ([2, 1, 0],):
        triangle[4], place[4] = triangle[4][columns], place[4][columns]
    with pytest.raises(ValueError, match="crosses itself"):
        fit(hand, dataclasses.replace(grid, triangle=triangle, barycentric=place))
    order = [0, 1, 4, 3, 2, 5, 6]
    with pytest.raises(ValueError, match="crosses itself"):
        fit(hand, dataclasses.replace(grid, triangle=grid.triangle[order], barycentric=grid.barycentric[order]))


def test_points_on_top_of_each_other_are_refused(hand):
    grid = GRIDS["abductor_digiti_minimi"]
    triangle, place = np.array(grid.triangle), np.array(grid.barycentric)
    triangle[3], place[3] = triangle[2], place[2]
    with pytest.raises(ValueError, match="nearer than"):
        fit(hand, dataclasses.replace(grid, triangle=triangle, barycentric=place))


def test_an_end_far_from_its_bone_is_refused(hand):
    grid = GRIDS["abductor_digiti_minimi"]
    with pytest.raises(ValueError, match=r"first row .* mm from scaphoid"):
        fit(hand, dataclasses.replace(grid, bones=("scaphoid", *grid.bones[1:])))


def test_a_muscle_thicker_than_its_place_is_refused(hand):
    grid = GRIDS["abductor_pollicis_brevis"]
    with pytest.raises(ValueError, match="finds no room at row"):
        fit(hand, dataclasses.replace(grid, thickness=(0.02, 0.025)))


# --- painting from code


def on_palm(hand, rows):
    """Rows of points on the palm over the little finger's metacarpal, 3 columns."""
    start = np.array([[[x, 0.06, z] for z in (-0.016, -0.020, -0.024)] for x in rows])
    down = np.tile([0.0, -1.0, 0.0], (start.size // 3, 1))
    far = first_hit(start.reshape(-1, 3), down, np.ascontiguousarray(hand.skin.points[hand.skin.faces]))[0]
    return start + far.reshape(*start.shape[:2], 1) * [0.0, -1.0, 0.0]


def test_a_muscle_is_painted_from_code(hand):
    points = on_palm(hand, (0.022, 0.032, 0.042, 0.052))
    grid = paint(hand, "mine", points, drives="FDM", thickness=(0.001, 0.004), bones="metacarpal_5", on_bone=(False, False))
    np.testing.assert_allclose(grid.points_on(hand.skin, hand.skin.points, hand.side), points, atol=1e-6)
    found = fit(hand, grid)
    np.testing.assert_allclose(found.thickness, REST_SHARE * 0.004, atol=1e-9)
    skin = np.ascontiguousarray(hand.skin.points[hand.skin.faces])
    depth = closest(np.ascontiguousarray(found.point.reshape(-1, 3)), skin)[0]
    assert np.all((depth > 0.002) & (depth < 0.002 + REST_SHARE * 0.004 / 2 + 1e-4))


def test_painting_beside_the_skin_or_for_nobody_is_refused(hand):
    points = on_palm(hand, (0.022, 0.032, 0.042))
    more = {"thickness": (0.001, 0.004), "bones": "metacarpal_5", "on_bone": (False, False)}
    with pytest.raises(ValueError, match=r"lies off the skin: a point is 1\d mm away"):
        paint(hand, "mine", points + np.array([0.0, 0.012, 0.0]), drives="FDM", **more)
    with pytest.raises(UnknownName, match="flexor"):
        paint(hand, "mine", points, drives="flexor_digiti", **more)
    with pytest.raises(ValueError, match="finite"):
        paint(hand, "mine", points * np.nan, drives="FDM", **more)
    with pytest.raises(ValueError, match="shape"):
        paint(hand, "mine", points[0], drives="FDM", **more)


def test_a_left_hand_is_painted_as_well(hand):
    left = hl.load_hand(side="left")
    points = on_palm(hand, (0.022, 0.032, 0.042)) * [1.0, 1.0, -1.0]
    grid = paint(left, "mine", points, drives="FDM", thickness=(0.001, 0.004), bones="metacarpal_5", on_bone=(False, False))
    assert grid.side == "left"
    np.testing.assert_allclose(fit(hand, grid).point * [1.0, 1.0, -1.0], fit(left, grid).point, atol=1e-9)


def test_normals_below_which_muscles_lie_are_even(hand):
    even = checked_skin(hand)
    np.testing.assert_allclose(np.linalg.norm(even, axis=1), 1.0, atol=1e-9)
    edges = np.concatenate([hand.skin.faces[:, [0, 1]], hand.skin.faces[:, [1, 2]]])
    from handlab.simulation.skin import normals

    raw = normals(hand, hand.skin.points)
    turn = [np.einsum("ij,ij->i", n[edges[:, 0]], n[edges[:, 1]]).mean() for n in (even, raw)]
    assert turn[0] > turn[1]


@pytest.mark.parametrize("clip", ["fist", "key-pinch", "opposition-little", "spread"])
def test_muscles_stay_out_of_bone_when_the_hand_moves(hand, muscles, sphere, clip):
    """Not deeper than 2.5 mm anywhere, and less than a fifth of any muscle's surface (they are bound to bones, not pushed by them)."""
    from handlab.simulation.geometric_muscle import ellipsoids
    from handlab.simulation.kinematics import posed_bone

    angle = hl.simulate(hand, hl.keyframes(clip)).angle[-1]
    bones = np.concatenate([posed_bone(hand, name, angle)[bone.faces] for name, bone in hand.bones.items()])
    found = ellipsoids(hand, angle)
    for name in muscles.names:
        points = surface_of(found, muscles.of(name), sphere[:60])
        inside = points[winding(points, bones) > 0.5]
        assert len(inside) < 0.2 * len(points), name
        if len(inside):
            assert closest(np.ascontiguousarray(inside), bones)[0].max() < 2.5e-3, name
