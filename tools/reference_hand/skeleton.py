"""The 29 bones placed into the skin: carpus by one affine map, metacarpals hinged to it, phalanges joint to joint.

Everything is in the *forearm frame*: origin at the wrist centre, x along the forearm, z radial, y palmar.
In the zero posture the middle metacarpal lies along x too.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import fast_simplification
import igl
import numpy as np
import pymeshfix
import pyvista as pv
from scipy.ndimage import binary_closing, binary_fill_holes, gaussian_filter, label
from scipy.spatial.transform import Rotation

from .rays import CARPUS_SHIFT, FINGERS, Rays, section
from .sources import BoneSet

CARPALS = ("scaphoid", "lunate", "triquetrum", "pisiform", "trapezium", "trapezoid", "capitate", "hamate")
PULP = {1: 0.0040, 2: 0.0030, 3: 0.0030, 4: 0.0030, 5: 0.0028}  # soft tissue beyond the distal phalanx (bone_lengths.csv, scaled)
SLENDER = 0.92  # assumption: a woman's bones are this much narrower for their length than the (male) bone set
FOREARM_WIDTH = np.array([1.0, 0.86, 0.86])  # radius and ulna narrowed to lie inside this wrist
MARGIN = 0.0010  # bones stay this far inside the skin
GAP = 0.0009  # least distance between the bones of a joint
TRIANGLES = {"radius": 600, "ulna": 500} | dict.fromkeys(CARPALS, 320)
FOREARM_CUT = -0.040  # radius and ulna end here, 5 mm inside the skin's cap


@dataclass
class Skeleton:
    """Bones and joints in the bind posture, forearm frame, metres."""

    bones: dict[str, tuple[np.ndarray, np.ndarray]]
    centres: dict[str, np.ndarray]
    flexion: dict[int, np.ndarray]  # unit flexion axis of each digit
    thumb_axes: tuple[np.ndarray, np.ndarray]  # CMC flexion, abduction
    carpus: np.ndarray  # linear map bone set -> here
    turn: np.ndarray  # palm frame -> forearm frame
    report: dict[str, float] = field(default_factory=dict)


def forearm_frame(surface: pv.PolyData) -> np.ndarray:
    """Rotation palm frame -> forearm frame, from the middles of the forearm's cross-sections."""
    rings = [surface.slice(normal=(1, 0, 0), origin=(x, 0, 0)).points for x in np.linspace(-0.07, -0.02, 11)]
    middles = np.array([(ring.min(axis=0) + ring.max(axis=0)) / 2 for ring in rings])
    x = np.linalg.svd(middles - middles.mean(axis=0))[2][0]
    x *= np.sign(x[0])
    z = _unit(np.array([0, 0, 1.0]) - x * x[2])
    return np.array([x, np.cross(z, x), z])


