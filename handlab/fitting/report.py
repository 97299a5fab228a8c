"""What a fit found: segment lengths beside the reference hand, and how strength goes with size."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import FINGERS
from handlab.simulation.dynamics import mass_matrix
from handlab.simulation.kinematics import body_transforms

if TYPE_CHECKING:
    from handlab.fitting.result import Fit

POWERS = {"length": 1, "force": 2, "torque": 3, "inertia": 5}
_CHAINS = {
    finger: ("cmc1", "mcp1", "ip1", "tip") if k == 1 else (f"cmc{k}", f"mcp{k}", f"pip{k}", f"dip{k}", "tip")
    for k, finger in enumerate(FINGERS, start=1)
}
_NAMES = {
    4: ("metacarpal", "proximal phalanx", "distal phalanx"),
    5: ("metacarpal", "proximal phalanx", "middle phalanx", "distal phalanx"),
}


@dataclass(frozen=True)
class Strength:
    """One law of growth: ``expected`` = L^power, ``found`` in this hand (geometric mean over muscles or joints)."""

    power: int
    expected: float
    found: float


@dataclass(frozen=True, eq=False)
class Report:
    """``lengths_mm``: segment -> (this hand, reference hand), joint centre to joint centre and on to the finger tip.

    ``hand_length_mm`` (this, reference), wrist centre to tip of the middle finger; ``growth`` L; ``laws`` by name;
    ``outline``: whether the outline in the picture shaped the skin too.
    """

    lengths_mm: Mapping[str, tuple[float, float]]
    hand_length_mm: tuple[float, float]
    growth: float
    laws: Mapping[str, Strength]
    mass_kg: tuple[float, float]
    side: str
    view: str
    points: int
    outline: bool
    scale: str
    scatter_mm: float
    warnings: tuple[str, ...]

    def __str__(self) -> str:
        """A table in millimetres."""
        shown = "palm" if self.view == "palmar" else "back"
        lines = [
            f"{shown} of a {self.side} hand, {self.points} points{' and the outline' if self.outline else ''}, {self.scale}",
            f"size L = {self.growth:.3f} of the reference hand; after turning and scaling it, points lie {self.scatter_mm:.1f} mm off",
            "",
            f"{'':<28}{'this hand':>10}{'reference':>11}{'ratio':>8}",
            _line("hand, wrist to middle tip", *self.hand_length_mm),
            *(_line(name, *pair) for name, pair in self.lengths_mm.items()),
            "",
            f"{'strength':<28}{'found':>10}{'expected':>11}   law",
            *(f"{name:<28}{law.found:>10.3f}{law.expected:>11.3f}   L^{law.power}" for name, law in self.laws.items()),
            f"{'mass with forearm stump':<28}{1e3 * self.mass_kg[0]:>8.0f} g{1e3 * self.mass_kg[1]:>9.0f} g",
            *(f"note: {warning}" for warning in self.warnings),
        ]
        return "\n".join(lines)

    __repr__ = __str__


def report(fit: Fit) -> Report:
    """The report of a fit."""
    new, old = segment_lengths_mm(fit.hand), segment_lengths_mm(fit.reference)
    return Report(
        lengths_mm={name: (new[name], old[name]) for name in old},
        hand_length_mm=(_hand_mm(fit.hand), _hand_mm(fit.reference)),
        growth=fit.growth,
        laws=laws(fit.hand, fit.reference, fit.growth),
        mass_kg=(sum(body.mass for body in fit.hand.bodies.values()), sum(body.mass for body in fit.reference.bodies.values())),
        side=fit.side,
        view=fit.view,
        points=len(fit.names),
        outline=fit.edge is not None,
        scale=f"{fit.scale.mm_per_px:.4g} mm per pixel ({fit.scale.how})",
        scatter_mm=fit.aligned.fit.scatter,
        warnings=fit.warnings,
    )


def laws(hand: Hand, reference: Hand, growth: float) -> Mapping[str, Strength]:
    """How length, muscle force, greatest torque and inertia of two hands compare, against L, L^2, L^3, L^5 of a hand of the same shape."""
    force = _mean_ratio(hand.max_force, reference.max_force)
    torque = _mean_ratio(_greatest_torque(hand), _greatest_torque(reference))
    straight = [np.diag(mass_matrix(one, one.zero)) for one in (hand, reference)]
    found = {
        "length": _hand_mm(hand) / _hand_mm(reference),
        "force": force,
        "torque": torque,
        "inertia": _mean_ratio(*straight),
    }
    return {name: Strength(power, growth**power, found[name]) for name, power in POWERS.items()}


def segment_lengths_mm(hand: Hand) -> dict[str, float]:
    """Distances between neighbouring joint centres, the last to the skin of the finger tip, as the hand lies."""
    frames = dict(zip(hand.body_names, body_transforms(hand, hand.bind), strict=True))
    found = {}
    for finger, chain in _CHAINS.items():
        places = [_centre(hand, frames, name, finger) for name in chain]
        for name, a, b in zip(_NAMES[len(chain)], places, places[1:], strict=False):
            found[f"{finger}, {name}"] = 1e3 * float(np.linalg.norm(b - a))
    return found


def _centre(hand: Hand, frames: Mapping[str, Array], name: str, finger: str) -> Array:
    if name == "tip":
        tip: Array = hand.skin.points[hand.feature_points[f"tip_{finger}"]["palmar"]]
        return tip
    joint = hand.joints[name]
    frame = frames[joint.child] if name == "cmc1" else frames[joint.parent]
    result: Array = frame[:3, :3] @ joint.centre + frame[:3, 3]
    return result


def _hand_mm(hand: Hand) -> float:
    return 1e3 * float(np.linalg.norm(hand.skin.points[hand.feature_points["tip_middle"]["palmar"]] - hand.joints["wrist"].centre))


def _greatest_torque(hand: Hand) -> Array:
    """Sum of |lever arm| times force (moving,), N m."""
    result: Array = (np.abs(hand.lever_arm @ hand.coupling) * hand.max_force[:, None]).sum(axis=0)
    return result


def _mean_ratio(one: Array, other: Array) -> float:
    return float(np.exp(np.mean(np.log(np.asarray(one) / np.asarray(other)))))


def _line(name: str, new: float, old: float) -> str:
    return f"{name:<28}{new:>7.1f} mm{old:>8.1f} mm{new / old:>8.3f}"
