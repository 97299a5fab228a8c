"""How the bones lie in the skin and to each other: depths, gaps, soft tissue over knuckles and pulps, creases over joints.

All in the bind posture, metres.
"""

from __future__ import annotations

import numpy as np

from handlab.anatomy.records import Array, Hand, Mesh
from handlab.anatomy.tables import joints_table
from handlab.physics.crossing import leaving
from handlab.physics.distance import closest, winding
from handlab.studies.measures import vertex_normals
from handlab.studies.places import Place, joint_place, unit

HEAD = 0.009  # of a metacarpal: the part this near to the joint's centre
DORSAL = 0.7  # cosine: bone surface that faces dorsally
PULP_STATIONS = np.linspace(0.5, 0.9, 9)  # of the distal phalanx's length: its distal half, short of the tip's rounding
STATION = 0.06  # half the width of a station, as part of that length
CREASE_REACH = 0.012  # of the skin's profile on either side of a joint
CREASE_STEP = 0.00025
CREASE_LINES = np.linspace(-0.002, 0.002, 5)  # beside the midline; the profile is their mean
CREASE_CHORD = 0.008
CREASE_SEARCH = 0.006  # on either side of the joint
CREASE_DEPTH = 0.0002  # a shallower dip is no crease
NEAR = 0.045  # skin that can matter to a joint


def corners(mesh: Mesh) -> Array:
    """Corners (M, 3, 3) of a mesh's triangles."""
    return np.ascontiguousarray(mesh.points[mesh.faces])


def depths(points: Array, mesh: Mesh) -> Array:
    """How deep each point lies inside a closed mesh, negative outside."""
    points = np.ascontiguousarray(points)
    triangles = corners(mesh)
    distance: Array = closest(points, triangles)[0]
    return np.where(winding(points, triangles) > 0.5, distance, -distance)


def bone_depths_in_skin(hand: Hand) -> tuple[tuple[float, str], tuple[float, str]]:
    """Least depth of any bone's points inside the even and inside the fine skin (negative outside), and the bone that comes nearest."""
    owner = [name for name, bone in hand.bones.items() for _ in bone.points]
    points = np.vstack([bone.points for bone in hand.bones.values()])
    even = depths(points, hand.skin)
    reach = float(np.abs(hand.skin_fine.height).max())  # the fine skin lies no farther from the even one
    near = np.flatnonzero(even <= even.min() + 2.0 * reach)
    fine = closest(points[near], corners(hand.skin_fine))[0]
    doubtful = even[near] <= reach  # deeper points are inside both
    fine[doubtful] = depths(points[near][doubtful], hand.skin_fine)
    return (float(even.min()), owner[int(even.argmin())]), (float(fine.min()), owner[int(near[fine.argmin()])])


def separation(one: Mesh, other: Mesh) -> tuple[float, Array]:
    """Least distance from the points of either mesh to the other, negative where they overlap, and the middle (3,) of that line."""
    best, middle = np.inf, np.zeros(3)
    for a, b in ((one, other), (other, one)):
        distance, _, place = closest(np.ascontiguousarray(a.points), corners(b))
        inside = winding(np.ascontiguousarray(a.points), corners(b)) > 0.5
        signed = np.where(inside, -distance, distance)
        nearest = int(signed.argmin())
        if signed[nearest] < best:
            best, middle = float(signed[nearest]), (a.points[nearest] + place[nearest]) / 2.0
    return best, middle


def joint_gap(hand: Hand, joint: str) -> tuple[float, Array]:
    """Gap between the bones of a joint, and the middle (3,) of it where it is least."""
    row = joints_table()[joint]
    pairs = [(parent, child) for parent in row.parent_bones for child in row.child_bones]
    return min((separation(hand.bones[a], hand.bones[b]) for a, b in pairs), key=lambda found: found[0])


def gap_ahead(hand: Hand, joint: str) -> float:
    """How far distal of the joint's centre the middle of its gap lies."""
    place = joint_place(hand, joint)
    return float((joint_gap(hand, joint)[1] - place.centre) @ place.distal)


def head_centre_error(hand: Hand, joint: str) -> float:
    """Distance of the joint's axis from the centre of curvature of the proximal bone's head (least-squares circle athwart the axis)."""
    place = joint_place(hand, joint)
    bone = hand.bones[joints_table()[joint].parent_bones[0]]
    normals = vertex_normals(bone.points, bone.faces)
    r = bone.points - place.centre
    surface = (r @ place.distal > -0.002) & (normals @ place.distal > 0.3) & (np.linalg.norm(r, axis=1) < 0.012)
    flat = np.stack([r[surface] @ place.distal, r[surface] @ place.palmar], axis=1)
    system = np.column_stack([2.0 * flat, np.ones(len(flat))])
    solution = np.linalg.lstsq(system, (flat**2).sum(axis=1), rcond=None)[0]
    return float(np.linalg.norm(solution[:2]))


