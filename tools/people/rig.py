"""A known person moved by rotations about its own joints: centres, flexion axes and skin are the person's, nothing is warped or fitted.

Points of the skin follow the segments by the shares that the same points of the reference hand have (the shape data number the points
of all people alike), blended as dual quaternions (Kavan et al. 2007).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from handlab.anatomy.records import Array, Hand

RADIAL = np.array([0.0, 0.0, 1.0])


def moved(person: Any, hand: Hand, turn_deg: Mapping[str, float]) -> tuple[Array, dict[str, Array]]:
    """Skin (N, 3) and joint centres of ``person`` after ``turn_deg`` from its rest, by names of degrees of freedom.

    ``hand``: the reference hand, for the order of the bodies, the shares of the skin, and the axes of the thumb's saddle joint.
    """
    frames = {"forearm": np.eye(4)}
    carrier = dict.fromkeys(("tip1", "tip2", "tip3", "tip4", "tip5"), "")
    for joint in hand.joints.values():
        frame = frames[joint.parent]
        for dof in joint.dofs:
            if dof.name in turn_deg:
                frame = frame @ _about(_axis(person, hand, dof.name), person.centres[joint.name], turn_deg[dof.name])
        frames[joint.child] = frame
        carrier[joint.name] = joint.parent
        if joint.child.startswith("distal"):
            carrier[f"tip{joint.child[-1]}"] = joint.child
    centres = {name: _at(frames[carrier[name]], place) for name, place in person.centres.items()}
    fine = hand.skin_fine
    share = np.einsum("nc,ncb->nb", fine.barycentric, hand.skin.weights[hand.skin.faces[fine.triangle]])
    return blended(person.skin, share, np.array([frames[name] for name in hand.body_names])), centres


def _axis(person: Any, hand: Hand, dof: str) -> Array:
    """Unit axis (3,) of a rotation as the person lies: flexion takes the bone to the palm, deviation to the thumb's side."""
    joint, _, motion = dof.partition(".")
    if joint == "cmc1" or not (joint.startswith(("mcp", "pip", "dip", "ip"))):
        return next(row.axis for row in hand.joints[joint].dofs if row.name == dof)
    k = joint[-1]
    names = [f"mcp{k}", f"pip{k}", f"dip{k}", f"tip{k}"] if k != "1" else ["mcp1", "ip1", "tip1"]
    place = names.index(joint)
    along = person.centres[names[place + 1]] - person.centres[joint]
    kind, finger = joint[:-1], ("thumb", "index", "middle", "ring", "little")[int(k) - 1]
    palmar = person.marks["palmar"][f"{kind}_{finger}"] - person.centres[joint]
    axis = np.cross(along, palmar if motion.startswith("flexion") else RADIAL)
    result: Array = axis / np.linalg.norm(axis)
    return result


def _about(axis: Array, centre: Array, degrees: float) -> Array:
    frame = np.eye(4)
    frame[:3, :3] = Rotation.from_rotvec(np.deg2rad(degrees) * axis).as_matrix()
    frame[:3, 3] = centre - frame[:3, :3] @ centre
    return frame


def _at(frame: Array, point: Array) -> Array:
    result: Array = frame[:3, :3] @ point + frame[:3, 3]
    return result


def blended(points: Array, share: Array, frames: Array) -> Array:
    """Points (N, 3) moved by ``frames`` (B, 4, 4) blended by ``share`` (N, B) as dual quaternions."""
    real = Rotation.from_matrix(frames[:, :3, :3]).as_quat()  # x, y, z, w
    real *= np.where(real @ real[0] < 0.0, -1.0, 1.0)[:, None]
    dual = 0.5 * _product(np.column_stack([frames[:, :3, 3], np.zeros(len(frames))]), real)
    real, dual = share @ real, share @ dual
    size = np.linalg.norm(real, axis=1, keepdims=True)
    real, dual = real / size, dual / size
    shift = 2.0 * _product(dual, real * [-1.0, -1.0, -1.0, 1.0])[:, :3]
    result: Array = Rotation.from_quat(real).apply(points) + shift
    return result


def _product(p: Array, q: Array) -> Array:
    """Quaternions (N, 4), x, y, z, w."""
    v = p[:, 3:] * q[:, :3] + q[:, 3:] * p[:, :3] + np.cross(p[:, :3], q[:, :3])
    return np.column_stack([v, p[:, 3] * q[:, 3] - np.sum(p[:, :3] * q[:, :3], axis=1)])
