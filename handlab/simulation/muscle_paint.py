"""Painting a muscle from code or a panel: points on the skin become a grid (Figure 4)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.grids import MuscleGrid
from handlab.anatomy.records import Array, Hand
from handlab.physics.distance import closest
from handlab.simulation.muscle_fit import fit

OFF = 0.004  # metres a painted point may lie from the skin


def paint(
    hand: Hand,
    name: str,
    points: ArrayLike,
    *,
    drives: str | tuple[str, ...],
    thickness: tuple[float, float],
    bones: Any,
    skin_distance: ArrayLike = 0.002,
    sources: tuple[str, ...] = ("painted",),
    **more: Any,
) -> MuscleGrid:
    """A grid from ``points`` (rows, columns, 3) on the skin in the bind posture, rows from origin to insertion, and tried on ``hand``.

    ``bones``: one name, or one entry for each row (a name, or two names with shares). Everything else as in ``MuscleGrid``.
    Raises ``ValueError`` for points off the skin and wherever the grid or its fit is bad; then nothing is kept.
    """
    wanted = np.array(points, dtype=np.float64)
    if wanted.ndim != 3 or wanted.shape[2] != 3 or not np.all(np.isfinite(wanted)):
        raise ValueError(f"the points of {name!r} have shape {wanted.shape}; give finite (rows, columns, 3) in metres")
    corners = np.ascontiguousarray(hand.skin.points[hand.skin.faces])
    distance, triangle, place = closest(np.ascontiguousarray(wanted.reshape(-1, 3)), corners)
    if len(distance) and distance.max() > OFF:
        raise ValueError(f"the muscle grid {name!r} lies off the skin: a point is {1e3 * distance.max():.0f} mm away; paint on the skin")
    grid = MuscleGrid(
        name=name,
        drives=(drives,) if isinstance(drives, str) else tuple(drives),
        triangle=triangle.reshape(wanted.shape[:2]),
        barycentric=barycentric(place, corners[triangle]).reshape(wanted.shape),
        thickness=thickness,
        skin_distance=np.asarray(skin_distance, dtype=np.float64),
        bones=bones,
        sources=sources,
        side=hand.side,
        **more,
    )
    for drive in grid.drives:
        hand.muscles[drive]  # an unknown one is answered with the nearest names
    fit(hand, grid)
    return grid


def barycentric(points: Array, corners: Array) -> Array:
    """Barycentric coordinates (n, 3) of places (n, 3) on triangles (n, 3, 3), not below 0, adding to 1, five digits."""
    u, v, w = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    uu, uv, vv = (np.einsum("ij,ij->i", a, b) for a, b in ((u, u), (u, v), (v, v)))
    wu, wv = np.einsum("ij,ij->i", w, u), np.einsum("ij,ij->i", w, v)
    det = uu * vv - uv * uv
    b, c = (vv * wu - uv * wv) / det, (uu * wv - uv * wu) / det
    two = np.clip(np.stack([1.0 - b - c, b], axis=1), 0.0, 1.0).round(5)
    two[:, 1] = np.minimum(two[:, 1], 1.0 - two[:, 0])
    return np.concatenate([two, 1.0 - two.sum(axis=1, keepdims=True)], axis=1)
