"""Lessons become notebooks: one source with solutions, two forms.

    python -m tools.notebooks                  the student form of every lesson, into notebooks/
    python -m tools.notebooks --solved FOLDER  the solved form, into FOLDER

A lesson is a jupytext py:percent file. Between ``# solution: PLACEHOLDER`` and ``# end solution`` (or the end of the cell) stands
what students do not get; their form has PLACEHOLDER there, which runs. ``# solution`` without a placeholder leaves nothing.
A cell tagged ``solution`` is in the solved form only. Ids of cells count within their lesson, so a rebuild gives the same bytes.
"""

import argparse
import re
import sys
from pathlib import Path

import jupytext
import nbformat

ROOT = Path(__file__).parents[1]
LESSONS = ROOT / "lessons"
NOTEBOOKS = ROOT / "notebooks"
BEGIN = re.compile(r"^(?P<indent>\s*)# solution(?:: (?P<placeholder>.+))?$")
END = re.compile(r"^\s*# end solution$")
KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}


def sources():
    """The lessons, by number."""
    return sorted(LESSONS.glob("[0-9][0-9]_*.py"))


def student_lines(lines, where):
    """Lines of a code cell without its solutions."""
    kept, inside = [], False
    for line in lines:
        begin = BEGIN.match(line)
        if begin and inside:
            raise ValueError(f"{where}: a solution begins inside another one; end it with '# end solution'")
        if END.match(line) and not inside:
            raise ValueError(f"{where}: '# end solution' without '# solution'")
        if begin:
            inside = True
            if begin["placeholder"]:
                kept.append(begin["indent"] + begin["placeholder"])
        elif END.match(line):
            inside = False
        elif not inside:
            kept.append(line)
    return kept


def solved_lines(lines):
    """Lines of a code cell without the marks."""
    return [line for line in lines if not BEGIN.match(line) and not END.match(line)]


def notebook(source, *, solved):
    """The notebook of a lesson in one of its forms, without outputs."""
    read = jupytext.read(source, fmt="py:percent")
    cells = []
    for k, cell in enumerate(read.cells):
        tags = cell.metadata.get("tags", [])
        if "solution" in tags and not solved:
            continue
        text = cell.source
        if cell.cell_type == "code":
            lines = text.split("\n")
            text = "\n".join(solved_lines(lines) if solved else student_lines(lines, f"{source.name}, cell {k}")).strip("\n")
        new = nbformat.v4.new_code_cell(text) if cell.cell_type == "code" else nbformat.v4.new_markdown_cell(text)
        new["id"] = f"lesson-{source.name[:2]}-cell-{k:02d}"
        if tags:
            new.metadata["tags"] = list(tags)
        cells.append(new)
    made = nbformat.v4.new_notebook(cells=cells, metadata={"kernelspec": KERNEL, "language_info": {"name": "python"}})
    nbformat.validate(made)
    return made


def text_of(source, *, solved):
    """The file that a lesson becomes."""
    return nbformat.writes(notebook(source, solved=solved), version=4).rstrip("\n") + "\n"


def write(folder, *, solved):
    """Write all lessons; the paths they went to. A notebook whose lesson is gone goes too."""
    folder.mkdir(parents=True, exist_ok=True)
    made = {folder / f"{source.stem}.ipynb": text_of(source, solved=solved) for source in sources()}
    for old in set(folder.glob("[0-9][0-9]_*.ipynb")) - set(made):
        old.unlink()
    for path, text in made.items():
        path.write_text(text, encoding="utf-8", newline="\n")
    return sorted(made)


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Make notebooks of the lessons.")
    parser.add_argument(
        "--solved", type=Path, metavar="FOLDER", help="write the solved form into FOLDER instead of the student form into notebooks/"
    )
    asked = parser.parse_args(arguments)
    for path in write(asked.solved or NOTEBOOKS, solved=asked.solved is not None):
        sys.stdout.write(f"{path}\n")


if __name__ == "__main__":
    main()
