"""Where every body is: forward kinematics of the joint hierarchy (section 3).

T(body) = T(parent) Rot(axis_1, anchor_1, angle_1) Rot(axis_2, ...) ... over the degrees of freedom of its joint, with axes
and anchors written in the zero posture. A transform maps points of the zero posture to the pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skeleton_kernel import pose as posed
from handlab.simulation.skeleton_kernel import relative


@dataclass(frozen=True)
class Tree:
    """The hierarchy as arrays.

    ``parent`` (body,) or -1; degrees of freedom ``first`` to ``first + count - 1`` of each body; ``axis``, ``anchor`` (dof, 3).
    ``bind_inverse`` (body, 4, 4) takes a point of the stored meshes to the zero posture.
    """

    parent: Index
    first: Index
    count: Index
    axis: Array
    anchor: Array
    bind_inverse: Array

    @property
    def arrays(self) -> tuple[Index, Index, Index, Array, Array]:
        """In the order in which the kernels take them."""
        return self.parent, self.first, self.count, self.axis, self.anchor


@per_hand
def tree(hand: Hand) -> Tree:
    """The hierarchy of a hand; bodies come after their parents."""
    row = {name: k for k, name in enumerate(hand.body_names)}
    column = {name: k for k, name in enumerate(hand.dof_names)}
    parent, first, count = [], [], []
    for name, body in hand.bodies.items():
        if body.parent is not None and body.parent not in row:
            raise ValueError(f"body {name!r} hangs on {body.parent!r}, but there is no body {body.parent!r}")
        if body.joint is not None and body.joint not in hand.joints:
            raise ValueError(f"body {name!r} turns in {body.joint!r}, but there is no joint {body.joint!r}")
        above = -1 if body.parent is None else row[body.parent]
        if above >= row[name]:
            raise ValueError(f"body {name!r} comes before its parent {body.parent!r}; list parents first")
        dofs = () if body.joint is None else hand.joints[body.joint].dofs
        parent.append(above)
        first.append(column[dofs[0].name] if dofs else 0)
        count.append(len(dofs))
    axis = np.array([dof.axis for dof in hand.dofs.values()])
    axis = frozen(axis / np.linalg.norm(axis, axis=1, keepdims=True))  # files keep a few digits only
    anchor = frozen([dof.anchor for dof in hand.dofs.values()])
    zero_is_bind = Tree(
        parent=frozen(parent, np.int64),
        first=frozen(first, np.int64),
        count=frozen(count, np.int64),
        axis=axis,
        anchor=anchor,
        bind_inverse=frozen(np.tile(np.eye(4), (len(parent), 1, 1))),
    )
    return replace(zero_is_bind, bind_inverse=frozen(np.linalg.inv(transforms(zero_is_bind, hand.bind)[0])))


def transforms(tree: Tree, angle: ArrayLike) -> tuple[Array, Array, Array]:
    """Transforms (body, 4, 4), posed axes (dof, 3) and posed anchors (dof, 3) at ``angle`` (dof,)."""
    angle = np.array(angle, dtype=np.float64)  # a copy: kernels are compiled anew for arrays that cannot be written
    if angle.shape != (len(tree.axis),):
        raise ValueError(f"angle has shape {angle.shape}; give one angle in radians for each of the {len(tree.axis)} degrees of freedom")
    out, axis, anchor = np.empty((len(tree.parent), 4, 4)), np.empty_like(tree.axis), np.empty_like(tree.anchor)
    posed(angle, *tree.arrays, out, axis, anchor)
    return out, axis, anchor


def body_transforms(hand: Hand, angle: ArrayLike) -> Array:
    """Transforms (body, 4, 4) from the zero posture to ``angle`` (dof,) in radians."""
    return transforms(tree(hand), angle)[0]


def posed_axes(hand: Hand, angle: ArrayLike) -> tuple[Array, Array]:
    """Axes (dof, 3) and anchors (dof, 3) where they are at ``angle``: each turned by everything before it."""
    _, axis, anchor = transforms(tree(hand), angle)
    return axis, anchor


def relative_transforms(hand: Hand, angle: ArrayLike) -> Array:
    """T(angle) T(bind)^-1 (body, 4, 4): what moves the stored meshes."""
    kept = tree(hand)
    out = np.zeros((len(kept.parent), 4, 4))
    out[:, 3, 3] = 1.0
    relative(transforms(kept, angle)[0], kept.bind_inverse, out)
    return out


def posed_points(hand: Hand, body: str, points: ArrayLike, angle: ArrayLike) -> Array:
    """Points (N, 3) of the bind posture, fixed to a body, where they are at ``angle``."""
    if body not in hand.bodies:
        hand.bodies[body]  # answers with the nearest names
    moved = relative_transforms(hand, angle)[hand.body_names.index(body)]
    result: Array = np.asarray(points, dtype=np.float64) @ moved[:3, :3].T + moved[:3, 3]
    return result


def posed_bone(hand: Hand, name: str, angle: ArrayLike) -> Array:
    """Points (N, 3) of a bone at ``angle``."""
    bone = hand.bones[name]
    return posed_points(hand, bone.body, bone.points, angle)


def rotation(axis: ArrayLike, anchor: ArrayLike, angle: float) -> Array:
    """Transform (4, 4) that turns by ``angle`` about a unit ``axis`` (3,) through ``anchor`` (3,) (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(4)
    turn[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    turn[:3, 3] = np.asarray(anchor) - turn[:3, :3] @ np.asarray(anchor)
    return turn


def body_transforms_readable(hand: Hand, angle: ArrayLike) -> Array:
    """``body_transforms`` in six lines, for reading and for testing the compiled one."""
    turn = {name: rotation(dof.axis, dof.anchor, value) for (name, dof), value in zip(hand.dofs.items(), np.asarray(angle), strict=True)}
    out: dict[str, Array] = {}
    for name, body in hand.bodies.items():
        out[name] = np.eye(4) if body.parent is None else out[body.parent].copy()
        for dof in () if body.joint is None else hand.joints[body.joint].dofs:
            out[name] = out[name] @ turn[dof.name]
    return np.array(list(out.values()))
