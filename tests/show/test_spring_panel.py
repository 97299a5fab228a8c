"""The panel of springs: it explodes where theory says, in the swing that theory says."""

import io

import numpy as np
import pytest

from handlab.show.spring_panel import MOST_MASSES, SpringPanel


@pytest.fixture
def panel():
    return SpringPanel()


@pytest.mark.parametrize("masses", [1, 2, 7, 40])
def test_a_row_explodes_just_above_the_limit_of_theory_and_not_below(panel, masses):
    """Between walls omega_max = 2 sqrt(k / m) sin(n pi / (2 n + 2)) (standing waves of a row)."""
    omega = 2.0 * np.sqrt(2.0 / 1e-4) * np.sin(masses * np.pi / (2 * masses + 2))
    panel.set(masses=masses, step_ms=0.99 * 2e3 / omega)
    assert panel.limit_ms == pytest.approx(2e3 / omega, rel=1e-9)
    assert not panel.exploded
    assert "exploded" not in panel.text()
    panel.set(step_ms=1.01 * 2e3 / omega)
    assert panel.exploded
    assert "exploded" in repr(panel)


def test_in_the_swing_that_explodes_neighbours_move_against_each_other(panel):
    panel.set(masses=12, step_ms=7.5)
    assert panel.exploded
    assert (np.sign(panel.pattern[1:]) == -np.sign(panel.pattern[:-1])).all()


@pytest.mark.parametrize("damping", [0.0, 50.0, 500.0])
def test_damping_moves_the_limit_of_no_row(panel, damping):
    for part, explodes in ((0.98, False), (1.02, True)):
        panel.set(masses=5, damping=damping, step_ms=1.0)
        panel.set(step_ms=part * panel.limit_ms)
        assert panel.exploded is explodes


def test_with_damping_a_short_step_comes_to_rest(panel):
    panel.set(masses=5, damping=100.0, step_ms=1.0)
    assert panel.farthest[-1] < 1e-3 * panel.farthest[0]


def test_four_times_the_stiffness_halves_the_limit(panel):
    before = panel.limit_ms
    panel.set(stiffness=8.0)
    assert panel.limit_ms == pytest.approx(0.5 * before, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"masses": 0}, "masses is 0"),
        ({"masses": MOST_MASSES + 1}, "1 to 40"),
        ({"step_ms": 0}, "step_ms is 0"),
        ({"step_ms": float("nan")}, "step_ms is nan"),
        ({"stiffness": -1}, "stiffness is -1"),
        ({"damping": -1}, "damping is -1"),
    ],
)
def test_a_mistake_is_told_and_changes_nothing(panel, change, word):
    before = panel.pattern
    with pytest.raises(ValueError, match=word):
        panel.set(**change)
    assert panel.pattern is before
    assert (panel.masses, panel.step_ms, panel.damping) == (1, 1.0, 0.0)


def test_the_sliders_do_what_set_does_and_every_value_draws_a_picture(panel):
    pytest.importorskip("ipywidgets")
    from PIL import Image

    assert panel.widget
    pictures = {panel._picture.value}
    panel.masses_slider.value = 20
    pictures.add(panel._picture.value)
    panel.step_slider.value = 8.0
    pictures.add(panel._picture.value)
    assert (panel.masses, panel.step_ms, panel.exploded) == (20, 8.0, True)
    assert "exploded" in panel._readout.value
    drawn = []
    panel.figure, really = lambda: drawn.append(1) or really(), panel.figure
    panel.set(masses=3, step_ms=2.0)
    assert len(drawn) == 1, "moving the sliders along must not compute everything again"
    assert (panel.masses_slider.value, panel.step_slider.value) == (3, 2.0)
    pictures.add(panel._picture.value)
    assert len(pictures) == 4
    assert all(min(Image.open(io.BytesIO(picture)).size) > 300 for picture in pictures)


def test_the_figure_has_units(panel):
    figure = panel.figure()
    assert figure.axes[1].get_ylabel() == "farthest from rest (mm)"
    assert len(figure.axes[0].lines[1].get_xdata()) == panel.masses + 2


def test_without_widgets_the_panel_shows_its_read_out(panel, monkeypatch):
    monkeypatch.setattr(SpringPanel, "widget", property(lambda self: (_ for _ in ()).throw(ImportError("ipywidgets"))))
    assert "springs of 2 N/m" in panel._repr_mimebundle_()["text/plain"]