def place_bones(rays: Rays, source: BoneSet, surface: pv.PolyData) -> Skeleton:
    """Place, fit into the skin, part the joints, and thin the meshes."""
    turn = forearm_frame(surface)
    surface = surface.copy()
    surface.points = surface.points @ turn.T
    centres = {name: turn @ point for name, point in rays.centres.items()}
    flexion = {k: turn @ flexion_axis(rays, k) for k in range(1, 6)}
    linear, scale = turn @ rays.carpus, rays.scale

    def carpus(points: np.ndarray) -> np.ndarray:
        return points @ linear.T + turn @ CARPUS_SHIFT

    bones: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for name in CARPALS:
        bones[name] = (carpus(source.bones[name][0]), source.bones[name][1])
    for name in ("radius", "ulna"):
        bones[name] = (_forearm(source, name, linear, centres), source.bones[name][1])
    for k in FINGERS:
        points, faces = source.bones[f"metacarpal_{k}"]
        foot = points[np.argsort(points[:, 0])[:5]].mean(axis=0)
        own = _between(
            points,
            (foot, source.anchors[f"mcp{k}"], source.axes[f"mcp{k}"]),
            (carpus(foot), centres[f"mcp{k}"], flexion[k]),
            scale * SLENDER,
        )
        along = (points - foot) @ _unit(source.anchors[f"mcp{k}"] - foot) / np.linalg.norm(source.anchors[f"mcp{k}"] - foot)
        share = _smooth((along - 0.15) / 0.5)[:, None]  # the base keeps its place in the carpus, the head sits in its joint
        bones[f"metacarpal_{k}"] = ((1 - share) * carpus(points) + share * own, faces)
    chains = {1: [("metacarpal_1", "cmc1", "mcp1"), ("proximal_phalanx_1", "mcp1", "ip1"), ("distal_phalanx_1", "ip1", None)]}
    for k in FINGERS:
        chains[k] = [
            (f"proximal_phalanx_{k}", f"mcp{k}", f"pip{k}"),
            (f"middle_phalanx_{k}", f"pip{k}", f"dip{k}"),
            (f"distal_phalanx_{k}", f"dip{k}", None),
        ]
    for k, chain in chains.items():
        for name, near, far in chain:
            points, faces = source.bones[name]
            here = source.anchors[near]
            if far is None:
                axis = _unit(points.mean(axis=0) - here)
                there = here + axis * ((points - here) @ axis).max()
                goal = centres[f"tip{k}"] - PULP[k] * _unit(centres[f"tip{k}"] - centres[near])
            else:
                there, goal = source.anchors[far], centres[far]
            length = np.linalg.norm(goal - centres[near]) / np.linalg.norm(there - here)
            moved = _between(
                points,
                (here, there, source.axes[near if k > 1 else "ip1"]),
                (centres[near], goal, flexion[k]),
                min(length, scale) * SLENDER,
            )
            bones[name] = (moved, faces)
    skeleton = Skeleton({}, centres, flexion, _thumb_axes(source, linear), linear, turn)
    chain_pairs = [(a, b) for chain in chains.values() for (a, _, _), (b, _, _) in pairwise(chain)]
    pairs = (
        chain_pairs
        + [(f"metacarpal_{k}", f"proximal_phalanx_{k}") for k in FINGERS]
        + [("trapezium", "metacarpal_1"), ("trapezoid", "metacarpal_2"), ("capitate", "metacarpal_3"), ("hamate", "metacarpal_5")]
    )
    for name in bones:
        skeleton.bones[name] = _remesh(*bones[name], TRIANGLES.get(name, 520), rough=name in ("radius", "ulna"))
    for _ in range(3):
        for name in skeleton.bones:
            if name not in ("radius", "ulna", *CARPALS):
                _fit_inside(skeleton, name, surface)
        for near, far in pairs:
            _part(skeleton, near, far)
    return skeleton


def flexion_axis(rays: Rays, k: int) -> np.ndarray:
    """Flexion axis of digit ``k`` (palm frame): mean of the normal of its bent plane and the width of its end section."""
    names = ("cmc1", "mcp1", "ip1", "tip1") if k == 1 else (f"mcp{k}", f"pip{k}", f"dip{k}", f"tip{k}")
    line = np.array([rays.centres[n] for n in names])
    step = np.diff(line, axis=0)
    bend = _unit(np.cross(step[0], step[1]) + np.cross(step[1], step[2]) + np.cross(step[0], step[2]))
    ring = section(rays.surface, (line[2] + line[3]) / 2, _unit(step[2]))
    wide = np.linalg.svd(ring - ring.mean(axis=0))[2][0]
    return _unit(bend + wide * np.sign(wide @ bend))


