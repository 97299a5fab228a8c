"""Find contractions for the named clips and write ``assets/clips``: ``python -m tools.clips.solve [name ...]``.

First a posture that satisfies the targets and that muscles can hold (bounded least squares on the static balance), then
the simulation from the relaxed posture, which decides: what it settles in is checked against the targets.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from tqdm import tqdm

import handlab as hl
from handlab.simulation.balance import contraction_for, settled
from handlab.simulation.kinematics import body_transforms
from handlab.simulation.skeleton import mechanics
from handlab.simulation.skin import blend
from handlab.studies import measures

from .targets import CLIPS, POSTURES, Posture

FOLDER = Path(__file__).resolve().parents[2] / "assets" / "clips"
PULP_GAP = 0.0010  # aimed at where pulps meet; -1 to 4 mm is accepted
SLACK = 0.0008  # capsules of neighbouring digits may overlap this much: flesh gives
ROUNDED = 4  # decimals of a contraction


class Solver:
    """One hand, prepared: capsules for the digits, limits and stiffness of the moving coordinates."""

    def __init__(self, hand: hl.Hand) -> None:
        self.hand = hand
        self.m = mechanics(hand)
        self.limits = hand.limits[self.m.moving]
        self.names = hand.moving_names
        self.capsules = _capsules(hand)

    def angles(self, y: np.ndarray) -> np.ndarray:
        return self.hand.coupling @ y + self.hand.coupling_offset

    def residual(self, y: np.ndarray, posture: Posture, near: np.ndarray | None) -> np.ndarray:
        """What is wrong with a posture, each entry about 1 when it matters."""
        angle = self.angles(y)
        degrees = dict(zip(self.names, np.degrees(y), strict=True))
        rest = dict(zip(self.names, np.degrees(self.m.rest_y), strict=True))
        r: list[float] = []
        for name, value in degrees.items():
            low, high = posture.window.get(name, (-180, 180))
            r.append((max(0.0, low + 1.5 - value) + max(0.0, value - high + 1.5)) / 2.0)
            wish = posture.wish.get(name, rest[name] if name not in posture.window else value)
            r.append((value - wish) / (60.0 if name in posture.wish else 120.0 if "deviation" not in name else 25.0))
        skin = blend(self.hand, angle)
        for k in posture.meet:
            r.append((measures.pulp_gap(self.hand, skin, 1, k) - PULP_GAP) / 0.0007)
            r.append(max(0.0, np.degrees(measures.facing(self.hand, skin, 1, k)) - 32.0) / 4.0)
        for k, bodies in posture.rest_on.items():
            r += [(measures.pulp_to_bodies(self.hand, skin, k, (body,)) - 0.0005) / 0.0015 for body in bodies]
        for k in posture.near_palm:
            distance = measures.pulp_to_palm(self.hand, skin, k)
            r.append((max(0.0, distance - 0.006) + max(0.0, -0.0005 - distance)) / 0.0010)
        r += list(np.maximum(0.0, self.overlaps(angle) - SLACK) / 0.0010)
        balance = contraction_for(self.hand, angle)
        drift = np.degrees(balance.unbalanced / self.m.stiffness)  # how far the joint would sink
        r += list(drift / 6.0)
        if near is not None:
            r += list(0.15 * np.degrees(y - near) / 10.0)
        return np.array(r)

    def overlaps(self, angle: np.ndarray) -> np.ndarray:
        """Overlap of the capsules of different digits, metres."""
        transform = body_transforms(self.hand, angle)
        index = {name: i for i, name in enumerate(self.hand.body_names)}
        ends = {name: [transform[index[name]] @ np.append(p, 1.0) for p in (a, b)] for name, (a, b, _) in self.capsules.items()}
        out = []
        for one, other in _pairs(list(self.capsules)):
            distance = _segment_distance(*(e[:3] for e in ends[one]), *(e[:3] for e in ends[other]))
            out.append(self.capsules[one][2] + self.capsules[other][2] - distance)
        return np.array(out)

    def posture(self, posture: Posture) -> tuple[np.ndarray, np.ndarray]:
        """Moving coordinates and contractions."""
        start = self.m.rest_y.copy()
        for i, name in enumerate(self.names):
            if name in posture.wish:
                start[i] = np.radians(posture.wish[name])
            elif name in posture.window:
                start[i] = np.radians(np.mean(posture.window[name]))
        margin = np.radians(0.8)
        low, high = self.limits[:, 0] + margin, self.limits[:, 1] - margin
        found = least_squares(self.residual, np.clip(start, low + 1e-3, high - 1e-3), bounds=(low, high), args=(posture, None), diff_step=1e-4, max_nfev=25)
        aim = found.x
        best: tuple[float, np.ndarray, np.ndarray] | None = None
        target = aim.copy()
        for _ in range(6):  # where it sinks when simulated, aim beyond
            contraction = np.round(contraction_for(self.hand, self.angles(target)).contraction, ROUNDED)
            rest = settled(self.hand, contraction, seconds=4.0)
            y = rest.angle[self.m.moving]
            cost = float((self.residual(y, posture, None)[: -len(y)] ** 2).sum())
            if best is None or cost < best[0]:
                best = cost, y, contraction
            target = np.clip(target + 0.7 * (aim - y), self.limits[:, 0] + 1e-3, self.limits[:, 1] - 1e-3)
        assert best is not None
        return best[1], best[2]


def _capsules(hand: hl.Hand) -> dict[str, tuple[np.ndarray, np.ndarray, float]]:
    """Ends (zero posture) and radius of every phalanx's flesh."""
    bind = body_transforms(hand, hand.bind)
    main, best = hand.skin.weights.argmax(axis=1), hand.skin.weights.max(axis=1)
    result = {}
    for k in range(1, 6):
        chain = ["proximal", "middle", "distal"] if k > 1 else ["proximal", "distal"]
        joints = ["mcp", "pip", "dip"] if k > 1 else ["mcp", "ip"]
        for n, kind in enumerate(chain):
            name = f"{kind}_phalanx_{k}"
            body = hand.body_names.index(name)
            near = hand.joints[f"{joints[n]}{k}"].centre
            mine = hand.skin.points[(main == body) & (best > 0.7)]
            local = (mine - bind[body][:3, 3]) @ bind[body][:3, :3]
            if n + 1 < len(joints):
                far = hand.joints[f"{joints[n + 1]}{k}"].centre
            else:
                axis = local.mean(axis=0) - near
                axis /= np.linalg.norm(axis)
                far = near + axis * ((local - near) @ axis).max()
            axis = (far - near) / np.linalg.norm(far - near)
            side = local - near - np.outer((local - near) @ axis, axis)
            centre = (side.min(axis=0) + side.max(axis=0)) / 2
            radius = float(np.percentile(np.linalg.norm(side - centre, axis=1), 50))
            start = near + axis * (0.45 if kind == "proximal" else 0.1) * np.linalg.norm(far - near)
            end = far - axis * (radius if kind == "distal" else 0.0)
            result[name] = (start + centre, end + centre, radius)
    return result


