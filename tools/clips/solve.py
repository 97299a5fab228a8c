"""Find contractions for the named clips and write ``assets/clips``: ``python -m tools.clips.solve [name ...]``.

First a posture that satisfies the targets and that muscles can hold (bounded least squares on the static balance), then
the simulation from the relaxed posture, which decides: what it settles in is checked against the targets.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares, lsq_linear
from tqdm import tqdm

import handlab as hl
from handlab.simulation.balance import contraction_for, settled
from handlab.simulation.mechanics import mechanics
from handlab.simulation.reach import QUICK, reach, turn_per_contraction
from handlab.simulation.skin import blend
from handlab.studies import measures

from .targets import CLIPS, POSTURES, Posture

FOLDER = Path(__file__).resolve().parents[2] / "assets" / "clips"
SOLVED = Path(__file__).with_name("solved.json")  # contractions of every posture, as found
START = 0.2  # seconds of rest before a clip moves
LET_GO = 0.7  # of a movement's time, in which the hand lets go of one posture before it takes the next
PULP_GAP = 0.0010  # aimed at where pulps meet; -1 to 4 mm is accepted
SLACK = 0.0011  # flesh may enter flesh this much
ROUNDED = 4  # decimals of a contraction
EFFORT = 0.15  # a muscle at full contraction counts like this much of what is wrong
ROUNDS = 30


class Solver:
    """One hand, prepared: limits and stiffness of the moving coordinates."""

    def __init__(self, hand: hl.Hand) -> None:
        self.hand = hand
        self.m = mechanics(hand)
        self.limits = hand.limits[self.m.moving]
        self.names = hand.moving_names

    def angles(self, y: np.ndarray) -> np.ndarray:
        return self.hand.coupling @ y + self.hand.coupling_offset

    def wrong(self, y: np.ndarray, posture: Posture) -> np.ndarray:
        """What is wrong with a posture, each entry about 1 when it matters."""
        angle = self.angles(y)
        degrees = dict(zip(self.names, np.degrees(y), strict=True))
        rest = dict(zip(self.names, np.degrees(self.m.relaxed), strict=True))
        r: list[float] = []
        for name, value in degrees.items():
            low, high = posture.window.get(name, (-180, 180))
            r.append((max(0.0, low + 0.8 - value) + max(0.0, value - high + 0.8)) / 0.5)
            if name in posture.window:
                wish, give = sum(posture.window[name]) / 2, 90.0
            else:
                wish, give = posture.wish.get(name, rest[name]), 60.0 if name in posture.wish else 25.0 if "deviation" in name else 120.0
            r.append((value - wish) / give)
        skin = blend(self.hand, angle)
        for k in posture.meet:
            r.append((measures.pulp_gap(self.hand, skin, 1, k) - PULP_GAP) / 0.0007)
            r.append(max(0.0, np.degrees(measures.facing(self.hand, skin, 1, k)) - 30.0) / 3.0)
            r.append(max(0.0, np.degrees(measures.facing(self.hand, skin, k, 1)) - 40.0) / 4.0)
        for k, bodies in posture.rest_on.items():
            r += [max(0.0, measures.pulp_to_bodies(self.hand, skin, k, (body,)) - 0.002) / 0.0015 for body in bodies]
        for k in posture.near_palm:
            distance = measures.pulp_to_palm(self.hand, skin, k)
            r.append(max(0.0, distance - 0.006) / 0.0010)
        depth = measures.digit_depths(self.hand, skin)
        r += list(np.maximum(0.0, depth - SLACK).ravel() / 0.0003)
        return np.array(r)

    def residual(self, y: np.ndarray, posture: Posture) -> np.ndarray:
        """What is wrong with a posture, and how far its joints would sink under the best contractions."""
        balance = contraction_for(self.hand, self.angles(y))
        drift = np.degrees(balance.unbalanced / self.m.stiffness)  # how far the joint would sink
        return np.concatenate([self.wrong(y, posture), drift / 6.0])

    def posture(self, posture: Posture) -> tuple[np.ndarray, np.ndarray]:
        """Moving coordinates and contractions."""
        margin = np.radians(0.8)
        low, high = self.limits[:, 0] + margin, self.limits[:, 1] - margin
        tries = []
        for other in posture.starts:
            start = self.m.relaxed.copy()
            for i, name in enumerate(self.names):
                if name in {**posture.wish, **other}:
                    start[i] = np.radians({**posture.wish, **other}[name])
                elif name in posture.window:
                    start[i] = np.radians(np.mean(posture.window[name]))
            start = np.clip(start, low + 1e-3, high - 1e-3)
            tries.append(least_squares(self.residual, start, bounds=(low, high), args=(posture,), diff_step=1e-3, max_nfev=40))
        found = min(tries, key=lambda one: one.cost)
        aim = dict(zip(self.names, found.x, strict=True))
        return self.refined(np.array(reach(self.hand, aim).contraction), posture)

    def refined(self, contraction: np.ndarray, posture: Posture) -> tuple[np.ndarray, np.ndarray]:
        """Gauss-Newton on what is wrong with the posture that the contractions really settle in."""
        free = np.ones(len(self.names), dtype=bool)

        def at(c: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
            y = settled(self.hand, c, seconds=4.0, laws=QUICK).angle[self.m.moving]
            r = self.wrong(y, posture)
            return y, r, float(r @ r + EFFORT**2 * c @ c)

        contraction = np.round(np.clip(contraction, 0, 1), ROUNDED)
        y, r, cost = at(contraction)
        step = 0.2
        for _ in range(ROUNDS):
            slope = np.array([(self.wrong(y + 2e-3 * e, posture) - r) / 2e-3 for e in np.eye(len(y))]).T
            turn = turn_per_contraction(self.hand, self.angles(y), contraction, free)
            matrix = np.vstack([slope @ turn, EFFORT * np.eye(len(contraction))])
            goal = np.concatenate([-r, -EFFORT * contraction])
            bounds = np.maximum(-step, -contraction) - 1e-12, np.minimum(step, 1 - contraction) + 1e-12
            tried = np.round(np.clip(contraction + lsq_linear(matrix, goal, bounds=bounds).x, 0, 1), ROUNDED)
            y_tried, r_tried, cost_tried = at(tried)
            if cost_tried < cost:
                contraction, y, r, cost, step = tried, y_tried, r_tried, cost_tried, min(0.3, 1.5 * step)
            else:
                step *= 0.4
                if step < 1e-3:
                    break
        return y, contraction


def write_clip(name: str, solved: dict[str, dict[str, float]], hand: hl.Hand) -> None:
    """Key frames of one clip from the contractions of its postures.

    Between two postures that touch the hand lets go for a moment: all muscles slacken to a share of their contraction.
    """
    title, postures, reach, stay, slack = CLIPS[name]
    time, rows = [0.0, START], [np.zeros(len(hand.muscles)), np.zeros(len(hand.muscles))]
    for posture in postures:
        goal = _row(solved[posture], hand)
        if slack < 1.0 and len(time) > 2:
            time.append(time[-1] + LET_GO * reach)
            rows.append(slack * (rows[-1] + goal) / 2)
        time.append(time[-1] + reach)
        rows.append(goal)
        if stay > 0:
            time.append(time[-1] + stay)
            rows.append(goal)
    values = np.array(rows)
    used = np.flatnonzero(values.max(axis=0) > 0)
    clip = {
        "name": name,
        "title": title,
        "about": "contraction values only; found by tools/clips from targets, checked by simulation",
        "time": [round(t, 3) for t in time],
        "contraction": {hand.muscle_names[i]: [round(float(v), ROUNDED) for v in values[:, i]] for i in used},
    }
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / f"{name}.json").write_text(json.dumps(clip, indent=1) + "\n", encoding="utf-8")


def _row(contraction: dict[str, float], hand: hl.Hand) -> np.ndarray:
    return np.array([contraction.get(name, 0.0) for name in hand.muscle_names])


def main(names: list[str]) -> None:
    """Solve the postures of the named clips (all, if none is named).

    ``--again`` starts from the contractions found last time, ``--write`` only writes the clips.
    """
    hand = hl.load_hand()
    solver = Solver(hand)
    write_only, again = "--write" in names, "--again" in names
    wanted = [name for name in names if not name.startswith("--")] or list(CLIPS)
    solved = json.loads(SOLVED.read_text(encoding="utf-8")) if SOLVED.exists() else {}
    needed = [] if write_only else list(dict.fromkeys(posture for name in wanted for posture in CLIPS[name][1]))
    for posture in tqdm(needed, desc="postures", file=sys.stderr):
        known = solved.get(posture) if again else None
        y, contraction = solver.refined(_row(known, hand), POSTURES[posture]) if known else solver.posture(POSTURES[posture])
        solved[posture] = {name: float(value) for name, value in zip(hand.muscle_names, contraction, strict=True) if value > 0}
        print(posture, report(solver, y, POSTURES[posture]), flush=True)
        SOLVED.write_text(json.dumps(solved, indent=1) + "\n", encoding="utf-8")
    for name in wanted:
        write_clip(name, solved, hand)


def report(solver: Solver, y: np.ndarray, posture: Posture) -> str:
    """What of the targets is missed."""
    hand, angle = solver.hand, solver.angles(y)
    skin = blend(hand, angle)
    missed = [
        f"{n} {np.degrees(v):.1f} not in {posture.window[n]}"
        for n, v in zip(solver.names, y, strict=True)
        if n in posture.window and not posture.window[n][0] <= np.degrees(v) <= posture.window[n][1]
    ]
    gaps = [
        f"gap {k} {measures.pulp_gap(hand, skin, 1, k) * 1000:.1f} mm facing {np.degrees(measures.facing(hand, skin, 1, k)):.0f} and "
        f"{np.degrees(measures.facing(hand, skin, k, 1)):.0f}"
        for k in posture.meet
    ]
    gaps += [
        f"rest {b} {measures.pulp_to_bodies(hand, skin, k, (b,)) * 1000:.1f} mm" for k, bodies in posture.rest_on.items() for b in bodies
    ]
    gaps += [f"palm {k} {measures.pulp_to_palm(hand, skin, k) * 1000:.1f}" for k in posture.near_palm]
    flesh = measures.flesh_depth(hand, skin)
    bone = {pair: round(depth * 1000, 1) for pair, depth in measures.bone_depths(hand, angle).items()}
    where = hand.body_names[hand.skin.weights[flesh.argmax()].argmax()]
    return f"missed {missed} | {gaps} | flesh {flesh.max() * 1000:.1f} mm at {where} | bones {bone}"


if __name__ == "__main__":
    main(sys.argv[1:])
