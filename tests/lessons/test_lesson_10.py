"""The checks of "From pixels to millimetres to 3D": right answers pass, and every common slip is told for what it is."""

import numpy as np
import pytest

import handlab as hl
from handlab.check import lesson
from handlab.check.verdict import Outcome
from handlab.studies.table_photo import table_photo

RIGHT, WRONG = Outcome.RIGHT, Outcome.WRONG


@pytest.fixture(scope="module")
def child():
    return hl.load_hand("child")


@pytest.fixture(scope="module")
def photo(child):
    return table_photo(child, camera_mm=600)


def said(exercise, *answers):
    return lesson("10").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG, verdict
    return verdict.text


def test_any_number_is_a_guess():
    assert said("guess", 10).outcome is Outcome.NOTED
    assert "one number" in hint("guess", "little")


def place(kind="right"):
    def own(point, d):
        x, y, h = point
        flat = np.array([x, y])
        return {
            "right": flat / (1 - h / d),
            "smaller": flat * (1 - h / d),
            "flat": flat,
            "added": flat + h / (1 - h / d),
            "below": flat / (1 + h / d),
            "three": point,
            "other": 2 * flat,
            "open": ...,
        }[kind]

    return own


def test_where_a_camera_sees_a_point_passes_and_its_slips_are_told():
    assert said("project", place()).outcome is RIGHT
    assert said("project", place("open")).outcome is Outcome.OPEN
    for kind, word in (
        ("smaller", "looks larger"),
        ("flat", "It should"),
        ("added", "not the height"),
        ("below", "not d + h"),
        ("three", "two numbers"),
    ):
        assert word in hint("project", place(kind))
    assert "the package has" in hint("project", place("other"))
    assert "without brackets" in hint("project", np.zeros(2))


def test_the_scale_passes_and_its_slips_are_told():
    assert said("scale", lambda a, b, mm: mm / np.hypot(*(a - b))).outcome is RIGHT
    assert said("scale", lambda a, b, mm: ...).outcome is Outcome.OPEN
    assert "Turn the fraction" in hint("scale", lambda a, b, mm: np.hypot(*(a - b)) / mm)
    assert "root is missing" in hint("scale", lambda a, b, mm: mm / ((a - b) ** 2).sum())
    assert "at an angle" in hint("scale", lambda a, b, mm: mm / abs(b - a)[1])
    assert "one number; this has 2" in hint("scale", lambda a, b, mm: b - a)


def knuckles(photo):
    a, b = (np.array(photo.marks_px[name]) for name in ("mcp_index", "mcp_little"))
    return np.linalg.norm(a - b) * 150 / np.linalg.norm(photo.ruler_px[0] - photo.ruler_px[1])


def truth(photo):
    return np.linalg.norm((photo.marks_mm["mcp_index"] - photo.marks_mm["mcp_little"])[:2])


def test_knuckles_above_the_ruler_come_out_too_long_by_their_height(photo):
    mm, true = knuckles(photo), truth(photo)
    height = np.mean([photo.marks_mm[name][2] for name in ("mcp_index", "mcp_little")])
    assert mm / true == pytest.approx(600 / (600 - height), abs=0.003)
    percent = 100 * (mm / true - 1)
    assert said("knuckles", mm, percent).outcome is RIGHT
    assert "that is the truth" in hint("knuckles", true, percent)
    assert "pixels" in hint("knuckles", 3 * mm, percent)
    assert "metres" in hint("knuckles", mm / 1000, percent)
    assert "too much" in hint("knuckles", mm, 100 + percent)
    assert "part of one" in hint("knuckles", mm, percent / 100)
    assert "is not" in hint("knuckles", mm, 2 * percent)


def test_a_ruler_lifted_by_2_cm_makes_everything_a_thirtieth_smaller(child, photo):
    found = 100 * (1 - knuckles(table_photo(child, ruler_mm=20)) / knuckles(photo))
    assert found == pytest.approx(100 / 30, abs=1e-6)
    assert said("lifted", 10 / 3, found).outcome is RIGHT
    assert "looks longer" in hint("lifted", 100 * 20 / 580, found)
    assert "what is lost" in hint("lifted", 100 * 580 / 600, found)
    assert "positive number" in hint("lifted", -10 / 3, found)
    assert "not one with the truth" in hint("lifted", 10 / 3, 100 * (knuckles(table_photo(child, ruler_mm=20)) / truth(photo) - 1))


def test_closer_cameras_lose_more():
    assert said("camera", 20 / 3, 2000).outcome is RIGHT
    assert said("camera", 20 / 3, 2020).outcome is RIGHT
    assert "600 mm" in hint("camera", 10 / 3, 2000)
    assert "in metres" in hint("camera", 20 / 3, 2)
    assert "go on" in hint("camera", 20 / 3, 1200)


