"""Pictures of moments of inertia say what the numbers say."""

import matplotlib as mpl
import numpy as np
import pytest

from handlab.show.chain_panel import ChainPanel
from handlab.show.inertia_plots import inertia_table_errors, percent, wrist_inertia
from handlab.simulation.inertia_tables import from_tables, table_errors, tensor_inertia, wrist_inertia_error
from handlab.simulation.mechanics import mechanics


@pytest.fixture(autouse=True, scope="module")
def headless():
    mpl.use("Agg")


@pytest.fixture
def close():
    from matplotlib import pyplot

    yield
    pyplot.close("all")


def texts(figure):
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def line(axes, label):
    return next(one for one in axes.lines if one.get_label() == label)


def overlapping(figure):
    """Pairs of labels inside the axes that lie on one another."""
    figure.draw_without_rendering()
    shown = [text for axes in figure.axes for text in (*axes.texts, axes.title) if text.get_text()]
    boxes = [text.get_window_extent() for text in shown]
    return [(shown[i].get_text(), shown[j].get_text()) for i in range(len(boxes)) for j in range(i) if boxes[i].overlaps(boxes[j])]


@pytest.mark.parametrize("constant", ["relaxed", "open", "fist", "de leva female"])
def test_the_wrist_is_drawn_from_open_to_closed_in_kilogram_square_millimetres_and_percent(hand, close, constant):
    figure = wrist_inertia(hand, constant=constant)
    found = wrist_inertia_error(hand, constant=constant)
    left, right = figure.axes
    np.testing.assert_allclose(line(left, "about the flexion axis").get_ydata(), 1e6 * found.inertia[:, 0])
    np.testing.assert_allclose(line(right, "about the deviation axis").get_ydata(), 100.0 * found.error[:, 1])
    assert line(left, "about the flexion axis").get_linestyle() != line(left, "about the deviation axis").get_linestyle()
    assert (left.get_ylabel(), right.get_xlabel()) == ("kg mm²", "closed (%)")
    assert not overlapping(figure)


def test_the_error_in_the_fist_stands_beside_the_line(hand, close):
    error = 100.0 * wrist_inertia_error(hand).error[-1]
    shown = texts(wrist_inertia(hand))
    assert {f"{value:+.0f} %" for value in error} <= set(shown)


def test_every_joint_whose_moment_changes_has_a_row_with_both_errors(hand, close):
    figure = inertia_table_errors(hand, samples=100)
    (axes,) = figure.axes
    names = [label.get_text() for label in axes.get_yticklabels()]
    worst = {how: 100.0 * np.abs(table_errors(hand, samples=100, nearest=how)).max(axis=0) for how in (True, False)}
    assert set(names) == {name for name in hand.moving_names if not name.startswith(("dip", "ip1"))}
    for k, name in enumerate(names):
        column = hand.moving_names.index(name)
        assert line(axes, "nearest entry").get_xdata()[k] == pytest.approx(worst[True][column])
        assert line(axes, "linear between entries").get_xdata()[k] == pytest.approx(worst[False][column])
        assert f"{percent(worst[True][column])} / {percent(worst[False][column])}" in texts(figure)
    assert line(axes, "nearest entry").get_marker() != line(axes, "linear between entries").get_marker()
    assert not overlapping(figure)


def test_percents_have_two_digits():
    assert [percent(value) for value in (0.0333, 0.999, 2.61, 9.96, 48.4)] == ["0.03", "1.0", "2.6", "10", "48"]


def test_the_panel_shows_the_tensors_and_both_readings_of_the_table(hand):
    panel = ChainPanel(hand, pip_deg=52, dip_deg=33)
    y = np.array(mechanics(hand).relaxed)
    for joint, value in (("pip2", 52.0), ("dip2", 33.0)):
        y[hand.moving_names.index(f"{joint}.flexion_extension")] = np.deg2rad(value)
    k = hand.moving_names.index("mcp2.flexion_extension")
    assert panel.inertia == pytest.approx(tensor_inertia(hand, y)[k], rel=1e-12)
    assert panel.linear == pytest.approx(from_tables(hand, y)[k], rel=1e-12)
    assert panel.nearest == pytest.approx(from_tables(hand, y, nearest=True)[k], rel=1e-12)
    assert 1e-4 < abs(panel.nearest / panel.inertia - 1.0) < 0.03
    assert f"J about the MCP axis is {1e6 * panel.inertia:.2f} kg mm^2" in repr(panel)


def test_a_straight_index_finger_has_nearly_twice_the_moment_of_a_hooked_one(hand):
    panel = ChainPanel(hand)
    straight = panel.inertia
    panel.set(pip_deg=100, dip_deg=60)
    assert 1.6 < straight / panel.inertia < 2.2


def test_the_drawn_chain_has_the_lengths_and_the_bends_of_the_finger(hand):
    panel = ChainPanel(hand, pip_deg=50, dip_deg=30)
    joints, centres, mass = panel.chain()
    straight = ChainPanel(hand).chain()[0]
    rods, before = np.diff(joints, axis=0), np.diff(straight, axis=0)
    np.testing.assert_allclose(np.linalg.norm(rods, axis=1), np.linalg.norm(before, axis=1), rtol=0.02)
    turn = np.rad2deg(np.arctan2(rods[:, 1], rods[:, 0]) - np.arctan2(before[:, 1], before[:, 0]))
    np.testing.assert_allclose(turn, [0.0, 50.0, 80.0], atol=3.0)
    assert (np.diff(mass) < 0.0).all()
    assert centres.shape == (3, 2)


def test_a_bend_outside_the_limits_is_refused_with_the_limits(hand):
    panel = ChainPanel(hand, pip_deg=10)
    with pytest.raises(ValueError, match="0 to 110 degrees"):
        panel.set(pip_deg=200)
    assert panel.angles_deg == pytest.approx((10.0, np.rad2deg(mechanics(hand).relaxed[panel.columns[2]])), abs=40.0)


def test_a_slider_bends_the_finger_and_the_read_out_follows(hand, close):
    pytest.importorskip("ipywidgets")
    panel = ChainPanel(hand)
    assert panel.widget is panel.widget
    before = bytes(panel._picture.value)
    panel.sliders["pip_deg"].value = 60.0
    assert panel.angles_deg[0] == pytest.approx(60.0)
    assert "PIP 60" in panel._readout.value
    assert bytes(panel._picture.value) != before
    panel.set(dip_deg=20)
    assert panel.sliders["dip_deg"].value == pytest.approx(20.0)


@pytest.mark.parametrize("bend", [(0, 0), (50, 30), (100, 60), (110, 90)])
def test_labels_of_the_chain_keep_clear_of_one_another(hand, close, bend):
    assert not overlapping(ChainPanel(hand, pip_deg=bend[0], dip_deg=bend[1]).figure())


def test_the_figure_of_the_panel_names_its_units(hand, close):
    left, right = ChainPanel(hand).figure().axes
    assert (left.get_xlabel(), right.get_ylabel(), right.get_xlabel()) == ("mm", "kg mm²", "PIP angle (degrees)")
