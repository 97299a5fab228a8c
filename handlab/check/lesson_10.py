"""Checks of lesson 10, "From pixels to millimetres to 3D". What is right is computed on a fresh photograph, never written down here."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Array
from handlab.check.answers import number, one, reference, said
from handlab.check.lesson import Exercises
from handlab.check.own_lines import compare, values
from handlab.check.verdict import Wrong
from handlab.fitting.calibration import as_scale
from handlab.fitting.fit import fit_photo
from handlab.fitting.landmarks import source_points
from handlab.fitting.result import Fit
from handlab.studies.table_photo import RULER_MM, TablePhoto, seen, table_photo

EXERCISES = Exercises("10")

CAMERA, BOOK = 600.0, 20.0  # mm
FAR = 20_000.0  # mm
NEAR, LOST = 300.0, 0.01
THICK = 1.3
EXACT = 0.005  # part by which a computed answer may be off
TRIED_MM = 1.0
KNUCKLES = ("mcp_index", "mcp_little")
RULES = ("on the table", "as high as the point", "as high as possible")


@cache
def photo(ruler_mm: float = 0.0, camera_mm: float = CAMERA, thickness: float = 1.0) -> TablePhoto:
    """The child's hand."""
    return table_photo(load_hand("child"), camera_mm=camera_mm, ruler_mm=ruler_mm, thickness=thickness)


@cache
def fitted(picture: TablePhoto, camera_mm: float | None) -> Fit:
    """The hand from a photograph."""
    options: dict[str, Any] = {"view": "palmar", "side": "right", "camera_mm": camera_mm, "centre_px": picture.centre_px}
    return fit_photo(picture.pixels, landmarks=picture.marks_px, scale=picture.scale, **options)


def apart_px(picture: TablePhoto) -> float:
    """Knuckles in the picture."""
    a, b = (np.array(picture.marks_px[name]) for name in KNUCKLES)
    return float(np.linalg.norm(b - a))


def apart_mm(picture: TablePhoto) -> float:
    """The same in millimetres by the ruler."""
    return apart_px(picture) * as_scale(picture.scale).mm_per_px


def true_mm() -> float:
    """The truth, from straight above."""
    a, b = (photo().marks_mm[name] for name in KNUCKLES)
    return float(np.linalg.norm((b - a)[:2]))


def percent(right: float, others: dict[str, float], answer: Any, what: str, part: float = EXACT) -> None:
    """``said`` for percentages."""
    slips = {
        "this is a part of one. Give percent.": right / 100.0,
        "the sign is turned: say by how many percent, as a positive number.": -right,
    }
    said(right, {**slips, **others}, answer, what, "percent", part)


@EXERCISES.register("guess", guess=True)
def guess(answer: Any) -> str:
    """Any number of percent."""
    number(answer, "The guess", "percent")
    return "You will predict it below, and measure it."


@EXERCISES.register("project")
def project(own: Callable[..., Any]) -> str:
    """A function (point, camera_mm) that returns the place (2,) where it is seen."""
    for x, y, h, d in ((100.0, -40.0, 20.0, 600.0), (-30.0, 80.0, 45.0, 350.0), (70.0, 10.0, 0.0, 500.0)):
        point, right = np.array([x, y, h]), seen([x, y, h], d)
        slips = {
            "That makes high points smaller. What is nearer to the camera looks larger.": point[:2] * (d - h) / d,
            "The height makes no difference there. It should.": point[:2],
            "Multiply the place, not the height: d/(d-h) times x and y.": point[:2] + h * d / (d - h),
            "A point at height h is d - h below the camera, not d + h.": point[:2] * d / (d + h),
        }
        theirs = values(own, point.copy(), d)
        if theirs.shape == (3,):
            raise Wrong("Hand back two numbers, x and y on the table; this has three.")
        compare(theirs, right, slips if h else {}, "The place", "mm")
    return "Your lines and the package agree to nine digits."


@EXERCISES.register("scale")
def scale(own: Callable[..., Any]) -> str:
    """A function (first, second, millimetres) that returns millimetres per pixel."""
    for first, second, mm in (([100.0, 900.0], [100.0, 400.0], 150.0), ([30.0, 40.0], [330.0, 440.0], 200.0)):
        a, b = np.array(first), np.array(second)
        apart = float(np.linalg.norm(b - a))
        slips = {
            "These are pixels per millimetre. Turn the fraction over.": np.asarray(apart / mm),
            "A ruler may lie at an angle: take the length of the way from click to click.": np.asarray(mm / abs(b - a)[1]),
            "The root is missing: the length is the root of the sum of squares.": np.asarray(mm / apart**2),
        }
        theirs = values(own, a, b, mm)
        if theirs.ndim:
            raise Wrong(f"Hand back one number; this has {theirs.size}. How long is the way from click to click?")
        compare(theirs, np.asarray(mm / apart), slips, "The scale", "mm per pixel")
    return "Your lines and the package agree to nine digits."


