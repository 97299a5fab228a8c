"""How large a pixel is: a ruler, or one click on a coin or a card of known size (section 5.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.records import Array
from handlab.anatomy.terms import find

# Diameters in mm: legal dimensions of the coins.
COINS: Mapping[str, float] = MappingProxyType(
    {
        "1 cent": 16.25, "2 cent": 18.75, "5 cent": 21.25, "10 cent": 19.75, "20 cent": 22.25, "50 cent": 24.25,
        "1 euro": 23.25, "2 euro": 25.75,
        "US cent": 19.05, "US nickel": 21.21, "US dime": 17.91, "US quarter": 24.26,
        "1 penny": 20.3, "2 pence": 25.9, "10 pence": 24.5, "1 pound": 23.43,
        "1 franc": 23.2, "2 francs": 27.4, "5 francs": 31.45,
        "100 yen": 22.6, "500 yen": 26.5,
    }
)  # fmt: skip
# The edge of a coin is rounded with about this radius (an assumption; worn and new coins may differ by half of it). Metal mirrors: where
# the rounding is steeper than 45 degrees it shows the table and is as dark as that, so that a ring of 0.09 mm is not seen.
ROUNDING_MM, ROUNDING_MAY_DIFFER = 0.3, 0.5
UNSEEN_MM = ROUNDING_MM * (1.0 - math.sqrt(0.5))
SIDEWAYS = 0.003  # what the side of a coin adds that is not right below the camera (2 mm thick, some 5 cm beside, 60 cm away)
PLACED_PX = 0.25  # how well a blurred edge is placed
DOUBTFUL = 0.03  # a coin that may be its own shadow: as wide as shadows of coins were found to be
# So far the widest part of a coin lies above the table: euro coins are 1.67 to 2.38 mm thick, less the rounding (an assumption for others).
COIN_ABOVE_MM = 1.8
CARD_ABOVE_MM = 0.76  # ISO/IEC 7810
CARD_MM = (85.60, 53.98)  # ISO/IEC 7810, format ID-1: bank and identity cards


@dataclass(frozen=True)
class Scale:
    """``mm_per_px`` of what was measured, ``how`` it was found, ``uncertainty`` (relative) of finding it; ``above_mm`` so far above the
    table, towards the camera, it was found (see ``confirmed``)."""

    mm_per_px: float
    how: str
    uncertainty: float = 0.0
    above_mm: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is no scale."""
        if not (isinstance(self.mm_per_px, int | float) and math.isfinite(self.mm_per_px) and self.mm_per_px > 0.0):
            raise ValueError(f"the scale is {self.mm_per_px!r} mm per pixel; it must be a positive number, such as 0.15")


def ruler(first: Sequence[float], second: Sequence[float], millimetres: float) -> Scale:
    """The scale from two clicks (x, y) px that are ``millimetres`` apart on a ruler.

    >>> ruler((100, 900), (2100, 900), 200).mm_per_px
    0.1
    """
    millimetres = _length(millimetres, "the distance on the ruler")
    a, b = (_place(click, name) for click, name in ((first, "the first click on the ruler"), (second, "the second click on the ruler")))
    apart = math.dist(a, b)
    if apart < 2.0:
        raise ValueError(
            f"the two clicks on the ruler are {apart:.1f} pixels apart; click two marks that are far from each other, such as 0 and 20 cm"
        )
    return Scale(millimetres / apart, f"ruler, {millimetres:g} mm on {apart:.1f} px", math.sqrt(2.0) / apart)


def coin(picture: NDArray[Any], click: Sequence[float], size: float | str) -> Scale:
    """The scale from one click on a coin: ``picture`` (rows, columns[, 3]), ``size`` its diameter in mm or its name ("2 euro").

    See ``rim`` for how the outline is found. Where it is seen by its light, the diameter half way between mean and longest counts (missing
    light and a tilt shorten the others; the side of a coin beside the camera lengthens one), with the ring that is too dark to be seen.
    Seen by its colour, the mean diameter counts.
    Raises ``ValueError`` where no circle is found; then click two points of a ruler instead.
    """
    from handlab.fitting.coins import find_circle
    from handlab.fitting.rim import outline

    millimetres = COINS[find(size, COINS, kind="coin")] if isinstance(size, str) else _length(size, "the diameter of the coin")
    pixels = np.asarray(picture)
    found = outline(pixels, *find_circle(pixels, _place(click, "the click on the coin")))
    bright = found.seen == "by light"
    across = 2.0 * found.radius * (1.0 + 0.5 * found.oval if bright else 1.0)
    unseen = 2.0 * UNSEEN_MM if bright else 0.0
    uncertainty = math.hypot(
        found.scatter / 2.0, PLACED_PX / found.radius, SIDEWAYS, found.oval / 2.0, ROUNDING_MAY_DIFFER * unseen / millimetres
    )
    if found.seen == "doubtful":
        uncertainty = math.hypot(uncertainty, DOUBTFUL)
    how = (
        f"coin, {millimetres:g} mm on {across:.1f} px, seen {found.seen}"
        if found.seen != "doubtful"
        else f"coin, {millimetres:g} mm, {found.seen}"
    )
    return Scale((millimetres - unseen) / across, how, uncertainty, COIN_ABOVE_MM)


