"""The panel: what a slider does, ``set`` does; on the main thread, and never in silence."""

import asyncio
import builtins
import io
import threading

import numpy as np
import pytest

import handlab as hl
from handlab.show import panels
from handlab.show.main_thread import OnMain
from handlab.show.panels import MusclePanel


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture
def panel(hand):
    return MusclePanel(hand, ["FDP2", "opponens_digiti_minimi"], hold=["wrist"])


def test_a_slider_moves_exactly_the_joints_that_its_lever_arms_reach(panel):
    panel.set(FDP2=0.3)
    assert {name.partition(".")[0] for name in panel.moved} == {"mcp2", "pip2", "dip2"}
    assert all(panel.moved[f"{joint}2.flexion_extension"] > 10 for joint in ("mcp", "pip", "dip"))
    assert "no joint has moved" not in panel.text()


def test_abbreviation_and_full_name_are_the_same_slider(panel):
    panel.set(flexor_digitorum_profundus_index=0.2)
    assert panel.contraction == {"FDP2": 0.2, "ODM": 0.0}


def test_a_second_change_goes_on_where_the_first_one_ended(panel):
    panel.set(FDP2=0.3)
    between = panel.state
    panel.set(ODM=0.3)
    assert panel.contraction == {"FDP2": 0.3, "ODM": 0.3}
    assert {"cmc4", "cmc5"} <= {name.partition(".")[0] for name in panel.moved}
    assert between is not panel.state


def test_the_record_of_the_panel_is_one_motion_without_gaps_or_doubles(panel):
    for contraction in (0.1, 0.2, 0.3):
        panel.set(FDP2=contraction)
    clip = panel.clip
    assert np.allclose(np.diff(clip.time), 1 / 60)
    assert clip.time[-1] == pytest.approx(3.0)
    assert len(clip.time) == len(clip.angle) == len(clip.contraction) == len(clip.fibre_length) == 181
    assert np.array_equal(clip.angle[-1], panel.state.angle)
    assert np.abs(np.diff(np.rad2deg(clip.angle), axis=0)).max() < 10, "the hand does not jump"


def test_the_record_forgets_what_is_older_than_a_minute(panel):
    panel.seconds = 7.0
    for _ in range(12):
        panel.set(FDP2=0.1)
    assert 50.0 < panel.clip.time[-1] <= 60.0


def test_reset_goes_back_to_the_start(panel):
    panel.set(FDP2=0.3)
    panel.reset()
    assert not panel.moved
    assert panel.contraction == {"FDP2": 0.0, "ODM": 0.0}
    assert panel.state is panel.start
    assert len(panel.clip) > 1


def test_a_mistake_is_told_and_changes_nothing(panel):
    with pytest.raises(ValueError, match="between 0 and 1"):
        panel.set(FDP2=1.4)
    with pytest.raises(ValueError, match="has no slider in this panel"):
        panel.set(FDP3=0.4)
    with pytest.raises(KeyError, match="FDP"):
        panel.set(FDP22=0.4)
    assert panel.contraction == {"FDP2": 0.0, "ODM": 0.0}
    assert not panel.moved
    with pytest.raises(ValueError, match="at least one muscle"):
        MusclePanel(panel.hand, [])


def test_the_read_out_agrees_with_the_state(panel):
    panel.set(FDP2=0.3)
    row = panel.hand.muscle_names.index("flexor_digitorum_profundus_index")
    assert f"FDP2: fibre {1000 * panel.state.fibre_length[row]:.1f} mm, at rest 66.0 mm" in repr(panel)


def test_without_ipywidgets_the_panel_shows_its_read_out(panel, monkeypatch):
    really = builtins.__import__

    def without(name, *arguments, **how):
        if name.startswith("ipywidgets"):
            raise ImportError(name)
        return really(name, *arguments, **how)

    monkeypatch.setattr(builtins, "__import__", without)
    panel.set(FDP2=0.3)
    shown = panel._repr_mimebundle_()["text/plain"]
    assert "pip2.flexion_extension" in shown
    assert "handlab[lab]" in shown


