"""Bones and skin of a hand as parts of a MuJoCo model."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.simulation.kinematics import body_transforms, tree

LIGHTEST = 0.01  # blend weights below this are left out: nobody sees them


def numbers(values: ArrayLike) -> str:
    """Numbers that read back to the last bit."""
    return " ".join(repr(float(value)) for value in np.ravel(np.asarray(values, dtype=np.float64)))


def short(values: ArrayLike) -> str:
    """Numbers for the eye: six digits."""
    return " ".join(f"{value:.6g}" for value in np.ravel(np.asarray(values, dtype=np.float64)))


def whole(values: ArrayLike) -> str:
    """Whole numbers."""
    return " ".join(map(str, np.ravel(np.asarray(values, dtype=np.int64)).tolist()))


def body_origins(hand: Hand) -> dict[str, Array]:
    """Where each body's frame lies in the zero posture: in the centre of the joint that carries it."""
    return {name: np.zeros(3) if body.joint is None else hand.joints[body.joint].centre for name, body in hand.bodies.items()}


def add_bones(asset: Element, bodies: Mapping[str, Element], hand: Hand, origin: Mapping[str, Array]) -> None:
    """One mesh per bone, in the frame of its body."""
    to_zero = dict(zip(hand.body_names, tree(hand).bind_inverse, strict=True))
    for name, bone in hand.bones.items():
        turn = to_zero[bone.body]
        points = bone.points @ turn[:3, :3].T + turn[:3, 3] - origin[bone.body]
        SubElement(asset, "mesh", name=name, vertex=short(points), face=whole(bone.faces))
        SubElement(bodies[bone.body], "geom", {"class": "bone"}, name=name, mesh=name)


def add_skin(deformable: Element, hand: Hand, origin: Mapping[str, Array]) -> None:
    """The detailed skin, bound to the bodies in the bind posture by its blend weights."""
    fine = hand.skin_fine
    skin = SubElement(deformable, "skin", name="skin", rgba="0.87 0.68 0.57 1", group="2")
    skin.set("vertex", short(fine.points))
    skin.set("face", whole(fine.faces))
    weights = fine_weights(hand)
    for row, (name, transform) in enumerate(zip(hand.body_names, body_transforms(hand, hand.bind), strict=True)):
        moved = np.flatnonzero(weights[:, row])
        if len(moved):
            bound = transform[:3, :3] @ origin[name] + transform[:3, 3]
            SubElement(
                skin,
                "bone",
                body=name,
                bindpos=numbers(bound),
                bindquat=numbers(quaternion(transform[:3, :3])),
                vertid=whole(moved),
                vertweight=short(weights[moved, row]),
            )


def fine_weights(hand: Hand) -> Array:
    """Blend weights (Nf, body) of the detailed skin: those of the even skin under each point. Rows add to 1."""
    fine = hand.skin_fine
    corners = hand.skin.faces[fine.triangle]
    weights = np.einsum("nc,ncb->nb", fine.barycentric, hand.skin.weights[corners])
    weights = np.where(weights < LIGHTEST, 0.0, weights)
    result: Array = weights / weights.sum(axis=1, keepdims=True)
    return result


def quaternion(turn: Array) -> Array:
    """The unit quaternion (w, x, y, z) of a rotation matrix (3, 3)."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(turn).as_quat()
    return np.array([w, x, y, z])
