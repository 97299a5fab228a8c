"""Every ratio of the performance goals, each against its peer in the same run: ``make bench``.

Prints a table and writes it to ``benchmarks/results.md``. ``--clone`` also times ``make run`` on a fresh clone, downloads
included. Only ratios carry over to other machines; the absolute goals hold for two cores and a software renderer.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mechanics
import skin as net
import warp
from live import measured, started

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results.md"
MB = 1e6


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    what: str
    measured: float
    goal: float
    unit: str
    at_most: bool
    note: str = ""

    @property
    def ok(self) -> bool:
        """Whether the goal is reached."""
        return self.measured <= self.goal if self.at_most else self.measured >= self.goal


def in_fresh_interpreter(setup: str, timed: str) -> float:
    """Seconds that ``timed`` takes in a new Python."""
    code = f"import time\n{setup}\nt = time.perf_counter()\n{timed}\nprint(time.perf_counter() - t)"
    return float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()[-1])


def imports() -> list[Row]:
    """Interleaved, so that a busy moment hits both."""
    pairs = [(in_fresh_interpreter("", "import handlab"), in_fresh_interpreter("", "import numpy")) for _ in range(15)]
    ours, theirs = (statistics.median(column) for column in zip(*pairs, strict=True))
    loads = [in_fresh_interpreter("import handlab, numpy", "handlab.load_hand()") for _ in range(7)]
    whole = [in_fresh_interpreter("import handlab", "handlab.load_hand()") for _ in range(7)]
    return [
        Row("`import handlab` / `import numpy`", ours / theirs, 1.5, "x", True, f"{1000 * ours:.1f} ms / {1000 * theirs:.1f} ms"),
        Row(
            "`load_hand()`, the first in a process",
            statistics.median(loads),
            0.3,
            "s",
            True,
            f"{statistics.median(whole):.2f} s with numpy's own import",
        ),
    ]


def rate(work: Callable[[], int], seconds: float = 2.0) -> float:
    """Frames per second of ``work``, which returns how many it made; the best of repeated runs."""
    work()
    best, end = 0.0, time.perf_counter() + seconds
    while time.perf_counter() < end:
        start = time.perf_counter()
        frames = work()
        best = max(best, frames / (time.perf_counter() - start))
    return best


def headless() -> list[Row]:
    """Mechanics and blended skin at 60 steps a second, nothing drawn."""
    import handlab as hl

    hand = hl.load_hand()

    def play() -> int:
        clip = hl.simulate(hand, "fist", fps=60)
        return sum(1 for k in range(len(clip)) if clip.skin(k) is not None)

    def mechanics() -> int:
        return len(hl.simulate(hand, "fist", fps=60))

    return [
        Row("skeleton and blended skin, 60 Hz, headless", rate(play), 2000, "frames/s", False),
        Row("of which skeleton alone", rate(mechanics), 2000, "frames/s", False),
    ]


def skeleton() -> list[Row]:
    """One step of the skeleton against MuJoCo's, and scalar tables against tensors."""
    step, motion = mechanics.measured()
    micro = {name: f"{value:.2f} µs" for name, value in step.items()}
    myohand, own, tables = step["MyoHand"] / step["tensor"], step["coupled"] / step["own"], step["tensor"] / step["table"]
    return [
        Row("`mj_step` of MyoHand / decoupled step", myohand, 50, "x", False, f"{micro['MyoHand']} / {micro['tensor']}"),
        Row("coupled step / `mj_step` of our exported hand", own, 1, "x", True, f"{micro['coupled']} / {micro['own']}"),
        Row("2 s of decoupled motion", motion["tensor"], 5, "ms", True),
        Row("2 s of coupled motion", motion["coupled"], 25, "ms", True),
        Row("step with inertia tensors / with tables", tables, 3, "x", True, f"tables {micro['table']}, nearest {micro['nearest table']}"),
    ]


def soft() -> list[Row]:
    """The skin of masses and springs against its peers, and whole frames."""
    return [Row(*row) for row in net.rows()]


def photographed() -> list[Row]:
    """The warp of a hand's points against scipy's and VTK's, and a whole fit from 26 clicks.

    In a process of its own, as a user's is; here, where much else has run, scipy finds its memory warm.
    """
    own = subprocess.run([sys.executable, warp.__file__], capture_output=True, text=True, check=True)
    fresh, later = json.loads(own.stdout), warp.measured()
    ours, here = (f"{median['ours']:.2f} ms; scipy {median['scipy']:.1f}, VTK {median['vtk']:.1f} ms" for median in (fresh, later))
    return [
        Row("warp of 30,000 points, times faster than scipy", fresh["scipy/ours"], 20, "x", False, ours),
        Row("the same after all rows above in one process", later["scipy/ours"], 10, "x", False, here),
        Row("warp of 30,000 points, times faster than VTK", fresh["vtk/ours"], 10, "x", False, ours),
        Row("a hand from 26 clicks", fresh["fit"] / 1e3, 0.5, "s", True),
    ]


