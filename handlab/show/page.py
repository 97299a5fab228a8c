"""A recorded clip as one HTML file: it opens from disk, offline, and plays in the same viewer as everywhere else."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Iterable
from html import escape
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from handlab.show import keepsakes, wire
from handlab.show.flesh import packed_layers
from handlab.show.module import viewer_module
from handlab.show.moments import Story, raised_of
from handlab.show.outfits import SOFT
from handlab.simulation.geometric_muscle import ellipsoids
from handlab.simulation.skin import blend
from handlab.simulation.tendon_ridges import ridge_points
from handlab.simulation.writing import write_text

FPS = 30.0
LEAST_SOFT_FPS = 10.0
MOST_FRAME_BYTES = 1_200_000  # of all clips together, before base64: the page stays below 3 MB, a long clip gets fewer frames

# Nothing from anywhere else: the page holds all it needs.
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"

TEMPLATE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<link rel="icon" href="data:,">
<title>{title}</title>
<style>html, body {{ margin: 0; height: 100%; }} #hand {{ height: 100vh; }}</style>
</head>
<body>
<div id="hand"></div>
<noscript>This page draws the hand with JavaScript; please allow it.</noscript>
<script type="application/json" id="data">{data}</script>
<script type="module">
{module}
const data = JSON.parse(document.getElementById("data").textContent);
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const clips = data.clips.map((clip) => ({{ ...clip, frames: bytes(clip.frames), track: clip.track ? bytes(clip.track) : null }}));
const scene = unpackScene(bytes(data.scene));
if (data.layers) scene.layers = unpackScene(bytes(data.layers));
mount(document.getElementById("hand"), recorded(scene, clips), data.options);
</script>
</body>
</html>
"""


def frames(story: Story, fps: float, count: int, *, soft: bool = False, layers: bool = False) -> bytes:
    """``count`` frames of a story, one after another; with the points of a ``soft`` skin, and the muscles' segments for ``layers``."""
    hand, silent = story.hand, np.zeros(len(story.hand.muscle_names))
    packed = []
    skin: Any = None
    for k in range(count):
        if story.clip is None:
            contraction, angle, length, force, skin = silent, story.state.angle, story.state.fibre_length, silent, story.state.skin
        else:
            contraction, angle, length, force, skin = keepsakes.between(story.clip, k / fps, skin=soft)
        moment: dict[str, Any] = {"time": k / fps, "contraction": contraction, "fibre_length": length, "force": force}
        if layers:
            heard = np.zeros_like(contraction) if story.clip is not None and story.clip.muscles == "pseudo" else contraction
            moment["segments"] = ellipsoids(hand, angle, heard)
        if soft and story.clip is not None and story.clip.wear == SOFT:
            points = ridge_points(hand)
            lifted = raised_of(story.clip, angle, contraction)
            moment["ridges"] = points, np.zeros(len(points)) if lifted is None else lifted[points]
        packed.append(wire.frame(hand, angle, **moment, flags=wire.CLIP, seconds=story.seconds, skin=skin if soft else None))
    return b"".join(packed)


def page(stories: Iterable[Story], *, title: str = "", **options: Any) -> str:
    """The HTML text of one or more stories of one hand; ``options`` go to the viewer (``view``, ``skin``, ``bones``, ``layers``).

    A soft skin is shown as long as that leaves ``LEAST_SOFT_FPS`` pictures a second, about ten seconds; in longer pages it is blended.
    """
    told = list(stories)
    if not told or any(one.hand is not told[0].hand for one in told):
        raise ValueError("a page shows one or more clips of one hand")
    hand = told[0].hand
    seconds, under = sum(one.seconds for one in told), bool(options.get("layers"))
    soft, fps = any(softly(one) for one in told), rate(told[0], True, under, seconds, len(told))
    if not soft or fps < LEAST_SOFT_FPS:
        soft, fps = False, rate(told[0], False, under, seconds, len(told))
    clips = []
    for k, one in enumerate(told):
        name = getattr(one.clip, "name", "") or ("pose" if one.clip is None else f"clip {k + 1}" if len(told) > 1 else "clip")
        count = ceil(one.seconds * fps - 1e-9) + 1
        clips.append(
            {
                "name": name,
                "title": name,
                "seconds": one.seconds,
                "fps": fps,
                "count": count,
                "frames": b64encode(frames(one, fps, count, soft=soft, layers=under)).decode(),
                "track": None if one.clip is None else b64encode(keepsakes.track(one.clip)).decode(),
            }
        )
    shown = [{key: clip[key] for key in ("name", "title", "seconds")} for clip in clips]
    data = {"scene": b64encode(wire.scene(hand, shown_clips=shown)).decode(), "clips": clips, "options": options}
    if under:
        data["layers"] = b64encode(packed_layers(hand)).decode()
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    module = viewer_module(exports=False).replace("</script", "<\\/script")
    return TEMPLATE.format(title=escape(title or f"handlab: {clips[0]['name']}"), policy=POLICY, data=text, module=module)


def softly(story: Story) -> bool:
    """Whether a story's skin is another than the blended one."""
    if story.clip is not None:
        return story.clip.worn is not None
    return bool(np.abs(story.state.skin - blend(story.hand, story.state.angle)).max() > wire.UNIT)


def rate(story: Story, soft: bool, layers: bool, seconds: float, stories: int) -> float:
    """Frames per second with which ``seconds`` of stories like this one fit."""
    size = len(frames(story, FPS, 1, soft=soft, layers=layers))
    return min(FPS, max((MOST_FRAME_BYTES / size - 2 * stories) / seconds, 0.5)) if seconds else FPS


def write_html(story: Story, out: Path, **options: Any) -> None:
    """Write the page of one story, whole or not at all."""
    write_text(out, page([story], **options))
