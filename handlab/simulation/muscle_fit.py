"""From a painted grid to a muscle between skin and bone (section 4.2; steps as worked out for the hand).

Between every two columns runs a fibre. At each of its points: normal inwards, d = way to the bone below (or to the far skin, less
what lies under that), o = skin distance of the muscle, thickness h = clamp(d - o - gap, least, most), centre at depth o + h/2, width
from column to column at that depth unless bone beside it leaves less. Everything in the bind posture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlab.anatomy.grids import MuscleGrid
from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.physics.distance import closest
from handlab.simulation.geometric_kernel import first_hit
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skin import normals

# Assumptions, all chosen by eye on the reference hand.
GAP = 0.0004  # metres between a muscle and the bone below it
FAR_SKIN = 0.003  # metres of skin and fat that stay free where no bone lies below but the far side of the hand
# Share of its largest thickness that a muscle at rest is fitted to: room to swell (set together with bulge.SHORTENING).
REST_SHARE = 0.65
NEAR_SKIN = 0.0008  # metres: where room is short a muscle may come this near to the skin
REACH = 0.012  # metres an end may lie from its bone before the grid counts as painted in the wrong place
SHORTEST = 0.0002  # metres: least side of a cell
CUT = 0.8, 0.01  # the forearm's cut: triangles that face the elbow (cosine) within this distance of the end of the skin
EVEN = 4  # times that a normal is averaged with its neighbours': a muscle lies below what the skin does at large, not in its wrinkles
CROSSING = 0.002  # metres: lines of a grid nearer than this are looked at for crossing


@dataclass(frozen=True, eq=False)
class Fitted:
    """A muscle in the bind posture: ``point``, ``outward`` (rows, fibres, 3); ``thickness``, ``width``, ``depth`` d (rows, fibres), metres.

    ``painted`` (rows, columns, 3): the grid on the skin.
    """

    grid: MuscleGrid
    point: Array
    outward: Array
    thickness: Array
    width: Array
    depth: Array
    painted: Array


@per_hand
def bone_corners(hand: Hand) -> Array:
    """Corners (M, 3, 3) of the triangles of all bones."""
    return frozen(np.concatenate([bone.points[bone.faces] for bone in hand.bones.values()]))


@per_hand
def checked_skin(hand: Hand) -> Array:
    """Evened normals (N, 3) of a hand's skin. Raises ``ValueError`` if it is open or not a manifold: nothing can be fitted below it."""
    check_closed(hand.skin.faces, len(hand.skin.points))
    even, faces = normals(hand, hand.skin.points), hand.skin.faces
    for _ in range(EVEN):
        total = even.copy()
        for one, other in ((0, 1), (1, 2), (2, 0)):  # every edge is met once from each of its two triangles
            np.add.at(total, faces[:, one], even[faces[:, other]])
        even = total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-9)
    return frozen(even)


def check_closed(faces: Index, count: int) -> None:
    """Raise ``ValueError`` unless triangles (M, 3) over ``count`` points form a closed surface with an inside."""
    if len(faces) == 0 or faces.min() < 0 or faces.max() >= count:
        raise ValueError("the skin has no triangles, or triangles of points that it does not have; give a closed triangle mesh")
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    way, back = edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]
    if len(np.unique(way)) < len(way):
        raise ValueError("the skin is not a manifold: an edge belongs to more than two triangles, or they face both ways; repair the mesh")
    if missing := int((~np.isin(way, back)).sum()):
        raise ValueError(f"the skin is open: {missing} edges belong to one triangle only; close its holes before fitting muscles")


