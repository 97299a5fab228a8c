"""The fitting panel of a notebook in a real browser: its page, and the real panel behind it."""

import base64
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("anywidget")
from handlab.show.fit_panel import FitPanel
from handlab.show.fit_words import ORDER

sys.path.insert(0, str(Path(__file__).parents[2] / "fitting"))  # for people.py and photograph.py
import people
import photograph

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]
PAGE = """<!DOCTYPE html><meta charset="utf-8"><link rel="icon" href="data:,"><body style="margin:20px"><div id="box"></div>
<script type="module">
%s
const listeners = new Set(), text = (part) => btoa(Array.from(new Uint8Array(part), (byte) => String.fromCharCode(byte)).join(""));
const model = {
  get: () => 640, on: (_, f) => listeners.add(f), off: (_, f) => listeners.delete(f),
  send: (message, _, buffers) => window.askHost(message, buffers.map(text)).then((all) => all.forEach(window.tell)),
};
window.tell = (told) => listeners.forEach((f) => f(told));
widget.render({ model, el: document.getElementById("box") });
</script>"""


@pytest.fixture(scope="module")
def shot():
    return photograph.photograph(people.everyone()["girl"], view="palmar", ground="dark")


@pytest.fixture
def opened(chromium, shot, tmp_path, monkeypatch):
    """A panel, and the page that shows it."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(shot.pixels).save(tmp_path / "girl.png")
    panel, told, errors = FitPanel(), [], []
    panel.page.widget.send = lambda content, buffers=None: told.append(content)

    def ask(message, buffers):
        told.clear()
        panel.page.hear(None, message, [base64.b64decode(part) for part in buffers])
        return list(told)

    page = chromium.new_page(viewport={"width": 1100, "height": 720})
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.expose_function("askHost", ask)
    module = panel.page.widget._esm.replace("export default", "const widget =")
    assert "const widget =" in module
    page.route("http://fit.test/", lambda route: route.fulfill(body=PAGE % module, content_type="text/html"))
    page.goto("http://fit.test/")
    page.wait_for_selector(".hf-welcome")
    yield page, panel
    page.close()
    assert not errors


def point(page, shot, place):
    box = page.locator(".hf-stage > img").bounding_box()
    scale = box["width"] / shot.pixels.shape[1]
    page.mouse.click(box["x"] + place[0] * scale, box["y"] + place[1] * scale)


def test_a_picture_dropped_on_the_panel_becomes_panel_hand_by_clicks(opened, shot, tmp_path):
    page, panel = opened
    page.set_input_files(".hf > input[accept*=heic]", tmp_path / "girl.png")
    page.click(".hf-choice[data-view=palmar]")
    for place in shot.ruler:
        point(page, shot, place)
    page.wait_for_function("document.activeElement?.dataset.mm !== undefined")
    page.keyboard.type("150")
    page.keyboard.press("Enter")
    for name in (*ORDER[:13], *ORDER[14:]):
        page.wait_for_selector(f".hf-drawing circle.now[data-point={name}]", state="attached")
        point(page, shot, shot.marks[name])
        if name == ORDER[12]:  # code and page speak of the same clicks
            page.wait_for_function("!document.getElementById('box').firstChild.fit.sending")
            panel.set(landmarks={ORDER[13]: tuple(shot.marks[ORDER[13]])})
            page.evaluate("told => tell({kind: 'changed', told})", panel.clicks.to_json())
    page.wait_for_selector("[data-act=move]")
    assert panel.hand.side == "right"
    true = people.everyone()["girl"].lengths_mm
    shown = [float(text) for text in page.locator(".hf tbody tr").nth(2).locator("b").all_inner_texts()]
    assert abs(sum(shown[1:]) - sum(true[bone] for bone in (("mcp3", "pip3"), ("pip3", "dip3"), ("dip3", "tip3")))) < 4.0
    assert (tmp_path / "girl.points.json").is_file()
    assert np.abs(np.array(panel.landmarks["tip_index"]) - shot.marks["tip_index"]).max() < 2.0
    page.click("[data-act=move]")
    page.wait_for_selector(".hf-say:not([hidden])")
    assert "panel.hand" in page.inner_text(".hf-say")
    assert panel.view is not None
