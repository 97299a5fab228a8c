"""The first lesson in a real JupyterLab: it runs, a slider is dragged, the hand moves and nothing else does."""

import io
import os
import socket
import subprocess
import time
import urllib.request
from pathlib import Path

import numpy as np
import pytest

from handlab.show import lab

ROOT = Path(__file__).parents[2]
PATIENCE = 45_000  # milliseconds: two busy cores
TOKEN = "lesson"
pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@pytest.fixture(scope="module")
def jupyter(chromium, tmp_path_factory):
    """JupyterLab as ``handlab lab`` starts it, with settings of its own; its address."""
    pytest.importorskip("jupyterlab")
    place = tmp_path_factory.mktemp("lab")
    lab.copy_lessons(place / "lessons")
    settings = place / "settings" / "@jupyterlab" / "notebook-extension"
    settings.mkdir(parents=True)
    # All cells in the page, not only those in view: otherwise a test would have to scroll to see that the last one has run.
    (settings / "tracker.jupyterlab-settings").write_text('{"windowingMode": "none"}')
    port = free_port()
    environment = {key: value for key, value in os.environ.items() if key != "HANDLAB_STRICT"}
    environment |= {f"JUPYTER_{kind}_DIR": str(place / kind) for kind in ("CONFIG", "DATA", "RUNTIME")}
    environment |= {
        "JUPYTERLAB_WORKSPACES_DIR": str(place / "workspaces"),
        "JUPYTERLAB_SETTINGS_DIR": str(place / "settings"),
        "JUPYTER_TOKEN": TOKEN,
        "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep),
    }
    line = lab.command(place / "lessons", browser=False, port=port)
    with (place / "log.txt").open("w") as log:
        process = subprocess.Popen(line, cwd=place, env=environment, stdout=log, stderr=subprocess.STDOUT)
        try:
            address = f"http://127.0.0.1:{port}"
            for _ in range(300):
                assert process.poll() is None, (place / "log.txt").read_text()
                try:
                    urllib.request.urlopen(f"{address}/api?token={TOKEN}", timeout=1).close()
                    break
                except OSError:
                    time.sleep(0.2)
            yield address
        finally:
            process.terminate()
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()


@pytest.fixture(scope="module")
def ran(chromium, jupyter):
    """The student form of lesson 00 after Run All: the page, and the addresses outside this computer that it asked for."""
    context = chromium.new_context(viewport={"width": 1500, "height": 1000})
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    outside = []
    page.on("request", lambda request: outside.append(request.url) if outward(request.url) else None)
    page.goto(f"{jupyter}/lab/tree/00_meet_the_hand.ipynb?token={TOKEN}")
    page.wait_for_selector(".jp-Notebook .jp-Cell >> nth=0")
    page.wait_for_selector('.jp-Notebook-ExecutionIndicator[data-status="idle"]')
    page.get_by_text("| Idle").wait_for()  # without a kernel, Run All asks for one
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_text("Run All Cells", exact=True).click()
    page.get_by_text("exercises of lesson 00 are done").wait_for(state="attached")
    yield page, outside
    context.close()


def outward(address):
    return address.startswith(("http", "ws")) and "//127.0.0.1" not in address


def panel_of(page):
    """The slider panel: its handle for FDP2 in view, at rest."""
    page.locator(".noUi-handle").first.scroll_into_view_if_needed()
    page.get_by_role("button", name="Relax").click()
    page.get_by_text("no joint has moved").wait_for()
    return page.locator(".jp-OutputArea-output", has=page.locator(".noUi-handle")).first


def seen(page, area):
    """The pixels of the hand in the panel (height, width, 3)."""
    from PIL import Image

    picture = area.locator("img, canvas").first
    picture.scroll_into_view_if_needed()
    page.wait_for_timeout(300)
    return np.asarray(Image.open(io.BytesIO(picture.screenshot())).convert("RGB")).astype(int)


def test_the_lesson_runs_and_shows_the_only_error_that_it_means_to_show(ran):
    page, _ = ran
    text = page.evaluate("() => [...document.querySelectorAll('.jp-OutputArea-output')].map((o) => o.innerText).join('\\n')")
    assert "not answered yet" in text
    errors = page.locator(
        '.jp-OutputArea-output[data-mime-type="application/vnd.jupyter.stderr"], .jp-RenderedText[data-mime-type*="error"]'
    )
    shown = [errors.nth(k).inner_text() for k in range(errors.count())]
    assert all("90 rad; its limits" in one for one in shown), shown


def test_nothing_is_fetched_from_outside(ran):
    _, outside = ran
    assert not outside


def test_dragging_a_slider_moves_the_finger_and_leaves_the_background_alone(ran):
    page, _ = ran
    area = panel_of(page)
    before = seen(page, area)
    handle = area.locator(".noUi-handle").first
    handle.scroll_into_view_if_needed()
    box, track = handle.bounding_box(), area.locator(".noUi-target").first.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 0.3 * track["width"], y, steps=12)
    page.mouse.up()
    area.get_by_text("pip2.flexion_extension").wait_for()
    after = seen(page, area)
    text = area.inner_text()
    assert "mcp2.flexion_extension" in text
    assert not any(f"{joint}{digit}." in text for joint in ("mcp", "pip", "dip") for digit in (3, 4, 5)), "one slider moves one finger"
    assert before.shape == after.shape
    changed = np.abs(after - before).max(axis=2) > 40
    assert 0.002 < changed.mean() < 0.25, "noise would change everything, a standing picture nothing"
    edge = np.concatenate([changed[:6].ravel(), changed[:, :6].ravel()])
    assert edge.mean() < 0.01


def test_a_burst_of_slider_moves_ends_where_the_slider_is(ran):
    page, _ = ran
    area = panel_of(page)
    handle = area.locator(".noUi-handle").first
    handle.focus()
    for _ in range(30):
        page.keyboard.press("ArrowRight")
    area.get_by_text("pip2.flexion_extension").wait_for()
    page.wait_for_timeout(2000)
    reading = float(area.locator(".widget-readout").first.inner_text())
    assert reading > 0.05
    shown = area.inner_text()
    page.wait_for_timeout(1000)
    assert area.inner_text() == shown, "nothing moves any more when nobody moves a slider"
