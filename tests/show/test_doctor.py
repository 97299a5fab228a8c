import os
import subprocess
import sys

import pytest

from handlab.show import gl
from handlab.show.doctor import check_drawing

linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux draws through EGL")


def test_a_machine_that_draws_is_found_well():
    found = check_drawing()
    assert found.ok, found
    assert "ms" in found.what


@linux
def test_a_crash_while_drawing_is_survived_and_answered_with_what_to_install():
    found = check_drawing(command="import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
    assert not found.ok
    assert "SIGSEGV" in found.what
    assert "apt-get install libegl1 libgl1-mesa-dri" in found.remedy


def test_a_picture_that_never_comes_is_given_up():
    found = check_drawing(command="import time; time.sleep(30)", timeout=0.5)
    assert not found.ok
    assert "0.5 s" in found.what


def test_an_error_while_drawing_is_repeated():
    found = check_drawing(command="raise SystemExit('the ball is missing')")
    assert not found.ok
    assert "the ball is missing" in found.what


@linux
def test_without_any_library_the_message_says_what_to_install(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", gl.WINDOW):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(gl, "loads", lambda library: False)
    with pytest.raises(gl.NoDrawing, match="libegl1"):
        gl.choose_window()
    assert not check_drawing().ok


@linux
def test_the_window_of_vtk_is_chosen_only_where_there_is_no_screen_and_no_choice(monkeypatch):
    monkeypatch.setattr(gl, "loads", lambda library: "EGL" in library)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    for display, before, after in (
        (None, None, "vtkEGLRenderWindow"),
        (":0", None, None),
        (None, "vtkOSOpenGLRenderWindow", "vtkOSOpenGLRenderWindow"),
    ):
        for name, value in (("DISPLAY", display), (gl.WINDOW, before)):
            if value is None:
                monkeypatch.delenv(name, raising=False)
            else:
                monkeypatch.setenv(name, value)
        gl.choose_window()
        assert os.environ.get(gl.WINDOW) == after


@linux
def test_a_picture_comes_out_without_a_screen():
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", gl.WINDOW)}
    done = subprocess.run(
        [sys.executable, "-c", "from handlab.show.doctor import draw; draw()"], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "bad X server" not in done.stderr
