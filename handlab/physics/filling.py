"""Points of an even grid inside a closed mesh: every column of the grid meets the surface in pairs of crossings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]

MOST = 64  # crossings of one column


def filled(points: Array, faces: Index, step: float) -> Array:
    """Grid points (K, 3) with spacing ``step`` inside the closed mesh ``points`` (N, 3), ``faces`` (M, 3).

    The first cell touches the lowest corner of the mesh. Raises ``ValueError`` for a mesh that a line meets more than 64 times.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    count = np.ceil((high - low) / step).astype(np.int64) + 1
    crossing, number = np.empty((count[0], count[2], MOST)), np.zeros((count[0], count[2]), dtype=np.int64)
    corners = np.array(points[faces], order="C")
    corners.setflags(write=False)
    _cross(corners, low + 0.5 * step, step, crossing, number)
    most = int(number.max(initial=0))
    if most > MOST:
        raise ValueError(f"a line meets the mesh {most} times; it is no skin")
    sorted_crossing = np.sort(np.where(np.arange(most) < number[:, :, None], crossing[:, :, :most], np.inf), axis=2)
    y = low[1] + step * (np.arange(count[1]) + 0.5)
    below = (sorted_crossing[:, None, :, :] < y[None, :, None, None]).sum(axis=3)
    i, j, k = np.nonzero(below % 2 == 1)
    result: Array = low + step * (np.stack([i, j, k], axis=1) + 0.5)
    return result


@compiled
def _cross(corners: Array, origin: Array, step: float, crossing: Array, number: Index) -> None:
    """Where the lines along y through the grid meet each triangle (M, 3, 3)."""
    for t in range(corners.shape[0]):
        ax, az, bx, bz, cx, cz = corners[t, 0, 0], corners[t, 0, 2], corners[t, 1, 0], corners[t, 1, 2], corners[t, 2, 0], corners[t, 2, 2]
        area = (bx - ax) * (cz - az) - (bz - az) * (cx - ax)
        if area == 0.0:
            continue
        i0 = max(0, int(np.ceil((min(ax, bx, cx) - origin[0]) / step)))
        i1 = min(crossing.shape[0] - 1, int(np.floor((max(ax, bx, cx) - origin[0]) / step)))
        k0 = max(0, int(np.ceil((min(az, bz, cz) - origin[2]) / step)))
        k1 = min(crossing.shape[1] - 1, int(np.floor((max(az, bz, cz) - origin[2]) / step)))
        for i in range(i0, i1 + 1):
            for k in range(k0, k1 + 1):
                px, pz = origin[0] + i * step, origin[2] + k * step
                u = ((px - ax) * (cz - az) - (pz - az) * (cx - ax)) / area
                v = ((bx - ax) * (pz - az) - (bz - az) * (px - ax)) / area
                if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                    if number[i, k] < crossing.shape[2]:
                        ay, by, cy = corners[t, 0, 1], corners[t, 1, 1], corners[t, 2, 1]
                        crossing[i, k, number[i, k]] = ay + u * (by - ay) + v * (cy - ay)
                    number[i, k] += 1
