"""A muscle while it is painted: what was clicked, what was set, and the muscle that comes of it (section 4.2, Figure 4).

Nothing that was clicked is ever thrown away: a grid that makes no muscle yet says why, and the next click may mend it.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.grids import MuscleGrid, load_grids, save_grids
from handlab.anatomy.records import Array, Hand, Index
from handlab.anatomy.terms import find
from handlab.simulation.geometric_kernel import first_hit
from handlab.simulation.geometric_muscle import Ellipsoids, GeometricMuscles, muscles_of
from handlab.simulation.grid_rows import finer_bones, finer_points, finer_values, nearest_bones, on_skin
from handlab.simulation.muscle_below import DEEP, hits
from handlab.simulation.muscle_fit import bone_corners, checked_skin
from handlab.simulation.muscle_paint import OFF, paint
from handlab.simulation.muscle_surface import skeletons

MOST_COLUMNS = 8
MOST_FINER = 6
MOST_POINTS = 512

Row = str | Mapping[str, float] | None


class NotYet(ValueError):  # noqa: N818 (points that are still to come are no error)
    """What is painted makes no muscle yet. In a notebook it is told in one line, without the ways of the program."""

    def _render_traceback_(self) -> list[str]:
        """What IPython prints instead of a traceback."""
        return [str(self)]


@dataclass(frozen=True)
class Settings:
    """What is set beside the points.

    ``drive``: the pseudo muscle whose contraction moves it; ``columns``: points of a row; ``finer``: into how many each painted row is
    divided before the fit; ``thickness_mm`` (least, most); ``skin_distance_mm``: one number, or one for each painted row; ``bones``: for
    each painted row the bone that carries it, ``None`` where the nearest one is meant; ``on_bone``: whether first and last row reach bone.
    """

    name: str
    drive: str
    columns: int = 3
    finer: int = 2
    thickness_mm: tuple[float, float] = (1.5, 6.0)
    skin_distance_mm: float | tuple[float, ...] = 2.0
    bones: tuple[Row, ...] = ()
    on_bone: tuple[bool, bool] = (True, True)


@dataclass(frozen=True, eq=False)
class Result:
    """A painted muscle: its grid, itself fitted to the hand, the skin points (n,) that it influences, and the seconds that it took."""

    grid: MuscleGrid
    muscle: GeometricMuscles
    influenced: Index
    seconds: float

    @property
    def volume_ml(self) -> float:
        """Millilitres, of its surface at rest."""
        return 1e6 * skeletons(self.muscle)[0].volume[0]

    @property
    def length_mm(self) -> float:
        """From origin to insertion at rest, the mean of its fibres."""
        fibres = self.muscle.fibres[0]
        return 1e3 * float(self.muscle.chains.length.sum()) / fibres


class Painting:
    """Points on the skin of ``hand`` (bind posture), settings, and ``result`` or ``problem``.

    Raises ``ValueError`` for a hand whose skin is open or no manifold.
    """

    def __init__(self, hand: Hand, settings: Settings) -> None:
        checked_skin(hand)
        self.hand = hand
        self.settings = settings
        self.points: Array = np.empty((0, 3))
        self._past: list[Array] = []
        self._passing = False
        self.result: Result | None = None
        self.problem: str | None = None
        self.fits = 0  # how often it was fitted: a new result has a new number
        self.set()

    def set(self, **changes: Any) -> None:
        """Change settings by name. One that can be no muscle's raises ``ValueError`` or ``UnknownName``, and nothing is changed."""
        self.settings = self.wanted(changes)
        self._fit()

    def wanted(self, changes: Mapping[str, Any]) -> Settings:
        """What ``set`` would make of ``changes``: settings in their final form, tried on a grid that lies nowhere in particular."""
        names = tuple(field.name for field in fields(Settings))
        given = {find(name, names, kind="setting of a painted muscle"): value for name, value in changes.items()}
        wanted = replace(self.settings, **given)
        columns, finer = int(wanted.columns), int(wanted.finer)
        if not 2 <= columns <= MOST_COLUMNS:
            raise ValueError(f"columns is {wanted.columns}; a row has 2 to {MOST_COLUMNS} points")
        if not 1 <= finer <= MOST_FINER:
            raise ValueError(f"finer is {wanted.finer}; divide rows by 1 (as painted) to {MOST_FINER}")
        thickness = np.atleast_1d(np.asarray(wanted.thickness_mm, dtype=np.float64))
        if thickness.shape != (2,) or np.isnan(thickness).any():
            raise ValueError("thickness_mm is two numbers in millimetres, 0 < least <= most, like (2, 7)")
        depth = np.atleast_1d(np.asarray(wanted.skin_distance_mm, dtype=np.float64))
        if depth.ndim != 1 or not len(depth):
            raise ValueError("skin_distance_mm is a skin distance in millimetres, or one for each row, like (6, 3, 2)")
        bones = (wanted.bones,) if isinstance(wanted.bones, str | Mapping) else tuple(wanted.bones or ())
        named: list[Row] = []
        for row in bones:
            shares = {} if row is None else {row: 1.0} if isinstance(row, str) else row
            known = {find(name, self.hand.bones, kind="bone"): float(share) for name, share in shares.items()}
            named.append(None if not known else next(iter(known)) if len(known) == 1 else known)
        drive = self.hand.muscles[wanted.drive].name
        carried: list[Any] = [next(iter(self.hand.bones)) if row is None else row for row in (*named, None, None)]
        for value in depth:
            MuscleGrid(
                name=wanted.name,
                drives=(drive,),
                triangle=np.zeros((len(carried), 2), dtype=np.int64),
                barycentric=np.full((len(carried), 2, 3), 1.0 / 3.0),
                thickness=(thickness[0] / 1e3, thickness[1] / 1e3),
                skin_distance=np.array(value / 1e3),
                bones=tuple(carried),
                sources=(),
            )
        return replace(
            wanted,
            drive=drive,
            columns=columns,
            finer=finer,
            thickness_mm=(float(thickness[0]), float(thickness[1])),
            skin_distance_mm=float(depth[0]) if len(depth) == 1 else tuple(float(value) for value in depth),
            bones=tuple(named),
            on_bone=(bool(wanted.on_bone[0]), bool(wanted.on_bone[1])),
        )

    def add(self, points: ArrayLike) -> None:
        """Points (..., 3) in metres on the skin, row after row from origin to insertion. One off the skin raises; then none is added."""
        self.put(np.concatenate([self.points, self._on(points).reshape(-1, 3)]))

    def move(self, number: int, point: ArrayLike) -> None:
        """Put the point ``number`` (0 is the first) somewhere else."""
        if not 0 <= number < len(self.points):
            raise ValueError(f"there is no point {number}; {len(self.points)} are painted, counted from 0")
        moved = self.points.copy()
        moved[number] = self._on(point).reshape(3)
        self.put(moved)

    def put(self, points: ArrayLike, settings: Settings | None = None, *, passing: bool = False, back: bool = False) -> None:
        """Points (n, 3) in place of all that are there, with ``settings`` that ``wanted`` gave, fitted once. One off the skin raises.

        ``passing``: a point is still being dragged; the whole way is one change to ``undo``. ``back``: this is what ``undo`` would do.
        """
        given = np.asarray(points, dtype=np.float64)
        if given.size > 3 * MOST_POINTS:
            raise ValueError(f"there are {given.size // 3} points; a grid has at most {MOST_POINTS}")
        new = self._on(given).reshape(-1, 3) if given.size else np.empty((0, 3))
        if not same(new, self.points):
            if back and self._past and same(new, self._past[-1]):
                self._past.pop()
            elif not self._passing:
                self._past.append(self.points)
        changed = not same(new, self.points) or settings not in (None, self.settings)
        self.points, self.settings, self._passing = new, settings or self.settings, passing
        if changed:
            self._fit()

    def undo(self) -> None:
        """Take back the last change of the points; nothing happens when there is none."""
        if self._past:
            self.points = self._past.pop()
            self._fit()

    def clear(self) -> None:
        """Take all points away; ``undo`` brings them back."""
        self.put(np.empty((0, 3)))

    def _on(self, points: ArrayLike) -> Array:
        wanted = np.asarray(points, dtype=np.float64)
        if wanted.size == 0 or wanted.shape[-1] != 3 or not np.all(np.isfinite(wanted)):
            raise ValueError(f"points have shape {wanted.shape}; give finite (..., 3) in metres")
        place = on_skin(self.hand, wanted)
        if (off := float(np.linalg.norm(place - wanted, axis=-1).max())) > OFF:
            raise ValueError(f"a point lies {1e3 * off:.0f} mm off the skin; paint on the skin (metres, bind posture)")
        return place

    @property
    def rows(self) -> Array:
        """Whole rows (rows, columns, 3) of what was painted."""
        whole = len(self.points) // self.settings.columns
        return self.points[: whole * self.settings.columns].reshape(whole, self.settings.columns, 3)

    @property
    def carriers(self) -> tuple[dict[str, float], ...]:
        """The bones of every whole row, with shares: those that were named, the nearest where none was."""
        named = self.settings.bones
        nearest = nearest_bones(self.hand, self.rows) if len(self.rows) else ()
        if len(named) == 1:  # one name serves all rows
            named = named * len(nearest)
        found = [named[k] if k < len(named) and named[k] is not None else bone for k, bone in enumerate(nearest)]
        return tuple({row: 1.0} if isinstance(row, str) else dict(row or {}) for row in found)

    def _fit(self) -> None:
        begin = time.perf_counter()
        self.result, self.problem, self.fits = None, None, self.fits + 1
        if len(self.rows) < 2:
            return
        chosen, carriers = self.settings, self.carriers
        depth = np.atleast_1d(np.asarray(chosen.skin_distance_mm)) / 1e3
        rows = np.concatenate([depth, np.full(len(carriers), depth[-1])])[: len(carriers)]
        try:
            grid = paint(
                self.hand,
                chosen.name,
                finer_points(self.hand, self.rows, chosen.finer),
                drives=chosen.drive,
                thickness=(chosen.thickness_mm[0] / 1e3, chosen.thickness_mm[1] / 1e3),
                bones=finer_bones(carriers, chosen.finer),
                skin_distance=finer_values(rows, chosen.finer),
                on_bone=chosen.on_bone,
            )
            muscle = muscles_of(self.hand, [grid])
        except (ValueError, KeyError) as error:
            counted = chosen.finer > 1 and " row " in str(error)
            self.problem = f"{error}" + (f" (rows are counted after each was divided by {chosen.finer})" if counted else "")
            return
        self.result = Result(grid, muscle, influenced_by(self.hand, muscle), time.perf_counter() - begin)

    @property
    def missing(self) -> int:
        """How many clicks the next whole row, or the second one, still needs."""
        columns = self.settings.columns
        return max(2 * columns - len(self.points), (-len(self.points)) % columns)

    def required(self) -> Result:
        """The result. Raises ``ValueError`` with the reason where there is none."""
        if self.problem is not None:
            raise NotYet(f"There is no muscle yet: {self.problem}. Drag a point or undo, then run this again")
        if self.result is None:
            count = len(self.points) or "no"
            raise NotYet(
                f"There is no muscle yet: {count} {'point is' if count == 1 else 'points are'} painted. Click {self.missing} more on "
                f"the skin, in rows of {self.settings.columns} from the origin to the insertion; then run this again"
            )
        return self.result

    def save(self, folder: str | Path, *, overwrite: bool = False) -> Path:
        """Write the grid into ``folder`` as JSON, for ``load_grids``. An existing file is kept unless ``overwrite``."""
        grid = self.required().grid
        file = Path(folder) / f"{grid.name}.json"
        if file.exists() and not overwrite:
            raise FileExistsError(f"{file} exists; give the muscle another name, another folder, or say overwrite=True")
        return save_grids(folder, [grid])[0]

    def with_others(self, grids: Sequence[MuscleGrid] | None = None) -> GeometricMuscles:
        """All muscles of the hand (or of ``grids``), the painted one among them; it takes the place of one with its name."""
        grid = self.required().grid
        others = load_grids() if grids is None else grids
        return muscles_of(self.hand, [*(one for one in others if one.name != grid.name), grid])


def same(points: Array, others: Array) -> bool:
    """Whether two lists of points are the same but for rounding."""
    return points.shape == others.shape and bool(np.allclose(points, others, rtol=0.0, atol=1e-9))


def influenced_by(hand: Hand, muscle: GeometricMuscles) -> Index:
    """Skin points below which one muscle lies, before bone (as ``muscle_below.influenced``, asking for bone only where it matters)."""
    start, way = hand.skin.points, -checked_skin(hand)
    distance, _ = hits(Ellipsoids(*muscle.rest), start, way)
    near = np.flatnonzero(distance < DEEP)
    bone = first_hit(np.ascontiguousarray(start[near]), np.ascontiguousarray(way[near]), bone_corners(hand))[0]
    result: Index = near[distance[near] < bone]
    return result
