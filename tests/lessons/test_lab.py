"""``handlab lab`` brings the lessons and never touches what a student wrote."""

import errno
import hashlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from handlab.cli import answer
from handlab.show import lab


def content(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())}


def test_the_lessons_are_copied_byte_by_byte(tmp_path):
    copied = lab.copy_lessons(tmp_path / "new" / "folder")
    assert copied.new
    assert not copied.kept
    for path, source in zip(copied.new, lab.notebooks(), strict=True):
        assert path.read_bytes() == source.read_bytes()


def test_work_is_never_overwritten_however_often_the_command_runs(tmp_path):
    first = lab.copy_lessons(tmp_path)
    for path in first.new:
        path.write_text("my work")
    (tmp_path / "notes.txt").write_text("mine")
    before = content(tmp_path)
    for _ in range(3):
        again = lab.copy_lessons(tmp_path)
        assert not again.new
        assert again.changed == again.kept == first.new
    assert content(tmp_path) == before
    assert "yours" in str(again)


def test_a_fresh_copy_stands_beside_the_work_and_is_made_once(tmp_path):
    work = lab.copy_lessons(tmp_path).new[0]
    assert not lab.copy_lessons(tmp_path, fresh=True).new, "a notebook that nobody changed needs no second copy"
    work.write_text("my work")
    (fresh,) = lab.copy_lessons(tmp_path, fresh=True).new
    assert fresh.read_bytes() == lab.notebooks()[0].read_bytes()
    assert lab.copy_lessons(tmp_path, fresh=True).new == (fresh,)
    fresh.write_text("my second work")
    (second,) = lab.copy_lessons(tmp_path, fresh=True).new
    assert second.name.endswith("_fresh_2.ipynb")
    assert (work.read_text(), fresh.read_text()) == ("my work", "my second work")


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_a_link_to_nowhere_is_not_followed(tmp_path):
    name = lab.notebooks()[0].name
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / name).symlink_to(tmp_path / "elsewhere.ipynb")
    assert (tmp_path / "here" / name) in lab.copy_lessons(tmp_path / "here").kept
    assert not (tmp_path / "elsewhere.ipynb").exists()


def test_a_full_disk_leaves_no_half_notebook(tmp_path, monkeypatch):
    class Full:
        def __enter__(self):
            return self

        def __exit__(self, *_):
            self.file.close()

        def write(self, data):
            self.file.write(data[:100])
            raise OSError(errno.ENOSPC, "No space left on device")

    open_really = Path.open

    def open_full(path, mode="r", *arguments, **how):
        if mode != "xb":
            return open_really(path, mode, *arguments, **how)
        full = Full()
        full.file = open_really(path, mode)
        return full

    monkeypatch.setattr(Path, "open", open_full)
    with pytest.raises(OSError, match="No space left"):
        lab.copy_lessons(tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_command_copies_and_says_what_it_did(tmp_path, capsys):
    assert answer(["lab", "--no-start", "--folder", str(tmp_path / "mine")]) == 0
    assert "new   " in capsys.readouterr().out
    assert answer(["lab", "--no-start", "--folder", str(tmp_path / "mine")]) == 0
    assert "kept  " in capsys.readouterr().out


def test_a_file_in_place_of_the_folder_is_told_in_one_sentence(tmp_path, capsys):
    (tmp_path / "taken").write_text("mine")
    assert answer(["lab", "--no-start", "--folder", str(tmp_path / "taken")]) == 2
    assert "give the lessons a folder" in capsys.readouterr().err
    assert (tmp_path / "taken").read_text() == "mine"


def test_a_missing_jupyterlab_is_told_in_one_sentence_after_the_lessons_are_there(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(lab, "find_spec", lambda name: None)
    assert answer(["lab", "--folder", str(tmp_path / "mine")]) == 2
    assert "pip install 'handlab[lab]'" in capsys.readouterr().err
    assert list((tmp_path / "mine").iterdir())


def test_missing_lessons_are_told_with_both_places(tmp_path, monkeypatch):
    monkeypatch.setattr(lab, "PACKAGE", tmp_path / "handlab")
    with pytest.raises(FileNotFoundError, match="neither"):
        lab.notebooks()


def test_jupyterlab_opens_on_the_folder_of_this_computer_only(tmp_path):
    pytest.importorskip("jupyterlab")
    line = lab.command(tmp_path, browser=False, port=8899)
    assert line[:3] == [sys.executable, "-m", "jupyterlab"]
    assert "--ServerApp.ip=127.0.0.1" in line
    assert f"--ServerApp.root_dir={tmp_path.resolve()}" in line
    assert {"--no-browser", "--ServerApp.port=8899"} <= set(line)
    assert not [word for word in line if "token" in word], "Jupyter makes a random key; nothing here weakens it"


@pytest.mark.parametrize(("user", "root"), [(0, True), (1000, False), (None, False)])
def test_root_is_let_in_and_told_so_and_nobody_else(tmp_path, monkeypatch, capsys, user, root):
    pytest.importorskip("jupyterlab")
    if user is None:  # Windows
        monkeypatch.delattr(os, "geteuid", raising=False)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: user, raising=False)
    started = []
    monkeypatch.setattr(lab, "open_lab", lambda line: started.extend(line) or 0)
    assert lab.lab(folder=tmp_path / "mine", browser=False) == 0
    assert ("--allow-root" in started) is root
    told = [line for line in capsys.readouterr().out.splitlines() if "root" in line and "mine" not in line]
    assert len(told) == root


def test_the_exit_code_of_jupyterlab_is_passed_on():
    assert lab.open_lab([sys.executable, "-c", "raise SystemExit(3)"]) == 3


def test_the_lessons_are_found_beside_an_installed_package(tmp_path):
    """As in a wheel: the notebooks lie inside the package."""
    package = tmp_path / "handlab"
    (package / "notebooks").mkdir(parents=True)
    (package / "notebooks" / "00_x.ipynb").write_text("{}")
    script = f"from pathlib import Path; from handlab.show import lab; lab.PACKAGE = Path({str(package)!r}); print(lab.notebooks()[0])"
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
    )
    assert done.stdout.strip() == str(package / "notebooks" / "00_x.ipynb")


@pytest.mark.slow
@pytest.mark.xdist_group("wheel")
def test_an_installed_wheel_brings_the_lessons(tmp_path):
    root = Path(__file__).parents[2]
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    build = ["wheel", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", str(tmp_path), str(root)]
    subprocess.run([*pip, *build], check=True, capture_output=True)
    (wheel,) = tmp_path.glob("handlab-*.whl")
    installed = tmp_path / "installed"
    subprocess.run([*pip, "install", "--no-deps", "--no-index", "--target", str(installed), str(wheel)], check=True, capture_output=True)
    command = [sys.executable, "-m", "handlab.cli", "lab", "--no-start", "--folder", "mine"]
    environment = {**os.environ, "PYTHONPATH": str(installed), "PYTHONNOUSERSITE": "1"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    copied = {path.name: path.read_bytes() for path in (tmp_path / "mine").iterdir()}
    assert copied == {path.name: path.read_bytes() for path in lab.notebooks()}
