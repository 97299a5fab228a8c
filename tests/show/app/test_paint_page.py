"""The page "Paint a muscle" of the app in a real browser, with a real mouse: painted, fitted, saved, used; and what goes wrong."""

import http.client
import json

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.grids import load_grid

SIZE = {"width": 1280, "height": 720}  # a projector
PATIENCE = 60_000.0  # ms
pytestmark = pytest.mark.xdist_group("browser")
ACROSS = np.array([-0.6, 0.0, 0.8])  # the fibres of the short flexor of the thumb


@pytest.fixture(scope="module")
def wanted():
    """Nine places (3, 3, 3) on the thenar, from the carpus along the first metacarpal to the base of the proximal phalanx."""
    from handlab.simulation.grid_rows import skin_over

    hand = hl.load_hand()
    middle = {name: bone.points.mean(axis=0) for name, bone in hand.bones.items()}
    phalanx = hand.bones["proximal_phalanx_1"].points
    base = phalanx[phalanx[:, 0].argsort()[:50]].mean(axis=0)
    rows = [
        (0.5 * (middle["trapezium"] + middle["capitate"]), 4e-3),
        (middle["metacarpal_1"] + np.array([4e-3, 0, -12e-3]), 6e-3),
        (base + np.array([3e-3, 0, -3e-3]), 4e-3),
    ]
    return skin_over(hand, [[at + k * half * ACROSS for k in (-1, 0, 1)] for at, half in rows])


class User:
    """Someone at the page, with a mouse."""

    def __init__(self, page):
        self.page = page

    def place(self, point):
        box = self.page.locator(".hp-stage").bounding_box()
        x, y = self.page.evaluate("(p) => handlabPaint.onScreen(p)", [float(value) for value in point])
        return box["x"] + x, box["y"] + y

    def nearer(self, point):
        self.page.mouse.move(*self.place(point))
        self.page.mouse.wheel(0, -300)
        self.page.mouse.wheel(0, -300)
        self.page.wait_for_function("handlabPaint.hand.distance < 0.85")

    def click(self, points):
        for point in np.reshape(points, (-1, 3)):
            self.page.mouse.click(*self.place(point))
        self.settled()

    def fill(self, label, text):
        self.page.fill(f"[aria-label='{label}']", text)
        self.page.keyboard.press("Tab")
        self.settled()

    def settled(self):
        self.page.wait_for_function("!handlabPaint.sending")

    @property
    def points(self):
        return np.reshape(self.page.evaluate("handlabPaint.points"), (-1, 3))

    @property
    def told(self):
        return self.page.inner_text(".hp-say") if self.page.is_visible(".hp-say") else ""


@pytest.fixture
def context(chromium):
    made = chromium.new_context(viewport=SIZE, accept_downloads=True)
    made.set_default_timeout(PATIENCE)
    yield made
    made.close()


@pytest.fixture
def tab(context):
    """Open a page of a server at "Paint a muscle"; what went wrong in it must be nothing."""
    trouble = []

    def fresh(served):
        page = context.new_page()
        page.on("pageerror", lambda error: trouble.append(f"error: {error}"))
        page.on("console", lambda message: message.type == "error" and "status of 40" not in message.text and trouble.append(message.text))
        page.goto(served.address)
        page.wait_for_function("window.handlab && handlab.stats.first_ms > 0")
        page.click("[data-act=paint-muscle]")
        page.wait_for_function("window.handlabPaint?.told")
        return User(page)

    yield fresh
    assert trouble == []


@pytest.fixture
def user(tab, served):
    return tab(served)


@pytest.fixture
def painted(user, wanted):
    """A user whose nine clicks have become a muscle."""
    user.nearer(wanted[1, 1])
    user.click(wanted)
    user.page.wait_for_function("handlabPaint.told.muscle")
    return user


