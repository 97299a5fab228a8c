"""What is said when a photograph cannot become a hand; the user's clicks come along, so that they are never lost."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any


class FitError(ValueError):
    """A fit that was refused, and what to do about it.

    ``landmarks``: the points as they were given (name -> (x, y) px), to correct and try again; ``names``: those to look at.
    """

    def __init__(self, message: str, landmarks: Mapping[str, Any] | None = None, names: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.landmarks = MappingProxyType({name: tuple(place) for name, place in (landmarks or {}).items()})
        self.names = names


class FitQuestion(FitError):  # noqa: N818 (it asks)
    """A fit that needs an answer first: ``choices`` are the keyword arguments that answer it."""

    def __init__(
        self,
        message: str,
        landmarks: Mapping[str, Any] | None = None,
        names: tuple[str, ...] = (),
        choices: tuple[dict[str, Any], ...] = (),
    ) -> None:
        super().__init__(message, landmarks, names)
        self.choices = choices
