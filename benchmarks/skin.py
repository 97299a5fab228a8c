"""The skin against its peers, interleaved in one process: C, numpy, scipy.sparse and MuJoCo on the same mesh; frames and two cores.

``python benchmarks/skin.py`` prints the rows; ``rows()`` gives them to ``run.py``. The C peer is compiled here, if there is a compiler.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

import handlab as hl
from handlab.simulation import soft_skin_kernel as kernel
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.soft_anchors import anchors
from handlab.simulation.soft_frame import first_frame, frame, frames
from handlab.simulation.soft_skin import PAIR_REST, Network, soft_skin

SOURCE = Path(__file__).with_name("skin.c")
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-shared", "-fPIC")
FRAME = 1.0 / 60.0
ROUNDS = 25


def state(network: Network, hand: Any) -> dict[str, Any]:
    """Arguments of ``leapfrog`` for a frame in which a finger bends a little."""
    before = anchors(network, relative_transforms(hand, hand.bind))
    after = anchors(network, relative_transforms(hand, hand.bind + 0.02))
    block, position = np.empty((10, len(network.points))), np.ascontiguousarray(network.points.T)
    kernel.framed(before.centre, after.centre, after.arm, PAIR_REST, block)
    return {
        "position": position,
        "velocity": np.zeros_like(position),
        "force": np.empty_like(position),
        "first": network.first,
        "second": network.second,
        "stiffness": network.stiffness,
        "rest": network.rest,
        "slack": network.slack,
        "anchor": block,
        "hold": network.hold,
        "inverse_mass": network.inverse_mass,
        "dt": FRAME / network.substeps(FRAME),
        "steps": network.substeps(FRAME),
        "damping": network.damping,
    }


def in_c(folder: Path) -> Callable[..., None] | None:
    """The C peer, compiled; None without a compiler."""
    compiler = next((path for path in map(shutil.which, ("cc", "gcc", "clang")) if path), None)
    if compiler is None:
        return None
    library = folder / "skin.so"
    subprocess.run([compiler, *FLAGS, str(SOURCE), "-o", str(library), "-lm"], check=True)
    function = ctypes.CDLL(str(library)).leapfrog
    function.restype = None

    def run(**values: Any) -> None:
        arguments: list[Any] = []
        for value in values.values():
            if isinstance(value, np.ndarray):
                arguments.append(ctypes.c_void_p(value.ctypes.data))
            else:
                arguments.append(ctypes.c_int(value) if isinstance(value, int) else ctypes.c_double(value))
        function(*arguments, ctypes.c_int(values["position"].shape[1]), ctypes.c_int(len(values["first"])))

    return run


def with_numpy(
    position: Any, velocity: Any, force: Any, first: Any, second: Any, stiffness: Any, rest: Any, slack: float, anchor: Any, hold: Any,
    inverse_mass: Any, dt: float, steps: int, damping: float, *, scatter: Any = None,
) -> None:  # fmt: skip
    """The same with numpy: ``np.add.at``, or a sparse ``scatter`` (n, e) of +1 and -1."""
    lost = 0.5 * damping * dt
    kept, gained, dragged = (1 - lost) / (1 + lost), dt / (1 + lost), 2 * lost / (1 + lost) / (dt * steps)
    for step in range(steps):
        offset = position - anchor[:3] - step / steps * anchor[3:6]
        below, above = offset + anchor[6:9], offset - anchor[6:9]
        a = anchor[9] / np.sqrt((below**2).sum(axis=0)) - 1.0
        b = anchor[9] / np.sqrt((above**2).sum(axis=0)) - 1.0
        force[:] = hold * (a * below + b * above)
        way = position[:, second] - position[:, first]
        strain = 1.0 - rest / np.sqrt((way**2).sum(axis=0))
        way *= stiffness * np.where(strain > 0.0, strain, slack * strain)
        if scatter is None:
            for d in range(3):
                np.add.at(force[d], first, way[d])
                np.subtract.at(force[d], second, way[d])
        else:
            force += (scatter @ way.T).T
        velocity[:] = kept * velocity + gained * inverse_mass * force + dragged * anchor[3:6]
        position += dt * velocity


def as_written(
    position: Any, velocity: Any, force: Any, first: Any, second: Any, stiffness: Any, rest: Any, slack: float, anchor: Any, hold: Any,
    inverse_mass: Any, dt: float, steps: int, damping: float,
) -> None:  # fmt: skip
    """The same as one writes it in numpy first: a row per point (n, 3), and ``np.add.at`` of all three axes at once."""
    lost = 0.5 * damping * dt
    kept, gained, dragged = (1 - lost) / (1 + lost), dt / (1 + lost), 2 * lost / (1 + lost) / (dt * steps)
    for step in range(steps):
        offset = position - anchor[:, :3] - step / steps * anchor[:, 3:6]
        below, above = offset + anchor[:, 6:9], offset - anchor[:, 6:9]
        a = anchor[:, 9] / np.linalg.norm(below, axis=1) - 1.0
        b = anchor[:, 9] / np.linalg.norm(above, axis=1) - 1.0
        force[:] = hold[:, None] * (a[:, None] * below + b[:, None] * above)
        way = position[second] - position[first]
        strain = 1.0 - rest / np.linalg.norm(way, axis=1)
        way *= (stiffness * np.where(strain > 0.0, strain, slack * strain))[:, None]
        np.add.at(force, first, way)
        np.subtract.at(force, second, way)
        velocity[:] = kept * velocity + (gained * inverse_mass)[:, None] * force + dragged * anchor[:, 3:6]
        position += dt * velocity


def in_mujoco(network: Network, folder: Path) -> Callable[[int], None] | None:
    """Steps of MuJoCo with the same mesh as an elastic flex sheet, stretching and bending, without contact and gravity; or None."""
    try:
        import mujoco
    except ImportError:
        return None
    points = " ".join(f"{x:.6f}" for x in network.points.ravel())
    faces = " ".join(str(k) for k in network.faces.ravel())
    xml = f"""<mujoco><option timestep="1e-5" gravity="0 0 0" solver="CG"><flag contact="disable"/></option>
    <size memory="200M"/>
    <worldbody><flexcomp name="skin" type="direct" dim="2" radius="0.0005" mass="{network.mass.sum():.6f}"
    point="{points}" element="{faces}">
    <contact selfcollide="none"/><edge equality="false"/>
    <elasticity young="{network.young:g}" poisson="0.33" thickness="0.0015" elastic2d="both"/>
    </flexcomp></worldbody></mujoco>"""
    try:
        model = mujoco.MjModel.from_xml_string(xml)
    except ValueError as problem:
        print(f"MuJoCo takes no such flex: {problem}")
        return None
    data = mujoco.MjData(model)

    def run(steps: int) -> None:
        for _ in range(steps):
            mujoco.mj_step(model, data)

    return run


def interleaved(work: dict[str, Callable[[], Any]], rounds: int) -> dict[str, float]:
    """Least seconds of each, taking turns, so that a busy moment hits all."""
    best = dict.fromkeys(work, np.inf)
    for do in work.values():
        do()
    for _ in range(rounds):
        for name, do in work.items():
            start = time.perf_counter()
            do()
            best[name] = min(best[name], time.perf_counter() - start)
    return best


def rows() -> list[tuple[str, float, float, str, bool, str]]:
    """Rows (what, measured, goal, unit, at most, note) of the table."""
    hand = hl.load_hand()
    network = soft_skin(hand)
    values = state(network, hand)
    steps = values["steps"]

    def fresh(**changes: Any) -> dict[str, Any]:
        copied = {k: v.copy() if k in ("position", "velocity", "force") else v for k, v in values.items()}
        return {**copied, **changes}

    from scipy.sparse import csr_matrix

    count, edges = len(network.points), len(network.first)
    column = np.arange(edges)
    data, row = np.repeat([1.0, -1.0], edges), np.concatenate([network.first, network.second])
    scatter = csr_matrix((data, (row, np.tile(column, 2))), shape=(count, edges))
    with tempfile.TemporaryDirectory() as name:
        c, flex = in_c(Path(name)), in_mujoco(network, Path(name))
        ours, theirs = fresh(), fresh()
        kernel.leapfrog(*ours.values())
        if c is not None:
            c(**theirs)
            assert np.abs(ours["position"] - theirs["position"]).max() < 1e-12, "the C peer computes something else"
        few = 10
        short = {"steps": few, "dt": values["dt"]}
        again = fresh()
        work: dict[str, Callable[[], Any]] = {"ours": lambda: kernel.leapfrog(*again.values())}
        if c is not None:
            other = fresh()
            work["C"] = lambda: c(**other)
        fast = interleaved(work, 6 * ROUNDS)
        first, second, rows_of = fresh(**short), fresh(**short), fresh(**short)
        for name in ("position", "velocity", "force", "anchor"):
            rows_of[name] = np.ascontiguousarray(rows_of[name].T)
        slow: dict[str, Callable[[], Any]] = {
            "add.at": lambda: as_written(*rows_of.values()),
            "numpy": lambda: with_numpy(*first.values()),
            "scipy": lambda: with_numpy(*second.values(), scatter=scatter),
        }
        if flex is not None:
            slow["MuJoCo"] = lambda: flex(few)
        others = interleaved(slow, ROUNDS)
    each = fast["ours"] / steps
    out = []
    if c is not None:
        out.append(
            ("skin substep / the same in C (C's time over ours)", fast["C"] / fast["ours"], 0.90, "x", False, f"{1e6 * each:.1f} us")
        )
    goals = {
        "add.at": ("numpy `add.at` on points (n, 3)", 18.0),
        "numpy": ("numpy `add.at`, axis by axis: its fast path", 1.0),
        "scipy": ("scipy.sparse", 5.0),
        "MuJoCo": ("MuJoCo flex, same mesh", 20.0),
    }
    for key, seconds in others.items():
        out.append(
            (
                f"skin substep, times faster than {goals[key][0]}",
                seconds / few / each,
                goals[key][1],
                "x",
                False,
                f"{1e6 * seconds / few:.0f} us",
            )
        )
    return out + whole(hand, network)


def whole(hand: Any, network: Network) -> list[tuple[str, float, float, str, bool, str]]:
    """The whole frame against its skin substeps, frames a second, and two cores."""
    values = state(network, hand)
    keys = hl.keyframes("fist").for_hand(hand)
    start = first_frame(hand, network)
    count = round(keys.time[-1] / FRAME)  # the clip, whole

    def play() -> None:
        for _ in frames(hand, network, start, keys.at(FRAME * np.arange(count)), FRAME):
            pass

    def one_by_one() -> None:
        now = start
        for values in keys.at(FRAME * np.arange(count)):
            now = frame(hand, network, now, values, FRAME)

    def substeps() -> None:
        position, velocity = values["position"].copy(), values["velocity"].copy()
        for _ in range(count):
            kernel.leapfrog(position, velocity, *list(values.values())[2:])

    def hands(workers: int) -> None:
        with ThreadPoolExecutor(workers) as pool:
            list(pool.map(lambda _: one_by_one(), range(4)))

    # Many rounds: the second core must be free in one of them.
    best = interleaved({"play": play, "one by one": one_by_one, "substeps": substeps}, 40)
    best |= interleaved({"one": lambda: hands(1), "two": lambda: hands(2)}, 6)
    return [
        (
            "whole hand frame / its skin substeps",
            best["play"] / best["substeps"],
            1.15,
            "x",
            True,
            f"{1e3 * best['play'] / count:.2f} ms; the skeleton some frames ahead on the second core",
        ),
        (
            "the same, all on one core",
            best["one by one"] / best["substeps"],
            1.5,
            "x",
            True,
            f"{1e3 * best['one by one'] / count:.2f} ms",
        ),
        (
            "whole hand with skin at 100 kPa, headless",
            count / best["play"],
            500.0,
            "frames/s",
            False,
            f"{network.substeps(FRAME)} substeps",
        ),
        ("four hands on two threads, times faster than on one", best["one"] / best["two"], 1.6, "x", False, ""),
    ]


if __name__ == "__main__":
    for what, value, goal, unit, at_most, note in rows():
        print(f"{what:62} {value:8.3g} {unit:9} goal {'at most' if at_most else 'at least'} {goal:g}   {note}")
    print("load of this machine:", " ".join(f"{one:.1f}" for one in os.getloadavg()))