def drawn() -> list[Row]:
    """A moving translucent hand on an off-screen canvas, read back as pixels."""
    import handlab as hl
    from handlab.show.moments import story
    from handlab.show.scene import Scene

    hand = hl.load_hand()
    told = story(hl.simulate(hand, "fist", fps=60))
    moments = told.sample(40)
    rows = []
    for skin, goal in (("translucent", 35.0), ("solid", 35.0)):
        with Scene(hand, size=(800, 600), skin=skin) as scene:
            scene.frame([moment.skin for moment in moments])

            def draw(scene: Scene = scene) -> int:
                for moment in moments:
                    scene.pose(moment)
                    scene.picture()
                return len(moments)

            rows.append(Row(f"800 x 600, {skin}, software renderer", rate(draw, 5.0), goal, "frames/s", False))
    return rows


def alive() -> list[Row]:
    """The whole hand with a soft skin and its muscles: simulated alone, then simulated and drawn."""
    import handlab as hl
    from handlab.show.moments import Moment
    from handlab.show.scene import Scene

    hand = hl.load_hand()

    def simulate() -> int:
        return len(hl.simulate(hand, "fist", fps=60, skin="springs and muscles"))

    rows = [Row("mechanics, muscles and soft skin, 60 Hz, headless", rate(simulate, 4.0), 500, "frames/s", False)]
    with Scene(hand, size=(800, 600), skin="translucent", layers=["muscles"]) as scene:
        scene.frame([hand.skin.points])

        def draw(scene: Scene = scene) -> int:
            clip = hl.simulate(hand, "fist", seconds=1.0, fps=60, skin="springs and muscles")
            for k in range(len(clip)):
                scene.pose(Moment(float(clip.time[k]), clip.skin(k), clip.angle[k], clip.contraction[k]))
                scene.picture()
            return len(clip)

        rows.append(Row("800 x 600, translucent, bones, muscles, soft skin simulated", rate(draw, 5.0), 35, "frames/s", False))
    return rows


def sizes() -> list[Row]:
    """What is shipped."""
    assets = sum(path.stat().st_size for path in (ROOT / "assets").rglob("*") if path.is_file()) / MB
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", folder, str(ROOT)]
        subprocess.run(command, check=True)
        wheel = next(Path(folder).glob("*.whl")).stat().st_size / MB
    return [Row("`assets/`", assets, 6, "MB", True), Row("wheel", wheel, 8, "MB", True)]


def fresh_clone() -> list[Row]:
    """``make run`` on a clone without anything, downloads included."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["git", "clone", "--quiet", "--no-hardlinks", str(ROOT), f"{folder}/clone"], check=True)
        environment = {**os.environ, "CI": "1", "PIP_NO_CACHE_DIR": "1", "NUMBA_CACHE_DIR": f"{folder}/numba"}
        start = time.perf_counter()
        with started("make", "run", folder=Path(folder, "clone"), environment=environment) as (_, address):
            scene = address.replace("index.html", "handlab/data/scene")
            with urllib.request.urlopen(scene, timeout=120) as answer:  # the hand itself, not only its page
                hand = len(answer.read())
        spent = time.perf_counter() - start
        if hand < 100_000:
            raise SystemExit("make run served no hand")
    return [Row("bare clone to live hand, downloads included", spent, 120, "s", True)]


def live() -> list[Row]:
    """The live hand in a browser; no rows where there is none."""
    rows = [Row(*row) for row in measured()]
    if not rows:
        print("no Chromium or no playwright: the live hand was not measured")
    return rows


def table(rows: list[Row]) -> str:
    """The rows in Markdown."""
    lines = ["| what | measured | goal | reached |", "|---|---|---|---|"]
    for row in rows:
        sign = "≤" if row.at_most else "≥"
        note = f" ({row.note})" if row.note else ""
        reached = "yes" if row.ok else "**no**"
        lines.append(f"| {row.what} | {row.measured:.3g} {row.unit}{note} | {sign} {row.goal:g} {row.unit} | {reached} |")
    return "\n".join(lines)


def main() -> int:
    """Measure, print, write; 1 if a goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clone", action="store_true", help="also time `make run` on a fresh clone")
    parser.add_argument("--no-write", action="store_true", help="print only")
    chosen = parser.parse_args()
    parts = [imports, skeleton, soft, photographed, headless, drawn, alive, live, sizes, *([fresh_clone] if chosen.clone else [])]
    rows = [row for part in parts for row in part()]
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    text = f"# Measured against the goals\n\n{machine}; no graphics card. Made by `make bench`.\n\n{table(rows)}\n"
    print(text)
    if not chosen.no_write:
        part = RESULTS.with_suffix(".part")
        part.write_text(text, encoding="utf-8")
        shutil.move(part, RESULTS)
    return 0 if all(row.ok for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
