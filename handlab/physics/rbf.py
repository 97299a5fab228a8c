"""The biharmonic warp of section 5.2: a smooth map that takes given points to given places.

f(x) = sum_i w_i |x - s_i| + A x + b with f(s_i) = t_i, sum_i w_i = 0 and sum_i w_i s_i' = 0 (the side conditions keep affine maps
out of the sum, so an affine map is returned as it is). Arrays in, arrays out; any unit of length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

FLAT = 1e-7  # of the largest spread: points thinner than this lie in one plane, on one line, or at one place
SAME = 1e-9  # of the largest spread: points nearer than this are one point


class Warp(NamedTuple):
    """``centre`` (N, 3) s_i, ``weight`` (N, 3) w_i, ``linear`` (3, 3) A, ``shift`` (3,) b.

    ``rank``: in how many dimensions the centres spread. Below 3 the missing columns of A were chosen rigidly (see ``fitted``).
    """

    centre: Array
    weight: Array
    linear: Array
    shift: Array
    rank: int

    def __call__(self, points: ArrayLike) -> Array:
        """f at ``points`` (..., 3)."""
        return warped(self, points)


def fitted(source: ArrayLike, target: ArrayLike, smoothing: ArrayLike = 0.0) -> Warp:
    """The warp with f(source) = target; both (N, 3), N >= 1. One symmetric system of N + 4 with three right-hand sides.

    ``smoothing`` (N,) or one number, a length >= 0: how softly each point is held, f(s_i) = t_i + smoothing_i w_i; the larger it is, the
    more its weight w_i costs, and noise of close points is smoothed (Wahba 1990). 0 hits the point.

    Points are centred and brought to unit size before solving. Four points that are not in one plane determine A. Where there are
    none, the side conditions span only the plane (or line, or point) of the sources, and A continues across it as a similarity:
    by the normal of the warped plane, with the plane's own mean magnification.
    Raises ``ValueError`` for shapes that do not fit, values that are not finite, smoothing below 0, and two sources at one place.

    >>> corner = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> warp = fitted(corner, 2.0 * np.array(corner) + 1.0)
    >>> warp([[3.0, 4.0, 5.0]]).round(9)
    array([[ 7.,  9., 11.]])
    """
    s, t = np.asarray(source, dtype=np.float64), np.asarray(target, dtype=np.float64)
    if s.ndim != 2 or s.shape[1:] != (3,) or s.shape != t.shape or len(s) == 0:
        raise ValueError(f"source {s.shape} and target {t.shape} must both be (N, 3) with N >= 1")
    if not (np.isfinite(s).all() and np.isfinite(t).all()):
        raise ValueError("source and target must be finite numbers")
    loose = np.broadcast_to(np.asarray(smoothing, dtype=np.float64), len(s))
    if not ((loose >= 0.0) & np.isfinite(loose)).all():
        raise ValueError("smoothing must be one length, or one for each point, and none below 0")
    centre, goal = s.mean(axis=0), t.mean(axis=0)
    size = float(np.sqrt(np.mean(np.sum((s - centre) ** 2, axis=1)))) or 1.0
    x, y = (s - centre) / size, (t - goal) / size
    spread, axes = np.linalg.svd(x, full_matrices=True)[1:] if len(x) > 1 else (np.zeros(1), np.eye(3))
    rank = int(np.sum(spread > FLAT * max(float(spread[0]), 1.0)))
    distance = np.linalg.norm(x[:, None] - x, axis=2)
    np.fill_diagonal(distance, np.inf)
    if distance.min() <= SAME:
        i, j = np.unravel_index(int(distance.argmin()), distance.shape)
        raise ValueError(f"source points {min(i, j)} and {max(i, j)} lie at one place; leave one of them out")
    np.fill_diagonal(distance, -loose / size)
    seen = axes[:rank]  # directions in which the sources spread
    p = np.hstack([np.ones((len(x), 1)), x @ seen.T])
    matrix = np.block([[distance, p], [p.T, np.zeros((rank + 1, rank + 1))]])
    solved = np.linalg.solve(matrix, np.vstack([y, np.zeros((rank + 1, 3))]))
    w, b, columns = solved[: len(x)], solved[len(x)], solved[len(x) + 1 :]
    linear = columns.T @ seen + _across(columns, axes, rank)
    # back to the units and the origin that were given: |x - s| / size, (x - centre) / size, all times size
    return Warp(s.copy(), w, linear, goal + size * b - linear @ centre, rank)


def _across(columns: Array, axes: Array, rank: int) -> Array:
    """What A does to directions in which the sources do not spread, so that the whole is as near to a similarity as can be."""
    if rank == 3:
        return np.zeros((3, 3))
    if rank == 0:
        return np.eye(3)
    # images of the seen directions, completed to a rotation of the same handedness
    left, stretch, right = np.linalg.svd(columns.T, full_matrices=True)
    whole = np.eye(3)
    whole[:rank, :rank] = right
    before = whole @ axes
    if np.linalg.det(left) * np.linalg.det(before) < 0.0:
        left = left * np.array([1.0, 1.0, -1.0])
    scale = float(np.exp(np.mean(np.log(np.maximum(stretch[:rank], 1e-12)))))
    result: Array = scale * left[:, rank:] @ before[rank:]
    return result


def warped(warp: Warp, points: ArrayLike) -> Array:
    """f at ``points`` (..., 3). Raises ``ValueError`` for points of another shape."""
    from handlab.physics.rbf_kernel import evaluate  # compiled code, not needed to import this module

    x = np.ascontiguousarray(points, dtype=np.float64)
    if x.shape[-1] != 3:
        raise ValueError(f"points {np.shape(points)} must be (..., 3)")
    flat = x.reshape(-1)
    flat.setflags(write=False)  # kernels are compiled anew for arrays that can be written
    out = np.empty(x.shape)
    evaluate(flat, *_arrays(warp), out.reshape(-1))
    return out


def jacobian(warp: Warp, points: ArrayLike) -> Array:
    """Derivatives (..., 3, 3) of f at ``points`` (..., 3); where the determinant is negative the warp has folded."""
    from handlab.physics.rbf_kernel import jacobian as kernel

    x = np.asarray(points, dtype=np.float64)
    flat = np.ascontiguousarray(x.reshape(-1, 3))
    flat.setflags(write=False)
    out = np.empty((len(flat), 3, 3))
    centre, weight, linear, _ = _arrays(warp)
    kernel(flat, centre, weight, linear, out)
    return out.reshape(*x.shape[:-1], 3, 3)


def warped_numpy(warp: Warp, points: ArrayLike) -> Array:
    """``warped`` in two lines of numpy, for reading and for testing the compiled one; ``points`` (M, 3)."""
    x = np.asarray(points, dtype=np.float64)
    result: Array = np.linalg.norm(x[:, None] - warp.centre, axis=2) @ warp.weight + x @ warp.linear.T + warp.shift
    return result


def _arrays(warp: Warp) -> tuple[Array, Array, Array, Array]:
    arrays = tuple(np.array(values, dtype=np.float64, order="C") for values in warp[:4])
    for array in arrays:
        array.setflags(write=False)
    return arrays  # type: ignore[return-value]
