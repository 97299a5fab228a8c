"""The skin brought to the outline that the picture shows.

Feature points tell how long a hand is and how it lies; how broad it is stands in its outline. Wherever the edge of the warped skin has
the edge of the hand in the picture before or behind it, a point of the skin goes there and joins the feature points in the warp of
section 5.2. In the plane of the picture the hand is then as broad as in the picture; a finger gets as much thicker as it gets broader.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from handlab.anatomy.records import Array, Hand, Index
from handlab.fitting.bones import FoldedWarp
from handlab.fitting.outline import Mask, silhouette, small_mask
from handlab.fitting.plausible import remarks, with_camera
from handlab.fitting.result import Fit
from handlab.fitting.warp import Edge, landmark_warp, warp_hand
from handlab.simulation.skin_kernel import vertex_normals

ROUNDS = 3
# Lengths in a hand of the size of the reference hand (assumptions):
FARTHEST_MM = 5.0  # an edge farther off is another one
STEP_MM = 0.1  # in which it is looked for
SMOOTH_MM = 0.45  # over which the directions of edges are taken
GAP = 0.004  # m between chosen points, and from the feature points
FACING = 0.85  # cosine between the skin and the camera: the front or the back of a finger
REACH, FRONT_GAP = 0.012, 0.006  # m: how far its edges are from it; between chosen points
BOTH_SIDES = 0.35  # ways out of two edges that face one another add up to less
ALIKE = 0.8  # cosine of the angle between the two edges: others belong to a ring, a sleeve, a neighbour
# The outline counts where it shows the same hand as the points do.
SAME_HAND = 0.7
FEWEST = 40
UNSEEN = "hand and background cannot be told apart: the points alone shaped the hand"
OTHER = "the outline in the picture does not agree with the points: the points alone shaped the hand"


def outlined(fit: Fit) -> Fit:
    """``fit``, which has its picture, with the skin brought to the outline; with a remark instead where the outline cannot be used."""
    assert fit.pixels is not None
    try:
        shown, step = small_mask(fit.pixels, fit.clicks)
    except ValueError:
        return replace(fit, warnings=(*fit.warnings, UNSEEN))
    without = replace(fit, warnings=(*fit.warnings, OTHER))
    before, own = fit.overlap(shown, step), fit.aligned.hand
    if before < SAME_HAND:
        return without
    first = skin = fit.lying(fit.hand.skin_fine.points)
    rest, digit = own.skin_fine.points, _digit(own)
    for _ in range(ROUNDS):
        index, goal = _edge(fit, skin, shown, step)
        if len(index) < FEWEST:
            return without
        high, raised = _thicker(fit, first, skin, digit, index, goal)
        edge = Edge(rest[np.append(index, high)], np.concatenate([goal, raised]))
        warp = landmark_warp(fit.aligned.source, fit.target, fit.aligned.frame.towards, rule=fit.rule, edge=edge)
        skin = warp(rest)
    try:
        made = warp_hand(own, warp, fit.growth, name=fit.hand.name, mechanics=fit.mechanics)
    except FoldedWarp:
        return without
    shape = f"{fit.hand.sources['shape']}; {len(index)} points of its outline"
    result = replace(
        fit,
        hand=made.hand.with_(sources={**fit.hand.sources, "shape": shape}),
        warped=made,
        edge=edge,
        warnings=with_camera(remarks(fit.reference, made, fit.names, fit.aligned, fit.camera_mm), fit.camera_mm, fit.camera),
    )
    return result if result.overlap(shown, step) > before else without


def _edge(fit: Fit, skin: Array, shown: Mask, step: float) -> tuple[Index, Array]:
    """Rows (K,) of the fine skin whose place ``skin`` (N, 3) m is on the edge of the warped hand, and where they belong (K, 3) m."""
    from scipy.ndimage import gaussian_filter
    from scipy.spatial import cKDTree

    cell = step * fit.scale.mm_per_px  # mm
    at = fit.seen(skin) / step
    fine, marks = fit.aligned.hand.skin_fine, fit.aligned.source
    drawn = _outside(silhouette(at, fine.faces, (shown.shape[0], shown.shape[1])))
    blur = max(SMOOTH_MM / cell, 0.7)
    seen = gaussian_filter(_outside(shown), blur)
    rows, columns = shown.shape
    inside = (at > 1.0).all(axis=1) & (at[:, 0] < columns - 1) & (at[:, 1] < rows - 1)
    index = np.flatnonzero(inside)
    index = index[fit.beyond_wrist(shown, step)[tuple(at[index, ::-1].astype(int).T)]]
    index = index[np.abs(_value(drawn, at[index])) < 1.0]
    out = _direction(drawn, at[index], blur)
    # along the way out, the nearest place where the hand in the picture ends
    way = np.arange(-FARTHEST_MM, FARTHEST_MM + STEP_MM, STEP_MM) * fit.growth / cell
    value = _value(seen, (at[index, None] + way[:, None] * out[:, None]).reshape(-1, 2)).reshape(len(index), len(way))
    ends = (value[:, :-1] <= 0.0) & (value[:, 1:] > 0.0)
    k = np.where(ends, np.abs(way[:-1]), np.inf).argmin(axis=1)
    row = np.arange(len(index))
    a, b = value[row, k], value[row, k + 1]
    move = way[k] - (way[1] - way[0]) * a / np.where(b > a, b - a, 1.0)
    found = ends[row, k]
    found &= (_direction(seen, at[index] + move[:, None] * out, blur) * out).sum(axis=1) > ALIKE
    index, out, move = index[found], out[found], move[found]
    move = move + _value(drawn, at[index])  # the edge itself lies as far before the point
    if not len(index):
        return index, np.zeros((0, 3))
    rest = fine.points[index]
    chosen = _apart(rest, marks, GAP)
    near = cKDTree(rest).query_ball_point(rest[chosen], GAP)
    steady = np.array([np.median(move[one]) for one in near])
    return index[chosen], fit.beside(skin[index[chosen]], step * steady[:, None] * out[chosen])


def _thicker(fit: Fit, first: Array, skin: Array, digit: Index, edge: Index, goal: Array) -> tuple[Index, Array]:
    """Rows of the fine skin on the fingers' front and back, and where they belong (m): as much higher as both edges beside moved outwards.

    A picture does not show how thick a finger is; fingers are nearly round. The thumb lies turned: what is seen of it may be either.
    ``first`` and ``skin`` (N, 3) m: after the feature points alone, and now.
    """
    towards, flat = fit.aligned.frame.towards, fit.aligned.frame.flat(first)
    normal = np.empty(first.shape)
    vertex_normals(first, fit.aligned.hand.skin_fine.faces.astype(np.uint32), normal)
    out = normal[edge] - np.outer(normal[edge] @ towards, towards)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    broader = ((goal - first[edge]) * out).sum(axis=1)
    rows, heights = [], []
    for row in np.flatnonzero((digit > 1) & (np.abs(normal @ towards) > FACING)):
        near = np.flatnonzero((digit[edge] == digit[row]) & (np.linalg.norm(flat[edge] - flat[row], axis=1) < REACH * fit.growth))
        if len(near) >= 4 and np.linalg.norm(out[near].mean(axis=0)) < BOTH_SIDES:
            rows.append(row)
            heights.append(np.sign(normal[row] @ towards) * broader[near].mean())
    if not rows:
        return np.zeros(0, dtype=np.int64), np.zeros((0, 3))
    chosen = _apart(fit.aligned.hand.skin_fine.points[rows], fit.aligned.source, FRONT_GAP)
    index = np.array(rows)[chosen]
    height = (first[index] - skin[index]) @ towards + np.array(heights)[chosen]
    return index, skin[index] + height[:, None] * towards


def _digit(hand: Hand) -> Index:
    """The finger (1 to 5) of every point of the fine skin, 0 for palm and wrist."""
    of = np.array([int(name[-1]) if "phalanx" in name else 0 for name in hand.body_names])
    result: Index = of[hand.skin.weights.argmax(axis=1)][hand.skin.faces[hand.skin_fine.triangle, 0]]
    return result


def _outside(mask: Mask) -> Array:
    """Signed distance from the edge of ``mask`` in pixels, positive outside."""
    from scipy.ndimage import distance_transform_edt

    result: Array = np.where(mask, 0.5 - distance_transform_edt(mask), distance_transform_edt(~mask) - 0.5)
    return result


def _value(field: Array, at: Array) -> Array:
    """``field`` (rows, columns) at places (N, 2) = (x, y), linear between the middles of pixels."""
    from scipy.ndimage import map_coordinates

    result: Array = map_coordinates(field, (at[:, ::-1] - 0.5).T, order=1, mode="nearest")
    return result


def _direction(field: Array, at: Array, blur: float) -> Array:
    """Unit vectors (N, 2) in which ``field`` grows."""
    from scipy.ndimage import gaussian_filter

    slope = np.stack([_value(gaussian_filter(field, blur, order=order), at) for order in ((0, 1), (1, 0))], axis=1)
    result: Array = slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-12)
    return result


def _apart(points: Array, others: Array, gap: float) -> Index:
    """Rows of ``points`` (N, 3) that lie ``gap`` from one another and from ``others``, the loneliest first (farthest point sampling)."""
    left = np.linalg.norm(points[:, None] - others, axis=2).min(axis=1)
    chosen: list[int] = []
    while left.max() >= gap:
        chosen.append(int(left.argmax()))
        left = np.minimum(left, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen, dtype=np.int64)


__all__ = ["outlined"]
