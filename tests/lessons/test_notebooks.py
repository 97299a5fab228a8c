"""Notebooks come from the lessons, are short, and hide the solutions only from those who should find them."""

import ast
import json
import re
from pathlib import Path

import nbformat
import pytest

from handlab.check import lesson
from tools import notebooks

LESSONS = notebooks.sources()
BOTH = [(source, solved) for source in LESSONS for solved in (False, True)]
NAMES = [f"{source.stem}-{'solved' if solved else 'student'}" for source, solved in BOTH]
MOST_CELLS = 40
MOST_LINES = 12
FIRST = "import handlab as hl"


def code(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def test_there_are_lessons_and_each_has_a_notebook_and_no_notebook_is_left_over():
    assert LESSONS
    assert {path.stem for path in notebooks.NOTEBOOKS.glob("*.ipynb")} == {source.stem for source in LESSONS}


@pytest.mark.parametrize("source", LESSONS, ids=lambda source: source.stem)
def test_the_committed_notebook_is_what_the_lesson_gives(source):
    committed = (notebooks.NOTEBOOKS / f"{source.stem}.ipynb").read_text(encoding="utf-8")
    assert committed == notebooks.text_of(source, solved=False), "run: python -m tools.notebooks"


def test_building_twice_gives_the_same_bytes(tmp_path):
    one = [path.read_bytes() for path in notebooks.write(tmp_path / "one", solved=True)]
    two = [path.read_bytes() for path in notebooks.write(tmp_path / "two", solved=True)]
    assert one == two


def test_a_notebook_whose_lesson_is_gone_goes_too(tmp_path):
    stale, other = tmp_path / "77_gone.ipynb", tmp_path / "notes.ipynb"
    stale.write_text("{}")
    other.write_text("{}")
    notebooks.write(tmp_path, solved=False)
    assert not stale.exists()
    assert other.exists()


@pytest.mark.parametrize(("source", "solved"), BOTH, ids=NAMES)
def test_a_lesson_keeps_the_rules_of_the_house(source, solved):
    book = notebooks.notebook(source, solved=solved)
    nbformat.validate(book)
    cells = code(book)
    assert len(book.cells) <= MOST_CELLS
    assert max(len(cell.source.splitlines()) for cell in cells) <= MOST_LINES
    assert cells[0].source.splitlines()[0] == FIRST
    assert len({cell.id for cell in book.cells}) == len(book.cells)
    text = "\n".join(cell.source for cell in cells)
    assert not re.search(r"\binteract(ive|ive_output)?\b|^\s*[!%]", text, flags=re.MULTILINE)
    assert not re.search(r"# (end )?solution", text)
    for cell in cells:
        ast.parse(cell.source)
        assert not cell.outputs
        assert cell.execution_count is None


@pytest.mark.parametrize("source", LESSONS, ids=lambda source: source.stem)
def test_every_exercise_has_a_check_a_heading_and_a_place_for_the_answer(source):
    student = "\n".join(cell.source for cell in code(notebooks.notebook(source, solved=False)))
    called = re.findall(r'^check\("(\w+)"', student, flags=re.MULTILINE)
    assert tuple(called) == lesson(source.stem[:2]).exercises
    assert student.count("...") >= len(called)
    assert source.read_text(encoding="utf-8").rstrip().endswith("check.summary()")


@pytest.mark.parametrize("source", LESSONS, ids=lambda source: source.stem)
def test_the_student_form_holds_nothing_of_the_solutions(source):
    """Every line between the marks is looked for in what students get."""
    inside, secret = False, []
    for line in source.read_text(encoding="utf-8").splitlines():
        if notebooks.END.match(line):
            inside = False
        elif inside and len(line.strip()) > 12:
            secret.append(line.strip())
        inside = inside or bool(notebooks.BEGIN.match(line))
    student = notebooks.text_of(source, solved=False)
    solved = notebooks.text_of(source, solved=True)
    assert secret
    for line in secret:
        as_written = json.dumps(line)[1:-1]
        assert student.count(as_written) < solved.count(as_written), line
    assert "For the lecturer" not in student


def test_every_lesson_with_checks_exists_and_the_other_way_round():
    from handlab.check.lesson import numbers

    assert {source.stem[:2] for source in LESSONS} == set(numbers())


def test_what_a_student_gets_of_a_solution_is_its_placeholder():
    lines = ["def f(x):", "    # solution: return ...", "    y = x", "    return y", "    # end solution", "f(1)"]
    assert notebooks.student_lines(lines, "here") == ["def f(x):", "    return ...", "f(1)"]
    assert notebooks.solved_lines(lines) == ["def f(x):", "    y = x", "    return y", "f(1)"]
    assert notebooks.student_lines(["a = 1", "# solution", "b = 2"], "here") == ["a = 1"]


@pytest.mark.parametrize("lines", [["# end solution"], ["# solution", "# solution", "# end solution"]])
def test_marks_that_do_not_fit_are_refused(lines):
    with pytest.raises(ValueError, match="here: "):
        notebooks.student_lines(lines, "here")


def test_only_lessons_hold_solutions():
    assert not [path for path in notebooks.NOTEBOOKS.iterdir() if path.suffix == ".py"], (
        "a .py file here would shadow a package of its name"
    )
    assert all(path.parent == Path(notebooks.LESSONS) for path in LESSONS)
