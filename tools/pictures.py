"""Draw every picture of the README: ``python -m tools.pictures``."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import handlab as hl

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "pictures"
CLICKED = 20  # of 26 points
HELD = {"open": "open", "fist": "fist", "pinch": "pinch", "ok": "OK", "opposition-little": "opposition"}


def main() -> None:
    """Sheets of postures, curves of one clip, the lever arms and the force-length plot."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    hand = hl.load_hand()
    fist = hl.simulate(hand, hl.keyframes("fist"))
    moments = {
        "relaxed": fist.states[0],
        "closing": fist.states[int(0.55 * hl.keyframes("fist").time[2] * fist.fps)],
        "fist": fist.states[-1],
    }
    hl.sheet(hand, moments, FOLDER / "fist.png")
    held = {title: hl.simulate(hand, hl.keyframes(name)).states[-1] for name, title in HELD.items()}
    hl.sheet(hand, held, FOLDER / "postures.png", skin=["solid", "translucent"])
    hl.sheet(hand, {"relaxed": fist.states[0], **{k: held[k] for k in ("open", "fist")}}, FOLDER / "bones.png", skin=["hidden"])
    hl.save(hl.curves(fist, muscles=["FDP2", "FDS2", "EDC2", "LUM1"], joints=["mcp2", "pip2", "dip2"]), FOLDER / "curves.png")
    hl.save(hl.lever_arm_map(hand), FOLDER / "lever_arms.png")
    flat = hl.pose(hand, dict.fromkeys(hand.moving_names, 0.0))
    hl.save(hl.force_length(hand, {"flat hand": flat, "fist": fist.states[-1]}), FOLDER / "force_length.png")
    for name, figure in {
        "brand": hl.brand_plot(hand),
        "pull_map": hl.pull_map(hand),
        "excursion": hl.excursion_plot(hand),
        "torque_balance": hl.torque_balance(fist, "mcp2"),
        "wrist": hl.wrist_plot(hand),
        "step": hl.step_plot(hand),
        "wrist_inertia": hl.wrist_inertia(hand),
        "two_hands": hl.two_hands(hand, hl.load_hand("child"), "fist"),
    }.items():
        hl.save(figure, FOLDER / f"{name}.png")
    hl.bulge_figure(hand, path=FOLDER / "bulge.png")
    hl.skins_figure(hand, path=FOLDER / "skins.png")
    outline()
    live_view()
    own_hand()


def outline() -> None:
    """A computed photograph of the child's hand and the outlines of two fits: of its points alone, and with the outline in the picture."""
    import matplotlib.pyplot as plt
    import numpy as np

    from handlab.show.figures import STYLE
    from handlab.studies.table_photo import table_photo

    photo = table_photo(hl.load_hand("child"), px_per_mm=5.0)
    where = {"view": "palmar", "side": "right", "camera_mm": photo.camera_mm, "centre_px": photo.centre_px}
    with plt.rc_context(STYLE):
        figure, both = plt.subplots(1, 2, figsize=(11, 6.6), layout="constrained")
        for axes, used, colour, name in zip(both, (False, True), ("#E69F00", "#56B4E9"), ("points alone", "with the outline"), strict=True):
            fit = hl.fit_photo(photo.pixels, landmarks=photo.marks_px, scale=photo.scale, outline=used, **where)
            axes.imshow(photo.pixels)
            axes.plot(*np.vstack([fit.outline, fit.outline[:1]]).T, color=colour, linewidth=2)
            axes.plot(*fit.clicks.T, "o", color="white", markersize=4)
            axes.set(xticks=[], yticks=[], title=f"{name}: {100 * fit.iou:.1f} % overlap")
        figure.savefig(FOLDER / "outline.png", dpi=80)
        plt.close(figure)


@contextmanager
def served(*command: str, size: tuple[int, int]) -> Iterator[Any]:
    """A page of the running command in Chromium (needs playwright)."""
    from playwright.sync_api import sync_playwright

    words = [sys.executable, "-m", "handlab.cli", *command, "--no-browser", "--port", "0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as server, sync_playwright() as play:
        assert server.stdout is not None
        address = next(found.group(0) for line in server.stdout if (found := re.search(r"http://\S+", line)))
        browser = play.chromium.launch(
            executable_path="/usr/bin/chromium",
            args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
        )
        try:
            page = browser.new_page(viewport={"width": size[0], "height": size[1]})
            page.goto(address)
            yield page
        finally:
            browser.close()
            server.terminate()


def live_view() -> None:
    """The page that ``handlab`` opens, with the pinch held, solid and translucent."""
    with served("run", size=(1440, 900)) as page:
        page.wait_for_function("window.handlab?.status()?.soft", timeout=90_000)
        page.get_by_role("button", name="pinch", exact=True).click()
        page.get_by_role("button", name="radial", exact=True).click()
        page.wait_for_timeout(6_000)
        page.screenshot(path=FOLDER / "viewer.png")
        page.get_by_role("button", name="translucent", exact=True).click()
        page.wait_for_timeout(2_000)
        page.screenshot(path=FOLDER / "viewer_translucent.png")


def own_hand() -> None:
    """The page "Your own hand" with a computed photograph and most of its points clicked."""
    from PIL import Image

    from handlab.studies.table_photo import RULER_MM, table_photo

    photo = table_photo(hl.load_hand("man"), view="dorsal", px_per_mm=5.0)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "hand.png"
        Image.fromarray(photo.pixels).save(file)
        with served("fit", str(file), size=(1280, 720)) as page:

            def click(place: Any) -> None:
                box = page.locator(".hf-stage > img").bounding_box()
                scale = box["width"] / photo.pixels.shape[1]
                page.mouse.click(box["x"] + scale * place[0], box["y"] + scale * place[1])

            page.click(".hf-choice[data-view=dorsal]", timeout=60_000)
            for place in photo.ruler_px:
                click(place)
            page.wait_for_function("document.activeElement?.dataset.mm !== undefined")
            page.keyboard.type(f"{RULER_MM}")
            page.keyboard.press("Enter")
            for _ in range(CLICKED):
                name = page.wait_for_selector(".hf-drawing circle.now", state="attached").get_attribute("data-point")
                click(photo.marks_px[name])
                page.wait_for_timeout(700)
            page.wait_for_timeout(1_500)
            page.screenshot(path=FOLDER / "own_hand.png")


if __name__ == "__main__":
    main()
