"""The skin brought to the outline in the picture: against true outlines and true skins of known people, and where it must not be used."""

from dataclasses import replace

import numpy as np
import people
import photograph
import pytest
from scipy.interpolate import RBFInterpolator
from scipy.ndimage import gaussian_filter, shift
from scipy.spatial import cKDTree

from handlab.fitting.fit import fit_photo
from handlab.fitting.outline import overlap, silhouette
from handlab.fitting.outlined import GAP, OTHER, UNSEEN, _apart
from handlab.physics import rbf
from tools.people.rig import moved

BROAD, THIN = "man_broad", "girl_thin_fingers"


def taken(name, camera="pinhole", view="dorsal", **options):
    return photograph.photograph(people.everyone()[name], camera=camera, view=view, **options)


def fitted(picture, camera="pinhole", **options):
    rng = np.random.default_rng(0)
    scale = {"ruler": picture.ruler_clicks(rng), "mm": photograph.RULER_MM}
    with people.only_shapes():
        return fit_photo(
            picture.pixels,
            landmarks=picture.clicks(rng),
            scale=scale,
            view=picture.view,
            camera_mm=1e3 * photograph.DISTANCE if camera == "pinhole" else None,
            **options,
        )


def true_overlap(fit, picture):
    """With the pixels that the person covers, not with what was taken for them."""
    shape = picture.outline.shape
    drawn = silhouette(fit.to_picture(fit.hand.skin_fine.points), fit.hand.skin_fine.faces, shape)
    return overlap(drawn, picture.outline, fit.beyond_wrist(picture.outline, 1.0))


def error(fit, name):
    return people.skin_error_mm(fit.hand.skin_fine.points, people.everyone()[name])


@pytest.mark.parametrize("camera", ["pinhole", "flatbed"])
@pytest.mark.parametrize("view", ["palmar", "dorsal"])
@pytest.mark.parametrize("name", [BROAD, THIN])
def test_the_hand_gets_the_true_outline_and_comes_nearer_to_the_true_skin(name, view, camera):
    picture = taken(name, camera, view)
    with_it, without = fitted(picture, camera), fitted(picture, camera, outline=False)
    assert without.edge is None and with_it.edge is not None
    assert true_overlap(without, picture) < 0.97 < 0.975 < true_overlap(with_it, picture) < 1.0
    assert 0.4 < error(with_it, name) / error(without, name) < 0.92
    assert "and the outline" in str(with_it.report()) and "outline" not in str(without.report())
    assert "points of its outline" in with_it.hand.sources["shape"]


def thickness(hand, k):
    """Mean thickness (mm) of the middle phalanx's skin across the palm's plane."""
    fine, name = hand.skin_fine, f"middle_phalanx_{k}"
    owner = hand.skin.weights.argmax(axis=1)[hand.skin.faces[fine.triangle, 0]]
    points = fine.points[owner == hand.body_names.index(name)]
    bone = hand.bones[name].points
    axis = np.linalg.svd(bone - bone.mean(axis=0), full_matrices=False)[2][0]
    across = np.array([0.0, 1.0, 0.0]) - axis[1] * axis
    height = points @ (across / np.linalg.norm(across))
    return 1e3 * (np.quantile(height, 0.95) - np.quantile(height, 0.05))


@pytest.mark.parametrize(("name", "way"), [(BROAD, 1.0), (THIN, -1.0)])
def test_fingers_get_thicker_where_they_get_broader_and_thinner_where_narrower(name, way):
    picture = taken(name)
    with_it, without = fitted(picture), fitted(picture, outline=False)
    for k in (2, 3, 4, 5):
        assert 0.2 < way * (thickness(with_it.hand, k) - thickness(without.hand, k)) < 4.0


def test_feature_points_stay_where_they_were_clicked():
    fit = fitted(taken(BROAD))
    assert np.abs(fit.warped.rbf(fit.aligned.source) - fit.target).max() < 1e-9
    off = np.linalg.norm(fit.warped.rbf(fit.edge.source) - fit.edge.target, axis=1)
    assert 1e-6 < off.mean() < 0.3e-3 and off.max() < 2e-3  # held softly


@pytest.mark.parametrize(("camera", "options"), [("pinhole", {}), ("flatbed", {}), ("flatbed", {"mirror": True, "side": "right"})])
def test_points_moved_across_the_line_of_sight_are_seen_to_move(camera, options):
    picture = taken("woman", camera, "palmar", left="mirror" in options)
    fit = fitted(picture, camera, outline=False, **options)
    world = fit.lying(fit.hand.skin_fine.points[::50])
    px = np.random.default_rng(0).normal(size=(len(world), 2)) * 10.0
    moved = fit.beside(world, px)
    np.testing.assert_allclose(fit.seen(moved) - fit.seen(world), px, atol=1e-6)
    np.testing.assert_allclose((moved - world) @ fit.aligned.frame.towards, 0.0, atol=1e-12)


def test_a_mirrored_picture_has_an_outline_too():
    picture = taken("woman", "flatbed", "palmar", left=True)
    fit = fitted(picture, "flatbed", mirror=True, side="right")
    assert fit.edge is not None and fit.side == "right" and true_overlap(fit, picture) > 0.98