def card(picture: NDArray[Any], click: Sequence[float], size: tuple[float, float] = CARD_MM) -> Scale:
    """The scale from one click on a bank card (or another rectangle of ``size`` mm) that lies flat, at any angle."""
    from handlab.fitting.coins import find_rectangle

    long, short = (_length(value, "a side of the card") for value in sorted(size, reverse=True))
    found = find_rectangle(np.asarray(picture), _place(click, "the click on the card"), long / short)
    per_long, per_short = long / found.long, short / found.short
    if abs(math.log(per_long / per_short)) > 0.05:
        raise ValueError(
            f"what was clicked is {found.long:.0f} x {found.short:.0f} pixels, not a card of {long:g} x {short:g} mm seen from above; "
            "photograph it flat and whole, or use a ruler"
        )
    return Scale(math.sqrt(per_long * per_short), f"card, {long:g} x {short:g} mm", found.uncertainty, CARD_ABOVE_MM)


def confirmed(scale: Scale, picture: Any, camera_mm: float | str | None = "auto") -> Scale:
    """``scale`` on the table: of a scanner by its resolution, of a camera a little more than on the coin or card, which lies nearer.

    A scanner's file tells its resolution, which is better than a coin that says nearly the same. A camera at the distance d shows what
    lies h above the table d / (d - h) times as large. ``camera_mm`` as for ``fit_photo``; None: a scanner.
    """
    from handlab.fitting.lens import ASSUMED_MM, camera_distance_mm, scan_mm_per_px

    if not scale.how.startswith(("coin", "card")):
        return scale
    told = camera_distance_mm(picture, scale.mm_per_px) if camera_mm == "auto" else camera_mm
    scan = scan_mm_per_px(picture, scale.mm_per_px)
    if told is None and scan is not None:
        return Scale(scan, f"scanner, {25.4 / scan:g} dots per inch; {scale.how}")
    if camera_mm is None:
        return scale
    return replace(scale, mm_per_px=scale.mm_per_px * (1.0 + scale.above_mm / float(told or ASSUMED_MM)), above_mm=0.0)


def as_scale(scale: Any, picture: NDArray[Any] | None = None) -> Scale:
    """A ``Scale`` from what a user gives: a number (mm per px), a ``Scale``, or a mapping.

    ``{"ruler": [(x, y), (x, y)], "mm": 200}``, ``{"coin": (x, y), "mm": 25.75}`` (or ``"name": "2 euro"``), ``{"card": (x, y)}``.
    """
    if isinstance(scale, Scale):
        return scale
    if isinstance(scale, int | float | np.floating | np.integer) and not isinstance(scale, bool):
        return Scale(float(scale), "given")
    if isinstance(scale, Mapping):
        kind = next((key for key in ("ruler", "coin", "card") if key in scale), None)
        if kind == "ruler":
            if len(scale["ruler"]) != 2:
                raise ValueError(f"the ruler has {len(scale['ruler'])} clicks; give two, such as at 0 and 20 cm")
            return ruler(scale["ruler"][0], scale["ruler"][1], scale.get("mm", math.nan))
        if kind is not None:
            if picture is None:
                raise ValueError(f"a {kind} is looked for in the picture itself; give the picture, not only its size")
            if kind == "coin":
                return coin(picture, scale["coin"], scale.get("name", scale.get("mm", math.nan)))
            return card(picture, scale["card"], scale.get("mm", CARD_MM))
    raise ValueError(
        f"scale is {scale!r}; give millimetres per pixel, or {{'ruler': [(x, y), (x, y)], 'mm': 200}}, "
        "{'coin': (x, y), 'mm': 25.75} or {'card': (x, y)}"
    )


def _length(value: Any, what: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not (math.isfinite(number) and number > 0.0):
        raise ValueError(f"{what} is {value!r}; give a positive number of millimetres")
    return number


def _place(click: Sequence[float], what: str) -> Array:
    place = np.asarray(click, dtype=np.float64)
    if place.shape != (2,) or not np.isfinite(place).all():
        raise ValueError(f"{what} is {click!r}; give (x, y) in pixels")
    return place
