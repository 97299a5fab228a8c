"""Where joints and directions of the stored meshes are: the bind posture, in words of anatomy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import FINGERS
from handlab.simulation.kinematics import body_transforms, rotation


class Place(NamedTuple):
    """A joint in the bind posture: ``centre`` (3,), unit ``flexion`` axis, ``distal`` along the digit, ``palmar``."""

    centre: Array
    flexion: Array
    distal: Array
    palmar: Array


def joint_place(hand: Hand, name: str) -> Place:
    """Where joint ``name`` is; ``distal`` halves the angle between the bones before and after it."""
    centre, axis = _centre_and_axis(hand, name)
    line = digit_line(hand, name)
    here = min(range(len(line)), key=lambda i: float(np.linalg.norm(line[i] - centre)))
    steps = [unit(line[i + 1] - line[i]) for i in (here - 1, here) if 0 <= i < len(line) - 1]
    along = np.sum(steps, axis=0)
    distal = unit(along - axis * (along @ axis))
    return Place(centre, axis, distal, np.cross(axis, distal))


def digit_line(hand: Hand, name: str) -> list[Array]:
    """Joint centres of the digit that ``name`` belongs to, from its CMC joint to its tip; the middle ray for the wrist."""
    k = int(name[-1]) if name[-1].isdigit() else 3
    names = ["cmc", "mcp", "ip"] if k == 1 else ["cmc", "mcp", "pip", "dip"]
    start = ["wrist"] if name == "wrist" else []
    centres = [_centre_and_axis(hand, joint)[0] for joint in start + [f"{joint}{k}" for joint in names]]
    return [*centres, hand.skin.points[hand.feature_points[f"tip_{FINGERS[k - 1]}"]["palmar"]]]


def _centre_and_axis(hand: Hand, name: str) -> tuple[Array, Array]:
    """Centre and flexion axis; the centre moves with the first rotation only (the thumb's saddle has two anchors)."""
    joint = hand.joints[name]
    frame = body_transforms(hand, hand.bind)[hand.body_names.index(joint.parent)]
    axis = hand.joints["wrist"].dofs[0].axis
    if joint.dofs:
        first = joint.dofs[0]
        frame = frame @ rotation(first.axis, first.anchor, hand.bind[hand.dof_names.index(first.name)])
        axis = first.axis
    return frame[:3, :3] @ joint.centre + frame[:3, 3], unit(frame[:3, :3] @ axis)


def unit(v: Array) -> Array:
    """``v`` (3,) at length 1."""
    result: Array = v / np.linalg.norm(v)
    return result