def fit(hand: Hand, grid: MuscleGrid) -> Fitted:
    """The muscle of ``grid`` between skin and bones of ``hand``.

    Raises ``ValueError`` for a grid off the skin, over the forearm's cut, crossing itself, with collapsed cells, without room, or
    with an end too far from its bone. Nothing is kept of a bad fit.
    """
    skin_normals = checked_skin(hand)
    painted = grid.points_on(hand.skin, hand.skin.points, hand.side)
    outward = grid.points_on(hand.skin, skin_normals, hand.side)
    outward = outward / np.maximum(np.linalg.norm(outward, axis=2, keepdims=True), 1e-9)
    _check_cut(hand, grid)
    _check_cells(grid, painted, outward)
    middle, up = (painted[:, 1:] + painted[:, :-1]) / 2, outward[:, 1:] + outward[:, :-1]
    skin = np.ascontiguousarray(hand.skin.points[hand.skin.faces])
    over = closest(np.ascontiguousarray(middle.reshape(-1, 3)), skin)[2].reshape(middle.shape)  # a chord leaves a curved skin
    up /= np.maximum(np.linalg.norm(up, axis=2, keepdims=True), 1e-9)
    depth = depth_below(hand, over, up)
    least, most = grid.thickness
    offset = np.broadcast_to(grid.skin_distance[:, None], depth.shape)
    # Where bone is near, the muscle comes nearer to the skin before it would enter the bone.
    offset = np.clip(np.minimum(offset, depth - GAP - least), min(NEAR_SKIN, float(offset.min())), None)
    _check_room(grid, depth, offset)
    room = np.clip(depth - offset - GAP, least, max(least, REST_SHARE * most))
    thickness = least + np.asarray(grid.fullness)[:, None] * (room - least)
    point = over - (offset + thickness / 2)[..., None] * up
    width = _width(hand, point, painted - (offset + thickness / 2).mean(axis=1)[:, None, None] * outward, least)
    for row, wanted in ((0, grid.on_bone[0]), (-1, grid.on_bone[1])):
        if wanted:
            point[row] = _to_bone(hand, grid, row, point[row], thickness[row])
    return Fitted(grid, *(frozen(values) for values in (point, up, thickness, width, depth, painted)))


def _width(hand: Hand, point: Array, edges: Array, least: float) -> Array:
    """Widths (rows, fibres) between ``edges`` (rows, columns, 3), across the fibres, and no wider than bone on either side allows."""
    along = np.gradient(point, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=2, keepdims=True), 1e-9)
    across = edges[:, 1:] - edges[:, :-1]
    across = across - np.einsum("rfd,rfd->rf", across, along)[..., None] * along  # what a slanting row gains along is no width
    wide = np.linalg.norm(across, axis=2)
    way = np.ascontiguousarray((across / np.maximum(wide, 1e-9)[..., None]).reshape(-1, 3))
    start, bones = np.ascontiguousarray(point.reshape(-1, 3)), bone_corners(hand)
    room = np.minimum(first_hit(start, way, bones)[0], first_hit(start, -way, bones)[0]).reshape(wide.shape)
    result: Array = np.maximum(np.minimum(wide, 2.0 * room), least)
    return result


def depth_below(hand: Hand, points: Array, outward: Array) -> Array:
    """Way (...,) inwards from places on the skin to the first bone, or to the far skin less ``FAR_SKIN``."""
    start = np.ascontiguousarray(points.reshape(-1, 3))
    inward = np.ascontiguousarray(-outward.reshape(-1, 3))
    bone = first_hit(start, inward, bone_corners(hand))[0]
    skin = first_hit(start + 1e-5 * inward, inward, np.ascontiguousarray(hand.skin.points[hand.skin.faces]))[0]
    way = np.minimum(bone, skin - FAR_SKIN)
    result: Array = np.where(np.isfinite(way), way, 0.0).reshape(points.shape[:-1])
    return result


def _to_bone(hand: Hand, grid: MuscleGrid, row: int, points: Array, thickness: Array) -> Array:
    names = grid.bones[row]
    corners = np.concatenate([hand.bones[name].points[hand.bones[name].faces] for name in names])
    distance, _, place = closest(np.ascontiguousarray(points), corners)
    if distance.max() > REACH:
        raise ValueError(
            f"the {'first' if row == 0 else 'last'} row of the muscle grid {grid.name!r} lies {1e3 * distance.max():.0f} mm from "
            f"{' and '.join(names)}; paint it over that bone, name another bone, or say that this end is not on bone"
        )
    away = (points - place) / np.maximum(distance, 1e-9)[:, None]
    result: Array = place + (thickness / 2)[:, None] * away
    return result


