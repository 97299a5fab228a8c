"""The first muscle grids: computed from attachments on the bones of the reference hand, then free to be painted over.

    python -m tools.muscle_grids

Attachments are those of standard gross anatomy. Every row names the two edges of the muscle where it should lie; the grid is
where the skin looks down on that place, the skin distance is what lies between. Fitting then needs the grid only.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from handlab.anatomy.data import folder
from handlab.anatomy.grids import MuscleGrid, save_grids
from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Array, Hand
from handlab.physics.distance import closest
from handlab.simulation.geometric_kernel import first_hit
from handlab.simulation.geometric_muscle import fit
from handlab.simulation.muscle_fit import REST_SHARE, checked_skin
from handlab.simulation.muscle_paint import barycentric
from tools.muscle_places import Places

SOURCES = ("ANAT", "PAPER")
PALM, BACK, RADIAL, ULNAR = (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
STEPS = 30
KEPT = 0.7  # share of the planned width that the grid keeps on the skin
SWEEP = 0.2  # the skin must face the viewer at least this much (cosine)


@dataclass
class Row:
    """Edges (two places) of a muscle across its fibres, thickness at rest, bones, and the side from which it is painted."""

    one: Array
    other: Array
    thick_mm: float
    bones: Any
    view: tuple[float, float, float]


@dataclass
class Plan:
    """A muscle to be: rows from origin to insertion."""

    name: str
    drive: str
    rows: list[Row]
    columns: int = 3
    confined: bool = False
    on_bone: tuple[bool, bool] = (True, True)
    sources: tuple[str, ...] = field(default=SOURCES)


def across(middle: Array, way: Array, width_mm: float) -> tuple[Array, Array]:
    """Two edges ``width_mm`` apart about ``middle``, along ``way``."""
    half = 0.5e-3 * width_mm * way / np.linalg.norm(way)
    return middle - half, middle + half


def strip(plans: list[tuple[Array, float, float, Any, tuple[float, float, float]]], outward: Array) -> list[Row]:
    """Rows of a strap: (middle, width, thickness, bones, view); it lies flat under ``outward``, its rows across its own course."""
    middles = np.array([plan[0] for plan in plans])
    course = np.gradient(middles, axis=0)
    rows = []
    for (middle, width, thick, bones, view), along in zip(plans, course, strict=True):
        up = np.array(view) if outward is None else outward
        rows.append(Row(*across(middle, np.cross(along, up), width), thick, bones, view))
    return rows


def between(a: Array, b: Array, share: float) -> Array:
    """The place ``share`` of the way from a to b."""
    result: Array = a + share * (b - a)
    return result


def resampled(rows: list[Row], count: int) -> list[Row]:
    """``count`` rows along the smooth lines through the given ones."""
    from scipy.interpolate import PchipInterpolator

    middles = np.array([(row.one + row.other) / 2 for row in rows])
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(middles, axis=0), axis=1))])
    wanted = np.linspace(0.0, at[-1], count)
    table = PchipInterpolator(at, np.array([[*row.one, *row.other, row.thick_mm, *row.view] for row in rows]))(wanted)
    carried: list[Any] = []
    for s in wanted:
        k = int(np.clip(np.searchsorted(at, s) - 1, 0, len(at) - 2))
        r = (s - at[k]) / (at[k + 1] - at[k])
        shares: dict[str, float] = {}
        for row, part in ((rows[k], 1.0 - r), (rows[k + 1], r)):
            for bone, share in ({row.bones: 1.0} if isinstance(row.bones, str) else row.bones).items():
                shares[bone] = shares.get(bone, 0.0) + part * share
        heavy = sorted(((bone, share) for bone, share in shares.items() if share > 0.02), key=lambda pair: -pair[1])[:2]
        total = sum(share for _, share in heavy)
        carried.append({bone: share / total for bone, share in heavy})
    return [Row(r[:3], r[3:6], float(r[6]), b, (r[7], r[8], r[9])) for r, b in zip(table, carried, strict=True)]


def plans(hand: Hand) -> list[Plan]:
    """Every intrinsic muscle of a right hand."""
    from tools.muscle_table import hypothenar, interossei, lumbricals, thenar

    place = Places(hand)
    return [*thenar(place), *hypothenar(place), *lumbricals(place), *interossei(place)]


def grid_of(hand: Hand, plan: Plan) -> MuscleGrid:
    """The grid that lies over a planned muscle."""
    share = np.linspace(0.0, 1.0, plan.columns)[:, None]
    wanted = np.array([(1.0 - share) * row.one + share * row.other for row in plan.rows])
    view = np.array([np.array(row.view) / np.linalg.norm(row.view) for row in plan.rows])
    triangle, place, depth = _feet(hand, wanted, view)
    thick = np.array([row.thick_mm for row in plan.rows]) * 1e-3
    least = max(float(thick.min()), 0.0012)
    most = float(thick.max()) / REST_SHARE
    full = (thick - least) / (thick.max() - least) if thick.max() > least else np.zeros(len(thick))
    distance = np.clip(depth.mean(axis=1) - thick / 2, 0.0012, None)
    return MuscleGrid(
        name=plan.name,
        drives=(plan.drive,),
        triangle=triangle,
        barycentric=place,
        thickness=(least, most),
        skin_distance=distance,
        bones=tuple(row.bones for row in plan.rows),
        sources=plan.sources,
        on_bone=plan.on_bone,
        fullness=np.clip(full, 0.0, 1.0),
        confined=plan.confined,
    )


def _feet(hand: Hand, wanted: Array, view: Array) -> tuple[Any, Array, Array]:
    """Where the skin looks down on every place (rows, columns, 3): triangle, barycentric, depth.

    Begins where the skin is met in the direction of ``view`` and moves until the normals hit; moves are evened over the grid, so
    that its rows and columns stay in order where normals converge.
    """
    up_at, faces = checked_skin(hand), hand.skin.faces
    corners = np.ascontiguousarray(hand.skin.points[faces])
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    rows, columns = wanted.shape[:2]
    seen = [np.flatnonzero(facing @ v > SWEEP) for v in view]

    def settle(points: Array) -> tuple[Array, Any, Array, Array]:
        spot, found = np.empty_like(points), np.empty((rows, columns), dtype=np.int64)
        for k in range(rows):
            _, near, spot[k] = closest(np.ascontiguousarray(points[k]), np.ascontiguousarray(corners[seen[k]]))
            found[k] = seen[k][near]
        bary = barycentric(spot.reshape(-1, 3), corners[found.ravel()]).reshape(rows, columns, 3)
        up = np.einsum("rck,rckd->rcd", bary, up_at[faces[found]])
        return spot, found, bary, up / np.linalg.norm(up, axis=2, keepdims=True)

    way = np.repeat(view[:, None, :], columns, axis=1)
    start = np.ascontiguousarray(wanted.reshape(-1, 3))
    out = first_hit(start, np.ascontiguousarray(way.reshape(-1, 3)), corners)[0].reshape(rows, columns)
    out = np.where(np.isfinite(out), out, 0.005)
    spot, found, bary, up = settle(wanted + out[..., None] * way)
    for _ in range(STEPS):
        depth = np.einsum("rcd,rcd->rc", spot - wanted, up)
        move = 0.4 * _even(wanted - (spot - depth[..., None] * up))
        # Where normals meet below an edge of the hand, columns would fall together: keep most of the planned width.
        planned, width = np.diff(wanted, axis=1), np.diff(spot, axis=1)
        narrow = np.linalg.norm(width, axis=2, keepdims=True) < KEPT * np.linalg.norm(planned, axis=2, keepdims=True)
        push = np.where(narrow, 0.4 * (KEPT * planned - width), 0.0)
        move[:, 1:] += push
        move[:, :-1] -= push
        spot, found, bary, up = settle(spot + move)
    return found, bary, np.einsum("rcd,rcd->rc", spot - wanted, up)


def _even(moves: Array) -> Array:
    """Moves (rows, columns, 3) averaged with their neighbours along and across."""
    for axis in (0, 1):
        ends = np.concatenate([np.take(moves, [0], axis), moves, np.take(moves, [-1], axis)], axis=axis)
        n = moves.shape[axis]
        before, after = np.take(ends, range(n), axis), np.take(ends, range(2, n + 2), axis)
        moves = 0.5 * moves + 0.25 * before + 0.25 * after
    return moves


def report(hand: Hand, plan: Plan, grid: MuscleGrid) -> str:
    """How far the fitted muscle is from the plan, in millimetres."""
    fitted = fit(hand, grid)
    share = np.linspace(0.0, 1.0, plan.columns)[:, None]
    wanted = np.array([(1.0 - share) * row.one + share * row.other for row in plan.rows])
    off = 1e3 * np.linalg.norm(fitted.point - (wanted[:, 1:] + wanted[:, :-1]) / 2, axis=2)
    thick, below = 1e3 * fitted.thickness.max(), 1e3 * grid.skin_distance
    return (
        f"{grid.name:36} off {off.mean():4.1f}, worst {off.max():4.1f} mm; thick {thick:4.1f} mm; "
        f"skin distance {below.min():.1f} to {below.max():.1f} mm"
    )


def main() -> None:
    """Write all grids into ``assets/muscles``."""
    hand = load_hand()
    grids = []
    for plan in plans(hand):
        grids.append(grid_of(hand, plan))
        try:
            sys.stdout.write(report(hand, plan, grids[-1]) + "\n")
        except ValueError as error:
            sys.stdout.write(f"{plan.name:36} {error}\n")
    save_grids(Path(folder()) / "muscles", grids)


if __name__ == "__main__":
    main()
