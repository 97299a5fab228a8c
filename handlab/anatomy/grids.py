"""Muscle grids: rows and columns of points painted on the skin, from which geometric muscles are fitted (section 4.2, Figure 4).

Rows run across the fibres, the first along the origin (fixed edge), the last along the insertion; columns run along them.
Points are kept as places on triangles of the even skin, so that a warped hand warps the grid. Files are in ``assets/muscles``.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handlab.anatomy import data
from handlab.anatomy.meshes import Array, Index, Mesh, frozen
from handlab.anatomy.mirror import TURNED
from handlab.anatomy.terms import BONES, find

Bones = tuple[Mapping[str, float], ...]

THICKEST = 0.03  # metres: no muscle of a hand is thicker
DEEPEST = 0.04  # metres: nothing in a hand lies deeper below the nearest skin
LARGEST = 32  # rows or columns
SIDES = ("right", "left")


@dataclass(frozen=True, eq=False)
class MuscleGrid:
    """A painted muscle, validated: ``ValueError`` or ``UnknownName`` says what to change.

    ``drives``: pseudo muscles; the geometric muscle takes the largest of their contractions.
    ``triangle`` (rows, columns), ``barycentric`` (rows, columns, 3): places on the even skin of a hand of ``side``.
    ``thickness``: (least, most) metres. ``skin_distance`` (rows,) metres from the skin to the muscle; one number serves all rows.
    ``bones``: for each row the bones that carry it, with shares that add to 1 (a row between two bones follows both).
    ``on_bone``: whether the first and the last row are pulled down to their bones. A last row that is not is a free end.
    ``fullness`` (rows,), 0 to 1: 0 is a tendinous row of least thickness, 1 takes all the room; not given, 0 at ends on bone.
    ``confined``: neighbours leave no room sideways, so the muscle swells in height alone.
    """

    name: str
    drives: tuple[str, ...]
    triangle: Index
    barycentric: Array
    thickness: tuple[float, float]
    skin_distance: Array
    bones: Bones
    sources: tuple[str, ...]
    on_bone: tuple[bool, bool] = (True, True)
    fullness: Array | None = None
    confined: bool = False
    side: str = "right"

    def __post_init__(self) -> None:
        """Bring everything into its final form and refuse what cannot be a muscle."""
        triangle = frozen(self.triangle, np.int64)
        self._need(triangle.ndim == 2 and min(triangle.shape) >= 2, f"has {_size(triangle)} points; paint at least two rows of two points")
        rows, columns = triangle.shape
        self._need(max(rows, columns) <= LARGEST, f"has {rows} x {columns} points; {LARGEST} x {LARGEST} are enough for any muscle")
        place = frozen(self.barycentric)
        self._need(place.shape == (rows, columns, 3), f"has barycentric of shape {place.shape}; give {(rows, columns, 3)}")
        inside = bool(np.all(np.isfinite(place))) and place.min() >= -1e-6 and np.abs(place.sum(axis=2) - 1.0).max() <= 1e-6
        self._need(inside, "leaves its triangles; barycentric coordinates lie between 0 and 1 and add to 1")
        self._need(triangle.min() >= 0, "names a triangle below 0; paint it on the skin")
        least, most = (float(value) for value in self.thickness)
        sound = math.isfinite(least) and math.isfinite(most) and 0.0 < least <= most <= THICKEST
        self._need(
            sound,
            f"is {1e3 * least:g} to {1e3 * most:g} mm thick; give 0 < least <= most <= {1e3 * THICKEST:g} mm (as metres: 0.002, 0.008)",
        )
        depth = np.asarray(self.skin_distance, dtype=np.float64)
        self._need(depth.shape in ((), (1,), (rows,)), f"has {depth.size} skin distances; give one, or one for each of its {rows} rows")
        depth = frozen(np.broadcast_to(depth, (rows,)))
        good = bool(np.all(np.isfinite(depth))) and depth.min() >= 0.0 and depth.max() <= DEEPEST
        self._need(good, f"has a skin distance outside 0 to {1e3 * DEEPEST:g} mm; give metres, like 0.003")
        self._need(self.side in SIDES, f"was painted on a {self.side!r} hand; it must be 'right' or 'left'")
        self._need(bool(self.name) and self.name.replace("_", "").isalnum(), "needs a name of letters, digits and underscores")
        self._need(len(self.drives) >= 1, "has no drive; name the pseudo muscle whose contraction it takes")
        full = np.ones(rows) if self.fullness is None else np.array(self.fullness, dtype=np.float64)
        self._need(full.shape == (rows,), f"has {full.size} values of fullness; give one for each of its {rows} rows")
        self._need(bool(np.all((full >= 0.0) & (full <= 1.0))), "has a fullness outside 0 to 1")
        if self.fullness is None:
            full[0], full[-1] = (0.0 if end else 1.0 for end in self.on_bone)
        changed = {
            "triangle": triangle,
            "barycentric": place,
            "thickness": (least, most),
            "skin_distance": depth,
            "bones": self._carriers(rows),
            "drives": tuple(self.drives),
            "sources": tuple(self.sources),
            "on_bone": (bool(self.on_bone[0]), bool(self.on_bone[1])),
            "fullness": frozen(full),
        }
        for key, value in changed.items():
            object.__setattr__(self, key, value)

    def _need(self, true: bool, what: str) -> None:
        if not true:
            raise ValueError(f"the muscle grid {self.name!r} {what}")

    def _carriers(self, rows: int) -> Bones:
        given: Any = self.bones
        if isinstance(given, str):
            given = (given,) * rows
        self._need(len(given) == rows, f"names bones for {len(given)} rows; it has {rows}")
        carriers = []
        for k, row in enumerate(given):
            shares = {row: 1.0} if isinstance(row, str) else dict(row)
            named = {find(name, BONES, kind=f"bone (row {k + 1} of {self.name})"): float(share) for name, share in shares.items()}
            total = sum(named.values())
            right = 1 <= len(named) <= 2 and min(named.values(), default=0.0) > 0.0 and math.isfinite(total)
            self._need(right, f"row {k + 1} hangs on {len(named)} bones; name one or two, with positive shares")
            carriers.append({name: share / total for name, share in named.items()})
        return tuple(carriers)

    def points_on(self, skin: Mesh, points: Array, side: str) -> Array:
        """The grid (rows, columns, 3) on ``skin`` moved to ``points`` (N, 3); also for normals. ``side`` of that hand.

        Raises ``ValueError`` where the skin has no such triangle.
        """
        if self.triangle.max() >= len(skin.faces):
            raise ValueError(
                f"the muscle grid {self.name!r} lies off the skin: it names triangle {self.triangle.max()} of {len(skin.faces)}; "
                "a grid fits the skin that it was painted on, or one warped from it"
            )
        # A mirrored hand turns its triangles round; the place on them stays.
        place = self.barycentric if side == self.side else self.barycentric[:, :, TURNED]
        result: Array = np.einsum("rck,rckd->rcd", place, np.asarray(points)[skin.faces[self.triangle]])
        return result


def _size(array: Any) -> str:
    return " x ".join(str(n) for n in array.shape) or "no"


def load_grids(folder: str | os.PathLike[str] | None = None) -> tuple[MuscleGrid, ...]:
    """All muscle grids of a folder, by file name; without one, those of the reference hand that come with handlab.

    Raises ``FileNotFoundError`` for a folder without grids, ``ValueError`` for a file that is none.
    """
    place = data.folder() / "muscles" if folder is None else Path(folder)
    files = sorted(place.glob("*.json"))
    if not files:
        raise FileNotFoundError(f"{place} holds no muscle grids (*.json)")
    return tuple(load_grid(file) for file in files)


def load_grid(path: str | os.PathLike[str]) -> MuscleGrid:
    """One muscle grid from its JSON file, as ``save_grids`` writes it."""
    file = Path(path)
    try:
        return grid_of(json.loads(file.read_text(encoding="utf-8")), file.name)
    except FileNotFoundError:
        raise FileNotFoundError(f"there is no muscle grid {file}") from None
    except json.JSONDecodeError as error:
        raise ValueError(f"{file.name}: {error}") from error


def grid_of(row: Any, file: str) -> MuscleGrid:
    """The muscle grid in what a JSON ``file`` holds. Raises ``ValueError`` for anything else."""
    try:
        return MuscleGrid(
            name=row["name"],
            drives=tuple(row["drives"]),
            triangle=np.array(row["triangle"], dtype=np.int64),
            barycentric=_places(row["barycentric"]),
            thickness=(row["thickness_mm"][0] / 1e3, row["thickness_mm"][1] / 1e3),
            skin_distance=np.array(row["skin_distance_mm"], dtype=np.float64) / 1e3,
            bones=tuple(row["bones"]),
            sources=tuple(row["sources"]),
            on_bone=tuple(row.get("on_bone", (True, True))),
            fullness=row.get("fullness"),
            confined=bool(row.get("confined", False)),
            side=row.get("side", "right"),
        )
    except (TypeError, IndexError, KeyError, AttributeError) as error:
        if isinstance(error, KeyError) and type(error) is not KeyError:
            raise  # an unknown bone, already told with the nearest ones
        raise ValueError(f"{file} is no muscle grid: {error!r} is missing or misplaced") from error
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


def _places(pairs: Any) -> Array:
    """Files keep the first two coordinates; the third is what is left of 1."""
    two = np.array(pairs, dtype=np.float64)
    if two.ndim != 3 or two.shape[2] != 2:
        raise ValueError("barycentric needs two numbers for every point of the grid")
    return np.concatenate([two, 1.0 - two.sum(axis=2, keepdims=True)], axis=2)


def save_grids(path: str | os.PathLike[str], grids: Iterable[MuscleGrid]) -> tuple[Path, ...]:
    """Write ``grids`` into the folder ``path`` (made if it is not there), one JSON file each; returns the files.

    Files keep micrometres. Raises ``ValueError`` if two grids have one name, before anything is written.
    """
    kept = tuple(grids)
    names = [grid.name for grid in kept]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"two muscle grids are called {twice[0]!r}; give every grid its own name")
    place = Path(path)
    place.mkdir(parents=True, exist_ok=True)
    files = []
    for grid in kept:
        file, part = place / f"{grid.name}.json", place / f".{grid.name}.json.part"
        part.write_text(as_text(grid), encoding="utf-8")
        part.replace(file)
        files.append(file)
    return tuple(files)


def as_text(grid: MuscleGrid) -> str:
    """The JSON of one grid, a row of the grid to a line."""
    rows = {
        "name": grid.name,
        "drives": list(grid.drives),
        "side": grid.side,
        "thickness_mm": [round(1e3 * value, 3) for value in grid.thickness],
        "skin_distance_mm": (1e3 * grid.skin_distance).round(3).tolist(),
        "fullness": np.asarray(grid.fullness).round(3).tolist(),
        "on_bone": list(grid.on_bone),
        "confined": grid.confined,
        "bones": [{name: round(share, 4) for name, share in row.items()} for row in grid.bones],
        "triangle": grid.triangle.tolist(),
        "barycentric": np.clip(grid.barycentric[:, :, :2], 0.0, 1.0).round(5).tolist(),
        "sources": list(grid.sources),
    }
    lines = []
    for key, value in rows.items():
        if key in ("triangle", "barycentric", "bones"):
            inner = ",\n    ".join(json.dumps(row) for row in value)
            lines.append(f'  "{key}": [\n    {inner}\n  ]')
        else:
            lines.append(f'  "{key}": {json.dumps(value, ensure_ascii=False)}')
    return "{\n" + ",\n".join(lines) + "\n}\n"
