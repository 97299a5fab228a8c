"""A computed photograph: what it shows is where similar triangles put it, and the picture shows what it says."""

import numpy as np
import pytest

import handlab as hl
from handlab.fitting.landmarks import NAMES
from handlab.studies.table_photo import RULER_MM, seen, table_photo


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="module")
def photo(hand):
    return table_photo(hand, camera_mm=500, ruler_mm=12)


def test_a_ray_goes_straight_from_the_camera_through_the_point_to_the_table():
    rng = np.random.default_rng(4)
    points = rng.uniform([-80, -80, 0], [80, 80, 60], size=(20, 3))
    camera = np.array([0.0, 0.0, 420.0])
    for point, place in zip(points, seen(points, 420.0), strict=True):
        ray, way = np.array([*place, 0.0]) - camera, point - camera
        assert np.linalg.norm(np.cross(ray, way)) < 1e-9 * np.linalg.norm(ray) * np.linalg.norm(way) * 10
    with pytest.raises(ValueError, match="below the camera"):
        seen([0.0, 0.0, 420.0], 420.0)


def test_clicks_on_the_ruler_give_the_scale_of_its_own_height(photo):
    assert np.linalg.norm(np.diff(photo.ruler_px, axis=0)) == pytest.approx(3.0 * RULER_MM * 500 / 488)
    assert photo.scale["mm"] == RULER_MM


def test_every_ten_millimetres_of_the_ruler_have_their_number(photo):
    """As many separate shapes of ink left of the lines as there are digits, each number level with its line."""
    from scipy.ndimage import find_objects, label

    (edge, bottom), top = photo.ruler_px[0], photo.ruler_px[1, 1]
    per_mm = (bottom - top) / RULER_MM
    dark = photo.pixels.astype(int).sum(axis=2) < 380
    left, right = (int(edge - mm * per_mm) for mm in (20.5, 8.7))
    spots, _ = label(dark[int(top - 4 * per_mm) + 1 : int(bottom + 4 * per_mm), left:right], np.ones((3, 3)))
    rows = [(spot[0].start + spot[0].stop) / 2 + int(top - 4 * per_mm) + 1 for spot in find_objects(spots)]
    written = [f"{tick}" for tick in range(0, RULER_MM + 1, 10)]
    assert len(rows) == sum(len(number) for number in written) == 1 + 9 * 2 + 6 * 3
    for tick, number in zip(range(0, RULER_MM + 1, 10), written, strict=True):
        assert sum(abs(row - (bottom - tick * per_mm)) < 1.0 * per_mm for row in rows) == len(number)


def test_every_mark_is_seen_above_its_true_place_towards_the_rim(photo):
    for name in NAMES:
        x, y, height = photo.marks_mm[name]
        u, v = (np.array(photo.marks_px[name]) - photo.centre_px) / [3.0, -3.0]
        assert np.allclose([u, v], np.array([x, y]) * 500 / (500 - height), atol=1e-9)
        assert height >= 0.0


def test_the_hand_lies_on_the_table_and_is_where_the_skin_is(hand, photo):
    skin = photo.pixels.astype(int)
    flesh = (skin[..., 0] - skin[..., 2] > 15) & (np.arange(skin.shape[1]) > photo.ruler_px[0, 0] + 3)
    for name in ("tip_index", "tip_thumb", "mcp_middle", "web_middle_ring"):
        u, v = (round(value) for value in photo.marks_px[name])
        assert flesh[v - 4 : v + 5, u - 4 : u + 5].any(), name
    # fingers upwards, the thumb of a right palm to the right
    assert photo.marks_px["tip_middle"][1] < photo.marks_px["wrist_radial"][1]
    assert photo.marks_px["tip_thumb"][0] > photo.marks_px["tip_little"][0]
    lie, z = 1e3 * hand.skin_fine.points[:, 1], 1e3 * hand.skin_fine.points[:, 2]
    shown = (z - (z.min() + z.max()) / 2) * 500 / (500 - (lie - lie.min()))
    assert np.ptp(np.nonzero(flesh)[1]) / 3.0 == pytest.approx(np.ptp(shown), abs=1.5)


def test_the_back_and_the_left_hand_are_mirror_images(hand):
    back, left = table_photo(hand, view="dorsal"), table_photo(hl.load_hand(side="left"))
    for photo in (back, left):
        assert photo.marks_px["tip_thumb"][0] < photo.marks_px["tip_little"][0]
        lit = photo.pixels[photo.pixels[..., 0].astype(int) - photo.pixels[..., 2] > 15]
        assert lit[:, 0].mean() > 120  # faces look at the light, not away from it


def test_thickness_changes_heights_alone(hand):
    thin, thick = (table_photo(hand, thickness=times) for times in (1.0, 1.5))
    for name in NAMES:
        x, y, height = thin.marks_mm[name]
        assert np.allclose(thick.marks_mm[name], [x, y, 1.5 * height])


def test_a_ruler_near_the_camera_is_refused(hand):
    with pytest.raises(ValueError, match="below half"):
        table_photo(hand, camera_mm=300, ruler_mm=160)
