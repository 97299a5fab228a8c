"""Checks of a lesson by exercise: registered by its module, called by its notebook."""

from __future__ import annotations

import os
import pkgutil
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

import handlab.check
from handlab.anatomy.terms import find
from handlab.check.verdict import NotAnswered, Open, Outcome, Verdict, Wrong, WrongAnswer, is_open

STRICT = "HANDLAB_STRICT"
PREFIX = "lesson_"
OPEN_TEXT = "Put your answer where the dots (...) are, and run the cell again."

# A checker takes the answers of one exercise, returns the sentence that confirms them, and raises ``Wrong`` with one that helps.
Checker = Callable[..., str]


class Exercises(dict[str, Checker]):
    """The checkers of one lesson by exercise, in the order of the lesson."""

    def __init__(self, lesson: str) -> None:
        super().__init__()
        self.lesson = lesson
        self.guesses: set[str] = set()

    def register(self, name: str, *, guess: bool = False) -> Callable[[Checker], Checker]:
        """Decorator: this function checks the exercise ``name``; a guess is noted, whatever it is."""

        def add(checker: Checker) -> Checker:
            if name in self:
                raise ValueError(f"lesson {self.lesson} has two exercises called {name!r}; give one of them another name")
            self[name] = checker
            if guess:
                self.guesses.add(name)
            return checker

        return add


class Lesson:
    """The checks of one lesson. Call it with the name of an exercise and the answers; ``summary()`` says what is left."""

    def __init__(self, exercises: Exercises) -> None:
        self.number = exercises.lesson
        self._exercises = exercises
        self._said: dict[str, Verdict] = {}

    def __repr__(self) -> str:
        """Number and exercises."""
        return f"Lesson {self.number}: {', '.join(self._exercises)}"

    @property
    def exercises(self) -> tuple[str, ...]:
        """Names of the exercises."""
        return tuple(self._exercises)

    def __call__(self, exercise: str, *answers: Any) -> None:
        """Say whether the answers are right.

        Raises only under HANDLAB_STRICT=1: ``NotAnswered`` or ``WrongAnswer``. An exercise that does not exist is an error of
        the notebook, not of the student: ``UnknownName``.
        """
        verdict = self.verdict(exercise, *answers)
        self._said[verdict.exercise] = verdict
        sys.stdout.write(f"{verdict}\n")
        if strict() and verdict.outcome is Outcome.OPEN:
            raise NotAnswered(str(verdict))
        if strict() and verdict.outcome is Outcome.WRONG:
            raise WrongAnswer(str(verdict))

    def verdict(self, exercise: str, *answers: Any) -> Verdict:
        """The verdict, without a word and without raising, whatever the answers are."""
        name = find(exercise, self._exercises, kind="exercise")
        try:
            if is_open(answers):
                return Verdict(name, Outcome.OPEN, OPEN_TEXT)
            text = self._exercises[name](*answers)
            return Verdict(name, Outcome.NOTED if name in self._exercises.guesses else Outcome.RIGHT, text)
        except Open:
            return Verdict(name, Outcome.OPEN, OPEN_TEXT)
        except Wrong as wrong:
            return Verdict(name, Outcome.WRONG, str(wrong))
        except Exception as error:
            # Whatever a student hands in, the notebook goes on; what the checker stumbled over may help.
            text = f"This answer could not be read ({type(error).__name__}: {error}). Look at the form that is asked for."
            return Verdict(name, Outcome.WRONG, text)

    def summary(self) -> None:
        """One line for each exercise; under HANDLAB_STRICT=1 ``NotAnswered`` unless all are done."""
        for name in self._exercises:
            verdict = self._said.get(name, Verdict(name, Outcome.OPEN, "Its cell has not been run."))
            sys.stdout.write(f"{verdict.outcome.value[0]} {name}\n")
        done = sum(verdict.done for verdict in self._said.values())
        sys.stdout.write(f"{done} of {len(self._exercises)} exercises of lesson {self.number} are done.\n")
        if strict() and done < len(self._exercises):
            raise NotAnswered(f"lesson {self.number}: {done} of {len(self._exercises)} exercises are done")


def strict() -> bool:
    """Whether HANDLAB_STRICT asks checks to raise."""
    return os.environ.get(STRICT, "") not in ("", "0")


def numbers() -> tuple[str, ...]:
    """Numbers of the lessons that have checks, like ``"00"``."""
    names = (module.name for module in pkgutil.iter_modules(handlab.check.__path__))
    return tuple(sorted(name.removeprefix(PREFIX) for name in names if name.startswith(PREFIX)))


def lesson(number: str) -> Lesson:
    """The checks of a lesson by its number, such as ``"00"``; an unknown one is answered with what there is."""
    known = numbers()
    if number not in known:
        raise ValueError(f"there is no lesson {number!r}; the lessons with checks are {', '.join(known)}")
    exercises: Exercises = import_module(f"handlab.check.{PREFIX}{number}").EXERCISES
    return Lesson(exercises)
