"""Painting a muscle: what a click means, what is refused and how, and that nothing clicked is ever lost."""

import asyncio
import base64
import dataclasses
import json
import re
import threading
import time

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.grids import load_grid, load_grids
from handlab.anatomy.meshes import Mesh
from handlab.anatomy.terms import UnknownName
from handlab.show.outfits import SOFT
from handlab.show.paint_panel import PaintPanel
from handlab.show.paint_room import PaintRoom, warm_up
from handlab.show.painting import influenced_by
from handlab.show.session import Session
from handlab.simulation.geometric_muscle import ellipsoids, geometric_muscles, muscles_of
from handlab.simulation.grid_rows import on_skin
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.muscle_below import DEEP, hits, influenced
from handlab.simulation.muscle_fit import checked_skin
from handlab.simulation.painted import with_painted
from handlab.simulation.soft_skin import soft_skin

SHIPPED = next(grid for grid in load_grids() if grid.name == "flexor_pollicis_brevis")
BONES = ("trapezium", "metacarpal_1", "proximal_phalanx_1")


@pytest.fixture(scope="module")
def rows(hand):
    """Three rows of two points of the shipped short flexor."""
    return SHIPPED.points_on(hand.skin, hand.skin.points, hand.side)[::3][:, ::2]


@pytest.fixture
def panel(hand):
    return PaintPanel(hand, "painted", "FPB", columns=2)


@pytest.fixture
def painted(panel, rows):
    panel.add(rows)
    return panel


def blue_and_green(picture):
    red, green, blue = (picture[..., k].astype(int) for k in range(3))
    return np.count_nonzero((blue > 110) & (red < 60) & (blue > green + 25)), np.count_nonzero((green > red + 35) & (green > blue + 5))


# What a page sends.


def test_points_of_a_page_are_rows_from_origin_to_insertion(panel, rows):
    reply = panel.room.ask({"kind": "paint", "points": rows.reshape(-1, 3).tolist()})
    assert np.linalg.norm(panel.painting.rows - rows, axis=2).max() < 1e-6
    assert panel.grid.drives == ("flexor_pollicis_brevis",)
    assert (reply["good"], reply["rows"], reply["missing"], reply["muscle"]) == (True, 3, 0, True)
    assert len(json.dumps(reply, allow_nan=False)) < 60_000, "bytes of an answer"


def test_lines_of_the_grid_lie_on_the_skin_and_pass_through_every_point(hand, painted, rows):
    told = painted.room.told()
    lines = [np.reshape(line, (-1, 3)) / 1e3 for line in told["lines"]]
    assert len(lines) == 5 + 2, "five rows once each is divided by two, two columns"
    place = on_skin(hand, np.concatenate(lines))
    assert np.linalg.norm(place - np.concatenate(lines), axis=1).max() < 2e-5
    ends = np.concatenate([line[[0, -1]] for line in lines])
    for corner in (rows[0, 0], rows[0, 1], rows[-1, 0], rows[-1, 1]):
        assert np.linalg.norm(ends - corner, axis=1).min() < 3e-5
    outward = np.concatenate([np.reshape(way, (-1, 3)) for way in told["outward"]])
    np.testing.assert_allclose(np.linalg.norm(outward, axis=1), 1.0, atol=0.15)
    assert (outward[:, 1] > 0.0).mean() > 0.9, "this muscle is painted on the palm"


