"""What is true of a person: the skin, the centres of the joints, and the 26 points on it, from the shape data alone.

PIP, DIP (thumb: IP) and tip are the shape data's own marks, laid into the middle of the digit as for the reference hand; CMC and MCP
follow the rule of the reference hand. Nothing here is warped, and the skin is not stretched.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from handlab.anatomy.records import Hand
from tools.people import cage
from tools.reference_hand import joints, rays, skeleton
from tools.reference_hand.sources import BoneSet, Person

VIEWS = ("palmar", "dorsal")
FINGER = {1: "thumb", 2: "index", 3: "middle", 4: "ring", 5: "little"}
CENTRES = (
    "wrist",
    *(f"cmc{k}" for k in range(1, 6)),
    *(f"mcp{k}" for k in range(1, 6)),
    "ip1",
    *(f"{joint}{k}" for joint in ("pip", "dip") for k in range(2, 6)),
    *(f"tip{k}" for k in range(1, 6)),
)


@dataclass
class Truth:
    """Metres, in a frame like that of the reference hand: cage (1689, 3), centres (22, 3) as ``CENTRES``, marks (2, 26, 3)."""

    cage: np.ndarray
    centres: np.ndarray
    marks: np.ndarray


def truth(person: Person, bones: BoneSet, quads: np.ndarray, index: np.ndarray, turn: np.ndarray, hand: Hand, size: float) -> Truth:
    """Everything true of one person. ``size``: of this hand (wrist to middle tip), the reference woman being 1."""
    points, rig, surface = rays.marked(person, quads, size)
    centres, carpus, scale = rays.place_knuckles(rig, surface, bones, {}, size)
    for k in rays.FINGERS:
        placed = bones.bones[f"metacarpal_{k}"][0] @ carpus.T + rays.CARPUS_SHIFT
        centres[f"cmc{k}"] = joints._foot(placed, centres[f"mcp{k}"])
        centres |= {f"{joint}{k}": rig[k, i] for joint, i in (("pip", 2), ("dip", 3), ("tip", 4))}
    centres |= {"ip1": rig[1, 3], "tip1": rig[1, 4], "mcp1": _thumb_knuckle(centres["cmc1"], rig)}
    found = rays.Rays(points, rig, centres, carpus, scale, surface)
    palmar = {k: turn @ np.cross(skeleton.flexion_axis(found, k), _along(centres, k)) for k in range(1, 6)}
    placed = {name: turn @ place for name, place in centres.items()}
    flat = cage.flat_rim(points[index] @ turn.T, hand.skin_fine.faces)
    fine = cage.fine_from_cage(hand.skin_fine.faces) @ flat
    for k in range(1, 6):  # the tip mark lies a little below the skin: out to the last of the finger
        distal = _unit(placed[f"tip{k}"] - placed[f"dip{k}" if k > 1 else "ip1"])
        near = fine[np.linalg.norm(fine - placed[f"tip{k}"], axis=1) < 0.015 * size]
        placed[f"tip{k}"] = placed[f"tip{k}"] + distal * (near @ distal - placed[f"tip{k}"] @ distal).max()
    marks = np.array([[_mark(name, view, placed, palmar, fine, hand) for name in hand.feature_points] for view in VIEWS])
    return Truth(flat, np.array([placed[name] for name in CENTRES]), marks)


def _thumb_knuckle(base: np.ndarray, rig: dict) -> np.ndarray:
    """On the line from CMC over the rig's mark to IP, where metacarpal and proximal phalanx have their natural ratio."""
    line = np.array([base, rig[1, 2], rig[1, 3]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    lengths = rays.ray_lengths(1)
    at = along[-1] * lengths[0] / lengths[:2].sum()
    return np.array([np.interp(at, along, line[:, i]) for i in range(3)])


def _along(centres: dict, k: int) -> np.ndarray:
    return _unit(centres[f"tip{k}"] - centres[f"mcp{k}"])


def _mark(name: str, view: str, centres: dict, palmar: dict, fine: np.ndarray, hand: Hand) -> np.ndarray:
    """Joints: on the skin above the joint's centre. Tips: the last of the finger. Webs, wrist, ulna: the same place of the skin."""
    kind, _, digit = name.partition("_")
    k = next((k for k, word in FINGER.items() if word == digit), 0)
    if kind == "tip":
        return centres[f"tip{k}"]
    if kind in ("mcp", "pip", "dip", "ip"):
        at, along = centres[f"{kind}{k}"], _along(centres, k)
        out = palmar[k] if view == "palmar" else -palmar[k]
        joint_along = _unit(centres[f"tip{k}"] - at)
        out = _unit(out - joint_along * (out @ joint_along))
        hits, _ = skeleton.polydata(fine, hand.skin_fine.faces).ray_trace(at, at + 0.06 * out)
        if not len(hits):
            raise RuntimeError(f"no skin above {name} ({view}), {along}")
        return np.asarray(hits[0], float)
    return same_place(hand, fine, hand.feature_points[name][view])


def same_place(hand: Hand, fine: np.ndarray, index: int) -> np.ndarray:
    """Where a point of the reference hand's even skin lies on a person's fine skin, which has the same triangles."""
    point, faces, corners = hand.skin.points[index], hand.skin_fine.faces, hand.skin_fine.points
    middle = cKDTree(corners[faces].mean(axis=1)).query(point, k=12)[1]
    best = (np.inf, 0, np.zeros(3))
    for face in middle:
        a, b, c = corners[faces[face]]
        edges = np.stack([b - a, c - a], axis=1)
        u = np.linalg.lstsq(edges, point - a, rcond=None)[0]
        share = np.clip([1 - u.sum(), *u], 0.0, 1.0)
        share /= share.sum()
        off = float(np.linalg.norm(share @ corners[faces[face]] - point))
        if off < best[0]:
            best = (off, int(face), share)
    return best[2] @ fine[faces[best[1]]]


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)
