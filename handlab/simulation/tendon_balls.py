"""What keeps a tendon out of bone in every pose: balls that fill the bone from inside and touch its surface, where the tendon comes near.

Nothing but balls moves with the bodies, so a viewer can do the same with a few numbers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from handlab.anatomy.records import Array, Hand, Index, Mesh, frozen
from handlab.simulation import skin_kernel
from handlab.simulation.bone_field import bone_field
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.per_hand import per_hand
from handlab.simulation.soft_hold_kernel import UNIT
from handlab.simulation.surface_graph import edges_of, face_normals
from handlab.simulation.tendon_kernel import inscribed

LARGEST = 0.005  # m: larger balls touch a flat bone no better
POSTURES = 120  # random ones, most of them near limits, in which it is looked where tendons come near bone
MARGIN = 0.0005  # m: nearer than this to touching is near
NEAREST = 2  # balls that touch the surface nearest to a point of the tendon: they are kept
BESIDE = 2  # rows before and after those that came near


class Inside(NamedTuple):
    """Balls in one body's bones, many to a bone: ``touch`` (k, 3), ``centre`` (k, 3), ``radius`` (k,), bind posture;
    ``tree`` finds the nearest ``touch``."""

    touch: Array
    centre: Array
    radius: Array
    tree: Any


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
    from scipy.spatial import cKDTree

    found = []
    for body in hand.body_names:
        parts = [_balls(bone) for bone in hand.bones.values() if bone.body == body]
        touch, centre, radius = (frozen(np.concatenate(column)) for column in zip(*parts, strict=True))
        found.append(Inside(touch, centre, radius, cKDTree(touch)))
    return tuple(found)


def _balls(bone: Mesh) -> tuple[Array, Array, Array]:
    """At every corner of a triangle, middle of it and middle of a side the largest ball below it without another such point."""
    upright, sides = np.empty_like(bone.points), edges_of(bone)
    skin_kernel.vertex_normals(bone.points, frozen(bone.faces, np.uint32), upright)
    touch = np.concatenate([bone.points, bone.points[sides].mean(axis=1), bone.points[bone.faces].mean(axis=1)])
    normal = np.concatenate([upright, upright[sides].sum(axis=1), face_normals(bone)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    size = np.full(len(touch), LARGEST)
    inscribed(touch, normal, size)
    return touch, touch - size[:, None] * normal, size


@per_hand
def postures(hand: Hand) -> Array:
    """Transforms (p, bodies, 4, 4) of the bodies in the bind posture and in many others."""
    rng, (low, high) = np.random.default_rng(0), mechanics(hand).limits.T
    drawn = [coupled(hand, low + rng.beta(0.5, 0.5, len(low)) * (high - low)) for _ in range(POSTURES)]
    return np.array([relative_transforms(hand, angle) for angle in (hand.bind, *drawn)])


def in_the_way(hand: Hand, lines: Array, radius: float) -> Balls:
    """Balls in the way of a tendon that lies in ``lines`` (p, n, 3) in ``postures``."""
    field, rows = bone_field(hand), lines.shape[1]
    found = []
    for body, (kept, moved) in enumerate(zip(inside(hand), postures(hand).swapaxes(0, 1), strict=True)):
        half = 0.5 * field.spacing * field.size[body]  # a sphere around its box tells of most lines that they are far
        away = lines - (moved[:, :3, :3] @ (field.origin[body] + half) + moved[:, :3, 3])[:, None]
        posture, row = np.nonzero(np.einsum("pni,pni->pn", away, away) < half @ half)
        local = np.einsum("ki,kij->kj", lines[posture, row] - moved[posture, :3, 3], moved[posture, :3, :3])
        at = np.rint((local - field.origin[body]) / field.spacing).astype(np.int64)
        near = np.all((at >= 0) & (at < field.size[body]), axis=1)
        near[near] = UNIT * field.value[field.start[body] + np.ravel_multi_index(at[near].T, field.size[body])] < radius + MARGIN
        if near.any():
            row = row[near]
            nearest = kept.tree.query(local[near], k=NEAREST)[1]
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