def test_the_surface_travels_once_for_a_fit_and_its_segments_with_every_contraction(painted):
    first = painted.room.ask({"kind": "paint"})
    again = painted.room.ask({"kind": "paint", "have": first["fit"], "contraction": 1.0})
    assert "layers" in first
    assert "layers" not in again
    assert again["fit"] == first["fit"]
    before, after = (np.frombuffer(base64.b64decode(told["segments"]), dtype="<i2").reshape(-1, 10).astype(int) for told in (first, again))
    middle = slice(len(before) // 4, -len(before) // 4)
    assert np.all(after[:, 7].sum() < before[:, 7].sum()), "shorter along the fibres"
    assert after[middle, 9].mean() > 1.03 * before[middle, 9].mean(), "and thicker"
    assert painted.room.ask({"kind": "paint", "have": first["fit"], "settings": {"finer": 3}})["fit"] > first["fit"]


# What comes of it.


def test_a_muscle_appears_in_under_a_second_with_its_grid_in_blue_and_its_points_in_green(hand, rows):
    panel = PaintPanel(hand, "painted", "FPB", columns=2, skin="mesh")
    panel.add(rows)
    warm_up(hand)
    moved = rows.reshape(-1, 3).copy()
    moved[2] += [0.001, 0.0, 0.0]
    begin, used = time.perf_counter(), time.process_time()
    reply = panel.room.ask({"kind": "paint", "points": on_skin(hand, moved).tolist()})
    print(f"fit and reply: {time.perf_counter() - begin:.3f} s of the clock")
    assert time.process_time() - used < 0.5
    assert reply["muscle"]
    empty = PaintPanel(hand, "nothing", "FPB", skin="mesh").picture()
    picture = panel.picture()
    lines, dots = blue_and_green(picture)
    assert lines > 300
    assert dots > 150
    assert max(blue_and_green(empty)) < 20
    panel.clear()
    assert max(blue_and_green(panel.picture())) < 20


def test_influenced_points_are_those_of_the_whole_hand_s_rule(hand, painted):
    result = painted.painting.result
    np.testing.assert_array_equal(np.sort(result.influenced), np.sort(influenced(hand, result.muscle, "painted")))
    assert 5 < len(result.influenced) < 60


def test_bone_hides_a_deep_muscle_from_the_skin_behind_it(hand):
    deep = [muscles_of(hand, [grid]) for grid in load_grids() if grid.name in ("palmar_interosseus_2", "adductor_pollicis_oblique")]
    hidden = 0
    for muscle in deep:
        found = influenced_by(hand, muscle)
        np.testing.assert_array_equal(np.sort(found), np.sort(influenced(hand, muscle, muscle.names[0])))
        reached = hits(muscle.rest, hand.skin.points, -checked_skin(hand))[0] < DEEP
        hidden += np.count_nonzero(reached) - len(found)
    assert hidden > 5


def test_rows_between_two_bones_follow_both_and_ends_are_fixed(painted):
    bones = painted.grid.bones
    painted.set(bones=BONES)
    assert [dict(row) for row in painted.grid.bones] == [
        {"trapezium": 1.0},
        {"trapezium": 0.5, "metacarpal_1": 0.5},
        {"metacarpal_1": 1.0},
        {"metacarpal_1": 0.5, "proximal_phalanx_1": 0.5},
        {"proximal_phalanx_1": 1.0},
    ]
    assert len(bones) == 5
    assert painted.grid.on_bone == (True, True)


def test_the_painted_muscle_swells_in_the_picture(painted):
    still = painted.picture().astype(int)
    painted.set(contraction=1.0)
    assert np.abs(painted.picture().astype(int) - still).max() > 30


def test_it_is_saved_as_data_loaded_and_used(hand, painted, tmp_path):
    file = painted.save(tmp_path / "muscles")
    (loaded,) = load_grids(file.parent)
    np.testing.assert_array_equal(loaded.triangle, painted.grid.triangle)
    np.testing.assert_allclose(loaded.barycentric, painted.grid.barycentric, atol=2e-5)
    with pytest.raises(FileExistsError, match="another name"):
        painted.save(file.parent)
    painted.save(file.parent, overwrite=True)
    everything = painted.painting.with_others()
    assert everything.names[-1] == "painted"
    assert len(everything.names) == len(geometric_muscles(hand).names) + 1
    network = soft_skin(hand, muscles=everything)
    assert network.muscles is everything
    painted.set(name="flexor_pollicis_brevis")
    assert sorted(painted.painting.with_others().names) == sorted(geometric_muscles(hand).names), "it takes the place of its namesake"


def test_it_follows_the_bones_that_it_rides_on(hand, painted):
    painted.set(bones=BONES)
    muscle = painted.painting.result.muscle
    angle = hand.bind.copy()
    angle[hand.dof_names.index("mcp1.flexion_extension")] += 0.5
    from handlab.studies.fibre_arm import fibre_path

    before, after = (fibre_path(hand, muscle, "painted", at) for at in (hand.bind, angle))
    np.testing.assert_allclose(after[:, :3], before[:, :3], atol=1e-12)
    body = relative_transforms(hand, angle)[hand.body_names.index("proximal_phalanx_1")]
    np.testing.assert_allclose(after[:, -1], before[:, -1] @ body[:3, :3].T + body[:3, 3], atol=1e-12)
    assert ellipsoids(hand, angle).centre.shape[1] == 3


# What is refused.


@pytest.mark.parametrize(
    ("change", "kind", "word"),
    [
        ({"thickness_mm": (0, 5)}, ValueError, "0 < least"),
        ({"thickness_mm": (2, 500)}, ValueError, "0 < least"),
        ({"thickness_mm": (float("nan"), 5)}, ValueError, "0 < least"),
        ({"thickness_mm": (5, 2)}, ValueError, "0 < least"),
        ({"skin_distance_mm": -1}, ValueError, "skin distance"),
        ({"skin_distance_mm": (2, 900)}, ValueError, "skin distance"),
        ({"bones": ("trapezum", None, None)}, UnknownName, "trapezium"),
        ({"bones": (None, {"trapezium": 1, "capitate": 1, "hamate": 1}, None)}, ValueError, "one or two"),
        ({"drive": "FPQ"}, UnknownName, "flexor_pollicis_brevis"),
        ({"columns": 1}, ValueError, "2 to 8"),
        ({"finer": 0}, ValueError, "1 .as painted. to 6"),
        ({"name": "my muscle!"}, ValueError, "letters"),
        ({"thicknes_mm": (1, 2)}, UnknownName, "thickness_mm"),
        ({"skin": "glass"}, UnknownName, "translucent"),
        ({"view": "top"}, UnknownName, "palm"),
        ({"contraction": 1.4}, ValueError, "0 and 1"),
    ],
)
def test_a_bad_setting_is_refused_with_its_name_and_nothing_changes(painted, change, kind, word):
    before = (painted.painting.settings, painted.painting.result, painted.room.contraction, painted.room.skin)
    with pytest.raises(kind, match=word):
        painted.set(**change)
    assert (painted.painting.settings, painted.painting.result, painted.room.contraction, painted.room.skin) == before


def test_a_grid_of_two_points_is_no_muscle_yet(panel, rows):
    panel.add(rows[0])
    assert panel.problem is None
    assert "2 more clicks" in panel.text()
    with pytest.raises(ValueError, match=r"2 points are painted\. Click 2 more"):
        _ = panel.grid
    with pytest.raises(ValueError, match="no muscle yet"):
        panel.save("nowhere")


def test_a_grid_before_any_click_is_told_in_one_line_of_a_notebook(panel, rows):
    shells = pytest.importorskip("IPython.core.interactiveshell")
    shell = shells.InteractiveShell.instance()
    told = []
    shell._showtraceback = lambda kind, error, lines: told.append(lines)
    shell.user_ns["own_panel"] = panel
    try:
        shell.run_cell("mine = own_panel.grid")
        panel.add([rows[1], rows[0], rows[2]])
        shell.run_cell("mine = own_panel.grid")
    finally:
        del shell._showtraceback
        shells.InteractiveShell.clear_instance()
    (none,), (crossed,) = told
    assert none.startswith("There is no muscle yet: no points are painted. Click 4 more on the skin")
    assert "crosses itself" in crossed


def test_a_grid_that_crosses_itself_is_told_kept_and_can_be_mended(panel, rows):
    panel.add([rows[1], rows[0], rows[2]])
    assert "crosses itself" in panel.problem
    assert len(panel.painting.points) == 6
    assert "nothing is lost" in panel.text()
    with pytest.raises(ValueError, match="crosses itself"):
        _ = panel.grid
    for k in range(2):
        panel.painting.move(k, rows[0, k])
        panel.painting.move(2 + k, rows[1, k])
    assert panel.problem is None
    assert panel.grid.triangle.shape == (5, 2)


def test_a_grid_over_the_cut_of_the_forearm_is_told(hand, panel):
    low = hand.skin.points[:, 0].min()
    end = hand.skin.points[hand.skin.points[:, 0] < low + 1e-4]
    middle = end.mean(axis=0)
    square = middle + 0.008 * np.array([[[0, -1, -1], [0, -1, 1]], [[0, 1, -1], [0, 1, 1]]])
    panel.add(square)
    assert "cut of the forearm" in panel.problem


def test_points_off_the_skin_are_refused_and_none_is_added(painted, rows):
    for bad, word in ((rows + np.array([0, 0.05, 0]), "off the skin"), (rows * np.nan, "finite"), ([[1, 2]], "finite")):
        with pytest.raises(ValueError, match=word):
            painted.add(bad)
    assert len(painted.painting.points) == 6
    with pytest.raises(ValueError, match="no point 9"):
        painted.painting.move(9, rows[0, 0])


@pytest.mark.parametrize("kind", ["open", "doubled"])
def test_a_hand_whose_skin_is_no_closed_surface_is_refused(hand, kind):
    faces = hand.skin.faces[1:] if kind == "open" else np.concatenate([hand.skin.faces, hand.skin.faces[:1]])
    broken = (
        hand.with_(skin=dataclasses.replace(hand.skin, faces=faces))
        if dataclasses.is_dataclass(hand.skin)
        else Mesh(hand.skin.points, faces)
    )
    with pytest.raises(ValueError, match="open" if kind == "open" else "manifold"):
        PaintPanel(broken, "painted", "FPB")


# What is never lost.


def test_undo_takes_back_one_change_at_a_time_and_clear_can_be_undone(painted, rows):
    painted.clear()
    assert len(painted.painting.points) == 0
    painted.undo()
    assert len(painted.painting.points) == 6
    painted.painting.move(0, rows[0, 0] + [0.001, 0, 0])
    painted.undo()
    assert np.linalg.norm(painted.painting.points[0] - rows[0, 0]) < 1e-6
    for _ in range(5):
        painted.undo()
    assert len(painted.painting.points) == 0


def test_a_dragged_point_is_one_change_and_what_a_page_takes_back_is_taken_back(painted, rows):
    send = lambda points, **how: painted.room.ask({"kind": "paint", "points": points.tolist(), **how})  # noqa: E731
    start = painted.painting.points.copy()
    for k in range(1, 6):
        moved = start.copy()
        moved[0] += [2e-4 * k, 0.0, 0.0]
        send(on_skin(painted.hand, moved), passing=k < 5)
    painted.undo()
    np.testing.assert_array_equal(painted.painting.points, start)
    send(on_skin(painted.hand, moved))
    send(start, back=True)
    painted.undo()
    assert len(painted.painting.points) == 0, "the drag is gone; the next thing to take back is the grid itself"


class Page:
    """A page of a panel without a browser: ``told`` is what code changed."""

    def __init__(self, panel):
        pytest.importorskip("anywidget")
        self.panel, self.got, self.count = panel, [], 0
        panel.page.widget.send = lambda content, buffers=None: self.got.append(content)

    def send(self, **message):
        self.count += 1
        self.panel.page.hear(None, {"page": "p", "id": self.count, "of": 1, "message": message}, [])
        return self.count


def test_messages_of_other_threads_while_the_kernel_is_busy_are_all_heeded_in_order(hand, rows):
    flat = rows.reshape(-1, 3)

    async def session():
        panel = PaintPanel(hand, "painted", "FPB", columns=2)
        page = Page(panel)
        send = lambda: [page.send(kind="paint", points=flat[: k + 1].tolist()) for k in range(6)]  # noqa: E731
        other = threading.Thread(target=send)
        other.start()
        time.sleep(0.2)  # the kernel is busy with a cell
        other.join()
        assert len(panel.painting.points) == 0
        await asyncio.sleep(0.1)
        return panel, page

    panel, page = asyncio.run(session())
    assert np.linalg.norm(panel.painting.points - flat, axis=1).max() < 1e-6
    assert [one["id"] for one in page.got] == [1, 2, 3, 4, 5, 6]
    assert page.got[-1]["reply"]["muscle"]


def test_what_code_changes_shows_in_the_page(painted):
    page = Page(painted)
    painted.set(finer=3, view="back")
    (told,) = (one["told"] for one in page.got if one.get("kind") == "changed")
    assert told["settings"]["finer"] == 3
    assert told["view"] == "back"
    assert np.shape(told["points"]) == (6, 3)


BAD = {
    "thickness_mm": ([0, 6], "0 < least"),
    "skin_distance_mm": ([2, None], "skin distance"),
    "bones": (["trapezum", None, None], "trapezium"),
    "drive": ("FPQ", "flexor_pollicis_brevis"),
    "columns": (1, "2 to 8"),
    "finer": (0, "1 .as painted. to 6"),
    "name": ("no name!", "letters"),
    "on_bone": (None, "."),
    "thicknes": (3, "thickness_mm"),
}


def test_of_many_settings_the_wrong_ones_are_told_by_name_the_right_ones_count_and_no_point_is_lost(painted, rows):
    for name, (value, word) in BAD.items():
        reply = painted.room.ask(
            {"kind": "paint", "points": rows.reshape(-1, 3)[:4].tolist(), "settings": {name: value, "finer": 3} | {name: value}}
        )
        assert reply["good"], name
        assert list(reply["troubles"]) == [name]
        assert re.search(word, reply["troubles"][name], re.IGNORECASE), reply["troubles"]
        assert "Traceback" not in reply["troubles"][name]
        assert len(painted.painting.points) == 4
        assert name == "finer" or painted.painting.settings.finer == 3
        painted.undo()
        painted.set(finer=2)
    for empty in ([], [None, 6], None):  # fields that were emptied
        assert "two numbers" in painted.room.ask({"kind": "paint", "settings": {"thickness_mm": empty}})["troubles"]["thickness_mm"]


def test_points_that_make_no_grid_are_told_in_plain_words_and_the_last_ones_stay(hand, painted, rows):
    cases = {
        "off the skin": (rows + np.array([0.0, 0.05, 0.0])).reshape(-1, 3).tolist(),
        "finite": [[None, 0, 0]],
        "at most": [[0.0, 0.0, 0.0]] * 900,
        "convert": "all of them",
    }
    for word, points in cases.items():
        reply = painted.room.ask({"kind": "paint", "points": points})
        assert not reply["good"]
        assert word in reply["text"], reply["text"]
        assert len(painted.painting.points) == 6
    for message in ({"kind": "clack"}, {}, [], None, {"kind": "paint", "have": "x"}):
        assert painted.room.ask(message)["good"] is False
    assert painted.room.ask({"kind": "paint", "contraction": 7})["troubles"]["contraction"]
    crossed = painted.room.ask({"kind": "paint", "points": [*rows[1].tolist(), *rows[0].tolist(), *rows[2].tolist()]})
    assert crossed["good"]
    assert "crosses itself" in crossed["problem"]
    assert crossed["lines"]
    for kind in ("save", "use"):
        assert "crosses itself" in painted.room.ask({"kind": kind})["text"]


def test_the_save_button_writes_and_says_where(panel, rows, tmp_path):
    ask = lambda one: one.room.ask({"kind": "save", "folder": str(tmp_path)})  # noqa: E731
    assert "4 more clicks" in ask(panel)["text"]
    panel.add(rows)
    for _ in range(2):  # its own file may be written again
        assert "Saved as" in ask(panel)["said"]
    other = PaintPanel(panel.hand, "painted", "FPB", columns=2)
    other.add(rows)
    assert "exists" in ask(other)["text"]
    assert load_grids(tmp_path)[0].name == "painted"


def test_without_a_folder_the_page_gets_the_file_that_handlab_reads(hand, painted, tmp_path):
    reply = PaintRoom(painted.painting).ask({"kind": "save"})
    file = tmp_path / reply["file"]["name"]
    file.write_text(reply["file"]["text"])
    np.testing.assert_array_equal(load_grid(file).triangle, painted.grid.triangle)
    assert "no live hand" in PaintRoom(painted.painting).ask({"kind": "use"})["text"]


def test_use_it_shows_a_live_hand_that_has_the_muscle_below_the_page(hand, painted):
    pytest.importorskip("anywidget")
    reply = painted.room.ask({"kind": "use"})
    assert "FPB" in reply["said"]
    assert [grid.name for grid in painted.live.session.hand.grids][-1] == "painted"
    assert painted.widget.children == (painted.page.widget, painted.live.widget)


def test_a_live_hand_goes_on_with_the_painted_muscle_below_its_soft_skin(hand, painted):
    session = Session(hand, wear=SOFT)
    session.prepare()
    before = session.wardrobe.network
    session.paint(with_painted(hand, painted.grid), painted.grid)
    assert before is not None
    assert session.wardrobe.network is None, "the skin of the hand without it is no longer worn"
    session.prepare()
    assert session.wardrobe.network.muscles.names[-1] == "painted"
    assert any("FPB makes it swell" in reply.get("text", "") for reply in session.replies())


def test_a_left_hand_can_be_painted_too(rows):
    left = hl.load_hand(side="left")
    panel = PaintPanel(left, "painted", "FPB", columns=2)
    panel.add(rows * [1, 1, -1])
    assert panel.problem is None
    assert panel.grid.side == "left"
    right = PaintPanel(hl.load_hand(), "painted", "FPB", columns=2)
    right.add(rows)
    assert panel.painting.result.volume_ml == pytest.approx(right.painting.result.volume_ml, rel=5e-3)


def test_without_widgets_the_panel_shows_its_read_out(painted, monkeypatch):
    monkeypatch.setattr(PaintPanel, "widget", property(lambda self: (_ for _ in ()).throw(ImportError("anywidget"))))
    assert "6 points, 3 whole rows" in painted._repr_mimebundle_()["text/plain"]
