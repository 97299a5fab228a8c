"""How a geometric muscle changes shape: fibres as chains of ellipsoids (section 4.2, after Kähler, Haber, Seidel 2001).

A fibre is a line of control points from its fixed to its other end; every segment carries an ellipsoid. Marks: *recalled* are
formulas remembered of the source, which could not be read again; *derived* are those worked out here to fill its gaps.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Law = Literal["volume", "recalled"]

LEAST = 0.01  # no point comes nearer to the fixed end than this share of its rest distance (recalled, doubtful)
RECALLED_FACTOR = 2.0  # thickness gained per length lost (recalled, doubtful)
# Assumptions: what full contraction does to a muscle whose ends stay where the bones are. No source gives these numbers. They were
# chosen on the reference hand so that the upper side of the first dorsal interosseous rises by some 3 mm in a key pinch, because
# the skin over it is to rise visibly: that rise is therefore no evidence for the law.
SHORTENING = 0.3  # the middle of the belly gives up this share of its length to the tendinous ends
TRANSFER = 0.9  # volume moves from the ends into the belly: relative change per unit of bell weight above its mean
FREE_SHORTENING = 0.4  # a fibre whose end hangs on no bone shortens to 0.6 of its length


def arc_length(points: ArrayLike) -> Array:
    """Normalised arc length t_i (n,) of the corners of a line (n, 3): 0 at the first, 1 at the last.

    >>> arc_length([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [18.0, 6.0, 0.0], [28.0, 6.0, 0.0]]).round(6).tolist()
    [0.0, 0.333333, 0.666667, 1.0]
    """
    line = np.asarray(points, dtype=np.float64)
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    if line.ndim != 2 or len(line) < 2 or not steps.sum() > 0.0:
        raise ValueError("a fibre needs at least two different points (n, 3)")
    result: Array = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    return result


def on_line(points: ArrayLike, share: ArrayLike) -> Array:
    """Points (m, 3) of the line ``points`` (n, 3) at the normalised arc lengths ``share`` (m,), by linear interpolation."""
    line, t = np.asarray(points, dtype=np.float64), arc_length(points)
    return np.stack([np.interp(np.asarray(share, dtype=np.float64), t, line[:, k]) for k in range(line.shape[1])], axis=-1)


def contracted(points: ArrayLike, contraction: float) -> Array:
    """A linear muscle pulled to its fixed end (recalled): q_i on the old line at t~_i = max((1 - c) t_i, 0.01 t_i).

    ``points`` (n, 3), the fixed end first; ``contraction`` 0 to 1. Returns (n, 3).
    """
    t = arc_length(points)
    return on_line(points, np.maximum((1.0 - contraction) * t, LEAST * t))


def sphincter(points: ArrayLike, centre: ArrayLike, contraction: float) -> Array:
    """A ring muscle pulled to its centre p* (recalled): q_i = p* + (1 - c)(p_i - p*).

    >>> sphincter([[10.0, 5.0, 0.0]], [5.0, 5.0, 0.0], 0.3).tolist()
    [[8.5, 5.0, 0.0]]
    """
    middle = np.asarray(centre, dtype=np.float64)
    result: Array = middle + (1.0 - contraction) * (np.asarray(points, dtype=np.float64) - middle)
    return result


def recalled_bulge(ratio: ArrayLike) -> Array:
    """Thickness factor 1 + 2 (1 - q) of a segment at q = length / rest length (recalled, the factor 2 doubtful).

    It keeps no volume: at q = 0.7 a segment holds 1.12 times as much, at q = 0.5 just as much as at rest.
    """
    return np.asarray(1.0 + RECALLED_FACTOR * (1.0 - np.asarray(ratio, dtype=np.float64)), dtype=np.float64)


def volume_bulge(ratio: ArrayLike, *, height_only: bool = False) -> Array:
    """Thickness factor that keeps the volume (derived): q^(-1/2) of width and height, or q^(-1) of the height alone.

    >>> float(volume_bulge(0.7).round(6)), float(volume_bulge(0.7, height_only=True).round(6))
    (1.195229, 1.428571)
    """
    q = np.asarray(ratio, dtype=np.float64)
    return np.asarray(q ** (-1.0 if height_only else -0.5), dtype=np.float64)


def bell(rest_length: ArrayLike) -> Array:
    """4 u (1 - u) at the middle u of every segment of a fibre (derived): 1 in the belly, near 0 at the tendinous ends."""
    length = np.asarray(rest_length, dtype=np.float64)
    u = (np.cumsum(length) - 0.5 * length) / length.sum()
    result: Array = 4.0 * u * (1.0 - u)
    return result


def shares(rest_length: ArrayLike, contraction: float, *, shortening: float = SHORTENING) -> Array:
    """Share of the whole line that every segment takes (n,), adding to 1 (derived).

    l_i (1 - s c bell_i), scaled to the line: both ends stay on their bones, the belly shortens, the tendinous ends lengthen.
    """
    length = np.asarray(rest_length, dtype=np.float64)
    kept = length * (1.0 - shortening * contraction * bell(length))
    result: Array = kept / kept.sum()
    return result


def volumes(rest_length: ArrayLike, rest_volume: ArrayLike, contraction: float, *, transfer: float = TRANSFER) -> Array:
    """Volume of every segment (n,) at ``contraction`` (derived): V_i (1 + k c (bell_i - mean bell)).

    The mean is weighted by volume, so that the sum stays what it is to the last bit but rounding: nothing is created.
    """
    volume, weight = np.asarray(rest_volume, dtype=np.float64), bell(rest_length)
    mean = (volume * weight).sum() / volume.sum()
    result: Array = volume * (1.0 + transfer * contraction * (weight - mean))
    return result


def ellipsoid_volume(half: ArrayLike) -> Array:
    """4/3 pi a b c of half-axes (..., 3).

    >>> float(ellipsoid_volume([1.0, 1.0, 1.0]).round(4))
    4.1888
    """
    return np.asarray(4.0 / 3.0 * np.pi * np.prod(np.asarray(half, dtype=np.float64), axis=-1), dtype=np.float64)
