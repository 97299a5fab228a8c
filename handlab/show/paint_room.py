"""Painting a muscle by clicking: what stands behind the page of the app and the panel of a notebook (section 4.2, Figure 4).

The page holds points and settings and sends all of them after every change; the host answers each message with one reply. ``ask``
never raises::

    hello    the hand to paint on, names of bones and of muscles that can drive, limits; then as ``paint``
    paint    points, settings, contraction, have (the fit that the page has), passing, back (as in ``Painting.put``): the grid, and
             the muscle that comes of it
    save     folder: the grid as data
    use      the muscle goes to the live hand

Replies have ``good``; where it is false ``text`` says why in plain words. Of ``paint``, ``troubles`` says by name which settings were
refused; the others count, and so do all points.
"""

from __future__ import annotations

import base64
import re
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from itertools import pairwise
from typing import Any

import numpy as np

from handlab.anatomy.grids import MuscleGrid, as_text, load_grids
from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.physics.distance import closest
from handlab.show import wire
from handlab.show.flesh import packed_bellies
from handlab.show.painting import MOST_COLUMNS, MOST_FINER, Painting, influenced_by
from handlab.simulation.geometric_muscle import muscles_of, shape
from handlab.simulation.grid_rows import finer_points, nearest_bones
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.muscle_fit import checked_skin

CHORD = 8  # pieces of a line between two points, each laid on the skin
TRUE_TO_MM = (" (as metres: 0.002, 0.008)", "; give metres, like 0.003")  # what code is told, and a page is not

Keep = Callable[[MuscleGrid, str], str]


class PaintRoom:
    """One muscle while it is painted on ``hand``. ``use`` takes the finished grid to the live hand, ``save`` writes it into a folder;
    both return a sentence. Without ``save`` the page gets the file."""

    def __init__(self, painting: Painting, *, use: Callable[[MuscleGrid], str] | None = None, save: Keep | None = None) -> None:
        self.painting = painting
        self.contraction = 0.0
        self.view, self.skin = "palm", "translucent"
        self._use, self._keep = use, save
        self._lock = threading.RLock()

    @property
    def hand(self) -> Hand:
        """What is painted on."""
        return self.painting.hand

    def ask(self, message: Any, data: bytes | None = None) -> dict[str, Any]:
        """The reply to a message of a page."""
        start = time.perf_counter()
        with self._lock:
            try:
                kind = message.get("kind") if isinstance(message, Mapping) else None
                reply = {"good": True, **ACTS[find(str(kind), ACTS, kind="message")](self, message)}
            except (ValueError, LookupError, TypeError, OSError, ArithmeticError, AttributeError, MemoryError) as error:
                reply = {"good": False, "text": plain(error)}
        return {**reply, "ms": round(1e3 * (time.perf_counter() - start), 1)}

    def told(self, have: int = -1) -> dict[str, Any]:
        """Everything that a page shows; the surface of the muscle only if its fit is not ``have``."""
        painting, found = self.painting, self.painting.result
        told: dict[str, Any] = {
            "settings": asdict(painting.settings),
            "points": painting.points.tolist(),
            "contraction": self.contraction,
            "skin": self.skin,
            "rows": len(painting.rows),
            "missing": painting.missing,
            "carriers": [list(row) for row in painting.carriers],
            "problem": painting.problem and plain(painting.problem),
            "facts": facts(painting),
            "fit": painting.fits,
            "muscle": found is not None,
            **surface_lines(painting),
        }
        if found is not None:
            pull = np.zeros(len(self.hand.muscles))
            pull[[self.hand.muscle_names.index(name) for name in found.muscle.drives[0]]] = self.contraction
            segments = shape(found.muscle, relative_transforms(self.hand, self.hand.bind), pull)
            told |= {"influenced": found.influenced.tolist(), "segments": _text(wire.segment_table(segments))}
            if have != painting.fits:
                told["layers"] = _text(packed_bellies(self.hand, found.muscle))
        return told

    # What a page asks.

    def _hello(self, message: Mapping[str, Any]) -> dict[str, Any]:
        threading.Thread(target=warm_up, args=(self.hand,), daemon=True).start()
        return {
            "scene": _text(wire.scene(self.hand, shown_clips=())),
            "view": self.view,
            "bones": list(self.hand.bones),
            "drives": [[name, muscle.abbreviation] for name, muscle in self.hand.muscles.items()],
            "most_columns": MOST_COLUMNS,
            "most_finer": MOST_FINER,
            "folder": "muscles" if self._keep is not None else None,
            **self.told(),
        }

    def _paint(self, message: Mapping[str, Any]) -> dict[str, Any]:
        troubles = {}
        chosen = self.painting.settings
        given = message.get("settings")
        for name, value in (given if isinstance(given, Mapping) else {}).items():
            if getattr(chosen, str(name), self) == _numbers(value):
                continue
            try:
                chosen = self.painting.wanted({**asdict(chosen), name: _numbers(value)})
            except (ValueError, LookupError, TypeError) as error:
                troubles[str(name)] = plain(error)
        how = {key: bool(message.get(key)) for key in ("passing", "back")}
        self.painting.put(message.get("points", self.painting.points), chosen, **how)
        contraction = message.get("contraction", self.contraction)
        if isinstance(contraction, int | float) and 0.0 <= contraction <= 1.0:
            self.contraction = float(contraction)
        else:
            troubles["contraction"] = f"contraction is {contraction}; it lies between 0 and 1"
        return {**self.told(int(message.get("have", -1))), "troubles": troubles}

    def _finished(self) -> MuscleGrid:
        painting = self.painting
        if painting.result is None:
            raise ValueError(painting.problem or f"There is no muscle yet: it takes {painting.missing} more {clicks(painting.missing)}.")
        return painting.result.grid

    def _save(self, message: Mapping[str, Any]) -> dict[str, Any]:
        grid = self._finished()
        if self._keep is not None:
            return {"said": self._keep(grid, str(message.get("folder") or "muscles"))}
        return {
            "said": f'{grid.name}.json is saved. "keep" beside the live hand loads it.',
            "file": {"name": f"{grid.name}.json", "text": as_text(grid)},
        }

    def _moved(self, message: Mapping[str, Any]) -> dict[str, Any]:
        if self._use is None:
            raise ValueError("there is no live hand here; save the muscle and load it there")
        return {"said": self._use(self._finished())}


