"""One step of the skeleton against its peers, in one process, interleaved: rows for ``benchmarks/run.py``."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable

import numpy as np

ROUNDS = 25
SECONDS = 2.0


def best_of(works: dict[str, Callable[[], int]]) -> dict[str, float]:
    """Microseconds per step of each work, which returns how many steps it made; the best round, taken in turns."""
    best = dict.fromkeys(works, np.inf)
    for work in works.values():
        work()
    for _ in range(ROUNDS):
        for name, work in works.items():
            start = time.perf_counter()
            steps = work()
            best[name] = min(best[name], 1e6 * (time.perf_counter() - start) / steps)
    return best


def peers() -> tuple[Callable[[], int], Callable[[], int]]:
    """MuJoCo's step of MyoHand and of our own exported hand without contact, both with some contraction."""
    import mujoco
    import myo_sim

    import handlab as hl

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        myohand = myo_sim.load("myohand_r")
    myohand = myohand[0] if isinstance(myohand, tuple) else myohand
    own = mujoco.MjModel.from_xml_string(hl.to_mjcf(hl.load_hand(), bones=False, skin=False))
    own.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)

    def stepping(model: mujoco.MjModel) -> Callable[[], int]:
        data = mujoco.MjData(model)
        data.ctrl[:] = 0.1

        def work() -> int:
            mujoco.mj_step(model, data, 400)
            return 400

        return work

    return stepping(myohand), stepping(own)


def measured() -> tuple[dict[str, float], dict[str, float]]:
    """Microseconds per step by name, and milliseconds for two seconds of motion."""
    import handlab as hl
    from handlab.simulation.laws import SUBSTEP
    from handlab.simulation.mechanics import mechanics
    from handlab.simulation.skeleton import integrate

    hand = hl.load_hand()
    m, held = mechanics(hand), np.zeros(23, dtype=bool)
    steps = round(SECONDS / SUBSTEP)
    contraction = np.tile(np.random.default_rng(0).uniform(0.0, 0.3, 42), (steps, 1))

    def ours(laws: hl.Laws) -> Callable[[], int]:
        def work() -> int:
            integrate(hand, m.rest_y, np.zeros(23), contraction, SUBSTEP, held, laws)
            return steps

        return work

    works = {
        "coupled": ours(hl.Laws()),
        "tensor": ours(hl.Laws(dynamics="decoupled")),
        "table": ours(hl.Laws(dynamics="decoupled", inertia="table")),
        "nearest table": ours(hl.Laws(dynamics="decoupled", inertia="nearest table")),
    }
    works["MyoHand"], works["own"] = peers()
    per_step = best_of(works)
    return per_step, {name: per_step[name] * steps / 1000.0 for name in ("coupled", "tensor")}
