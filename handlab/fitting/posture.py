"""The hand spread as in the photograph, before it is warped: joints turn, flesh does not stretch.

A warp that has to open the gaps between spread fingers widens the fingers with them. So the reference hand first takes the
photographed hand's own posture, as far as points in a plane show it: spread of the fingers, lie of the thumb, bend of the wrist to the side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from handlab.anatomy.mirror import renamed
from handlab.anatomy.records import Array, Body, Bone, FineSkin, Hand, Skin, frozen
from handlab.fitting.alignment import frame_towards, similarity
from handlab.fitting.landmarks import VIEWS
from handlab.simulation.kinematics import posed_bone, relative_transforms
from handlab.simulation.skin import blend, fine_points

# How far (degrees) each joint is likely to be from the reference hand's posture in a photograph, and how far (mm) the points of a hand
# of other proportions lie from the posed ones: both assumptions, they only weigh posture against shape.
LIKELY_DEG: Mapping[str, float] = {
    "wrist.deviation": 8.0,
    "cmc1.flexion_opposition": 12.0,
    "cmc1.abduction_adduction": 12.0,
    "mcp1.flexion_extension": 10.0,
    "ip1.flexion_extension": 12.0,
    **{f"mcp{k}.deviation": 10.0 for k in range(2, 6)},
}
LIKELY_SCATTER_MM = 16.0


def as_photographed(hand: Hand, view: str, names: tuple[str, ...], picture: Array) -> Hand:
    """``hand``, stored in the posture that ``picture`` (N, 2) mm, y upwards, shows: the same hand, with other bind angles.

    ``view`` "palmar" or "dorsal" and ``names`` (N,) of the points, as ``alignment.conclude`` has them. The camera looks along the palm's normal:
    a hand on a table lies with its metacarpals flat. Points that show the posture already change nothing.
    """
    from scipy.optimize import least_squares

    if view not in VIEWS:
        raise ValueError(f"view is {view!r}; it must be 'palmar' or 'dorsal'")
    marks = np.array([hand.feature_points[name][view] for name in names])
    dofs = [hand.dof_names.index(name) for name in LIKELY_DEG]
    likely = np.deg2rad(np.array(list(LIKELY_DEG.values())))
    frame = frame_towards(np.array([0.0, 1.0 if view == "palmar" else -1.0, 0.0]), np.zeros(3))
    low, high = (np.minimum(hand.limits[dofs, 0], hand.bind[dofs]), np.maximum(hand.limits[dofs, 1], hand.bind[dofs]))

    def missed(turn: Array) -> Array:
        flat = 1e3 * frame.flat(blend(hand, _turned(hand, dofs, turn))[marks])
        return np.concatenate([similarity(flat, picture).residual.ravel() / LIKELY_SCATTER_MM, turn / likely])

    start = np.zeros(len(dofs))
    room = 1e-9
    found = least_squares(missed, start, bounds=(low - hand.bind[dofs] - room, high - hand.bind[dofs] + room), xtol=1e-10, ftol=1e-10)
    return rebound(hand, _turned(hand, dofs, found.x))


def rebound(hand: Hand, angle: Array) -> Hand:
    """The same hand stored in another posture: skin, bones and masses moved to ``angle`` (dof,) rad, which become its bind angles.

    Faces, weights, names and joints stay the very arrays. With the bind angles themselves ``hand`` comes back unchanged.
    """
    angle = np.asarray(angle, dtype=np.float64)
    if np.array_equal(angle, hand.bind):
        return hand
    skin = blend(hand, angle)
    fine = hand.skin_fine
    moved = relative_transforms(hand, angle)
    bodies = {name: _carried(body, transform) for (name, body), transform in zip(hand.bodies.items(), moved, strict=True)}
    bones: dict[str, Bone] = {name: replace(bone, points=frozen(posed_bone(hand, name, angle))) for name, bone in hand.bones.items()}
    return hand.with_(
        skin=Skin(frozen(skin), hand.skin.faces, hand.skin.weights),
        skin_fine=FineSkin(frozen(fine_points(hand, skin)), fine.faces, fine.texture, fine.triangle, fine.barycentric, fine.height),
        bones=renamed(hand.bones, bones),
        bodies=renamed(hand.bodies, bodies),
        bind=frozen(angle),
    )


def _turned(hand: Hand, dofs: list[int], turn: Array) -> Array:
    """Bind angles with ``turn`` added; followers of a joint that turned follow."""
    angle = np.array(hand.bind)
    angle[dofs] += turn
    moving = [hand.dof_names.index(name) for name in hand.moving_names]
    followed: Array = hand.coupling @ (angle[moving] - hand.bind[moving])
    driven = np.array([dof.driver is not None for dof in hand.dofs.values()])
    angle[driven] = hand.bind[driven] + followed[driven]
    return angle


def _carried(body: Body, transform: Array) -> Body:
    turn = transform[:3, :3]
    return replace(body, centre=frozen(turn @ body.centre + transform[:3, 3]), inertia=frozen(turn @ body.inertia @ turn.T))
