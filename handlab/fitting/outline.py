"""Outlines in a picture: which pixels a mesh covers, which pixels show the hand, and how well the two agree.

Picture coordinates are (x, y) in pixels: x to the right, y downwards, (0, 0) the top left corner of the picture, so that the
middle of the first pixel is (0.5, 0.5). Arrays of pixels are (rows, columns).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.meshes import Array, Index

Mask = NDArray[np.bool_]
AROUND = 0.02  # colours of the hand are taken within this part of the hand's size around each point
COARSE = 700  # a picture is reduced to about this many pixels on its longer side before the hand is looked for
SMOOTH = 2.0  # pixels of the reduced picture: grain of paper and sensor vanish, the outline stays
STEPS = (np.array([1, 0]), np.array([0, 1]), np.array([-1, 0]), np.array([0, -1]))  # right, down, left, up


def silhouette(points_px: Array, faces: Index, shape: tuple[int, int]) -> Mask:
    """Pixels (rows, columns) whose middle lies inside the projection of any triangle.

    ``points_px`` (N, 2), ``faces`` (M, 3), ``shape`` (rows, columns). Each row of pixels cuts a triangle in one interval: all
    intervals are added up at once. Parts outside the picture are cut off.

    >>> silhouette(np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]), np.array([[0, 1, 2]]), (3, 4)).astype(int)
    array([[1, 1, 1, 1],
           [1, 1, 1, 0],
           [1, 1, 0, 0]])
    """
    rows, columns = shape
    corner = np.asarray(points_px, np.float64)[faces]  # (M, 3, 2)
    corner = corner[np.isfinite(corner).all(axis=(1, 2))]
    first = np.clip(np.ceil(corner[:, :, 1].min(axis=1) - 0.5), 0, rows).astype(np.int64)
    last = np.clip(np.floor(corner[:, :, 1].max(axis=1) - 0.5), -1, rows - 1).astype(np.int64)
    count = np.maximum(last - first + 1, 0)
    triangle = np.repeat(np.arange(len(corner)), count)
    row = np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count) + first[triangle]
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for side in range(3):
        a, b = corner[triangle, side], corner[triangle, (side + 1) % 3]
        height = b[:, 1] - a[:, 1]
        level = np.abs(height) < 1e-12
        part = (row + 0.5 - a[:, 1]) / np.where(level, 1.0, height)
        x = a[:, 0] + part * (b[:, 0] - a[:, 0])
        cuts = ~level & (part >= 0.0) & (part <= 1.0)
        left = np.where(cuts, np.minimum(left, x), left)
        right = np.where(cuts, np.maximum(right, x), right)
    cut = np.isfinite(left)
    start = np.clip(np.ceil(left[cut] - 0.5), 0, columns).astype(np.int64)
    stop = np.clip(np.floor(right[cut] - 0.5) + 1, 0, columns).astype(np.int64)
    covered = stop > start
    change = np.zeros((rows, columns + 1), np.int64)
    np.add.at(change, (row[cut][covered], start[covered]), 1)
    np.add.at(change, (row[cut][covered], stop[covered]), -1)
    result: Mask = np.cumsum(change, axis=1)[:, :-1] > 0
    return result


def overlap(one: Mask, other: Mask, where: Mask | None = None) -> float:
    """IoU, intersection over union of two masks, 0 to 1 (of the pixels of ``where`` only, if given); 0 where both are empty.

    Raises ``ValueError`` for masks of different shape.

    >>> overlap(np.array([[True, True, False]]), np.array([[False, True, True]])).__round__(3)
    0.333
    """
    if one.shape != other.shape or (where is not None and where.shape != one.shape):
        raise ValueError(f"the masks have {one.shape} and {other.shape} pixels; compare outlines of one picture")
    if where is not None:
        one, other = one & where, other & where
    union = int((one | other).sum())
    return int((one & other).sum()) / union if union else 0.0


def distal_of(wrist_px: Array, towards_px: Array, shape: tuple[int, int]) -> Mask:
    """Pixels on the hand's side of the line through two points of the wrist.

    ``wrist_px`` (2, 2): radial and ulnar point of the wrist; ``towards_px`` (2,): any point of the hand, say the middle of the
    knuckles. A sleeve, a strap and the forearm stay out of the comparison. Raises ``ValueError`` if the three are on one line.
    """
    (a, b), c = np.asarray(wrist_px, np.float64), np.asarray(towards_px, np.float64)
    along = b - a
    side = along[0] * (c[1] - a[1]) - along[1] * (c[0] - a[0])
    if abs(side) < 1e-9 * max(1.0, float(along @ along)):
        raise ValueError("the two points of the wrist and the hand lie on one line; mark the two sides of the wrist")
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]] + 0.5
    result: Mask = (along[0] * (y - a[1]) - along[1] * (x - a[0])) * side > 0
    return result


def hand_mask(picture: NDArray[np.uint8], points_px: Array) -> Mask:
    """Pixels that show the hand: ``small_mask`` in the pixels of the picture. Raises ``ValueError`` as it does."""
    whole, step = small_mask(picture, points_px)
    rows, columns = picture.shape[:2]
    result: Mask = np.repeat(np.repeat(whole, step, axis=0), step, axis=1)
    return np.pad(result, ((0, max(0, rows - len(result))), (0, max(0, columns - result.shape[1]))), mode="edge")[:rows, :columns]


def small_mask(picture: NDArray[np.uint8], points_px: Array) -> tuple[Mask, int]:
    """Squares of pixels that show the hand, on a plain background of any other colour, dark or light, and how many pixels wide they are.

    ``picture`` (rows, columns, 3), ``points_px`` (N, 2): points on the hand (the feature points), at least three. The colours of
    hand and background are learnt from the picture itself: near the points, and along the picture's edge. The best line
    between the two (Fisher's discriminant, Otsu's threshold) parts all pixels; of the hand's the piece with the points is
    taken, and holes in it are filled. Raises ``ValueError`` where hand and background do not differ.
    """
    from scipy.ndimage import binary_fill_holes, binary_opening, gaussian_filter, label

    points = np.asarray(points_px, np.float64)
    rows, columns = picture.shape[:2]
    inside = (points[:, 0] >= 0) & (points[:, 0] < columns) & (points[:, 1] >= 0) & (points[:, 1] < rows)
    if inside.sum() < 3:
        raise ValueError(f"only {int(inside.sum())} of {len(points)} points lie in the picture; the hand is looked for around at least 3")
    step = max(1, round(max(rows, columns) / COARSE))
    small = reduced(picture, step)
    colour = np.stack([gaussian_filter(small[:, :, i], SMOOTH) for i in range(3)], axis=2)
    seeds = np.clip((points[inside] / step).astype(int), 0, [small.shape[1] - 1, small.shape[0] - 1])
    hand, ground = _examples(colour, seeds)
    value = colour @ _discriminant(hand, ground)
    low, high = np.median(ground @ _discriminant(hand, ground)), np.median(hand @ _discriminant(hand, ground))
    spread = np.std(hand @ _discriminant(hand, ground)) + np.std(ground @ _discriminant(hand, ground))
    if high - low < 2.0 * spread or high - low < 1e-9:
        raise ValueError(
            "hand and background have nearly the same colour in this picture; photograph the hand on a plain, darker or lighter ground"
        )
    limit = threshold(np.clip(value, low, high))
    coarse = binary_opening(value > limit, iterations=1)
    pieces, _ = label(coarse)
    touched = pieces[seeds[:, 1], seeds[:, 0]]
    if not touched.any():
        raise ValueError("none of the points lies on the hand that the picture shows; check the points and the picture belong together")
    whole: Mask = binary_fill_holes(pieces == np.bincount(touched[touched > 0]).argmax())
    return whole, step


def contour(mask: Mask) -> Array:
    """The outer border (K, 2) in pixels of the largest piece of ``mask``, closed and clockwise as seen; (0, 2) if it is empty.

    >>> contour(np.array([[False, False], [False, True]])).tolist()
    [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]
    """
    from scipy.ndimage import label

    pieces, number = label(mask)
    if number == 0:
        return np.zeros((0, 2))
    piece = np.pad(pieces == np.bincount(pieces[pieces > 0]).argmax(), 1)
    start = np.argwhere(piece)[0][::-1]  # the first pixel of the first row: its upper edge is border
    at, heading = start.copy(), 0
    line: list[Index] = []
    while not line or heading != 0 or (at != start).any():
        line.append(at - 1)
        at = at + STEPS[heading]
        for turn in (-1, 0, 1):  # keep the piece on the right hand
            way = (heading + turn) % 4
            if _borders(piece, at, way):
                heading = way
                break
    return np.array(line, np.float64)


def _borders(piece: Mask, at: NDArray[np.int64], way: int) -> bool:
    """Whether the edge that leaves corner ``at`` in direction ``way`` has the piece on its right and none on its left."""
    x, y = at
    right = {0: (y, x), 1: (y, x - 1), 2: (y - 1, x - 1), 3: (y - 1, x)}[way]
    left = {0: (y - 1, x), 1: (y, x), 2: (y, x - 1), 3: (y - 1, x - 1)}[way]
    return bool(piece[right]) and not bool(piece[left])


def reduced(picture: NDArray[np.uint8], step: int) -> Array:
    """Means of squares of ``step`` pixels; the last, incomplete ones are left out."""
    rows, columns = max(1, picture.shape[0] // step), max(1, picture.shape[1] // step)
    total = np.zeros((rows, columns, 3))
    for i in range(step):
        for j in range(step):
            total += picture[i::step, j::step][:rows, :columns]
    mean: Array = total / step**2
    return mean


def _examples(colour: Array, seeds: Index) -> tuple[Array, Array]:
    """Colours (K, 3) of the hand, near the points, and of the background: the edge of the picture without what looks like the hand."""
    radius = max(1, int(AROUND * np.ptp(seeds, axis=0).max()))
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1].reshape(2, -1)
    across = np.clip(seeds[:, :1] + x, 0, colour.shape[1] - 1)
    down = np.clip(seeds[:, 1:] + y, 0, colour.shape[0] - 1)
    near = colour[down, across].reshape(-1, 3)
    edge = np.concatenate([colour[0], colour[-1], colour[:, 0], colour[:, -1]])
    off = np.linalg.norm(edge - np.median(edge, axis=0), axis=1)
    ground = edge[off <= 3 * np.median(off) + 2]
    middle = np.median(near, axis=0)  # tips and wrists lie on the outline: a part of what is near them is background
    hand = near[np.linalg.norm(near - middle, axis=1) < np.linalg.norm(near - np.median(ground, axis=0), axis=1)]
    return (hand if len(hand) else near), ground


def _discriminant(hand: Array, ground: Array) -> Array:
    """Fisher's direction in colour space, from background to hand, of unit length."""
    within = np.cov(hand.T) + np.cov(ground.T) + 4.0 * np.eye(3)
    direction: Array = np.linalg.solve(within, hand.mean(axis=0) - ground.mean(axis=0))
    return direction / max(float(np.linalg.norm(direction)), 1e-12)


def threshold(value: Array) -> float:
    """Otsu's threshold (1979): the two classes differ most."""
    count, edges = np.histogram(value, bins=256)
    middle = (edges[1:] + edges[:-1]) / 2
    below = np.cumsum(count)
    above = below[-1] - below
    total = np.cumsum(count * middle)
    with np.errstate(divide="ignore", invalid="ignore"):
        between = below * above * (total / below - (total[-1] - total) / above) ** 2
    return float(edges[1:][np.nanargmax(between)])
