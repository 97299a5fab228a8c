"""What travels between a host and the viewer, as bytes: the scene once, then frames. All little-endian.

Scene: ``uint32`` length of a JSON text, the text (padded to four bytes), then one block of arrays. ``arrays`` in the text
says ``{name: [dtype, shape, byte offset in the block]}``; the rest of the text is what ``describe`` returns.

Frame: words of four bytes.

====================  ==============================================================================================
0                     uint32 kind: 1 = bodies, + 2 = points of the skin, + 4 = segments of the geometric muscles, + 8 = ridges of tendons
1                     uint32 flags: 1 = something moves, 2 = a clip plays, 4 = a clip is loaded
2                     uint32 echo: number of the newest message that this frame answers
3                     float32 time: of the clip, or of the live hand, seconds
4                     float32 length of the clip in seconds, 0 while the hand is live
5 ...                 float32 contraction (42), angle (31) rad, fibre_length (42) m, force (42) N,
                      transforms (19, 3, 4) that move the stored meshes
kind 2                int16 skin points (N, 3) in ``UNIT``, padded to four bytes
kind 8                uint32 count, uint16 fine points (count), padded, uint8 how far they are lifted (count) in ``LIFT_UNIT``, padded
kind 4                int16 for every segment: centre (3) in ``UNIT``, quaternion w x y z (4) in 1 / 32767, half-axes (3) in
                      ``HALF_UNIT``
====================  ==============================================================================================
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import FINGERS
from handlab.show.muscle_panel import newton_note, regions
from handlab.show.views import DIRECTIONS, LENS_DEG, directions
from handlab.simulation.geometric_muscle import Ellipsoids
from handlab.simulation.keyframes import clips, keyframes
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skin import binding, flat_height

BODIES, SKIN, SEGMENTS, RIDGES = 1, 2, 4, 8
UNIT, HALF_UNIT = 1e-5, 1e-6  # m: a hand reaches less than 32 cm from its wrist, a muscle is less than 6 cm thick
LIFT_UNIT = 2e-5  # m: no tendon lifts the skin by 5 mm
MOVING, PLAYING, CLIP = 1, 2, 4
HEAD_WORDS = 5

MOTIONS = {
    "flexion_extension": "flexion",
    "deviation": "deviation",
    "axial_rotation": "rotation",
    "flexion_opposition": "flexion",
    "abduction_adduction": "abduction",
}


def named_clips() -> list[dict[str, Any]]:
    """The clips that come with the package: name, title and length."""
    found = [(name, keyframes(name)) for name in clips()]
    return [{"name": name, "title": keys.title or name, "seconds": float(keys.time[-1])} for name, keys in found]


def describe(hand: Hand) -> dict[str, Any]:
    """Names and numbers of a hand that the viewer's panels show."""
    colour = regions(hand)
    return {
        "hand": hand.name,
        "side": hand.side,
        "reading": hand.reading,
        "newton_per_percent": hand.newton_per_percent,
        "newton_note": newton_note(hand),
        "lens_deg": LENS_DEG,
        "unit": UNIT,
        "views": {name: [part.tolist() for part in directions(hand, name)[:2]] for name in DIRECTIONS},
        "regions": [{"name": name, "colour": tint} for name, tint in colour.items()],
        "muscles": [
            {
                "name": muscle.name,
                "short": muscle.abbreviation,
                "title": muscle.name.replace("_", " "),
                "region": muscle.region,
                "group": muscle.group,
                "nerve": muscle.nerve,
                "action": muscle.action,
                "rest_length": float(length),
                "max_force": float(force),
                "dofs": [k for k, arm in enumerate(arms) if abs(arm) > 0.0],
            }
            for muscle, length, force, arms in zip(hand.muscles.values(), hand.rest_length, hand.max_force, hand.lever_arm, strict=True)
        ],
        "joints": [
            {
                "name": joint.name,
                "title": joint.english,
                "digit": digit_of(joint.name),
                "dofs": [hand.dof_names.index(dof.name) for dof in joint.dofs],
            }
            for joint in hand.joints.values()
            if joint.dofs
        ],
        "dofs": [
            {
                "name": name,
                "joint": dof.joint,
                "motion": MOTIONS.get(name.partition(".")[2], name.partition(".")[2]),
                "positive": dof.positive,
                "negative": dof.negative,
                "limits": [float(limit) for limit in dof.limits],
                "rest": float(rest),
                "driver": dof.driver,
                "ratio": float(dof.ratio),
            }
            for (name, dof), rest in zip(hand.dofs.items(), hand.fibre_rest, strict=True)
        ],
        "bodies": [{"name": name, "title": body_title(hand, name), "joint": body.joint} for name, body in hand.bodies.items()],
        "bones": [
            {"name": name, "title": bone.english, "latin": bone.latin, "body": hand.body_names.index(bone.body)}
            for name, bone in hand.bones.items()
        ],
    }


def digit_of(joint: str) -> str:
    """The digit a joint belongs to, or the wrist."""
    return FINGERS[int(joint[-1]) - 1] if joint[-1].isdigit() else joint


def body_title(hand: Hand, name: str) -> str:
    """What lies under a region of the skin, in plain words."""
    plain = {"forearm": "the forearm", "carpus": "the carpus and the middle of the hand"}
    return plain.get(name) or (f"the {hand.bones[name].english}" if name in hand.bones else name.replace("_", " "))