def test_postures_stand_side_by_side_each_in_its_own_state(hand):
    pytest.importorskip("anywidget")
    states = {"zero": hl.pose(hand, dict.fromkeys(hand.moving_names, 0.0)), "<relaxed>": hl.rest(hand)}
    shown = panels.Postures(hand, states, view="radial")
    first, second, _ = shown.widget.children
    assert "&lt;relaxed&gt;" in second.children[0].value
    assert first.layout.width == "50%"
    assert "relaxed" in repr(shown)
    with pytest.raises(KeyError, match="radial"):
        panels.Postures(hand, states, view="radiall")


class Widgets:
    """Sliders need ipywidgets and a picture that can be drawn."""

    @pytest.fixture
    def picture(self, panel, monkeypatch):
        """The picture of the panel where no live viewer is installed."""
        pytest.importorskip("ipywidgets")
        monkeypatch.setattr(panels, "find_spec", lambda name: None)
        from PIL import Image

        def look():
            return np.asarray(Image.open(io.BytesIO(panel._picture.widget.value)).convert("RGB")).astype(int)

        return look


class TestSliders(Widgets):
    """What a student drags."""

    def test_a_slider_moves_the_hand_and_only_its_finger_in_the_picture(self, panel, picture):
        assert panel.widget is panel.widget
        before = picture()
        panel.sliders["FDP2"].value = 0.3
        assert panel.contraction["FDP2"] == 0.3
        after = picture()
        changed = np.abs(after - before).max(axis=2) > 40
        assert 0.002 < changed.mean() < 0.2, "a finger moves; noise would change everything"
        edge = np.concatenate([changed[:8].ravel(), changed[:, :8].ravel()])
        assert not edge.any(), "the background stays as it was"
        assert "mcp2.flexion_extension" in panel._readout.value

    def test_set_moves_the_slider_and_acts_once(self, panel, picture):
        assert panel.widget
        panel.set(FDP2=0.25)
        assert panel.sliders["FDP2"].value == 0.25
        assert panel.clip.time[-1] == pytest.approx(1.0)

    def test_the_button_relaxes_the_hand(self, panel, picture):
        widget = panel.widget
        panel.sliders["FDP2"].value = 0.3
        button = next(child for child in widget.children[1].children if type(child).__name__ == "Button")
        button.click()
        assert panel.sliders["FDP2"].value == 0.0
        assert not panel.moved

    def test_an_error_in_a_slider_is_seen_by_the_student_and_by_tests(self, panel, picture, monkeypatch):
        assert panel.widget
        monkeypatch.setattr(MusclePanel, "set", lambda self, **changes: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            panel.sliders["FDP2"].value = 0.3
        assert "division" in panel._readout.value

    def test_every_slider_can_be_driven_over_its_range(self, panel, picture):
        assert panel.widget
        for slider in panel.sliders.values():
            for value in (slider.min, slider.max, 0.5):
                slider.value = value
                assert np.isfinite(panel.state.angle).all()


def test_the_live_viewer_of_the_panel_shows_what_the_panel_knows(panel):
    pytest.importorskip("anywidget")
    assert panel.widget
    view = panel._picture
    for change in ({"FDP2": 0.3}, {"ODM": 0.4}, {"FDP2": 0.0}):
        panel.set(**change)
        assert np.allclose(view.state.angle, panel.state.angle)
    panel.reset()
    assert np.allclose(view.state.angle, panel.start.angle)


def test_a_burst_from_another_thread_runs_on_the_main_thread_and_the_last_value_wins():
    seen = []

    async def notebook():
        move = OnMain(lambda value: seen.append((value, threading.get_ident())))
        other = threading.Thread(target=lambda: [move(k) for k in range(10_000)])
        other.start()
        other.join()
        await asyncio.sleep(0.05)
        move(-1)

    asyncio.run(notebook())
    assert {thread for _, thread in seen} == {threading.get_ident()}
    assert [value for value, _ in seen] == [9_999, -1]


def test_callbacks_go_on_after_one_of_them_has_failed():
    seen = []

    def fragile(value):
        if value == 1:
            raise ValueError("one")
        seen.append(value)

    async def notebook():
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: seen.append(str(context["exception"])))
        move = OnMain(fragile)
        for value in (1, 2):
            thread = threading.Thread(target=move, args=(value,))
            thread.start()
            thread.join()
            await asyncio.sleep(0.01)

    asyncio.run(notebook())
    assert seen == ["one", 2]