def test_nine_clicks_on_the_thenar_become_a_muscle_that_swells_on_the_live_hand(painted, wanted, tmp_path, serve, capsys):
    page = painted.page
    assert np.linalg.norm(painted.points - wanted.reshape(-1, 3), axis=1).max() < 1e-3, "a pixel is less than a third of a millimetre"
    page.select_option("[aria-label='divide rows by']", "3")
    painted.settled()
    page.select_option("[aria-label='divide rows by']", "2")
    painted.settled()
    stats = page.evaluate("handlabPaint.stats")
    with capsys.disabled():
        print(f"  change to fit: {stats['latency_ms'][-1]:.0f} ms, of these in the host {stats['server_ms'][-1]:.0f}", end=" ")
    assert stats["latency_ms"][-1] < 1000.0
    assert 20.0 < float(page.inner_text(".hp-facts span >> nth=0").split()[0]) < 70.0
    assert page.locator(".hp-bones select option:checked").all_inner_texts() == [
        f"nearest: {' + '.join(row)}".replace("_", " ") for row in page.evaluate("handlabPaint.told.carriers")
    ]
    assert page.evaluate("document.querySelector('.hp svg .dots:not(.casing)').getAttribute('d').split('M').length") > 4
    page.fill(".hp-side input[type=text] >> nth=0", "my flexor")
    with page.expect_download() as download:
        page.click("[data-act=save]")
    file = tmp_path / download.value.suggested_filename
    download.value.save_as(file)
    grid = load_grid(file)
    assert (file.name, grid.drives, grid.triangle.shape) == ("my_flexor.json", ("flexor_pollicis_brevis",), (5, 3))

    page.click("[data-act=use]")
    page.wait_for_selector("#handlab-paint", state="detached")
    page.wait_for_function("handlab.hand.flesh?.layers.muscles.some(({ name }) => name === 'my_flexor')")
    page.wait_for_function("handlab.hand.fleshShown()[1] > 0 && handlab.status().soft")
    assert page.locator(".hl-row[data-muscle=FPB] input").is_visible()
    belly = """() => { const { hand } = handlab, m = hand.flesh.layers.muscles.find(({ name }) => name === 'my_flexor');
      const all = m.segments * m.fibres;
      return Math.max(...Array.from({ length: all }, (_, s) => hand.segments[10 * (m.segment + s) + 9])); }"""
    before, angle = page.evaluate(belly), np.array(page.evaluate("Array.from(handlab.frame().angle)"))
    slider = page.locator(".hl-row[data-muscle=FPB] input").bounding_box()
    page.mouse.click(slider["x"] + 0.98 * slider["width"], slider["y"] + 0.5 * slider["height"])
    page.wait_for_function("handlab.frame().contraction.some((value) => value > 0.9)")
    page.wait_for_function("!handlab.frame().moving")
    assert page.evaluate(belly) > 1.05 * before, "it bulges with the slider of its pseudo muscle"
    assert np.abs(np.array(page.evaluate("Array.from(handlab.frame().angle)")) - angle).max() > 0.2, "and the thumb moves"


def test_a_reload_in_the_middle_loses_no_click(painted, wanted):
    before = painted.points
    painted.fill("greatest thickness in millimetres", "5")
    painted.page.reload()
    painted.page.wait_for_function("window.handlab && handlab.stats.first_ms > 0")
    painted.page.click("[data-act=paint-muscle]")
    painted.page.wait_for_function("window.handlabPaint?.told?.muscle")
    np.testing.assert_array_equal(painted.points, before)
    assert painted.page.input_value("[aria-label^=greatest]") == "5"


def test_what_can_be_no_muscle_is_told_in_plain_words_and_every_click_stays(painted, wanted):
    page, points = painted.page, painted.points
    for label, text, word in (
        ("least thickness in millimetres", "0", "0 < least"),
        ("greatest thickness in millimetres", "900", "30 mm"),
        ("greatest thickness in millimetres", "", "two numbers"),
    ):
        kept = page.input_value(f"[aria-label='{label}']")
        painted.fill(label, text)
        assert word in painted.told
        assert page.locator(f"[aria-label='{label}'][aria-invalid=true]").count() == 1
        page.click("[data-act=use]")
        page.wait_for_timeout(100)
        assert page.query_selector("#handlab-paint"), "nothing half-made is used"
        painted.fill(label, kept)
        assert painted.told == ""
        np.testing.assert_array_equal(painted.points, points)
    page.click("[data-act=clear]")
    painted.settled()
    page.click("[data-act=use]")
    page.wait_for_selector(".hp-say:not([hidden])")
    assert "6 more clicks" in painted.told
    painted.click(wanted[1])  # the rows in the wrong order cross
    painted.click(wanted[0])
    painted.click(wanted[2])
    page.wait_for_selector(".hp-say:not([hidden])")
    assert "crosses itself" in painted.told
    assert "nothing is lost" in painted.told
    assert len(painted.points) == 9
    for _ in range(10):
        page.click("[data-act=undo]")
    painted.settled()
    np.testing.assert_array_equal(painted.points, points)
    assert painted.told == ""


