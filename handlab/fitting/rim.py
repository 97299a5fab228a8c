"""The outline of a coin to a fraction of a pixel, from a circle near it.

A coin lies in its own shadow, and its edge is rounded: the strongest edge is seldom its outline. So the outline is looked for as a curve
(a circle that may be shifted and slightly oval) along which the picture changes everywhere at once, in one of two pictures:

- by its **colour**, where that differs from the ground's: what is left of every pixel without the ground's colour. A shadow is darker, but
  of the same colour, so it vanishes.
- by its **light** else. Metal mirrors: where the rounded edge is steeper than 45 degrees it shows the table, not the lamp or the room,
  and on a darker ground it is not seen. ``calibration.coin`` knows how much that is. A coin darker than its ground, of the same colour,
  cannot be told from its shadow: the finding is then called "doubtful".
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.records import Array

RAYS, SECTORS = 360, 45
LUMINANCE = (0.2126, 0.7152, 0.0722)  # of linear red, green, blue (ITU-R BT.709)
INSIDE, AROUND = (0.6, 0.93), (1.12, 1.30)  # of the radius: surely on the coin, surely on the ground
NEAR = ((0.90, 1.06), (0.97, 1.03))  # of the radius: where the outline is looked for, twice
OVAL, BESIDE = 0.01, 0.04  # how oval and how far beside its circle an outline likely is (an assumption)
STRONG = 1.5  # a sector counts at most so many times the middle one
# Least difference of colour (full scale 1), and over the unevenness of the ground. Below it the edge, which mirrors the table, has too
# nearly the colour of the table.
COLOURED, CLEAR = 0.11, 3.0
DARK = 4.0  # a coin so many times as bright as its ground lies on a dark one: its light tells enough
BRIGHTER = 1.3  # a rim must be so much brighter than the ground beside it to be no shadow
OUTERMOST = 0.5  # of the strongest change: the last one as strong is the outline
WINDOW = 0.025  # of the radius, around the outline


class Rim(NamedTuple):
    """``centre`` (2,) px, mean ``radius`` px, ``oval`` (half the difference of the longest and the shortest radius, relative), ``scatter``
    of the sectors about the outline (relative), ``seen`` "by colour", "by light" or "doubtful"."""

    centre: Array
    radius: float
    oval: float
    scatter: float
    seen: str


class _Outline(NamedTuple):
    """``centre`` (2,) and ``radius`` px, ``second`` (2,): cosine and sine of twice the angle, relative to the radius."""

    centre: Array
    radius: float
    second: Array


def outline(picture: NDArray[np.uint8], centre: Array, radius: float) -> Rim:
    """The rim of the coin near the circle ``centre`` (2,), ``radius`` px in ``picture`` (rows, columns, 3)."""
    reach = int(1.4 * radius) + 12
    low = np.maximum(np.floor(centre).astype(int) - reach, 0)
    part = np.asarray(picture[low[1] : int(centre[1]) + reach, low[0] : int(centre[0]) + reach], dtype=np.float64) / 255.0
    part = np.repeat(part[:, :, None], 3, axis=2) if part.ndim == 2 else part[:, :, :3]
    start = _Outline(centre - low, radius, np.zeros(2))
    coloured = _without_ground(part, start)
    image = part if coloured is None else coloured
    found = start
    for near in NEAR:
        found = _common(image, found, near)
    for _ in range(4):
        found, scatter = _through_edges(image, found, image)
    light = linear(part)
    seen = "by colour"
    if coloured is None:
        found, scatter = _through_edges(image, found, light)
        inside, around = (_level(light, found, edge) for edge in ((1.0, 3.0), (-3.5, -1.5)))
        seen = "by light" if inside > BRIGHTER * around else "doubtful"
    return Rim(found.centre + low, found.radius, float(np.hypot(*found.second)), scatter / found.radius, seen)


def linear(values: Array) -> Array:
    """Light from the values of a picture, 0 to 1 (IEC 61966-2-1)."""
    result: Array = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    return result


def _without_ground(part: Array, circle: _Outline) -> Array | None:
    """The picture without the ground's colour, or None where the coin has the same, or lies on a dark ground."""
    ground, coin = (_samples(part, circle, np.linspace(*share, 12) * circle.radius) for share in (AROUND, INSIDE))
    colour = np.median(ground, axis=(0, 1))
    bright, dark = (float(linear(np.median(values, axis=(0, 1))) @ LUMINANCE) for values in (coin, ground))
    if bright > DARK * dark:
        return None
    colour = colour / max(float(np.linalg.norm(colour)), 1e-9)
    rest = np.eye(3) - np.outer(colour, colour)
    apart = np.linalg.norm(np.median(coin @ rest, axis=(0, 1)))
    if apart < max(COLOURED, CLEAR * float(np.linalg.norm((ground @ rest).std(axis=(0, 1))))):
        return None
    return np.asarray(part @ rest)


