"""Can this machine draw? One picture, in a process of its own: a crash inside the graphics driver cannot be caught."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import dataclass

from handlab.show.gl import APT_LINE, WINDOW, NoDrawing, choose_window, pyvista

TIMEOUT_S = 60.0
DRAW = "from handlab.show.doctor import draw; draw()"


@dataclass(frozen=True)
class Finding:
    """``ok``, and what was found in one line; ``remedy`` says what to do where it is not ok."""

    ok: bool
    what: str
    remedy: str = ""


def draw() -> None:
    """Draw one picture and say by what; run in a process of its own."""
    import time

    pv = pyvista()
    start = time.perf_counter()
    plotter = pv.Plotter(off_screen=True, window_size=[320, 240])
    plotter.render_window.SetMultiSamples(0)
    plotter.set_background("white")
    plotter.add_mesh(pv.Sphere(), color="red")
    seen = plotter.screenshot(None, return_img=True)
    spent = 1000.0 * (time.perf_counter() - start)
    share = float((seen[..., 2] < 128).mean())
    if not 0.05 < share < 0.9:
        raise SystemExit(f"the picture is wrong: the ball covers {100 * share:.0f} % of it")
    facts = plotter.render_window.ReportCapabilities() or ""
    names = [line.partition(":")[2].strip() for line in facts.splitlines() if line.startswith("OpenGL renderer string")]
    sys.stdout.write(f"{names[0] if names else type(plotter.render_window).__name__}, first picture after {spent:.0f} ms\n")


def check_drawing(timeout: float = TIMEOUT_S, command: str = DRAW) -> Finding:
    """Draw a picture in a subprocess: whether it came out, and if not, what to install."""
    chosen = os.environ.get(WINDOW)
    hint = remedy() + (f" {WINDOW} is {chosen}: try without it." if chosen else "")
    try:
        choose_window()
    except NoDrawing as error:
        return Finding(False, "no picture: the system has neither EGL nor OSMesa", str(error))
    try:
        line = [sys.executable, "-c", command]
        done = subprocess.run(line, capture_output=True, text=True, timeout=timeout, check=False, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        return Finding(False, f"no picture within {timeout:g} s", hint)
    if done.returncode == 0:
        return Finding(True, done.stdout.strip().splitlines()[-1] if done.stdout.strip() else "drawn")
    if done.returncode < 0:
        return Finding(False, f"drawing ended with {signal.Signals(-done.returncode).name}", hint)
    last = (done.stderr.strip() or done.stdout.strip() or "no message").splitlines()[-1]
    return Finding(False, f"no picture: {last}", hint)


def remedy() -> str:
    """What to do on this system when drawing fails."""
    if not sys.platform.startswith("linux"):
        return "update the graphics driver; over remote desktop, start from a local session"
    return f"on Debian or Ubuntu: {APT_LINE}. Everything but pictures and films works without."
