"""Outlines: pixels that a mesh covers, pixels that show a hand, and how well they agree."""

import numpy as np
import people
import pytest
from photograph import GROUNDS, photograph

from handlab.fitting.outline import contour, distal_of, hand_mask, overlap, silhouette
from handlab.fitting.raster import foremost, pixels


def disc(radius, middle, count=200):
    """A fan of triangles."""
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    points = np.vstack([middle, middle + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)])
    ring = np.arange(1, count + 1)
    return points, np.stack([np.zeros(count, int), ring, np.roll(ring, -1)], axis=1)


def test_the_silhouette_of_a_disc_has_its_area():
    points, faces = disc(60.0, np.array([80.3, 71.7]))
    assert silhouette(points, faces, (150, 160)).sum() == pytest.approx(np.pi * 60**2, rel=0.003)


def test_two_ways_to_cut_triangles_into_pixels_agree_on_a_hand():
    person = people.everyone()["woman"]
    picture = photograph(person)
    assert overlap(silhouette(picture.skin, person.faces, picture.outline.shape), picture.outline) > 0.9999


def test_parts_outside_the_picture_and_points_at_infinity_are_cut_off():
    points, faces = disc(60.0, np.array([0.0, 0.0]))
    mask = silhouette(points, faces, (40, 50))
    assert mask.shape == (40, 50) and mask[:30, :40].all() and not mask[39, 49]
    assert not silhouette(points + 1000, faces, (40, 50)).any()
    points[3] = np.nan
    assert silhouette(points, faces, (40, 50)).sum() > 1500


def test_the_nearer_triangle_lies_in_front():
    points = np.array([[0, 0], [10, 0], [0, 10], [0, 0], [10, 0], [0, 10.0]])
    front, level = foremost(points, np.array([1, 1, 1, 2, 2, 2.0]), np.array([[0, 1, 2], [3, 4, 5]]), (12, 12))
    assert front[2, 2] == 1 and level[2, 2] == 2.0 and front[11, 11] == -1


def test_barycentric_coordinates_give_a_pixels_middle_back():
    points, faces = disc(8.0, np.array([10.2, 9.9]), 7)
    row, column, triangle, share = pixels(points, faces, (20, 20))
    np.testing.assert_allclose((share[:, :, None] * points[faces[triangle]]).sum(axis=1), np.stack([column, row], axis=1) + 0.5, atol=1e-9)


def test_overlap_is_0_for_nothing_1_for_the_same_and_between_for_a_shift():
    a = np.zeros((10, 10), bool)
    assert overlap(a, a) == 0.0
    a[2:6, 2:6] = True
    assert overlap(a, a) == 1.0
    assert overlap(a, np.roll(a, 2, axis=1)) == pytest.approx(8 / 24)
    where = np.zeros((10, 10), bool)
    where[:, :4] = True
    assert overlap(a, np.roll(a, 2, axis=1), where) == 0.0
    with pytest.raises(ValueError, match="outlines of one picture"):
        overlap(a, a[:5])


def test_a_line_through_the_wrist_parts_the_hand_from_the_forearm():
    half = distal_of(np.array([[0.0, 10.0], [20.0, 10.0]]), np.array([10.0, 0.0]), (20, 20))
    assert half[:10].all() and not half[10:].any()
    with pytest.raises(ValueError, match="on one line"):
        distal_of(np.array([[0.0, 10.0], [20.0, 10.0]]), np.array([10.0, 10.0]), (20, 20))


def test_the_contour_runs_once_round_the_largest_piece():
    points, faces = disc(30.0, np.array([40.0, 40.0]))
    mask = silhouette(points, faces, (80, 80))
    mask[70:73, 2:5] = True  # a speck
    line = contour(mask)
    x, y = line.T
    area = abs(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    assert area == mask.sum() - 9
    assert np.abs(np.diff(np.vstack([line, line[:1]]), axis=0)).sum(axis=1).max() == 1.0
    assert contour(np.zeros((5, 5), bool)).shape == (0, 2)


@pytest.mark.parametrize("ground", sorted(GROUNDS))
@pytest.mark.parametrize("view", ["palmar", "dorsal"])
def test_the_hand_is_found_on_dark_light_and_coloured_ground(ground, view):
    picture = photograph(people.everyone()["man"], ground=ground, view=view, turn=0.3)
    found = hand_mask(picture.pixels, np.array(list(picture.marks.values())))
    assert overlap(found, picture.outline) > 0.97


def test_a_hand_on_its_own_colour_and_points_outside_are_refused():
    picture = photograph(people.everyone()["woman"])
    marks = np.array(list(picture.marks.values()))
    flat = np.random.default_rng(1).integers(118, 122, picture.pixels.shape, dtype=np.uint8)
    with pytest.raises(ValueError, match="same colour"):
        hand_mask(flat, marks)
    with pytest.raises(ValueError, match="lie in the picture"):
        hand_mask(picture.pixels, marks + 5000)
