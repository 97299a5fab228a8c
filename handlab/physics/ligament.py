"""Passive parts of a joint that the paper leaves out: a linear stiffness, and ligaments that tighten with flexion.

Angles in radians, stiffness in newton metres per radian, torques in newton metres. Scalars or arrays of one shape.
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


def tautness(flexion: ArrayLike, taut_at: float = TAUT_AT) -> Array:
    """How taut a collateral ligament is: 0 up to 0 flexion, 1 from ``taut_at`` on, 3u^2 - 2u^3 between.

    That it rises smoothly in this shape is an assumption; sources give only its ends.
    """
    u = np.clip(np.asarray(flexion, dtype=np.float64) / taut_at, 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


def tautness_slope(flexion: ArrayLike, taut_at: float = TAUT_AT) -> Array:
    """Derivative of ``tautness`` by flexion, per radian."""
    u = np.clip(np.asarray(flexion, dtype=np.float64) / taut_at, 0.0, 1.0)
    return 6.0 * u * (1.0 - u) / taut_at


def between(slack: float, taut: float, flexion: ArrayLike, taut_at: float = TAUT_AT) -> Array:
    """A property that goes from ``slack`` to ``taut`` as the ligament tightens: range or stiffness factor."""
    return slack + (taut - slack) * tautness(flexion, taut_at)


def collateral_torque(
    stiffness: ArrayLike,
    factor: float,
    flexion: ArrayLike,
    deviation: ArrayLike,
    rest: ArrayLike,
    taut_at: float = TAUT_AT,
) -> tuple[Array, Array]:
    """Torques (on deviation, on flexion) of a deviation spring that is ``factor`` times as stiff when the ligament is taut.

    Both are slopes of one energy, k f(flexion) (deviation - rest)^2 / 2: without the second, flexing and
    straightening a spread finger would gain energy from nothing.
    """
    stiffness = np.asarray(stiffness, dtype=np.float64)
    away = np.asarray(deviation, dtype=np.float64) - np.asarray(rest)
    on_deviation = -stiffness * between(1.0, factor, flexion, taut_at) * away
    on_flexion = -0.5 * stiffness * (factor - 1.0) * tautness_slope(flexion, taut_at) * away**2
    return on_deviation, on_flexion
