"""The rim of a coin and the edges of a card, found around one click: strong changes of colour along rays, and the circle or
rectangle that most rays agree on."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.records import Array

RAYS = 240
KEPT = 6  # strongest changes of colour on every ray
LONGEST = 0.35  # of the shorter side of the picture: no coin in a picture of a hand is larger in radius
SAMPLES = 700  # along a ray
SMALLEST_PX = 8.0
AGREE = 0.55  # of the rays must meet the outline
AS_GOOD = 0.80  # of the best circle's agreement: then the larger circle is the rim, the smaller a pattern inside
TRIALS = 3000
PEAKS = 5  # candidates for each side of a card
EVERY_SIDE = 0.3  # of the rays to each side of a card must meet it
ASPECT = 0.03  # how far (log) the sides of a card may be from their ratio before they are refined


class Circle(NamedTuple):
    """``centre`` (2,) px, ``radius`` px."""

    centre: Array
    radius: float


class Rectangle(NamedTuple):
    """``long`` and ``short`` side in px, ``uncertainty`` (relative)."""

    long: float
    short: float
    uncertainty: float


def find_circle(picture: NDArray[np.uint8], click: Array) -> Circle:
    """A circle near the rim of a coin (its shadow, a ring inside) around ``click`` (x, y) px; ``rim.outline`` finds the rim itself.

    Raises ``ValueError`` where no circle stands out.
    """
    points, ray, step = edges(picture, click)
    tolerance = 1.5 * step
    found: list[tuple[int, float, Array]] = []
    for chosen in np.random.default_rng(0).integers(len(points), size=(TRIALS, 3)):
        circle = _through(points[chosen])
        if circle is None or circle[2] < SMALLEST_PX or np.hypot(*(circle[:2] - click)) > 0.9 * circle[2] or circle[2] > SAMPLES * step:
            continue
        met = np.zeros(RAYS, dtype=bool)
        met[ray[np.abs(np.hypot(points[:, 0] - circle[0], points[:, 1] - circle[1]) - circle[2]) < tolerance]] = True
        found.append((int(np.count_nonzero(met)), float(circle[2]), circle))
    best = max((votes for votes, _, _ in found), default=0)
    if best < AGREE * RAYS:
        raise ValueError(
            "no coin was found around the click: click near its middle; it must lie flat, whole and apart from other things "
            "(or click two points of a ruler instead)"
        )
    _, _, circle = max((row for row in found if row[0] >= max(AS_GOOD * best, AGREE * RAYS)), key=lambda row: row[1])
    return Circle(circle[:2], float(circle[2]))


def find_rectangle(picture: NDArray[np.uint8], click: Array, ratio: float) -> Rectangle:
    """The edges of a card with sides of this ``ratio`` (long over short) around ``click`` (x, y) px, at any angle.

    Raises ``ValueError`` where no rectangle stands out."""
    points, ray, step = edges(picture, click)
    here = points - click
    found = [
        (*row, float(angle))
        for angle in np.deg2rad(np.arange(0.0, 90.0))
        for row in _four_sides(here, ray, float(angle), ratio, 3.0 * step)
    ]
    most = max((votes for votes, *_ in found), default=0)
    if most < AGREE * RAYS:
        raise ValueError("no card was found around the click: click near its middle; it must lie flat, whole and apart from other things")
    # a stripe, a chip and two edges may form a smaller rectangle; a shadow a slightly larger one
    largest = max(size for votes, size, *_ in found if votes >= AS_GOOD * most)
    _, _, sides, angle = max((row for row in found if row[1] > 0.93 * largest), key=lambda row: row[0])
    for width in (3.0, 2.0, 1.5, 1.0):
        angle, sides = _refined(here, angle, sides, width * step)
    widths = sorted((sides[0] - sides[1], sides[2] - sides[3]), reverse=True)
    if min(widths) < SMALLEST_PX:
        raise ValueError("no card was found around the click: click near its middle")
    return Rectangle(float(widths[0]), float(widths[1]), 0.3 * step / float(widths[1]))


def edges(picture: NDArray[np.uint8], click: Array) -> tuple[Array, NDArray[np.int64], float]:
    """Places (K, 2) px of the strongest changes of colour along rays from ``click``, the ray of each, and the sampling step in px."""
    from scipy.ndimage import gaussian_filter, map_coordinates

    pixels = np.asarray(picture, dtype=np.float64)
    pixels = pixels[:, :, None] if pixels.ndim == 2 else pixels[:, :, :3]
    rows, columns = pixels.shape[:2]
    x, y = click
    if not (0.0 <= x < columns and 0.0 <= y < rows):
        raise ValueError(f"the click ({x:.0f}, {y:.0f}) lies outside the picture of {columns} x {rows} pixels")
    reach = LONGEST * min(rows, columns)
    step = max(1.0, reach / SAMPLES)
    low = np.maximum(np.floor([y - reach, x - reach]).astype(int) - 2, 0)
    high = np.minimum(np.ceil([y + reach, x + reach]).astype(int) + 3, [rows, columns])
    part = pixels[low[0] : high[0], low[1] : high[1]]
    smooth = np.stack([gaussian_filter(part[:, :, c], step) for c in range(part.shape[2])])
    angle = 2.0 * np.pi * np.arange(RAYS) / RAYS
    along = np.arange(2.0, reach, 0.5 * step)
    # pixel centres lie at halves
    at_x = x + np.cos(angle)[:, None] * along - 0.5 - low[1]
    at_y = y + np.sin(angle)[:, None] * along - 0.5 - low[0]
    values = np.stack([map_coordinates(channel, [at_y, at_x], order=1, mode="nearest") for channel in smooth])
    inside = (at_x >= 0) & (at_y >= 0) & (at_x <= part.shape[1] - 1) & (at_y <= part.shape[0] - 1)
    change = np.linalg.norm(np.gradient(values, axis=2), axis=0) * inside
    peak = (change[:, 1:-1] > change[:, :-2]) & (change[:, 1:-1] >= change[:, 2:])
    strength = np.where(peak, change[:, 1:-1], 0.0)
    top = np.argsort(-strength, axis=1)[:, :KEPT]
    ray = np.repeat(np.arange(RAYS), KEPT)
    column = top.reshape(-1)
    good = strength[ray, column] > 0.1 * np.quantile(strength.max(axis=1), 0.5)
    ray, column = ray[good], column[good] + 1
    # the top of a parabola through three samples
    a, b, c = (change[ray, column + k] for k in (-1, 0, 1))
    offset = np.clip(0.5 * (a - c) / np.minimum(a - 2 * b + c, -1e-12), -0.5, 0.5)
    far = along[column] + 0.5 * step * offset
    if len(far) < 12:
        raise ValueError("nothing stands out around the click; click on the coin or card itself")
    return np.stack([x + np.cos(angle[ray]) * far, y + np.sin(angle[ray]) * far], axis=1), ray, step


def _through(points: Array) -> Array | None:
    """Centre and radius (3,) of the circle through three points."""
    a, b = 2.0 * (points[1:] - points[0]), np.sum(points[1:] ** 2, axis=1) - np.sum(points[0] ** 2)
    det = a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    if abs(det) < 1e-6:
        return None
    centre = np.array([b[0] * a[1, 1] - b[1] * a[0, 1], a[0, 0] * b[1] - a[1, 0] * b[0]]) / det
    return np.array([*centre, np.hypot(*(points[0] - centre))])


def _four_sides(here: Array, ray: NDArray[np.int64], angle: float, ratio: float, bin_px: float) -> list[tuple[int, float, list[float]]]:
    """Rectangles of this ``ratio`` at ``angle``: rays that end on it, its longer side, its sides right, left, top, bottom of the click."""
    turned = _turned(here, angle)
    peaks: list[list[float]] = []
    for axis in (0, 1):
        for sign in (1.0, -1.0):
            value = sign * turned[:, axis]
            value = value[value > 2.0]
            if len(value) == 0:
                return []
            count, border = np.histogram(value, bins=np.arange(0.0, value.max() + 2 * bin_px, bin_px))
            count = count + np.append(count[1:], 0)
            peaks.append([sign * float(border[k] + bin_px) for k in np.argsort(-count)[:PEAKS]])
    found = []
    for sides in product(*peaks):
        wide, high = sides[0] - sides[1], sides[2] - sides[3]
        if abs(np.log(max(wide, high) / min(wide, high) / ratio)) < ASPECT:
            # on the rectangle itself: a stripe or a chip lies on lines of it, but only for a part of a side
            off = np.array([turned[:, 0] - sides[0], sides[1] - turned[:, 0], turned[:, 1] - sides[2], sides[3] - turned[:, 1]])
            on = np.abs(off.max(axis=0)) < bin_px
            seen = [len(np.unique(ray[on & (off.argmax(axis=0) == side)])) for side in range(4)]
            if min(np.array(seen) / _looking_at(sides)) > EVERY_SIDE:
                found.append((sum(seen), max(wide, high), list(sides)))
    return found


def _looking_at(sides: tuple[float, ...]) -> Array:
    """How many rays go to every side (4,)."""
    right, left, top, bottom = sides
    corner = np.arctan2([bottom, top, top, bottom], [right, right, left, left])  # the way round
    right_top_left_bottom = np.diff(np.append(corner, corner[0])) % (2.0 * np.pi) * RAYS / (2.0 * np.pi)
    return np.asarray(np.maximum(right_top_left_bottom[[0, 2, 1, 3]], 1.0))


def _turned(here: Array, angle: float) -> Array:
    result: Array = here @ np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return result


def _refined(here: Array, angle: float, sides: list[float], width: float) -> tuple[float, list[float]]:
    """A small turn and four distances by least squares over points near the sides."""
    turned = _turned(here, angle)
    low, high = np.array([sides[1], sides[3]]), np.array([sides[0], sides[2]])
    rows, goal = [], []
    for number, side in enumerate(sides):
        axis = number // 2
        other = 1 - axis
        near = (np.abs(turned[:, axis] - side) < width + 1.0) & (turned[:, other] > low[other]) & (turned[:, other] < high[other])
        for point in turned[near]:
            row = np.zeros(5)
            row[number], row[4] = 1.0, point[1] if axis == 0 else -point[0]
            rows.append(row)
            goal.append(point[axis])
    if len(rows) < 12:
        return angle, sides
    *found, turn = np.linalg.lstsq(np.array(rows), np.array(goal), rcond=None)[0]
    return angle - float(turn), [float(value) for value in found]
