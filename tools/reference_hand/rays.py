"""Where the joints of the reference hand lie inside its skin, and the skin stretched so that its creases lie over them.

The rig of the skin marks PIP and DIP (for the thumb MCP and IP) and the tip of each digit; its first finger joint
lies near the web, far from the knuckle, and is not used as a joint. Metacarpals and phalanges get the proportions of
``bone_lengths.csv`` between the carpus and the fingertip.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pyvista as pv
from scipy.interpolate import PchipInterpolator
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from handlab.anatomy.bone_lengths import bone_lengths_mm

from .sources import BoneSet, Person

PARTS = ("metacarpal", "proximal_phalanx", "middle_phalanx", "distal_phalanx", "pulp")
BONE_LENGTHS_MM = {k: tuple(row.get(part, 0.0) for part in PARTS) for k, row in bone_lengths_mm().items()}  # Buryanov & Kotiuk 2010
# centre to centre a ray is not its bone's length: joint centres lie inside the heads. Differences in mm (myo-sim: anchors against meshes)
CENTRES_MM = {1: (-10.0, 1.0, 0.0, 2.5, 0.0)} | dict.fromkeys((2, 3, 4, 5), (-6.0, 1.7, 1.3, 2.8, 0.0))
KNUCKLE_DEPTH = {
    2: 0.0084,
    3: 0.0086,
    4: 0.0073,
    5: 0.0076,
}  # joint centre below the dorsal skin: half a metacarpal head and 2 mm of tissue
LENGTHEN = {1: 0.009, 5: 0.005}  # assumption: these two digits of the skin are short against every bone table
DORSAL_SHIFT = 0.03  # assumption: phalanges lie this fraction of the thickness dorsal of the middle (more pulp than dorsal skin)
CARPUS_WIDTH = np.array([0.96, 0.94, 0.90])  # the carpus narrowed along x, y, z to lie inside this wrist
CARPUS_SHIFT = np.array([0.0, -0.002, 0.0])  # and laid 2 mm dorsally, where this skin has room
CARPAL_TURN = (
    0.45  # assumption: the carpus takes this part of the turn that the knuckles ask for; all of it lifts the thumb out of the skin
)
PALMAR = np.array([0.0, 1.0, 0.0])
FINGERS = (2, 3, 4, 5)


@dataclass
class Rays:
    """Skin points and joint centres in the palm frame (metres): the frame of the rig, x from wrist to middle web."""

    points: np.ndarray
    rig: dict[tuple[int, int], np.ndarray]
    centres: dict[str, np.ndarray]  # wrist, cmc1, mcp.., pip.., dip.., tip..
    carpus: np.ndarray  # linear map bone set -> palm frame, to which CARPUS_SHIFT is added
    scale: float
    surface: pv.PolyData  # the stretched skin, subdivided once


def palm_frame(person: Person) -> tuple[np.ndarray, np.ndarray]:
    """Origin and rotation of the provisional frame: x wrist to middle web, z radial, y palmar."""
    origin = person.joints["joint-r-hand"]
    x = _unit(person.joints["joint-r-finger-3-1"] - origin)
    z = person.joints["joint-r-finger-2-1"] - person.joints["joint-r-finger-5-1"]
    z = _unit(z - x * (z @ x))
    return origin, np.array([x, np.cross(z, x), z])


def triangulated(points: np.ndarray, quads: np.ndarray) -> pv.PolyData:
    """Quads cut along their first diagonal."""
    faces = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return pv.PolyData(points, np.hstack([np.full((len(faces), 1), 3), faces]).ravel())


def find_rays(person: Person, bones: BoneSet, quads: np.ndarray) -> Rays:
    """Place carpus and finger joints by iteration, thumb after them, then stretch the skin along the digits."""
    points, rig, surface = marked(person, quads)
    centres, carpus, scale = place_knuckles(rig, surface, bones)
    for k in range(1, 6):
        points = _stretch(points, rig, centres, k)
    surface = triangulated(points, quads).clean().subdivide(1, "loop")
    return Rays(points, rig, centres, carpus, scale, surface)


def marked(person: Person, quads: np.ndarray, size: float = 1.0) -> tuple[np.ndarray, dict[tuple[int, int], np.ndarray], pv.PolyData]:
    """Points and rig marks in the palm frame, marks in the middle of the digits, and the skin subdivided once.

    ``size``: of this hand, the reference hand being 1.
    """
    origin, rotation = palm_frame(person)
    points = (person.points - origin) @ rotation.T
    rig = {(k, i): (person.joints[f"joint-r-finger-{k}-{i}"] - origin) @ rotation.T for k in range(1, 6) for i in range(1, 5)}
    surface = triangulated(points, quads).clean().subdivide(1, "loop")
    _recentre(rig, surface, size)
    return points, rig, surface


def place_knuckles(
    rig: dict, surface: pv.PolyData, bones: BoneSet, lengthen: Mapping[int, float] = LENGTHEN, size: float = 1.0
) -> tuple[dict[str, np.ndarray], np.ndarray, float]:
    """Centres of wrist, finger MCP joints and thumb CMC, the carpus (linear map) and its scale, by iteration.

    ``lengthen``: what the skin will be stretched by afterwards; ``size``: of this hand, the reference hand being 1.
    """
    knuckle = {k: rig[k, 1] + 0.015 * _unit(rig[k, 1] - rig[k, 2]) for k in FINGERS}
    source = np.array([np.zeros(3)] + [bones.anchors[f"mcp{k}"] for k in FINGERS])
    base = {k: _proximal_end(bones.bones[f"metacarpal_{k}"][0]) for k in FINGERS}
    for _ in range(40):
        scale, turn, _ = similarity(source, np.array([np.zeros(3)] + [knuckle[k] for k in FINGERS]), np.array([3, 1, 1.5, 1, 1.0]))
        turn = Rotation.from_rotvec(CARPAL_TURN * Rotation.from_matrix(turn).as_rotvec()).as_matrix()
        carpus = scale * np.diag(CARPUS_WIDTH) @ turn
        for k in FINGERS:
            foot = carpus @ base[k] + CARPUS_SHIFT
            inward = _unit(rig[k, 1] - rig[k, 2])
            beyond = np.linalg.norm(knuckle[k] - rig[k, 1])
            finger = sum(np.linalg.norm(rig[k, i] - rig[k, i + 1]) for i in (1, 2, 3)) + lengthen.get(k, 0.0)
            have = np.linalg.norm(foot - knuckle[k])
            want = ray_lengths(k)[0] / ray_lengths(k).sum() * (have + finger + beyond)
            place = rig[k, 1] + inward * (beyond - 0.5 * (want - have))
            place[1] = _dorsal_skin(surface, place)[1] + size * KNUCKLE_DEPTH[k]
            knuckle[k] = 0.5 * knuckle[k] + 0.5 * place
    centres = {"wrist": np.zeros(3)} | {f"mcp{k}": knuckle[k] for k in FINGERS}
    centres["cmc1"] = carpus @ bones.anchors["cmc1"] + CARPUS_SHIFT
    return centres, carpus, scale


def _recentre(rig: dict, surface: pv.PolyData, size: float) -> None:
    """Move the rig's marks into the middle of the digit's cross-section, bones a little dorsal of it; tips onto the skin.

    The rig's own marks lie up to 5 mm dorsal of the middle of the finger.
    """
    for k in range(1, 6):
        marks = [rig[k, i] for i in (1, 2, 3, 4)]
        for i in (2, 3) if k > 1 else (3,):  # a plane through the thumb's MCP would cut the palm: its mark stays
            along = _unit(_unit(marks[i - 1] - marks[i - 2]) + _unit(marks[i] - marks[i - 1]))
            ring = section(surface, marks[i - 1], along)
            middle = (ring.min(axis=0) + ring.max(axis=0)) / 2
            bend = np.cross(marks[1] - marks[0], marks[2] - marks[1]) + np.cross(marks[2] - marks[1], marks[3] - marks[2])
            palmar = _unit(np.cross(bend, along))
            rig[k, i] = middle - DORSAL_SHIFT * np.ptp(ring @ palmar) * palmar
        near = surface.points[np.linalg.norm(surface.points - rig[k, 4], axis=1) < 0.014 * size]
        for _ in range(5):  # the tip: the middle of the last millimetres along the distal phalanx
            distal = _unit(rig[k, 4] - rig[k, 3])
            reach = near @ distal
            cap = near[reach > reach.max() - 0.002 * size]
            rig[k, 4] = (cap.min(axis=0) + cap.max(axis=0)) / 2


def section(surface: pv.PolyData, origin: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Points of the closed curve in which a plane cuts the surface, the curve around ``origin``."""
    rings = surface.slice(normal=normal, origin=origin).connectivity()
    label = rings.point_data["RegionId"]
    return min((rings.points[label == i] for i in np.unique(label)), key=lambda ring: np.linalg.norm(ring.mean(axis=0) - origin))


