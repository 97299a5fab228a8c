"""What a posture is, measured on the skin and the bones: pulps, gaps, facing, flesh in flesh, bone in bone.

These numbers check the named clips; nothing here moves the hand. Lengths in metres, angles in radians.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, Index
from handlab.anatomy.terms import DIGITS
from handlab.physics.distance import closest, winding
from handlab.simulation.kinematics import body_transforms, posed_bone
from handlab.simulation.per_hand import per_hand

PULP_WEIGHT = 0.9  # skin of a distal phalanx that moves with nothing else
PULP_FACING = 0.35  # cosine: skin that faces palmar
THICKNESS = 0.008  # behind an open patch of skin, but nearer than this: inside the digit; farther: just elsewhere
PALM = ("carpus", "metacarpal_1", "metacarpal_4", "metacarpal_5")
OUTWARD = 0.0003  # a point this far outside its own skin is asked whether it lies in other skin


def digit_number(digit: str | int) -> int:
    """1 to 5 from a name or a number."""
    return digit if isinstance(digit, int) else DIGITS[digit]


def vertex_normals(points: Array, faces: Index) -> Array:
    """Unit normals (N, 3), faces weighted by area."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for i in range(3):
        np.add.at(normals, faces[:, i], area)
    result: Array = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return result


@per_hand
def pulps(hand: Hand) -> dict[int, Index]:
    """Skin points of each digit's pulp: the palmar side of the distal phalanx."""
    normals = vertex_normals(hand.skin.points, hand.skin.faces)
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
        mine = hand.skin.weights[:, body] > PULP_WEIGHT
        beyond = (hand.skin.points - bone.mean(axis=0)) @ distal > -0.2 * float(distal @ distal)
        found[k] = np.flatnonzero(mine & beyond & (normals @ palmar > PULP_FACING))
    return found


@per_hand
def segment_faces(hand: Hand) -> dict[str, Index]:
    """Triangles of the skin whose corners move mainly with a body."""
    main = hand.skin.weights.argmax(axis=1)
    return {name: np.flatnonzero((main[hand.skin.faces] == i).any(axis=1)) for i, name in enumerate(hand.body_names)}


def signed_distance(points: Array, corners: Array) -> Array:
    """Distance (N,) to triangles (M, 3, 3), negative close behind the nearest one."""
    distance, triangle, place = closest(np.ascontiguousarray(points), np.ascontiguousarray(corners))
    t = corners[triangle]
    normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    behind = (np.einsum("ij,ij->i", points - place, normal) < 0.0) & (distance < THICKNESS)
    result: Array = np.where(behind, -distance, distance)
    return result


def pulp_gap(hand: Hand, skin: Array, first: int, second: int) -> float:
    """Least signed distance between the skin of two fingertips; negative where they overlap."""
    one, two = (skin[hand.skin.faces[segment_faces(hand)[f"distal_phalanx_{k}"]]] for k in (first, second))
    return float(min(signed_distance(skin[pulps(hand)[first]], two).min(), signed_distance(skin[pulps(hand)[second]], one).min()))


def pulp_normal(hand: Hand, skin: Array, k: int) -> Array:
    """Mean outward direction of a pulp."""
    normal = vertex_normals(skin, hand.skin.faces)[pulps(hand)[k]].mean(axis=0)
    result: Array = normal / np.linalg.norm(normal)
    return result


def facing(hand: Hand, skin: Array, first: int, second: int) -> float:
    """Angle between one pulp's normal and the reverse of the other's: 0 when pulp meets pulp squarely."""
    return float(np.arccos(np.clip(-pulp_normal(hand, skin, first) @ pulp_normal(hand, skin, second), -1.0, 1.0)))


def pulp_to_bodies(hand: Hand, skin: Array, k: int, bodies: tuple[str, ...]) -> float:
    """Least signed distance from a pulp to the skin that moves mainly with these bodies."""
    patch = np.concatenate([segment_faces(hand)[name] for name in bodies])
    return float(signed_distance(skin[pulps(hand)[k]], skin[hand.skin.faces[patch]]).min())


def pulp_to_palm(hand: Hand, skin: Array, k: int) -> float:
    """Least distance from a pulp to the skin that moves with the carpus and metacarpals."""
    return pulp_to_bodies(hand, skin, k, PALM)


def flesh_depth(hand: Hand, skin: Array) -> Array:
    """How deep each skin point (N,) lies inside another part of the skin; 0 for most.

    A point just outside its own skin that the skin still winds about lies in other flesh; its depth is the distance to
    the nearest skin that faces it.
    """
    faces = hand.skin.faces
    normals = vertex_normals(skin, faces)
    corners = np.ascontiguousarray(skin[faces])
    inside = winding(skin + OUTWARD * normals, corners) > 0.5
    depth = np.zeros(len(skin))
    face_normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for i in np.flatnonzero(inside):
        facing_it = face_normal @ normals[i] < 0.0
        depth[i] = closest(skin[i : i + 1], np.ascontiguousarray(corners[facing_it]))[0][0] if facing_it.any() else 0.0
    return depth


def bone_depths(hand: Hand, angle: ArrayLike) -> dict[tuple[str, str], float]:
    """Pairs of bones on different bodies that enter one another, and how deep."""
    posed = {name: posed_bone(hand, name, np.asarray(angle, dtype=np.float64)) for name in hand.bones}
    low, high = {n: p.min(axis=0) for n, p in posed.items()}, {n: p.max(axis=0) for n, p in posed.items()}
    found = {}
    names = list(posed)
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            if hand.bones[a].body == hand.bones[b].body or (low[a] > high[b]).any() or (low[b] > high[a]).any():
                continue
            depth = max(_deepest(posed[a], posed[b][hand.bones[b].faces]), _deepest(posed[b], posed[a][hand.bones[a].faces]))
            if depth > 0.0:
                found[a, b] = depth
    return found


def _deepest(points: Array, corners: Array) -> float:
    corners = np.ascontiguousarray(corners)
    inside = winding(np.ascontiguousarray(points), corners) > 0.5
    return float(closest(points[inside], corners)[0].max()) if inside.any() else 0.0