@EXERCISES.register("knuckles")
def knuckles(millimetres: Any, too_long: Any) -> str:
    """Distance of the knuckles by the ruler, and by how many percent that is too long."""
    right = apart_mm(photo())
    others = {
        "that is the truth; the photograph says something else.": true_mm(),
        "that is in pixels. Multiply by the millimetres per pixel.": apart_px(photo()),
        "this is in metres. Give millimetres.": right / 1e3,
    }
    said(right, others, millimetres, "The distance", "mm", EXACT)
    error = 100.0 * (right / true_mm() - 1.0)
    space = 100.0 * (right / float(np.linalg.norm(np.subtract(*(photo().marks_mm[name] for name in KNUCKLES)))) - 1.0)
    others = {"that is the length in percent; give how much is too much.": 100.0 + error}
    if abs(space / error - 1.0) > 2 * EXACT:
        others["leave out the heights in the truth: x and y alone."] = space
    percent(error, others, too_long, "The error", 0.01)
    return f"{error:.1f} percent: the knuckles are nearer to the camera than the ruler is."


@EXERCISES.register("lifted")
def lifted(predicted: Any, measured: Any) -> str:
    """Percent by which everything comes out smaller with the ruler on the book, predicted and measured."""
    right = 100.0 * BOOK / CAMERA
    longer = 100.0 * (CAMERA / (CAMERA - BOOK) - 1.0)
    found = 100.0 * (1.0 - apart_mm(photo(BOOK)) / apart_mm(photo()))
    for answer, goal, what in ((predicted, right, "The prediction"), (measured, found, "What is measured")):
        others = {
            "that is by how much the ruler looks longer. Sizes are divided by that.": longer,
            "compare the two photographs, not one with the truth.": 100.0 * (apart_mm(photo(BOOK)) / true_mm() - 1.0),
            "that is what is left. Give what is lost.": 100.0 - goal,
        }
        percent(goal, others, answer, what)
    return f"h/d: {right:.2f} percent predicted, {found:.2f} measured. A book costs a finger's breadth in every thirty."


@EXERCISES.register("camera")
def camera(near: Any, far: Any) -> str:
    """Percent lost with a camera at 300 mm, and the height of a camera for 1 percent."""
    right = 100.0 * BOOK / NEAR
    percent(right, {"that is with the camera at 600 mm.": 100.0 * BOOK / CAMERA}, near, "The loss at 300 mm")
    distance = BOOK / LOST
    others = {
        "this is in metres. Give millimetres.": distance / 1e3,
        "1 percent is 0.01: h/d must be as small as that.": BOOK,
        "twice as far loses half as much; go on from there.": 2.0 * CAMERA,
    }
    said(distance, others, far, "The height of the camera", "mm", 0.011)  # 1 percent of the height: whether of d or of d - h
    return "Half the distance, twice the error. Two metres up, through a longer lens, a book hardly matters."


@EXERCISES.register("repair")
def repair(best: Any, rule: Any) -> str:
    """Height of the ruler at which the knuckles come out right, and the rule."""
    right = float(np.mean([photo().marks_mm[name][2] for name in KNUCKLES]))
    given = number(best, "The height", "millimetres")
    if abs(1e3 * given - right) <= TRIED_MM:
        raise Wrong("This is in metres. Give millimetres.")
    if abs(given - right) > TRIED_MM:
        off = "short" if given > right else "long"
        raise Wrong(f"With a ruler {given:g} mm above the table the knuckles come out too {off}. Try the panel.")
    if one(rule, RULES, "place") != RULES[1]:
        raise Wrong("Compare the height you found with the heights of the two knuckles in photo.marks_mm.")
    return f"{right:.0f} mm, as high as the knuckles, and for every camera: what lies equally high is magnified equally."


