"""An hour of simulated time under random smooth contraction of all muscles, with every promise of the skin checked: ``make soak``.

No number that is not finite, no edge beyond twice its rest length, no inverted triangle in any frame; bones inside the skin within 0.5 mm
every 5 s. Says at the end whether every contraction went from below 0.05 to above 0.95 and every joint came within 10 % of both limits.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import PchipInterpolator

import handlab as hl
from handlab.anatomy.records import Array, Hand
from handlab.physics.distance import closest, winding
from handlab.simulation import skin_kernel
from handlab.simulation.kinematics import posed_bone, relative_transforms
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skin import binding
from handlab.simulation.soft_frame import first_frame, frames
from handlab.simulation.soft_skin import Network, soft_skin

FPS = 60
KNOT = 1.0  # seconds between the random contractions that a smooth line joins
SWING = (0.05, 0.3)  # seconds in which muscles take over from their antagonists in a swing: from as fast as muscles can
HELD = 0.5  # seconds before and after a swing
AGONIST = (0.02, 0.15, 0.5)  # a muscle turns a joint if its lever arm there has this share of its longest one: drawn anew every time
MOST_STRETCH = 2.0
DEEPEST = 0.0005
BONES_EVERY = 5.0  # seconds
CUT = ("radius", "ulna")  # the skin ends before these bones do


def contractions(hand: Hand, seconds: float, seed: int = 0) -> Array:
    """Smooth random contractions (frame, muscle) in [0, 1].

    A quarter of the knots are drawn muscle by muscle. In the others all that turn one joint one way pull together and all that turn it
    back rest, and what does not act there does the same for a second joint: a joint of many comes near its limit only if its
    antagonists are slack and the joints that its muscles cross are turned so that they keep their length. Half of these are swings:
    the other way first, then within ``SWING`` seconds this way, because some limits (flexion of the wrist, extension of the fifth
    metacarpal) are beyond what muscles hold in a steady posture and are reached by momentum.
    """
    rng = np.random.default_rng(seed)
    arm = hand.lever_arm @ hand.coupling
    muscles, joints = arm.shape
    share = np.abs(arm) / np.abs(arm).max(axis=1, keepdims=True)
    time, value = [0.0], [rng.beta(0.5, 0.5, muscles)]

    def knot(after: float, values: Array) -> None:
        time.append(time[-1] + after)
        value.append(values)

    while time[-1] < seconds:
        if rng.random() < 0.25:
            knot(KNOT, rng.beta(0.5, 0.5, muscles))
            continue
        first, second = rng.permutation(joints)[:2]
        sign = np.sign(arm) * (share > rng.choice(AGONIST))
        one, other = sign[:, first] * rng.choice([-1.0, 1.0]), sign[:, second] * rng.choice([-1.0, 1.0])
        pull = np.where(one != 0.0, one, other)
        if rng.random() < 0.5:
            knot(KNOT, np.where(pull < 0.0, 1.0, 0.0))
            knot(HELD, value[-1])
            knot(rng.uniform(*SWING), np.where(pull > 0.0, 1.0, 0.0))
            knot(HELD, value[-1])
        else:
            knot(KNOT, np.where(pull > 0.0, 1.0, 0.0))
            knot(KNOT, value[-1])
    at = np.arange(int(seconds * FPS)) / FPS
    result: Array = np.clip(PchipInterpolator(time, value)(at), 0.0, 1.0)
    return result


@dataclass
class Judge:
    """Checks skins of one hand against what is promised of them."""

    hand: Hand
    network: Network
    normal: Array = field(init=False)

    def __post_init__(self) -> None:
        self.normal = face_normals(self.hand.skin.points, self.hand.skin.faces)

    def stretch(self, points: Array) -> float:
        """Longest edge over its rest length."""
        ends = points[self.network.second.astype(int)] - points[self.network.first.astype(int)]
        return float((np.linalg.norm(ends, axis=1) / self.network.longest).max())

    def inverted(self, points: Array, angle: Array) -> int:
        """Triangles whose normal is more than 90 degrees from their rest normal, carried by the blend rotation of their corners."""
        hand, bound = self.hand, binding(self.hand)
        quaternion = np.empty((len(hand.bodies), 8))
        skin_kernel.dual_quaternions(relative_transforms(hand, angle), quaternion)
        real = quaternion[:, :4]
        lead = real[bound.index[:, :1]]
        sign = np.where((real[bound.index] * lead).sum(axis=2) < 0.0, -1.0, 1.0)
        node = ((sign * bound.weight)[:, :, None] * real[bound.index]).sum(axis=1)
        node /= np.linalg.norm(node, axis=1, keepdims=True)
        corners = node[hand.skin.faces]
        corners *= np.where((corners * corners[:, :1]).sum(axis=2, keepdims=True) < 0.0, -1.0, 1.0)
        turn = corners.sum(axis=1)
        w, v = turn[:, :1], turn[:, 1:]
        carried = self.normal + 2.0 / (turn**2).sum(axis=1, keepdims=True) * np.cross(v, np.cross(v, self.normal) + w * self.normal)
        return int(((face_normals(points, hand.skin.faces) * carried).sum(axis=1) < 0.0).sum())

    def bone_outside(self, points: Array, angle: Array) -> tuple[float, str]:
        """How far bone comes out of the skin, m, and which bone does most."""
        corners = np.ascontiguousarray(points[self.hand.skin.faces])
        worst, which = 0.0, ""
        for name in self.hand.bones:
            if name in CUT:
                continue
            bone = np.ascontiguousarray(posed_bone(self.hand, name, angle))
            out = winding(bone, corners) < 0.5
            if out.any():
                depth = float(closest(np.ascontiguousarray(bone[out]), corners)[0].max())
                worst, which = (depth, name) if depth > worst else (worst, which)
        return worst, which


def face_normals(points: Array, faces: Array) -> Array:
    """Normals (M, 3), as long as twice the triangle is large."""
    result: Array = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    return result


@dataclass
class Tally:
    """What was found: worst stretch, bone and counts of frames that broke a promise."""

    frames: int = 0
    broken: int = 0
    longest: float = 0.0
    inverted: int = 0
    inverted_frames: int = 0
    bone: float = 0.0
    bone_name: str = ""
    bone_checks: int = 0
    bone_faults: int = 0
    low: Array | None = None
    high: Array | None = None

    def lines(self) -> list[str]:
        """The tally in words."""
        return [
            f"{self.frames} frames: {self.broken} not finite, longest edge {self.longest:.2f} times its rest length",
            f"{self.inverted_frames} frames with inverted triangles, at most {self.inverted} of them",
            f"{self.bone_checks} looks at the bones: {self.bone_faults} outside, at most {1e3 * self.bone:.2f} mm {self.bone_name}",
        ]


def soak(hand: Hand, seconds: float, seed: int = 0, bones_every: float = BONES_EVERY, say: bool = False) -> tuple[Tally, list[str]]:
    """Run and check; the tally, and what the motion did not cover."""
    network, drive = soft_skin(hand), contractions(hand, seconds, seed)
    judge, tally = Judge(hand, network), Tally()
    low, high = np.full(len(hand.moving_names), np.inf), np.full(len(hand.moving_names), -np.inf)
    begun, every = time.perf_counter(), max(1, round(bones_every * FPS))
    for k, now in enumerate(frames(hand, network, first_frame(hand, network), drive, 1.0 / FPS)):
        low, high = np.minimum(low, now.y), np.maximum(high, now.y)
        points, angle = np.ascontiguousarray(now.soft.position.T), coupled(hand, now.y)
        tally.frames += 1
        if not np.isfinite(points).all():
            tally.broken += 1
            break
        tally.longest = max(tally.longest, judge.stretch(points))
        inverted = judge.inverted(points, angle)
        tally.inverted, tally.inverted_frames = max(tally.inverted, inverted), tally.inverted_frames + (inverted > 0)
        if k % every == every - 1:
            depth, name = judge.bone_outside(points, angle)
            tally.bone_checks, tally.bone_faults = tally.bone_checks + 1, tally.bone_faults + (depth > DEEPEST)
            if depth > tally.bone:
                tally.bone, tally.bone_name = depth, name
        if say and k % (60 * FPS) == 60 * FPS - 1:
            print(f"{(k + 1) / FPS / 60:.0f} min simulated in {time.perf_counter() - begun:.0f} s:", "; ".join(tally.lines()), flush=True)
    limit = mechanics(hand).limits
    span = limit[:, 1] - limit[:, 0]
    missed = [
        f"{name} kept {100 * a:.0f} % from its lower and {100 * b:.0f} % from its upper limit"
        for name, a, b in zip(hand.moving_names, (low - limit[:, 0]) / span, (limit[:, 1] - high) / span, strict=True)
        if max(a, b) > 0.1
    ]
    narrow = np.flatnonzero((drive.min(axis=0) > 0.05) | (drive.max(axis=0) < 0.95))
    missed += [f"{hand.muscle_names[m]} did not go from 0.05 to 0.95" for m in narrow]
    return tally, missed


def main() -> int:
    """Soak, print, 1 if a promise was broken."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    tally, missed = soak(hl.load_hand(), 60.0 * chosen.minutes, chosen.seed, say=True)
    print(*tally.lines(), *(missed or ["every contraction and every joint covered"]), sep="\n")
    kept = not (tally.broken or tally.inverted_frames or tally.bone_faults) and tally.longest <= MOST_STRETCH and not missed
    print("kept" if kept else "BROKEN")
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
