"""One list of requirements: pyproject.toml; everything else repeats it."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import handlab

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]


def name_of(requirement):
    return re.match(r"[A-Za-z0-9._-]+", requirement)[0].lower().replace("_", "-")


def test_the_conda_environment_installs_this_project_with_the_extras_of_its_tests():
    environment = yaml.safe_load((ROOT / "environment.yml").read_text(encoding="utf-8"))
    *conda, pip = environment["dependencies"]
    assert environment["name"] == PROJECT["name"]
    assert conda == [f"python{PROJECT['requires-python']}", "pip"]
    assert len(pip["pip"]) == 1
    extras = re.fullmatch(r"-e \.\[([a-z,]+)\]", pip["pip"][0])[1].split(",")
    assert set(extras) == set(EXTRAS) - {"build", "photo", "points"}  # to rebuild the reference hand, and for pictures of one's own


def test_the_constraints_pin_every_requirement_and_name_no_host():
    text = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    pinned = {name_of(line) for line in text.splitlines() if re.match(r"[a-z0-9._-]+==", line, flags=re.IGNORECASE)}
    wanted = {name_of(one) for one in [*PROJECT["dependencies"], *(one for extra in EXTRAS.values() for one in extra)]}
    assert wanted <= pinned
    assert not re.search(r"https?:|file:|\bindex\b|@ ", text)
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    assert all(re.match(r"[A-Za-z0-9._-]+==[0-9][^ ]*( ;|$)", line) for line in lines)


def test_the_constraints_fit_the_bounds_of_the_project():
    from packaging.requirements import Requirement

    text = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    pins = [
        (name_of(line), re.search(r"==([^ ;]+)", line)[1]) for line in text.splitlines() if "==" in line and not line.startswith((" ", "#"))
    ]
    for one in [*PROJECT["dependencies"], *(one for extra in EXTRAS.values() for one in extra)]:
        requirement = Requirement(one)
        versions = [version for name, version in pins if name == name_of(one)]
        assert versions
        assert all(requirement.specifier.contains(version) for version in versions), one


def test_the_version_is_the_same_everywhere():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert handlab.__version__ == PROJECT["version"] == citation["version"]
    assert f"## {PROJECT['version']}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


@pytest.mark.skipif(sys.platform == "win32", reason="bash")
def test_the_script_of_the_build_machine_is_sound_and_calls_the_tests():
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert subprocess.run(["bash", "-n", script], check=False).returncode == 0
    text = script.read_text(encoding="utf-8")
    assert "set -euo pipefail" in text
    assert "make test" in text


@pytest.mark.skipif(sys.platform == "win32", reason="make")
def test_every_command_of_the_makefile_can_be_planned():
    for target in ("run", "test", "bench", "wheel"):
        done = subprocess.run(["make", "--dry-run", target, "VENV=does-not-exist"], cwd=ROOT, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert "--constraint constraints.txt" in done.stdout
    assert "handlab run" in subprocess.run(["make", "--dry-run", "run"], cwd=ROOT, capture_output=True, text=True, check=True).stdout


def test_linters_run_with_the_tests():
    planned = subprocess.run(["make", "--dry-run", "test"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    order = [planned.index(step) for step in ("ruff check", "/mypy", "lint-imports", "pytest -n 2")]
    assert order == sorted(order)