@EXERCISES.register("heights")
def heights(own: Callable[..., Any]) -> str:
    """A function (source, ratio) that returns the scaled heights (N,) over the fitting plane."""
    for view, ratio in (("palmar", 0.7), ("dorsal", 1.2)):
        source = source_points(reference(), view) + np.array([0.03, -0.02, 0.05])  # somewhere else: the mean counts
        away = source - source.mean(axis=0)
        directions = np.linalg.svd(away)[2]
        sign_of = directions[2]
        right: Array = ratio * away @ sign_of
        loose = np.linalg.svd(source)[2][2]
        slips = {
            "The ratio is missing.": right / ratio,
            "The ratio divides there. A larger hand has larger heights.": right / ratio**2,
            "That is the direction of the largest spread. The plane's normal is the last row.": ratio * away @ directions[0],
            "Count from the mean of the points first, then look for the directions.": ratio * source @ loose,
            "The heights themselves count from the mean, too.": ratio * source @ sign_of,
        }
        theirs = values(own, source.copy(), ratio)
        if theirs.shape == right.shape and theirs @ right < 0.0:
            theirs = -theirs
        turned = {text: wrong if wrong @ right >= 0.0 else -wrong for text, wrong in slips.items()}
        compare(theirs, right, turned, "A height", "m")
    return "Your lines and the package agree to nine digits, but for the sign, which is free: palm or back."


@EXERCISES.register("thick")
def thick(word: Any, ratio: Any) -> str:
    """Whether the fit sees the thickness, and volume of the thick hand's fit over that of the thin one's."""
    volumes = [fitted(photo(0.0, FAR, times), None).hand.skin.volume for times in (THICK, 1.0)]
    right = volumes[0] / volumes[1]
    others = {
        "that is what the truth would be. Let the package make both hands, and compare.": THICK,
        "the first hand goes below the line, the thick one above.": 1.0 / right if abs(right - 1.0) > 0.02 else np.nan,
        "this is in percent. Give the ratio.": 100.0 * right,
    }
    said(right, others, ratio, "The ratio", "times", EXACT)
    if one(word, ("thicker", "same"), "answer") != "same":
        raise Wrong("Look at the ratio that you measured.")
    return f"{right:.3f} instead of {THICK:g}: the thickness that you see in a fitted hand is that of the reference hand, scaled."


@EXERCISES.register("twins")
def twins(millimetres: Any, apart: Any) -> str:
    """Length of the ruler on the table that looks like the one on the book, and whether they can be told apart."""
    right = RULER_MM * CAMERA / (CAMERA - BOOK)
    others = {
        "that ruler would look shorter. Its twin lies farther away, and must be longer.": RULER_MM * (CAMERA - BOOK) / CAMERA,
        "that is as if the camera were at 620 mm.": RULER_MM * (CAMERA + BOOK) / CAMERA,
    }
    said(right, others, millimetres, "The length", "mm", 0.001)
    if one(apart, ("yes", "no"), "answer") != "no":
        raise Wrong("They look exactly the same: by which pixel would you tell?")
    return "One picture, two worlds. A photograph shows directions; distance is what you know beforehand."


@EXERCISES.register("known")
def known(length: Any, volume: Any) -> str:
    """By how many percent length and volume are too large if the distance of the camera is not known."""
    without, with_it = (fitted(photo(), camera_mm) for camera_mm in (None, CAMERA))
    long = 100.0 * (without.growth / with_it.growth - 1.0)
    much = 100.0 * (without.hand.skin.volume / with_it.hand.skin.volume - 1.0)
    percent(long, {"that is the size itself.": without.growth, "that is the volume.": much}, length, "The length", 0.01)
    percent(much, {"that is the length.": long}, volume, "The volume", 0.01)
    return f"{long:.1f} percent too long makes {much:.0f} percent too much: errors of length count about three times in a volume."


@EXERCISES.register("doubt")
def doubt(long: Any, short: Any, worst: Any) -> str:
    """Uncertainty of the scale with 150 and with 20 mm between the clicks, and the largest error."""
    pixels = float(np.linalg.norm(photo().ruler_px[1] - photo().ruler_px[0]))
    for answer, mm, what in ((long, RULER_MM, "With 150 mm, the uncertainty"), (short, BOOK, "With 20 mm, the uncertainty")):
        right = 100.0 * np.sqrt(2.0) / (pixels * mm / RULER_MM)
        others = {
            "two clicks are off, each by a pixel: there is a root of 2.": right / np.sqrt(2.0),
            "two errors rarely point the same way: root of 2, not 2.": right * np.sqrt(2.0),
        }
        percent(right, others, answer, what, 0.01)
    if one(worst, ("clicks", "book", "hand"), "error") != "hand":
        raise Wrong("Put the three percentages beside each other: this one, that of the lifted ruler, that of the knuckles.")
    return "Clicking twice as carefully gains next to nothing here. A ruler beside the knuckles gains almost everything."
