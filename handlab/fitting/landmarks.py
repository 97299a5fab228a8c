"""The 26 feature points of section 5.1: their names, where they are on a hand, and files of clicks.

A click is a place (x, y) in pixels of the picture, x to the right and y downwards from its upper left corner. The same names serve
pictures of the palm and of the back; on the skin the two views have points of their own where they differ.
"""

from __future__ import annotations

import csv
import json
import math
import os
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import FINGERS, find
from handlab.fitting.marks import exact_points
from handlab.fitting.mistakes import FitError

VIEWS = ("palmar", "dorsal")
MARKS = ("exact", "stored")
FEWEST = 4  # three points give no more than place, size and turn

_JOINTS = {"dip": "last joint (DIP)", "ip": "joint (IP)", "pip": "middle joint (PIP)", "mcp": "knuckle (MCP)"}


def _table() -> dict[str, str]:
    rows = {f"tip_{finger}": f"tip of the {finger}" for finger in FINGERS}
    for joint, fingers in (("dip", FINGERS[1:]), ("ip", FINGERS[:1]), ("pip", FINGERS[1:]), ("mcp", FINGERS)):
        rows |= {f"{joint}_{finger}": f"{_JOINTS[joint]} of the {finger}" for finger in fingers}
    rows |= {f"web_{a}_{b}": f"skin between {a} and {b}" for a, b in pairwise(FINGERS)}
    return rows | {
        "wrist_radial": "edge of the wrist, thumb's side",
        "wrist_ulnar": "edge of the wrist, little finger's side",
        "head_of_ulna": "head of the ulna",
    }


# Name -> what to click, in the order of the paper's table.
LANDMARKS: Mapping[str, str] = MappingProxyType(_table())
NAMES = tuple(LANDMARKS)
# A choice of 16 that determines every digit and both ends of the palm: what to click when time is short.
SIXTEEN = (
    *(f"tip_{finger}" for finger in FINGERS),
    "ip_thumb",
    *(f"pip_{finger}" for finger in FINGERS[1:]),
    "mcp_thumb",
    "mcp_index",
    "mcp_middle",
    "mcp_little",
    "wrist_radial",
    "wrist_ulnar",
)


def digit_of(name: str) -> str | None:
    """The finger that a point lies on; none for webs and the wrist."""
    return name.partition("_")[2] if name.startswith(("tip", "dip", "ip", "pip", "mcp")) else None


def source_points(hand: Hand, view: str, names: tuple[str, ...] = NAMES, marks: str = "stored") -> Array:
    """Points (N, 3) m of the skin that ``names`` mark in a picture of ``view`` ("palmar" or "dorsal").

    ``marks``: "stored", the points of the even skin that the hand names; "exact", joints right above their centres (see ``marks``).
    """
    if view not in VIEWS:
        raise ValueError(f"view is {view!r}; it must be 'palmar' or 'dorsal'")
    if marks not in MARKS:
        raise ValueError(f"marks is {marks!r}; it must be 'exact' or 'stored'")
    if marks == "exact":
        return exact_points(hand, view, names)
    points: Array = hand.skin.points[[hand.feature_points[name][view] for name in names]]
    return points


def checked(landmarks: Mapping[str, Any] | str | os.PathLike[str]) -> dict[str, tuple[float, float]]:
    """Clicks by full name, in the order of the table; a path is read first. A value of None is a point that was left out.

    Raises ``FitError`` (it carries the clicks) for points that are no places, too few of them, all on one line, or two at one place.
    """
    given = read_landmarks(landmarks) if isinstance(landmarks, str | os.PathLike) else landmarks
    if not isinstance(given, Mapping):
        raise TypeError(f"landmarks come as a mapping from name to (x, y) in pixels, or as a file, not as {type(given).__name__}")
    found: dict[str, tuple[float, float]] = {}
    for name, place in given.items():
        full = find(name, LANDMARKS, kind="feature point")
        if place is None:
            continue
        if full in found:
            raise FitError(f"{full} is given twice; keep one of the two", found, (full,))
        try:
            x, y = (float(value) for value in place)
        except (TypeError, ValueError):
            raise FitError(f"{full} is {place!r}; give its place as (x, y) in pixels", found, (full,)) from None
        if not (math.isfinite(x) and math.isfinite(y)):
            raise FitError(f"{full} is at ({x}, {y}); give finite numbers of pixels", found, (full,))
        found[full] = x, y
    clicks = {name: found[name] for name in NAMES if name in found}
    _determined(clicks)
    return clicks


