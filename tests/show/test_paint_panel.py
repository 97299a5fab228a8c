"""Painting a muscle: what a click means, what is refused and how, and that nothing clicked is ever lost."""

import asyncio
import dataclasses
import threading
import time

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.grids import load_grids
from handlab.anatomy.meshes import Mesh
from handlab.anatomy.terms import UnknownName
from handlab.show.paint_panel import PaintPanel
from handlab.show.paint_picture import PaintPicture
from handlab.show.painting import influenced_by
from handlab.simulation.geometric_muscle import ellipsoids, geometric_muscles, muscles_of
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.muscle_below import DEEP, hits, influenced
from handlab.simulation.muscle_fit import checked_skin
from handlab.simulation.soft_skin import soft_skin

SHIPPED = next(grid for grid in load_grids() if grid.name == "flexor_pollicis_brevis")
BONES = ("trapezium", "metacarpal_1", "proximal_phalanx_1")


@pytest.fixture(scope="module")
def rows(hand):
    """Three rows of two points of the shipped short flexor."""
    return SHIPPED.points_on(hand.skin, hand.skin.points, hand.side)[::3][:, ::2]


@pytest.fixture
def panel(hand):
    made = PaintPanel(hand, "painted", "FPB", columns=2)
    yield made
    made.canvas.close()


@pytest.fixture
def painted(panel, rows):
    panel.add(rows)
    return panel


def blue_and_green(picture):
    red, green, blue = (picture[..., k].astype(int) for k in range(3))
    return np.count_nonzero((blue > 110) & (red < 60) & (blue > green + 25)), np.count_nonzero((green > red + 35) & (green > blue + 5))


# What a click means.


@pytest.mark.parametrize("change", ["as it opens", "turned", "near"])
def test_a_place_in_the_picture_is_the_place_that_vtk_sees_there(hand, change):
    canvas = PaintPicture(hand)
    if change != "as it opens":
        canvas.turn(0.23, -0.11)
    if change == "near":
        canvas.zoom(2.5, 0.7, 0.6)
    from handlab.show.painting import Painting, Settings

    canvas.draw(Painting(hand, Settings("none", "FPB")))
    renderer = canvas._scene.plotter.renderer
    width, height = canvas.size
    import pyvista

    mesh = pyvista.PolyData(hand.skin.points, np.column_stack([np.full(len(hand.skin.faces), 3), hand.skin.faces]))
    met = 0
    for x, y in ((0.5, 0.5), (0.42, 0.62), (0.6, 0.55), (0.37, 0.4), (0.02, 0.03)):
        ends = []
        for depth in (0.0, 1.0):
            renderer.SetDisplayPoint(x * width, (1.0 - y) * height, depth)
            renderer.DisplayToWorld()
            world = np.array(renderer.GetWorldPoint())
            ends.append(world[:3] / world[3])
        hits, _ = mesh.ray_trace(ends[0], ends[1])
        found = canvas.pick(x, y)
        if not len(hits):
            assert found is None
            continue
        met += 1
        first = hits[np.linalg.norm(hits - ends[0], axis=1).argmin()]
        assert np.linalg.norm(found - first) < 2e-4
        (place,), (seen,) = canvas.places(found)
        np.testing.assert_allclose(place, (x, y), atol=1e-6)
        assert seen
    assert met >= 2
    canvas.close()


def test_clicks_are_rows_from_origin_to_insertion(panel, rows):
    for point in rows.reshape(-1, 3):
        (x, y), _ = (found[0] for found in panel.canvas.places(point))
        assert panel.click(float(x), float(y))
    assert np.linalg.norm(panel.painting.rows - rows, axis=2).max() < 1e-3
    assert panel.grid.drives == ("flexor_pollicis_brevis",)
    assert panel.painting.missing == 0


def test_a_click_beside_the_hand_says_so_and_changes_nothing(painted):
    before = painted.painting.points
    assert painted.click(0.02, 0.02) is False
    assert "beside the hand" in painted.text()
    assert painted.painting.points is before
    assert painted.click(1.5, 0.5) is False


def test_going_nearer_keeps_the_place_under_the_mouse_and_stops_in_time(hand, rows):
    canvas, thumb = PaintPicture(hand), rows[1, 0]
    (x, y), (there, _) = canvas.places(thumb)[0][0], canvas.places(hand.bones["metacarpal_5"].points[:2])[0]
    canvas.zoom(1.7, x, y)
    assert np.linalg.norm(canvas.pick(x, y) - thumb) < 3e-3, "exact in the plane of the middle, near it elsewhere"
    after = canvas.places(hand.bones["metacarpal_5"].points[:1])[0][0]
    assert np.linalg.norm(after - (x, y)) == pytest.approx(1.7 * np.linalg.norm(there - (x, y)), rel=0.1)
    for _ in range(50):
        canvas.zoom(2.0)
    assert canvas.camera.distance == pytest.approx(0.15)
    with pytest.raises(ValueError, match="positive"):
        canvas.zoom(0.0)


def test_points_on_the_far_side_are_told_apart(hand, rows):
    canvas = PaintPicture(hand)
    assert canvas.places(rows[1])[1].all()
    canvas.look(view="back")
    assert not canvas.places(rows[1])[1].any()


# What comes of it.


