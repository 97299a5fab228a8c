"""A mapping that helps whoever mistypes a name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from handlab.anatomy.terms import find, match


class Named(Mapping[str, Any]):
    """Read-only mapping that keeps order, accepts aliases, and answers an unknown name with the nearest three."""

    def __init__(self, kind: str, items: Mapping[str, Any], aliases: Mapping[str, str] | None = None) -> None:
        self._kind = kind
        self._items = MappingProxyType(dict(items))
        self._aliases = MappingProxyType(dict(aliases or {}))

    def __getitem__(self, name: str) -> Any:
        return self._items[find(name, self._items, kind=self._kind, aliases=self._aliases)]

    def __contains__(self, name: object) -> bool:
        return match(name, self._items, self._aliases) is not None

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def with_items(self, items: Mapping[str, Any]) -> Named:
        """The same kind and aliases with other items."""
        return Named(self._kind, items, self._aliases)

    def __repr__(self) -> str:
        return f"<{len(self)} {self._kind}s: {', '.join(self._items)}>"
