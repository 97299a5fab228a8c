"""A smooth closed surface about the ellipsoids of every muscle, for the eye: the same triangles in every frame.

Along the fibres a quadratic B-spline runs through what the ellipsoids say (it never overshoots), across them the section is
a rounded strip. All that is linear in centres and half-axes: a new frame is two products with constant matrices, and a factor on
the thickness that gives the drawn muscle the share of its rest volume that its ellipsoids have.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from handlab.anatomy.meshes import Mesh
from handlab.anatomy.records import Array, Index, frozen
from handlab.simulation.geometric_kernel import volume_of
from handlab.simulation.geometric_muscle import OVERLAP, Ellipsoids, GeometricMuscles

STATIONS_PER_SEGMENT = 4
RING = 20  # points of a section of one fibre; every further fibre adds some
RING_MORE = 8
TIP = 0.5  # width and thickness at the very end against those of the last segment
FLAT = 0.7  # exponent of a sheet's outline: 1 is an ellipse, less is fuller towards the edges


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Constant part of one surface: ``faces`` (M, 3); ``spine`` (points, controls) and ``girth`` (points, 2 x controls) matrices.

    ``u`` (points,): 0 at the origin, 1 at the insertion; ``v`` (points,): place across the fibres, -1 to 1, for stripes along them.
    ``volume``: of the surface, and of all its ellipsoids, in the bind posture.
    """

    faces: Index
    spine: Array
    girth: Array
    u: Array
    v: Array
    volume: tuple[float, float]


_kept: WeakKeyDictionary[GeometricMuscles, tuple[Skeleton, ...]] = WeakKeyDictionary()


def skeletons(muscles: GeometricMuscles) -> tuple[Skeleton, ...]:
    """What never changes of the surfaces of ``muscles``, computed once."""
    found = _kept.get(muscles)
    if found is None:
        found = _kept[muscles] = tuple(_skeleton(muscles, g) for g in range(len(muscles.names)))
    return found


def surface(muscles: GeometricMuscles, ellipsoids: Ellipsoids) -> list[Mesh]:
    """One closed mesh per muscle, in the order of ``muscles.names``; faces are the same arrays every time."""
    points = surface_points(muscles, ellipsoids)
    return [Mesh(found, skeleton.faces) for found, skeleton in zip(points, skeletons(muscles), strict=True)]


def surface_points(muscles: GeometricMuscles, ellipsoids: Ellipsoids) -> Sequence[Array]:
    """The points (n, 3) of every muscle's surface: what changes from frame to frame."""
    result = []
    for part, fibres, kept in zip(muscles.segments, muscles.fibres, skeletons(muscles), strict=True):
        centre, axes = _controls(part, fibres, ellipsoids)
        spine, girth = kept.spine @ centre, kept.girth @ axes
        drawn, meant = kept.volume
        wanted = drawn * 4.0 / 3.0 * np.pi * float(ellipsoids.half[part].prod(axis=1).sum()) / meant
        factor = 1.0
        for _ in range(3):  # nearly quadratic in the factor: a few corrections leave a few parts in a thousand
            factor *= np.sqrt(wanted / max(volume_of(spine + factor * girth, kept.faces), 0.1 * wanted))
        result.append(spine + factor * girth)
    return result


def _controls(part: slice, fibres: int, ellipsoids: Ellipsoids) -> tuple[Array, Array]:
    """Centres (controls, 3) and half-axes across and upwards (2 x controls, 3), fibre after fibre, a tip at either end of each."""
    centre, frame, half = (values[part].reshape(fibres, -1, *values.shape[1:]) for values in ellipsoids)
    stretch = frame[..., 0] * (half[..., :1] / OVERLAP)
    centre = np.concatenate([centre[:, :1] - stretch[:, :1], centre, centre[:, -1:] + stretch[:, -1:]], axis=1)
    ways = [frame[..., 1] * half[..., 1:2], frame[..., 2] * half[..., 2:3]]
    axes = [np.concatenate([TIP * way[:, :1], way, TIP * way[:, -1:]], axis=1).reshape(-1, 3) for way in ways]
    return centre.reshape(-1, 3), np.concatenate(axes)


