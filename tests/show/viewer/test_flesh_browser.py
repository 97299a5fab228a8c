"""Muscles and tendons in a real browser: where the kernel has them, named, switched."""

from dataclasses import replace

import numpy as np
import pytest

from handlab.anatomy.grids import as_text, load_grids
from handlab.show.flesh import ROUND, STRIDE
from handlab.show.session import Session
from handlab.simulation.geometric_muscle import ellipsoids, geometric_muscles
from handlab.simulation.muscle_surface import surface_points
from handlab.simulation.skin import blend, fine_points
from handlab.simulation.tendon_ridges import ridge_heights
from handlab.simulation.tendons import tendons

SOFT = "springs and muscles"


@pytest.fixture
def soft(live, hand):
    session = Session(hand, wear=SOFT)
    session.prepare()
    return live(session, '{"skin": "translucent", "layers": ["muscles", "tendons"]}')


def array(page, name):
    return np.array(page.evaluate(f"Array.from(handlab.hand.{name})"))


def test_the_browser_puts_muscles_and_tendons_where_the_kernel_does(soft, hand):
    page = soft.page
    page.evaluate("handlab.send({kind: 'play', clip: 'key-pinch', speed: 4})")
    soft.settled()
    points = array(page, "flesh.points").reshape(-1, 3)
    told = page.evaluate("handlab.hand.flesh.all")
    session = soft.session
    contraction, angle = session.clip.contraction[-1], session.clip.angle[-1]
    muscles = geometric_muscles(hand)
    wanted = surface_points(muscles, ellipsoids(hand, angle, contraction))
    for one, exact, (fibres, part) in zip(told, wanted, zip(muscles.fibres, muscles.segments, strict=True), strict=False):
        assert one["segments"] == (part.stop - part.start) // fibres
        shown = points[one["first"] : one["end"]]
        body = exact[:-2].reshape(-1, one["ring"] * STRIDE, 3)[::STRIDE, ::STRIDE].reshape(-1, 3)
        assert np.linalg.norm(shown - np.concatenate([body, exact[-2:]]), axis=1).max() < 4e-4, one["name"]
    for one, tube in zip(told[len(wanted) :], tendons(hand, angle, contraction), strict=True):
        assert one["name"] == tube.name
        rings = points[one["first"] : one["end"] - 2].reshape(-1, ROUND, 3)
        rows = np.minimum(STRIDE * np.arange(len(rings)), len(tube.points) - 1)
        assert np.abs(rings.mean(axis=1) - tube.points[rows]).max() < 2e-5, one["name"]
        assert np.abs(np.linalg.norm(rings - tube.points[rows][:, None], axis=2) - tube.radius).max() < 2e-5


def test_the_browser_lifts_the_skin_over_tendons_that_pull_as_the_kernel_does(soft, hand):
    page = soft.page
    page.evaluate("handlab.send({kind: 'play', clip: 'spread', speed: 4})")
    soft.settled()
    clip = soft.session.clip
    raised = ridge_heights(hand, clip.angle[-1], clip.contraction[-1])
    points = array(page, "points").reshape(-1, 3)
    assert np.linalg.norm(points - fine_points(hand, clip.skin(-1), raised), axis=1).max() < 5e-5
    assert np.linalg.norm(points - fine_points(hand, clip.skin(-1)), axis=1).max() > 5e-4
    page.evaluate("handlab.send({kind: 'wear', skin: 'springs'})")
    soft.settled()
    assert page.evaluate("Math.max(...handlab.hand.raised)") == 0


def test_a_software_renderer_draws_fewer_triangles_while_the_hand_moves_and_all_of_them_at_rest(soft):
    counted = """(still) => {
      const { hand } = handlab, gl = hand.gl, real = gl.drawElements;
      let count = 0;
      gl.drawElements = (mode, corners, ...more) => { count += corners / 3; real.call(gl, mode, corners, ...more); };
      hand.draw(still);
      gl.drawElements = real;
      return count;
    }"""
    page = soft.page
    soft.settled()
    whole, lean = (page.evaluate(counted, still) for still in (True, False))
    arrays = page.evaluate(
        "[handlab.hand.scene.arrays.fine_faces, handlab.hand.scene.arrays.bone_faces, handlab.hand.flesh.faces].map((f) => f.length / 3)"
    )
    assert whole == 2 * arrays[0] + arrays[1] + arrays[2]
    assert 0.3 * whole < lean < 0.6 * whole
    page.evaluate("handlab.hand.zoom(0.3)")  # from near, every triangle shows
    assert page.evaluate(counted, False) == whole


