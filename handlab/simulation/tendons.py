"""Tendons of the muscles of the forearm as tubes, for the eye only: mechanics knows lever arms, not these lines.

Every tendon runs through points fixed to bodies (its pulleys and its insertion); where a joint bends under it, it is laid over the
head of the bone. Courses as in any atlas of anatomy; how far above the bone a tendon runs is chosen by eye on the reference hand.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.simulation.bone_frames import BoneFrames
from handlab.simulation.bones_below import bodies, in_bone, nearest_bone
from handlab.simulation.geometric_kernel import first_hit
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.per_hand import per_hand
from handlab.simulation.tendon_balls import Balls, in_the_way, none, postures
from handlab.simulation.tendon_kernel import lifted
from handlab.simulation.tendon_table import COURSES, Flat, Ring

SAMPLES = 7  # points of a tube from one via point to the next
EVEN = 2  # smoothing passes
LIFTS = 5  # rounds of lifting a tendon out of bone in a pose
ENDING = 4  # points of an end that may go into its bone
NUDGES = 5  # rounds of lifting points off the bones
FAR = 0.06  # metres: where rays towards a bone begin


class Tube(NamedTuple):
    """``points`` (n, 3) m along a tendon from the forearm to its end, ``radius`` m, and the pseudo ``muscle`` that it belongs to."""

    name: str
    muscle: str
    points: Array
    radius: float


@dataclass(frozen=True)
class Course:
    """One tendon in the bind posture: via points ``point`` (v, 3) on bodies ``body`` (v,), smoothing matrix ``spread`` (n, v);
    ``up`` (v, 3) points out of the bone there.

    ``nudge`` (n, 3) with bodies ``nudged`` (n,): what lifts the curve off the bones between its via points.
    It is laid over joints: ``centre``, ``axis`` (j, 3) on bodies ``carrier`` (j,), at the distance ``reach`` (j,), and out of ``balls``.
    """

    name: str
    muscle: str
    radius: float
    point: Array
    up: Array
    body: Index
    spread: Array
    nudge: Array
    nudged: Index
    centre: Array
    axis: Array
    carrier: Index
    reach: Array
    balls: Balls


def tendons(hand: Hand, angle: ArrayLike, contraction: ArrayLike | None = None) -> tuple[Tube, ...]:
    """All extrinsic tendons at ``angle`` (dof,) rad, the same number of points in every pose. A picture: no force comes from it.

    Muscles that pull, at ``contraction`` (muscle,), straighten those of the back of the hand (see ``tendon_ridges``).
    """
    moved, off = relative_transforms(hand, angle), [course.nudge for course in courses(hand)]
    if contraction is not None:
        from handlab.simulation.tendon_ridges import pulled, taut

        for one, bow in zip(taut(hand), pulled(hand, angle, contraction)[1], strict=True):
            off[one.course] = off[one.course] + bow * one.way
    return tuple(
        Tube(course.name, course.muscle, laid(course, moved, nudge), course.radius)
        for course, nudge in zip(courses(hand), off, strict=True)
    )


def laid(course: Course, moved: Array, nudge: Array | None = None) -> Array:
    """Points (n, 3) of a tendon for ``relative_transforms``; ``nudge`` (n, 3): another one than its own, as where it is straight."""
    line, balls = _bare(course, moved, course.nudge if nudge is None else nudge), course.balls
    up: Array = course.spread @ _turned(moved, course.body, course.up)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    lifted(line, up, _carried(moved, balls.body, balls.centre), balls.radius + course.radius, balls.first, balls.last, LIFTS)
    return line


def _turned(moved: Array, body: Index, way: Array) -> Array:
    result: Array = np.einsum("...vij,vj->...vi", moved[..., body, :3, :3], way)
    return result


def _carried(moved: Array, body: Index, point: Array) -> Array:
    result: Array = _turned(moved, body, point) + moved[..., body, :, :][..., :3, 3]
    return result


def _bare(course: Course, moved: Array, nudge: Array) -> Array:
    """Points (..., n, 3) of a tendon in one posture ``moved`` (..., bodies, 4, 4) or in many, before it is lifted out of balls."""
    line: Array = course.spread @ _carried(moved, course.body, course.point) + _turned(moved, course.nudged, nudge)
    centre, axis = _carried(moved, course.carrier, course.centre), _turned(moved, course.carrier, course.axis)
    for _ in range(EVEN):
        _lay_over(line, centre, axis, course.reach)
        line[..., 1:-1, :] = 0.5 * line[..., 1:-1, :] + 0.25 * line[..., :-2, :] + 0.25 * line[..., 2:, :]
    _lay_over(line, centre, axis, course.reach)
    return line


def _lay_over(line: Array, centre: Array, axis: Array, reach: Array) -> None:
    """Push points that came nearer to a joint's axis than the head of the bone allows straight outwards."""
    for j, r in enumerate(reach):
        a = axis[..., j, None, :]
        way = line - centre[..., j, None, :]
        along = (way * a).sum(axis=-1)
        way = way - along[..., None] * a
        far = np.linalg.norm(way, axis=-1)
        near = (far < r) & (np.abs(along) < r) & (far > 1e-4)
        line[near] += way[near] * (r / far[near] - 1.0)[:, None]


