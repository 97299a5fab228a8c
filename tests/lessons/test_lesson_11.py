"""The checks of "The warp": right answers pass, and every common slip is told for what it is."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

import handlab as hl
from handlab.check import lesson
from handlab.check.misclick import misplaced
from handlab.check.verdict import Outcome
from handlab.fitting.landmarks import NAMES, source_points
from handlab.physics import rbf
from handlab.studies.table_photo import table_photo

RIGHT, WRONG = Outcome.RIGHT, Outcome.WRONG


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="module")
def source(hand):
    return source_points(hand, "palmar", NAMES, "exact")


@pytest.fixture(scope="module")
def bones(hand):
    return np.concatenate([bone.points for bone in hand.bones.values()])


def said(exercise, *answers):
    return lesson("11").verdict(exercise, *answers)


def hint(exercise, *answers):
    """What a wrong answer is told."""
    verdict = said(exercise, *answers)
    assert verdict.outcome is WRONG, verdict
    return verdict.text


def least(made, bones):
    """By finite differences, not by the package's Jacobian."""
    step = 1e-7
    columns = [(made(bones + step * e) - made(bones - step * e)) / (2 * step) for e in np.eye(3)]
    return np.linalg.det(np.stack(columns, axis=2))


def test_any_number_of_points_is_a_guess():
    assert said("guess", 5).outcome is Outcome.NOTED
    assert "one number" in hint("guess", "few")


def system(kind="right"):
    def own(s):
        n = len(s)
        phi = np.sqrt(((s[:, None] - s) ** 2).sum(axis=2))
        p = np.c_[np.ones(n), s]
        late = np.c_[s, np.ones(n)]
        zero = np.zeros((4, 4))
        return {
            "right": np.block([[phi, p], [p.T, zero]]),
            "squared": np.block([[phi**2, p], [p.T, zero]]),
            "late": np.block([[phi, late], [late.T, zero]]),
            "rows": np.hstack([phi, p]),
            "columns": np.vstack([phi, p.T]),
            "alone": phi,
            "other": np.block([[-phi, p], [p.T, zero]]),
            "open": ...,
        }[kind]

    return own


def test_a_system_for_26_points_only_is_told_what_the_check_asks(source):
    for whole in (system()(source), system("alone")(source)):
        assert "asks with 7 points" in hint("system", lambda _, whole=whole: whole)


def test_the_system_passes_and_its_slips_are_told():
    assert said("system", system()).outcome is RIGHT
    assert said("system", system("open")).outcome is Outcome.OPEN
    for kind, word in (
        ("squared", "take the root"),
        ("late", "one stands first"),
        ("rows", "side conditions are missing"),
        ("columns", "affine part is missing"),
        ("alone", "distances alone"),
        ("other", "the package has"),
    ):
        assert word in hint("system", system(kind)), kind


def warp(kind="right"):
    def own(points, source, target):
        made = rbf.fitted(source, target)
        radial = np.linalg.norm(points[:, None] - source, axis=2) @ made.weight
        return {
            "right": RBFInterpolator(source, target, kernel="linear", degree=1)(points),
            "no affine": radial,
            "no shift": radial + points @ made.linear.T,
            "turned": radial + points @ made.linear + made.shift,
            "no sum": points @ made.linear.T + made.shift,
            "other": points,
            "open": ...,
        }[kind]

    return own


def test_what_scipy_computes_is_a_right_warp_and_slips_are_told():
    assert said("warp", warp()).outcome is RIGHT
    assert said("warp", warp("open")).outcome is Outcome.OPEN
    for kind, word in (
        ("no affine", "A x + b is missing"),
        ("no shift", "shift b is missing"),
        ("turned", "transpose"),
        ("no sum", "sum of the distances"),
        ("other", "the package has"),
    ):
        assert word in hint("warp", warp(kind)), kind


def test_an_affine_map_needs_no_weights(source):
    assert np.abs(rbf.fitted(source, 0.7 * source + np.array([0.05, 0, 0])).weight).max() < 1e-12
    assert said("affine", 0).outcome is RIGHT
    assert "without any help" in hint("affine", 0.3)


def test_without_affine_part_bones_move_though_nothing_should(hand, source, bones):
    free = RBFInterpolator(source, source, kernel="linear", degree=-1)(bones)
    moved = 1000 * np.linalg.norm(free - bones, axis=1)
    owner = np.repeat(list(hand.bones), [len(bone.points) for bone in hand.bones.values()])
    bone = owner[moved.argmax()]
    assert 20 < moved.max() < 200
    assert bone in ("radius", "ulna")
    assert said("without", moved.max(), bone).outcome is RIGHT
    assert "give the worst" in hint("without", moved.mean(), bone)
    assert "Leave it off" in hint("without", 0, bone)
    assert "metres" in hint("without", moved.max() / 1000, bone)
    assert "Not that bone" in hint("without", moved.max(), "capitate")


def test_flat_points_lack_one_row_and_go_on_as_a_similarity(source):
    flat = source * [1, 0, 1]
    p = np.c_[np.ones(26), flat]
    full = np.block([[np.linalg.norm(flat[:, None] - flat, axis=2), p], [p.T, np.zeros((4, 4))]])
    assert np.linalg.matrix_rank(full) == 29
    assert said("flat", 29, 14).outcome is RIGHT
    assert "number of rows" in hint("flat", 30, 14)
    assert "matrix_rank" in hint("flat", 4, 14)
    assert "thick bones" in hint("flat", 29, 20)


