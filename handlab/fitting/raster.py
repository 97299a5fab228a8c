"""Triangles cut into pixels: which triangle covers a pixel, where in it the pixel's middle lies, and which lies in front."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.meshes import Array, Index

EDGE = -1e-9  # a pixel's middle on the common side of two triangles belongs to both


def pixels(points_px: Array, faces: Index, shape: tuple[int, int], margin: float = 0.0) -> tuple[Index, Index, Index, Array]:
    """All pairs of a triangle and a pixel whose middle it covers: row (K,), column (K,), triangle (K,), barycentric (K, 3).

    ``points_px`` (N, 2) or (M, 3, 2) per corner, (x, y) in pixels, (0, 0) the top left corner; ``faces`` (M, 3); ``shape`` (rows, columns).
    ``margin``: barycentric coordinates down to this much below zero count as covered.
    """
    corner = np.asarray(points_px, np.float64)
    corner = corner[faces] if corner.ndim == 2 else corner
    bound = np.array([shape[1], shape[0]])
    side = np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], axis=2)  # (M, 2, 2)
    determinant = side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0]
    fits = np.isfinite(corner).all(axis=(1, 2)) & (np.abs(determinant) > 1e-12)
    spare = margin * np.where(fits[:, None], np.ptp(np.where(fits[:, None, None], corner, 0.0), axis=1), 0.0)
    low = np.where(fits[:, None], corner.min(axis=1) - spare, 1.0)
    high = np.where(fits[:, None], corner.max(axis=1) + spare, 0.0)
    first = np.clip(np.ceil(low - 0.5), 0, bound).astype(np.int64)
    last = np.clip(np.floor(high - 0.5), -1, bound - 1).astype(np.int64)
    size = np.maximum(last - first + 1, 0)
    count = size[:, 0] * size[:, 1]
    triangle = np.repeat(np.arange(len(corner)), count)
    number = np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    row = first[triangle, 1] + number // np.maximum(size[triangle, 0], 1)
    column = first[triangle, 0] + number % np.maximum(size[triangle, 0], 1)
    x, y = column + 0.5 - corner[triangle, 0, 0], row + 0.5 - corner[triangle, 0, 1]
    d = determinant[triangle]
    b = (x * side[triangle, 1, 1] - y * side[triangle, 0, 1]) / d
    c = (y * side[triangle, 0, 0] - x * side[triangle, 1, 0]) / d
    a = 1.0 - b - c
    covered = (a >= EDGE - margin) & (b >= EDGE - margin) & (c >= EDGE - margin)
    return row[covered], column[covered], triangle[covered], np.stack([a[covered], b[covered], c[covered]], axis=1)


def foremost(points_px: Array, height: Array, faces: Index, shape: tuple[int, int]) -> tuple[NDArray[np.int64], Array]:
    """The triangle in front at every pixel (rows, columns), -1 where there is none, and its height there (-inf).

    ``height`` (N,): how near each point is to the camera, larger is nearer.
    """
    row, column, triangle, barycentric = pixels(points_px, faces, shape)
    near = np.einsum("ij,ij->i", barycentric, height[faces[triangle]])
    order = np.argsort(near, kind="stable")  # the nearest is written last
    front, level = np.full(shape, -1, np.int64), np.full(shape, -np.inf)
    front[row[order], column[order]] = triangle[order]
    level[row[order], column[order]] = near[order]
    return front, level
