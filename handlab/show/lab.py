"""``handlab lab``: the lessons in a folder of the user's own, opened in JupyterLab."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from handlab.anatomy.data import PACKAGE

FOLDER = Path("handlab-lessons")
PATTERN = "[0-9][0-9]_*.ipynb"
ROOT_TOO = "--allow-root"  # without it Jupyter refuses to start for root; it still listens to this computer only, with a key


@dataclass(frozen=True)
class Copied:
    """What happened to the notebooks: ``new`` were copied, ``kept`` were there already and were not touched.

    ``changed`` are those of ``kept`` that differ from the lesson as it comes with the package.
    """

    new: tuple[Path, ...]
    kept: tuple[Path, ...]
    changed: tuple[Path, ...]

    def __str__(self) -> str:
        """One line each."""
        kept = [f"kept  {path}{'  (yours; --fresh puts a new copy beside it)' * (path in self.changed)}" for path in self.kept]
        return "\n".join([*kept, *(f"new   {path}" for path in self.new)])


def lab(*, folder: Path = FOLDER, fresh: bool = False, browser: bool = True, port: int | None = None, start: bool = True) -> int:
    """Copy the lessons into a folder of your own, where nothing of yours is ever overwritten, and open JupyterLab there.

    Parameters
    ----------
    folder
        Where your copies lie; made if it is not there.
    fresh
        Put new copies beside the notebooks that you have changed.
    browser
        Open a browser.
    port
        Of JupyterLab; the first free one from 8888 if not given.
    start
        Start JupyterLab; --no-start only copies.
    """
    sys.stdout.write(f"{copy_lessons(folder, fresh=fresh)}\n")
    sys.stdout.flush()
    if not start:
        return 0
    line = command(folder, browser=browser, port=port)
    if ROOT_TOO in line:
        sys.stdout.write(f"You are root, as in a container: JupyterLab is started with {ROOT_TOO}.\n")
        sys.stdout.flush()
    return open_lab(line)


def notebooks() -> tuple[Path, ...]:
    """The lessons that came with the package (installed wheel) or lie beside it (clone).

    Raises ``FileNotFoundError`` that names both places if neither has any.
    """
    places = (PACKAGE / "notebooks", PACKAGE.parent / "notebooks")
    for place in places:
        found = tuple(sorted(place.glob(PATTERN)))
        if found:
            return found
    raise FileNotFoundError(f"the lessons are missing: neither {places[0]} nor {places[1]} has notebooks; install handlab again")


def copy_lessons(folder: Path, *, fresh: bool = False) -> Copied:
    """Copy the lessons that are not yet in ``folder``. A file that is there is the user's work, and stays as it is.

    ``fresh``: put a new copy beside it under another name (``00_meet_the_hand_fresh.ipynb``, then ``_fresh_2`` ...).
    Raises ``OSError`` for a folder that cannot be written to; a copy is whole or not there.
    """
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{folder} is a file; give the lessons a folder, such as --folder {FOLDER}")
    folder.mkdir(parents=True, exist_ok=True)
    new, kept, changed = [], [], []
    for source in notebooks():
        content = source.read_bytes()
        target = folder / source.name
        if create(target, content):
            new.append(target)
            continue
        kept.append(target)
        if not target.is_file() or target.read_bytes() != content:
            changed.append(target)
            new += [beside(target, content)] if fresh else []
    return Copied(tuple(new), tuple(kept), tuple(changed))


def beside(target: Path, content: bytes) -> Path:
    """Write ``content`` beside ``target`` under the first free name; the name."""
    k = 1
    while True:
        name = target.with_stem(f"{target.stem}_fresh" + (f"_{k}" if k > 1 else ""))
        if create(name, content) or (name.is_file() and name.read_bytes() == content):
            return name
        k += 1


def create(target: Path, content: bytes) -> bool:
    """Write a file that is not there yet; False, and nothing written, if it is (a dangling link counts as there)."""
    try:
        with target.open("xb") as file:
            try:
                file.write(content)
                file.flush()
            except OSError:
                target.unlink(missing_ok=True)
                raise
    except FileExistsError:
        return False
    return True


def command(folder: Path, *, browser: bool = True, port: int | None = None) -> list[str]:
    """The command that opens JupyterLab on a folder, with the Python that runs now.

    Raises ``RuntimeError`` if JupyterLab is not installed.
    """
    if find_spec("jupyterlab") is None:
        raise RuntimeError(
            f"JupyterLab is not installed; install it with: pip install 'handlab[lab]'. The lessons are in {folder}, for any Jupyter"
        )
    options = ["--ServerApp.ip=127.0.0.1", f"--ServerApp.root_dir={folder.resolve()}"]
    options += [] if browser else ["--no-browser"]
    options += [] if port is None else [f"--ServerApp.port={port}"]
    options += [ROOT_TOO] if getattr(os, "geteuid", lambda: 1)() == 0 else []  # Windows has no geteuid
    return [sys.executable, "-m", "jupyterlab", *options]


def open_lab(line: Sequence[str]) -> int:
    """Run JupyterLab until it ends; its exit code. Ctrl-C ends it quietly."""
    process = subprocess.Popen(line)
    while True:
        try:
            return process.wait()
        except KeyboardInterrupt:
            continue  # JupyterLab got it as well and asks what to do
