"""Both forms of every lesson run through nbmake, in an empty folder; the solved one insists that its answers are right."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tools import notebooks

ROOT = Path(__file__).parents[2]
LONGEST = 20.0  # seconds for a lesson on a machine that does nothing else: measured as processor time, for tests run side by side
BUSY = 4.0  # how much slower the clock may be than the processor
LESSONS = notebooks.sources()
# One after the other: the time is measured.
pytestmark = [pytest.mark.xdist_group("notebooks"), pytest.mark.skipif(sys.platform == "win32", reason="Windows has no times of children")]


def nbmake(source, folder, *, solved, strict):
    """(exit code, output, seconds of the processor, seconds of the clock) of a lesson."""
    path = folder / f"{source.stem}.ipynb"
    path.write_text(notebooks.text_of(source, solved=solved), encoding="utf-8")
    environment = {key: value for key, value in os.environ.items() if key != "HANDLAB_STRICT" and not key.startswith("PYTEST")}
    environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), environment.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    environment |= {"HANDLAB_STRICT": "1"} if strict else {}
    command = [sys.executable, "-m", "pytest", "-q", "--nbmake", "--nbmake-timeout=60", "-p", "no:cacheprovider", "-p", "no:xdist"]
    begin, before = time.perf_counter(), used()
    done = subprocess.run(
        [*command, "--rootdir", str(folder), str(path)], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout + done.stderr, used() - before, time.perf_counter() - begin


def used():
    """Processor seconds of all processes that were started here and have ended."""
    times = os.times()
    return times.children_user + times.children_system


@pytest.mark.slow
@pytest.mark.parametrize("source", LESSONS, ids=lambda source: source.stem)
def test_the_solved_form_runs_in_strict_mode_and_in_time(source, tmp_path):
    code, text, processor, clock = nbmake(source, tmp_path, solved=True, strict=True)
    print(f"{source.stem}: {processor:.1f} s of the processor, {clock:.1f} s of the clock")
    assert code == 0, text
    assert 1.0 < processor < LONGEST
    assert clock < BUSY * LONGEST


@pytest.mark.slow
@pytest.mark.parametrize("source", LESSONS, ids=lambda source: source.stem)
def test_the_student_form_runs_though_nothing_is_answered(source, tmp_path):
    code, text, processor, clock = nbmake(source, tmp_path, solved=False, strict=False)
    print(f"{source.stem}: {processor:.1f} s of the processor, {clock:.1f} s of the clock")
    assert code == 0, text
    assert 1.0 < processor < LONGEST
    assert clock < BUSY * LONGEST


@pytest.mark.slow
@pytest.mark.parametrize("source", LESSONS, ids=lambda source: source.stem)
def test_the_student_form_fails_in_strict_mode_because_nothing_is_answered(source, tmp_path):
    code, text, *_ = nbmake(source, tmp_path, solved=False, strict=True)
    assert code == 1
    assert "not answered yet" in text
