"""Torque about a joint axis, and friction: equations (2), (2') and (2'').

Vectors are (..., 3): ``axis`` is a unit vector, ``arm`` in metres, ``force`` in newtons; torques are in newton metres,
speeds in radians per second, ``friction`` in newton metre seconds per radian.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def cross(arm: ArrayLike, force: ArrayLike) -> Array:
    """arm x force, (..., 3)."""
    return np.cross(np.asarray(arm, dtype=np.float64), np.asarray(force, dtype=np.float64))


def along(axis: ArrayLike, vector: ArrayLike) -> Array:
    """The part (...,) of vectors (..., 3) along unit axes."""
    result: Array = np.sum(np.asarray(axis, dtype=np.float64) * np.asarray(vector, dtype=np.float64), axis=-1)
    return result


def torque_about_axis(axis: ArrayLike, arm: ArrayLike, force: ArrayLike) -> Array:
    """The part of arm x force that turns about the axis: (2), sound reading.

    >>> round(float(torque_about_axis([0, 0, 1], [0.004, -0.0111, 0.002], [50, 3, 5])), 12)
    0.567
    """
    return along(axis, cross(arm, force))


def torque_printed(axis: ArrayLike, arm: ArrayLike, force: ArrayLike) -> Array:
    """The length of arm x force with the sign of its part about the axis: (2) as printed.

    The length contains what the bearing of the joint takes up, so it is too large unless arm x force lies along the axis.

    >>> round(float(torque_printed([0, 0, 1], [0.004, -0.0111, 0.002], [50, 3, 5])), 6)
    0.575909
    """
    return torque_printed_of_sum(axis, cross(arm, force))


def torque_printed_of_sum(axis: ArrayLike, torque: ArrayLike) -> Array:
    """The length of the summed torque vector with the sign of its part about the axis: (2'') as printed, without friction."""
    result: Array = np.sign(along(axis, torque)) * np.linalg.norm(np.asarray(torque, dtype=np.float64), axis=-1)
    return result


def friction_opposing(torque: ArrayLike, speed: ArrayLike, friction: ArrayLike) -> Array:
    """Torque left after viscous friction against the speed: T - mu omega, the sound reading of (2').

    >>> round(float(friction_opposing(0.1, -2.0, 0.015)), 12)
    0.13
    """
    result: Array = np.asarray(torque) - np.asarray(friction) * np.asarray(speed, dtype=np.float64)
    return result


def friction_printed(torque: ArrayLike, speed: ArrayLike, friction: ArrayLike) -> Array:
    """sgn(T) (|T| - mu |omega|): (2') as printed.

    It takes friction off along the muscle's torque: a bone that turns the other way is pushed on, and without torque nothing brakes.

    >>> round(float(friction_printed(0.1, -2.0, 0.015)), 12)
    0.07
    """
    torque = np.asarray(torque, dtype=np.float64)
    result: Array = np.sign(torque) * (np.abs(torque) - np.asarray(friction) * np.abs(np.asarray(speed, dtype=np.float64)))
    return result


def joint_torque(lever_arm: ArrayLike, force: ArrayLike) -> Array:
    """R' F: torques (dof,) of all muscles from signed lever arms (muscle, dof) and forces (muscle,); the sum in (2'')."""
    result: Array = np.asarray(lever_arm, dtype=np.float64).T @ np.asarray(force, dtype=np.float64)
    return result
