"""What a painter of muscle grids need not do by hand: places on the skin over a place inside, more rows, the bones below them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.physics.distance import closest
from handlab.simulation.bones_below import nearest_bone
from handlab.simulation.geometric_kernel import first_hit

OUTSIDE = 0.5  # metres: from so far away nothing of the hand lies behind

Carriers = Mapping[str, float]


def on_skin(hand: Hand, points: ArrayLike) -> Array:
    """The nearest places (..., 3) on the even skin in the bind posture."""
    wanted = np.asarray(points, dtype=np.float64)
    corners = np.ascontiguousarray(hand.skin.points[hand.skin.faces])
    return closest(np.ascontiguousarray(wanted.reshape(-1, 3)), corners)[2].reshape(wanted.shape)


def skin_over(hand: Hand, points: ArrayLike, way: ArrayLike = (0.0, 1.0, 0.0)) -> Array:
    """The skin (..., 3) that an eye far away along ``way`` (3,) sees in front of ``points`` (..., 3), metres, bind posture.

    ``way`` points from the hand to the eye; not given, the eye looks at the palm. Raises ``ValueError`` where no skin is in front.
    """
    wanted, to_eye = np.asarray(points, dtype=np.float64), np.asarray(way, dtype=np.float64)
    to_eye = to_eye / np.linalg.norm(to_eye)
    start = np.ascontiguousarray(wanted.reshape(-1, 3) + OUTSIDE * to_eye)
    far = first_hit(start, np.tile(-to_eye, (len(start), 1)), np.ascontiguousarray(hand.skin.points[hand.skin.faces]))[0]
    if not np.all(np.isfinite(far)):
        k = int(np.argmin(np.isfinite(far)))
        raise ValueError(f"no skin lies over the point {1e3 * wanted.reshape(-1, 3)[k].round(4)} mm; look from another side")
    result: Array = (start - far[:, None] * to_eye).reshape(wanted.shape)
    return result


def finer_points(hand: Hand, points: ArrayLike, finer: int) -> Array:
    """Rows (rows, columns, 3) with ``finer`` - 1 more between every two, on a smooth curve through them, laid on the skin."""
    painted = np.asarray(points, dtype=np.float64)
    steps = np.linalg.norm(np.diff(painted, axis=0), axis=2).mean(axis=1)
    if finer <= 1 or len(painted) < 2 or steps.min() < 1e-6:
        return on_skin(hand, painted)
    from scipy.interpolate import make_interp_spline

    at = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.concatenate([np.linspace(a, b, finer, endpoint=False) for a, b in pairwise(at)] + [at[-1:]])
    curve = make_interp_spline(at, painted, k=min(3, len(at) - 1))(wanted)
    return on_skin(hand, curve)


def finer_values(values: ArrayLike, finer: int) -> Array:
    """One number per row, on straight lines between rows, for the rows of ``finer_points``."""
    given = np.asarray(values, dtype=np.float64)
    rows = np.arange(len(given))
    return np.interp(np.linspace(0.0, len(given) - 1.0, finer * (len(given) - 1) + 1), rows, given)


def finer_bones(bones: Sequence[Carriers], finer: int) -> tuple[Carriers, ...]:
    """Bones with shares for the rows of ``finer_points``: a row between two others follows the bones of both, at most two."""
    made: list[Carriers] = []
    for one, other in pairwise(bones):
        for k in range(finer):
            part = k / finer
            mixed = {name: (1.0 - part) * one.get(name, 0.0) + part * other.get(name, 0.0) for name in {**one, **other}}
            kept = sorted((name for name in mixed if mixed[name] > 0.0), key=lambda name: -mixed[name])[:2]
            total = sum(mixed[name] for name in kept)
            made.append({name: mixed[name] / total for name in kept})
    return (*made, bones[-1])


def nearest_bones(hand: Hand, points: ArrayLike) -> tuple[str, ...]:
    """For each row of ``points`` (rows, columns, 3) the bone that comes nearest to it, in the bind posture."""
    wanted = np.asarray(points, dtype=np.float64)
    _, distance, bone = nearest_bone(hand, wanted.reshape(-1, 3))
    best = distance.reshape(wanted.shape[:2]).argmin(axis=1)
    names = tuple(hand.bones)
    return tuple(names[k] for k in bone.reshape(wanted.shape[:2])[np.arange(len(wanted)), best])
