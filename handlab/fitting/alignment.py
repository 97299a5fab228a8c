"""Clicks in a picture laid onto the feature points of a hand (section 5.2): which side they show, how they lie, how large they are.

In the picture a place is (x, y) in millimetres, x to the right and y *upwards*. The camera looks along -v; with the unit vectors
``across``, ``up`` and v of a right-handed frame, a hand of the right side shows up turned, one of the other side mirrored.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlab.anatomy.mirror import mirrored
from handlab.anatomy.records import Array, Hand
from handlab.fitting.landmarks import VIEWS, source_points
from handlab.fitting.mistakes import FitError, FitQuestion

# How far the camera's direction is likely to lie from ``likely_view`` (an assumption).
LIKELY_TILT = np.deg2rad(2.5)
# Scatter (mm) of the points of two hands of one size after the best similarity: where the search for a tilt begins (an assumption).
LIKELY_SCATTER_MM = 5.0
ROUNDS = 60
# A mirrored fit must be this much worse before the side counts as certain.
CERTAIN = 1.5
OTHER = {"right": "left", "left": "right", "palmar": "dorsal", "dorsal": "palmar"}
SIDES = ("right", "left")
SHOWN = {"palmar": "palm", "dorsal": "back"}


@dataclass(frozen=True, eq=False)
class Frame:
    """A camera far away: unit vectors (3,) of the picture in the frame of the hand; ``towards`` points to the camera."""

    across: Array
    up: Array
    towards: Array
    origin: Array

    def flat(self, points: Array) -> Array:
        """Places (..., 2) in the picture's plane."""
        result: Array = (points - self.origin) @ np.stack([self.across, self.up], axis=1)
        return result

    def height(self, points: Array) -> Array:
        """Heights (...,) towards the camera."""
        result: Array = (points - self.origin) @ self.towards
        return result

    def lifted(self, flat: Array, height: Array) -> Array:
        """Points (..., 3) from places in the plane and heights."""
        result: Array = self.origin + flat @ np.stack([self.across, self.up]) + np.asarray(height)[..., None] * self.towards
        return result


@dataclass(frozen=True, eq=False)
class Similarity:
    """Picture = ``scale`` * turned(plane) + ``shift``; ``matrix`` (2, 2) the turn (det -1: mirrored), ``residual`` (N, 2) in mm."""

    scale: float
    matrix: Array
    shift: Array
    residual: Array

    @property
    def scatter(self) -> float:
        """Root mean square distance of the points, mm."""
        return float(np.sqrt(np.mean(np.sum(self.residual**2, axis=1))))


def similarity(plane: Array, picture: Array, *, mirror: bool = False) -> Similarity:
    """The least-squares similarity from ``plane`` to ``picture`` (N, 2), point by point (Umeyama 1991); ``mirror``: a mirrored one."""
    a, b = plane - plane.mean(axis=0), picture - picture.mean(axis=0)
    left, size, right = np.linalg.svd(b.T @ a)
    sign = np.array([1.0, np.linalg.det(left @ right) * (-1.0 if mirror else 1.0)])
    turn = left @ (sign[:, None] * right)
    scale = float((size * sign).sum() / max(float(np.sum(a**2)), 1e-300))
    shift = picture.mean(axis=0) - scale * turn @ plane.mean(axis=0)
    return Similarity(scale, turn, shift, picture - scale * plane @ turn.T - shift)


def fitting_plane(points: Array, view: str) -> Frame:
    """The plane that fits ``points`` (N, 3) best, seen from the palm or the back: centroid, direction of least spread (section 5.2)."""
    origin = points.mean(axis=0)
    directions = np.linalg.svd(points - origin)[2]
    sign = 1.0 if view == "palmar" else -1.0
    return frame_towards(directions[2] * (sign if directions[2][1] >= 0.0 else -sign), origin)


def frame_towards(direction: Array, origin: Array) -> Frame:
    """A frame whose picture has the fingers (x of the hand) upwards."""
    towards = direction / np.linalg.norm(direction)
    up = np.array([1.0, 0.0, 0.0]) - towards[0] * towards
    up /= np.linalg.norm(up)
    return Frame(np.cross(up, towards), up, towards, origin)


