import numpy as np
import pytest

import handlab as hl
from handlab.show.moments import story
from handlab.show.scene import SKINS, Scene
from handlab.simulation.kinematics import posed_bone
from handlab.simulation.skin import fine_points

SIZE = (240, 300)


@pytest.fixture(scope="module")
def scene(hand):
    with Scene(hand, size=SIZE) as one:
        yield one


@pytest.fixture
def relaxed(scene, hand):
    scene.pose(story(hand).at(0.0))
    scene.set(skin="solid", bones=True, view="palm")
    return scene


def test_a_solid_hand_covers_a_third_of_the_picture_it_fits_into(relaxed, drawn):
    picture = relaxed.picture()
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    assert picture.dtype == np.uint8
    assert 0.2 < drawn(picture).mean() < 0.6


def test_shading_is_not_flat(relaxed, drawn):
    picture = relaxed.picture()
    seen = picture[drawn(picture)].astype(float).mean(axis=1)
    assert np.ptp(np.percentile(seen, [2, 98])) > 50


def test_translucent_skin_shows_the_bones_inside_it(relaxed, drawn):
    relaxed.set(skin="translucent", bones=True)
    with_bones = relaxed.picture().astype(int)
    relaxed.set(bones=False)
    without = relaxed.picture().astype(int)
    relaxed.set(skin="hidden", bones=True)
    bones_alone = drawn(relaxed.picture())
    changed = np.abs(with_bones - without).sum(axis=2) > 30
    assert changed.mean() > 0.05
    assert (changed & ~bones_alone).mean() < 0.01


def test_hidden_skin_without_bones_is_an_empty_picture(relaxed, drawn):
    relaxed.set(skin="hidden", bones=False)
    assert not drawn(relaxed.picture()).any()


def test_a_solid_skin_hides_every_bone(relaxed):
    relaxed.set(skin="solid", bones=True)
    shown = relaxed.picture()
    assert not any(relaxed.plotter.actors[name].visibility for name in relaxed.hand.bones)
    relaxed.set(bones=False)
    assert np.array_equal(shown, relaxed.picture())


def test_translucent_skin_lets_the_background_through_but_keeps_a_dense_outline(relaxed, drawn):
    relaxed.set(skin="hidden", bones=False)
    empty = relaxed.picture().astype(float)
    relaxed.set(skin="solid")
    solid = relaxed.picture()
    inside = drawn(solid)
    relaxed.set(skin="translucent")
    density = np.abs(relaxed.picture() - empty).sum(axis=2)[inside] / np.abs(solid - empty).sum(axis=2)[inside]
    assert 0.15 < np.median(density) < 0.5
    assert np.percentile(density, 98) > 0.6


def test_every_actor_has_a_name_and_no_pose_adds_one(relaxed, grip):
    names = set(relaxed.plotter.actors)
    assert set(relaxed.hand.bones) | {"skin", "skin far side", "skin near side"} == names
    told = story(grip)
    for time in (0.1, 0.3, 0.5):
        relaxed.pose(told.at(time))
        for skin in SKINS:
            relaxed.set(skin=skin)
    assert set(relaxed.plotter.actors) == names


def test_points_are_replaced_in_place_and_are_those_of_the_simulation(relaxed, grip, hand):
    mesh = relaxed.plotter.actors["skin"].mapper.dataset
    before = mesh.points.__array_interface__["data"][0]
    moment = story(grip).at(0.5)
    relaxed.pose(moment)
    assert mesh.points.__array_interface__["data"][0] == before
    assert np.allclose(mesh.points, fine_points(hand, moment.skin), atol=1e-6)
    actor = relaxed.plotter.actors["distal_phalanx_2"]
    matrix = np.asarray(actor.user_matrix)
    moved = hand.bones["distal_phalanx_2"].points @ matrix[:3, :3].T + matrix[:3, 3]
    assert np.allclose(moved, posed_bone(hand, "distal_phalanx_2", moment.angle), atol=1e-6)


def test_normals_have_length_one_and_point_outwards(relaxed, hand):
    mesh = relaxed.plotter.actors["skin"].mapper.dataset
    normals = np.asarray(mesh.point_data["Normals"], dtype=float)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
    points = np.asarray(mesh.points, dtype=float)
    swollen = hand.skin_fine.__class__(**{**hand.skin_fine.__dict__, "points": points + 0.001 * normals})
    plain = hand.skin_fine.__class__(**{**hand.skin_fine.__dict__, "points": points})
    assert swollen.volume > plain.volume


def test_a_left_hand_is_the_mirror_image_of_a_right_hand(hand, drawn):
    pictures = []
    for one in (hand, hl.load_hand(side="left")):
        with Scene(one, size=SIZE) as scene:
            scene.pose(story(one).at(0.0))
            pictures.append(drawn(scene.picture()))
    right, left = pictures[0], pictures[1][:, ::-1]
    assert (right & left).sum() / (right | left).sum() > 0.98


def test_a_film_picture_has_softer_outlines_than_a_live_one(hand, drawn):
    steps = []
    for quality in ("live", "film"):
        with Scene(hand, size=SIZE, quality=quality) as scene:
            scene.pose(story(hand).at(0.0))
            blue = scene.picture()[..., 2].astype(int)
            steps.append((np.abs(np.diff(blue, axis=1)) > 100).sum())
    assert 0.3 * steps[0] < steps[1] < 0.75 * steps[0]


def test_ambient_occlusion_darkens_a_still_only_a_little(hand, drawn):
    means = []
    for quality in ("film", "still"):
        with Scene(hand, size=SIZE, quality=quality) as scene:
            scene.pose(story(hand).at(0.0))
            picture = scene.picture()
            means.append(picture[drawn(picture)].mean())
    assert 0.80 < means[1] / means[0] < 1.0


def test_an_unknown_way_to_draw_skin_is_answered_with_the_known_ones(relaxed):
    with pytest.raises(KeyError, match="translucent"):
        relaxed.set(skin="transparent")
