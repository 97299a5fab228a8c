"""The wheel is small, complete, and works where nothing else is: in an empty folder, with the network off."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from handlab.anatomy.data import folder

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.xdist_group("wheel")

OFFLINE = """
import socket, sys
def refuse(*_):
    raise OSError("the network is off")
socket.socket.connect = socket.create_connection = socket.getaddrinfo = refuse
from handlab.cli import main
main(sys.argv[1:])
"""


def run(*command, **how):
    done = subprocess.run([sys.executable, *map(str, command)], capture_output=True, text=True, check=False, **how)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    place = tmp_path_factory.mktemp("wheel")
    run("-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", place, ROOT)
    (built,) = place.glob("handlab-*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    place = tmp_path_factory.mktemp("installed")
    run("-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", place, wheel)
    return place


def there(installed, empty, *command):
    environment = {**os.environ, "PYTHONPATH": str(installed), "PYTHONNOUSERSITE": "1"}
    return run(*command, cwd=empty, env=environment)


def test_the_wheel_is_below_8_mb_and_the_assets_below_6_mb(wheel):
    assert wheel.stat().st_size < 8e6
    assert sum(path.stat().st_size for path in folder().rglob("*") if path.is_file()) < 6e6


def test_the_wheel_holds_every_asset_module_and_licence(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    assets = {f"handlab/assets/{path.relative_to(ROOT / 'assets').as_posix()}" for path in (ROOT / "assets").rglob("*") if path.is_file()}
    modules = {path.relative_to(ROOT).as_posix() for path in (ROOT / "handlab").rglob("*.py")}
    assert len(assets) > 5
    assert assets | modules | {"handlab/py.typed"} <= names
    for licence in ("LICENSE", "LICENSE-DATA", "LICENSES.md"):
        assert any(name.endswith(f"/{licence}") for name in names), licence
    assert not [name for name in names if name.startswith(("tests", "tools", "docs")) or name.endswith((".nbi", ".nbc", ".pyc"))]


def test_what_is_installed_is_what_runs(installed, tmp_path):
    shown = there(installed, tmp_path, "-c", "import handlab, handlab.anatomy.data as data; print(handlab.__file__); print(data.folder())")
    for line in shown.splitlines():
        assert Path(line).resolve().is_relative_to(installed.resolve())


def test_the_installed_hand_describes_itself_with_the_network_off(installed, tmp_path):
    shown = there(installed, tmp_path, "-c", OFFLINE, "info")
    assert "29 bones" in shown
    assert "newton_per_percent" in shown
    assert not list(tmp_path.iterdir())


def test_the_installed_hand_makes_a_film_with_the_network_off(installed, tmp_path):
    there(installed, tmp_path, "-c", OFFLINE, "render", "fist", "-o", "fist.mp4", "--size", "160x120", "--fps", "5", "--seconds", "0.4")
    assert (tmp_path / "fist.mp4").stat().st_size > 1000