def test_the_best_ruler_is_as_high_as_the_knuckles_for_every_camera(child, photo):
    height = np.mean([photo.marks_mm[name][2] for name in ("mcp_index", "mcp_little")])
    for camera in (300, 1500):
        assert knuckles(table_photo(child, camera_mm=camera, ruler_mm=height)) == pytest.approx(truth(photo), rel=0.004)
    assert said("repair", height, "as high as the point").outcome is RIGHT
    assert "too short" in hint("repair", height + 5, "as high as the point")
    assert "too long" in hint("repair", 0, "on the table")
    assert "in metres" in hint("repair", height / 1000, "as high as the point")
    assert "two knuckles" in hint("repair", height, "on the table")


def heights(kind="right"):
    def own(source, ratio):
        away = source - source.mean(axis=0)
        vectors = np.linalg.eigh(away.T @ away)[1]
        h = away @ vectors[:, 0]
        return {
            "right": ratio * h,
            "turned": -ratio * h,
            "no ratio": h,
            "divided": h / ratio,
            "longest": ratio * away @ vectors[:, 2],
            "no mean": ratio * source @ np.linalg.svd(source)[2][2],
            "half mean": ratio * source @ vectors[:, 0],
            "other": h + 1,
            "open": ...,
        }[kind]

    return own


def test_heights_over_the_fitting_plane_pass_and_their_slips_are_told():
    assert said("heights", heights()).outcome is RIGHT
    assert said("heights", heights("turned")).outcome is RIGHT
    assert said("heights", heights("open")).outcome is Outcome.OPEN
    for kind, word in (
        ("no ratio", "ratio is missing"),
        ("divided", "divides"),
        ("longest", "last row"),
        ("no mean", "mean of the points first"),
        ("half mean", "count from the mean, too"),
        ("other", "the package has"),
    ):
        assert word in hint("heights", heights(kind)), kind


def fitted(photo, camera_mm):
    where = {"view": "palmar", "side": "right", "camera_mm": camera_mm, "centre_px": photo.centre_px}
    return hl.fit_photo(photo.pixels, landmarks=photo.marks_px, scale=photo.scale, **where)


def test_a_photograph_knows_nothing_of_thickness(child):
    volumes = [fitted(table_photo(child, camera_mm=20_000, thickness=times), None).hand.skin.volume for times in (1.0, 1.3)]
    ratio = volumes[1] / volumes[0]
    assert ratio == pytest.approx(1.0, abs=0.05)
    assert said("thick", "same", ratio).outcome is RIGHT
    assert "compare" in hint("thick", "thicker", 1.3)
    assert "Look at the ratio" in hint("thick", "thicker", ratio)
    assert "Give the ratio" in hint("thick", "same", 100 * ratio)


def test_two_rulers_look_alike():
    assert said("twins", 150 / (1 - 20 / 600), "no").outcome is RIGHT
    assert "farther away" in hint("twins", 145, "no")
    assert "620" in hint("twins", 155, "no")
    assert "which pixel" in hint("twins", 150 / (1 - 20 / 600), "yes")


def test_without_the_distance_of_the_camera_a_hand_is_too_large(photo):
    known, unknown = fitted(photo, 600), fitted(photo, None)
    length, volume = 100 * (unknown.growth / known.growth - 1), 100 * (unknown.hand.skin.volume / known.hand.skin.volume - 1)
    heights = [place[2] for place in photo.marks_mm.values()]
    assert 100 * min(heights) / 600 < length < 100 * max(heights) / (600 - max(heights))
    assert 2 * length < volume < 4.5 * length
    assert said("known", length, volume).outcome is RIGHT
    assert "that is the volume" in hint("known", volume, volume)
    assert "that is the length" in hint("known", length, length)
    assert said("known", ..., ...).outcome is Outcome.OPEN


def test_clicks_count_least(photo):
    pixels = np.linalg.norm(photo.ruler_px[1] - photo.ruler_px[0])
    rng = np.random.default_rng(5)
    clicks = photo.ruler_px + rng.standard_normal((4000, 2, 2))
    scatter = 100 * np.std(np.linalg.norm(clicks[:, 1] - clicks[:, 0], axis=1)) / pixels
    long = 100 * np.sqrt(2) / pixels
    assert scatter == pytest.approx(long, rel=0.05)
    assert said("doubt", long, long * 7.5, "hand").outcome is RIGHT
    assert "root of 2" in hint("doubt", long / np.sqrt(2), long * 7.5, "hand")
    assert "not 2" in hint("doubt", long, long * 7.5 * np.sqrt(2), "hand")
    assert "beside each other" in hint("doubt", long, long * 7.5, "clicks")