def _thumb_axes(source: BoneSet, linear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Flexion and abduction axis of the thumb's CMC as in the bone set (its flexion coordinate counts extension)."""
    turn = Rotation.from_matrix(_nearest_rotation(linear)).as_matrix()
    return -turn @ source.axes["cmc1"], turn @ source.axes["cmc1.abduction"]


def _forearm(source: BoneSet, name: str, linear: np.ndarray, centres: dict) -> np.ndarray:
    """Radius and ulna: mapped like the carpus but straightened to the forearm, and laid along it."""
    points = source.bones[name][0].copy()
    near = points[:, 0] > -0.12
    axis = np.linalg.svd(points[near] - points[near].mean(axis=0))[2][0]
    axis *= np.sign(axis[0])
    end = points[points[:, 0] > points[:, 0].max() - 0.01].mean(axis=0)
    straight = Rotation.align_vectors([[1.0, 0, 0.0]], [axis])[0]
    points = straight.apply(points - end) + end
    mc3 = _unit(centres["mcp3"])
    unbend = Rotation.align_vectors([[1.0, 0, 0]], [mc3])[0].as_matrix()
    return points @ (FOREARM_WIDTH[:, None] * (unbend @ linear)).T + CARPUS_SHIFT - [0.0018, 0, 0]  # clear of the lunate in ulnar deviation


def _between(points: np.ndarray, source: tuple, target: tuple, across: float) -> np.ndarray:
    """Move a bone from (near, far, axis) to (near, far, axis): stretched along, scaled by ``across`` athwart."""
    frame_s, length_s = _frame(*source)
    frame_t, length_t = _frame(*target)
    local = (points - source[0]) @ frame_s.T * [length_t / length_s, across, across]
    return local @ frame_t + target[0]


def _frame(near: np.ndarray, far: np.ndarray, axis: np.ndarray) -> tuple[np.ndarray, float]:
    x = _unit(far - near)
    z = _unit(axis - x * (axis @ x))
    return np.array([x, np.cross(z, x), z]), float(np.linalg.norm(far - near))


def _remesh(points: np.ndarray, faces: np.ndarray, triangles: int, rough: bool) -> tuple[np.ndarray, np.ndarray]:
    """A closed, even mesh of a bone that may have holes: level set of its winding number, then clustered.

    ``rough`` bones (radius and ulna: 390 sharp triangles) are rounded off by 1.8 mm, the others by 0.3 mm.
    """
    step, soften = (0.0006, 0.0018) if rough else (0.0003, 0.0003)
    if rough:
        points, faces = _keep_near(points, faces, FOREARM_CUT - 0.02)
    low, high = points.min(axis=0) - 6 * step, points.max(axis=0) + 6 * step
    size = np.ceil((high - low) / step).astype(int) + 1
    grid = pv.ImageData(dimensions=size, spacing=(step,) * 3, origin=low)
    inside = igl.fast_winding_number(points.astype(float), faces.astype(np.int64), np.asarray(grid.points, float))
    solid, _ = label(inside.reshape(size, order="F") > 0.5)
    solid = binary_fill_holes(solid == 1 + np.argmax(np.bincount(solid.ravel())[1:]))  # the bone, without crumbs and bubbles
    while not rough and _tunnels(solid):
        solid = binary_closing(np.pad(solid, 3), iterations=2)[3:-3, 3:-3, 3:-3]
    field = gaussian_filter(solid.astype(float), soften / step)
    if rough:
        field[np.asarray(grid.points)[:, 0].reshape(size, order="F") < FOREARM_CUT] = 0.0
    grid["field"] = field.ravel(order="F")
    mesh = grid.contour([0.5], scalars="field").extract_largest().clean()
    mesh = mesh.smooth_taubin(n_iter=20, pass_band=0.1)
    dense = np.asarray(mesh.points, float), mesh.faces.reshape(-1, 4)[:, 1:].astype(np.int32)
    thin, faces = fast_simplification.simplify(*dense, target_count=triangles)
    thin, faces = pymeshfix.clean_from_arrays(thin.astype(float), faces.astype(np.int32))
    even = polydata(thin, faces)
    if not (even.is_manifold and even.n_open_edges == 0 and abs(even.volume / mesh.volume - 1) < 0.1):
        raise RuntimeError("a bone could not be closed")
    even = even.compute_normals(auto_orient_normals=True, consistent_normals=True, split_vertices=False)
    return np.asarray(even.points, float), even.faces.reshape(-1, 4)[:, 1:].astype(np.int64)


def _tunnels(solid: np.ndarray) -> int:
    """Tunnels through a connected solid of voxels without bubbles: 1 minus its Euler characteristic."""
    cells = np.pad(solid, 1)
    counts = [int(cells.sum())]
    edges = [cells | np.roll(cells, 1, axis=i) for i in range(3)]  # cubical complex of the union of closed voxels
    counts.append(sum(int(e.sum()) for e in edges))
    squares = [edges[i] | np.roll(edges[i], 1, axis=j) for i, j in ((0, 1), (0, 2), (1, 2))]
    counts.append(sum(int(q.sum()) for q in squares))
    corners = squares[0] | np.roll(squares[0], 1, axis=2)
    return 1 - (int(corners.sum()) - counts[2] + counts[1] - counts[0])


def _keep_near(points: np.ndarray, faces: np.ndarray, x: float) -> tuple[np.ndarray, np.ndarray]:
    keep = (points[faces][:, :, 0] > x - 0.06).all(axis=1)
    return points, faces[keep]


def polydata(points: np.ndarray, faces: np.ndarray) -> pv.PolyData:
    """Triangles as VTK knows them."""
    return pv.PolyData(points, np.hstack([np.full((len(faces), 1), 3), faces]).ravel())


def depth(points: np.ndarray, surface: pv.PolyData) -> np.ndarray:
    """Signed distance to a closed surface, negative inside (metres)."""
    return np.asarray(pv.PolyData(points).compute_implicit_distance(surface)["implicit_distance"])


def _fit_inside(skeleton: Skeleton, name: str, surface: pv.PolyData) -> None:
    """Shift a bone sideways, then narrow it, until it lies ``MARGIN`` inside the skin."""
    points, faces = skeleton.bones[name]
    for _ in range(12):
        out = depth(points, surface) + MARGIN
        if out.max() <= 0:
            break
        middle = points.mean(axis=0)
        axis = np.linalg.svd(points - middle)[2][0]
        worst = out > max(0.0, out.max() - 0.001)
        direction = (points[worst] - middle).mean(axis=0)
        direction -= axis * (direction @ axis)
        size = np.linalg.norm(direction)
        points = points - 0.5 * out.max() * direction / (size + 1e-9)
        local = points - points.mean(axis=0)
        lengthwise = np.outer(local @ axis, axis)
        points = points.mean(axis=0) + lengthwise + 0.985 * (local - lengthwise)
    skeleton.bones[name] = (points, faces)


def _part(skeleton: Skeleton, near: str, far: str) -> None:
    """Shorten the far bone's base until the joint has its gap."""
    points, faces = skeleton.bones[far]
    other = skeleton.bones[near][0]
    wall = polydata(other, skeleton.bones[near][1])
    axis = _unit(points.mean(axis=0) - other.mean(axis=0))
    for _ in range(60):
        gap = min(depth(points, wall).min(), depth(other, polydata(points, faces)).min())
        if gap >= GAP:
            break
        along = (points - points.mean(axis=0)) @ axis
        share = (along.max() - along) / np.ptp(along)  # the tip stays, only the base gives way
        points = points + 0.6 * (GAP - gap + 1e-5) * share[:, None] ** 2 * axis
    skeleton.bones[far] = (points, faces)


def _nearest_rotation(matrix: np.ndarray) -> np.ndarray:
    left, _, right = np.linalg.svd(matrix)
    return left @ right


def _smooth(x: np.ndarray) -> np.ndarray:
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3 - 2 * x)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)


def capitate_head(skeleton: Skeleton) -> np.ndarray:
    """Middle of the proximal third of the capitate: both axes of the wrist pass through it."""
    points = skeleton.bones["capitate"][0]
    return points[points[:, 0] < points[:, 0].min() + 0.33 * np.ptp(points[:, 0])].mean(axis=0)


def shift(skeleton: Skeleton, by: np.ndarray) -> None:
    """Move the origin; the wrist centre becomes the new origin."""
    for name, (points, faces) in skeleton.bones.items():
        skeleton.bones[name] = (points + by, faces)
    for name in skeleton.centres:
        skeleton.centres[name] = skeleton.centres[name] + by
    skeleton.centres["wrist"] = np.zeros(3)