def knuckle_tissue(hand: Hand, k: int) -> tuple[float, float]:
    """Tissue from the dorsal surface of a metacarpal's head to the fine skin: the least, and at the head's most dorsal point."""
    place = joint_place(hand, f"mcp{k}")
    bone = hand.bones[f"metacarpal_{k}"]
    up = -place.palmar
    head = np.linalg.norm(bone.points - place.centre, axis=1) < HEAD
    dorsal = head & (vertex_normals(bone.points, bone.faces) @ up > DORSAL)
    over = depths(bone.points[dorsal], hand.skin_fine)
    crest = int((bone.points[dorsal] @ up).argmax())
    return float(over.min()), float(over[crest])


def pulp_thickness(hand: Hand, k: int) -> float:
    """Tissue palmar of the distal phalanx, mean over its distal half."""
    place = joint_place(hand, "ip1" if k == 1 else f"dip{k}")
    bone = hand.bones[f"distal_phalanx_{k}"]
    middle = bone.points.mean(axis=0)
    long_axis = np.linalg.svd(bone.points - middle)[2][0]
    along = unit(long_axis * np.sign(long_axis @ place.distal))
    palmar = unit(place.palmar - along * (along @ place.palmar))
    station = (bone.points - middle) @ along
    length, start = float(np.ptp(station)), float(station.min())
    origins = []
    for part in PULP_STATIONS:
        ring = bone.points[np.abs(station - start - part * length) < STATION * length]
        centre = (ring.min(axis=0) + ring.max(axis=0)) / 2.0
        origins.append(centre + along * (start + part * length - (centre - middle) @ along))
    starts = np.array(origins)
    skin = near_skin(hand, Place(middle, place.flexion, along, palmar))
    return float((leaving(starts, palmar, skin) - leaving(starts, palmar, corners(bone))).mean())


def near_skin(hand: Hand, place: Place) -> Array:
    """Corners of the fine skin's triangles around a joint."""
    triangles = corners(hand.skin_fine)
    return np.ascontiguousarray(triangles[np.linalg.norm(triangles.mean(axis=1) - place.centre, axis=1) < NEAR])


def palmar_profile(hand: Hand, joint: str) -> tuple[Array, Array]:
    """Height of the palmar skin over the digit's line: places along it (S,), 0 at the joint, distal positive, and heights (S,).

    Mean of five lines up to 2 mm beside the midline.
    """
    place = joint_place(hand, joint)
    along = np.arange(-CREASE_REACH, CREASE_REACH + CREASE_STEP / 2, CREASE_STEP)
    skin = near_skin(hand, place)
    lines = [leaving(place.centre + along[:, None] * place.distal + aside * place.flexion, place.palmar, skin) for aside in CREASE_LINES]
    return along, np.mean(lines, axis=0)


def crease(hand: Hand, joint: str) -> float | None:
    """How far distal of the joint's centre the palmar crease lies; None where the skin has none within 6 mm.

    The crease is where the palmar profile lies deepest below its own chord of 8 mm (a local deepening, whatever the slope of
    the skin there), provided that the profile is clearly straighter on both sides of it.
    """
    along, height = palmar_profile(hand, joint)
    half = round(CREASE_CHORD / 2 / CREASE_STEP)
    depth = (height[: -2 * half] + height[2 * half :]) / 2 - height[half:-half]
    place = along[half:-half]
    if not np.isfinite(depth).all():
        return None
    depth, place = depth[np.abs(place) <= CREASE_SEARCH], place[np.abs(place) <= CREASE_SEARCH]
    deepest = int(depth.argmax())
    before, after = depth[: deepest + 1].min(), depth[deepest:].min()
    if depth[deepest] < CREASE_DEPTH or depth[deepest] - max(before, after) < CREASE_DEPTH / 2:
        return None
    return float(place[deepest])


def bone_length(hand: Hand, name: str) -> float:
    """Extent of a bone along its long axis."""
    points = hand.bones[name].points
    long_axis = np.linalg.svd(points - points.mean(axis=0))[2][0]
    return float(np.ptp(points @ long_axis))