def _skeleton(muscles: GeometricMuscles, g: int) -> Skeleton:
    part, fibres = muscles.segments[g], muscles.fibres[g]
    centre, frame, half = (values[part].reshape(fibres, -1, *values.shape[1:]) for values in muscles.rest)
    length = half[..., 0].mean(axis=0)
    at = np.concatenate([[0.0], (np.cumsum(length) - length / 2) / length.sum(), [1.0]])
    stations = STATIONS_PER_SEGMENT * len(length) + 1
    along = _spline(at, np.linspace(0.0, 1.0, stations))
    ring = RING + RING_MORE * (fibres - 1)
    # Fibres stand in the order of the grid's columns; the frames' sideways direction may run against it.
    run = (centre[-1] - centre[0]).mean(axis=0) @ frame[..., 1].mean(axis=(0, 1)) if fibres > 1 else 1.0
    sign = 1.0 if run >= 0.0 else -1.0
    wide = half[..., 1].mean(axis=1)
    places = np.concatenate([[0.0], np.cumsum(2 * wide) - wide, [2 * wide.sum()]]) / wide.sum() - 1.0
    angle = np.linspace(0.0, 2 * np.pi, ring, endpoint=False)
    v = np.cos(angle)
    control = np.stack([np.interp(v, places, row) for row in np.eye(fibres + 2)], axis=1)
    middle = control[:, 1:-1].copy()
    middle[:, 0] += control[:, 0]
    middle[:, -1] += control[:, -1]
    sideways = np.zeros((ring, fibres))
    sideways[:, 0] -= sign * control[:, 0]
    sideways[:, -1] += sign * control[:, -1]
    rise = np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** (1.0 if fibres == 1 else FLAT)
    tips = np.zeros((2, fibres, len(at)))
    tips[0, :, 0] = tips[1, :, -1] = 1.0 / fibres
    blocks = [np.einsum("sn,kf->skfn", along, w).reshape(stations * ring, -1) for w in (middle, sideways, rise[:, None] * middle)]
    spine = np.concatenate([blocks[0], tips.reshape(2, -1)])
    girth = np.concatenate([np.concatenate(blocks[1:], axis=1), np.zeros((2, 2 * fibres * len(at)))])
    faces = tube_faces(stations, ring, inwards=sign < 0.0)
    u = np.concatenate([np.repeat(np.linspace(0.0, 1.0, stations), ring), [0.0, 1.0]])
    resting, axes = _controls(part, fibres, muscles.rest)
    volume = volume_of(spine @ resting + girth @ axes, faces), float(4.0 / 3.0 * np.pi * half.prod(axis=-1).sum())
    return Skeleton(faces, frozen(spine), frozen(girth), frozen(u), frozen(np.concatenate([np.tile(v, stations), [0.0, 0.0]])), volume)


def _spline(at: Array, wanted: Array) -> Array:
    """Weights (stations, controls) of a clamped quadratic B-spline whose controls stand near ``at``; rows add to 1."""
    from scipy.interpolate import BSpline

    degree = min(2, len(at) - 1)
    inner = [at[k + 1 : k + 1 + degree].mean() for k in range(len(at) - degree - 1)]
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    return np.asarray(BSpline(knots, np.eye(len(at)), degree)(wanted), dtype=np.float64)


def tube_faces(stations: int, ring: int, *, inwards: bool = False) -> Index:
    """Triangles of a tube of ``stations`` rings of ``ring`` points, closed by fans about its last two points (start and end)."""
    s, k = np.meshgrid(np.arange(stations - 1), np.arange(ring), indexing="ij")
    a, b = s * ring + k, s * ring + (k + 1) % ring
    c, d = a + ring, b + ring
    sides = np.concatenate([np.stack([a, b, d], axis=-1).reshape(-1, 3), np.stack([a, d, c], axis=-1).reshape(-1, 3)])
    turn, first, last = np.arange(ring), stations * ring, stations * ring + 1
    start = np.stack([np.full(ring, first), (turn + 1) % ring, turn], axis=1)
    base = (stations - 1) * ring
    end = np.stack([np.full(ring, last), base + turn, base + (turn + 1) % ring], axis=1)
    faces = np.concatenate([sides, start, end])
    result: Index = frozen(faces[:, ::-1] if inwards else faces, np.int64)
    return result
