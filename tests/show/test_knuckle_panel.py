"""The panel of a bent joint: what it says it measured is what a ruler finds, and its slider does what ``set`` does."""

import io

import numpy as np
import pytest

import handlab as hl
from handlab.show.knuckle_panel import WAYS, KnucklePanel
from handlab.studies import knuckle


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture
def panel(hand):
    return KnucklePanel(hand, "pip2", bend_deg=60)


def test_the_straight_finger_is_a_hundred_percent_of_itself(panel):
    panel.set(bend_deg=0)
    for way in WAYS:
        assert panel.measured[way] == pytest.approx(100.0, abs=1e-9)


def test_a_bent_finger_stretches_the_back_and_shortens_the_palm_side(panel):
    for way in WAYS:
        volume, back, palm = panel.measured[way]
        assert 75.0 < volume < 101.0
        assert 105.0 < back < 170.0
        assert 50.0 < palm < 95.0


def test_the_numbers_are_those_of_the_study(panel, hand):
    angles = dict.fromkeys(hand.moving_names, 0.0)
    flat, bent = (hl.pose(hand, angles | {"pip2.flexion_extension": np.deg2rad(bend)}) for bend in (0.0, 60.0))
    part = knuckle.piece(hand, "pip2")
    ratio = np.divide(*(knuckle.piece_volume(knuckle.worn(hand, state, "linear"), part) for state in (bent, flat)))
    assert panel.measured["linear"][0] == pytest.approx(100.0 * ratio, rel=1e-9)
    assert f"linear: volume of the piece {100.0 * ratio:.1f} %" in repr(panel)


def test_the_picture_shows_the_joint_in_its_middle_and_bends_to_the_palm(panel):
    centre, normal, across = panel._plane()
    assert np.column_stack([across, normal]).T @ np.column_stack([across, normal]) == pytest.approx(np.eye(3), abs=1e-9)
    tip = panel.state.skin[panel.hand.feature_points["tip_index"]["palmar"]]
    assert (tip - centre) @ across[:, 1] > 0.02, "palmar is upward"
    assert abs((tip - centre) @ normal) < 0.01
    figure = panel.figure()
    section, bars = figure.axes
    assert section.get_xlabel() == "mm, distal to the right"
    assert {text.get_text() for text in section.get_legend().get_texts()} == set(WAYS)
    assert len(bars.patches) == 9


def test_the_slider_does_what_set_does(panel):
    pytest.importorskip("ipywidgets")
    from PIL import Image

    assert panel.widget
    first = panel._picture.value
    assert min(Image.open(io.BytesIO(first)).size) > 300
    panel.slider.value = 90.0
    assert panel.bend_deg == 90.0
    assert panel._picture.value != first
    drawn = []
    panel.figure, really = lambda: drawn.append(1) or really(), panel.figure
    panel.set(bend_deg=30)
    assert (len(drawn), panel.slider.value) == (1, 30.0)
    assert "30 degrees" in panel._readout.value


def test_a_mistake_is_told_and_changes_nothing(panel, hand):
    before = panel.skin
    for bend in (-5, 200):
        with pytest.raises(ValueError, match=f"bend_deg is {bend}"):
            panel.set(bend_deg=bend)
    assert panel.skin is before
    assert panel.bend_deg == 60.0
    with pytest.raises(KeyError, match="pip2"):
        KnucklePanel(hand, "pip22")


def test_without_widgets_the_panel_shows_its_read_out(panel, monkeypatch):
    monkeypatch.setattr(KnucklePanel, "widget", property(lambda self: (_ for _ in ()).throw(ImportError("ipywidgets"))))
    assert "ink on the back" in panel._repr_mimebundle_()["text/plain"]
