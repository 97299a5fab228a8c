"""The bone that is nearest to a point in the bind posture: exactly, but without looking at bones whose box is further than another bone."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.physics.distance import closest, winding
from handlab.simulation.per_hand import per_hand

ROUNDING = 1e-9  # m


class _Bones(NamedTuple):
    """Triangles of every bone, its box from ``low`` to ``high`` (bones, 3), and a tree of all ``middles``."""

    corners: tuple[Array, ...]
    low: Array
    high: Array
    middles: Any


@per_hand
def _bones(hand: Hand) -> _Bones:
    from scipy.spatial import cKDTree

    every = hand.bones.values()
    corners = tuple(bone.points[bone.faces] for bone in every)
    low, high = (np.array([end(bone.points, axis=0) for bone in every]) for end in (np.min, np.max))
    return _Bones(corners, low, high, cKDTree(np.concatenate(corners).mean(axis=1)))


def nearest_bone(hand: Hand, points: Array) -> tuple[Array, Array, Index]:
    """Nearest place on bone (n, 3) of ``points`` (n, 3), its distance (n,) m, and which of ``hand.bones`` that is (n,)."""
    bones = _bones(hand)
    most = bones.middles.query(points)[0]
    outside = np.maximum(np.maximum(bones.low[:, None] - points, points - bones.high[:, None]), 0.0)
    near = np.linalg.norm(outside, axis=2) <= most + ROUNDING
    place, distance, nearest = np.empty_like(points), np.full(len(points), np.inf), np.zeros(len(points), np.int64)
    for bone in np.flatnonzero(near.any(axis=1)):
        row = np.flatnonzero(near[bone])
        away, _, foot = closest(points[row], bones.corners[bone])
        less = away < distance[row]
        row = row[less]
        place[row], distance[row], nearest[row] = foot[less], away[less], bone
    return place, distance, nearest


@per_hand
def bodies(hand: Hand) -> Index:
    """The body (bones,) of each of ``hand.bones``."""
    result: Index = frozen([hand.body_names.index(bone.body) for bone in hand.bones.values()], np.int64)
    return result


def in_bone(hand: Hand, points: Array) -> Array:
    """Whether each of ``points`` (n, 3) lies in a bone."""
    bones = _bones(hand)
    within = np.all((points > bones.low[:, None]) & (points < bones.high[:, None]), axis=2)
    inside = np.zeros(len(points), dtype=bool)
    for bone in np.flatnonzero(within.any(axis=1)):
        inside[within[bone]] |= winding(points[within[bone]], bones.corners[bone]) > 0.5
    return inside
