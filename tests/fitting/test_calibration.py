"""Pictures with a known scale: rulers, coins and cards drawn with sub-pixel edges, and noise."""

import numpy as np
import pytest

from handlab.fitting.calibration import CARD_MM, COINS, Scale, as_scale, card, coin, ruler

SIZE = (600, 800)
FINE = 4


def drawn(inside, colour, ground=(40, 90, 60), seed=0):
    """A picture whose pixels are means of 16 samples of the shape ``inside(x, y)``."""
    y, x = (np.mgrid[0 : SIZE[0] * FINE, 0 : SIZE[1] * FINE] + 0.5) / FINE
    picture = np.tile(np.float64(ground), (*x.shape, 1))
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


@pytest.mark.parametrize("radius", [25.3, 60.7, 150.0])
@pytest.mark.parametrize("ring", [False, True])
@pytest.mark.parametrize("off", [0.0, 0.35])
def test_one_click_on_a_coin_gives_the_scale_within_one_percent(radius, ring, off):
    centre = np.array([401.3, 297.8])
    picture = drawn(disc(centre, radius, ring), (190, 150, 80))
    found = coin(picture, centre + off * radius * np.array([0.6, -0.8]), 25.75)
    assert found.mm_per_px == pytest.approx(25.75 / (2 * radius), rel=0.005)
    assert found.uncertainty < 0.01
    assert coin(picture, centre, "2 euro").mm_per_px == pytest.approx(found.mm_per_px, rel=2e-3)


@pytest.mark.parametrize("degrees", [0, 17, 60, 88, 140])
def test_one_click_on_a_card_gives_the_scale_within_one_percent(degrees):
    angle, centre, long = np.radians(degrees), (402.0, 299.0), 250.0
    short = long * CARD_MM[1] / CARD_MM[0]

    def inside(x, y, colour):
        u = (x - centre[0]) * np.cos(angle) + (y - centre[1]) * np.sin(angle)
        v = (y - centre[1]) * np.cos(angle) - (x - centre[0]) * np.sin(angle)
        return [((np.abs(u) < long / 2) & (np.abs(v) < short / 2), colour), ((np.abs(u) < 40) & (np.abs(v - 45) < 12), (30, 60, 190))]

    found = card(drawn(inside, (205, 205, 220)), (395.0, 290.0))
    assert found.mm_per_px == pytest.approx(CARD_MM[0] / long, rel=0.01)


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