def tilted(points: Array, start: Frame, picture: Array, held: Array | None = None) -> tuple[Frame, Similarity]:
    """The frame near ``start`` (near the direction ``held`` (3,), if given) in which ``points`` (N, 3) look most like ``picture`` (N, 2).

    A tilt shifts points in proportion to their height, so it is a linear unknown; it is held near zero as strongly as
    the scatter of the points makes it doubtful: for a picture of the very same hand there is no scatter, and the tilt is exact.
    """
    frame, found = start, similarity(start.flat(points) * 1e3, picture)
    held = start.towards if held is None else held
    scatter = LIKELY_SCATTER_MM
    for _ in range(ROUNDS):
        plane, height = frame.flat(points) * 1e3, frame.height(points) * 1e3
        height = height - height.mean()
        n = len(points)
        # unknowns: a, b of the similarity [[a, -b], [b, a]], two shifts, two tilts times the similarity
        rows = np.zeros((2 * n, 6))
        rows[0::2, 0], rows[0::2, 1], rows[0::2, 2], rows[0::2, 4] = plane[:, 0], -plane[:, 1], 1.0, height
        rows[1::2, 0], rows[1::2, 1], rows[1::2, 3], rows[1::2, 5] = plane[:, 1], plane[:, 0], 1.0, height
        # tilt already taken counts against the prior too
        taken = np.array([held @ frame.across, held @ frame.up])
        weight = scatter / LIKELY_TILT
        a, b = found.scale * found.matrix[:, 0]
        turn = np.array([[a, -b], [b, a]])
        prior = np.zeros((2, 6))
        prior[:, 4:] = weight * np.eye(2) / max(found.scale, 1e-9)
        goal = np.concatenate([picture.reshape(-1), -weight * turn @ taken / max(found.scale, 1e-9)])
        a, b, *_, u, v = np.linalg.lstsq(np.vstack([rows, prior]), goal, rcond=None)[0]
        step = np.linalg.solve(np.array([[a, -b], [b, a]]), np.array([u, v]))
        frame = frame_towards(frame.towards - step[0] * frame.across - step[1] * frame.up, frame.origin)
        found = similarity(frame.flat(points) * 1e3, picture)
        scatter = max(float(np.sqrt(np.sum(found.residual**2) / max(2 * n - 6, 1))), 1e-9)
        if np.linalg.norm(step) < 1e-12:
            break
    return frame, found


@dataclass(frozen=True, eq=False)
class Aligned:
    """Which hand the clicks show and how they lie on it.

    ``hand``: the reference hand of that side; ``view`` "palmar" or "dorsal"; ``source`` (N, 3) m its feature points; ``frame``;
    ``fit``: the similarity from the frame's plane (mm) to the picture (mm, y upwards); ``rule`` by which it was found; ``start`` (3,): the
    direction of the camera before any tilt was looked for; ``marks`` of the hand that were compared.
    """

    hand: Hand
    view: str
    source: Array
    frame: Frame
    fit: Similarity
    rule: str
    start: Array
    marks: str


def conclude(
    hand: Hand, names: tuple[str, ...], picture: Array, *, view: str | None, side: str | None, mirror: bool = False
) -> tuple[Hand, str]:
    """The hand (of the side that was photographed) and the view that clicks ``picture`` (N, 2) mm, y upwards, show.

    A palm and the back of the other hand look alike, so one of ``view`` ("palmar", "dorsal") and ``side`` ("right", "left") must
    be known; where neither is, ``FitQuestion`` asks. ``FitError`` where both are given and the points say otherwise. ``mirror``: the
    picture itself is mirrored, as many telephones show their owner.
    """
    for value, known, name in ((view, VIEWS, "view"), (side, SIDES, "side")):
        if value is not None and value not in known:
            raise ValueError(f"{name} is {value!r}; it must be {known[0]!r} or {known[1]!r}")
    seen = picture * np.array([-1.0, 1.0]) if mirror else picture
    right = hand if hand.side == "right" else mirrored(hand)
    # a right palm and a left back show the thumb on one side, a left palm and a right back on the other
    one = _scatter(right, "palmar", names, seen, False) + _scatter(right, "dorsal", names, seen, True)
    other = _scatter(right, "palmar", names, seen, True) + _scatter(right, "dorsal", names, seen, False)
    certain = max(one, other) > CERTAIN * min(one, other)
    palm = "right" if one <= other else "left"  # whose palm it would be
    if not certain:
        if view is None or side is None:
            raise FitQuestion(
                "these points look nearly the same turned and mirrored, so they do not tell which hand it is; "
                "say both view='palmar' or 'dorsal' and side='right' or 'left', or add points on the thumb",
                choices=tuple({"view": v, "side": s} for v in VIEWS for s in SIDES),
            )
    elif view is None and side is None:
        raise FitQuestion(
            f"this is the palm of a {palm} hand or the back of a {OTHER[palm]} hand, and points cannot tell which; "
            f"say view='palmar' or view='dorsal' (or side='right' or side='left')",
            choices=({"view": "palmar"}, {"view": "dorsal"}),
        )
    elif view is None:
        view = "palmar" if side == palm else "dorsal"
    elif side is None:
        side = palm if view == "palmar" else OTHER[palm]
    elif (side == palm) != (view == "palmar"):
        raise FitError(
            f"these points show the palm of a {palm} hand or the back of a {OTHER[palm]} hand, not the {SHOWN[view]} of a {side} hand; "
            f"give side={OTHER[side]!r} or view={OTHER[view]!r}, or mirror=True if the picture itself is mirrored"
        )
    own = right if side == "right" else mirrored(right)
    return own, view or VIEWS[0]


