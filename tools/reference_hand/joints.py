"""Joint axes in the zero posture, and the angles of the bind posture, from the placed bones.

Zero posture: every phalanx in line with its metacarpal, the middle metacarpal in line with the forearm, metacarpal 1
beside metacarpal 2. The axes are first found as the hand lies (bind), then carried back, joint by joint, to zero.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.spatial.transform import Rotation

from .rays import FINGERS
from .skeleton import Skeleton

# Directions of the thumb's metacarpal in the zero posture: in the palm's plane, this far from metacarpal 2 (assumption:
# "beside metacarpal 2" still leaves the width of the first web)
THUMB_BESIDE_INDEX = np.radians(22.0)
THUMB_BASE_OFFSET = 0.004  # the abduction axis passes this far distal of the joint, through the base of metacarpal 1
THUMB_AXIAL = (17.0 / 53.0, np.radians(17.0 / 53.0 * 20.0))  # coupling of joints.json: ratio, offset
# How far a flexed finger leans to the radial side (rise per length along z): proximal phalanx at MCP 90, middle phalanx with
# MCP 80 and PIP 98. Assumption, within a few degrees of the axes that the skin's bent fingers and nails show: fingers that
# flex together lie side by side, and each alone points at the scaphoid tubercle.
LEAN_PROXIMAL = {2: -0.04, 3: 0.08, 4: 0.06, 5: 0.11}
LEAN_MIDDLE = {2: -0.10, 3: 0.01, 4: 0.15, 5: 0.37}
MCP_AXIAL = {2: 0.0, 3: -0.03, 4: -0.08, 5: -0.10}


@dataclass
class Articulation:
    """Axes, anchors and centres in the zero posture, bind angles, and body transforms bind <- zero."""

    axis: dict[str, np.ndarray] = field(default_factory=dict)
    anchor: dict[str, np.ndarray] = field(default_factory=dict)
    centre: dict[str, np.ndarray] = field(default_factory=dict)
    bind: dict[str, float] = field(default_factory=dict)
    body: dict[str, np.ndarray] = field(default_factory=dict)

    def add(self, dof: str, axis: np.ndarray, anchor: np.ndarray, angle: float) -> None:
        self.axis[dof], self.anchor[dof], self.bind[dof] = np.asarray(axis, float), np.asarray(anchor, float), float(angle)


def articulate(skeleton: Skeleton) -> Articulation:
    """Joints of the whole hand; ``skeleton`` lies in the forearm frame with the wrist centre at the origin."""
    centre = skeleton.centres
    a = Articulation()
    a.body["forearm"] = np.eye(4)
    _hinge(a, "wrist", "forearm", "carpus", np.zeros(3), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), _unit(centre["mcp3"]), None)
    foot = {k: _foot(skeleton.bones[f"metacarpal_{k}"][0], centre[f"mcp{k}"]) for k in FINGERS}
    for k in (4, 5):
        shaft = _unit(centre[f"mcp{k}"] - foot[k])
        flexion = _unit(_athwart(skeleton.flexion[k], shaft))
        back = np.linalg.inv(a.body["carpus"])
        a.centre[f"cmc{k}"] = _move(back, foot[k])
        a.add(f"cmc{k}.flexion_opposition", back[:3, :3] @ flexion, a.centre[f"cmc{k}"], 0.0)
        a.add(f"cmc{k}.axial_rotation", -back[:3, :3] @ shaft, a.centre[f"cmc{k}"], 0.0)
        a.body[f"metacarpal_{k}"] = a.body["carpus"].copy()
    for k in (2, 3):
        a.centre[f"cmc{k}"] = _move(np.linalg.inv(a.body["carpus"]), foot[k])
    for k in FINGERS:
        palm = f"metacarpal_{k}" if k in (4, 5) else "carpus"
        shaft = _unit(centre[f"mcp{k}"] - foot[k])
        line = [centre[f"{name}{k}"] for name in ("mcp", "pip", "dip", "tip")]
        mcp_axis, pip_axis = _leaning_axes(a.body["carpus"][:3, :3].T @ shaft, k)
        flexion = a.body["carpus"][:3, :3] @ mcp_axis
        _hinge(a, f"mcp{k}", palm, f"proximal_phalanx_{k}", line[0], flexion, shaft, _unit(line[1] - line[0]), MCP_AXIAL[k])
        flexion = a.body[f"proximal_phalanx_{k}"][:3, :3] @ pip_axis
        _bend(a, f"pip{k}", f"proximal_phalanx_{k}", f"middle_phalanx_{k}", line[0], line[1], line[2], flexion)
        _bend(a, f"dip{k}", f"middle_phalanx_{k}", f"distal_phalanx_{k}", line[1], line[2], line[3], flexion)
    _thumb(a, skeleton)
    return a


def _hinge(
    a: Articulation,
    joint: str,
    parent: str,
    child: str,
    at: np.ndarray,
    flexion: np.ndarray,
    shaft: np.ndarray,
    now: np.ndarray,
    axial: float | None,
) -> None:
    """A joint with flexion then deviation (then axial): the child lay along ``shaft`` in zero and lies along ``now``."""
    back = np.linalg.inv(a.body[parent])
    flexion = _unit(_athwart(flexion, shaft))
    deviation = np.cross(shaft, flexion)
    v = np.arcsin(np.clip(now @ flexion, -1, 1))
    f = np.arctan2(now @ np.cross(flexion, shaft), now @ shaft)
    a.centre[joint] = _move(back, at)
    a.add(f"{joint}.flexion_extension", back[:3, :3] @ flexion, a.centre[joint], f)
    a.add(f"{joint}.deviation", back[:3, :3] @ deviation, a.centre[joint], v)
    names = ["flexion_extension", "deviation"]
    if axial is not None:
        a.add(f"{joint}.axial_rotation", -back[:3, :3] @ shaft, a.centre[joint], axial * f)
        names.append("axial_rotation")
    a.body[child] = _carried(a, a.body[parent], joint, names)


def _bend(
    a: Articulation, joint: str, parent: str, child: str, before: np.ndarray, at: np.ndarray, after: np.ndarray, flexion: np.ndarray
) -> None:
    """An interphalangeal hinge about an axis athwart its two phalanges."""
    back = np.linalg.inv(a.body[parent])
    near, far = _unit(at - before), _unit(after - at)
    axis = _unit(_athwart(flexion, near + far))
    angle = np.arctan2(np.cross(near, far) @ axis, _athwart(near, axis) @ _athwart(far, axis))
    a.centre[joint] = _move(back, at)
    a.add(f"{joint}.flexion_extension", back[:3, :3] @ axis, a.centre[joint], angle)
    a.body[child] = _carried(a, a.body[parent], joint, ["flexion_extension"])


def _leaning_axes(shaft: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Flexion axes of MCP and PIP in the zero posture, athwart ``shaft``, that give the leans above."""
    first = _unit(_athwart(np.array([0, 0, 1.0]), shaft))
    second = np.cross(shaft, first)

    def axis(turn: float) -> np.ndarray:
        return np.cos(turn) * first + np.sin(turn) * second

    def lean(direction: np.ndarray) -> float:
        return direction[2] / np.hypot(direction[0], direction[1])

    mcp = axis(brentq(lambda turn: lean(np.cross(axis(turn), shaft)) - LEAN_PROXIMAL[k], -0.7, 0.7))
    flexed = Rotation.from_rotvec(np.radians(80) * mcp) * Rotation.from_rotvec(-MCP_AXIAL[k] * np.radians(80) * shaft)

    def middle(turn: float) -> np.ndarray:
        return flexed.apply(Rotation.from_rotvec(np.radians(98) * axis(turn)).apply(shaft))

    return mcp, axis(brentq(lambda turn: lean(middle(turn)) - LEAN_MIDDLE[k], -0.9, 0.9))


