"""Checks of lesson 11, "The warp". What is right is computed on a fresh hand, never written down here."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Array
from handlab.check.answers import number, one, reference, said
from handlab.check.lesson import Exercises
from handlab.check.misclick import misplaced
from handlab.check.own_lines import compare, values
from handlab.check.verdict import Wrong
from handlab.fitting.fit import fit_photo
from handlab.fitting.landmarks import NAMES, source_points
from handlab.fitting.result import Fit
from handlab.physics import rbf
from handlab.studies.table_photo import table_photo

EXERCISES = Exercises("11")

DRAGGED, NEXT = "pip_index", "dip_index"
TRIED_MM = 1.0
RELAX = 0.005  # m
CLICK_MM = 1.0
EXACT = 0.005  # part by which a computed answer may be off


@cache
def source() -> Array:
    """Feature points of the reference hand."""
    return source_points(reference(), "palmar", NAMES, "exact")


@cache
def target() -> Array:
    """And of the child's."""
    return source_points(load_hand("child"), "palmar", NAMES, "exact")


@cache
def bones() -> tuple[Array, tuple[str, ...]]:
    """All points of bones (N, 3), and the bone of each."""
    hand = reference()
    names = tuple(name for name, bone in hand.bones.items() for _ in bone.points)
    return np.concatenate([bone.points for bone in hand.bones.values()]), names


def least(warp: rbf.Warp) -> tuple[float, str]:
    """Least determinant in all bones, and the bone."""
    found = np.linalg.det(rbf.jacobian(warp, bones()[0]))
    return float(found.min()), bones()[1][int(found.argmin())]


def matrix(points: Array) -> Array:
    """The system (N + 4, N + 4)."""
    p = np.hstack([np.ones((len(points), 1)), points])
    return np.block([[np.linalg.norm(points[:, None] - points, axis=2), p], [p.T, np.zeros((4, 4))]])


@EXERCISES.register("guess", guess=True)
def guess(points: Any) -> str:
    """Any number of points."""
    number(points, "The guess", "points")
    return "Three give size and place. Every finger that is longer than the others needs points of its own."


@EXERCISES.register("system")
def system(own: Callable[..., Any]) -> str:
    """A function (source) that returns the matrix of the system."""
    for points in (source()[:7], source()):
        n, right = len(points), matrix(points)
        last = np.roll(np.arange(n + 4)[n:], -1)
        order = np.concatenate([np.arange(n), last])
        squared = right.copy()
        squared[:n, :n] **= 2
        slips = {
            "The distances are squared: take the root.": squared,
            "The one stands first in a row of P, then x, y, z.": right[order][:, order],
            "The side conditions are missing: N rows are too few.": right[:n],
            "The affine part is missing: N columns are too few.": right[:, :n],
            "That is the part with the distances alone.": right[:n, :n],
        }
        theirs = values(own, points.copy())
        if n < len(source()) and theirs.shape[:1] in {(len(source()),), (len(source()) + 4,)}:
            raise Wrong(f"The check asks with {n} points. Take the number of points from source, so that any number will do.")
        compare(theirs, right, slips, "The matrix", "")
    return f"{len(source())} points make {len(source()) + 4} rows. Your lines and the package's equation agree to nine digits."


