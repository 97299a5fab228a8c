"""How large a pixel is: a ruler, or one click on a coin or a card of known size (section 5.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
# A coin's rounded rim is dark on a dark ground: it looks smaller by about so much (two euro coins on a flatbed: 0.2 and 0.4 mm).
RIM_MM = 0.2
CARD_MM = (85.60, 53.98)  # ISO/IEC 7810, format ID-1: bank and identity cards


@dataclass(frozen=True)
class Scale:
    """``mm_per_px`` in the plane of the ruler or coin, ``how`` it was found, ``uncertainty`` (relative) of finding it."""

    mm_per_px: float
    how: str
    uncertainty: float = 0.0

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

    The rim is found as the circle along which the picture changes most (see ``coins.find_circle``).
    Raises ``ValueError`` where no circle is found; then click two points of a ruler instead.
    """
    from handlab.fitting.coins import find_circle

    millimetres = COINS[find(size, COINS, kind="coin")] if isinstance(size, str) else _length(size, "the diameter of the coin")
    found = find_circle(np.asarray(picture), _place(click, "the click on the coin"))
    uncertainty = math.hypot(found.uncertainty, RIM_MM / millimetres)
    return Scale(millimetres / (2.0 * found.radius), f"coin, {millimetres:g} mm on {2 * found.radius:.1f} px", uncertainty)


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
    return Scale(math.sqrt(per_long * per_short), f"card, {long:g} x {short:g} mm", found.uncertainty)


def confirmed(scale: Scale, picture: Any) -> Scale:
    """The resolution of a scanner, where the file of ``picture`` tells one and a coin or card says nearly the same; else ``scale``.

    The rounded rim of a coin is dark in a scanner: the coin looks smaller by 0.2 to 0.4 mm, which is 1 to 2 %.
    """
    from handlab.fitting.lens import camera_distance_mm, scan_mm_per_px

    scan = scan_mm_per_px(picture, scale.mm_per_px) if scale.how.startswith(("coin", "card")) else None
    if scan is None or camera_distance_mm(picture, scale.mm_per_px) is not None:
        return scale
    return Scale(scan, f"scanner, {25.4 / scan:g} dots per inch; {scale.how}")


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
