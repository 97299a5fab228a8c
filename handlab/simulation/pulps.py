"""The pulps of the fingers: what touches when thumb and finger meet."""

from __future__ import annotations

import numpy as np

from handlab.anatomy.records import Array, Hand, Index
from handlab.simulation.kinematics import body_transforms, relative_transforms
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skin import normals

WEIGHT = 0.9  # skin of a distal phalanx that moves with nothing else
FACING = 0.35  # cosine: skin that faces palmar


@per_hand
def pulps(hand: Hand) -> dict[int, Index]:
    """Skin points of each digit's pulp: the palmar side of the distal phalanx."""
    outwards = normals(hand, hand.skin.points)
    bind = body_transforms(hand, hand.bind)
    found = {}
    for k in range(1, 6):
        body = hand.body_names.index(f"distal_phalanx_{k}")
        dof = hand.dofs[f"{'ip' if k == 1 else 'dip'}{k}.flexion_extension"]
        axis = bind[body][:3, :3] @ dof.axis
        bone = hand.bones[f"distal_phalanx_{k}"].points
        joint = bind[body][:3, :3] @ dof.anchor + bind[body][:3, 3]
        distal = bone.mean(axis=0) - joint
        palmar = np.cross(axis, distal)
        palmar /= np.linalg.norm(palmar)
        mine = hand.skin.weights[:, body] > WEIGHT
        beyond = (hand.skin.points - bone.mean(axis=0)) @ distal > -0.2 * float(distal @ distal)
        found[k] = np.flatnonzero(mine & beyond & (outwards @ palmar > FACING))
    return found


def pulp_centres(hand: Hand, angle: Array) -> Array:
    """Middles (5, 3) m of the pulps, thumb to little finger, in a posture (dof,)."""
    moved = relative_transforms(hand, angle)
    frames = [moved[hand.body_names.index(f"distal_phalanx_{k}")] for k in range(1, 6)]
    return np.array([frame[:3, :3] @ middle + frame[:3, 3] for frame, middle in zip(frames, _middles(hand), strict=True)])


@per_hand
def _middles(hand: Hand) -> Array:
    return np.array([hand.skin.points[points].mean(axis=0) for points in pulps(hand).values()])
