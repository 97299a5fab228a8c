"""One click on a coin gives the scale: pictures whose scale is known, computed without ``handlab``, and two real ones.

Seeds up to 29 and 100 to 229 were looked at while the way to find a rim was chosen; those used here only once, for one of its choices.
"""

import os
from functools import cache
from pathlib import Path

import minted
import numpy as np
import pytest

from handlab.fitting.calibration import Scale, coin, confirmed
from handlab.fitting.fit import fit_points
from handlab.fitting.mistakes import FitQuestion
from handlab.fitting.pictures import load_picture
from handlab.fitting.plausible import UNCLEAR
from handlab.fitting.rim import outline

FIRST, EACH = 500, 5
PHOTOS = os.environ.get("HANDLAB_PHOTOS")
SCANNED = [
    ("hand_a.jpg", (297, 1270), "2 euro"),
    ("hand_a.jpg", (283, 1640), "1 euro"),
    ("hand_b.jpg", (1155, 181), "2 euro"),
    ("hand_b.jpg", (878, 175), "1 euro"),
]


@cache
def measured(ground):
    """Error of the scale on the table and what is said of it, for pictures nobody looked at."""
    rows = []
    for seed in range(FIRST, FIRST + EACH):
        rng = np.random.default_rng([seed, len(ground)])
        metal, shot = minted.any_coin(rng), minted.any_shot(rng, ground)
        picture, middle = minted.photograph(metal, shot, rng)
        click = middle + 0.1 * metal.diameter * shot.px_per_mm * rng.standard_normal(2)
        found = confirmed(coin(picture, click, metal.diameter), picture)
        rows.append((found.mm_per_px * shot.px_per_mm - 1.0, found.uncertainty))
    return np.array(rows)


@pytest.mark.parametrize("ground", minted.GROUNDS)
def test_the_scale_by_a_coin_with_a_rounded_rim_and_shadows_is_right_to_less_than_one_percent_on_any_ground(ground):
    """A camera 35 to 80 cm away, tilted by up to 6 degrees, the coin up to 8 cm beside the middle; sharp or blurred, noise, JPEG."""
    error, told = measured(ground).T
    sure = error[told <= UNCLEAR]
    print(f"{ground}: {100 * np.sqrt(np.mean(sure**2)):.2f} % (worst {100 * np.abs(sure).max():.2f}), {EACH - len(sure)} of {EACH} asked")
    assert 0.0005 < np.sqrt(np.mean(sure**2)) < 0.009
    assert np.abs(sure).max() < 0.02


def test_a_coin_gives_the_scale_within_one_percent_or_the_user_is_asked_but_seldom():
    error, told = np.concatenate([measured(ground) for ground in minted.GROUNDS]).T
    sure = told <= UNCLEAR
    print(f"{np.mean(sure):.2f} sure, {np.mean(np.abs(error[sure]) < 0.01):.2f} of them within 1 %")
    assert 0.6 < np.mean(sure) < 1.0
    assert np.mean(np.abs(error[sure]) < 0.01) > 0.85
    assert 0.3 < np.sqrt(np.mean((error[sure] / told[sure]) ** 2)) < 1.2


def test_a_shadow_is_not_taken_for_a_coin_of_another_colour():
    """Gold on white paper, one low lamp: the outline of the shadow is 1.5 mm wider."""
    shot = minted.Shot(ground="light", lamps=((0.5, 0.6, 1.5),), off=(0.0, 0.0), texture=0.0)
    picture, middle = minted.photograph(minted.Coin(), shot, np.random.default_rng(0))
    found = coin(picture, middle, 23.25)
    assert "by colour" in found.how
    assert found.mm_per_px * shot.px_per_mm == pytest.approx(1.0 - 1.8 / 600.0, abs=0.006)


def test_a_coin_that_looks_like_its_shadow_is_asked_about():
    shot = minted.Shot(ground="light", lamps=((0.5, 0.6, 1.5),), texture=0.2, blur=1.2)
    picture, middle = minted.photograph(minted.Coin(metal="silver", dull=0.3), shot, np.random.default_rng(1))
    found = coin(picture, middle, 23.25)
    assert "doubtful" in found.how and found.uncertainty > 0.02
    clicks = {"tip_middle": (100, 100), "wrist_radial": (90, 900), "wrist_ulnar": (300, 900), "tip_thumb": (50, 500)}
    with pytest.raises(FitQuestion, match="ruler") as asked:
        fit_points(None, clicks, found, view="palmar")
    assert asked.value.choices == ({"sure": True},) and set(asked.value.landmarks) == set(clicks)


def test_metal_on_a_dark_ground_looks_smaller_by_the_ring_that_mirrors_the_table():
    """Bright metal in an evenly lit room: the larger the rounding of the edge, the smaller the coin looks."""
    radius = {}
    for rounding in (0.05, 0.4):
        shot = minted.Shot(off=(0.0, 0.0), distance=5000.0, px_per_mm=8.0, noise=0.002, texture=0.0, lamps=((0.0, 1.5, 0.05),))
        picture, middle = minted.photograph(minted.Coin(round=rounding, dull=0.1), shot, np.random.default_rng(2))
        found = outline(picture, middle, 94.0)
        assert found.seen == "by light"
        radius[rounding] = found.radius / shot.px_per_mm
    assert radius[0.05] == pytest.approx(23.25 / 2, abs=0.03)
    assert 0.5 * 0.35 * (1 - np.sqrt(0.5)) < radius[0.05] - radius[0.4] < 1.5 * 0.35 * (1 - np.sqrt(0.5))


def test_a_coin_lies_nearer_to_a_camera_than_the_table():
    seen = Scale(0.1, "coin, 23.25 mm on 232 px", 0.005, 1.8)
    assert confirmed(seen, None, 360.0).mm_per_px == pytest.approx(0.1 * (1 + 1.8 / 360))
    assert confirmed(seen, None).mm_per_px == pytest.approx(0.1 * (1 + 1.8 / 600))
    assert confirmed(seen, None, None).mm_per_px == 0.1  # a scanner
    assert confirmed(Scale(0.1, "ruler, 150 mm on 1500 px"), None, 360.0).mm_per_px == 0.1


@pytest.mark.parametrize(("name", "click", "which"), SCANNED)
def test_coins_in_two_scans_give_their_resolution_within_one_percent_or_little_more_without_being_told_it(name, click, which):
    """200 dots per inch by the file, which is not asked here. The 2 euro are 0.3 % off, the 1 euro 0.9 and 1.3 %."""
    if not PHOTOS or not (Path(PHOTOS) / name).is_file():
        pytest.skip("HANDLAB_PHOTOS names no folder with the two real pictures")
    found = coin(load_picture(Path(PHOTOS) / name), click, which)
    assert "by light" in found.how
    assert found.mm_per_px == pytest.approx(25.4 / 200.0, rel=0.005 if which == "2 euro" else 0.013)
    assert 0.004 < found.uncertainty < UNCLEAR
