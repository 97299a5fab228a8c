"""Geometric muscles: chains of ellipsoids that follow the bones and swell with contraction (section 4.2).

Fitted once per hand from its muscle grids; then ``shape`` places all ellipsoids for a pose and contractions in microseconds.
There are no springs between muscles: layers slide freely over each other.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.grids import MuscleGrid, load_grids
from handlab.anatomy.records import Array, Hand, frozen
from handlab.anatomy.terms import find
from handlab.physics.bulge import FREE_SHORTENING, SHORTENING, TRANSFER, Law, bell
from handlab.simulation.geometric_kernel import Chains, shape_into
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.muscle_fit import Fitted as Fitted
from handlab.simulation.muscle_fit import fit as fit
from handlab.simulation.per_hand import per_hand

OVERLAP = 1.2  # ellipsoids of a fibre are longer than their segments by this factor, so that neighbours overlap
OVERLAP_ACROSS = 1.15  # and wider than their fibres where a muscle has several
LAWS: tuple[Law, ...] = ("volume", "recalled")


class Ellipsoids(NamedTuple):
    """``centre`` (s, 3) m; ``frame`` (s, 3, 3), its columns unit vectors along the fibre, across, outwards; ``half`` (s, 3) half-axes m.

    A world point x has the local place ``(x - centre) @ frame / half``: on the surface where that has length 1.
    """

    centre: Array
    frame: Array
    half: Array


@dataclass(frozen=True, eq=False)
class GeometricMuscles:
    """All geometric muscles of one hand.

    ``names``; ``drives``: pseudo muscles of each; ``segments``: slice of the ellipsoids of each; ``fibres``: how many each has;
    ``owner`` (s,): muscle of every ellipsoid; ``chains``: what the kernel needs; ``rest``: the ellipsoids in the bind posture.
    """

    names: tuple[str, ...]
    drives: tuple[tuple[str, ...], ...]
    segments: tuple[slice, ...]
    fibres: tuple[int, ...]
    owner: Array
    chains: Chains
    fitted: tuple[Fitted, ...]
    rest: Ellipsoids

    def index(self, name: str) -> int:
        """Number of the muscle ``name``; an unknown one is answered with the nearest three."""
        return self.names.index(find(name, self.names, kind="geometric muscle"))

    def of(self, name: str) -> slice:
        """Slice of the ellipsoids of one muscle."""
        return self.segments[self.index(name)]


@per_hand
def geometric_muscles(hand: Hand) -> GeometricMuscles:
    """The muscles of ``hand``, shipped or painted, fitted to it once."""
    return muscles_of(hand, load_grids() if hand.grids is None else hand.grids)


def muscles_of(hand: Hand, grids: Iterable[MuscleGrid]) -> GeometricMuscles:
    """The muscles of any ``grids``, fitted to ``hand``; for painted ones. Raises as ``fit`` does, and for unknown drives."""
    fitted = tuple(fit(hand, grid) for grid in grids)
    names = tuple(one.grid.name for one in fitted)
    if not names or len(set(names)) < len(names):
        raise ValueError("give at least one muscle grid, each with its own name")
    column: dict[str, list[Array]] = {key: [] for key in Chains._fields}
    segments, node, segment = [], 0, 0
    for g, one in enumerate(fitted):
        rows, fibres = one.thickness.shape
        begin = segment
        for k in range(fibres):
            for key, values in _fibre(hand, one, k).items():
                column[key].append(values)
            column["first_node"].append(np.array([node]))
            column["nodes"].append(np.array([rows]))
            column["grid"].append(np.array([g]))
            column["free"].append(np.array([0 if one.grid.on_bone[1] else 1]))
            node, segment = node + rows, segment + rows - 1
        segments.append(slice(begin, segment))
    drives = tuple(tuple(find_muscle(hand, name) for name in one.grid.drives) for one in fitted)
    table = np.full((len(fitted), max(len(row) for row in drives)), -1)
    for g, row in enumerate(drives):
        table[g, : len(row)] = [hand.muscle_names.index(name) for name in row]
    column["drive"].append(table)
    integer = {"first_node", "nodes", "grid", "free", "drive", "body", "confined"}
    chains = Chains(**{key: frozen(np.concatenate(v), np.int64 if key in integer else np.float64) for key, v in column.items()})
    owner = np.concatenate([np.full(part.stop - part.start, g) for g, part in enumerate(segments)])
    still = Ellipsoids(np.empty((segment, 3)), np.empty((segment, 3, 3)), np.empty((segment, 3)))
    _fill(chains, relative_transforms(hand, hand.bind), np.zeros(len(hand.muscles)), "volume", still)
    fibres_of = tuple(one.thickness.shape[1] for one in fitted)
    rest = Ellipsoids(*(frozen(values) for values in still))
    return GeometricMuscles(names, drives, tuple(segments), fibres_of, frozen(owner, np.int64), chains, fitted, rest)


def find_muscle(hand: Hand, name: str) -> str:
    """Full name of a pseudo muscle; an unknown one is answered with the nearest three."""
    found: str = hand.muscles[name].name
    return found


def _fibre(hand: Hand, one: Fitted, k: int) -> dict[str, Array]:
    """Fibre ``k`` of a fitted muscle."""
    rows, fibres = one.thickness.shape
    point, outward = one.point[:, k], one.outward[:, k]
    length = np.linalg.norm(np.diff(point, axis=0), axis=1)
    if length.min() < 1e-4:
        raise ValueError(f"the muscle {one.grid.name!r} collapses below the skin; paint its rows further apart")
    wide, thick = one.width[:, k] * (OVERLAP_ACROSS if fibres > 1 else 1.0), one.thickness[:, k]
    width, height = (wide[1:] + wide[:-1]) / 4, (thick[1:] + thick[:-1]) / 4
    weight, volume = bell(length), length * width * height
    body, share = np.zeros((rows, 2)), np.zeros((rows, 2))
    for row, carriers in enumerate(one.grid.bones):
        for slot, (bone, part) in enumerate(carriers.items()):
            body[row, slot], share[row, slot] = hand.body_names.index(hand.bones[bone].body), part
    low, high = (np.full(rows - 1, value / 2) for value in one.grid.thickness)
    return {
        "body": body,
        "share": share,
        "point": point,
        "outward": outward,
        "length": length,
        "width": width,
        "height": height,
        "low": low,
        "high": high,
        "bell": weight,
        "surplus": weight - (volume * weight).sum() / volume.sum(),
        "confined": np.full(rows - 1, int(one.grid.confined)),
    }


def shape(muscles: GeometricMuscles, transforms: Array, contraction: ArrayLike, *, law: Law = "volume") -> Ellipsoids:
    """All ellipsoids for ``transforms`` (body, 4, 4), as ``relative_transforms`` gives them, and ``contraction`` (muscle,).

    ``law``: ``"volume"`` keeps the volume of every muscle (default), ``"recalled"`` thickens by 1 + 2 (1 - q).
    """
    count = len(muscles.owner)
    out = Ellipsoids(np.empty((count, 3)), np.empty((count, 3, 3)), np.empty((count, 3)))
    place(muscles, transforms, contraction, out, law=law)
    return out


def place(muscles: GeometricMuscles, transforms: Array, contraction: ArrayLike, out: Ellipsoids, *, law: Law = "volume") -> None:
    """``shape`` into arrays that exist: for live views that reuse them."""
    _fill(muscles.chains, transforms, np.asarray(contraction, dtype=np.float64), law, out)


def _fill(chains: Chains, transforms: Array, contraction: Array, law: Law, out: Ellipsoids) -> None:
    if law not in LAWS:
        raise ValueError(f"law is {law!r}; choose 'volume' (keeps it) or 'recalled' (thickness 1 + 2 (1 - q))")
    if contraction.ndim != 1 or len(contraction) <= chains.drive.max():
        raise ValueError(f"contraction has shape {contraction.shape}; give one value for every pseudo muscle of the hand")
    recalled, contraction = law == "recalled", contraction.view()
    contraction.setflags(write=False)  # kernels are compiled anew for arrays that can be written
    shape_into(chains, transforms, contraction, recalled, OVERLAP, SHORTENING, TRANSFER, FREE_SHORTENING, *out)


def ellipsoids(hand: Hand, angle: ArrayLike, contraction: ArrayLike | None = None, *, law: Law = "volume") -> Ellipsoids:
    """``shape`` of the shipped muscles at ``angle`` (dof,) rad and ``contraction`` (muscle,), none if not given."""
    activity = np.zeros(len(hand.muscles)) if contraction is None else contraction
    return shape(geometric_muscles(hand), relative_transforms(hand, angle), activity, law=law)
