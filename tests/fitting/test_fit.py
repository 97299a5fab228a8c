"""From clicks to a hand: the round trip, sides, readings, files."""

import clicks as c
import numpy as np
import pytest

import handlab as hl
from handlab.fitting.fit import fit_photo, fit_points, warp_to
from handlab.fitting.landmarks import NAMES, SIXTEEN, source_points
from handlab.fitting.mistakes import FitError, FitQuestion
from handlab.physics.polyhedron import mass_properties

MM = 1e-3
MM_PER_PX = 1.0 / c.PX_PER_MM


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="module")
def longer(hand):
    """A hand whose points were stretched by 12 % along and 5 % across: not similar to the reference."""
    stretched = {name: hand.skin.points[row["palmar"]] * [1.12, 1.06, 1.05] for name, row in hand.feature_points.items()}
    return warp_to(hand, stretched, view="palmar", marks="stored").hand


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("view", ["palmar", "dorsal"])
@pytest.mark.parametrize("direction", [(0, 1, 0), (-0.17, 0.96, -0.23), (0.1, 0.98, 0.05)])
def test_the_reference_hand_returns_itself_from_exact_clicks(side, view, direction):
    own = hl.load_hand(side=side)
    lean = np.array(direction) * [1, 1, 1 if side == "right" else -1]
    fit = fit_points(hl.load_hand(), c.clicks(own, view, direction=lean, turn=2.6), MM_PER_PX, view=view)
    assert (fit.side, fit.view) == (side, view)
    assert np.abs(fit.hand.skin.points - own.skin.points).max() < 1e-3 * MM  # asked for: 0.5 mm
    assert np.abs(fit.hand.skin_fine.points - own.skin_fine.points).max() < 1e-3 * MM
    for name, bone in own.bones.items():
        assert np.abs(fit.hand.bones[name].points - bone.points).max() < 1e-3 * MM
    for name, dof in own.dofs.items():
        assert np.linalg.norm(fit.hand.dofs[name].anchor - dof.anchor) < 1e-3 * MM
        assert np.linalg.norm(np.cross(fit.hand.dofs[name].axis, dof.axis)) < 1e-5
    assert np.degrees(np.abs(fit.hand.bind - own.bind).max()) < 1e-4
    for name, body in own.bodies.items():
        assert fit.hand.bodies[name].mass == pytest.approx(body.mass, rel=1e-4)
    np.testing.assert_allclose(fit.hand.lever_arm, own.lever_arm, rtol=1e-4, atol=1e-9)


def test_one_of_view_and_side_is_enough_and_the_other_is_concluded(hand):
    left = hl.load_hand(side="left")
    assert fit_points(hand, c.clicks(left, "dorsal"), MM_PER_PX, side="left").view == "dorsal"
    assert fit_points(hand, c.clicks(left, "dorsal"), MM_PER_PX, view="dorsal").side == "left"
    assert fit_points(hand, c.clicks(hand, "palmar", mirror=True), MM_PER_PX, view="palmar", mirror=True).side == "right"


def test_without_either_it_asks_and_names_both_readings(hand):
    with pytest.raises(FitQuestion, match="palm of a right hand or the back of a left hand") as asked:
        fit_points(hand, c.clicks(hand), MM_PER_PX)
    assert {"view": "palmar"} in asked.value.choices
    assert len(asked.value.landmarks) == 26


def test_a_side_that_the_points_contradict_is_refused(hand):
    with pytest.raises(FitError, match="mirror=True"):
        fit_points(hand, c.clicks(hand, "palmar"), MM_PER_PX, view="palmar", side="left")


def test_points_that_fit_turned_and_mirrored_alike_ask_for_both(hand):
    """One finger, its points a little to the left and right of a line in turns."""
    names = ("tip_middle", "dip_middle", "pip_middle", "mcp_middle", "wrist_radial")
    along = np.linalg.norm(hand.skin.points[[hand.feature_points[name]["palmar"] for name in names]] - [0.15, 0.04, 0.0], axis=1) * 1e3
    points = {name: (500.0 + 40.0 * (k % 2), 300.0 + c.PX_PER_MM * far) for k, (name, far) in enumerate(zip(names, along, strict=True))}
    with pytest.raises(FitQuestion, match="turned and mirrored"):
        fit_points(hand, points, MM_PER_PX, view="palmar")


