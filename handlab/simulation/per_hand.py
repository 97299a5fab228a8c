"""Arrays computed once per hand: a hand never changes, so what follows from it is kept as long as the hand lives."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

from handlab.anatomy.records import Hand

T = TypeVar("T")


def per_hand(build: Callable[[Hand], T]) -> Callable[[Hand], T]:
    """Call ``build`` once for every hand. Its result must not hold the hand, or neither would ever be freed."""
    kept: WeakKeyDictionary[Hand, T] = WeakKeyDictionary()

    @wraps(build)
    def get(hand: Hand) -> T:
        found = kept.get(hand)
        if found is None:
            found = kept[hand] = build(hand)
        return found

    return get
