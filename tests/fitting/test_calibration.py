"""Pictures with a known scale: rulers, coins and cards drawn with sub-pixel edges, and noise."""

import numpy as np
import pytest

from handlab.fitting.calibration import CARD_MM, COINS, Scale, as_scale, card, coin, ruler
from handlab.fitting.coins import find_circle
from handlab.fitting.rim import outline

SIZE = (600, 800)
FINE = 3


def drawn(inside, colour, ground=(40, 90, 60), seed=0):
    """A picture whose pixels are means of 9 samples of the shape ``inside(x, y)``."""
    y, x = (np.mgrid[0 : SIZE[0] * FINE, 0 : SIZE[1] * FINE].astype(np.float32) + 0.5) / FINE
    picture = np.tile(np.float32(ground), (*x.shape, 1))
    for part, paint in inside(x, y, colour):
        picture[part] = paint
    small = picture.reshape(SIZE[0], FINE, SIZE[1], FINE, 3).mean(axis=(1, 3))
    return np.clip(small + 6.0 * np.random.default_rng(seed).normal(size=small.shape), 0, 255).astype(np.uint8)


def disc(centre, radius, ring):
    def inside(x, y, colour):
        far = np.hypot(x - centre[0], y - centre[1])
        return [(far < radius, colour)] + ([(far < 0.7 * radius, (230, 225, 215))] if ring else [])

    return inside


def test_a_ruler_gives_its_distance_over_its_pixels():
    assert ruler((10, 20), (310, 420), 100).mm_per_px == pytest.approx(0.2)
    assert ruler((10, 20), (310, 420), 100).uncertainty == pytest.approx(np.sqrt(2) / 500)


@pytest.mark.parametrize(
    ("radius", "ring", "off", "colour"),
    [
        (25.3, False, 0.35, (190, 150, 80)),
        (60.7, True, 0.0, (40, 40, 200)),
        (60.7, True, 0.35, (190, 150, 80)),
        (110.0, False, 0.0, (40, 40, 200)),
    ],
)
def test_one_click_on_a_disc_gives_its_outline_within_half_a_percent(radius, ring, off, colour):
    centre = np.array([401.3, 297.8])
    picture = drawn(disc(centre, radius, ring), colour)
    found = outline(picture, *find_circle(picture, centre + off * radius * np.array([0.6, -0.8])))
    assert found.radius == pytest.approx(radius, rel=0.003, abs=0.15)
    assert found.centre == pytest.approx(centre, abs=0.1)
    assert found.oval < 0.004


def test_a_coin_has_its_diameter_by_name_or_number_and_a_dark_ring_on_a_dark_ground():
    picture = drawn(disc((401.3, 297.8), 60.7, True), (190, 150, 80), (10, 12, 15))
    named, measured = coin(picture, (410, 290), "2 euro"), coin(picture, (400, 300), 25.75)
    assert named.mm_per_px == pytest.approx(measured.mm_per_px, rel=2e-3)
    assert named.mm_per_px == pytest.approx((25.75 - 2 * 0.3 * (1 - np.sqrt(0.5))) / 121.4, rel=0.005)
    assert named.above_mm > 0 and 0.003 < named.uncertainty < 0.01


@pytest.mark.parametrize(
    ("degrees", "ground", "stripe"),
    [(0, (40, 90, 60), False), (17, (235, 235, 235), True), (88, (12, 12, 15), True), (140, (150, 120, 90), False)],
)
def test_one_click_on_a_card_gives_the_scale_within_one_percent(degrees, ground, stripe):
    """Round corners as ISO/IEC 7810 has them, a narrow shadow, and a stripe and a chip that form a smaller rectangle of the same ratio."""
    angle, centre, px = np.radians(degrees), (402.0, 299.0), 250.0 / CARD_MM[0]

    def inside(x, y, colour):
        u = ((x - centre[0]) * np.cos(angle) + (y - centre[1]) * np.sin(angle)) / px
        v = ((y - centre[1]) * np.cos(angle) - (x - centre[0]) * np.sin(angle)) / px

        def plate(u, v):
            q = np.array([np.abs(u) - CARD_MM[0] / 2, np.abs(v) - CARD_MM[1] / 2]) + 3.18
            return np.hypot(*np.maximum(q, 0)) + np.minimum(q.max(axis=0), 0) < 3.18

        marks = [((np.abs(v - 16) < 5) & plate(u, v), (40, 40, 45)), ((np.abs(u + 25) < 6) & (np.abs(v) < 5), (200, 170, 90))]
        shadow = tuple(0.6 * np.array(ground))
        return [(plate(u - 0.5, v - 0.4), shadow), (plate(u, v), colour), *(marks if stripe else [])]

    found = card(drawn(inside, (205, 205, 220), ground), (395.0, 290.0))
    assert found.mm_per_px == pytest.approx(1 / px, rel=0.01)
    assert found.above_mm == 0.76


def test_a_square_is_no_card_and_an_empty_ground_no_coin():
    square = drawn(lambda x, y, colour: [((np.abs(x - 400) < 80) & (np.abs(y - 300) < 80), colour)], (220, 220, 220))
    with pytest.raises(ValueError, match=r"no card|not a card"):
        card(square, (400, 300))
    with pytest.raises(ValueError, match=r"no coin|nothing stands out"):
        coin(drawn(lambda x, y, colour: [], (0, 0, 0)), (400, 300), 25.75)


@pytest.mark.parametrize(
    ("scale", "match"),
    [
        (0.0, "positive"),
        (float("nan"), "positive"),
        ("large", "scale is"),
        ({"ruler": [(1, 1)], "mm": 10}, "two"),
        ({"ruler": [(1, 1), (1, 2)], "mm": 10}, "pixels apart"),
        ({"ruler": [(1, 1), (100, 2)]}, "positive number of millimetres"),
        ({"ruler": [(1, 1), (100, 2)], "mm": -3}, "positive number of millimetres"),
        ({"coin": (1, 1), "mm": 20}, "picture itself"),
        ({"stick": (1, 1)}, "scale is"),
    ],
)
def test_what_is_no_scale_is_told(scale, match):
    with pytest.raises(ValueError, match=match):
        as_scale(scale)


def test_scales_are_taken_in_every_form():
    assert as_scale(0.25) == Scale(0.25, "given")
    assert as_scale(Scale(0.3, "x")).mm_per_px == 0.3
    assert as_scale({"ruler": [(0, 0), (0, 400)], "mm": 100}).mm_per_px == 0.25
    assert COINS["1 euro"] == 23.25
    with pytest.raises(KeyError, match="2 euro"):
        coin(np.zeros((100, 100, 3), np.uint8), (50, 50), "2 euros")
