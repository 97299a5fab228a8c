"""Joints of a warped hand: centres and axes go where the warp takes them, angles are counted from the same straight posture.

Centres are warped as points. An axis turns with the ends of the bones around it (the best rotation, not the sheared neighbourhood).
Then the rules that made the reference hand hold again: a finger's zero is in line with its metacarpal, metacarpal 3 in line with the
forearm, metacarpal 1 beside metacarpal 2; the axes of a joint stay athwart its bones. A hand that was not changed keeps its joints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from handlab.anatomy.mirror import renamed
from handlab.anatomy.records import Array, Hand, Joint, frozen
from handlab.simulation.kinematics import body_transforms, posed_axes, rotation

NEAR = 0.010  # bones within this distance of a joint turn its axes (m); heads of neighbouring metacarpals are 18 mm apart
FEWEST = 40  # bone points that decide a turn, where there are not as many within that distance
THUMB_BESIDE_INDEX = np.deg2rad(22.0)  # metacarpal 1 in the zero posture, as in the reference hand
DIGITS = 9  # of an angle in degrees: as many as its file keeps


@dataclass
class Placed:
    """Joints as the warped hand lies (bind): where a point goes, how its neighbourhood turns, and what was found so far."""

    hand: Hand
    moved: Callable[[Array], Array]
    turned: Callable[[Array], Array]
    axis: dict[str, Array] = field(default_factory=dict)  # posed axes of the old hand, turned
    anchor: dict[str, Array] = field(default_factory=dict)  # posed anchors of the old hand, moved
    centre: dict[str, Array] = field(default_factory=dict)  # joint centres, moved
    new: dict[str, tuple[Array, Array, float]] = field(default_factory=dict)  # zero axis, zero anchor, bind angle
    zero_centre: dict[str, Array] = field(default_factory=dict)
    body: dict[str, Array] = field(default_factory=dict)


def articulated(hand: Hand, moved: Callable[[Array], Array], old_bone: Array, new_bone: Array) -> tuple[dict[str, Joint], Array]:
    """Joints in the zero posture and bind angles (dof,) of the hand whose points go where ``moved`` takes them.

    ``moved`` must end in the frame of a hand: wrist centre at the origin, forearm along x (see ``hand_frame``); ``old_bone``,
    ``new_bone`` (N, 3) all bone points before and after.
    """

    def turned(at: Array) -> Array:
        return turn_near(at, old_bone, new_bone)

    p = Placed(hand, moved, turned)
    axes, anchors = posed_axes(hand, hand.bind)
    frames = dict(zip(hand.body_names, body_transforms(hand, hand.bind), strict=True))
    posed: dict[str, Array] = {}  # centres and axes of the old hand as it lies
    for name, joint in hand.joints.items():
        at = _move(frames[joint.parent], joint.centre)
        if name == "cmc1":  # in the zero posture it has been turned about the first axis, which lies in the carpus
            k = hand.dof_names.index(joint.dofs[0].name)
            at = _move(rotation(axes[k], anchors[k], hand.bind[k]), at)
        p.centre[name], posed[name] = moved(at), at
        turn = turned(at)
        for dof in joint.dofs:
            k = hand.dof_names.index(dof.name)
            p.axis[dof.name], p.anchor[dof.name] = turn @ axes[k], moved(anchors[k])
            posed[dof.name] = axes[k]
    p.body["forearm"] = np.eye(4)
    _hinge(p, "wrist", np.array([1.0, 0.0, 0.0]), p.centre["mcp3"])
    for k in (2, 3, 4, 5):
        p.zero_centre[f"cmc{k}"] = _move(np.linalg.inv(p.body["carpus"]), p.centre[f"cmc{k}"])
    for k in (4, 5):
        back = np.linalg.inv(p.body["carpus"])[:3, :3]
        shaft = _unit(p.centre[f"mcp{k}"] - p.centre[f"cmc{k}"])
        at = p.zero_centre[f"cmc{k}"]
        p.new[f"cmc{k}.flexion_opposition"] = (back @ _athwart(p.axis[f"cmc{k}.flexion_opposition"], shaft), at, 0.0)
        along = np.sign(float(hand.dofs[f"cmc{k}.axial_rotation"].axis @ _zero_shaft(hand, f"mcp{k}")))
        p.new[f"cmc{k}.axial_rotation"] = (along * back @ shaft, at, 0.0)
        p.body[f"metacarpal_{k}"] = p.body["carpus"].copy()
    for k in (2, 3, 4, 5):
        line = [p.centre[f"{name}{k}"] for name in ("mcp", "pip", "dip")]
        line.append(_far_end(p, f"pip{k}", f"dip{k}", posed))
        _hinge(p, f"mcp{k}", _unit(p.centre[f"mcp{k}"] - p.centre[f"cmc{k}"]), line[1])
        _bend(p, f"pip{k}", line[0], line[1], line[2])
        _bend(p, f"dip{k}", line[1], line[2], line[3])
    _thumb(p)
    line = [p.centre[name] for name in ("cmc1", "mcp1", "ip1")] + [_far_end(p, "mcp1", "ip1", posed)]
    _bend(p, "mcp1", line[0], line[1], line[2])
    _bend(p, "ip1", line[1], line[2], line[3])
    return _joints(p), frozen([p.new[name][2] for name in hand.dof_names])


def hand_frame(hand: Hand, moved: Callable[[Array], Array], old_bone: Array, new_bone: Array) -> tuple[Array, Array]:
    """Rotation (3, 3) and origin (3,) of the frame of a warped hand: p -> rotation @ (p - origin).

    Origin at the wrist centre, x along the forearm as it turned, z along the wrist's flexion axis.
    """
    wrist = hand.joints["wrist"]
    fore = np.concatenate([bone.points for bone in hand.bones.values() if bone.body == "forearm"])
    x = best_turn(fore, moved(fore)) @ np.array([1.0, 0.0, 0.0])
    z = _athwart(turn_near(wrist.centre, old_bone, new_bone) @ wrist.dofs[0].axis, x)
    return np.stack([x, np.cross(z, x), z]), moved(wrist.centre)


def best_turn(before: Array, after: Array) -> Array:
    """The rotation (3, 3) that takes ``before`` (N, 3) nearest to ``after``, each about its own middle (Kabsch 1976)."""
    left, _, right = np.linalg.svd((after - after.mean(axis=0)).T @ (before - before.mean(axis=0)))
    turn: Array = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return turn


def turn_near(at: Array, before: Array, after: Array) -> Array:
    """``best_turn`` of the points around ``at``."""
    far = np.linalg.norm(before - at, axis=1)
    near = far <= max(NEAR, float(np.partition(far, FEWEST)[FEWEST]))
    return best_turn(before[near], after[near])


def _hinge(p: Placed, joint: str, shaft: Array, beyond: Array) -> None:
    """Flexion then deviation (then axial rotation): the child lies along ``shaft`` in zero and points to ``beyond`` now."""
    record = p.hand.joints[joint]
    back = np.linalg.inv(p.body[record.parent])
    now = _unit(beyond - p.centre[joint])
    flexion = _athwart(p.axis[f"{joint}.flexion_extension"], shaft)
    deviation = np.cross(shaft, flexion)
    if record.dofs[1].axis @ np.cross(_zero_shaft(p.hand, joint), record.dofs[0].axis) < 0.0:  # a left hand
        deviation = -deviation
    side = float(deviation @ np.cross(shaft, flexion))
    v = side * np.arcsin(np.clip(now @ flexion, -1.0, 1.0))
    f = np.arctan2(now @ np.cross(flexion, shaft), now @ shaft)
    at = p.zero_centre[joint] = _move(back, p.centre[joint])
    p.new[f"{joint}.flexion_extension"] = (back[:3, :3] @ flexion, at, _kept(f))
    p.new[f"{joint}.deviation"] = (back[:3, :3] @ deviation, at, _kept(v))
    for dof in record.dofs[2:]:
        along = np.sign(float(dof.axis @ _zero_shaft(p.hand, joint)))
        p.new[dof.name] = (along * back[:3, :3] @ shaft, at, _kept(dof.ratio * f + dof.offset))
    _carry(p, joint)


def _bend(p: Placed, joint: str, before: Array, at: Array, after: Array) -> None:
    """A hinge athwart its two phalanges."""
    record = p.hand.joints[joint]
    back = np.linalg.inv(p.body[record.parent])
    near, far = _unit(at - before), _unit(after - at)
    axis = _athwart(p.axis[record.dofs[0].name], near + far)
    angle = np.arctan2(np.cross(near, far) @ axis, _across(near, axis) @ _across(far, axis))
    zero = p.zero_centre[joint] = _move(back, at)
    p.new[record.dofs[0].name] = (back[:3, :3] @ axis, zero, _kept(angle))
    _carry(p, joint)


def _thumb(p: Placed) -> None:
    """CMC of the thumb: flexion about an axis of the carpus, then abduction about one of metacarpal 1, then pronation."""
    from scipy.optimize import least_squares

    hand, back = p.hand, np.linalg.inv(p.body["carpus"])
    names = [dof.name for dof in hand.joints["cmc1"].dofs]
    turn = back[:3, :3]
    flexion, abduction_now = turn @ p.axis[names[0]], turn @ p.axis[names[1]]
    shaft = turn @ _unit(p.centre["mcp1"] - p.centre["cmc1"])
    mcp = {k: _move(back, p.centre[f"mcp{k}"]) for k in (2, 5)}
    index = _unit(p.zero_centre["mcp2"] - p.zero_centre["cmc2"])
    palm = _unit(np.cross(mcp[2] - p.zero_centre["mcp5"], index))
    radial = _unit(np.cross(index, palm))
    wanted = np.cos(THUMB_BESIDE_INDEX) * index + np.sin(THUMB_BESIDE_INDEX) * radial

    def zero_shaft(angles: Array) -> Array:
        unflexed = rotation(flexion, np.zeros(3), -angles[0])[:3, :3]
        abduction = unflexed @ abduction_now
        result: Array = rotation(abduction, np.zeros(3), -angles[1])[:3, :3] @ unflexed @ shaft
        return result

    old = [hand.bind[hand.dof_names.index(name)] for name in names]
    f, v = (_kept(x) for x in least_squares(lambda x: zero_shaft(x) - wanted, old[:2], xtol=1e-14, ftol=1e-14, gtol=1e-14).x)
    unflexed = rotation(flexion, np.zeros(3), -f)[:3, :3]
    pivot, base_now, joint = (_move(back, place) for place in (p.anchor[names[0]], p.anchor[names[1]], p.centre["cmc1"]))
    base = pivot + unflexed @ (base_now - pivot)
    along = np.sign(float(hand.joints["cmc1"].dofs[2].axis @ _zero_shaft(hand, "mcp1")))
    follower = hand.joints["cmc1"].dofs[2]
    p.zero_centre["cmc1"] = pivot + unflexed @ (joint - pivot)
    p.new[names[0]] = (flexion, pivot, f)
    p.new[names[1]] = (unflexed @ abduction_now, base, v)
    p.new[names[2]] = (along * _unit(zero_shaft(np.array([f, v]))), base, _kept(follower.ratio * f + follower.offset))
    _carry(p, "cmc1")


def _carry(p: Placed, joint: str) -> None:
    record = p.hand.joints[joint]
    body = p.body[record.parent]
    for dof in record.dofs:
        axis, anchor, angle = p.new[dof.name]
        body = body @ rotation(axis, anchor, angle)
    p.body[record.child] = body


def _zero_shaft(hand: Hand, joint: str) -> Array:
    """Direction of the bone before a joint in the zero posture of the old hand."""
    before = {"wrist": None, "mcp1": "cmc1"} | {f"mcp{k}": f"cmc{k}" for k in (2, 3, 4, 5)}
    start = before[joint]
    return np.array([1.0, 0.0, 0.0]) if start is None else _unit(hand.joints[joint].centre - hand.joints[start].centre)


def _far_end(p: Placed, before: str, joint: str, posed: dict[str, Array]) -> Array:
    """Where the far end of a last phalanx goes: in the zero posture it continues the phalanx before it.

    A hinge keeps the part of a direction along its axis; of that part the phalanx has as much to the other side (see ``_bend``).
    """
    hand, record = p.hand, p.hand.joints[joint]
    axis, angle = posed[record.dofs[0].name], hand.bind[hand.dof_names.index(record.dofs[0].name)]
    at = posed[joint]
    near = _unit(at - posed[before])
    far = rotation(axis, np.zeros(3), float(angle))[:3, :3] @ (near - 2.0 * axis * (near @ axis))
    reach = float(((hand.bones[record.child].points - at) @ far).max())
    return p.moved(at + reach * far)


def _joints(p: Placed) -> dict[str, Joint]:
    joints = {}
    for name, joint in p.hand.joints.items():
        dofs = tuple(replace(dof, axis=frozen(_unit(p.new[dof.name][0])), anchor=frozen(p.new[dof.name][1])) for dof in joint.dofs)
        joints[name] = replace(joint, centre=frozen(p.zero_centre[name]), dofs=dofs)
    result: dict[str, Joint] = renamed(p.hand.joints, joints)
    return result


def _kept(angle: Any) -> float:
    """An angle as a file keeps it: a short number of degrees."""
    return float(np.radians(round(float(np.degrees(angle)), DIGITS)))


def _move(transform: Any, point: Array) -> Array:
    result: Array = transform[:3, :3] @ point + transform[:3, 3]
    return result


def _across(v: Array, axis: Array) -> Array:
    result: Array = v - axis * (v @ axis)
    return result


def _athwart(v: Array, axis: Array) -> Array:
    """The unit vector nearest to ``v`` that is perpendicular to ``axis``."""
    return _unit(_across(v, _unit(axis)))


def _unit(v: Array) -> Array:
    result: Array = v / np.linalg.norm(v)
    return result
