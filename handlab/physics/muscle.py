"""Force of a muscle from its contraction and its fibre length (section 4.1).

Every function takes scalars or arrays of one shape and returns that shape. ``ratio`` is
fibre length over resting length, without unit; forces are in newtons.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Reading = Literal["sound", "printed"]

# The fitted quadratics of section 4.1.
ACTIVE_PEAK = 1.1  # fibre length ratio of the largest active force
ACTIVE_CURVATURE = 4.0
PASSIVE_CURVATURE = 2.77


def active_force_length(ratio: ArrayLike, *, reading: Reading = "sound") -> Array:
    """Active force over maximum force at full contraction: 1 - 4 (ratio - 1.1)^2 (section 4.1, unnumbered).

    ``printed`` turns negative outside [0.6, 1.6], as if a muscle could push; ``sound`` is never below 0.

    >>> round(float(active_force_length(1.0)), 12), round(float(active_force_length(0.5, reading="printed")), 12)
    (0.96, -0.44)
    """
    curve = 1.0 - ACTIVE_CURVATURE * (np.asarray(ratio, dtype=np.float64) - ACTIVE_PEAK) ** 2
    if reading == "printed":
        return curve
    if reading == "sound":
        return np.maximum(0.0, curve)
    raise ValueError(f"reading is {reading!r}; choose 'sound' or 'printed'")


def passive_force_length(ratio: ArrayLike) -> Array:
    """Force of a stretched fibre over maximum force: 2.77 (ratio - 1)^2 from ratio 1 on, else 0 (section 4.1, unnumbered).

    Not bounded above 1.6, where it acts as a soft stop.

    >>> round(float(passive_force_length(1.6)), 12), float(passive_force_length(0.9))
    (0.9972, 0.0)
    """
    stretch = np.maximum(0.0, np.asarray(ratio, dtype=np.float64) - 1.0)
    return PASSIVE_CURVATURE * stretch**2


def active_slope(ratio: ArrayLike) -> Array:
    """Derivative of the sound active curve by ``ratio``; 0 where the fibre pulls nothing."""
    ratio = np.asarray(ratio, dtype=np.float64)
    slope = -2.0 * ACTIVE_CURVATURE * (ratio - ACTIVE_PEAK)
    return np.where(active_force_length(ratio) > 0.0, slope, 0.0)


def passive_slope(ratio: ArrayLike) -> Array:
    """Derivative of the passive curve by ``ratio``."""
    return 2.0 * PASSIVE_CURVATURE * np.maximum(0.0, np.asarray(ratio, dtype=np.float64) - 1.0)


def muscle_force(contraction: ArrayLike, ratio: ArrayLike, max_force: ArrayLike, *, reading: Reading = "sound") -> Array:
    """F = (c active + passive) F_max, newtons: equations (1) and (1').

    ``contraction`` in [0, 1]; ``max_force`` in newtons.

    >>> round(float(muscle_force(0.5, 1.2, 1.0)), 12)
    0.5908
    """
    active, passive = active_force_length(ratio, reading=reading), passive_force_length(ratio)
    result: Array = (np.asarray(contraction) * active + passive) * np.asarray(max_force)
    return result