def _scatter(hand: Hand, view: str, names: tuple[str, ...], picture: Array, mirror: bool) -> float:
    """Scatter (mm) of the best similarity over its own size, with what two people of one size always differ by."""
    frame = fitting_plane(source_points(hand, view), view)
    found = similarity(frame.flat(source_points(hand, view, names)) * 1e3, picture, mirror=mirror)
    return float(np.hypot(found.scatter / max(found.scale, 1e-9), LIKELY_SCATTER_MM))


def aligned(hand: Hand, view: str, names: tuple[str, ...], picture: Array, marks: str) -> Aligned:
    """The default rule: a least-squares similarity over the points at hand, seen from where they look most alike.

    ``picture`` (N, 2) mm, y upwards, not mirrored. The camera is looked for around ``likely_view``. ``marks`` as for ``source_points``.
    """
    source = source_points(hand, view, names, marks)
    start = frame_towards(likely_view(hand, view), source.mean(axis=0))
    frame, fit = tilted(source, start, picture)
    return Aligned(hand, view, source, frame, fit, "least squares", start.towards, marks)


def likely_view(hand: Hand, view: str) -> Array:
    """From where (3,) a hand on a table is likely seen: half way between the normals of its palm (forearm and palm lie flat) and of
    the fitting plane of all its points (thumb and finger tips lie flat too). All 26 points count, so that those left out do not tilt it."""
    palm = np.array([0.0, 1.0 if view == "palmar" else -1.0, 0.0])
    return palm + fitting_plane(source_points(hand, view), view).towards


def aligned_printed(hand: Hand, view: str, names: tuple[str, ...], picture: Array, marks: str) -> Aligned:
    """The paper's rule: fitting plane of the points at hand, the largest diameters of both sets on one line.

    The paper leaves open which end comes first; the one with the smaller scatter is taken. The scale is the ratio of the diameters.
    """
    source = source_points(hand, view, names, marks)
    frame = fitting_plane(source, view)
    plane = frame.flat(source) * 1e3
    (i, j), source_size = diameter(plane)
    (k, m), target_size = diameter(picture)
    way, seen = plane[j] - plane[i], picture[m] - picture[k]
    scale = target_size / source_size
    fits = []
    for half_turn in (0.0, np.pi):
        angle = np.arctan2(seen[1], seen[0]) - np.arctan2(way[1], way[0]) + half_turn
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        shift = picture.mean(axis=0) - scale * turn @ plane.mean(axis=0)
        fits.append(Similarity(scale, turn, shift, picture - scale * plane @ turn.T - shift))
    best = min(fits, key=lambda found: found.scatter)
    return Aligned(hand, view, source, frame, best, "printed", frame.towards, marks)


def diameter(points: Array) -> tuple[tuple[int, int], float]:
    """The two points (N, 2 or 3) farthest from each other, and their distance."""
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    i, j = np.unravel_index(int(apart.argmax()), apart.shape)
    return (int(min(i, j)), int(max(i, j))), float(apart[i, j])
