"""The paint panel of a notebook in a real browser: clicks, drags, the wheel and keys, answered by a real panel."""

import numpy as np
import pytest

pytest.importorskip("anywidget")
from handlab.anatomy.grids import load_grids
from handlab.show.paint_panel import PaintPanel

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]
PAGE = """<!DOCTYPE html><meta charset="utf-8"><link rel="icon" href="data:,"><body style="margin:0"><div id="box"></div>
<script type="module">
%s
const listeners = new Set();
let busy = null; // answers that a test holds back
window.hold = () => { busy = []; };
window.release = () => { const kept = busy; busy = null; kept.forEach(window.tell); };
const model = {
  get: () => 640, on: (_, f) => listeners.add(f), off: (_, f) => listeners.delete(f),
  send: (message) => window.askHost(message).then((all) => all.forEach((one) => (busy ? busy.push(one) : window.tell(one)))),
};
window.tell = (told) => listeners.forEach((f) => f(told));
widget.render({ model, el: document.getElementById("box") });
</script>"""


class User:
    """Someone at the page of ``panel``."""

    def __init__(self, page, panel):
        self.page, self.panel = page, panel
        self.ask = lambda expression, *given: page.evaluate(f"(given) => document.querySelector('#box > div').paint.{expression}", *given)

    def place(self, point):
        """Where a point of the skin is on the page."""
        box = self.page.locator(".hp-stage").bounding_box()
        x, y = self.ask("onScreen(given)", list(map(float, point)))
        return box["x"] + x, box["y"] + y

    def click(self, points):
        for point in np.reshape(points, (-1, 3)):
            self.page.mouse.click(*self.place(point))

    def settled(self, condition="true"):
        self.page.wait_for_function(
            f"() => {{ const p = document.querySelector('#box > div').paint; return !p.sending && ({condition}); }}"
        )

    def drag(self, start, end, steps=6):
        self.page.mouse.move(*start)
        self.page.mouse.down()
        self.page.mouse.move(*end, steps=steps)
        self.page.mouse.up()
        self.settled()


@pytest.fixture
def user(chromium, hand):
    panel, told, errors = PaintPanel(hand, "painted", "FPB", columns=2), [], []
    panel.page.widget.send = lambda content, buffers=None: told.append(content)

    def ask(message):
        told.clear()
        panel.page.hear(None, message, [])
        return list(told)

    page = chromium.new_page(viewport={"width": 1100, "height": 700})
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.expose_function("askHost", ask)
    module = panel.page.widget._esm.replace("export default", "const widget =")
    page.route("http://paint.test/", lambda route: route.fulfill(body=PAGE % module, content_type="text/html"))
    page.goto("http://paint.test/")
    page.wait_for_function("document.querySelector('#box > div')?.paint?.hand.drawn > 0")
    made = User(page, panel)
    made.told = told
    yield made
    page.close()
    assert not errors


@pytest.fixture(scope="module")
def wanted(hand):
    grid = next(grid for grid in load_grids() if grid.name == "flexor_pollicis_brevis")
    return grid.points_on(hand.skin, hand.skin.points, hand.side)[1::2][:, ::2].reshape(-1, 3)


def off(user, wanted):
    return np.linalg.norm(user.panel.painting.points - wanted, axis=1).max()


def test_clicks_become_points_where_they_were_made_and_the_muscle_appears(user, wanted):
    user.click(wanted)
    user.settled("p.told.muscle")
    assert off(user, wanted) < 1e-4
    assert user.panel.grid.triangle.shape == (5, 2)
    user.page.wait_for_function("document.querySelectorAll('svg circle').length === 6")  # drawn with the next picture
    assert user.page.locator("svg text").all_text_contents() == ["row 1", "row 2", "row 3"]
    assert user.ask("hand.fleshShown()")[1] > 0
    assert "fitted in" in user.page.inner_text(".hp-facts")
    assert "The muscle is there" in user.page.inner_text(".hp-guide")


def test_no_click_of_a_fast_hand_is_lost_while_the_kernel_is_busy(user, wanted):
    user.page.evaluate("window.hold()")
    user.click(wanted)
    user.page.wait_for_function("document.querySelectorAll('svg circle').length === 6")  # shown at once
    user.page.wait_for_timeout(300)
    assert len(user.panel.painting.points) == 1, "one message is on its way"
    user.page.evaluate("window.release()")
    user.settled("p.told.muscle")
    assert off(user, wanted) < 1e-4


def test_dragging_beside_the_points_turns_the_hand_and_adds_none(user, wanted):
    user.click(wanted[2])
    user.settled()
    before = np.array(user.ask("hand.eye"))
    user.drag((60, 200), (120, 230))
    assert 0.2 < np.arccos(np.clip(before @ user.ask("hand.eye"), -1, 1)) < 1.2
    assert off(user, wanted[2:3]) < 1e-4


def test_a_point_is_dragged_in_one_step_and_undone_with_a_key(user, wanted):
    user.click(wanted)
    user.settled("p.told.muscle")
    target = 0.7 * wanted[5] + 0.3 * wanted[3]
    user.drag(user.place(wanted[5]), user.place(target), steps=9)
    moved = user.panel.painting.points
    assert np.linalg.norm(moved[5] - wanted[5]) > 2e-3
    np.testing.assert_allclose(moved[:5], wanted[:5], atol=1e-4)
    user.page.keyboard.press("Backspace")
    user.settled()
    assert off(user, wanted) < 1e-4
    user.panel.undo()  # code goes on where the page has stopped
    assert len(user.panel.painting.points) == 5


def test_the_wheel_goes_nearer_where_the_pointer_is_and_a_click_then_means_the_new_picture(user, wanted):
    far = user.ask("hand.distance")
    there = user.place(wanted[2])
    user.page.mouse.move(*there)
    user.page.mouse.wheel(0, -500)
    user.page.wait_for_timeout(100)
    assert 0.3 * far < user.ask("hand.distance") < 0.8 * far
    assert np.linalg.norm(np.subtract(user.place(wanted[2]), there)) < 12, "exact in the plane of the middle, near it elsewhere"
    user.click(wanted[2])
    user.settled()
    assert off(user, wanted[2:3]) < 1e-4


def test_a_click_beside_the_hand_or_on_a_point_says_so_and_changes_nothing(user, wanted):
    user.page.mouse.click(40, 400)
    assert "beside the hand" in user.page.inner_text(".hp-say")
    user.click(wanted[0])
    assert not user.page.is_visible(".hp-say")
    user.click(wanted[0])
    assert "A point is there already" in user.page.inner_text(".hp-say")
    assert user.ask("points.length") == 1


def test_what_code_changes_shows_in_the_page(user, wanted):
    user.told.clear()
    user.panel.add(wanted)
    user.panel.set(skin="mesh", contraction=0.5, thickness_mm=(1, 20), skin_distance_mm=(6, 3, 2))
    for one in user.told:
        user.page.evaluate("(told) => window.tell(told)", one)
    user.page.wait_for_function("document.querySelectorAll('svg circle').length === 6 && document.querySelector('svg .wires')")
    assert user.page.input_value("[aria-label^='skin distance']") == "6, 3, 2"
    assert user.page.input_value("[aria-label*='greatest']") == "20"
    assert user.page.locator(".hp-bones select").count() == 3
    user.page.keyboard.press("Tab")
    user.ask("undo()")
    user.settled()
    assert len(user.panel.painting.points) == 0, "what code did can be taken back in the page"
