"""A check helps and never stops a notebook, except where it is asked to insist."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from handlab.check import NotAnswered, WrongAnswer, lesson
from handlab.check.answers import said
from handlab.check.lesson import Exercises, Lesson, numbers
from handlab.check.own_lines import compare
from handlab.check.verdict import Open, Outcome, Wrong, is_open


@pytest.fixture
def check(monkeypatch):
    monkeypatch.delenv("HANDLAB_STRICT", raising=False)
    exercises = Exercises("99")

    @exercises.register("seven")
    def seven(answer):
        if answer == "inside":
            raise Open
        if answer != 7:
            raise Wrong("Count again.")
        return "Seven it is."

    @exercises.register("guess", guess=True)
    def guess(answer):
        return "Now look."

    return Lesson(exercises)


def test_a_number_without_a_unit_ends_at_its_full_stop():
    with pytest.raises(Wrong, match=r"^The ratio is not 3\.$"):
        said(4.0, {}, 3, "The ratio", "")
    with pytest.raises(Wrong, match=r"^The width is not 3 mm\.$"):
        said(4.0, {}, 3, "The width", "mm")
    with pytest.raises(Wrong, match=r"the package has 0\.6925\.$"):
        compare(np.array(3.0), np.array(0.6925), {}, "thicker", "")
    with pytest.raises(Wrong, match=r"the package has 0\.6925 m\.$"):
        compare(np.array(3.0), np.array(0.6925), {}, "thicker", "m")


def test_an_open_answer_is_noted_and_does_not_stop_the_notebook(check, capsys):
    check("seven", ...)
    assert "[ ] seven: not answered yet." in capsys.readouterr().out


@pytest.mark.parametrize("answer", [[1, ...], {"a": {"b": ...}}, (..., 2), {1: (..., 3)}])
def test_a_placeholder_is_found_inside_a_container(answer):
    assert is_open(answer)


@pytest.mark.parametrize("answer", [0, "", "...", [], {}, None, {"a": 1}])
def test_an_empty_or_false_answer_is_an_answer(answer):
    assert not is_open(answer)


def test_a_function_that_returns_the_placeholder_is_open(check):
    assert check.verdict("seven", "inside").outcome is Outcome.OPEN


def test_a_wrong_answer_is_explained_and_does_not_stop_the_notebook(check, capsys):
    check("seven", 8)
    assert capsys.readouterr().out == "[!] seven: not right yet. Count again.\n"


def test_a_right_answer_is_confirmed(check, capsys):
    check("seven", 7)
    assert capsys.readouterr().out == "[x] seven: right. Seven it is.\n"


def test_a_guess_is_noted_and_counts_as_done(check, capsys):
    check("guess", 1)
    check("seven", 7)
    check.summary()
    out = capsys.readouterr().out
    assert "[x] guess: noted. Now look." in out
    assert "2 of 2 exercises of lesson 99 are done." in out


def test_the_summary_counts_what_is_done_and_names_what_is_not(check, capsys):
    check("seven", 8)
    check.summary()
    assert capsys.readouterr().out.splitlines()[1:] == ["[!] seven", "[ ] guess", "0 of 2 exercises of lesson 99 are done."]


def test_an_answer_can_be_bettered(check, capsys):
    check("seven", 8)
    check("seven", 7)
    check.summary()
    assert "[x] seven\n" in capsys.readouterr().out


def test_strict_mode_raises_on_what_is_open_or_wrong_and_on_nothing_else(check, monkeypatch):
    monkeypatch.setenv("HANDLAB_STRICT", "1")
    check("seven", 7)
    with pytest.raises(NotAnswered, match="seven"):
        check("seven", ...)
    with pytest.raises(WrongAnswer, match="Count again"):
        check("seven", 8)
    with pytest.raises(NotAnswered, match="0 of 2"):
        check.summary()
    check("seven", 7)
    check("guess", 0)
    check.summary()


@pytest.mark.parametrize("value", ["", "0"])
def test_strict_mode_can_be_switched_off(check, monkeypatch, value):
    monkeypatch.setenv("HANDLAB_STRICT", value)
    check("seven", 8)


def test_an_answer_that_breaks_the_checker_is_a_wrong_answer(check):
    class Odd:
        def __eq__(self, other):
            raise RuntimeError("no comparison")

        __hash__ = None

    verdict = check.verdict("seven", Odd())
    assert verdict.outcome is Outcome.WRONG
    assert "no comparison" in verdict.text


def test_too_many_answers_are_a_wrong_answer(check):
    assert check.verdict("seven", 7, 7).outcome is Outcome.WRONG


def test_an_exercise_that_does_not_exist_is_answered_with_the_nearest(check):
    with pytest.raises(KeyError, match="seven"):
        check("sevn", 7)


def test_two_exercises_cannot_share_a_name():
    exercises = Exercises("99")
    exercises.register("a")(lambda: "")
    with pytest.raises(ValueError, match="two exercises called 'a'"):
        exercises.register("a")(lambda: "")


def test_an_unknown_lesson_is_answered_with_those_that_exist():
    with pytest.raises(ValueError, match="00"):
        lesson("77")
    assert "00" in numbers()


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.sampled_from(["mcp2", "DI4", "metacarpal_3", ...]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["FDP2", "ODM", "LUM1", "x"]), inner, max_size=4),
    max_leaves=6,
)


@pytest.mark.parametrize("number", numbers())
@given(answers=st.lists(ANYTHING, max_size=4))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_no_answer_whatsoever_makes_a_check_raise(number, answers):
    check = lesson(number)
    for exercise in check.exercises:
        assert str(check.verdict(exercise, *answers))
