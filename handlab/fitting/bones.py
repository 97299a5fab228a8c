"""Bones must stay bones: a warp that turns one inside out or squeezes it flat is found, repaired or refused.

Repaired means: the bone is brought to its new place and length as a whole, with the thickness that the size of the hand asks for.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.fitting.articulation import best_turn
from handlab.physics import rbf

THINNEST = 0.70  # of the thickness that the size of the hand asks for
SLICES = 5  # along a bone: each must be thick enough
# More bones than this folded or thinned are not one bad bone but a bad warp (an assumption).
MOST_REPAIRED = 6
# A bone that is turned against the rest of the hand by more than 60 degrees, or folded over a quarter of its points, is not repaired
# (assumptions). Carpal bones have no long axis to speak of.
MOST_TURNED, MOST_FOLDED = 0.5, 0.25
_SHORT = ("scaphoid", "lunate", "triquetrum", "pisiform", "trapezium", "trapezoid", "capitate", "hamate")


class FoldedWarp(ValueError):  # noqa: N818 (it says what is wrong: the warp has folded)
    """A warp that no bone survives; ``bones`` names those that fold or thin out."""

    def __init__(self, message: str, bones: tuple[str, ...]) -> None:
        super().__init__(message)
        self.bones = bones


@dataclass(frozen=True, eq=False)
class Checked:
    """``points`` of every bone after the warp; least determinant and thickness (over the hand's size) of each bone *before* repair."""

    points: Mapping[str, Array]
    determinant: Mapping[str, float]
    thickness: Mapping[str, float]
    repaired: tuple[str, ...]


def sound_bones(hand: Hand, warp: rbf.Warp, size: float, *, repair: bool = True) -> Checked:
    """Bones of ``hand`` after ``warp``, each whole: no point where the warp folds, no slice thinner than 70 %.

    ``size``: how many times as large the hand is as a whole. Raises ``FoldedWarp`` where a bone fails and is not repaired, where
    more than six do, or where the skin itself is turned inside out over a bone.
    """
    points, determinant, thickness, failed = {}, {}, {}, []
    for name, bone in hand.bones.items():
        points[name] = warp(bone.points)
        determinant[name] = float(np.linalg.det(rbf.jacobian(warp, bone.points)).min()) / size**3
        thickness[name] = thinnest(bone.points, points[name]) / size
        if not (determinant[name] > 0.0 and thickness[name] >= THINNEST):
            failed.append(name)
    if failed and (not repair or len(failed) > MOST_REPAIRED):
        raise FoldedWarp(_reason(failed, determinant, thickness), tuple(failed))
    whole = best_turn(*(np.concatenate(list(p.values())) for p in ({n: b.points for n, b in hand.bones.items()}, points)))
    for name in failed:
        turned = float(_carried_axis(hand.bones[name].points, points[name]) @ whole @ long_axis_way(hand.bones[name].points))
        folded = float(np.mean(np.linalg.det(rbf.jacobian(warp, hand.bones[name].points)) <= 0.0))
        if name not in _SHORT and (turned < MOST_TURNED or folded > MOST_FOLDED):
            raise FoldedWarp(_reason([name], determinant, thickness) if folded else _reversed(name), (name,))
        points[name] = rebuilt(hand.bones[name].points, points[name], size)
        if not abs(thinnest(hand.bones[name].points, points[name]) / size - 1.0) < 1.0 - THINNEST:
            raise FoldedWarp(_reason([name], determinant, thickness), (name,))
    return Checked(points, determinant, thickness, tuple(failed))


def _reversed(name: str) -> str:
    return f"these points would turn {name} back to front; look at the points nearby: one of them is likely misplaced or has another's name"


def _reason(failed: list[str], determinant: Mapping[str, float], thickness: Mapping[str, float]) -> str:
    folded = [name for name in failed if determinant[name] <= 0.0]
    thin = [f"{name} to {100 * thickness[name]:.0f} %" for name in failed if name not in folded]
    parts = [f"fold {_listed(folded)}"] * bool(folded) + [f"thin {_listed(thin)} of its natural thickness"] * bool(thin)
    return f"these points would {' and '.join(parts)}; look at the points nearby: one of them is likely misplaced or has another's name"


def _listed(names: list[str]) -> str:
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


def long_axis(points: Array) -> Array:
    """The direction (3,) in which a bone is longest."""
    axis: Array = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    return axis


def long_axis_way(points: Array) -> Array:
    """``long_axis`` with the sense in which ``_carried_axis`` counts it: from the low to the high end."""
    return _carried_axis(points, points)


def thinnest(before: Array, after: Array) -> float:
    """Least thickness of a bone's slices over what it was: ``before``, ``after`` (N, 3).

    Slices are cut along the bone; the thickness of one is the least spread of its points across the bone.
    """
    axis, new_axis = long_axis_way(before), _carried_axis(before, after)
    along = (before - before.mean(axis=0)) @ axis
    edges = np.quantile(along, np.linspace(0.0, 1.0, SLICES + 1))
    ratios = []
    for low, high in pairwise(edges):
        mine = (along >= low) & (along <= high)
        ratios.append(_narrow(after[mine], new_axis) / _narrow(before[mine], axis))
    return float(min(ratios))


def _carried_axis(before: Array, after: Array) -> Array:
    """Where the long axis goes: through the middles of both ends."""
    along = (before - before.mean(axis=0)) @ long_axis(before)
    low, high = np.quantile(along, [0.2, 0.8])
    way = after[along >= high].mean(axis=0) - after[along <= low].mean(axis=0)
    result: Array = way / np.linalg.norm(way)
    return result


def _narrow(points: Array, axis: Array) -> float:
    across = points - points.mean(axis=0)
    across = across - np.outer(across @ axis, axis)
    return float(np.sqrt(max(np.linalg.eigvalsh(across.T @ across / len(across))[1], 0.0)))


def rebuilt(before: Array, after: Array, size: float) -> Array:
    """The bone ``before`` (N, 3) laid where ``after`` is: turned as a whole, as long as ``after``, ``size`` times as thick."""
    axis, new_axis = long_axis_way(before), _carried_axis(before, after)
    a, b = before - before.mean(axis=0), after - after.mean(axis=0)
    # turn: the axis exactly, the rest as well as it goes
    side_a, side_b = a - np.outer(a @ axis, axis), b - np.outer(b @ new_axis, new_axis)
    left, _, right = np.linalg.svd(side_b.T @ side_a + 1e3 * len(a) * np.var(a) * np.outer(new_axis, axis))
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    along = a @ axis
    stretch = float((b @ new_axis) @ along / (along @ along))
    result: Array = after.mean(axis=0) + (size * side_a + stretch * np.outer(along, axis)) @ turn.T
    return result