@per_hand
def courses(hand: Hand) -> tuple[Course, ...]:
    """The courses of all tendons on one hand."""
    at = _Bones(hand)
    found = []
    for name, muscle, radius_mm, vias in COURSES:
        points, ups, bodies = zip(*(at.via(via, radius_mm) for via in vias), strict=True)
        joints = [via.over for via in vias if isinstance(via, Ring) and via.over]
        if any(isinstance(via, Flat) for via in vias):
            joints.insert(0, "wrist")
        line = np.array(points)
        spread = _catmull_rom(line)
        nudge, nudged = at.lifted(spread @ line, 1e-3 * radius_mm)
        under = [at.joint(joint, spread @ line + nudge) for joint in joints]
        centre, axis, carrier, reach = zip(*under, strict=True) if under else ((), (), (), ())
        course = Course(
            name,
            hand.muscles[muscle].name,
            1e-3 * radius_mm,
            frozen(line),
            frozen(ups),
            frozen(bodies, np.int64),
            frozen(spread),
            frozen(nudge),
            frozen(nudged, np.int64),
            frozen(np.reshape(centre, (-1, 3))),
            frozen(np.reshape(axis, (-1, 3))),
            frozen(carrier, np.int64),
            frozen(reach),
            none(),
        )
        lines = _bare(course, postures(hand), course.nudge)[:, :-ENDING]
        found.append(replace(course, balls=in_the_way(hand, lines, course.radius)))
    return tuple(found)


def _catmull_rom(line: Array) -> Array:
    """Weights (n, v) of a smooth curve through v points; rows add to 1."""
    count = len(line)
    if count < 3:
        share = np.linspace(0.0, 1.0, SAMPLES + 1)[:, None]
        return np.concatenate([1.0 - share, share], axis=1)
    unit = np.concatenate([2 * np.eye(count)[:1] - np.eye(count)[1:2], np.eye(count), 2 * np.eye(count)[-1:] - np.eye(count)[-2:-1]])
    rows = []
    for k in range(count - 1):
        a, b, c, d = unit[k : k + 4]
        for t in np.arange(SAMPLES) / SAMPLES:
            rows.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3))
    return np.array([*rows, np.eye(count)[-1]])


class _Bones(BoneFrames):
    """Places of tendons on the bones of one hand in the bind posture."""

    def via(self, via: Ring | Flat, radius_mm: float) -> tuple[Array, Array, int]:
        """Place of a via point, which way is out of the bone there, and its body."""
        body = via.body if isinstance(via, Flat) else self.hand.bones[via.bone].body
        if isinstance(via, Flat):
            way = np.array([0.0, 1.0 if via.palmar else -1.0, 0.0])
            start = self.centre["wrist"] + self.size * np.array([via.distal, 0.0, self.radial * via.radial])
            bones = [name for name, bone in self.hand.bones.items() if bone.body == body and not name.startswith("metacarpal")]
        else:
            base, head, palmar, radial = self.frame(via.bone)
            start, bones = base + via.along * (head - base), [via.bone]
            way = via.palmar * palmar + via.radial * radial
            way /= np.linalg.norm(way)
        return self._onto(bones, start, way, via.lift_mm + radius_mm), way, self.hand.body_names.index(body)

    def _onto(self, bones: list[str], start: Array, way: Array, lift_mm: float) -> Array:
        corners = np.concatenate([self.hand.bones[name].points[self.hand.bones[name].faces] for name in bones])
        distance = first_hit((start + FAR * way)[None], -way[None], corners)[0][0]
        height = FAR - distance if np.isfinite(distance) else 0.0
        place: Array = start + (height + 1e-3 * lift_mm) * way
        return place

    def lifted(self, line: Array, radius: float) -> tuple[Array, Index]:
        """Moves (n, 3) that take a curve out of the bones, and the bodies (n,) of the bones below it."""
        start = line.copy()
        for _ in range(NUDGES):
            place, distance, bone = nearest_bone(self.hand, line)
            inside = in_bone(self.hand, line)
            away = np.where(inside[:, None], place - line, line - place) / np.maximum(distance, 1e-9)[:, None]
            short = np.where(inside, radius + distance, radius - distance)
            short[-ENDING:] = 0.0
            line = line + np.maximum(short, 0.0)[:, None] * away
            line[1:-ENDING] = 0.5 * line[1:-ENDING] + 0.25 * line[: -ENDING - 1] + 0.25 * line[2 : len(line) - ENDING + 1]
        return line - start, bodies(self.hand)[bone]

    def joint(self, name: str, line: Array) -> tuple[Array, Array, int, float]:
        """What a tendon is laid over at a joint: centre, axis, the body that carries both, and how near it comes in the bind posture."""
        centre, axis = self.centre[name], self.axes[f"{name}.flexion_extension"]
        parent = self.hand.joints[name].parent
        body = self.hand.bones[parent].body if parent in self.hand.bones else parent
        way = line - centre
        way = way - (way @ axis)[:, None] * axis
        return centre, axis, self.hand.body_names.index(body), float(np.linalg.norm(way, axis=1).min())
