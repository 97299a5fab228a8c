"""The warp of section 5.2 applied to a whole hand: skin, fine skin, bones, joints with their axes; muscle grids lie on the skin.

Faces, weights, texture, names and feature points are the very arrays of the old hand. What the new hand weighs and how its muscles
act is computed from its shape, or kept as in the paper, by name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from handlab.anatomy.growth import Growth, grown
from handlab.anatomy.mirror import renamed
from handlab.anatomy.records import Array, FineSkin, Hand, Skin, frozen
from handlab.fitting.articulation import articulated, hand_frame, turn_near
from handlab.fitting.bodies import weighed, with_masses_of
from handlab.fitting.bones import Checked, sound_bones
from handlab.physics import rbf
from handlab.simulation.kinematics import body_transforms, posed_axes
from handlab.simulation.skin import normals

Mechanics = Literal["scaled", "kept"]
MECHANICS = ("scaled", "kept")
# A second layer of points lies this far behind the feature points, about as deep as a palm is thick (an assumption).
BEHIND = 0.020
# How softly points on the outline are held (an assumption): pixels of an outline are rough, clicks are not.
SMOOTHING = 0.002
NEWTON = 8


@dataclass(frozen=True, eq=False)
class WarpedHand:
    """``hand``, in its own frame: p = ``rotation`` (f(x) - ``origin``) of the warp ``rbf``; ``bones``: what their check found."""

    hand: Hand
    rbf: rbf.Warp
    rotation: Array
    origin: Array
    bones: Checked


class Edge(NamedTuple):
    """Points of the skin ``source`` (K, 3) m on the old hand, and where the outline in a picture says they lie, ``target`` (K, 3) m."""

    source: Array
    target: Array


def landmark_warp(source: Array, target: Array, towards: Array, *, rule: str = "least squares", edge: Edge | None = None) -> rbf.Warp:
    """The warp that takes feature points ``source`` (N, 3) to ``target`` (N, 3) m; ``towards`` (3,): to the camera.

    ``printed``: these points alone. They lie nearly in one plane, so what the warp does across it hangs on small differences of
    height, and it may squeeze or shear bones. By default a second layer ``BEHIND`` them moves along as it would in a hand that is larger
    or smaller as a whole: thickness stays in proportion to size, as the paper wants it. Points of an ``edge`` are held softly.
    """
    if rule == "printed":
        return rbf.fitted(source, target)
    scale, turn = overall(source, target, towards)
    behind = -BEHIND * towards
    before, after = np.concatenate([source, source + behind]), np.concatenate([target, target + scale * turn @ behind])
    if edge is None:
        return rbf.fitted(before, after)
    smoothing = np.repeat([0.0, SMOOTHING], [len(before), len(edge.source)])
    return rbf.fitted(np.concatenate([before, edge.source]), np.concatenate([after, edge.target]), smoothing)


def overall(source: Array, target: Array, towards: Array) -> tuple[float, Array]:
    """Scale and rotation (3, 3) of the least-squares similarity in space from ``source`` to ``target`` (N, 3) (Umeyama 1991)."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    left, size, right = np.linalg.svd(b.T @ a)
    sign = np.array([1.0, 1.0, np.linalg.det(left @ right)])
    return float((size * sign).sum() / np.sum(a**2)), left @ (sign[:, None] * right)


def warp_hand(
    hand: Hand,
    warp: rbf.Warp,
    size: float,
    *,
    name: str = "",
    mechanics: Mechanics = "scaled",
    strict: bool = False,
) -> WarpedHand:
    """``hand`` warped, ready to move. ``size``: how many times as large as a whole (for thickness of bones, fibres and forces).

    ``mechanics``: "scaled", lever arms by the thickness of each joint, fibres by ``size``, forces by its square, masses from the volume;
    "kept", all as in the reference hand but the shape (the paper's way). ``strict``: bones that are too thin are refused, not repaired.
    Raises ``FoldedWarp`` where the bones cannot be saved.
    """
    if mechanics not in MECHANICS:
        raise ValueError(f"mechanics is {mechanics!r}; it must be 'scaled' or 'kept'")
    checked = sound_bones(hand, warp, size, repair=not strict)
    old = np.concatenate([bone.points for bone in hand.bones.values()])
    new = np.concatenate([checked.points[bone] for bone in hand.bones])

    turn, origin = hand_frame(hand, lambda points: warp(points), old, new)

    def placed(points: Array) -> Array:
        result: Array = (points - origin) @ turn.T
        return result

    def moved(points: Array) -> Array:
        return placed(warp(points))

    stored = {bone: _stored(placed(points)) for bone, points in checked.points.items()}
    skin = Skin(frozen(_stored(moved(hand.skin.points))), hand.skin.faces, hand.skin.weights)
    result = hand.with_(
        name=name or f"{hand.name}, warped",
        skin=skin,
        bones=renamed(hand.bones, {bone: replace(hand.bones[bone], points=frozen(points)) for bone, points in stored.items()}),
    )
    result = result.with_(skin_fine=_bound(result, hand.skin_fine, moved(hand.skin_fine.points)))
    joints, bind = articulated(hand, moved, old, placed(new))
    result = result.with_(joints=joints, bind=bind)
    result = result.with_(bodies=weighed(result, size))
    if mechanics == "kept":
        result = with_masses_of(result, hand)
    elif hand.growth is None:
        result = grown(result, growth(hand, result, size))
    return WarpedHand(result, warp, turn, origin, checked)


