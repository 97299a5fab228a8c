"""A clip as one page: opened from disk, with the network off."""

import base64
import json
import re
import time

import numpy as np
import pytest

import handlab as hl
from handlab.show.moments import story
from handlab.show.page import MOST_FRAME_BYTES, page
from handlab.simulation.skin import blend, fine_points

MEGABYTE = 1_000_000
HANDLE = "document.getElementById('hand').handlab"


@pytest.fixture(scope="module")
def fist(hand):
    return hl.simulate(hand, "fist")


def until(tab, condition, seconds=60):
    """Wait from outside: the page's own rules forbid what Playwright would do inside."""
    end = time.monotonic() + seconds
    while not tab.evaluate(f"!!({condition})"):
        assert time.monotonic() < end, condition
        tab.wait_for_timeout(50)


def data_of(text):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, flags=re.DOTALL)[1])


def test_the_page_opens_from_disk_without_a_network_and_plays(tab, tmp_path, fist, hand):
    path = hl.save(fist, tmp_path / "fist.html", skin="translucent", view="radial")
    tab.context.set_offline(True)
    tab.goto(path.as_uri())
    until(tab, f"{HANDLE}?.stats.first_ms > 0")
    assert tab.locator("[data-skin=translucent]").get_attribute("aria-pressed") == "true"
    assert tab.locator("[data-view=radial]").get_attribute("aria-pressed") == "true"
    tab.get_by_label("play", exact=True).click()
    until(tab, f"{HANDLE}.frame().time > 0.5")
    until(tab, f"!{HANDLE}.status().playing && {HANDLE}.frame().time > {fist.time[-1] - 0.05}")
    tab.wait_for_timeout(600)
    fine = np.array(tab.evaluate(f"Array.from({HANDLE}.hand.points)")).reshape(-1, 3)
    assert np.abs(fine - fine_points(hand, blend(hand, fist.angle[-1]))).max() < 1e-5
    readings = tab.evaluate(
        "Object.fromEntries([...document.querySelectorAll('[data-dof] output')].map((o) => [o.parentNode.dataset.dof, o.textContent]))"
    )
    shown = np.array([float(readings[name].replace("−", "-").rstrip("°")) for name in hand.dof_names])
    assert np.abs(shown - np.rad2deg(fist.angle[-1])).max() <= 0.51


def test_its_sliders_show_the_recording_and_cannot_be_moved(tab, tmp_path, fist, hand):
    tab.goto(hl.save(fist, tmp_path / "fist.html").as_uri())
    until(tab, f"{HANDLE}?.stats.first_ms > 0")
    tab.get_by_label("time in the clip").evaluate(f"(e) => {{ e.value = {fist.time[-1]}; e.dispatchEvent(new Event('input')); }}")
    tab.wait_for_timeout(800)
    shown = {
        name: int(value)
        for name, value in tab.evaluate("[...document.querySelectorAll('input[data-muscle]')].map((e) => [e.dataset.muscle, e.value])")
    }
    for muscle, value in zip(hand.muscles.values(), fist.contraction[-1], strict=True):
        assert abs(shown[muscle.abbreviation] - 100 * value) <= 0.51
    slider = tab.locator("input[data-muscle=FDP2]")
    assert slider.get_attribute("aria-disabled") == "true"
    assert slider.evaluate("(e) => getComputedStyle(e).pointerEvents") == "none"


def test_a_page_is_below_three_megabytes_even_for_a_minute_of_motion(hand, fist):
    long = hl.simulate(hand, {"FDP2": [(0, 0), (30, 0.5), (60, 0)]})
    for clip in (fist, long):
        text = page([story(clip)])
        assert 0.5 * MEGABYTE < len(text.encode()) < 3 * MEGABYTE
        (stored,) = data_of(text)["clips"]
        size = len(base64.b64decode(stored["frames"]))
        assert 0.09 * MOST_FRAME_BYTES < size <= MOST_FRAME_BYTES
        assert stored["count"] >= stored["fps"] * stored["seconds"]


def test_a_page_names_no_address_outside_and_forbids_requests(fist):
    text = page([story(fist)])
    assert not re.search(r"https?://|//cdn|@import|\bimport\(", text)
    assert "default-src 'none'" in text


def test_several_clips_share_a_page_and_clips_of_two_hands_do_not(hand, fist):
    pinch = hl.simulate(hand, "pinch")
    assert [clip["name"] for clip in data_of(page([story(fist), story(pinch)]))["clips"]] == ["fist", "pinch"]
    with pytest.raises(ValueError, match="one hand"):
        page([story(fist), story(hl.simulate(hl.load_hand(side="left"), "fist"))])


def test_what_a_clip_is_called_cannot_become_part_of_the_program(hand):
    keys = hl.KeyFrames.from_mapping({"FDP2": [(0, 0), (0.1, 0.5)]}, name="</script><script>alert(1)</script>")
    text = page([story(hl.simulate(hand, keys))])
    assert "<script>alert" not in text
    assert data_of(text)["clips"][0]["name"] == keys.name
