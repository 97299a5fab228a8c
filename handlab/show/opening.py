"""Hand a file to the program that the user's desktop opens it with."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from handlab.show.gl import screen


def open_file(path: Path) -> bool:
    """Open ``path`` with the desktop's own program; whether there was one to ask."""
    if sys.platform == "win32":
        os.startfile(path)
        return True
    command = shutil.which("open" if sys.platform == "darwin" else "xdg-open")
    if command is None or not screen() or "CI" in os.environ:
        return False
    nowhere = subprocess.DEVNULL
    subprocess.Popen([command, str(path)], start_new_session=True, stdin=nowhere, stdout=nowhere, stderr=nowhere)
    return True
