"""``view`` takes the best way to look at a hand that works, says which, and is never blank."""

import sys

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.terms import UnknownName
from handlab.show import view as module
from handlab.show.view import view


@pytest.fixture
def desk(monkeypatch, tmp_path):
    """No browser opens, and pages go to a folder of the test."""
    opened = []
    monkeypatch.setattr("handlab.show.opening.open_file", lambda path: opened.append(path) or True)
    monkeypatch.setattr(module, "mkdtemp", lambda prefix: str(tmp_path))
    return opened


def test_outside_a_notebook_a_page_opens(hand, grip, desk, capsys):
    shown = view(hand, grip)
    assert shown.kind == "page"
    assert desk == [shown.inner.path]
    assert "<canvas" not in shown.inner.text
    assert len(shown.inner.path.read_text(encoding="utf-8")) > 500_000
    assert "page view" in capsys.readouterr().out


def test_in_a_notebook_it_is_the_live_widget(hand, monkeypatch, capsys):
    pytest.importorskip("anywidget")
    monkeypatch.setattr(module, "in_notebook", lambda: True)
    shown = view(hand, hold=["wrist"])
    assert shown.kind == "widget"
    assert shown.inner.session.hold == ("wrist",)
    assert "live" in repr(shown)
    assert "widget view" in capsys.readouterr().out
    bundle = shown._repr_mimebundle_()
    bundle = bundle[0] if isinstance(bundle, tuple) else bundle
    assert "application/vnd.jupyter.widget-view+json" in bundle
    shown.set(FDP2=0.4)
    assert shown.inner.session.contraction.max() == pytest.approx(0.4)


def test_where_anywidget_is_missing_a_picture_is_shown_and_the_reason_said(hand, grip, monkeypatch):
    pytest.importorskip("ipywidgets")
    monkeypatch.setattr(module, "in_notebook", lambda: True)
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    shown = view(hand, grip, height=200)
    assert shown.kind == "picture"
    assert "anywidget" in shown.why
    picture, slider = shown.inner.widget.children
    before = picture.value
    slider.value = slider.max
    assert before != picture.value


def test_where_no_widget_works_a_page_stands_in_the_cell(hand, monkeypatch):
    def missing(*_):
        raise ImportError("not here")

    monkeypatch.setattr(module, "in_notebook", lambda: True)
    monkeypatch.setitem(module.BUILD, "widget", missing)
    monkeypatch.setitem(module.BUILD, "picture", missing)
    shown = view(hand)
    assert shown.kind == "page"
    assert shown.why.count("not here") == 2
    assert "<iframe srcdoc=" in shown._repr_mimebundle_()["text/html"]


def test_a_still_shows_the_end_of_a_clip(hand, grip, drawn):
    import base64
    import io

    from PIL import Image

    shown = view(hand, grip, "still", skin="solid")
    image = np.asarray(Image.open(io.BytesIO(base64.b64decode(shown._repr_mimebundle_()["image/png"]))))
    assert 0.05 < drawn(image).mean() < 0.6


def test_a_view_without_muscles_says_so(hand, desk):
    with pytest.raises(TypeError, match="give it a state"):
        view(hand, kind="page").set(FDP2=0.3)


def test_unknown_kinds_and_looks_are_answered_with_near_ones(hand):
    with pytest.raises(UnknownName, match="widget"):
        view(hand, kind="widgets of all kinds")
    with pytest.raises(UnknownName, match="palm"):
        view(hand, view="plam")
    with pytest.raises(UnknownName, match="translucent"):
        view(hand, skin="translucid")


def test_a_state_of_another_kind_of_thing_is_refused(hand, desk):
    with pytest.raises(TypeError, match="cannot draw"):
        view(hand, {"mcp2": 1.0})


def test_a_kind_that_cannot_work_here_says_what_is_missing(hand, monkeypatch):
    monkeypatch.setitem(sys.modules, "trame_pyvista", None)
    with pytest.raises(ImportError, match="pip install"):
        view(hand, kind="trame")
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match="anywidget is missing"):
        view(hand, kind="widget")


def test_the_public_name_is_this_one():
    assert hl.view is view
