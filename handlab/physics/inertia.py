"""Moments of inertia of bones: equation (5) and the chains of section 4.1.2.

Mass in kilograms, lengths in metres, moments in kilogram square metres.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def rod_about_end(mass: ArrayLike, length: ArrayLike) -> Array:
    """m l^2 / 3: equation (5). The paper calls it a solid cylinder; it is a thin rod about its end."""
    return np.asarray(mass) * np.asarray(length, dtype=np.float64) ** 2 / 3.0


def cylinder_about_end(mass: ArrayLike, length: ArrayLike, radius: ArrayLike) -> Array:
    """m l^2 / 3 + m r^2 / 4: a solid cylinder about a diameter of its end face, the sound reading of (5)."""
    return rod_about_end(mass, length) + np.asarray(mass) * np.asarray(radius, dtype=np.float64) ** 2 / 4.0


def rod_tensor(mass: float, ends: ArrayLike) -> Array:
    """Inertia tensor (3, 3) of a thin rod about its middle; ``ends`` (2, 3)."""
    start, end = np.asarray(ends, dtype=np.float64)
    along = end - start
    tensor: Array = mass / 12.0 * (np.dot(along, along) * np.eye(3) - np.outer(along, along))
    return tensor


def from_points(mass: float, points: ArrayLike, axis: ArrayLike, anchor: ArrayLike, *, literal: bool = False) -> float:
    """Sum of squared distances of mesh points (N, 3) to the axis: J* of section 4.1.2.

    ``literal`` multiplies every point by the whole mass, as printed, and grows with the number of points;
    otherwise every point carries mass / N.
    """
    points = np.asarray(points, dtype=np.float64)
    square = np.sum(np.cross(points - np.asarray(anchor), np.asarray(axis, dtype=np.float64)) ** 2)
    return float(mass * square) if literal else float(mass * square / len(points))


def composite_about_axis(mass: ArrayLike, centre: ArrayLike, inertia: ArrayLike, axis: ArrayLike, anchor: ArrayLike) -> float:
    """Moment of inertia of rigid bodies that turn together about one axis: J of a chain of any length (section 4.1.2).

    sum over bodies of a'I a + m |(centre - anchor) x a|^2 (parallel axis theorem) in the present pose, where the paper
    looks up a table. ``mass`` (body,), ``centre`` (body, 3), ``inertia`` (body, 3, 3) about each centre, unit ``axis`` (3,),
    ``anchor`` (3,) a point of the axis.
    """
    axis = np.asarray(axis, dtype=np.float64)
    own = np.einsum("i,bij,j->", axis, np.asarray(inertia, dtype=np.float64), axis)
    away = np.cross(np.asarray(centre, dtype=np.float64) - np.asarray(anchor), axis)
    return float(own + np.sum(np.asarray(mass) * np.sum(away**2, axis=-1)))


def turned_tensor(inertia: ArrayLike, rotation: ArrayLike) -> Array:
    """R I R': the tensor (..., 3, 3) of a body after a turn by ``rotation`` (..., 3, 3), a similarity transform."""
    rotation = np.asarray(rotation, dtype=np.float64)
    result: Array = rotation @ np.asarray(inertia, dtype=np.float64) @ np.swapaxes(rotation, -1, -2)
    return result


def shifted_tensor(mass: ArrayLike, inertia: ArrayLike, offset: ArrayLike) -> Array:
    """I + m (|d|^2 1 - d d'): the tensor (..., 3, 3) about a point at ``offset`` d (..., 3) from the centre (parallel axis theorem)."""
    d = np.asarray(offset, dtype=np.float64)
    square = np.sum(d**2, axis=-1)[..., None, None] * np.eye(3) - d[..., :, None] * d[..., None, :]
    result: Array = np.asarray(inertia, dtype=np.float64) + np.asarray(mass, dtype=np.float64)[..., None, None] * square
    return result


def composite_tensor(
    mass: ArrayLike, centre: ArrayLike, inertia: ArrayLike, about: ArrayLike, *, rotation: ArrayLike | None = None
) -> Array:
    """Inertia tensor (3, 3) of rigid bodies that turn together, about the point ``about`` (3,): chains of any length, any axis.

    What the paper leaves as future work: tensors add up where scalar moments need a table for every axis. ``mass`` (body,),
    ``centre`` (body, 3) in the present pose, ``inertia`` (body, 3, 3) about each centre; with ``rotation`` (body, 3, 3) these
    are written in each body's own frame and turned into the pose first. For an axis a through ``about``, J = a' I a.
    """
    tensors = np.asarray(inertia, dtype=np.float64) if rotation is None else turned_tensor(inertia, rotation)
    result: Array = shifted_tensor(mass, tensors, np.asarray(centre, dtype=np.float64) - np.asarray(about)).sum(axis=0)
    return result
