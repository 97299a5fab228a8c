"""Tables of section 4.1.2: the moments of inertia of the paper's rods for angles in equal steps, and how a table is read.

Angles in radians, lengths in metres, moments in kilogram square metres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.physics.inertia import rod_about_end

Array = NDArray[np.float64]


def second_level(mass: float, lengths: Sequence[float], alpha: ArrayLike) -> Array:
    """J2*: a thin rod of length ``lengths[1]`` at the end of one of length ``lengths[0]``, bent by ``alpha``, about the first joint.

    m (l1^2 + l2^2 / 3 + l1 l2 cos alpha): the closed form of the sum over vertices in section 4.1.2, for parallel axes.
    """
    first, second = lengths
    return np.asarray(mass * (first**2 + second**2 / 3.0 + first * second * np.cos(alpha)), dtype=np.float64)


def third_level(mass: float, lengths: Sequence[float], alpha: ArrayLike, beta: ArrayLike) -> Array:
    """J3*: a third thin rod, bent by ``beta`` against the second, about the first joint.

    m l3^2 / 12 + m |l1 e(0) + l2 e(alpha) + l3 e(alpha + beta) / 2|^2 with e(t) = (cos t, sin t).
    """
    first, second, third = lengths
    alpha, whole = np.asarray(alpha, dtype=np.float64), np.asarray(alpha) + np.asarray(beta, dtype=np.float64)
    along = first + second * np.cos(alpha) + 0.5 * third * np.cos(whole)
    across = second * np.sin(alpha) + 0.5 * third * np.sin(whole)
    return np.asarray(mass * (third**2 / 12.0 + along**2 + across**2), dtype=np.float64)


def two_levels(mass: Sequence[float], lengths: Sequence[float], alpha: ArrayLike) -> Array:
    """J = J1 + J2*[alpha] of two rods about their first joint."""
    return np.asarray(rod_about_end(mass[0], lengths[0]) + second_level(mass[1], lengths, alpha), dtype=np.float64)


def three_levels(mass: Sequence[float], lengths: Sequence[float], alpha: ArrayLike, beta: ArrayLike) -> Array:
    """J = J1 + J2*[alpha] + J3*[alpha][beta] of three rods about their first joint.

    The straight index finger of the worked example, about its MCP joint:

    >>> J = three_levels((0.01192, 0.00556, 0.00304), (0.04259, 0.02514, 0.01798), 0.0, 0.0)
    >>> print(f"{J:.5e}")
    4.23923e-05
    """
    return two_levels(mass[:2], lengths[:2], alpha) + third_level(mass[2], lengths, alpha, beta)


def table_of(function: Callable[..., ArrayLike], *grids: ArrayLike) -> Array:
    """The values of ``function`` at all angles of the ``grids``: an array with one axis for each grid."""
    return np.asarray(function(*np.meshgrid(*grids, indexing="ij")), dtype=np.float64)


def nearest_entry(table: ArrayLike, low: ArrayLike, step: float, angles: ArrayLike) -> Array:
    """The entry of a table nearest to ``angles`` (..., axis), as in the paper. Entry 0 of each axis stands at ``low`` (axis,)."""
    table = np.asarray(table)
    at = _position(table, low, step, angles)
    return np.asarray(table[tuple(np.moveaxis(np.floor(at + 0.5).astype(np.int64), -1, 0))], dtype=np.float64)


def linear_entry(table: ArrayLike, low: ArrayLike, step: float, angles: ArrayLike) -> Array:
    """Linear interpolation between the entries around ``angles`` (..., axis); beyond the ends of a table its last entry holds."""
    table = np.asarray(table, dtype=np.float64)
    at = _position(table, low, step, angles)
    below = np.minimum(np.floor(at).astype(np.int64), np.array(table.shape) - 2)
    part = at - below
    result = np.zeros(at.shape[:-1])
    for corner in np.ndindex(*(2,) * table.ndim):
        share = np.prod(np.where(corner, part, 1.0 - part), axis=-1)
        result = result + share * table[tuple(np.moveaxis(below + np.array(corner), -1, 0))]
    return result


def _position(table: Array, low: ArrayLike, step: float, angles: ArrayLike) -> Array:
    """Where ``angles`` (..., axis) lie in the table, in steps, not beyond its ends."""
    if min(table.shape) < 2:
        raise ValueError(f"a table of shape {table.shape} has no two entries along one of its axes; give two or more angles")
    at = (np.atleast_1d(np.asarray(angles, dtype=np.float64)) - np.asarray(low)) / step
    return np.asarray(np.clip(at, 0.0, np.array(table.shape) - 1.0))