def _stretch(points: np.ndarray, rig: dict, centres: dict, k: int) -> np.ndarray:
    """Slide skin (and rig marks) along digit ``k`` until its creases lie at natural proportions; writes the centres."""
    first = "cmc1" if k == 1 else f"mcp{k}"
    lengths = ray_lengths(k) if k == 1 else ray_lengths(k)[1:]
    line = np.array([centres[first], rig[k, 2], rig[k, 3], rig[k, 4]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    goal = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum() * (along[-1] + LENGTHEN.get(k, 0.0))
    start = np.linalg.norm(rig[k, 1] - line[0]) if k > 1 else along[1]
    marks = slice(2, None) if k == 1 else slice(1, None)  # the thumb's first mark lies in the web: no crease to move
    slide = PchipInterpolator([-1.0, start, *along[marks], 1.0], [0.0, 0.0, *(goal - along)[marks], goal[-1] - along[-1]])

    dense = np.concatenate([np.linspace(0, along[-1], 400), [along[-1] + 0.02]])
    curve = np.array([np.interp(dense, along, line[:, i]) for i in range(3)]).T
    curve[-1] = line[-1] + 0.02 * _unit(line[-1] - line[-2])
    tangent = np.gradient(curve, dense, axis=0)
    tangent = np.array([np.convolve(np.pad(tangent[:, i], 40, mode="edge"), np.ones(81) / 81, mode="valid") for i in range(3)]).T
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)

    # the digit's own skin, fading out towards its neighbours so that the webs stay smooth
    others = np.vstack([np.linspace(rig[m, i], rig[m, i + 1], 30) for m in range(1, 6) if m != k for i in (1, 2, 3)])
    own, nearest = cKDTree(curve).query(points)
    other, _ = cKDTree(others).query(points)
    share = _smooth((other - own) / 0.008) * _smooth((0.030 - own) / 0.010)
    moved = points + (share * slide(dense[nearest]))[:, None] * tangent[nearest]
    middle = PchipInterpolator(dense, curve)
    names = ("cmc1", "mcp1", "ip1", "tip1") if k == 1 else (f"mcp{k}", f"pip{k}", f"dip{k}", f"tip{k}")
    for i, name in enumerate(names[1:], start=1):
        at = along[i] if i >= marks.start else goal[i]
        centres[name] = middle(at) + slide(at) * tangent[min(np.searchsorted(dense, at), 399)]
    return moved


def ray_lengths(k: int) -> np.ndarray:
    """Natural distances between the joint centres of a ray, from the carpus to the tip (mm): only their ratios count."""
    bone = np.array(BONE_LENGTHS_MM[k]) + CENTRES_MM[k]
    lengths = np.array([bone[0], bone[1], bone[2], bone[3:].sum()])
    return lengths[[0, 1, 3]] if k == 1 else lengths


def similarity(source: np.ndarray, target: np.ndarray, weight: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Least-squares scale, rotation and shift from source to target points (Umeyama 1991)."""
    weight = weight / weight.sum()
    a, b = source - weight @ source, target - weight @ target
    left, size, right = np.linalg.svd((b * weight[:, None]).T @ a)
    turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    scale = float((size * [1, 1, np.sign(np.linalg.det(left @ right))]).sum() / (weight * (a**2).sum(axis=1)).sum())
    return scale, turn, weight @ target - scale * turn @ (weight @ source)


def _proximal_end(points: np.ndarray) -> np.ndarray:
    return points[np.argsort(points[:, 0])[:5]].mean(axis=0)


def _dorsal_skin(surface: pv.PolyData, place: np.ndarray) -> np.ndarray:
    hits, _ = surface.ray_trace(place + 0.004 * PALMAR, place - 0.08 * PALMAR)
    return hits[0] if len(hits) else place


def _smooth(x: np.ndarray) -> np.ndarray:
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3 - 2 * x)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)
