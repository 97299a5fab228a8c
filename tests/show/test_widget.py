"""The viewer in a notebook, without a notebook: what the page sends, and what the kernel sends back."""

import threading
import time

import numpy as np
import pytest

import handlab as hl

pytest.importorskip("anywidget")
from handlab.show.widget import HandView


class Front:
    """The page's side of a widget."""

    def __init__(self, view):
        self.view, self.got = view, []
        view.widget.send = lambda content, buffers=None: self.got.append((content, buffers or []))

    def sends(self, **message):
        with self.view._lock:  # the soft skin comes on a thread of its own, and no reply may fall between the lists
            self.view._hear(self.view.widget, message, [])
            got, self.got = self.got, []
        return got

    def kinds(self, **message):
        return [content["kind"] for content, _ in self.sends(**message)]


@pytest.fixture
def front(hand):
    return Front(HandView(hand))


def until_dressed(front):
    """Say hello, and wait for the soft skin that comes then: what the view sent meanwhile."""
    got = front.sends(kind="hello")
    if (thread := front.view._preparing) is not None:
        thread.join(60)
    got += front.got
    front.got = []
    return got


def until_still(front):
    for count in range(1000):
        time.sleep(0.01)  # the widget goes by the clock
        if "frame" not in front.kinds(kind="tick"):
            return count
    raise AssertionError("never still")


def test_a_page_that_says_hello_gets_the_scene_and_a_frame(front):
    got = front.sends(kind="hello")
    kinds = [content["kind"] for content, _ in got]
    assert kinds.index("scene") < kinds.index("frame")
    assert len(got[kinds.index("scene")][1][0]) > 100_000
    assert 1000 < len(got[kinds.index("frame")][1][0]) <= 4096


def test_a_resting_hand_answers_a_tick_without_a_frame(front):
    until_dressed(front)
    assert until_still(front) <= 1
    assert front.kinds(kind="tick") == ["tock"]


def test_the_soft_skin_follows_a_hello_by_itself(front):
    got = until_dressed(front)
    frames = [buffers[0] for content, buffers in got if content["kind"] == "frame"]
    assert [content["soft"] for content, _ in got if content["kind"] == "status"][-1] is True
    assert len(frames[0]) <= 4096 and 10_000 < len(frames[-1]) <= 20_000


def test_what_a_slider_sends_moves_the_hand(front, hand):
    front.sends(kind="hello")
    front.sends(kind="set", contraction={"FDP2": 0.6}, n=1)
    k = hand.dof_names.index("dip2.flexion_extension")
    before = front.view.state.angle[k]
    assert until_still(front) > 0
    assert front.view.state.angle[k] > before


def test_messages_on_other_threads_are_all_heeded(front, hand):
    names = [muscle.abbreviation for muscle in hand.muscles.values()][:20]
    threads = [
        threading.Thread(target=lambda name=name: front.view._hear(None, {"kind": "set", "contraction": {name: 0.3}}, [])) for name in names
    ]
    threads += [threading.Thread(target=lambda: [front.view._hear(None, {"kind": "tick"}, []) for _ in range(20)]) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert np.allclose(front.view.session.contraction[:20], 0.3)


def test_python_moves_the_hand_too_and_hears_of_mistakes(front):
    front.view.set(EDC2=0.4)
    assert [content["kind"] for content, _ in front.got][-1] == "frame"
    front.view.hold("wrist")
    front.view.play("fist", loop=True)
    assert front.view.session.playing
    front.view.pause()
    front.view.reset()
    with pytest.raises(ValueError, match="between 0 and 1"):
        front.view.set(EDC2=4)
    with pytest.raises(ValueError, match="did you mean"):
        front.view.play("fits")


def test_a_state_that_is_shown_stays(front, hand):
    state = hl.pose(hand, {"mcp2.flexion_extension": 1.0})
    front.view.show(state)
    front.sends(kind="tick")
    assert front.kinds(kind="tick") == ["tock"]
    assert np.array_equal(front.view.state.angle, state.angle)


def test_an_export_arrives_as_a_file(front):
    arrived = threading.Event()
    front.view.widget.send = lambda content, buffers=None: (
        front.got.append((content, buffers)),
        content["kind"] == "file" and arrived.set(),
    )
    front.view.play("fist")
    front.view._hear(None, {"kind": "export", "format": "csv", "look": {}}, [])
    assert arrived.wait(60)
    content, buffers = next((c, b) for c, b in front.got if c["kind"] == "file")
    assert content["name"] == "fist.csv"
    assert bytes(buffers[0]).startswith(b"time_s,")


def test_nothing_a_page_sends_ends_the_widget(front):
    for message in (None, 3, [], {}, {"kind": None}, {"kind": "set", "contraction": 4}):
        front.view._hear(None, message, [])
    assert front.kinds(kind="hello")
