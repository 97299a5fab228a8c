"""Passive parts of a joint that the paper leaves out: a spring, a capsule that tightens toward the limits, collateral ligaments.

Angles in radians, stiffness in newton metres per radian, torques in newton metres, energies in joules. Scalars or arrays of one shape.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Flexion at which a collateral ligament is fully taut, where nothing else is said.
TAUT_AT = np.pi / 2.0


def spring_torque(stiffness: ArrayLike, angle: ArrayLike, rest: ArrayLike) -> Array:
    """-k (angle - rest)."""
    result: Array = np.asarray(stiffness, dtype=np.float64) * (np.asarray(rest) - np.asarray(angle))
    return result


def strain(angle: ArrayLike, lower: ArrayLike, upper: ArrayLike, width: ArrayLike) -> tuple[Array, Array]:
    """How far (lower, upper) a capsule is stretched: 0 until ``width`` before the limit, 1 at the limit, more beyond."""
    angle, width = np.asarray(angle, dtype=np.float64), np.asarray(width, dtype=np.float64)
    low: Array = np.maximum(0.0, 1.0 + (np.asarray(lower) - angle) / width)
    high: Array = np.maximum(0.0, 1.0 + (angle - np.asarray(upper)) / width)
    return low, high


def capsule_torque(
    angle: ArrayLike,
    lower: ArrayLike,
    upper: ArrayLike,
    width: ArrayLike,
    at_lower: ArrayLike,
    at_upper: ArrayLike,
    speed: ArrayLike = 0.0,
    time: ArrayLike = 0.0,
) -> Array:
    """Torque of capsule and ligaments near the limits: T strain^3 toward the middle, braked by its slope times ``time`` times speed.

    ``at_lower`` and ``at_upper`` are T, the torques at the limits; ``width`` before them it begins. Slope and curvature begin at 0,
    so nothing jolts. ``time`` (s) is that of a Kelvin-Voigt solid: it takes energy out, never in.

    >>> round(float(capsule_torque(1.0, -1.0, 1.0, 0.1, 0.3, 0.2)), 12), float(capsule_torque(0.8, -1.0, 1.0, 0.1, 0.3, 0.2))
    (-0.2, 0.0)
    """
    low, high = strain(angle, lower, upper, width)
    slope = capsule_slope(angle, lower, upper, width, at_lower, at_upper)
    result: Array = np.asarray(at_lower) * low**3 - np.asarray(at_upper) * high**3 - np.asarray(time) * slope * np.asarray(speed)
    return result


def capsule_slope(
    angle: ArrayLike, lower: ArrayLike, upper: ArrayLike, width: ArrayLike, at_lower: ArrayLike, at_upper: ArrayLike
) -> Array:
    """Stiffness of the capsule: minus the derivative of its torque by the angle, N m/rad."""
    low, high = strain(angle, lower, upper, width)
    result: Array = 3.0 * (np.asarray(at_lower) * low**2 + np.asarray(at_upper) * high**2) / np.asarray(width)
    return result


def capsule_energy(
    angle: ArrayLike, lower: ArrayLike, upper: ArrayLike, width: ArrayLike, at_lower: ArrayLike, at_upper: ArrayLike
) -> Array:
    """Energy stored in the capsule: T width strain^4 / 4."""
    low, high = strain(angle, lower, upper, width)
    result: Array = 0.25 * np.asarray(width) * (np.asarray(at_lower) * low**4 + np.asarray(at_upper) * high**4)
    return result


def tautness(flexion: ArrayLike, taut_at: float = TAUT_AT) -> Array:
    """How taut a collateral ligament is: 0 up to 0 flexion, 1 from ``taut_at`` on, 3u^2 - 2u^3 between.

    That it rises smoothly in this shape is an assumption; sources give only its ends.
    """
    u = np.clip(np.asarray(flexion, dtype=np.float64) / taut_at, 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


def between(slack: float, taut: float, flexion: ArrayLike, taut_at: float = TAUT_AT) -> Array:
    """A property that goes from ``slack`` to ``taut`` as the ligament tightens: range or stiffness factor."""
    return slack + (taut - slack) * tautness(flexion, taut_at)


def collateral_energy(
    stiffness: ArrayLike,
    factor: float,
    fraction: float,
    flexion: ArrayLike,
    deviation: ArrayLike,
    rest: ArrayLike,
    lower: ArrayLike,
    upper: ArrayLike,
    width: ArrayLike,
    at_lower: ArrayLike,
    at_upper: ArrayLike,
    taut_at: float = TAUT_AT,
) -> Array:
    """Energy of a deviation spring and capsule that MCP flexion tightens.

    Stiffness grows by ``factor``, limits and width shrink to ``fraction``. Both torques are slopes of this one energy, that on
    flexion too: without it, flexing and straightening a spread finger would gain energy from nothing.
    """
    away = np.asarray(deviation, dtype=np.float64) - np.asarray(rest)
    left = between(1.0, fraction, flexion, taut_at)
    spring = 0.5 * np.asarray(stiffness) * between(1.0, factor, flexion, taut_at) * away**2
    bounds = left * np.asarray(lower), left * np.asarray(upper), left * np.asarray(width)
    result: Array = spring + capsule_energy(deviation, *bounds, at_lower, at_upper)
    return result