def test_a_muscle_appears_in_under_a_second_with_its_grid_in_blue_and_its_points_in_green(hand, rows):
    panel = PaintPanel(hand, "painted", "FPB", columns=2, skin="mesh")
    panel.add(rows)
    panel.picture()  # the canvas, and the compiled parts
    empty = PaintPanel(hand, "nothing", "FPB", skin="mesh").picture()
    panel.painting.move(2, panel.painting.points[2] + [0.001, 0, 0])
    begin, used = time.perf_counter(), time.process_time()
    panel.painting.move(2, panel.painting.points[2] - [0.001, 0, 0])
    picture = panel.picture()
    print(f"fit and picture: {time.perf_counter() - begin:.2f} s of the clock")
    assert time.process_time() - used < 1.0
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
    before = (painted.painting.settings, painted.painting.result, painted.contraction, painted.canvas.skin)
    with pytest.raises(kind, match=word):
        painted.set(**change)
    assert (painted.painting.settings, painted.painting.result, painted.contraction, painted.canvas.skin) == before


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


@pytest.fixture
def page(panel):
    pytest.importorskip("anywidget")
    sent = []
    panel.canvas_widget.send = lambda content, buffers: sent.append((content, len(buffers[0])))
    assert panel.widget
    sent.clear()
    return sent


def click_of(panel, point, **more):
    (x, y), _ = (found[0] for found in panel.canvas.places(point))
    return {"kind": "click", "x": float(x), "y": float(y), "page": "p", **more}


def test_clicks_of_other_threads_while_the_kernel_is_busy_are_all_heeded_in_order_and_drawn_once(hand, rows):
    pytest.importorskip("anywidget")
    flat = rows.reshape(-1, 3)

    async def session():
        panel, sent = PaintPanel(hand, "painted", "FPB", columns=2), []
        panel.canvas_widget.send = lambda content, buffers: sent.append(content)
        assert panel.widget
        sent.clear()
        messages = [click_of(panel, point, n=k + 1) for k, point in enumerate(flat)]
        other = threading.Thread(target=lambda: [panel._hear(None, message, []) for message in messages])
        other.start()
        time.sleep(0.3)  # the kernel is busy with a cell
        other.join()
        assert len(panel.painting.points) == 0
        await asyncio.sleep(0.1)
        return panel, sent

    panel, sent = asyncio.run(session())
    assert np.linalg.norm(panel.painting.points - flat, axis=1).max() < 1e-3
    assert len(sent) == 1
    assert sent[0]["answered"] == {"p": 6}
    panel.canvas.close()


def test_a_click_that_arrives_twice_counts_once(panel, page, rows):
    message = click_of(panel, rows[0, 0], n=1)
    panel._hear(None, message, [])
    panel._hear(None, message, [])
    assert len(panel.painting.points) == 1


def test_the_controls_do_what_set_does_and_a_wrong_value_is_told_and_put_back(panel, page, rows):
    panel.add(rows)
    named = panel._controls.named
    named["finer"].value = 3
    assert panel.painting.settings.finer == 3
    assert panel.grid.triangle.shape == (7, 2)
    named["name"].value = "no name!"
    assert panel.painting.settings.name == "painted"
    assert named["name"].value == "painted"
    assert "letters" in panel._controls.readout.value
    assert len(panel._controls.bones.children) == 3
    panel._controls.bones.children[0].value = "trapezoid"
    assert panel.painting.carriers[0] == {"trapezoid": 1.0}
    panel.set(thickness_mm=(1, 20))
    assert named["thickness_mm"].value == (1, 20)
    assert page[-1][1] < 60_000, "bytes of a picture"


def test_the_controls_show_the_skin_distance_of_every_row(panel, page):
    """As in lesson 8: three rows, three distances; one for all is the slider's."""
    slider, each = (panel._controls.named[name] for name in ("skin_distance_mm", "rows_mm"))
    assert (slider.layout.display, each.layout.display) == (None, "none")
    panel.set(skin_distance_mm=(6, 3, 2))
    assert (slider.layout.display, each.layout.display, each.value) == ("none", None, "6, 3, 2")
    each.value = "5 3, 2.5"
    assert panel.painting.settings.skin_distance_mm == (5, 3, 2.5)
    for wrong in ("five", "", "5, 900"):
        each.value = wrong
        assert panel.painting.settings.skin_distance_mm == (5, 3, 2.5)
        assert "distance" in panel.said
        assert each.value == "5, 3, 2.5"
    each.value = "20"
    assert (slider.layout.display, slider.value, each.layout.display) == (None, 20, "none")


def test_the_save_button_writes_and_says_where(panel, page, rows, tmp_path):
    panel._save_into(str(tmp_path))
    assert "no muscle yet" in panel._controls.readout.value
    panel.add(rows)
    for _ in range(2):  # its own file may be written again
        panel._save_into(str(tmp_path))
        assert "Saved as" in panel._controls.readout.value
    other = PaintPanel(panel.hand, "painted", "FPB", columns=2)
    other.add(rows)
    other._save_into(str(tmp_path))
    assert "exists" in other.said


def test_a_message_that_makes_no_sense_is_told(panel, page):
    for message in ({"kind": "clack"}, {"kind": "click"}, {"kind": "zoom", "by": -1}, {"kind": "move", "mark": 3, "x": 0.5, "y": 0.5}):
        panel._hear(None, {"page": "p", **message}, [])
        assert panel.said, message
    panel._hear(None, "nonsense", [])


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