def _thumb(a: Articulation, skeleton: Skeleton) -> None:
    """CMC: flexion axis through the trapezium, then abduction axis through the base of metacarpal 1, then pronation."""
    centre, bones = skeleton.centres, skeleton.bones
    back = np.linalg.inv(a.body["carpus"])
    turn = back[:3, :3]
    shaft = turn @ _unit(centre["mcp1"] - centre["cmc1"])
    flexion, abduction_now = (turn @ axis for axis in skeleton.thumb_axes)
    index = _unit(a.centre["mcp2"] - a.centre["cmc2"])
    palm = _unit(np.cross(_unit(a.centre["mcp2"] - a.centre["mcp5"]), index))  # palmar normal of the metacarpals
    radial = _unit(np.cross(index, palm))
    wanted = np.cos(THUMB_BESIDE_INDEX) * index + np.sin(THUMB_BESIDE_INDEX) * radial

    def zero_shaft(angles: np.ndarray) -> np.ndarray:
        f, v = angles
        unflexed = Rotation.from_rotvec(-f * flexion)
        abduction = unflexed.apply(abduction_now)
        return Rotation.from_rotvec(-v * abduction).apply(unflexed.apply(shaft))

    f, v = least_squares(lambda x: zero_shaft(x) - wanted, [0.0, 0.4]).x
    abduction = Rotation.from_rotvec(-f * flexion).apply(abduction_now)
    trapezium = _move(back, bones["trapezium"][0].mean(axis=0))
    joint = _move(back, centre["cmc1"])
    base_now = joint + THUMB_BASE_OFFSET * shaft
    base = trapezium + Rotation.from_rotvec(-f * flexion).apply(base_now - trapezium)
    a.centre["cmc1"] = trapezium + Rotation.from_rotvec(-f * flexion).apply(joint - trapezium)
    a.add("cmc1.flexion_opposition", flexion, trapezium, f)
    a.add("cmc1.abduction_adduction", abduction, base, v)
    a.add("cmc1.axial_rotation", -_unit(zero_shaft(np.array([f, v]))), base, THUMB_AXIAL[0] * f + THUMB_AXIAL[1])
    a.body["metacarpal_1"] = _carried(a, a.body["carpus"], "cmc1", ["flexion_opposition", "abduction_adduction", "axial_rotation"])
    line = [centre[name] for name in ("cmc1", "mcp1", "ip1", "tip1")]
    _bend(a, "mcp1", "metacarpal_1", "proximal_phalanx_1", line[0], line[1], line[2], skeleton.flexion[1])
    _bend(a, "ip1", "proximal_phalanx_1", "distal_phalanx_1", line[1], line[2], line[3], skeleton.flexion[1])


def _carried(a: Articulation, parent: np.ndarray, joint: str, names: list[str]) -> np.ndarray:
    body = parent
    for name in names:
        dof = f"{joint}.{name}"
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec(a.bind[dof] * a.axis[dof]).as_matrix()
        turn[:3, 3] = a.anchor[dof] - turn[:3, :3] @ a.anchor[dof]
        body = body @ turn
    return body


def _foot(points: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Middle of a metacarpal's base."""
    axis = _unit(head - points.mean(axis=0))
    along = points @ axis
    return points[along < along.min() + 0.003].mean(axis=0)


def _move(transform: np.ndarray, point: np.ndarray) -> np.ndarray:
    return transform[:3, :3] @ point + transform[:3, 3]


def _athwart(v: np.ndarray, axis: np.ndarray) -> np.ndarray:
    axis = _unit(axis)
    return v - axis * (v @ axis)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)