@per_hand
def meshes(hand: Hand) -> dict[str, Any]:
    """The arrays of the scene: the even skin with four weights a point, the fine skin on it, and all bones in one mesh."""
    from handlab.show.complexion import complexion

    bound, fine = binding(hand), hand.skin_fine
    bones = list(hand.bones.values())
    before = np.cumsum([0, *(len(bone.points) for bone in bones)])
    return {
        "skin_points": hand.skin.points.astype("<f4"),
        "skin_faces": hand.skin.faces.astype("<u2"),
        "skin_bodies": bound.index.astype("u1"),
        "skin_weights": bound.weight.astype("<f4"),
        "fine_faces": fine.faces.astype("<u2"),
        "fine_triangle": fine.triangle.astype("<u2"),
        "fine_barycentric": fine.barycentric[:, :2].astype("<f4"),
        "fine_height": flat_height(hand).astype("<f4"),
        "fine_tone": complexion(hand),
        "bone_points": np.concatenate([bone.points for bone in bones]).astype("<f4"),
        "bone_faces": np.concatenate([bone.faces + first for bone, first in zip(bones, before, strict=False)]).astype("<u2"),
        "bone_starts": before.astype("<u4"),
    }


def packed(head: Mapping[str, Any], arrays: Mapping[str, Any]) -> bytes:
    """A JSON text and arrays as one block."""
    places, block = {}, bytearray()
    for name, array in arrays.items():
        block.extend(b"\0" * (-len(block) % 4))
        places[name] = [array.dtype.str.lstrip("<|"), list(array.shape), len(block)]
        block.extend(np.ascontiguousarray(array).tobytes())
    text = json.dumps({**head, "arrays": places}, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<I", len(text)) + text + bytes(block)


def scene(hand: Hand, *, shown_clips: Iterable[Mapping[str, Any]] | None = None, **more: Any) -> bytes:
    """Everything about a hand that stays; ``more`` joins the text (such as ``exports``, the formats that the host writes)."""
    listed = named_clips() if shown_clips is None else list(shown_clips)
    return packed({**describe(hand), "clips": listed, **more}, meshes(hand))


def frame(
    hand: Hand,
    angle: Array,
    *,
    time: float,
    contraction: Array,
    fibre_length: Array,
    force: Array,
    flags: int = 0,
    echo: int = 0,
    seconds: float = 0.0,
    skin: Array | None = None,
    segments: Ellipsoids | None = None,
    ridges: tuple[Any, Array] | None = None,
) -> bytes:
    """One moment. With ``skin`` (N, 3) the points travel; without, the viewer blends them. ``segments`` of the muscles if they are seen.

    ``ridges``: points of the fine skin, and how far in metres tendons lift them.
    """
    parts = [
        np.array([time, seconds]),
        contraction,
        angle,
        fibre_length,
        force,
        relative_transforms(hand, angle)[:, :3].ravel(),
    ]
    kind = BODIES | SKIN * (skin is not None) | SEGMENTS * (segments is not None) | RIDGES * (ridges is not None)
    text = struct.pack("<III", kind, flags, echo & 0xFFFFFFFF) + np.concatenate(parts).astype("<f4").tobytes()
    if skin is not None:
        text += filled(whole(skin / UNIT))
    if ridges is not None:
        lifted = np.clip(np.rint(ridges[1] / LIFT_UNIT), 0, 255).astype("u1").tobytes()
        text += struct.pack("<I", len(ridges[0])) + filled(ridges[0].astype("<u2").tobytes()) + filled(lifted)
    if segments is not None:
        text += segment_table(segments)
    return text


def segment_table(segments: Ellipsoids) -> bytes:
    """Segments of muscles as the kind 4 above."""
    return whole(np.concatenate([segments.centre / UNIT, 32767 * quaternions(segments.frame), segments.half / HALF_UNIT], axis=1))


def whole(values: Array) -> bytes:
    """Numbers rounded to int16; what does not fit stays at the end of the range."""
    return np.clip(np.rint(values), -32767, 32767).astype("<i2").tobytes()


def filled(text: bytes) -> bytes:
    """Bytes to a whole number of words."""
    return text + b"\0" * (-len(text) % 4)


def quaternions(frame: Array) -> Array:
    """Unit quaternions (n, 4), w x y z, of rotations (n, 3, 3): the heaviest row of q q', so that no root is taken of little."""
    a, b, c = frame[:, 0], frame[:, 1], frame[:, 2]
    x, y, z = a[:, 0], b[:, 1], c[:, 2]
    p, q, r = c[:, 1] - b[:, 2], a[:, 2] - c[:, 0], b[:, 0] - a[:, 1]
    d, e, f = a[:, 1] + b[:, 0], a[:, 2] + c[:, 0], b[:, 2] + c[:, 1]
    rows = [[1 + x + y + z, p, q, r], [p, 1 + x - y - z, d, e], [q, d, 1 - x + y - z, f], [r, e, f, 1 - x - y + z]]
    square = np.array(rows).transpose(2, 0, 1)
    heaviest = square[np.arange(len(square)), np.einsum("nkk->nk", square).argmax(axis=1)]
    result: Array = heaviest / np.linalg.norm(heaviest, axis=1, keepdims=True)
    return result
