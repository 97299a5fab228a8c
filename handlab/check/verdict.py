"""What a check says: right, wrong (and why), or not answered yet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any


class Outcome(Enum):
    """What an answer can be, with the mark and the words that stand before the explanation."""

    RIGHT = "[x]", "right."
    NOTED = "[x]", "noted."  # a guess, which is neither right nor wrong
    WRONG = "[!]", "not right yet."
    OPEN = "[ ]", "not answered yet."


@dataclass(frozen=True)
class Verdict:
    """The outcome of one exercise and the sentence that explains it."""

    exercise: str
    outcome: Outcome
    text: str

    def __str__(self) -> str:
        """One line with a mark: [x] done, [!] not right yet, [ ] not answered."""
        mark, words = self.outcome.value
        return f"{mark} {self.exercise}: {words} {self.text}"

    @property
    def done(self) -> bool:
        """Whether nothing is left to do."""
        return self.outcome in (Outcome.RIGHT, Outcome.NOTED)


class NotAnswered(Exception):  # noqa: N818 (an answer that is missing is no error)
    """Raised for an open exercise under HANDLAB_STRICT=1."""


class WrongAnswer(Exception):  # noqa: N818
    """Raised for a wrong answer under HANDLAB_STRICT=1."""


class Wrong(Exception):  # noqa: N818
    """What a checker raises; its text is the explanation that the student reads."""


class Open(Exception):  # noqa: N818
    """What a checker raises when it finds the placeholder only after looking inside, as in a function that returns ``...``."""


def is_open(answer: Any) -> bool:
    """Whether an answer, or anything inside it, is still the placeholder ``...``."""
    if answer is ...:
        return True
    if isinstance(answer, Mapping):
        return any(is_open(one) for one in answer.values())
    if isinstance(answer, list | tuple | set | frozenset):
        return any(is_open(one) for one in answer)
    return False
