"""What a posture is, measured on the skin and the bones: pulps, gaps, facing, flesh in flesh, bone in bone.

These numbers check the named clips; nothing here moves the hand. Lengths in metres, angles in radians.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, Index
from handlab.anatomy.terms import DIGITS
from handlab.physics.distance import closest, winding
from handlab.simulation.kinematics import posed_bone
from handlab.simulation.per_hand import per_hand
from handlab.simulation.pulps import pulps as pulps

THICKNESS = 0.008  # a point farther than this behind a patch of skin is on its other side, not in it
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
def segment_faces(hand: Hand) -> dict[str, Index]:
    """Triangles of the skin whose corners move mainly with a body."""
    main = hand.skin.weights.argmax(axis=1)
    return {name: np.flatnonzero((main[hand.skin.faces] == i).any(axis=1)) for i, name in enumerate(hand.body_names)}


def skin_distance(hand: Hand, skin: Array, points: Index, triangles: Index) -> Array:
    """Distance from skin points to some triangles of the skin, negative where a point lies in flesh behind them."""
    corners = np.ascontiguousarray(skin[hand.skin.faces[triangles]])
    place = np.ascontiguousarray(skin[points])
    distance, triangle, near = closest(place, corners)
    t = corners[triangle]
    behind = np.einsum("ij,ij->i", place - near, np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])) < 0.0
    doubtful = np.flatnonzero(behind & (distance < THICKNESS))
    if len(doubtful):  # behind an open patch is not yet inside
        outside = place[doubtful] + OUTWARD * vertex_normals(skin, hand.skin.faces)[points[doubtful]]
        inside = winding(outside, np.ascontiguousarray(skin[hand.skin.faces])) > 0.5
        distance[doubtful[inside]] *= -1.0
    return distance


def pulp_gap(hand: Hand, skin: Array, first: int, second: int) -> float:
    """Least signed distance between two pulps, skin to skin; negative where they overlap."""
    pulp, faces = pulps(hand), _pulp_faces(hand)
    there = skin_distance(hand, skin, pulp[first], faces[second])
    return float(min(there.min(), skin_distance(hand, skin, pulp[second], faces[first]).min()))


@per_hand
def _pulp_faces(hand: Hand) -> dict[int, Index]:
    """Triangles whose corners all belong to a pulp."""
    return {k: np.flatnonzero(np.isin(hand.skin.faces, points).all(axis=1)) for k, points in pulps(hand).items()}


def pulp_normal(hand: Hand, skin: Array, k: int) -> Array:
    """Mean outward direction of a pulp."""
    normal = vertex_normals(skin, hand.skin.faces)[pulps(hand)[k]].mean(axis=0)
    result: Array = normal / np.linalg.norm(normal)
    return result


def facing(hand: Hand, skin: Array, first: int, second: int) -> float:
    """Angle between the normal of one pulp and the way from its middle to the middle of the other: 0 when it faces it squarely."""
    way = skin[pulps(hand)[second]].mean(axis=0) - skin[pulps(hand)[first]].mean(axis=0)
    return float(np.arccos(np.clip(pulp_normal(hand, skin, first) @ way / np.linalg.norm(way), -1.0, 1.0)))


def pulp_to_bodies(hand: Hand, skin: Array, k: int, bodies: tuple[str, ...]) -> float:
    """Least signed distance from a pulp to the skin that moves mainly with these bodies."""
    patch = np.concatenate([segment_faces(hand)[name] for name in bodies])
    return float(skin_distance(hand, skin, pulps(hand)[k], patch).min())


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


def digit_depths(hand: Hand, skin: Array) -> Array:
    """How deep each digit's last phalanges lie in the palm and in the other digits: (5, 6), column 0 the palm. Quick, for solvers."""
    depth = np.zeros((5, 6))
    for k, free in _digit_points(hand).items():
        for other, triangles in _digit_faces(hand).items():
            if other != k and (k == 1 or other < 2 or abs(k - other) == 1):
                depth[k - 1, other] = max(0.0, -float(skin_distance(hand, skin, free, triangles).min()))
    return depth


@per_hand
def _digit_points(hand: Hand) -> dict[int, Index]:
    """Skin of each digit beyond its first phalanx's middle: what can touch other skin."""
    sure = hand.skin.weights.max(axis=1) > 0.6
    main = np.array(hand.body_names)[hand.skin.weights.argmax(axis=1)]
    return {
        k: np.flatnonzero(
            sure & np.isin(main, [f"{kind}_phalanx_{k}" for kind in (("middle", "distal") if k > 1 else ("proximal", "distal"))])
        )
        for k in range(1, 6)
    }


@per_hand
def _digit_faces(hand: Hand) -> dict[int, Index]:
    """Triangles of the palm (0) and of each digit (1 to 5)."""
    faces = segment_faces(hand)
    digits = {k: np.unique(np.concatenate([faces[n] for n in faces if n.endswith(f"phalanx_{k}")])) for k in range(1, 6)}
    return {0: np.unique(np.concatenate([faces[name] for name in PALM]))} | digits


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
