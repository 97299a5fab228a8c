"""Where exactly the feature points lie on the skin.

A hand stores each feature point as the nearest point of its even skin, whose edges are 5 mm long: up to 3 mm beside the joint that
it marks. Whoever clicks a joint clicks above its centre, so there the mark belongs: where a ray from the centre leaves the skin.
"""

from __future__ import annotations

import numpy as np

from handlab.anatomy.records import Array, Hand, Index
from handlab.anatomy.terms import FINGERS
from handlab.simulation.kinematics import body_transforms, rotation
from handlab.simulation.per_hand import per_hand

JOINTS = ("mcp", "pip", "dip", "ip")


def exact_points(hand: Hand, view: str, names: tuple[str, ...]) -> Array:
    """Places (N, 3) m on the skin of ``hand`` that ``names`` mark in a picture of ``view``, in the bind posture.

    Joints: above the joint's centre, at right angles to the finger, in the direction of the stored point. All others: the stored point.
    """
    found = _all_points(hand)[view]
    points: Array = np.array([found[name] for name in names])
    return points


@per_hand
def _all_points(hand: Hand) -> dict[str, dict[str, Array]]:
    centres = bound_centres(hand)
    result: dict[str, dict[str, Array]] = {"palmar": {}, "dorsal": {}}
    for name, stored in hand.feature_points.items():
        for view, index in stored.items():
            point = hand.skin.points[index]
            kind, _, finger = name.partition("_")
            if kind in JOINTS and finger in FINGERS:
                centre = centres[f"{kind}{FINGERS.index(finger) + 1}"]
                along = hand.skin.points[hand.feature_points[f"tip_{finger}"][view]] - centre
                along = along / np.linalg.norm(along)
                out = point - centre
                out = out - along * (out @ along)
                point = leaves(hand.skin.points, hand.skin.faces, centre, out / np.linalg.norm(out), point)
            result[view][name] = point
    return result


def bound_centres(hand: Hand) -> dict[str, Array]:
    """Joint centres (3,) m where they lie in the bind posture."""
    bodies = dict(zip(hand.body_names, body_transforms(hand, hand.bind), strict=True))
    centres: dict[str, Array] = {}
    for name, joint in hand.joints.items():
        body = bodies[joint.parent]
        if name == "cmc1":  # it lies distal of the thumb's first axis and turns about it
            first = joint.dofs[0]
            body = body @ rotation(first.axis, first.anchor, float(hand.bind[hand.dof_names.index(first.name)]))
        centres[name] = body[:3, :3] @ joint.centre + body[:3, 3]
    return centres


def leaves(points: Array, faces: Index, origin: Array, direction: Array, otherwise: Array) -> Array:
    """Where the ray from ``origin`` in unit ``direction`` first meets the mesh (Moeller & Trumbore 1997); ``otherwise`` if nowhere."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    one, two = b - a, c - a
    p = np.cross(direction, two)
    determinant = np.einsum("ij,ij->i", one, p)
    flat = np.abs(determinant) < 1e-18
    inverse = 1.0 / np.where(flat, 1.0, determinant)
    u = np.einsum("ij,ij->i", origin - a, p) * inverse
    q = np.cross(origin - a, one)
    v, distance = (q @ direction) * inverse, np.einsum("ij,ij->i", two, q) * inverse
    meets = ~flat & (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9) & (distance > 1e-9)
    if not meets.any():
        return otherwise
    result: Array = origin + direction * distance[meets].min()
    return result
