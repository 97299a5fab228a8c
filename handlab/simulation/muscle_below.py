"""Which muscle lies below a place on the skin: the first ellipsoid on the way inwards, unless bone comes before (Figure 4)."""

from __future__ import annotations

import numpy as np

from handlab.anatomy.records import Array, Hand, Index
from handlab.simulation.geometric_kernel import first_hit
from handlab.simulation.geometric_muscle import Ellipsoids, GeometricMuscles
from handlab.simulation.muscle_fit import bone_corners, checked_skin

DEEP = 0.012  # metres: a muscle deeper than this is not felt at the skin (assumption)


def hits(ellipsoids: Ellipsoids, start: Array, way: Array) -> tuple[Array, Index]:
    """Distance (n,) and ellipsoid (n,) that rays from ``start`` (n, 3) along unit ``way`` (n, 3) meet first; infinity and -1 if none.

    A ray that starts inside an ellipsoid meets it at distance 0.
    """
    centre, frame, half = ellipsoids
    local = np.einsum("nsd,sdk->nsk", start[:, None] - centre, frame) / half
    along = np.einsum("nd,sdk->nsk", way, frame) / half
    a, b, c = (along**2).sum(axis=2), (local * along).sum(axis=2), (local**2).sum(axis=2) - 1.0
    root = b * b - a * c
    with np.errstate(invalid="ignore"):
        near = (-b - np.sqrt(root)) / a
    far = np.where(c <= 0.0, 0.0, np.where((root >= 0.0) & (near > 0.0), near, np.inf))
    first = far.argmin(axis=1)
    distance = far[np.arange(len(far)), first]
    return distance, np.where(np.isfinite(distance), first, -1)


def below(hand: Hand, muscles: GeometricMuscles) -> tuple[Array, Index]:
    """Depth (N,) and ellipsoid (N,) of the muscle below every point of the skin in the bind posture; infinity and -1 where none is."""
    start, way = hand.skin.points, np.ascontiguousarray(-checked_skin(hand))
    distance, ellipsoid = hits(muscles.rest, start, way)
    bone = first_hit(start, way, bone_corners(hand))[0]
    hidden = (distance > np.minimum(bone, DEEP)) | (ellipsoid < 0)
    return np.where(hidden, np.inf, distance), np.where(hidden, -1, ellipsoid)


def influenced(hand: Hand, muscles: GeometricMuscles, name: str) -> Index:
    """Skin points that one muscle influences: those below which it lies, whatever lies between."""
    part = muscles.of(name)
    own = Ellipsoids(*(values[part] for values in muscles.rest))
    start, way = hand.skin.points, np.ascontiguousarray(-checked_skin(hand))
    distance, _ = hits(own, start, way)
    bone = first_hit(start, way, bone_corners(hand))[0]
    return np.flatnonzero(distance < np.minimum(bone, DEEP))