def test_a_painted_muscle_that_is_loaded_is_drawn_with_the_others(soft, hand):
    shipped = next(one for one in load_grids() if one.name == "abductor_digiti_minimi")
    text = as_text(replace(shipped, name="impostor", drives=("flexor_pollicis_longus",)))
    page = soft.page
    before = page.evaluate("handlab.hand.flesh.all.length")
    page.evaluate("(text) => handlab.send({kind: 'load', text, name: 'impostor.json'})", text)
    page.wait_for_function("handlab.hand.flesh.all.some((one) => one.name === 'impostor')")
    page.evaluate("handlab.send({kind: 'set', contraction: {FPL: 0.5}})")
    page.wait_for_function("handlab.hand.segments?.length === 10 * handlab.hand.flesh.segments")
    assert page.evaluate("handlab.hand.flesh.all.length") == before + 1
    soft.settled()
    points = array(page, "flesh.points").reshape(-1, 3)
    assert np.isfinite(points).all() and np.abs(points).max() < 0.3
    one = page.evaluate("handlab.hand.flesh.all.find((one) => one.name === 'impostor')")
    assert np.ptp(points[one["first"] : one["end"]], axis=0).max() > 0.02


def test_muscles_and_tendons_show_under_translucent_skin_and_go_again(soft):
    page = soft.page
    both = soft.seen().astype(int)
    red = (both[..., 0] - both[..., 1] > 70) & (both[..., 1] < 130)
    assert red.sum() > 3000
    page.locator("[data-layer=muscles]").click()
    page.wait_for_timeout(300)
    bare = soft.seen().astype(int)
    assert ((bare[..., 0] - bare[..., 1] > 70) & (bare[..., 1] < 130)).sum() < 0.1 * red.sum()
    page.locator("[data-layer=tendons]").click()
    page.wait_for_timeout(300)
    assert (np.abs(soft.seen().astype(int) - bare).max(axis=2) > 12).sum() > 1000
    page.locator("[data-skin=solid]").click()
    page.locator("[data-layer=muscles]").click()  # nobody could see them under a solid skin
    assert page.evaluate("handlab.hand.look.skin") == "translucent"


def test_a_muscle_under_the_mouse_says_its_name_and_a_click_marks_what_drives_it(soft, hand):
    page = soft.page
    page.locator("[data-view=palm]").click()
    soft.settled()
    place = page.evaluate(
        """() => {
          const { hand } = handlab, k = hand.flesh.all.findIndex((one) => one.name === 'abductor_digiti_minimi');
          for (let y = 60; y < hand.canvas.clientHeight - 60; y += 4) for (let x = 20; x < hand.canvas.clientWidth; x += 4) {
            const found = hand.pick(x, y);
            if (found?.kind === 'flesh' && found.index === k) return [x, y];
          }
        }"""
    )
    box = page.locator(".hl-stage canvas").bounding_box()
    page.mouse.move(box["x"] + place[0], box["y"] + place[1])
    page.wait_for_function("!document.querySelector('.hl-tag').hidden")
    assert page.locator(".hl-tag").inner_text().lower().startswith("abductor digiti minimi")
    assert "ADM" in page.locator(".hl-tag").inner_text()
    page.mouse.down()
    page.mouse.up()
    assert page.evaluate("handlab.picked().name") == "abductor_digiti_minimi"
    assert page.locator(".hl-row.linked[data-muscle=ADM]").count() == 1


def test_buttons_change_the_skin_that_is_worn(soft, hand):
    page = soft.page
    angle = soft.session.state.angle
    for wear, least in (("blend", 0.0), ("springs", 1e-4), (SOFT, 1e-4)):
        page.locator(f'[data-wear="{wear}"]').click()
        page.wait_for_function(f"handlab.status().wear === '{wear}'")
        soft.settled()
        assert page.locator(f'[data-wear="{wear}"]').get_attribute("aria-pressed") == "true"
        shown = array(page, "coarse").reshape(-1, 3)
        off = np.abs(shown - blend(hand, angle)).max()
        assert least <= off < (2e-6 if wear == "blend" else 2e-2)
    page.get_by_label("which muscles contract").select_option("geometric")
    page.wait_for_function("handlab.status().muscles === 'geometric'")
    page.locator("input[data-muscle=DI1]").evaluate("(s) => { s.value = 100; s.dispatchEvent(new Event('input', { bubbles: true })); }")
    soft.settled()
    assert np.abs(soft.session.state.angle - angle).max() < 1e-9


def test_a_soft_page_at_rest_asks_for_nothing(soft):
    before = soft.ticks
    soft.page.wait_for_timeout(1500)
    assert soft.ticks - before <= 1