def growth(old: Hand, new: Hand, size: float) -> Growth:
    """How lever arms and fibres grew: lever arms of each rotation by the thickness of the bones at its joint, athwart axis and bone."""
    factor = []
    before, after = (np.concatenate([bone.points for bone in hand.bones.values()]) for hand in (old, new))
    ends = [_ends(hand) for hand in (old, new)]
    for name in old.dof_names:
        (axis, along, at), (new_axis, new_along, _) = (found[name] for found in ends)
        far = np.linalg.norm(before - at, axis=1)
        near = far <= max(0.010, float(np.partition(far, 40)[40]))
        if abs(axis @ along) > 0.7:  # a bone that turns about itself: its mean thickness
            spread = [
                np.sqrt(np.var(points[near] - np.outer(points[near] @ a, a), axis=0).sum())
                for points, a in ((before, along), (after, new_along))
            ]
        else:
            across = [np.cross(a, b) for a, b in ((axis, along), (new_axis, new_along))]
            spread = [np.std(points[near] @ a) / np.linalg.norm(a) for points, a in zip((before, after), across, strict=True)]
        factor.append(round(float(spread[1] / spread[0]), 6))
    return Growth(round(size, 6), frozen(factor))


def _ends(hand: Hand) -> dict[str, tuple[Array, Array, Array]]:
    """Axis, direction of the moved bone and joint centre of every degree of freedom as the hand lies."""
    axes, anchors = posed_axes(hand, hand.bind)
    frames = dict(zip(hand.body_names, body_transforms(hand, hand.bind), strict=True))
    found = {}
    for joint in hand.joints.values():
        for dof in joint.dofs:
            k = hand.dof_names.index(dof.name)
            along = hand.bodies[joint.child].centre - (frames[joint.parent][:3, :3] @ joint.centre + frames[joint.parent][:3, 3])
            found[dof.name] = axes[k], along / np.linalg.norm(along), anchors[k]
    return found


def _bound(hand: Hand, fine: FineSkin, points: Array) -> FineSkin:
    """The fine skin at ``points`` (Nf, 3), bound to the same triangles of the new even skin (Newton on place and height)."""
    corner = hand.skin.faces[fine.triangle]
    p, n = hand.skin.points[corner], normals(hand, hand.skin.points)[corner]
    x = np.concatenate([fine.barycentric[:, 1:], fine.height[:, None]], axis=1)

    def on_skin(x: Array) -> tuple[Array, Array, Array]:
        b = np.concatenate([1.0 - x[:, :2].sum(axis=1, keepdims=True), x[:, :2]], axis=1)
        raised = p + x[:, 2, None, None] * n
        return b, raised, np.einsum("nc,ncd->nd", b, raised)

    for _ in range(NEWTON):
        b, raised, place = on_skin(x)
        slope = np.stack([raised[:, 1] - raised[:, 0], raised[:, 2] - raised[:, 0], np.einsum("nc,ncd->nd", b, n)], axis=2)
        x = x - np.linalg.solve(slope, (place - points)[:, :, None])[:, :, 0]
    b, _, place = on_skin(x)
    lost = ~(np.linalg.norm(place - points, axis=1) < 1e-7) | (b.min(axis=1) < -0.5) | (np.abs(x[:, 2]) > 0.01)
    x[lost] = np.concatenate([fine.barycentric[lost, 1:], fine.height[lost, None]], axis=1)
    b, _, place = on_skin(x)
    b, height = _stored(b), _stored(x[:, 2])
    return replace(fine, points=frozen(_stored(np.where(lost[:, None], place, points))), barycentric=frozen(b), height=frozen(height))


def _stored(values: Array) -> Array:
    """Through 32 bits, as a file keeps them, so that a hand comes back from its file to the last bit."""
    return values.astype(np.float32).astype(np.float64)


Move = Callable[[Array], Array]
__all__ = ["MECHANICS", "Edge", "Mechanics", "WarpedHand", "growth", "landmark_warp", "overall", "turn_near", "warp_hand"]
