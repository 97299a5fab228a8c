"""What stays of muscles and tendons in the viewer, packed once per hand; frames bring the segments, the bones bring the tendons.

A surface of ``muscle_surface`` is a product: places along the fibres (B-spline weights) times a section across them. Both factors are
small and travel; the viewer multiplies (``static/flesh.js``). It draws every second ring and every second point of a ring, and
leaves out the last correction of the volume (a hundredth or two of the thickness).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show import wire
from handlab.simulation.geometric_muscle import OVERLAP, GeometricMuscles, geometric_muscles
from handlab.simulation.muscle_surface import TIP, Skeleton, skeletons, tube_faces
from handlab.simulation.per_hand import per_hand
from handlab.simulation.tendon_ridges import MOST_BOW, STRAIGHT, taut
from handlab.simulation.tendons import EVEN, LIFTS, courses

STRIDE = 2  # of all rings and points of a section, every second is drawn
ROUND = 6  # corners of a tendon's section
SINEW = (226, 233, 236)
HEAD = {
    "overlap": OVERLAP,
    "tip": TIP,
    "round": ROUND,
    "half_unit": wire.HALF_UNIT,
    "stride": STRIDE,
    "even": EVEN,
    "lifts": LIFTS,
    "straight": STRAIGHT,
    "most_bow": MOST_BOW,
}


@per_hand
def packed_layers(hand: Hand) -> bytes:
    """Names, sections and triangles of all muscles; courses and triangles of all tendons; in the layout of ``wire.packed``."""
    muscles, muscle_arrays = bellies(hand)
    first = len(muscle_arrays["tone"])
    tendons, tendon_arrays = sinews(hand, first, muscle_arrays["faces"].size)
    pale = np.tile(np.array(SINEW, dtype="u1"), (tendons[-1]["end"] - first, 1))
    both = {
        "faces": np.concatenate([muscle_arrays["faces"], tendon_arrays.pop("tendon_faces")]).astype("<u2"),
        "tone": np.concatenate([muscle_arrays["tone"], pale]),
    }
    return wire.packed({"muscles": muscles, "tendons": tendons, **HEAD}, {**muscle_arrays, **tendon_arrays, **both})


def packed_bellies(hand: Hand, muscles: GeometricMuscles) -> bytes:
    """The same of ``muscles`` alone, without tendons."""
    told, arrays = bellies(hand, muscles)
    return wire.packed({"muscles": told, "tendons": [], **HEAD}, {**arrays, "faces": arrays["faces"].astype("<u2")})


def bellies(hand: Hand, muscles: GeometricMuscles | None = None) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Every muscle of the hand, or of ``muscles``: names and sizes; weights along and across, triangles and colours of all."""
    from handlab.show.muscle_layer import BUNDLE, tones

    muscles = geometric_muscles(hand) if muscles is None else muscles
    told, along, across, faces, tone = [], [], [], [], []
    points = corners = 0
    for name, drives, part, fibres, kept in zip(
        muscles.names, muscles.drives, muscles.segments, muscles.fibres, skeletons(muscles), strict=True
    ):
        length, section, u, v = factors(kept, (part.stop - part.start) // fibres, fibres)
        stations, ring = len(length), len(section)
        mesh = tube_faces(stations, ring, inwards=inwards(kept))
        count = stations * ring + 2
        told.append(
            {
                "name": name, "title": name.replace("_", " "),
                "drives": [hand.muscle_names.index(one) for one in drives],
                "segment": part.start, "segments": (part.stop - part.start) // fibres, "fibres": fibres, "stations": stations, "ring": ring,
                "first": points, "end": points + count, "corner": corners, "last": corners + mesh.size,
            }
        )  # fmt: skip
        bundles = round(np.count_nonzero(kept.u == kept.u[0]) / (2 * BUNDLE))
        tone.append(tones(u, v, bundles=bundles))
        along.append(length.ravel())
        across.append(section.ravel())
        faces.append(mesh + points)
        points, corners = points + count, corners + mesh.size
    return told, {
        "along": np.concatenate(along).astype("<f4"),
        "across": np.concatenate(across).astype("<f4"),
        "faces": np.concatenate(faces),
        "tone": np.concatenate(tone),
    }


def factors(kept: Skeleton, segments: int, fibres: int) -> tuple[Array, Array, Array, Array]:
    """Weights along (stations, segments + 2), a section (ring, 3 fibres: middle, sideways, rise), and ``u``, ``v`` of the points drawn."""
    controls = segments + 2
    body = len(kept.u) - 2  # the last two are the tips
    ring = int(np.count_nonzero(kept.u[:body] == kept.u[0]))
    stations = body // ring
    spine = kept.spine[:body].reshape(stations, ring, fibres, controls)
    girth = kept.girth[:body].reshape(stations, ring, 2, fibres, controls)
    length = spine.sum(axis=2)[::STRIDE, 0]
    section = np.concatenate([spine[0].sum(axis=2), girth[0, :, 0].sum(axis=2), girth[0, :, 1].sum(axis=2)], axis=1)[::STRIDE]
    u, v = (np.concatenate([w[:body].reshape(stations, ring)[::STRIDE, ::STRIDE].ravel(), w[body:]]) for w in (kept.u, kept.v))
    return length, section, u, v


def inwards(kept: Skeleton) -> bool:
    """Whether the triangles of a surface run the other way about."""
    return int(kept.faces[0, 2]) == 0


def sinews(hand: Hand, first: int, corner: int) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Every tendon: names and sizes; via points, weights and joints of all, and triangles of their tubes, after ``first`` points and
    ``corner`` corners of triangles."""
    told: list[dict[str, Any]] = []
    faces = []
    via = row = sample = over = ball = 0
    for course in courses(hand):
        rows, vias = course.spread.shape
        stations = (rows + STRIDE - 1) // STRIDE + (rows % STRIDE == 0)
        count = stations * ROUND + 2
        mesh = tube_faces(stations, ROUND)
        told.append(
            {
                "name": course.name, "title": f"tendon: {course.name}", "drives": [hand.muscle_names.index(course.muscle)],
                "radius": course.radius, "rows": rows, "vias": vias, "via": via, "row": row, "weight": sample, "over": over,
                "joints": len(course.reach), "ball": ball, "balls": len(course.balls.radius),
                "stations": stations, "first": first, "end": first + count, "corner": corner, "last": corner + mesh.size,
            }
        )  # fmt: skip
        faces.append(mesh + first)
        via, row, sample, over = via + vias, row + rows, sample + rows * vias, over + len(course.reach)
        first, corner, ball = first + count, corner + mesh.size, ball + len(course.balls.radius)
    every = courses(hand)
    balls = [course.balls for course in every]
    for one in taut(hand):
        told[one.course]["taut"] = {"muscle": one.muscle, "knuckle": one.knuckle, "reach": one.reach}
    way = [np.zeros_like(course.nudge) for course in every]
    for one in taut(hand):
        way[one.course] = one.way
    return told, {
        "via_point": np.concatenate([course.point for course in every]).astype("<f4"),
        "via_body": np.concatenate([course.body for course in every]).astype("u1"),
        "via_up": np.concatenate([course.up for course in every]).astype("<f4"),
        "spread": np.concatenate([course.spread.ravel() for course in every]).astype("<f4"),
        "nudge": np.concatenate([course.nudge for course in every]).astype("<f4"),
        "taut_way": np.concatenate(way).astype("<f4"),
        "nudge_body": np.concatenate([course.nudged for course in every]).astype("u1"),
        "over_centre": np.concatenate([course.centre for course in every]).astype("<f4"),
        "over_axis": np.concatenate([course.axis for course in every]).astype("<f4"),
        "over_body": np.concatenate([course.carrier for course in every]).astype("u1"),
        "over_reach": np.concatenate([course.reach for course in every]).astype("<f4"),
        "ball_centre": np.rint(np.concatenate([one.centre for one in balls]) / wire.UNIT).astype("<i2"),
        "ball_radius": np.rint(np.concatenate([one.radius for one in balls]) / wire.HALF_UNIT).astype("<i2"),
        "ball_body": np.concatenate([one.body for one in balls]).astype("u1"),
        "ball_first": np.concatenate([one.first for one in balls]).astype("u1"),
        "ball_last": np.concatenate([one.last for one in balls]).astype("u1"),
        "tendon_faces": np.concatenate(faces),
    }