@pytest.mark.parametrize("rule", ["least squares", "printed"])
def test_every_landmark_is_hit_to_1e_6_mm(hand, longer, rule):
    fit = fit_points(hand, c.clicks(longer), MM_PER_PX, view="palmar", rule=rule, marks="stored")
    goal = (fit.target - fit.warped.origin) @ fit.warped.rotation.T
    before = source_points(fit.aligned.hand, "palmar")
    hit = (fit.warped.rbf(before) - fit.warped.origin) @ fit.warped.rotation.T
    assert np.abs(hit - goal).max() < 1e-9 * MM * 1e3
    # stored skins are rounded to 32 bits: less than 10 nanometres
    assert np.abs(source_points(fit.hand, "palmar") - goal).max() < 1e-5 * MM
    seen = fit.to_picture(source_points(fit.hand, "palmar"))
    np.testing.assert_allclose(seen, fit.clicks, atol=1e-3)


def test_another_hand_comes_out_with_its_own_lengths(hand, longer):
    for names, bound in ((NAMES, 0.02), (SIXTEEN, 0.05)):
        rows = fit_points(hand, c.clicks(longer, names=names), MM_PER_PX, view="palmar", marks="stored").report().lengths_mm
        from handlab.fitting.report import segment_lengths_mm

        truth = segment_lengths_mm(longer)
        off = [abs(rows[name][0] / truth[name] - 1.0) for name in truth]
        assert np.mean(off) < bound


def test_what_has_no_place_stays_the_very_same_array(hand, longer):
    fit = fit_points(hand, c.clicks(longer), MM_PER_PX, view="palmar")
    assert fit.hand.skin.faces is hand.skin.faces
    assert fit.hand.skin.weights is hand.skin.weights
    assert fit.hand.skin_fine.faces is hand.skin_fine.faces
    assert fit.hand.skin_fine.texture is hand.skin_fine.texture
    assert fit.hand.feature_points is hand.feature_points
    assert all(fit.hand.bones[name].faces is bone.faces for name, bone in hand.bones.items())
    assert (fit.hand.muscle_names, fit.hand.dof_names, fit.hand.body_names) == (hand.muscle_names, hand.dof_names, hand.body_names)


def test_a_size_gives_back_l_l2_l3_and_l5(hand):
    size = 1.2
    fit = fit_points(hand, c.clicks(hand, size=size), MM_PER_PX, view="palmar")
    laws = fit.report().laws
    for name, power in {"length": 1, "force": 2, "torque": 3, "inertia": 5}.items():
        assert laws[name].power == power
        assert laws[name].found == pytest.approx(size**power, rel=2e-3)
        assert laws[name].expected == pytest.approx(size**power, rel=1e-4)
    assert "L^5" in str(fit.report())
    np.testing.assert_allclose(fit.hand.rest_length, size * hand.rest_length, rtol=1e-4)
    whole = sum(body.mass for body in fit.hand.bodies.values())
    skin = mass_properties(fit.hand.skin.points, fit.hand.skin.faces, density=1100.0)
    assert whole == pytest.approx(skin.mass, rel=1e-6)


def test_mechanics_of_a_scaled_hand_move_it_by_the_same_angles_and_kept_ones_by_the_papers_way(hand):
    points = c.clicks(hand, size=0.8)
    kept = fit_points(hand, points, MM_PER_PX, view="palmar", mechanics="kept").hand
    scaled = fit_points(hand, points, MM_PER_PX, view="palmar").hand
    assert kept.growth is None
    np.testing.assert_array_equal(kept.lever_arm, hand.lever_arm)
    np.testing.assert_array_equal(kept.max_force, hand.max_force)
    assert [b.mass for b in kept.bodies.values()] == [b.mass for b in hand.bodies.values()]
    assert kept.bodies["carpus"].inertia[0, 0] == pytest.approx(0.64 * hand.bodies["carpus"].inertia[0, 0], rel=1e-2)
    at_end = [hl.settle(one, {"FDP2": 0.3}, hold=["wrist"]).state.angle for one in (hand, scaled)]
    assert np.degrees(np.abs(at_end[0] - at_end[1]).max()) < 0.5
    assert np.degrees(np.abs(at_end[0] - hand.relaxed).max()) > 10.0


