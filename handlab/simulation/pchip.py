"""Monotone cubic interpolation: a smooth curve through key values that never leaves them.

The paper asks for "a smooth spline" (section 3.1); an ordinary one can leave [0, 1]. Slopes after Fritsch and Butland 1984
with the three-point ends of Moler's "Numerical Computing with MATLAB"; scipy's ``PchipInterpolator`` is the same curve, and
importing it takes longer than a simulation.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array


def slopes(x: Array, y: Array) -> Array:
    """Slopes (K, m) at the knots ``x`` (K,) of the monotone curves through ``y`` (K, m)."""
    if len(x) == 1:
        return np.zeros_like(y)
    width = np.diff(x)[:, None]
    secant = np.diff(y, axis=0) / width
    if len(x) == 2:
        return np.repeat(secant, 2, axis=0)
    slope = np.zeros_like(y)
    left, right = secant[:-1], secant[1:]
    same_way = left * right > 0.0
    heavy_left, heavy_right = 2.0 * width[1:] + width[:-1], width[1:] + 2.0 * width[:-1]
    with np.errstate(all="ignore"):  # where the secants do not go the same way, the mean is not used
        mean = (heavy_left + heavy_right) / (heavy_left / left + heavy_right / right)
    slope[1:-1] = np.where(same_way, mean, 0.0)
    slope[0] = end_slope(width[0], width[1], secant[0], secant[1])
    slope[-1] = end_slope(width[-1], width[-2], secant[-1], secant[-2])
    return slope


def end_slope(width: Array, next_width: Array, secant: Array, next_secant: Array) -> Array:
    """Slope (m,) at an end: of the parabola through three knots, unless that would overshoot."""
    slope = ((2.0 * width + next_width) * secant - width * next_secant) / (width + next_width)
    slope = np.where(np.sign(slope) != np.sign(secant), 0.0, slope)
    result: Array = np.where((np.sign(secant) != np.sign(next_secant)) & (np.abs(slope) > 3.0 * np.abs(secant)), 3.0 * secant, slope)
    return result


def curve(x: Array, y: Array, slope: Array, at: ArrayLike) -> Array:
    """Values (T, m) of the cubics with knots ``x`` (K,), values ``y`` and ``slope`` (K, m) at times ``at`` (T,); the ends hold."""
    at = np.clip(np.asarray(at, dtype=np.float64), x[0], x[-1])
    if len(x) == 1:
        return np.repeat(y, len(at), axis=0)
    k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    width = (x[k + 1] - x[k])[:, None]
    u = (at - x[k])[:, None] / width
    v = 1.0 - u
    left = (1.0 + 2.0 * u) * y[k] + u * width * slope[k]
    right = (1.0 + 2.0 * v) * y[k + 1] - v * width * slope[k + 1]
    result: Array = v * v * left + u * u * right
    return result