def test_a_grid_over_the_cut_of_the_forearm_is_told(user, wanted):
    page = user.page
    low = page.evaluate("Math.min(...handlabPaint.hand.coarse.filter((_, k) => k % 3 === 0))")
    end = page.evaluate("(low) => { const P = handlabPaint.hand.coarse, all = []; for (let v = 0; v < P.length; v += 3)"
                        " if (P[v] < low + 1e-4) all.push([P[v], P[v + 1], P[v + 2]]); return all; }", low)  # fmt: skip
    middle = np.mean(end, axis=0)
    page.focus(".hp-stage")
    for _ in range(14):
        page.keyboard.press("ArrowUp")  # looks up the forearm
    assert page.evaluate("handlabPaint.hand.eye[0]") < -0.8
    page.select_option("[aria-label='points in a row']", "2")
    user.click(middle + 0.008 * np.array([[0, -1, -1], [0, -1, 1], [0, 1, -1], [0, 1, 1]]))
    assert len(user.points) == 4
    assert "cut of the forearm" in user.told


def test_the_layout_holds_on_a_projector_a_telephone_and_a_large_wall(painted):
    page = painted.page
    for width, height in ((1280, 720), (760, 560), (700, 900), (390, 800), (1920, 1080)):
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(150)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert page.evaluate("(() => { const s = document.querySelector('.hp-side'); return s.scrollWidth <= s.clientWidth; })()")
        stage = page.locator(".hp-stage").bounding_box()
        assert stage["width"] >= 0.55 * width
        assert stage["height"] >= 0.38 * height
        for act in ("undo", "save", "use", "close"):
            box = page.locator(f".hp [data-act={act}]").bounding_box()
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= width
            assert box["y"] >= 0
            assert box["y"] + box["height"] <= height, (act, width, height)


def test_the_page_s_address_is_guarded_as_all_others(served, user):
    def posted(word, body, **headers):
        line = http.client.HTTPConnection(served.host, served.port, timeout=60)
        try:
            line.request(
                "POST", f"/handlab/data/paint/{word}", body, {"X-Handlab-Key": served.key, "Content-Type": "application/json", **headers}
            )
            answer = line.getresponse()
            return answer.status, answer.read()
        finally:
            line.close()

    hello = json.dumps({"kind": "hello"})
    assert posted("some-tab-word", hello)[0] == 200
    assert posted("some-tab-word", hello, **{"X-Handlab-Key": "wrong"})[0] == 403
    assert posted("some-tab-word", hello, Origin="https://evil.example")[0] == 403
    assert posted("some-tab-word", hello, Host=f"evil.example:{served.port}")[0] == 403
    assert posted("..%2f..%2fetc", hello)[0] == 404
    assert posted("some-tab-word", b"{not json")[0] == 400
    assert posted("some-tab-word", b" " * 4_100_000)[0] == 413
    for message in (
        [],
        {"kind": "paint", "points": [[1, 2, 3]]},
        {"kind": "use"},
        {"kind": "save", "folder": "/etc"},
        {"kind": "paint", "have": []},
    ):
        status, said = posted("some-tab-word", json.dumps(message))
        assert (status, json.loads(said)["good"]) == (200, False), message
    for other in range(6):  # more tabs than rooms: the first finds its own again
        assert posted(f"another-tab-{other}", hello)[0] == 200
    user.page.mouse.click(*user.place([0.05, 0.035, 0.0]))
    user.settled()
    assert user.told == ""
    assert served.alive()
