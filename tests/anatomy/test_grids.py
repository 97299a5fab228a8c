"""Muscle grids as data: what is refused, and that files give back what was saved."""

import dataclasses
import json

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.grids import MuscleGrid, load_grid, load_grids, save_grids
from handlab.anatomy.terms import UnknownName


@pytest.fixture(scope="module")
def grid():
    return next(grid for grid in load_grids() if grid.name == "abductor_digiti_minimi")


def changed(grid, **changes):
    return dataclasses.replace(grid, **changes)


def test_every_intrinsic_muscle_of_the_hand_has_a_grid():
    driven = {drive for grid in load_grids() for drive in grid.drives}
    intrinsic = {name for name, muscle in hl.load_hand().muscles.items() if muscle.group == "intrinsic"}
    assert driven == intrinsic
    assert len(intrinsic) == 18


def test_the_nine_of_figure_2_are_there():
    names = " ".join(grid.name for grid in load_grids())
    for nine in ("adductor_pollicis", "opponens_pollicis", "dorsal_interosseus_1", "palmar_interosseus_1", "palmar_interosseus_2"):
        assert nine in names
    for nine in ("palmar_interosseus_3", "opponens_digiti_minimi", "flexor_digiti_minimi_brevis", "abductor_digiti_minimi"):
        assert nine in names


def test_every_grid_names_sources_that_exist():
    from handlab.anatomy.data import read_json

    known = read_json("anatomy/sources.json")
    for grid in load_grids():
        assert grid.sources
        assert set(grid.sources) <= set(known)


def test_the_abductor_of_the_little_finger_spans_three_bones_as_in_the_paper(grid):
    bones = {name for row in grid.bones for name in row}
    assert bones == {"pisiform", "metacarpal_5", "proximal_phalanx_5"}


def test_files_give_back_what_was_saved(tmp_path):
    grids = load_grids()
    files = save_grids(tmp_path / "mine", grids)
    assert [file.name for file in files] == [f"{grid.name}.json" for grid in grids]
    for one, other in zip(grids, load_grids(tmp_path / "mine"), strict=True):
        for field in dataclasses.fields(MuscleGrid):
            before, after = getattr(one, field.name), getattr(other, field.name)
            if isinstance(before, np.ndarray):
                np.testing.assert_allclose(after, before, atol=1e-6)
            elif field.name == "bones":
                assert [list(row) for row in before] == [list(row) for row in after]
            else:
                assert before == pytest.approx(after) if field.name == "thickness" else before == after
    again = save_grids(tmp_path / "again", load_grids(tmp_path / "mine"))
    assert [a.read_bytes() for a in again] == [b.read_bytes() for b in files]


def test_two_grids_of_one_name_are_not_saved(grid, tmp_path):
    with pytest.raises(ValueError, match="two muscle grids are called"):
        save_grids(tmp_path / "twice", [grid, grid])
    assert not (tmp_path / "twice").exists()


@pytest.mark.parametrize(
    ("thickness", "words"),
    [((0.0, 0.005), "0 to 5 mm thick"), ((0.006, 0.002), "6 to 2 mm thick"), ((0.002, 2.0), "2000 mm thick"), ((np.nan, 0.005), "thick")],
)
def test_zero_or_absurd_thickness_is_refused(grid, thickness, words):
    with pytest.raises(ValueError, match=words):
        changed(grid, thickness=thickness)


def test_a_grid_of_two_points_is_refused(grid):
    with pytest.raises(ValueError, match="at least two rows of two points"):
        changed(grid, triangle=grid.triangle[:1, :2], barycentric=grid.barycentric[:1, :2])
    with pytest.raises(ValueError, match="at least two rows of two points"):
        changed(grid, triangle=grid.triangle[:, :1], barycentric=grid.barycentric[:, :1])


