"""pyvista, ready to draw with or without a screen.

VTK chooses its window class when it is imported, and without a screen the wrong choice ends the process, which no
``except`` can catch. So the choice is made here, before the only ``import pyvista`` of the package.
"""

from __future__ import annotations

import os
import sys
from ctypes import CDLL
from typing import Any

WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"
APT_LINE = "sudo apt-get install libegl1 libgl1-mesa-dri"


class NoDrawing(RuntimeError):  # noqa: N818 (reads as what it is)
    """This machine lacks the system libraries that draw; the message says what to install."""


def pyvista() -> Any:
    """The module ``pyvista``. Raises ``NoDrawing`` where importing it would lead to a crash at the first picture."""
    if "pyvista" not in sys.modules:
        choose_window()
    import pyvista

    return pyvista


def choose_window() -> None:
    """Tell VTK to draw without a screen where there is none; a choice that the user made stays.

    Only Linux needs it: VTK for Windows and macOS draws off screen by itself.
    """
    if not sys.platform.startswith("linux") or WINDOW in os.environ or screen():
        return
    if loads("libEGL.so.1"):
        os.environ[WINDOW] = "vtkEGLRenderWindow"
    elif any(loads(f"libOSMesa.so.{version}") for version in (8, 6)):
        os.environ[WINDOW] = "vtkOSOpenGLRenderWindow"
    else:
        raise NoDrawing(f"this machine has no library to draw with; on Debian or Ubuntu: {APT_LINE} (`handlab doctor` checks again)")


def screen() -> bool:
    """Whether a window could open here."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def loads(library: str) -> bool:
    """Whether the system finds a shared library."""
    try:
        CDLL(library)
    except OSError:
        return False
    return True
