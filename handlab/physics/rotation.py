"""From torque to angle and fibre length: equations (3) and (4) and the length update of section 4.1.1.

Torque in newton metres, inertia in kilogram square metres, speed in radians per second, angle in radians, ``dt`` in seconds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.physics.torque import friction_opposing, friction_printed

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


def printed_step(
    angle: ArrayLike, speed: ArrayLike, torque: ArrayLike, inertia: ArrayLike, dt: float, friction: ArrayLike
) -> tuple[Array, Array]:
    """Angle and speed after one step exactly as printed: friction (2') along the muscles' ``torque``, then (3) and (4).

    A bone that turns against its muscles is pushed on by its friction and runs away; one without muscles never stops.

    >>> [round(float(value), 6) for value in printed_step(0.0, -2.0, 0.1, 1e-4, 1e-4, 0.015)]
    [-0.000193, -1.93]
    """
    after = explicit_speed(speed, friction_printed(torque, speed, friction), inertia, dt)
    return turned(angle, after, dt), after


def explicit_step(
    angle: ArrayLike, speed: ArrayLike, torque: ArrayLike, inertia: ArrayLike, dt: float, friction: ArrayLike
) -> tuple[Array, Array]:
    """Angle and speed after one step of (3) and (4) with friction against the old speed; grows for dt > ``largest_step``.

    >>> [round(float(value), 6) for value in explicit_step(0.0, -2.0, 0.1, 1e-4, 1e-4, 0.015)]
    [-0.000187, -1.87]
    """
    after = explicit_speed(speed, friction_opposing(torque, speed, friction), inertia, dt)
    return turned(angle, after, dt), after


def largest_step(inertia: ArrayLike, friction: ArrayLike) -> Array:
    """2 J / mu in seconds: with a longer explicit step friction overshoots by more than it brakes, and the speed grows.

    >>> round(1000 * float(largest_step(4.23923e-5, 0.015)), 2)
    5.65
    """
    result: Array = 2.0 * np.asarray(inertia, dtype=np.float64) / np.asarray(friction)
    return result


def leapfrog_first(speed: ArrayLike, torque: ArrayLike, inertia: ArrayLike, dt: float, friction: ArrayLike) -> Array:
    """(omega_0 + dt T / 2J) / (1 + dt mu / 2J): the speed half a step after the beginning; then ``leapfrog_speed``."""
    return implicit_speed(speed, torque, inertia, 0.5 * dt, friction)


def leapfrog_speed(half_speed: ArrayLike, torque: ArrayLike, inertia: ArrayLike, dt: float, friction: ArrayLike) -> Array:
    """((1 - x) omega_(n-1/2) + dt T_n / J) / (1 + x), x = dt mu / 2J: speeds live between the angles, so errors shrink with dt^2.

    ``torque`` at the angle of step n, without friction; friction acts on the mean of both speeds. Friction alone is stable at any dt,
    but for dt > ``largest_step`` the speed changes its sign at every step while it decays.

    >>> round(float(leapfrog_speed(-0.01, -2.0 * 0.00099, 1e-4, 1e-3, 0.0)), 6)
    -0.0298
    """
    rate = dt / np.asarray(inertia, dtype=np.float64)
    half = 0.5 * rate * np.asarray(friction)
    result: Array = ((1.0 - half) * np.asarray(half_speed) + rate * np.asarray(torque)) / (1.0 + half)
    return result