def facts(painting: Painting) -> list[str]:
    """What is known of the muscle, and how long its fit took."""
    found = painting.result
    if found is None:
        return []
    thick = 1e3 * found.muscle.fitted[0].thickness
    return [
        f"{found.length_mm:.1f} mm long",
        f"{thick.min():.1f} to {thick.max():.1f} mm thick",
        f"{found.volume_ml:.2f} ml at rest",
        f"below {len(found.influenced)} of {len(painting.hand.skin.points)} skin points",
        f"fitted in {found.seconds:.2f} s",
    ]


def clicks(count: int) -> str:
    """One click, several clicks."""
    return "click" if count == 1 else "clicks"


def plain(error: object) -> str:
    """A sentence in millimetres about the one muscle that there is."""
    said = " ".join(str(error).split()) or type(error).__name__
    said = re.sub(r"^the muscle grid '[^']*'", "the muscle", said)
    for part in TRUE_TO_MM:
        said = said.replace(part, "")
    return said[:1].upper() + said[1:]


def surface_lines(painting: Painting) -> dict[str, Any]:
    """``lines`` on the skin: rows and columns of the grid as it was divided, and of a grid that is not whole what there is.

    Points (n, 3) in millimetres, and ``outward`` their unit normals, both flat.
    """
    ways = grid_ways(painting)
    if not ways:
        return {"lines": [], "outward": []}
    points = np.concatenate(ways)
    corners = np.ascontiguousarray(painting.hand.skin.points[painting.hand.skin.faces])
    _, triangle, place = closest(np.ascontiguousarray(points), corners)
    up = checked_skin(painting.hand)[painting.hand.skin.faces[triangle]].mean(axis=1)
    ends = np.cumsum([len(way) for way in ways])[:-1]
    return {
        "lines": [part.round(2).ravel().tolist() for part in np.split(1e3 * place, ends)],
        "outward": [part.round(2).ravel().tolist() for part in np.split(up, ends)],
    }


def grid_ways(painting: Painting) -> list[Array]:
    """Lines (n, 3) through the points, straight between them but for pieces of ``CHORD``; metres."""
    whole = painting.rows
    rest = painting.points[whole.size // 3 :]
    grid = finer_points(painting.hand, whole, painting.settings.finer) if len(whole) > 1 else whole
    ways = [*grid, *(grid.transpose(1, 0, 2) if len(grid) > 1 else ()), *([rest] if len(rest) > 1 else ())]
    ways += [np.stack([whole[-1, k], rest[k]]) for k in range(len(rest))] if len(whole) else []
    share = np.linspace(0.0, 1.0, CHORD, endpoint=False)[:, None]
    return [np.concatenate([*(a + share * (b - a) for a, b in pairwise(way)), way[-1:]]) for way in ways]


def warm_up(hand: Hand) -> None:
    """What is compiled is loaded now: the first fit of a user must not wait for it."""
    grid = replace(load_grids()[0], side=hand.side)
    muscle = muscles_of(hand, [grid])
    influenced_by(hand, muscle)
    packed_bellies(hand, muscle)
    nearest_bones(hand, grid.points_on(hand.skin, hand.skin.points, hand.side))


def _numbers(value: Any) -> Any:
    """Lists of a page as tuples."""
    return tuple(_numbers(one) for one in value) if isinstance(value, list) else value


def _text(data: bytes) -> str:
    return base64.b64encode(data).decode()


ACTS: dict[str, Callable[[PaintRoom, Mapping[str, Any]], dict[str, Any]]] = {
    "hello": PaintRoom._hello,
    "paint": PaintRoom._paint,
    "save": PaintRoom._save,
    "use": PaintRoom._moved,
}
