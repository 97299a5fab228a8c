"""The panel of one bone: what its sliders do, ``set`` does, and it says when a bone has run away."""

import io

import numpy as np
import pytest

import handlab as hl
from handlab.show.step_panel import StepPanel


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture
def panel(hand):
    return StepPanel(hand)


def test_the_finger_reaches_the_speed_at_which_friction_balances_the_muscle_and_stops_when_it_lets_go(panel):
    middle = np.searchsorted(panel.motion.time, 0.05)
    balance = panel.torque(0.0, float(panel.motion.angle[middle])) / panel.friction
    assert panel.motion.speed[middle] == pytest.approx(balance, rel=0.01)
    assert abs(panel.motion.speed[-1]) < 1e-3
    assert 5.0 < np.rad2deg(panel.motion.angle[-1]) < 20.0
    assert panel.ran_away is None


@pytest.mark.parametrize(
    ("rule", "step_ms", "runs"), [("explicit", 2.9, False), ("explicit", 3.3, True), ("implicit", 30, False), ("leapfrog", 30, False)]
)
def test_the_panel_says_when_the_bone_has_run_away(panel, rule, step_ms, runs):
    panel.set(rule=rule, step_ms=step_ms)
    assert (panel.ran_away is not None) is runs
    assert ("run away" in panel.text()) is runs
    assert panel.limit_ms == pytest.approx(2.98, abs=0.02)


def test_with_the_printed_rule_the_finger_goes_on_when_the_muscle_has_let_go(panel):
    right = panel.motion.angle[-1]
    panel.set(rule="printed")
    assert panel.motion.angle[-1] > 1.8 * right


def test_a_mistake_is_told_and_changes_nothing(panel, hand):
    before = panel.motion
    for change, word in (({"step_ms": 0}, "dt is 0"), ({"rule": "euler"}, "choose one of")):
        with pytest.raises(ValueError, match=word):
            panel.set(**change)
        assert (panel.motion is before, panel.step_ms, panel.rule) == (True, 0.1, "implicit")
    with pytest.raises(ValueError, match="no lever arm"):
        StepPanel(hand, "mcp3.flexion_extension", "FDP2")
    with pytest.raises(KeyError, match="mcp2"):
        StepPanel(hand, "mpc2.flexion_extension", "FDP2")


def test_the_sliders_do_what_set_does_and_every_value_draws_a_picture(panel):
    pytest.importorskip("ipywidgets")
    from PIL import Image

    assert panel.widget
    assert panel._picture.value, "the first picture is there before a slider moves"
    pictures = {panel._picture.value}
    panel.step_slider.value = 5.0
    panel.rule_choice.value = "explicit"
    assert (panel.step_ms, panel.rule) == (5.0, "explicit")
    panel.set(rule="leapfrog", step_ms=2.0)
    assert (panel.step_slider.value, panel.rule_choice.value) == (2.0, "leapfrog")
    assert "leapfrog" in panel._readout.value
    drawn = []
    panel.figure, really = lambda: drawn.append(1) or really(), panel.figure
    panel.set(rule="implicit", step_ms=3.0)
    assert len(drawn) == 1, "moving the sliders along must not compute everything again"
    for rule in panel.rule_choice.options:
        for value in (0.1, 30.0):
            panel.set(rule=rule, step_ms=value)
            pictures.add(panel._picture.value)
    assert len(pictures) == 8  # two of each rule, and the first is one of them
    assert min(Image.open(io.BytesIO(panel._picture.value)).size) > 300


def test_the_figure_has_units_and_shows_both_motions(panel):
    figure = panel.figure()
    assert [axes.get_ylabel() for axes in figure.axes] == ["degrees", "degrees per second"]
    assert all(axes.get_xlabel() == "time (ms)" and len(axes.lines) == 3 for axes in figure.axes)


def test_without_widgets_the_panel_shows_its_read_out(panel, monkeypatch):
    monkeypatch.setattr(StepPanel, "widget", property(lambda self: (_ for _ in ()).throw(ImportError("ipywidgets"))))
    assert "2J/mu" in panel._repr_mimebundle_()["text/plain"]