def jacobian(kind="right"):
    def own(x, made):
        step = 1e-6
        way = x - made.centre
        part = made.weight.T @ (way / np.linalg.norm(way, axis=1)[:, None])
        return {
            "right": made.linear + part,
            "no affine": part,
            "turned": made.linear + part.T,
            "affine": made.linear,
            "no unit": made.linear + made.weight.T @ way,
            "away": made.linear - part,
            "rough": np.stack([(made(x + step * e) - made(x)) / step for e in np.eye(3)], axis=1),
            "open": ...,
        }[kind]

    return own


def test_the_jacobian_passes_and_its_slips_are_told():
    assert said("jacobian", jacobian()).outcome is RIGHT
    assert said("jacobian", jacobian("open")).outcome is Outcome.OPEN
    for kind, word in (
        ("no affine", "A is missing"),
        ("turned", "exchanged"),
        ("affine", "A alone"),
        ("no unit", "divide each by its length"),
        ("away", "not back"),
        ("rough", "the package has"),
    ):
        assert word in hint("jacobian", jacobian(kind)), kind


def test_a_bone_folds_where_two_points_change_their_order(hand, source, bones):
    i = NAMES.index("pip_index")

    def folds(mm):
        target = source.copy()
        target[i, 0] += mm / 1000
        return (least(rbf.fitted(source, target), bones) < 0).any()

    limit = next(mm for mm in range(80) if folds(mm))
    apart = 1000 * np.linalg.norm(source[NAMES.index("dip_index")] - source[i])
    assert 0.5 * apart < limit < 2 * apart
    assert said("fold", limit, "middle_phalanx_2", apart).outcome is RIGHT
    assert "no bone has folded yet" in hint("fold", limit - 5, "middle_phalanx_2", apart)
    assert "folded before" in hint("fold", limit + 5, "middle_phalanx_2", apart)
    assert "metres" in hint("fold", limit / 1000, "middle_phalanx_2", apart)
    assert "not the bone" in hint("fold", limit, "capitate", apart)
    assert "distance is not" in hint("fold", limit, "middle_phalanx_2", 2 * apart)


def test_the_wrong_click_is_the_one_whose_absence_heals_most(source, bones):
    found = {}
    for i, name in enumerate(NAMES):
        found[name] = least(rbf.fitted(np.delete(source, i, axis=0), np.delete(misplaced(), i, axis=0)), bones).min()
    ranked = sorted(found, key=found.get)
    assert found[ranked[-1]] > 0.15 > 0.08 > found[ranked[-2]]
    assert said("repair", ranked[-1], found[ranked[-1]]).outcome is RIGHT
    assert "heals more" in hint("repair", ranked[-2], found[ranked[-1]])
    assert "all points" in hint("repair", ranked[-1], least(rbf.fitted(source, misplaced()), bones).min())
    child = source_points(hl.load_hand("child"), "palmar", NAMES, "exact")
    assert [name for name, off in zip(NAMES, np.abs(child - misplaced()).max(axis=1), strict=True) if off > 0] == [ranked[-1]]


def test_a_softened_warp_spreads_the_blame(source):
    # scipy's kernel is -r: its smoothing is added where ours is taken off
    soft = RBFInterpolator(source, misplaced(), kernel="linear", degree=1, smoothing=0.005)(source)
    missed = 1000 * np.linalg.norm(soft - misplaced(), axis=1)
    i = NAMES.index("dip_ring")
    culprit, others = missed[i], np.delete(missed, i).mean()
    assert culprit > 5 * others > 0.5
    assert said("extend", culprit, others).outcome is RIGHT
    assert "swapped" in hint("extend", others, culprit)
    assert "metres" in hint("extend", culprit / 1000, others)


def test_the_outline_makes_the_overlap_and_is_held_softly():
    picture = table_photo(hl.load_hand("child"), px_per_mm=4.0)
    where = {"view": "palmar", "side": "right", "camera_mm": picture.camera_mm, "centre_px": picture.centre_px}
    alone, both = (
        hl.fit_photo(picture.pixels, landmarks=picture.marks_px, scale=picture.scale, outline=used, **where) for used in (False, True)
    )
    assert alone.iou < 0.95 < 0.98 < both.iou
    travelled = 1000 * np.linalg.norm(both.edge.source - both.edge.target, axis=1).mean()
    missed = 1000 * np.linalg.norm(both.warped.rbf(both.edge.source) - both.edge.target, axis=1).mean()
    assert 0.005 < missed < 0.3
    assert said("outline", alone.iou, both.iou, missed).outcome is RIGHT
    assert "swapped" in hint("outline", both.iou, alone.iou, missed)
    assert "percent" in hint("outline", 100 * alone.iou, both.iou, missed)
    assert "metres" in hint("outline", alone.iou, both.iou, missed / 1000)
    assert "travel" in hint("outline", alone.iou, both.iou, travelled)


def test_short_segments_suffer_most_from_clicks():
    child = source_points(hl.load_hand("child"), "palmar", NAMES, "exact")
    percent = 0.2 / np.linalg.norm(child[NAMES.index("pip_index")] - child[NAMES.index("dip_index")])
    assert said("doubt", percent, "short").outcome is RIGHT
    assert "by 1 mm each" in hint("doubt", percent / 2, "short")
    assert "part of one" in hint("doubt", percent / 100, "short")
    assert "Divide" in hint("doubt", percent, "long")
