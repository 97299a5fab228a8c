"""The panels of lessons 10 to 12: what they say is what theory and the studies say, and their controls do what ``set`` does."""

import io

import numpy as np
import pytest

import handlab as hl
from handlab.fitting.landmarks import NAMES
from handlab.physics import rbf
from handlab.show.ruler_panel import RulerPanel
from handlab.show.size_panel import POWERS, SizePanel
from handlab.show.warp_panel import WarpPanel
from handlab.studies import size


@pytest.fixture(scope="module")
def child():
    return hl.load_hand("child")


def drawn(panel):
    """The picture that the widget shows now."""
    from PIL import Image

    picture = panel._picture.value
    assert min(Image.open(io.BytesIO(picture)).size) > 300
    return picture


@pytest.mark.parametrize(("ruler", "camera"), [(0, 600), (20, 600), (20, 1500), (45, 400)])
def test_a_ruler_is_wrong_by_similar_triangles(child, ruler, camera):
    panel = RulerPanel(child, ruler_mm=ruler, camera_mm=camera)
    height = np.mean([panel.photo.marks_mm[name][2] for name in panel.between])
    assert panel.error_percent == pytest.approx(100 * ((camera - ruler) / (camera - height) - 1), abs=0.2)
    assert f"{panel.error_percent:+.1f} %" in repr(panel)
    assert f"camera {camera} mm" in repr(panel)


def test_the_rays_of_the_side_view_meet_the_camera(child):
    panel = RulerPanel(child, ruler_mm=20, camera_mm=800)
    rays = [line.get_xydata() for line in panel.figure().axes[0].lines if len(line.get_xydata()) == 2 and line.get_linewidth() < 2]
    assert len(rays) == 4
    for ray in rays:
        assert list(ray[0]) == [0.0, 800.0]
        assert ray[1][1] == 0.0


def test_a_picture_has_about_as_many_dots_as_a_wide_cell(child):
    """Fewer look soft when the cell stretches them, many more make a drag slow."""
    pytest.importorskip("ipywidgets")
    from PIL import Image

    panel = RulerPanel(child)
    assert panel.widget
    assert 1300 < Image.open(io.BytesIO(panel._picture.value)).width < 1700


def test_the_sliders_of_the_ruler_do_what_set_does(child):
    pytest.importorskip("ipywidgets")
    panel = RulerPanel(child)
    assert panel.widget
    first = drawn(panel)
    panel.sliders["ruler_mm"].value = 30.0
    assert panel.photo.ruler_mm == 30.0
    assert drawn(panel) != first
    panel.set(camera_mm=900)
    assert panel.sliders["camera_mm"].value == 900.0
    assert "camera 900 mm" in panel._readout.value


def test_a_ruler_that_cannot_be_is_refused_and_changes_nothing(child):
    panel = RulerPanel(child, ruler_mm=10)
    with pytest.raises(ValueError, match="ruler_mm is 70; give 0 to 60"):
        panel.set(ruler_mm=70, camera_mm=1000)
    assert (panel.photo.ruler_mm, panel.photo.camera_mm) == (10.0, 600.0)


def test_a_drag_moves_one_point_and_a_long_one_folds(hand):
    panel = WarpPanel(hand, "pip_index", distal_mm=10, radial_mm=-4)
    off = panel.warp(panel.source) - panel.source
    np.testing.assert_allclose(1000 * off[NAMES.index("pip_index")], [10, 0, -4], atol=1e-6)
    assert np.abs(np.delete(off, NAMES.index("pip_index"), axis=0)).max() < 1e-9
    assert panel.folded == 0
    panel.set(distal_mm=45, radial_mm=0)
    assert panel.folded > 0
    assert "FOLDED" in repr(panel)
    assert next(iter(panel.least)) == "middle_phalanx_2"
    bone = hand.bones["middle_phalanx_2"].points
    assert panel.least["middle_phalanx_2"] == pytest.approx(np.linalg.det(rbf.jacobian(panel.warp, bone)).min())
    marks = [line for line in panel.figure().axes[0].lines if line.get_marker() == "x"]
    assert len(marks[0].get_xdata()) == panel.folded


def test_a_hand_that_is_not_dragged_is_itself(hand):
    panel = WarpPanel(hand)
    assert min(panel.least.values()) == pytest.approx(1.0, abs=1e-9)
    assert "no bone folds" in repr(panel)


def test_a_left_hand_is_dragged_to_its_own_thumb():
    left = hl.load_hand(side="left")
    panel = WarpPanel(left, "pip_index", radial_mm=10)
    thumb = left.skin.points[left.feature_points["tip_thumb"]["palmar"]]
    i = NAMES.index("pip_index")
    assert np.linalg.norm((panel.target - thumb)[i, [0, 2]]) < np.linalg.norm((panel.source - thumb)[i, [0, 2]])


def test_the_controls_of_the_warp_do_what_set_does(hand):
    pytest.importorskip("ipywidgets")
    panel = WarpPanel(hand)
    assert panel.widget
    first = drawn(panel)
    panel.sliders["distal_mm"].value = 40.0
    panel.choice.value = "tip_ring"
    assert panel.point == "tip_ring"
    assert drawn(panel) != first
    assert panel.target[NAMES.index("tip_ring"), 0] == pytest.approx(panel.source[NAMES.index("tip_ring"), 0] + 0.04)
    panel.set(point="mcp_index", distal_mm=0)
    assert (panel.choice.value, panel.sliders["distal_mm"].value) == ("mcp_index", 0.0)


def test_a_drag_that_cannot_be_is_refused_and_changes_nothing(hand):
    panel = WarpPanel(hand, distal_mm=5)
    with pytest.raises(ValueError, match="radial_mm is 100"):
        panel.set(distal_mm=9, radial_mm=100)
    with pytest.raises(KeyError, match="pip_index"):
        panel.set(point="pip_indx")
    assert panel._drag == {"distal_mm": 5.0, "radial_mm": 0.0}


@pytest.mark.parametrize("times", [0.6, 1.4])
def test_a_hand_that_grew_with_its_muscles_keeps_the_laws_of_growth(hand, times):
    panel = SizePanel(hand, size=times)
    for name, power in POWERS.items():
        assert panel.ratios[name] == pytest.approx(times**power, rel=0.01), name


def test_kept_mechanics_change_inertia_alone(hand):
    panel = SizePanel(hand, size=0.7, mechanics="kept")
    assert panel.ratios["force"] == panel.ratios["torque"] == 1.0
    assert panel.ratios["inertia"] == pytest.approx(0.49, rel=1e-6)
    assert panel.ratios["half time"] == pytest.approx(size.half_time(panel.other) / size.half_time(hand))
    assert "mechanics kept" in repr(panel)


def test_the_controls_of_the_size_do_what_set_does(hand):
    pytest.importorskip("ipywidgets")
    panel = SizePanel(hand)
    assert panel.widget
    first = drawn(panel)
    panel.slider.value = 0.7
    panel.choice.value = "kept"
    assert (panel.size, panel.mechanics) == (0.7, "kept")
    assert drawn(panel) != first
    panel.set(size=1.2, mechanics="scaled")
    assert (panel.slider.value, panel.choice.value) == (1.2, "scaled")
    with pytest.raises(ValueError, match=r"size is 3; give 0\.5 to 1\.5"):
        panel.set(size=3)
    with pytest.raises(ValueError, match="mechanics is 'big'"):
        panel.set(mechanics="big")
    assert (panel.size, panel.mechanics) == (1.2, "scaled")
