"""The picture of the paint panel in a real browser: clicks, drags, the wheel and keys, answered by a real panel."""

import base64

import numpy as np
import pytest

pytest.importorskip("anywidget")
from handlab.show.module import STATIC
from handlab.show.paint_panel import PaintPanel

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]
PAGE = """<!DOCTYPE html><meta charset="utf-8"><link rel="icon" href="data:,"><body style="margin:20px"><div id="box"></div>
<script type="module">
%s
const listeners = new Set();
const opened = ([message, data]) => [message, [Uint8Array.from(atob(data), (c) => c.charCodeAt(0)).buffer]];
let busy = null; // answers that a test holds back
window.hold = () => { busy = []; };
window.release = () => { const kept = busy; busy = null; kept.forEach((told) => listeners.forEach((f) => f(...opened(told)))); };
const model = {
  get: (name) => ({ width: 560, height: 640 })[name],
  on: (_, f) => listeners.add(f), off: (_, f) => listeners.delete(f),
  send: (message) => window.askHost(message).then((told) => told.forEach((one) => (busy ? busy.push(one)
    : listeners.forEach((f) => f(...opened(one)))))),
};
render({ model, el: document.getElementById("box") });
</script>"""


class Host:
    """A panel behind a page: what the page sends goes to the panel, what the panel sends goes back."""

    def __init__(self, hand):
        self.panel = PaintPanel(hand, "painted", "FPB", columns=2, finer=2)
        self.heard, self.told = [], []
        self.panel.canvas_widget.send = lambda content, buffers: self.told.append((content, base64.b64encode(buffers[0]).decode()))
        self.panel._refresh = self.panel._send

    def ask(self, message):
        self.heard.append(message)
        self.told.clear()
        self.panel._hear(None, message, [])
        return list(self.told)


@pytest.fixture
def opened(chromium, hand):
    host, errors = Host(hand), []
    page = chromium.new_page(viewport={"width": 700, "height": 720})
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.expose_function("askHost", host.ask)
    page.route("http://paint.test/", lambda route: route.fulfill(body=PAGE % (STATIC / "paint.js").read_text(), content_type="text/html"))
    page.goto("http://paint.test/")
    page.wait_for_function("document.querySelector('img')?.naturalWidth > 0")
    yield page, host
    page.close()
    assert not errors


def place(page, host, point):
    """Where a point of the skin is on the page."""
    box = page.locator(".hl-paint").bounding_box()
    (x, y), seen = (found[0] for found in host.panel.canvas.places(point))
    assert seen
    return box["x"] + x * box["width"], box["y"] + y * box["height"]


def thenar(hand):
    from handlab.anatomy.grids import load_grids

    grid = next(grid for grid in load_grids() if grid.name == "flexor_pollicis_brevis")
    return grid.points_on(hand.skin, hand.skin.points, hand.side)[1::2][:, ::2].reshape(-1, 3)


def test_clicks_become_points_where_they_were_made_and_the_muscle_appears(opened, hand):
    page, host = opened
    wanted = thenar(hand)
    for point in wanted:
        page.mouse.click(*place(page, host, point))
    page.wait_for_function("document.querySelectorAll('circle').length === 6 && document.querySelectorAll('text').length === 3")
    assert np.linalg.norm(host.panel.painting.points - wanted, axis=1).max() < 1.5e-3
    assert host.panel.problem is None
    assert host.panel.painting.result is not None


def test_no_click_of_a_fast_hand_is_lost_while_the_kernel_is_busy(opened, hand):
    page, host = opened
    wanted = thenar(hand)
    page.evaluate("window.hold()")
    for point in wanted:
        page.mouse.click(*place(page, host, point))
    page.wait_for_function("document.querySelectorAll('circle[fill=none]').length === 6")  # shown at once, hollow
    page.wait_for_timeout(300)
    assert len(host.panel.painting.points) == 6
    page.evaluate("window.release()")
    page.wait_for_function("document.querySelectorAll('text').length === 3")
    assert np.linalg.norm(host.panel.painting.points - wanted, axis=1).max() < 1.5e-3


def test_dragging_beside_the_points_turns_the_hand_and_adds_none(opened, hand):
    page, host = opened
    page.mouse.click(*place(page, host, thenar(hand)[2]))
    page.wait_for_function("document.querySelectorAll('circle').length === 1")
    before, first = host.panel.canvas.camera, host.panel.painting.points.copy()
    page.mouse.move(60, 60)
    page.mouse.down()
    page.mouse.move(120, 90, steps=6)
    page.mouse.up()
    page.wait_for_timeout(600)
    after = host.panel.canvas.camera
    assert 0.1 < np.arccos(before.to_eye @ after.to_eye) < 0.6
    np.testing.assert_array_equal(host.panel.painting.points, first)


def test_a_point_can_be_dragged_and_undone_with_a_key(opened, hand):
    page, host = opened
    start, end = thenar(hand)[2], thenar(hand)[5]
    page.mouse.click(*place(page, host, start))
    page.wait_for_function("document.querySelectorAll('circle').length === 1")
    page.mouse.move(*place(page, host, start))
    page.mouse.down()
    page.mouse.move(*place(page, host, end), steps=5)
    page.mouse.up()
    page.wait_for_timeout(400)
    assert len(host.panel.painting.points) == 1
    assert np.linalg.norm(host.panel.painting.points[0] - end) < 1.5e-3
    page.keyboard.press("Backspace")
    page.wait_for_timeout(400)
    assert np.linalg.norm(host.panel.painting.points[0] - start) < 1.5e-3


def test_the_wheel_goes_nearer_and_a_click_then_means_the_new_picture(opened, hand):
    page, host = opened
    point = thenar(hand)[2]
    far = host.panel.canvas.camera.distance
    page.mouse.move(*place(page, host, point))
    page.mouse.wheel(0, -500)
    page.wait_for_timeout(500)
    assert 0.3 * far < host.panel.canvas.camera.distance < 0.8 * far
    page.mouse.click(*place(page, host, point))
    page.wait_for_function("document.querySelectorAll('circle').length === 1")
    assert np.linalg.norm(host.panel.painting.points[0] - point) < 1e-3


def test_a_click_in_a_picture_that_is_already_old_means_what_was_seen(opened, hand):
    page, host = opened
    point = thenar(hand)[2]
    at = place(page, host, point)
    page.evaluate("window.hold()")
    host.panel.canvas.turn(0.2, 0.0)
    host.panel._send()  # a newer picture that the page has not seen
    page.mouse.click(*at)
    page.wait_for_timeout(300)
    assert np.linalg.norm(host.panel.painting.points[0] - point) < 1.5e-3