def test_a_hand_that_cannot_be_told_from_the_ground_is_shaped_by_the_points_alone_and_that_is_said():
    picture = taken("woman")
    grey = replace(picture, pixels=np.full_like(picture.pixels, 128))
    fit, without = fitted(grey), fitted(grey, outline=False)
    assert UNSEEN in fit.warnings and fit.edge is None
    assert (fit.hand.skin_fine.points == without.hand.skin_fine.points).all()


def test_the_outline_of_something_else_is_not_followed_and_that_is_said():
    picture = taken("woman", ground="dark")
    rows, columns = picture.outline.shape
    y, x = np.mgrid[0:rows, 0:columns]
    disc = np.hypot(x - columns / 2, y - rows / 2) < 0.47 * min(rows, columns)
    pixels = np.where((disc | picture.outline)[:, :, None], np.uint8([200, 150, 120]), np.uint8([20, 24, 28]))
    fit = fitted(replace(picture, pixels=pixels))
    assert OTHER in fit.warnings and fit.edge is None


def test_a_soft_shadow_and_a_ring_do_no_harm():
    plain = taken("woman", ground="light")
    px = photograph.PX_PER_MM
    dark = gaussian_filter(shift(plain.outline.astype(float), (3.0 * px, 2.0 * px), order=0), 1.5 * px)
    shadow = replace(plain, pixels=(plain.pixels * (1.0 - 0.5 * dark * ~plain.outline)[..., None]).astype(np.uint8))
    knuckle, middle = np.array(plain.marks["web_ring_little"]), np.array(plain.marks["pip_ring"])
    along = (middle - knuckle) / np.linalg.norm(middle - knuckle)
    y, x = np.mgrid[0 : plain.outline.shape[0], 0 : plain.outline.shape[1]]
    here = np.stack([x, y], axis=2) - (0.35 * knuckle + 0.65 * middle)
    band = (np.abs(here @ along) < 1.5 * px) & (np.linalg.norm(here, axis=2) < 14 * px) & plain.outline
    ring = replace(plain, pixels=np.where(band[..., None], np.uint8([225, 228, 235]), plain.pixels))
    alone = error(fitted(plain, outline=False), "woman")
    for picture in (shadow, ring):
        assert error(fitted(picture), "woman") < alone


def test_fingers_that_all_but_touch_are_told_apart():
    straight, reference = people.everyone()["woman_slender"], people.hand()
    skin, _ = moved(straight, reference, {"mcp2.deviation": -9.0, "mcp4.deviation": 7.0, "mcp5.deviation": 14.0})
    nearest = cKDTree(straight.skin)
    places = {}
    for view, marks in straight.marks.items():
        rows = nearest.query(np.array(list(marks.values())))[1]
        places[view] = {name: place + skin[row] - straight.skin[row] for row, (name, place) in zip(rows, marks.items(), strict=True)}
    picture = photograph.photograph(replace(straight, skin=skin, marks=places), view="palmar")
    with_it, without = fitted(picture), fitted(picture, outline=False)
    assert true_overlap(without, picture) < 0.95 < 0.97 < true_overlap(with_it, picture)
    off = [cKDTree(skin).query(people.rigidly(fit.hand.skin_fine.points, skin))[0].mean() for fit in (with_it, without)]
    assert 0.5 < off[0] / off[1] < 0.98


def test_as_printed_and_without_pixels_the_outline_is_not_used():
    picture = taken("woman")
    assert fitted(picture, rule="printed").edge is None
    assert fitted(replace(picture, pixels=picture.pixels.shape[1::-1])).edge is None


def test_chosen_points_are_apart_and_none_is_forgotten():
    rng = np.random.default_rng(2)
    points, others = 0.05 * rng.random((400, 3)), 0.05 * rng.random((10, 3))
    chosen = points[_apart(points, others, GAP)]
    far = np.linalg.norm(chosen[:, None] - np.concatenate([chosen, others]), axis=2)
    np.fill_diagonal(far, np.inf)
    assert far.min() >= GAP
    assert np.linalg.norm(points[:, None] - np.concatenate([chosen, others]), axis=2).min(axis=1).max() < GAP
    assert len(_apart(others, others, GAP)) == 0


def test_smoothing_is_that_of_scipy():
    rng = np.random.default_rng(4)
    source = rng.normal(size=(30, 3)) * 0.05
    target, query = source + 0.003 * rng.normal(size=source.shape), 0.1 * rng.normal(size=(200, 3))
    smoothing = rng.uniform(0.0, 0.01, 30)
    expected = RBFInterpolator(source, target, kernel="linear", degree=1, smoothing=smoothing)(query)
    np.testing.assert_allclose(rbf.fitted(source, target, smoothing)(query), expected, atol=1e-9)


def test_smoothing_is_how_far_a_point_gives_way_to_its_weight():
    rng = np.random.default_rng(1)
    source = rng.normal(size=(20, 3)) * 0.05
    target = source + 0.003 * rng.normal(size=source.shape)
    smoothing = np.repeat([0.0, 0.002, 0.05], [6, 7, 7])
    soft = rbf.fitted(source, target, smoothing)
    np.testing.assert_allclose(soft(source) - target, smoothing[:, None] * soft.weight, atol=1e-12)
    assert (np.linalg.norm(rbf.fitted(source, target, 0.05).weight) < 0.7 * np.linalg.norm(rbf.fitted(source, target).weight)).all()
    for bad in (-1.0, np.full(20, np.nan)):
        with pytest.raises(ValueError, match="smoothing"):
            rbf.fitted(source, target, bad)
