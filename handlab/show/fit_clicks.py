"""What a user of the fitting page has said so far: clicks, the scale, answers. Read from pages and files with care, written as JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from handlab.anatomy.terms import find
from handlab.fitting.alignment import SIDES
from handlab.fitting.calibration import CARD_MM, COINS
from handlab.fitting.landmarks import LANDMARKS, VIEWS, read_landmarks

MOST_TEXT = 1_000_000  # characters of a file of points


@dataclass(frozen=True)
class Clicks:
    """``landmarks``: name -> (x, y) px, or None where left out, in the order of clicking; ``scale`` as for ``as_scale``, or empty.

    ``camera_mm`` above the table if known, 0 for a scanner; ``sure``: sizes and labels are right; ``mirror``: the picture is mirrored;
    ``outline``: the outline in the picture shapes the skin too.
    """

    landmarks: Mapping[str, tuple[float, float] | None] = field(default_factory=dict)
    scale: Mapping[str, Any] = field(default_factory=dict)
    view: str | None = None
    side: str | None = None
    camera_mm: float | None = None
    sure: bool = False
    mirror: bool = False
    outline: bool = True

    @property
    def placed(self) -> dict[str, tuple[float, float]]:
        """The points that have a place."""
        return {name: place for name, place in self.landmarks.items() if place is not None}

    @property
    def whole_scale(self) -> bool:
        """Whether the scale can be worked out."""
        return bool(self.scale) and ("mm" in self.scale if "ruler" in self.scale else True)

    def to_json(self) -> dict[str, Any]:
        """Plain values; ``read`` gives the same clicks back."""
        return {
            "landmarks": {name: None if place is None else list(place) for name, place in self.landmarks.items()},
            "scale": dict(self.scale),
            **{key: getattr(self, key) for key in ("view", "side", "camera_mm", "sure", "mirror", "outline")},
        }


def read(given: Any) -> Clicks:
    """Clicks from plain values. Raises ``ValueError``, ``TypeError`` or ``UnknownName`` for what can be none."""
    if not isinstance(given, Mapping):
        raise TypeError(f"clicks come as a mapping, not as {type(given).__name__}")
    landmarks = given.get("landmarks", {})
    if not isinstance(landmarks, Mapping):
        raise TypeError("landmarks is a mapping from name to (x, y)")
    camera = given.get("camera_mm")
    return Clicks(
        {find(str(name), LANDMARKS, kind="feature point"): None if at is None else place(at) for name, at in landmarks.items()},
        read_scale(given.get("scale") or {}),
        _one_of(given.get("view"), VIEWS, "view"),
        _one_of(given.get("side"), SIDES, "side"),
        camera if camera in (None, 0) else length(camera, "the height of the camera", 150.0, 5000.0),
        bool(given.get("sure", False)),
        bool(given.get("mirror", False)),
        bool(given.get("outline", True)),
    )


def read_scale(given: Any) -> dict[str, Any]:
    """A scale as ``calibration.as_scale`` takes it; a ruler may lack its millimetres or its second click while it is being clicked."""
    if not isinstance(given, Mapping):
        raise TypeError("the scale is a ruler, a coin or a card")
    if "ruler" in given:
        clicks = list(given["ruler"])
        if len(clicks) != 2:
            return {}
        found: dict[str, Any] = {"ruler": [list(place(click)) for click in clicks]}
        return found if given.get("mm") is None else {**found, "mm": length(given["mm"], "the distance on the ruler", 0.1, 1e5)}
    if "coin" in given:
        size = {"name": find(str(given["name"]), COINS, kind="coin")} if given.get("name") else {"mm": length(given.get("mm"), "the coin")}
        return {"coin": list(place(given["coin"])), **size}
    if "card" in given:
        return {"card": list(place(given["card"])), "mm": list(CARD_MM)}
    return {}


def read_file(name: str, text: Any) -> Clicks:
    """Clicks from the text of a .csv or .json file that a page sent. Raises ``ValueError`` in one sentence."""
    if not isinstance(text, str) or len(text) > MOST_TEXT:
        raise ValueError(f"{name} holds no feature points: it is too large")
    with TemporaryDirectory(prefix="handlab-") as folder:  # read_landmarks speaks of lines of a file
        suffix = ".json" if text.lstrip("\ufeff \n\r\t").startswith("{") else ".csv"
        file = Path(folder) / f"points{suffix}"
        file.write_text(text, encoding="utf-8")
        points = read_landmarks(file)
    found = Clicks({name: place_or_none(at) for name, at in points.items()})
    if suffix == ".json":
        import json

        whole = json.loads(text.lstrip("\ufeff"))
        if "landmarks" in whole:
            found = replace(read(whole), landmarks=found.landmarks)
    return found


def place(at: Any) -> tuple[float, float]:
    """(x, y) px. Raises ``ValueError`` for what is no place."""
    x, y = (float(value) for value in at)
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueError(f"({x}, {y}) is no place in a picture")
    return x, y


def place_or_none(at: Any) -> tuple[float, float] | None:
    """The same; None stays None."""
    return None if at is None else place(at)


def length(value: Any, what: str, low: float = 1.0, high: float = 1000.0) -> float:
    """Millimetres between ``low`` and ``high``. Raises ``ValueError``."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not low <= number <= high:
        raise ValueError(f"{what} is {value!r}; give millimetres from {low:g} to {high:g}")
    return number


def _one_of(value: Any, known: tuple[str, ...], name: str) -> str | None:
    if value is not None and value not in known:
        raise ValueError(f"{name} is {value!r}; it must be {known[0]!r} or {known[1]!r}")
    return None if value is None else str(value)
