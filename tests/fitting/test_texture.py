"""The photograph on the skin."""

import numpy as np
import people
import pytest
from photograph import photograph

import handlab as hl
from handlab.anatomy.store import save_hand
from handlab.fitting.outline import hand_mask
from handlab.fitting.raster import pixels
from handlab.fitting.texture import project_texture
from handlab.show.complexion import complexion

SIZE = 512


@pytest.fixture(scope="module")
def seen():
    """The reference hand's palm on a flatbed, with stripes drawn across the picture."""
    picture = photograph(people.reference_person(), camera="flatbed", ground="dark")
    striped = picture.pixels.copy()
    striped[(np.arange(len(striped)) // 16) % 2 == 0] //= 2
    return picture, striped


@pytest.fixture(scope="module")
def texture(seen):
    picture, striped = seen
    hand = people.hand()
    mask = hand_mask(picture.pixels, np.array(list(picture.marks.values())))
    return project_texture(hand.skin_fine, picture.skin, hand.skin_fine.points[:, 1], striped, hand=mask, size=SIZE)


def test_no_texel_belongs_to_two_places_of_the_skin():
    fine = people.hand().skin_fine
    row, column, _, share = pixels(fine.texture * 2048, fine.faces, (2048, 2048))
    inside = share.min(axis=1) > 1e-6
    assert np.unique(row[inside] * 2048 + column[inside], return_counts=True)[1].max() == 1


def test_seen_texels_have_the_colour_of_their_pixel(seen, texture):
    picture, striped = seen
    fine = people.hand().skin_fine
    row, column, triangle, share = pixels(fine.texture * SIZE, fine.faces, (SIZE, SIZE))
    place = (share[:, :, None] * picture.skin[fine.faces[triangle]]).sum(axis=1)
    sure = texture.seen[row, column] > 0.999
    there = striped[place[sure, 1].astype(int), place[sure, 0].astype(int)].astype(float)
    off = np.abs(texture.pixels[row[sure], column[sure]] - there).mean(axis=1)
    assert sure.sum() > 3000 and np.median(off) < 6.0


def test_a_palm_shows_its_own_half_of_the_skin_and_nothing_of_the_back(texture):
    fine = people.hand().skin_fine
    row, column, triangle, _ = pixels(fine.texture * SIZE, fine.faces, (SIZE, SIZE))
    a, b, c = (fine.points[fine.faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    trust = texture.seen[row, column]
    assert trust[normal[triangle, 1] < 0.1].max() == 0.0
    assert trust[normal[triangle, 1] > 0.8].mean() > 0.8
    assert 0.25 < texture.share_seen < 0.5


def test_unseen_skin_is_filled_with_skin_never_with_background(seen, texture):
    """The ground is nearly black: skin that took its colour from it would be dark."""
    unseen = texture.covered & (texture.seen == 0)
    colour = texture.pixels[unseen].astype(float)
    known = texture.pixels[texture.seen > 0.9].astype(float)
    assert np.abs(colour.mean(axis=0) - known.mean(axis=0)).max() < 25.0
    assert colour.mean(axis=1).min() > 40.0
    assert 0.5 < colour.std() / known.std() < 1.5 or colour.std() < known.std()


def test_a_hidden_surface_takes_nothing_from_what_covers_it():
    """Two square sheets above one another facing the camera: only the upper one is painted."""
    from handlab.anatomy.meshes import FineSkin, frozen

    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    points = np.vstack([np.c_[square * 0.1, np.zeros(4)], np.c_[square * 0.1, np.full(4, 0.05)]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    flat = np.vstack([square * 0.4 + 0.02, square * 0.4 + 0.52])
    skin = FineSkin(
        frozen(points),
        frozen(faces, np.int64),
        frozen(flat[faces]),
        frozen(np.zeros(8), np.int64),
        frozen(np.zeros((8, 3))),
        frozen(np.zeros(8)),
    )
    place = np.c_[10 + 80 * np.vstack([square, square])[:, 0], 90 - 80 * np.vstack([square, square])[:, 1]]
    picture = np.full((100, 100, 3), 200, np.uint8)
    found = project_texture(skin, place, points[:, 2], picture, size=64)
    assert found.seen[33:58, 33:58].min() == 1.0 and found.seen[2:26, 2:26].max() == 0.0


def test_a_picture_that_shows_nothing_of_the_hand_is_refused():
    hand = people.hand()
    with pytest.raises(ValueError, match="shows no part"):
        project_texture(
            hand.skin_fine,
            np.full((len(hand.skin_fine.points), 2), -50.0),
            hand.skin_fine.points[:, 1],
            np.zeros((80, 80, 3), np.uint8),
            size=64,
        )
    with pytest.raises(ValueError, match="points of skin"):
        project_texture(hand.skin_fine, np.zeros((3, 2)), np.zeros(3), np.zeros((80, 80, 3), np.uint8), size=64)


def test_the_saved_hand_gives_mesh_places_and_picture_back(texture, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    hand = people.hand().with_(picture=texture.pixels)
    fine = hand.skin_fine
    scene = trimesh.load(hl.save(hl.pose(hand, {}), tmp_path / "hand.glb", hand=hand), process=False)
    mesh = next(one for name, one in scene.geometry.items() if "skin" in name)
    assert len(mesh.faces) == len(fine.faces)
    np.testing.assert_allclose(mesh.triangles, fine.points[fine.faces], atol=1e-6)
    uv = mesh.visual.uv[mesh.faces]
    np.testing.assert_allclose(np.stack([uv[..., 0], 1 - uv[..., 1]], axis=-1), fine.texture, atol=1e-5)  # trimesh counts v upwards
    np.testing.assert_array_equal(np.asarray(mesh.visual.material.baseColorTexture.convert("RGB")), texture.pixels)


def test_a_hand_keeps_its_picture_in_its_files_mirrored_or_not(texture, tmp_path):
    hand = people.hand().with_(picture=texture.pixels)
    place = save_hand(hand, tmp_path / "me")
    for side in ("right", "left"):
        again = hl.load_hand(place, side=side)
        np.testing.assert_array_equal(again.picture, texture.pixels)
        np.testing.assert_array_equal(complexion(again), complexion(hand))
    assert np.abs(complexion(hand).astype(int) - complexion(people.hand()).astype(int)).mean() > 5.0
    (place / "skin.png").write_bytes(b"no picture")
    with pytest.raises(ValueError, match=r"skin\.png is no picture"):
        hl.load_hand(place)