def _check_cut(hand: Hand, grid: MuscleGrid) -> None:
    corners = hand.skin.points[hand.skin.faces[grid.triangle]]
    normal = np.cross(corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :])
    facing = -normal[..., 0] / np.maximum(np.linalg.norm(normal, axis=-1), 1e-12)
    end = corners[..., 0].mean(axis=-1) - hand.skin.points[:, 0].min()
    if np.any((facing > CUT[0]) & (end < CUT[1])):
        raise ValueError(f"the muscle grid {grid.name!r} lies over the cut of the forearm; that is no skin: paint further towards the hand")


def _check_room(grid: MuscleGrid, depth: Array, offset: Array) -> None:
    least = grid.thickness[0]
    inner = np.ones(len(depth), dtype=bool)  # ends on bone are put there, whatever lies below the painted place
    inner[0], inner[-1] = (not end for end in grid.on_bone)
    short = (depth < offset + least) & inner[:, None]
    if np.any(short):
        row, column = np.argwhere(short)[0]
        raise ValueError(
            f"the muscle grid {grid.name!r} finds no room at row {row + 1}, fibre {column + 1}: bone lies "
            f"{1e3 * depth[row, column]:.1f} mm below the skin, the least thickness is {1e3 * least:.1f} mm; "
            "make it thinner or paint it beside the bone"
        )


def _check_cells(grid: MuscleGrid, painted: Array, outward: Array) -> None:
    along, across = painted[1:] - painted[:-1], painted[:, 1:] - painted[:, :-1]
    if min(np.linalg.norm(along, axis=2).min(), np.linalg.norm(across, axis=2).min()) < SHORTEST:
        raise ValueError(
            f"the muscle grid {grid.name!r} has points nearer than {1e3 * SHORTEST:g} mm to each other; spread its rows and columns"
        )
    # Every cell must lie the same way round on the skin: a grid that folds over or crosses itself does not.
    normal = np.cross(along[:, :-1] + along[:, 1:], across[:-1] + across[1:])
    middle = outward[1:, 1:] + outward[:-1, 1:] + outward[1:, :-1] + outward[:-1, :-1]
    facing = np.einsum("rcd,rcd->rc", normal, middle)
    if facing.min() <= 0.0 <= facing.max() or _crosses(painted, outward):
        raise ValueError(f"the muscle grid {grid.name!r} crosses itself; paint its rows one after the other from origin to insertion")


def _crosses(painted: Array, outward: Array) -> bool:
    """Whether two lines of the grid that share no corner cross, seen along the normals of the skin."""
    rows, columns = painted.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    pairs = [number[:, [k, k + 1]] for k in range(columns - 1)] + [number[[k, k + 1]].T for k in range(rows - 1)]
    ends = np.concatenate(pairs)
    i, j = np.triu_indices(len(ends), 1)
    one, other = ends[i], ends[j]
    apart = (one[:, :, None] != other[:, None, :]).all(axis=(1, 2))
    one, other = one[apart], other[apart]
    p, n = painted.reshape(-1, 3), outward.reshape(-1, 3)
    a, b, c, d = p[one[:, 0]], p[one[:, 1]], p[other[:, 0]], p[other[:, 1]]
    up = n[one].sum(axis=1) + n[other].sum(axis=1)
    up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)

    def side(u: Array, v: Array, w: Array) -> Array:
        result: Array = np.einsum("ij,ij->i", np.cross(v - u, w - u), up)
        return result

    cross = (side(a, b, c) * side(a, b, d) < 0.0) & (side(c, d, a) * side(c, d, b) < 0.0)
    height = np.abs(np.einsum("ij,ij->i", (a + b - c - d) / 2, up))  # lines on both sides of a finger do not cross
    return bool(np.any(cross & (height < CROSSING)))
