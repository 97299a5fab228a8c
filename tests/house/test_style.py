"""Rules of the house that no linter knows."""

import ast
import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = sorted((ROOT / "handlab").rglob("*.py"))
SKIPPED = {
    ".git",
    ".venv",
    ".mypy_cache",
    ".ruff_cache",
    ".pytest_cache",
    ".hypothesis",
    ".import_linter_cache",
    "__pycache__",
    "dist",
    "build",
}
TEXT = {".py", ".md", ".toml", ".txt", ".yml", ".cff", ".json", ".csv", ".ipynb", ".js", ".html", ""}
MOST_LINES = 300

# Put together from pieces, so that this file does not contain them.
FORBIDDEN = [
    "/" + "work/",
    "/" + "root/",
    "/" + "home/",
    "/" + "Users/",
    "py" + "pi.org",
    "python" + "hosted.org",
    "ana" + "conda.org",
    "--" + "index-url",
    "--" + "extra-index-url",
]
DRAWING = ("pyvista", "vtk", "vtkmodules", "matplotlib", "imageio", "imageio_ffmpeg", "ipywidgets", "anywidget", "trame", "plotly")


def of_project(path):
    return not SKIPPED & set(path.relative_to(ROOT).parts) and not any(part.endswith(".egg-info") for part in path.parts)


def texts():
    return [path for path in sorted(ROOT.rglob("*")) if path.is_file() and path.suffix in TEXT and of_project(path)]


@pytest.mark.parametrize("path", PACKAGE, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_module_is_short_and_says_what_it_is(path):
    source = path.read_text(encoding="utf-8")
    assert len(source.splitlines()) <= MOST_LINES
    assert ast.get_docstring(ast.parse(source)) or not source.strip()


def test_no_module_is_called_utils():
    assert not [path for path in texts() if re.fullmatch(r"(utils?|helpers?|misc|common)\.py", path.name)]


def test_no_file_holds_a_path_of_one_machine_or_an_address_of_a_registry():
    found = [
        (str(path.relative_to(ROOT)), word)
        for path in texts()
        for word in FORBIDDEN
        if word in path.read_text(encoding="utf-8", errors="ignore")
    ]
    assert not found


def public(tree):
    """Public functions and methods of public classes."""
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public(node)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not node.name.startswith("_"):
            yield node


@pytest.mark.parametrize("path", PACKAGE, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_public_function_says_what_it_does_and_takes(path):
    for function in public(ast.parse(path.read_text(encoding="utf-8"))):
        if any("overload" in ast.unparse(decorator) for decorator in function.decorator_list):
            continue
        assert ast.get_docstring(function), f"{function.name} has no docstring"
        assert function.returns is not None, f"{function.name} does not say what it returns"
        arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
        untyped = [argument.arg for argument in arguments if argument.annotation is None and argument.arg not in ("self", "cls")]
        assert not untyped, f"{function.name}: {untyped} have no type"


@pytest.mark.parametrize("path", [p for p in PACKAGE if not {"show", "cli.py"} & set(p.relative_to(ROOT).parts)], ids=lambda p: p.name)
def test_nothing_below_show_draws_by_a_back_door(path):
    """import-linter reads import statements; this reads the other ways to load a module."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if (
            isinstance(node, ast.Call)
            and ast.unparse(node.func).endswith(("import_module", "__import__", "find_spec"))
            and path.name != "__init__.py"
        ):
            assert not any(isinstance(argument, ast.Constant) and str(argument.value).split(".")[0] in DRAWING for argument in node.args)


def test_notebooks_carry_no_outputs():
    for path in (path for path in texts() if path.suffix == ".ipynb"):
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            assert not cell.get("outputs"), path
            assert cell.get("execution_count") is None, path


def test_no_widget_swallows_its_errors():
    banned = re.compile(r"\binteract(ive|ive_output)?\(")
    assert not [path for path in PACKAGE if banned.search(path.read_text(encoding="utf-8"))]


def test_readme_commands_exist():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z]+):", makefile, flags=re.MULTILINE))
    named = set(re.findall(r"`make ([a-z]+)`|^make ([a-z]+)", readme, flags=re.MULTILINE))
    assert {"run", "test"} <= {one or other for one, other in named} <= targets


def test_links_and_pictures_of_the_documents_exist():
    for path in (path for path in ROOT.glob("*.md")):
        for target in re.findall(r"\]\(([^)#]+)\)", path.read_text(encoding="utf-8")):
            if not target.startswith(("http", "mailto")):
                assert (path.parent / target).exists(), f"{path.name} names {target}"
