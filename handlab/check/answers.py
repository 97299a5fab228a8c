"""Reading what students write: joint names in any spelling, numbers with the usual slips of unit."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Hand
from handlab.anatomy.terms import UnknownName, find
from handlab.check.verdict import Wrong

VISIBLE_DEG = 0.5  # an assumption: a rotation below half a degree cannot be seen and counts as none
BY_HAND = 0.02  # an answer found by trying may be off by this part


@cache
def reference(reading: str = "sound") -> Hand:
    """The hand that checks measure: always a fresh one, so that nothing in a notebook can change an answer."""
    return load_hand(reading=reading)


def joints(answer: Any) -> set[str]:
    """Joints that an answer names: a name or several; ``"mcp2.deviation"`` counts for its joint. Raises ``Wrong``."""
    names: Iterable[Any] = [answer] if isinstance(answer, str) else answer
    try:
        return {one(str(name).partition(".")[0], reference().joints, "joint") for name in names}
    except TypeError:
        raise Wrong(f"Give joint names in quotes, like {{'mcp2', 'pip2'}}; this is {answer!r}.") from None


def one(answer: Any, known: Collection[str], kind: str) -> str:
    """The name that an answer means. Raises ``Wrong`` with the nearest names."""
    if not isinstance(answer, str):
        raise Wrong(f"Give the name of a {kind} in quotes; this is {answer!r}.")
    aliases = {muscle.abbreviation: name for name, muscle in reference().muscles.items()} if kind == "muscle" else {}
    try:
        return find(answer, tuple(known), kind=kind, aliases=aliases)
    except UnknownName as unknown:
        raise Wrong(f"{str(unknown)[:1].upper()}{str(unknown)[1:]}.") from None


def number(answer: Any, what: str, unit: str) -> float:
    """A finite number. Raises ``Wrong``."""
    try:
        value = float(answer)
    except (TypeError, ValueError):
        raise Wrong(f"{what} must be one number, in {unit}; this is {answer!r}.") from None
    if not np.isfinite(value):
        raise Wrong(f"{what} is {value}; it must be a finite number, in {unit}.")
    return value


def near(answer: Any, right: float, what: str, unit: str, part: float = BY_HAND) -> bool:
    """Whether a number is right to a part of itself."""
    return abs(number(answer, what, unit) - right) <= part * abs(right)


def said(right: float, others: dict[str, float], answer: Any, what: str, unit: str, part: float = BY_HAND) -> None:
    """Raise ``Wrong`` unless a number is right; ``others`` are numbers that come of a slip, by the sentence that helps."""
    if near(answer, right, what, unit, part):
        return
    for text, slip in others.items():
        if near(answer, slip, what, unit, part):
            raise Wrong(f"{what}: {text}")
    raise Wrong(f"{what} is not {f'{float(answer):.5g} {unit}'.strip()}.")


def listing(names: Iterable[str]) -> str:
    """``"a, b and c"``."""
    ordered = sorted(names)
    return " and ".join([", ".join(ordered[:-1]), ordered[-1]]) if len(ordered) > 1 else "".join(ordered)