def _determined(clicks: dict[str, tuple[float, float]]) -> None:
    if not clicks:
        raise FitError("there are no feature points yet; click at least 16 of the 26, the finger tips first", clicks)
    if len(clicks) < FEWEST:
        raise FitError(
            f"{len(clicks)} feature points do not determine a hand; click at least {FEWEST}, "
            "better 16 (tips, middle joints, knuckles, wrist)",
            clicks,
        )
    at, names = np.array(list(clicks.values())), list(clicks)
    spread = np.linalg.svd(at - at.mean(axis=0), compute_uv=False)
    apart = np.linalg.norm(at[:, None] - at, axis=2)
    np.fill_diagonal(apart, np.inf)
    if apart.min() <= 1e-3 * max(spread[0], 1e-9) / math.sqrt(len(at)):
        i, j = sorted(int(k) for k in np.unravel_index(int(apart.argmin()), apart.shape))
        raise FitError(f"{names[i]} and {names[j]} are at one place; move one of them", clicks, (names[i], names[j]))
    if spread[1] < 0.02 * spread[0]:
        raise FitError(
            "all feature points lie on one line; add points to its side, such as the tip of the thumb or both edges of the wrist", clicks
        )


def read_landmarks(path: str | os.PathLike[str]) -> dict[str, tuple[float, float] | None]:
    """Clicks from a file: JSON ``{"tip_index": [x, y], ...}`` (or the same under ``"landmarks"``), or CSV ``name,x,y``.

    Raises ``FileNotFoundError``, ``ValueError`` with the line, or ``UnknownName`` with the nearest names.
    """
    file = Path(path)
    if not file.is_file():
        raise FileNotFoundError(f"there is no file of feature points {file}")
    text = file.read_text(encoding="utf-8-sig")
    if file.suffix.lower() == ".json":
        try:
            rows = json.loads(text)
            rows = rows.get("landmarks", rows)
            return {name: None if place is None else (float(place[0]), float(place[1])) for name, place in rows.items()}
        except (ValueError, TypeError, AttributeError, IndexError, KeyError) as error:
            raise ValueError(
                f'{file.name} holds no feature points ({error}); it should look like {{"tip_index": [812, 240], ...}}'
            ) from error
    points: dict[str, tuple[float, float] | None] = {}
    for number, cells in enumerate(csv.reader(text.splitlines()), start=1):
        row = [cell.strip() for cell in cells]
        if (
            not any(row)
            or row[0].startswith("#")
            or (not points and [cell.lower() for cell in row[:3]][1:] in (["x", "y"], ["x_px", "y_px"]))
        ):
            continue
        try:
            name, x, y = row[:3]
            points[find(name, LANDMARKS, kind=f"feature point in line {number} of {file.name}:")] = (float(x), float(y)) if x or y else None
        except ValueError:
            raise ValueError(f"{file.name}, line {number}: {','.join(cells)!r} is not name,x,y (pixels)") from None
    return points


def write_landmarks(landmarks: Mapping[str, Any], path: str | os.PathLike[str]) -> Path:
    """Write clicks as JSON or CSV (by suffix), whole or not at all; ``read_landmarks`` gives the same numbers back."""
    file = Path(path)
    rows = {name: None if place is None else [float(place[0]), float(place[1])] for name, place in landmarks.items()}
    if file.suffix.lower() == ".json":
        text = json.dumps({"landmarks": rows}, indent=1) + "\n"
    elif file.suffix.lower() == ".csv":
        text = "name,x_px,y_px\n" + "".join(f"{name},,\n" if p is None else f"{name},{p[0]!r},{p[1]!r}\n" for name, p in rows.items())
    else:
        raise ValueError(f"{file.name}: feature points are written as .json or .csv")
    part = file.with_name(f".{file.name}.part")
    part.write_text(text, encoding="utf-8")
    part.replace(file)
    return file
