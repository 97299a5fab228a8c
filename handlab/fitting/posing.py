"""The reference hand brought into the posture of the picture before it is warped.

Fingers that are spread wider than the reference hand's would otherwise be taken for a broader hand, and come out thick. Only
rotations that a picture shows are free; each is held near the reference hand's as strongly as its usual range asks for.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handlab.anatomy.mirror import renamed
from handlab.anatomy.records import Array, Hand, frozen
from handlab.fitting.alignment import Aligned, similarity, tilted
from handlab.fitting.landmarks import source_points
from handlab.simulation.kinematics import posed_bone, relative_transforms
from handlab.simulation.skin import blend, fine_points

# How far (rad) people are likely to hold a joint from the reference hand's posture when they lay the hand down (an assumption).
LIKELY = {
    "wrist.deviation": np.deg2rad(8.0),
    **{f"mcp{k}.deviation": np.deg2rad(8.0) for k in (2, 3, 4, 5)},
    "cmc1.flexion_opposition": np.deg2rad(8.0),
    "cmc1.abduction_adduction": np.deg2rad(8.0),
    "mcp1.flexion_extension": np.deg2rad(8.0),
    "ip1.flexion_extension": np.deg2rad(8.0),
}
SCATTER_MM = 4.0  # of points of two hands of one size and posture (an assumption)
# Points that lie so well (scatter over size, mm) show another shape in the reference hand's posture; so badly, another posture. Between
# the two the posture is taken in part. Hands of women, men and children in one posture lie within 3 mm (assumptions).
SHAPE_MM, POSTURE_MM = 3.0, 5.0
ROUNDS = 12
STEP = 1e-4


def posture(found: Aligned, names: tuple[str, ...], picture: Array) -> Array:
    """Angles (dof,) in which ``found.hand`` looks most like ``picture`` (N, 2) mm, y upwards; the frame stays where it is."""
    hand = found.hand
    share = float(np.clip((found.fit.scatter / found.fit.scale - SHAPE_MM) / (POSTURE_MM - SHAPE_MM), 0.0, 1.0))
    if share == 0.0:
        return hand.bind
    # an exact mark moves with the stored point next to it
    index = [hand.feature_points[name][found.view] for name in names]
    beside = found.source - hand.skin.points[index]
    rows = [hand.dof_names.index(name) for name in LIKELY]
    likely = np.array(list(LIKELY.values()))
    low, high = hand.limits[rows].T
    start = np.asarray(hand.bind)[rows]
    # a reference hand that lies beyond a limit may stay there
    low, high = np.minimum(low, start), np.maximum(high, start)
    matrix = hand.coupling

    def whole(free: Array) -> Array:
        angle = np.array(hand.bind)
        moving = np.array([angle[hand.dof_names.index(name)] for name in hand.moving_names])
        moving[[hand.moving_names.index(name) for name in LIKELY]] = free
        # followers move by as much as their drivers make them
        old = np.array([angle[hand.dof_names.index(name)] for name in hand.moving_names])
        result: Array = angle + matrix @ (moving - old)
        return result

    def error(free: Array) -> Array:
        points = blend(hand, whole(free))[index] + beside
        residual = similarity(found.frame.flat(points) * 1e3, picture).residual / (SCATTER_MM * found.fit.scale)
        return np.concatenate([residual.reshape(-1), (free - start) / likely])

    free = start.copy()
    for _ in range(ROUNDS):
        now = error(free)
        slope = np.array([(error(free + STEP * e) - now) / STEP for e in np.eye(len(free))]).T
        change = np.clip(free - np.linalg.lstsq(slope, now, rcond=None)[0], low, high) - free
        free = free + change
        if np.abs(change).max() < 1e-5:
            break
    return whole(start + share * (free - start))


def posed(hand: Hand, angle: Array) -> Hand:
    """``hand`` stored in another posture: the same joints and bones, skin blended to it; ``bind`` is ``angle`` (dof,)."""
    skin = blend(hand, angle)
    moved = dict(zip(hand.body_names, relative_transforms(hand, angle), strict=True))
    bodies = {
        name: replace(
            body,
            centre=frozen(moved[name][:3, :3] @ body.centre + moved[name][:3, 3]),
            inertia=frozen(moved[name][:3, :3] @ body.inertia @ moved[name][:3, :3].T),
        )
        for name, body in hand.bodies.items()
    }
    return hand.with_(
        skin=replace(hand.skin, points=frozen(skin)),
        skin_fine=replace(hand.skin_fine, points=frozen(fine_points(hand, skin))),
        bones=renamed(hand.bones, {name: replace(bone, points=frozen(posed_bone(hand, name, angle))) for name, bone in hand.bones.items()}),
        bodies=renamed(hand.bodies, bodies),
        bind=frozen(angle),
    )


def reposed(found: Aligned, names: tuple[str, ...], picture: Array) -> Aligned:
    """``found`` with its hand in the posture of the picture, seen again from where that looks most alike."""
    angle = posture(found, names, picture)
    if angle is found.hand.bind:
        return found
    hand = posed(found.hand, angle)
    source = source_points(hand, found.view, names, found.marks)
    frame, fit = tilted(source, replace(found.frame, origin=source.mean(axis=0)), picture, held=found.start)
    return replace(found, hand=hand, source=source, frame=frame, fit=fit)
