"""Comparing what a student's own function returns with what the package has, and naming the likely slip."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.check.verdict import Open, Wrong, is_open


def values(function: Any, *arguments: Any) -> Array:
    """What a student's function returns, as an array; the placeholder is passed on as not answered."""
    if not callable(function):
        raise Wrong("Hand over the function itself, without brackets.")
    result = function(*arguments)
    if is_open(result) or result is None:
        raise Open
    return np.asarray(result, dtype=np.float64)


def same(one: Array, other: Array) -> bool:
    """Equal to nine digits."""
    return one.shape == other.shape and bool(np.abs(one - other).max() <= 1e-9 * np.abs(other).max())


def compare(theirs: Array, right: Array, slips: dict[str, Array], what: str, unit: str = "kg m^2") -> None:
    """Raise ``Wrong`` unless ``theirs`` is ``right``; ``slips`` are wrong results by the sentence that explains them."""
    if same(theirs, right):
        return
    for text, wrong in slips.items():
        if same(theirs, wrong):
            raise Wrong(text)
    if theirs.shape != right.shape:
        raise Wrong(f"{what} has shape {theirs.shape}; it should have {right.shape}.")
    raise Wrong(f"{what} comes out at {theirs.ravel()[0]:.4g}; the package has {f'{right.ravel()[0]:.4g} {unit}'.strip()}.")