def test_an_unknown_bone_is_answered_with_the_nearest(grid):
    bones = list(grid.bones)
    bones[2] = "metacarpal_6"
    with pytest.raises(UnknownName, match=r"row 3 .*metacarpal_6.*did you mean metacarpal_"):
        changed(grid, bones=tuple(bones))


@pytest.mark.parametrize("row", [{}, {"hamate": 0.5, "capitate": 0.3, "trapezium": 0.2}, {"hamate": -1.0}, {"hamate": 0.0}])
def test_a_row_hangs_on_one_bone_or_two(grid, row):
    with pytest.raises(ValueError, match="name one or two"):
        changed(grid, bones=(row, *grid.bones[1:]))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"barycentric": np.full((7, 3, 3), 0.4)}, "leaves its triangles"),
        ({"barycentric": np.tile([1.5, -0.5, 0.0], (7, 3, 1))}, "leaves its triangles"),
        ({"barycentric": np.full((7, 2, 3), 1 / 3)}, "barycentric of shape"),
        ({"triangle": np.full((7, 3), -1)}, "below 0"),
        ({"skin_distance": np.array([0.001, 0.002])}, "skin distances"),
        ({"skin_distance": np.array(-0.001)}, "outside 0 to"),
        ({"skin_distance": np.array(3.0)}, "outside 0 to"),
        ({"fullness": np.full(7, 1.2)}, "outside 0 to 1"),
        ({"fullness": np.ones(3)}, "values of fullness"),
        ({"bones": ("hamate",) * 3}, "names bones for 3 rows"),
        ({"drives": ()}, "has no drive"),
        ({"name": "a/b"}, "needs a name"),
        ({"side": "middle"}, "must be 'right' or 'left'"),
    ],
)
def test_bad_grids_are_refused_with_what_to_change(grid, changes, words):
    with pytest.raises(ValueError, match=words):
        changed(grid, **changes)


def test_one_bone_and_one_distance_serve_all_rows(grid):
    one = changed(grid, bones="hamate", skin_distance=np.array(0.002), fullness=None, on_bone=(True, False))
    assert [dict(row) for row in one.bones] == [{"hamate": 1.0}] * 7
    np.testing.assert_array_equal(one.skin_distance, np.full(7, 0.002))
    np.testing.assert_array_equal(one.fullness, [0, 1, 1, 1, 1, 1, 1])


def test_shares_of_two_bones_are_brought_to_one(grid):
    one = changed(grid, bones=({"hamate": 3.0, "pisiform": 1.0}, *grid.bones[1:]))
    assert dict(one.bones[0]) == {"hamate": 0.75, "pisiform": 0.25}


def test_a_grid_lies_on_the_mirrored_hand_where_the_mirror_shows_it(grid):
    right, left = hl.load_hand(), hl.load_hand(side="left")
    seen = grid.points_on(right.skin, right.skin.points, "right") * [1.0, 1.0, -1.0]
    np.testing.assert_allclose(grid.points_on(left.skin, left.skin.points, "left"), seen, atol=1e-12)


def test_a_grid_off_the_skin_is_refused(grid):
    hand = hl.load_hand()
    away = changed(grid, triangle=grid.triangle + len(hand.skin.faces))
    with pytest.raises(ValueError, match="lies off the skin"):
        away.points_on(hand.skin, hand.skin.points, "right")


def test_broken_files_say_which_and_why(grid, tmp_path):
    file = save_grids(tmp_path, [grid])[0]
    row = json.loads(file.read_text(encoding="utf-8"))
    for text, words in (
        ("{", "abductor"),
        ("[]", "no muscle grid"),
        (json.dumps({k: v for k, v in row.items() if k != "bones"}), "'bones'"),
    ):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(ValueError, match=words):
            load_grid(file)
    with pytest.raises(FileNotFoundError, match="no muscle grid"):
        load_grid(tmp_path / "none.json")
    with pytest.raises(FileNotFoundError, match="holds no muscle grids"):
        load_grids(tmp_path / "nowhere")