def _pairs(names: list[str]) -> list[tuple[str, str]]:
    digit = {name: int(name[-1]) for name in names}
    return [(a, b) for i, a in enumerate(names) for b in names[i + 1 :] if digit[a] != digit[b] and (min(digit[a], digit[b]) == 1 or abs(digit[a] - digit[b]) == 1)]


def _segment_distance(p: np.ndarray, q: np.ndarray, r: np.ndarray, s: np.ndarray) -> float:
    """Distance of segments pq and rs, by sampling one and projecting on the other (smooth enough here)."""
    t = np.linspace(0, 1, 9)[:, None]
    points = p + t * (q - p)
    u = np.clip((points - r) @ (s - r) / ((s - r) @ (s - r)), 0, 1)[:, None]
    square = ((points - r - u * (s - r)) ** 2).sum(axis=1)
    return float(np.sqrt(square.min()))


def write_clip(name: str, solved: dict[str, np.ndarray], hand: hl.Hand) -> None:
    """Key frames of one clip from the contractions of its postures."""
    title, postures, reach, stay = CLIPS[name]
    time, rows = [0.0, 0.2], [np.zeros(len(hand.muscles)), np.zeros(len(hand.muscles))]
    for posture in postures:
        time += [time[-1] + reach, time[-1] + reach + stay]
        rows += [solved[posture], solved[posture]]
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


def main(names: list[str]) -> None:
    """Solve the named clips (all, if none is named)."""
    hand = hl.load_hand()
    solver = Solver(hand)
    wanted = names or list(CLIPS)
    needed = list(dict.fromkeys(posture for name in wanted for posture in CLIPS[name][1]))
    solved = {}
    for posture in tqdm(needed, desc="postures", file=sys.stderr):
        y, contraction = solver.posture(POSTURES[posture])
        solved[posture] = contraction
        print(posture, report(solver, y, POSTURES[posture]), flush=True)
    for name in wanted:
        write_clip(name, solved, hand)


def report(solver: Solver, y: np.ndarray, posture: Posture) -> str:
    """What of the targets is missed."""
    hand, angle = solver.hand, solver.angles(y)
    skin = blend(hand, angle)
    missed = [f"{n} {np.degrees(v):.1f} not in {posture.window[n]}" for n, v in zip(solver.names, y, strict=True)
              if n in posture.window and not posture.window[n][0] <= np.degrees(v) <= posture.window[n][1]]  # fmt: skip
    gaps = [f"gap {k} {measures.pulp_gap(hand, skin, 1, k) * 1000:.1f} mm facing {np.degrees(measures.facing(hand, skin, 1, k)):.0f}" for k in posture.meet]
    gaps += [f"rest {b} {measures.pulp_to_bodies(hand, skin, k, (b,)) * 1000:.1f} mm" for k, bodies in posture.rest_on.items() for b in bodies]
    gaps += [f"palm {k} {measures.pulp_to_palm(hand, skin, k) * 1000:.1f}" for k in posture.near_palm]
    flesh = measures.flesh_depth(hand, skin)
    bone = {pair: round(depth * 1000, 1) for pair, depth in measures.bone_depths(hand, angle).items()}
    return f"missed {missed} | {gaps} | flesh {flesh.max() * 1000:.1f} mm at {hand.body_names[hand.skin.weights[flesh.argmax()].argmax()]} | bones {bone}"


if __name__ == "__main__":
    main(sys.argv[1:])
