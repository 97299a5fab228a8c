"""A real browser, and a host for the viewer that is nothing but a session: the page asks, the test process answers."""

import base64

import numpy as np
import pytest

import handlab as hl
from handlab.show.module import viewer_module
from handlab.show.session import Session

PATIENCE_MS = 60_000
SIZE = {"width": 1440, "height": 900}
PAGE = """<!DOCTYPE html><meta charset="utf-8"><link rel="icon" href="data:,">
<style>body { margin: 0 } #hand { height: 100vh }</style>
<div id="hand"></div>
<script type="module">
%s
const listeners = new Set();
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const opened = ({ frame, data, ...reply }) => (frame ? bytes(frame) : data ? { ...reply, data: bytes(data) } : reply);
const deliver = (told) => listeners.forEach((f) => f(opened(told)));
const transport = {
  ticks: "client",
  scene: window.askHost({ kind: "hello" }).then(([first]) => bytes(first.scene)),
  send: (message) => { window.askHost(message).then((told) => told.forEach(deliver)); },
  onMessage: (f) => { listeners.add(f); return () => listeners.delete(f); },
};
window.handlab = await mount(document.getElementById("hand"), transport, %s);
</script>"""


@pytest.fixture(scope="session")
def hand():
    return hl.load_hand()


@pytest.fixture
def tab(chromium):
    """An empty page; nothing may go wrong in it, and it may ask nobody outside."""
    context = chromium.new_context(viewport=SIZE, accept_downloads=True)
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    trouble = []
    page.on("console", lambda message: message.type in ("error", "warning") and trouble.append(f"console: {message.text}"))
    page.on("pageerror", lambda error: trouble.append(f"error: {error}"))
    page.on("request", lambda request: request.url.startswith(("file:", "data:", "blob:", "about:")) or trouble.append(request.url))
    yield page
    context.close()
    # Reading pixels back is what tests do, and slow is what they may be.
    assert [one for one in trouble if "GPU stall due to ReadPixels" not in one] == []


class Live:
    """A page with a live hand: ``page``, ``session``; ``ticks`` counts what the page asked for, ``told`` what it was told."""

    def __init__(self, page, session):
        self.page, self.session = page, session
        self.ticks, self.told, self.sent = 0, [], []

    def ask(self, message):
        if message["kind"] == "hello":
            return [{"scene": encoded(self.session.scene())}]
        if message["kind"] == "tick":
            self.ticks += 1
            frame = self.session.tick(1 / 60)
            told = [{"kind": "tock"}] if frame is None else [{"frame": encoded(frame)}]
        else:
            self.sent.append(message)
            self.session.message(message)
            told = []
        replies = self.session.replies()
        self.told += replies
        return [{**reply, "data": encoded(reply["data"])} if "data" in reply else reply for reply in replies] + told

    def settled(self):
        """Wait until the hand is still and drawn sharply."""
        self.page.wait_for_timeout(300)
        self.page.wait_for_function("handlab.frame() && !handlab.frame().moving")
        self.page.wait_for_timeout(600)

    def seen(self):
        """What the stage shows, without what lies over it: (height, width, 3)."""
        return picture(self.page)


def encoded(data):
    return base64.b64encode(data).decode()


def picture(page, handle="handlab"):
    """The hand's canvas as an array of 0 to 255: (height, width, 3)."""
    width, height, text = page.evaluate(
        """async (name) => {
          const hand = name.split('.').reduce((o, key) => o[key], window).hand;
          hand.draw(true);
          const { gl, canvas: { width, height } } = hand, pixels = new Uint8Array(4 * width * height);
          gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
          let text = '';
          for (let k = 0; k < pixels.length; k += 32768) text += String.fromCharCode(...pixels.subarray(k, k + 32768));
          return [width, height, btoa(text)];
        }""",
        handle,
    )
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)[::-1, :, :3]


@pytest.fixture
def live(tab, hand):
    """Open the viewer on a session."""

    def start(session=None, options="{}"):
        host = Live(tab, session or Session(hand))
        tab.expose_function("askHost", host.ask)
        tab.set_content(PAGE % (viewer_module(exports=False), options))
        tab.wait_for_function("window.handlab && handlab.stats.first_ms > 0")
        host.settled()
        return host

    return start