@EXERCISES.register("warp")
def warp(own: Callable[..., Any]) -> str:
    """A function (points, source, target) that returns where the points go."""
    probes = bones()[0][:: len(bones()[0]) // 12]
    for goal in (target(), source() + np.array([0.0, 0.02, 0.0])):
        made = rbf.fitted(source(), goal)
        right = made(probes)
        distance = np.linalg.norm(probes[:, None] - source(), axis=2)
        slips = {
            "The affine part A x + b is missing.": distance @ made.weight,
            "The shift b is missing.": right - made.shift,
            "A is turned over: the last three rows of the solution are its transpose.": distance @ made.weight
            + probes @ made.linear
            + made.shift,
            "The sum of the distances is missing.": probes @ made.linear.T + made.shift,
        }
        theirs = values(own, probes.copy(), source().copy(), goal.copy())
        if theirs.shape == right.shape and np.abs(theirs - right).max() <= 1e-9:  # two ways to solve: the last digits differ
            continue
        compare(theirs, right, slips, "The first point", "m")
    return "Your lines and the package agree to a millionth of a millimetre."


@EXERCISES.register("affine")
def affine(largest: Any) -> str:
    """The largest weight of an affine map."""
    if abs(number(largest, "The largest weight", "times")) > 1e-9:
        raise Wrong("Could A and b do all of it, without any help? What is left for the sum?")
    return "Nothing is left for the sum: the affine part does all that is straight."


@EXERCISES.register("without")
def without(worst: Any, bone: Any) -> str:
    """How far the bones move at most without affine part, where nothing should, and which bone."""
    points, names = bones()
    alone = np.linalg.solve(np.linalg.norm(source()[:, None] - source(), axis=2), source())
    moved = 1e3 * np.linalg.norm(np.linalg.norm(points[:, None] - source(), axis=2) @ alone - points, axis=1)
    right = float(moved.max())
    others = {
        "this is in metres. Give millimetres.": right / 1e3,
        "that is the mean; give the worst.": float(moved.mean()),
        "that is with the affine part. Leave it off.": 0.0,
    }
    said(right, others, worst, "The worst point", "mm", EXACT)
    if one(bone, tuple(reference().bones), "bone") != names[int(moved.argmax())]:
        raise Wrong("Not that bone. Take the owner of the row that moves farthest.")
    return f"{right:.0f} mm in the {names[int(moved.argmax())]}, while all 26 feature points stay exactly where they are."


@EXERCISES.register("flat")
def flat(rank: Any, height: Any) -> str:
    """Rank of the system of flat points, and where the package puts what was 20 mm above."""
    if number(rank, "The rank", "rows") != len(source()) + 3:
        hint = "That is the number of rows; the rank is smaller here." if float(rank) == len(source()) + 4 else "Use np.linalg.matrix_rank."
        raise Wrong(f"The rank is not {rank}. {hint}")
    pressed = source() * np.array([1.0, 0.0, 1.0])
    right = 1e3 * float(rbf.fitted(pressed, 0.7 * pressed)(np.array([[0.08, 0.02, 0.0]]))[0, 1])
    others = {
        "this is in metres. Give millimetres.": right / 1e3,
        "that would leave the thickness as it was: a smaller hand with thick bones.": 20.0,
    }
    said(right, others, height, "The height", "mm", EXACT)
    return f"{right:.0f} mm: one row says nothing new, and the package goes on as a similarity, by the plane's own magnification."


@EXERCISES.register("jacobian")
def jacobian(own: Callable[..., Any]) -> str:
    """A function (x, made) that returns the Jacobian (3, 3)."""
    made = rbf.fitted(source(), target())
    for x in bones()[0][[10, 2000, 6000]]:
        right = rbf.jacobian(made, x)
        slips = {
            "The affine part A is missing.": right - made.linear,
            "Rows and columns are exchanged: w_i is a column, the direction a row.": made.linear + (right - made.linear).T,
            "That is A alone. Undivided ways add up to nothing, by the side conditions: divide each by its length.": made.linear,
            "The direction goes from the feature point to x, not back.": 2.0 * made.linear - right,
        }
        compare(values(own, x.copy(), made), right, slips, "The first number", "")
    return f"Your lines and the package agree to nine digits. Here the determinant is about {np.linalg.det(right):.2f}: a smaller hand."


@EXERCISES.register("fold")
def fold(limit: Any, bone: Any, apart: Any) -> str:
    """The drag at which a bone folds, the bone, and the distance to the next feature point, millimetres."""
    row = NAMES.index(DRAGGED)

    def dragged(mm: float) -> tuple[float, str]:
        goal = source().copy()
        goal[row, 0] += 1e-3 * mm
        return least(rbf.fitted(source(), goal))

    given = number(limit, "The drag", "millimetres")
    if 0.0 < given < 1.0:
        raise Wrong("The drag is in metres. Give millimetres.")
    if dragged(given + TRIED_MM)[0] > 0.0:
        raise Wrong(f"After {given:g} mm no bone has folded yet: the least determinant is {dragged(given)[0]:.2f}.")
    if dragged(given - TRIED_MM)[0] < 0.0:
        raise Wrong(f"Bones have folded before {given:g} mm. Go back until the least determinant is above zero.")
    if one(bone, tuple(reference().bones), "bone") != dragged(given + TRIED_MM)[1]:
        raise Wrong("That is not the bone that folds. panel.least has the worst one first.")
    far = 1e3 * float(np.linalg.norm(source()[NAMES.index(NEXT)] - source()[row]))
    said(far, {"this is in metres. Give millimetres.": far / 1e3}, apart, "The distance", "mm", 0.01)
    return f"Folded at about {given:.0f} mm, with {NEXT} {far:.0f} mm away: a bone folds where two of its points change their order."


@cache
def without_each() -> dict[str, float]:
    """Least determinant without each of the points that were clicked in a hurry."""
    return {name: least(rbf.fitted(np.delete(source(), i, axis=0), np.delete(misplaced(), i, axis=0)))[0] for i, name in enumerate(NAMES)}


@EXERCISES.register("repair")
def repair(name: Any, healed: Any) -> str:
    """The wrong click, and the least determinant without it."""
    found = without_each()
    best = max(found, key=found.__getitem__)
    chosen = one(name, NAMES, "feature point")
    if chosen != best:
        raise Wrong(f"Without {chosen} the least determinant is {found[chosen]:.3f}. There is a point whose absence heals more.")
    said(found[best], {"that is with all points.": least(rbf.fitted(source(), misplaced()))[0]}, healed, "The determinant", "", 0.01)
    return f"Without {best} it is {found[best]:.2f}, and no bone folds. Let the person click {best} once more."


@EXERCISES.register("extend")
def extend(culprit: Any, others: Any) -> str:
    """By how much a softened warp misses the wrong click, and the other points on average, millimetres."""
    n = len(NAMES)
    found = without_each()
    row = NAMES.index(max(found, key=found.__getitem__))

    def misses(sign: float) -> tuple[float, float]:
        soft = matrix(source()) - sign * RELAX * np.diag([1.0] * n + [0.0] * 4)
        solved = np.linalg.solve(soft, np.vstack([misplaced(), np.zeros((4, 3))]))
        missed = 1e3 * np.linalg.norm(matrix(source())[:n] @ solved - misplaced(), axis=1)
        return float(missed[row]), float(np.delete(missed, row).mean())

    for k, (answer, what) in enumerate(((culprit, "The miss of the wrong click"), (others, "The mean miss of the others"))):
        right = misses(1.0)[k]
        slips = {
            "lambda is added there. Take it off.": misses(-1.0)[k],
            "this is in metres. Give millimetres.": right / 1e3,
            "the two are swapped.": misses(1.0)[1 - k],
        }
        said(right, slips, answer, what, "mm", 0.01)
    right, mean = misses(1.0)
    return f"{right:.1f} mm, and {mean:.2f} mm for the innocent. The wrong click is still most of the way where it was clicked."


@cache
def photographed(outline: bool) -> Fit:
    """The child's hand from its picture."""
    picture = table_photo(load_hand("child"), px_per_mm=4.0)
    where: dict[str, Any] = {"view": "palmar", "side": "right", "camera_mm": picture.camera_mm, "centre_px": picture.centre_px}
    return fit_photo(picture.pixels, landmarks=picture.marks_px, scale=picture.scale, outline=outline, **where)


@EXERCISES.register("outline")
def outline(alone: Any, both: Any, missed: Any) -> str:
    """Overlap without and with the outline, and the mean miss of the points that came from it, millimetres."""
    without, fit = photographed(False).iou, photographed(True)
    said(
        without,
        {"this is in percent. Give a part of one.": 100 * without, "the two are swapped.": fit.iou},
        alone,
        "The overlap",
        "",
        0.001,
    )
    said(fit.iou, {"this is in percent. Give a part of one.": 100 * fit.iou}, both, "The overlap with the outline", "", 0.001)
    assert fit.edge is not None
    miss = 1e3 * float(np.linalg.norm(fit.warped.rbf(fit.edge.source) - fit.edge.target, axis=1).mean())
    slips = {
        "this is in metres. Give millimetres.": miss / 1e3,
        "that is how far they travel. Send the points through both.warped.rbf first.": 1e3
        * float(np.linalg.norm(fit.edge.source - fit.edge.target, axis=1).mean()),
    }
    said(miss, slips, missed, "The miss", "mm", 0.01)
    return (
        f"{100 * without:.1f} and {100 * fit.iou:.1f} percent, and {miss:.2f} mm. It fits this picture; how thick it is, no overlap tells."
    )


@EXERCISES.register("doubt")
def doubt(short: Any, suffers: Any) -> str:
    """By how many percent a segment comes out too short, and which segments suffer."""
    between = 1e3 * float(np.linalg.norm(target()[NAMES.index(NEXT)] - target()[NAMES.index(DRAGGED)]))
    right = 100.0 * 2.0 * CLICK_MM / between
    large = 1e3 * float(np.linalg.norm(source()[NAMES.index(NEXT)] - source()[NAMES.index(DRAGGED)]))
    others = {
        "this is a part of one. Give percent.": right / 100.0,
        "both ends are wrong, by 1 mm each.": right / 2.0,
        "that is for the finger of the reference hand; the child's is shorter.": 200.0 * CLICK_MM / large,
    }
    said(right, others, short, "The error", "percent", 0.01)
    if one(suffers, ("long", "short"), "answer") != "short":
        raise Wrong("The error in millimetres is the same for both. Divide.")
    return f"{right:.0f} percent, by two clicks that nobody would call careless."
