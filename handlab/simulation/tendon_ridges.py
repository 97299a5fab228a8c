"""Extensor tendons that stand out below the skin of the back of the hand, for the eye: no force comes of it.

A tendon that pulls is straight: where the knuckle is bent backwards it leaves the bone and runs from the retinaculum of the wrist to the
finger, and skin that a slack tendon leaves smooth lies over it in a ridge. Beside the tendon the skin is a bent strip on an elastic bed
(Winkler): it falls off as e^(-x/l) (cos x/l + sin x/l), l^4 = 4 B / k, with bending stiffness B = E h^3 / 12 and bed k = E_tissue / depth.
Loose tissue above the tendon hides its relief: e^(-g/l_g) for a gap g, as any layer flattens waves of length 2 pi l_g. With the constants
of the soft skin l is 2.4 mm, less than an edge of its net (5 mm): ridges are put on the fine skin, on top of what springs and muscles do.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.physics.muscle import muscle_force
from handlab.simulation.geometric_kernel import first_hit
from handlab.simulation.hairy_skin import TISSUE, loose
from handlab.simulation.mechanics import fibre_lengths
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skin import normals
from handlab.simulation.soft_skin import THICKNESS, YOUNG
from handlab.simulation.tendons import SAMPLES, Course, courses

BAND = 0.002  # m: half the width of a tendon, which is a flat band there, not the round tube that is drawn: assumption
BED = 0.003  # m: depth of skin and tissue beside it: assumption, from sections of the reference hand
BED_STIFFNESS = TISSUE * float(loose(BED, THICKNESS)) / BED  # Pa/m
STRAIGHT = 0.25  # share of its greatest force at which a tendon is straight: assumption
MOST_BOW = 0.0015  # m: sagittal bands and fascia hold a tendon nearer to the bone than this: assumption
FLATTENED = 0.0013  # m: l_g above, for a ridge 8 mm from foot to foot
FADE = 0.008  # m: over which a ridge begins and ends
DEEP = 0.012  # m: a tendon deeper than this shows nowhere
LENGTH = (4.0 * YOUNG * THICKNESS**3 / 12.0 / BED_STIFFNESS) ** 0.25

# Via points (see ``tendon_table``): from the retinaculum over the knuckle to where the ridge ends; and the knuckle.
SPANS = {"common extensor": (3, 7, 8), "extensor of the": (3, 7, 8), "long extensor of the thumb": (3, 5, 6)}


class Taut(NamedTuple):
    """A tendon that can stand out: ``course`` of ``courses``, rows ``first`` to ``last`` of it, its ``muscle`` and ``knuckle`` (dof).

    ``way`` (n, 3): how its points leave the bed, bind posture, unit length over the knuckle; ``tent`` (n,): that length;
    ``reach`` m: how far they do for a knuckle bent back by a (small) angle of 1 rad.
    """

    course: int
    first: int
    last: int
    muscle: int
    knuckle: int
    way: Array
    tent: Array
    reach: float


class Ridges(NamedTuple):
    """Fine point ``point`` (r,) lies above the tendon ``tendon`` (r,) of ``taut``: ``share`` (r,) of its ridge there, where the tendon has
    ``tent`` (r,) of its bow, is ``thick`` (r,) m and has ``gap`` (r,) m of loose tissue above it."""

    point: Index
    tendon: Index
    share: Array
    tent: Array
    thick: Array
    gap: Array


@per_hand
def taut(hand: Hand) -> tuple[Taut, ...]:
    """The tendons that can stand out."""
    return tuple(found for k, course in enumerate(courses(hand)) if (found := _taut(hand, k, course)) is not None)


def _taut(hand: Hand, k: int, course: Course) -> Taut | None:
    vias = next((span for name, span in SPANS.items() if course.name.startswith(name)), None)
    if vias is None:
        return None
    first, top, last = (SAMPLES * via for via in vias)
    line = bed(course)
    walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    a, b = walked[top] - walked[first], walked[last] - walked[top]
    tent = np.interp(walked, walked[[first, top, last]], [0.0, 1.0, 0.0])
    digit = "1" if "thumb" in course.name else hand.body_names[course.nudged[last]][-1]
    return Taut(
        course=k,
        first=first,
        last=last,
        muscle=hand.muscle_names.index(course.muscle),
        knuckle=hand.dof_names.index(f"mcp{digit}.flexion_extension"),
        way=frozen(tent[:, None] * outward(hand, line)),
        tent=frozen(tent),
        reach=float(a * b / (a + b)),
    )


def bed(course: Course) -> Array:
    """Points (n, 3) of a course in the bind posture, where it lies when it is slack."""
    line: Array = course.spread @ course.point + course.nudge
    return line


def outward(hand: Hand, points: Array) -> Array:
    """Unit vectors (n, 3) out of the hand: the mean of those of the nearest points of the skin."""
    from scipy.spatial import cKDTree

    mean = normals(hand, hand.skin.points)[cKDTree(hand.skin.points).query(points, k=6)[1]].mean(axis=1)
    result: Array = mean / np.linalg.norm(mean, axis=1, keepdims=True)
    return result


@per_hand
def ridges(hand: Hand) -> Ridges:
    """Which points of the fine skin every tendon lifts."""
    fine, every = hand.skin_fine.points, courses(hand)
    corners = np.ascontiguousarray(hand.skin.points[hand.skin.faces])
    found = []
    for k, one in enumerate(taut(hand)):
        rows = slice(one.first, one.last + 1)
        line, radius = bed(every[one.course])[rows], every[one.course].radius
        way = outward(hand, line)
        deep = first_hit(np.ascontiguousarray(line), np.ascontiguousarray(way), corners)[0]
        walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        ends = np.clip(np.minimum(walked, walked[-1] - walked) / FADE, 0.0, 1.0)
        row, aside, above = _nearest(fine, line, way)
        at = np.arange(len(line))
        x = np.maximum(aside - BAND, 0.0) / LENGTH
        share = np.exp(-x) * (np.cos(x) + np.sin(x)) * np.interp(row, at, ends**2 * (3.0 - 2.0 * ends))
        share[(x > 0.75 * np.pi) | (above < 0.0) | (above > DEEP)] = 0.0
        mine = np.flatnonzero(share > 0.005)
        gap = np.interp(row[mine], at, np.minimum(deep, DEEP)) - radius - THICKNESS
        tent = np.interp(row[mine], at, one.tent[rows])
        found.append((mine, np.full(len(mine), k), share[mine], tent, np.full(len(mine), 2.0 * radius), gap))
    columns = [np.concatenate(column) for column in zip(*found, strict=True)]
    return Ridges(*(frozen(column, np.int64 if n < 2 else np.float64) for n, column in enumerate(columns)))


def _nearest(points: Array, line: Array, way: Array) -> tuple[Array, Array, Array]:
    """Where along a line (as a row with its fraction) points (n, 3) lie, how far beside it and how far above it."""
    step = np.diff(line, axis=0)
    from_start = points[:, None] - line[None, :-1]
    share = np.clip(np.einsum("nrd,rd->nr", from_start, step) / np.einsum("rd,rd->r", step, step), 0.0, 1.0)
    off = from_start - share[..., None] * step
    up = way[:-1] + share[..., None] * np.diff(way, axis=0)
    up /= np.linalg.norm(up, axis=2, keepdims=True)
    above = np.einsum("nrd,nrd->nr", off, up)
    aside = np.linalg.norm(off - above[..., None] * up, axis=2)
    row = (aside**2 + 0.25 * above**2).argmin(axis=1)
    n = np.arange(len(points))
    return row + share[n, row], aside[n, row], above[n, row]


@per_hand
def ridge_points(hand: Hand) -> Index:
    """All points (p,) of the fine skin that any tendon can lift, in rising order."""
    result: Index = frozen(np.unique(ridges(hand).point), np.int64)
    return result


def pulled(hand: Hand, angle: ArrayLike, contraction: ArrayLike) -> tuple[Array, Array]:
    """How straight every tendon of ``taut`` is (t,), 0 to 1, and how far (t,) m it has left the bone over the knuckle."""
    pose = np.asarray(angle, dtype=np.float64)
    force = muscle_force(np.asarray(contraction, dtype=np.float64), fibre_lengths(hand, pose) / hand.rest_length, 1.0)
    every = taut(hand)
    straight = np.clip(force[[one.muscle for one in every]] / STRAIGHT, 0.0, 1.0)
    back = np.maximum(np.sin(-pose[[one.knuckle for one in every]]), 0.0)
    bow: Array = straight * np.minimum(back * [one.reach for one in every], MOST_BOW)
    return straight, bow


def ridge_heights(hand: Hand, angle: ArrayLike, contraction: ArrayLike) -> Array:
    """How far (Nf,) m the points of the fine skin are lifted by tendons at ``angle`` (dof,) rad and ``contraction`` (muscle,)."""
    found = ridges(hand)
    straight, bow = (values[found.tendon] for values in pulled(hand, angle, contraction))
    bow = bow * found.tent
    own = found.share * straight * (bow + found.thick) * np.exp(-np.maximum(found.gap - bow, 0.0) / FLATTENED)
    height = np.zeros(len(hand.skin_fine.points))
    np.maximum.at(height, found.point, own)
    return height