def test_a_hand_file_loads_back_to_the_last_bit(hand, longer, tmp_path):
    made = fit_points(hand, c.clicks(longer), MM_PER_PX, view="palmar").hand
    again = hl.load_hand(made.save(tmp_path / "me"))
    for name in ("points", "faces", "weights"):
        np.testing.assert_array_equal(getattr(again.skin, name), getattr(made.skin, name))
    for name in ("points", "faces", "texture", "triangle", "barycentric", "height"):
        np.testing.assert_array_equal(getattr(again.skin_fine, name), getattr(made.skin_fine, name))
    for name, bone in made.bones.items():
        np.testing.assert_array_equal(again.bones[name].points, bone.points)
    for name in ("bind", "fibre_rest", "relaxed", "stiffness", "friction", "lever_arm", "rest_length", "max_force"):
        np.testing.assert_array_equal(getattr(again, name), getattr(made, name))
    for name, dof in made.dofs.items():
        np.testing.assert_array_equal(again.dofs[name].axis, dof.axis)
        np.testing.assert_array_equal(again.dofs[name].anchor, dof.anchor)
    for name, body in made.bodies.items():
        assert again.bodies[name].mass == body.mass
        np.testing.assert_array_equal(again.bodies[name].inertia, body.inertia)
        np.testing.assert_array_equal(again.bodies[name].centre, body.centre)
    np.testing.assert_array_equal(again.capsule.torque, made.capsule.torque)
    assert dict(again.muscles) == dict(made.muscles)
    assert again.sources == made.sources
    np.testing.assert_array_equal(hl.simulate(again, "fist", seconds=0.3).angle, hl.simulate(made, "fist", seconds=0.3).angle)


@pytest.mark.parametrize("name", ["fist", "pinch"])
def test_clips_play_on_the_new_hand(hand, longer, name):
    made = fit_points(hand, c.clicks(longer), MM_PER_PX, view="palmar").hand
    clip = hl.simulate(made, name, fps=30)
    stop = np.deg2rad(3.0)
    assert np.isfinite(clip.angle).all()
    assert (clip.angle > made.limits[:, 0] - stop).all()
    assert (clip.angle < made.limits[:, 1] + stop).all()
    assert np.degrees(np.ptp(clip.angle, axis=0).max()) > 15


def test_the_fine_skin_sits_on_the_new_even_skin(hand, longer):
    from handlab.simulation.skin import fine_points

    made = fit_points(hand, c.clicks(longer), MM_PER_PX, view="palmar").hand
    assert np.abs(fine_points(made, made.skin.points) - made.skin_fine.points).max() < 1e-6


def test_a_picture_gives_outline_and_overlap(hand):
    shape = (2700, 2700)
    points = c.clicks(hand, turn=0.0)
    fit = fit_photo((shape[1], shape[0]), landmarks=points, scale=MM_PER_PX, view="palmar", sure=True, camera_mm=None)
    from handlab.fitting.outline import silhouette

    mask = silhouette(fit.to_picture(hand.skin_fine.points), hand.skin_fine.faces, shape)
    pixels = np.where(mask[:, :, None], np.uint8([200, 150, 120]), np.uint8([20, 24, 28]))
    again = fit_photo(pixels, landmarks=points, scale=MM_PER_PX, view="palmar", camera_mm=None)
    assert again.iou > 0.98
    assert len(again.outline) > 500
    assert again.outline[:, 1].max() < shape[0] + 200
    with pytest.raises(ValueError, match="needs the picture itself"):
        _ = fit.iou


def test_perspective_is_taken_out_where_the_distance_is_known(hand):
    """Pinhole 500 mm over the table: points h above it look larger by 500 / (500 - h)."""
    names = NAMES
    points = hand.skin.points[[hand.feature_points[name]["palmar"] for name in names]] * 1e3
    above = points[:, 1] - 1e3 * hand.skin.points[:, 1].min()
    flat = np.stack([points[:, 2], points[:, 0]], axis=1) - [0.0, 60.0]
    px = (flat * (500.0 / (500.0 - above))[:, None]) * [c.PX_PER_MM, -c.PX_PER_MM] + 1500.0
    seen = dict(zip(names, map(tuple, px), strict=True))
    plain = fit_points(hand, seen, MM_PER_PX, view="palmar")
    known = fit_points(hand, seen, MM_PER_PX, view="palmar", camera_mm=500.0, centre_px=(1500.0, 1500.0))
    assert plain.growth > 1.05
    assert "perspective" in " ".join(plain.warnings)
    assert known.growth == pytest.approx(1.0, abs=0.006)
    assert np.abs(known.hand.skin.points - hand.skin.points).max() < 2.5 * MM
    seen_again = known.to_picture(known.hand.skin.points[[hand.feature_points[name]["palmar"] for name in names]])
    assert np.abs(seen_again - px).max() < 1.5 * c.PX_PER_MM