def _samples(image: Array, circle: _Outline, far: Array) -> Array:
    """Means over sectors (SECTORS, len(far), channels) at the distances ``far`` px, stretched as ``circle`` is oval."""
    from scipy.ndimage import map_coordinates

    angle = 2.0 * np.pi * (np.arange(RAYS) + 0.5) / RAYS
    oval = 1.0 + circle.second[0] * np.cos(2.0 * angle) + circle.second[1] * np.sin(2.0 * angle)
    # pixel centres lie at halves
    x = circle.centre[0] + (np.cos(angle) * oval)[:, None] * far - 0.5
    y = circle.centre[1] + (np.sin(angle) * oval)[:, None] * far - 0.5
    values = [map_coordinates(image[:, :, k], [y, x], order=1, mode="nearest") for k in range(image.shape[2])]
    return np.asarray(np.stack(values, axis=-1).reshape(SECTORS, RAYS // SECTORS, len(far), -1).mean(axis=1))


def _change(image: Array, circle: _Outline, far: Array, blur_px: float) -> Array:
    """How strongly the picture changes outwards (SECTORS, len(far))."""
    from scipy.ndimage import gaussian_filter1d

    smooth = gaussian_filter1d(_samples(image, circle, far), blur_px / (far[1] - far[0]), axis=1)
    return np.asarray(np.linalg.norm(np.gradient(smooth, axis=1), axis=2))


def _rows() -> Array:
    """Radius of every sector (SECTORS,) = these rows times (radius, shift in x and y, oval's cosine and sine)."""
    angle = 2.0 * np.pi * (np.arange(SECTORS) + 0.5) / SECTORS
    return np.stack([np.ones(SECTORS), np.cos(angle), np.sin(angle), np.cos(2 * angle), np.sin(2 * angle)], axis=1)


def _moved(circle: _Outline, found: Array) -> _Outline:
    return _Outline(circle.centre + found[1:3], float(found[0]), circle.second + found[3:] / circle.radius)


def _common(image: Array, circle: _Outline, near: tuple[float, float]) -> _Outline:
    """The curve along which the picture changes in as many sectors as possible; strong ones count no more than others."""
    from scipy.optimize import minimize

    radius, step, rows = circle.radius, 0.5, _rows()
    far = np.arange(near[0] * radius - 8.0, near[1] * radius + 8.0, step)
    change = _change(image, circle, far, 1.0)
    worth = np.sqrt(np.minimum(change / max(float(np.median(change.max(axis=1))), 1e-12), STRONG))
    sector = np.arange(SECTORS)

    def cost(unknown: Array) -> float:
        place = np.clip((rows @ unknown - far[0]) / step, 0.0, len(far) - 1.001)
        k = place.astype(int)
        along = worth[sector, k] * (k + 1 - place) + worth[sector, k + 1] * (place - k)
        return float(
            0.5 * np.sum((unknown[3:] / (OVAL * radius)) ** 2) + 0.5 * np.sum((unknown[1:3] / (BESIDE * radius)) ** 2) - along.sum()
        )

    starts: list[float] = []
    for value in sorted(np.arange(near[0] * radius, near[1] * radius, step), key=lambda r: cost(np.array([r, 0, 0, 0, 0]))):
        if len(starts) < 5 and all(abs(value - other) > 0.01 * radius for other in starts):
            starts.append(float(value))
    options = {"xtol": 0.02, "ftol": 1e-6, "maxiter": 8}
    tried = [minimize(cost, [start, 0.0, 0.0, 0.0, 0.0], method="Powell", options=options) for start in starts]
    return _moved(circle, min(tried, key=lambda one: float(one.fun)).x)


def _through_edges(image: Array, circle: _Outline, light: Array) -> tuple[_Outline, float]:
    """The outline through the outermost strong change of every sector, robust, and the sectors' scatter about it (px).

    Where ``light`` is another picture, every place is moved to the steepest light beside it: blur is even in light, not in the picture's
    values, in which a bright coin looks larger.
    """
    radius = circle.radius
    window = max(WINDOW * radius, 1.5)
    far = np.arange(radius - window - 4.0, radius + window + 4.0, 0.2)
    change = _change(image, circle, far, 0.5)
    within = np.abs(far - radius) <= window
    strongest = np.where(within, change, 0.0).max(axis=1, keepdims=True)
    place, there = _last_peak(change, far, within & (change >= OUTERMOST * np.minimum(strongest, np.median(strongest))))
    if light is not image:
        beside = (far > place[:, None] - 1.6) & (far < place[:, None] + 0.4)
        lit, also = _last_peak(_change(light, circle, far, 0.5), far, beside)
        place = np.where(also, lit, place)
    rows, found = _rows(), np.array([np.median(place[there]) if there.any() else radius, 0.0, 0.0, 0.0, 0.0])
    scatter = 0.0
    for _ in range(12):
        off = place - rows @ found
        scatter = max(1.4826 * float(np.median(np.abs(off))), 0.15)
        weight = there * np.clip(1.0 - (off / (4.0 * scatter)) ** 2, 0.0, 1.0)
        if np.count_nonzero(weight) < 8:
            break
        found = np.linalg.lstsq(rows * weight[:, None], place * weight, rcond=None)[0]
    return _moved(circle, found), scatter


def _last_peak(change: Array, far: Array, where: NDArray[np.bool_]) -> tuple[Array, NDArray[np.bool_]]:
    """The outermost peak of every sector among the places ``where``, and whether there is one."""
    peak = np.zeros_like(where)
    peak[:, 1:-1] = (change[:, 1:-1] >= change[:, :-2]) & (change[:, 1:-1] > change[:, 2:])
    peak &= where
    last = np.clip(len(far) - 1 - np.argmax(peak[:, ::-1], axis=1), 1, len(far) - 2)
    row = np.arange(len(change))
    # the top of a parabola through three samples
    a, b, c = (change[row, last + k] for k in (-1, 0, 1))
    offset = np.clip(0.5 * (a - c) / np.minimum(a - 2 * b + c, -1e-12), -0.5, 0.5)
    return far[last] + offset * (far[1] - far[0]), np.asarray(peak.any(axis=1))


def _level(light: Array, circle: _Outline, inwards: tuple[float, float]) -> float:
    """Median brightness between two distances (px) inside the outline."""
    far = circle.radius - np.linspace(*inwards, 8)
    return float(np.median(_samples(light, circle, far) @ LUMINANCE))
