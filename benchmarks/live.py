"""The live hand in a headless Chromium with a software renderer: how soon it is there, how fluent it is, what it costs."""

from __future__ import annotations

import os
import re
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

CHROMIUM = ("/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome")
SOFTWARE_GL = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
SHOWN = "window.handlab && handlab.stats.first_ms > 0"
STARTS = 3
COUNT = """async () => {
  const { stats, hand } = handlab, old = hand.ondraw;
  let drawn = 0;
  hand.ondraw = () => { drawn += 1; old(); };
  const bytes = stats.bytes, frames = stats.frames, start = performance.now();
  await new Promise((go) => setTimeout(go, 4000));
  hand.ondraw = old;
  const seconds = (performance.now() - start) / 1000;
  return { drawn: drawn / seconds, bytes: (stats.bytes - bytes) / (stats.frames - frames) };
}"""


@contextmanager
def started(*command: str, folder: Path | None = None, environment: dict[str, str] | None = None) -> Iterator[tuple[Any, str]]:
    """The process of a command that opens the live hand, and the address that it printed."""
    process = subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True, start_new_session=True)
    assert process.stdout is not None
    try:
        for line in process.stdout:
            found = re.search(r"http://\S+", line)
            if found:
                yield process, found.group(0)
                break
        else:
            raise SystemExit(f"{' '.join(command)} printed no address")
    finally:
        os.killpg(process.pid, signal.SIGINT)
        process.wait(20)


def family(pid: int) -> list[int]:
    """A process and all that it started."""
    parent = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent[int(path.parent.name)] = int(path.read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue  # it has just ended
    found = [pid]
    for one in found:
        found += [child for child, above in parent.items() if above == one]
    return found


def cpu(pids: list[int]) -> float:
    """Seconds of processor time that processes have used."""
    fields = [path.read_text().rpartition(")")[2].split() for path in (Path(f"/proc/{pid}/stat") for pid in pids) if path.exists()]
    return sum(int(one[11]) + int(one[12]) for one in fields) / os.sysconf("SC_CLK_TCK")


def played(page: Any) -> dict[str, float]:
    """Pictures a second and bytes a frame while the fist closes, over and over."""
    page.evaluate("handlab.send({ kind: 'play', clip: 'fist', loop: true })")
    page.wait_for_function("handlab.frame().clip && handlab.frame().time > 0.1")
    page.wait_for_timeout(1500)  # until the browser has compiled what it runs over and over
    counted: dict[str, float] = page.evaluate(COUNT)
    return counted


def drag(page: Any) -> list[float]:
    """Milliseconds from a step of the slider under the mouse to the picture that shows it."""
    page.evaluate("handlab.send({ kind: 'reset' }), handlab.stats.latency_ms.length = 0")
    page.wait_for_timeout(500)
    slider = page.locator("input[data-muscle=FDP2]")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    x, y = box["x"] + 8, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(40):
        page.mouse.move(x + 2 * step, y)
        page.wait_for_timeout(80)
    page.mouse.up()
    page.wait_for_timeout(500)
    latency: list[float] = page.evaluate("handlab.stats.latency_ms")
    return latency


def measured() -> list[tuple[str, float, float, str, bool]]:
    """Rows (what, measured, goal, unit, at most); none where there is no browser."""
    program = next((path for path in CHROMIUM if Path(path).exists()), None)
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        program = None
    if program is None:
        return []
    command = (sys.executable, "-m", "handlab.cli", "run", "--port", "0", "--no-browser")
    commands, pages = [], []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=SOFTWARE_GL)
        for last in [False] * (STARTS - 1) + [True]:
            start = time.perf_counter()
            with started(*command) as (_, address):
                page = browser.new_page(viewport={"width": 1280, "height": 800})
                page.goto(address)
                page.wait_for_function(SHOWN)
                commands.append(time.perf_counter() - start)
                again = browser.new_page(viewport={"width": 1280, "height": 800})
                start = time.perf_counter()
                again.goto(address)
                again.wait_for_function(SHOWN)
                pages.append(time.perf_counter() - start)
                again.close()
                if last:
                    page.wait_for_function("handlab.status().soft")
                    play = played(page)
                    page.evaluate("handlab.set({ skin: 'translucent', muscles: true, tendons: true })")
                    page.wait_for_function("handlab.hand.flesh")
                    flesh = played(page)
                    page.evaluate("handlab.set({ skin: 'solid', muscles: false, tendons: false })")
                    latency = statistics.median(drag(page))
                    page.evaluate("handlab.send({ kind: 'reset' })")
                    page.wait_for_timeout(2000)
                    ours = [pid for pid in family(os.getpid()) if pid != os.getpid()]
                    before = cpu(ours)
                    time.sleep(4.0)
                    idle = 100.0 * (cpu(ours) - before) / 4.0
                page.close()
        browser.close()
    return [
        ("command to live hand (the browser runs already)", statistics.median(commands), 5.0, "s", True),
        ("page to hand", statistics.median(pages), 3.0, "s", True),
        ("slider to new picture, median", latency, 50.0, "ms", True),
        ("pictures while a clip plays, soft skin, software renderer", play["drawn"], 30.0, "frames/s", False),
        ("bytes per frame, soft skin", play["bytes"], 20_000.0, "B", True),
        ("the same translucent, with bones, muscles and tendons", flesh["drawn"], 30.0, "frames/s", False),
        ("bytes per frame with muscles", flesh["bytes"], 20_000.0, "B", True),
        ("idle page: server and browser together", idle, 2.0, "% of a core", True),
    ]


if __name__ == "__main__":
    for what, value, goal, unit, at_most in measured():
        print(f"{what:55} {value:8.3g} {unit}   goal {'at most' if at_most else 'at least'} {goal:g}")
    print("load of this machine:", " ".join(f"{one:.1f}" for one in os.getloadavg()))
