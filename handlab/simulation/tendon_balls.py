"""What keeps a tendon out of bone in every pose: balls that fill the bone from inside and touch its surface, where the tendon comes near.

Nothing but balls moves with the bodies, so a viewer can do the same with a few numbers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlab.anatomy.records import Array, Hand, Index, Mesh, frozen
from handlab.simulation import skin_kernel
from handlab.simulation.bone_field import BoneField, bone_field
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.per_hand import per_hand
from handlab.simulation.soft_hold_kernel import UNIT
from handlab.simulation.surface_graph import edges_of, face_normals

LARGEST = 0.005  # m: larger balls touch a flat bone no better
POSTURES = 120  # random ones, most of them near limits, in which it is looked where tendons come near bone
MARGIN = 0.0005  # m: nearer than this to touching is near
NEAREST = 2  # balls that touch the surface nearest to a point of the tendon: they are kept
BESIDE = 2  # rows before and after those that came near


class Inside(NamedTuple):
    """Balls in one body's bones, many to a bone: ``touch`` (k, 3), ``centre`` (k, 3), ``radius`` (k,), bind posture."""

    touch: Array
    centre: Array
    radius: Array


class Balls(NamedTuple):
    """Balls in one tendon's way: ``centre`` (b, 3) m, bind posture, on ``body`` (b,), ``radius`` (b,) m, rows ``first`` to ``last``."""

    centre: Array
    body: Index
    radius: Array
    first: Index
    last: Index


def none() -> Balls:
    """No balls."""
    row = frozen(np.zeros(0), np.int64)
    return Balls(frozen(np.zeros((0, 3))), row, frozen(np.zeros(0)), row, row)


@per_hand
def inside(hand: Hand) -> tuple[Inside, ...]:
    """The balls of every body."""
    found = []
    for body in hand.body_names:
        parts = [_balls(bone) for bone in hand.bones.values() if bone.body == body]
        found.append(Inside(*(frozen(np.concatenate(column)) for column in zip(*parts, strict=True))))
    return tuple(found)


def _balls(bone: Mesh) -> Inside:
    """At every corner of a triangle, middle of it and middle of a side q, with normal n, the largest ball below it without another such p.

    Its radius is the least (p - q)^2 / (2 n . (q - p)).
    """
    upright, sides = np.empty_like(bone.points), edges_of(bone)
    skin_kernel.vertex_normals(bone.points, frozen(bone.faces, np.uint32), upright)
    touch = np.concatenate([bone.points, bone.points[sides].mean(axis=1), bone.points[bone.faces].mean(axis=1)])
    normal = np.concatenate([upright, upright[sides].sum(axis=1), face_normals(bone)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    square = (touch**2).sum(axis=1)
    deep = (touch * normal).sum(axis=1)[:, None] - normal @ touch.T
    far = square[:, None] + square - 2.0 * (touch @ touch.T)
    radius = np.where(deep > 1e-6, far / (2.0 * np.maximum(deep, 1e-6)), LARGEST)
    size = np.minimum(radius.min(axis=1), LARGEST)
    return Inside(touch, touch - size[:, None] * normal, size)


@per_hand
def postures(hand: Hand) -> tuple[Array, ...]:
    """Transforms of the bodies in the bind posture and in many others."""
    rng, (low, high) = np.random.default_rng(0), mechanics(hand).limits.T
    drawn = [coupled(hand, low + rng.beta(0.5, 0.5, len(low)) * (high - low)) for _ in range(POSTURES)]
    return tuple(relative_transforms(hand, angle) for angle in (hand.bind, *drawn))


def in_the_way(hand: Hand, lines: Array, radius: float) -> Balls:
    """Balls in the way of a tendon that lies in ``lines`` (p, n, 3) in ``postures``."""
    from scipy.spatial import cKDTree

    field, moved, rows = bone_field(hand), np.array(postures(hand)), lines.shape[1]
    found = []
    for body, kept in enumerate(inside(hand)):
        turn, shift = moved[:, body, :3, :3], moved[:, body, :3, 3]
        local = np.einsum("pni,pij->pnj", lines - shift[:, None], turn)
        posture, row = np.nonzero(looked_up(field, body, local) < radius + MARGIN)
        if len(row):
            nearest = cKDTree(kept.touch).query(local[posture, row], k=NEAREST)[1]
            ball, place = np.unique(nearest, return_inverse=True)
            at, first, last = np.repeat(row, NEAREST), np.full(len(ball), rows), np.zeros(len(ball), np.int64)
            np.minimum.at(first, place.ravel(), at)
            np.maximum.at(last, place.ravel(), at)
            found.append((kept.centre[ball], np.full(len(ball), body), kept.radius[ball], first - BESIDE, last + BESIDE))
    if not found:
        return none()
    centre, on, size, first, last = (np.concatenate(column) for column in zip(*found, strict=True))
    low, high = (frozen(np.clip(end, 0, rows - 1), np.int64) for end in (first, last))
    return Balls(frozen(centre), frozen(on, np.int64), frozen(size), low, high)


def looked_up(field: BoneField, body: int, points: Array) -> Array:
    """Signed distances (...,) m of points (..., 3) in a body's own frame to its bones, from the nearest point of the grid."""
    size, start = field.size[body], field.start[body]
    at = np.rint((points - field.origin[body]) / field.spacing).astype(np.int64)
    known = np.all((at >= 0) & (at < size), axis=-1)
    i, j, k = np.moveaxis(np.clip(at, 0, size - 1), -1, 0)
    result: Array = np.where(known, field.value[start + (i * size[1] + j) * size[2] + k] * UNIT, np.inf)
    return result
