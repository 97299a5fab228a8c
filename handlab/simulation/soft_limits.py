"""Limits of the skin, once per frame: out of bone, no triangle inverted, no edge stretched too far (section 3.1)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.simulation import soft_hold_kernel as limits
from handlab.simulation.bone_field import REACH, bone_field
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skin import blend
from handlab.simulation.soft_skin_kernel import Node

LONGEST = 1.85  # times its rest length: no edge is longer at the end of a frame
LEAST_SHADOW = 0.1  # of a triangle's rest area, on its carried rest plane: one with less is turned back
PASSES, ROUNDS = 16, 12  # how often in a round; at most how many rounds of all limits
BONE_ROUNDS = 6  # rounds in which skin is pushed out of bone; where limits exclude each other, a whole skin comes before a deep bone
# Skin keeps this share of its rest distance from bone, at most so many metres: 1.5 mm of skin and 1 mm of extensor tendon or capsule
# below it, over the knuckles nothing else, are pressed together by no more than a tenth: assumption.
CLEARANCE, MOST_CLEARANCE = 0.9, 0.0025
NEAR_BONE = 0.015  # m: bones of the palm that come this near a node in the bind posture are asked for
POSTURES = 300  # random ones; from 100 to 300 of them add 2 in 100 pairs
OWN, FAR_BONE = 0.02, 0.020  # and within this reach those of bodies that have this weight in it


class Guard(NamedTuple):
    """Which bones are looked up where: the middle of nodes ``corner`` (p, 3), the ``body`` (p,), the ``clearance`` (p,) m that is kept.

    Those of body b are ``group[b]`` to ``group[b + 1]``; ``near`` (p,) is the clearance in units of the field.
    """

    corner: Node
    body: Node
    clearance: Array
    group: Index
    near: NDArray[np.int16]


@per_hand
def guard(hand: Hand) -> Guard:
    """Nodes and triangles, and the bodies whose bones they must stay out of: what moves them, and what is near in the bind posture.

    Of these pairs only those stay that blending alone brings within the reach of the bones' field, 5 mm, in any of many postures, most
    of them near limits: springs and muscles move skin along or away from bone, and a clearance is at most 2.5 mm.
    """
    from scipy.spatial import cKDTree

    points, faces = hand.skin.points, hand.skin.faces
    places = np.concatenate([points, points[faces].mean(axis=1)])
    corners = np.concatenate([np.repeat(np.arange(len(points))[:, None], 3, axis=1), faces])
    weights = np.concatenate([hand.skin.weights, hand.skin.weights[faces].mean(axis=1)])
    corner, body, clearance = [], [], []
    for b, name in enumerate(hand.body_names):
        bones = np.concatenate([bone.points[bone.faces].mean(axis=1) for bone in hand.bones.values() if bone.body == name])
        near = cKDTree(bones).query(places)[0]
        # Fingers cross in some postures: the skin of one must not be pushed out of its own bones by those of its neighbour.
        mine = np.flatnonzero(((weights[:, b] > OWN) & (near < FAR_BONE)) | ((near < NEAR_BONE) & ("phalanx" not in name)))
        corner.append(corners[mine])
        body.append(np.full(len(mine), b))
        clearance.append(np.minimum(CLEARANCE * near[mine], MOST_CLEARANCE))
    pairs = (frozen(np.concatenate(corner), np.uint32), frozen(np.concatenate(body), np.uint32), frozen(np.concatenate(clearance)))
    field, least, rng = bone_field(hand), np.full(len(pairs[1]), np.inf), np.random.default_rng(0)
    low, high = mechanics(hand).limits.T
    for k in range(POSTURES):
        angle = coupled(hand, low + rng.beta(0.5, 0.5, len(low)) * (high - low)) if k else hand.bind
        transforms = relative_transforms(hand, angle)
        position = np.ascontiguousarray(blend(hand, angle).T)
        limits.nearest_bone(position, transforms, pairs[0], pairs[1], *field[1:], least)
    kept = [frozen(v[least < 0.999 * REACH], v.dtype) for v in pairs]
    near = np.ceil(kept[2] / limits.UNIT)
    group = np.searchsorted(kept[1], np.arange(len(hand.body_names) + 1))
    return Guard(kept[0], kept[1], kept[2], frozen(group, np.int64), frozen(near, np.int16))
