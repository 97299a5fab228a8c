"""From torque to angle and fibre length: equations (3) and (4) and the length update of section 4.1.1.

Torque in newton metres, inertia in kilogram square metres, speed in radians per second, angle in radians, ``dt`` in seconds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def explicit_speed(speed: ArrayLike, torque: ArrayLike, inertia: ArrayLike, dt: float) -> Array:
    """omega + dt T / J: (3) and (4) as printed, friction already inside ``torque``.

    With friction it is stable only for dt < 2 J / mu: 0.04 ms at the tip of the index finger.

    >>> round(float(explicit_speed(0.0, 0.1, 7.20726e-6, 1e-4)), 5)
    1.38749
    """
    result: Array = np.asarray(speed, dtype=np.float64) + dt * np.asarray(torque) / np.asarray(inertia)
    return result


def implicit_speed(
    speed: ArrayLike,
    torque: ArrayLike,
    inertia: ArrayLike,
    dt: float,
    friction: ArrayLike,
    stiffness: ArrayLike = 0.0,
) -> Array:
    """(omega + dt T / J) / (1 + dt mu / J + dt^2 k / J): (3) and (4) with friction and spring taken at the end of the step.

    Friction and spring alone are stable at any dt. ``torque`` contains the spring's torque at the old angle, not friction;
    ``stiffness`` k in newton metres per radian.
    """
    rate = dt / np.asarray(inertia, dtype=np.float64)
    result: Array = (np.asarray(speed) + rate * np.asarray(torque)) / (1.0 + rate * (np.asarray(friction) + dt * np.asarray(stiffness)))
    return result


def turned(angle: ArrayLike, speed: ArrayLike, dt: float) -> Array:
    """angle + dt omega_new: (4), semi-implicit Euler."""
    return np.asarray(angle, dtype=np.float64) + dt * np.asarray(speed)


def fibre_length(rest_length: ArrayLike, lever_arm: ArrayLike, angle: ArrayLike, fibre_rest: ArrayLike) -> Array:
    """l0 - R (angle - fibre_rest): fibre lengths (muscle,) in metres from the angles, without drift (sound reading).

    ``lever_arm`` (muscle, dof) in metres with signs; ``angle`` (dof,) or (time, dof); ``fibre_rest`` (dof,): the angles at
    which fibres have their resting length.
    """
    turned_by = np.asarray(angle, dtype=np.float64) - np.asarray(fibre_rest)
    result: Array = np.asarray(rest_length) - turned_by @ np.asarray(lever_arm).T
    return result


def length_printed(length: ArrayLike, turned_by: ArrayLike, arm: ArrayLike) -> Array:
    """l - dphi |r|: the update as printed. It has no sign, so an extensor shortens when its joint flexes."""
    result: Array = np.asarray(length, dtype=np.float64) - np.asarray(turned_by) * np.abs(np.asarray(arm))
    return result
