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

from handlab.anatomy.records import Array
from handlab.show import wire
from handlab.show.module import viewer_module
from handlab.show.moments import Story
from handlab.simulation.clip import Clip
from handlab.simulation.writing import write_text

FPS = 30.0
MOST_FRAME_BYTES = 1_200_000  # of all clips together, before base64: the page stays below 3 MB, a long clip gets fewer frames
MOST_TRACK_ROWS = 240

TEMPLATE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:">
<link rel="icon" href="data:,">
<title>{title}</title>
<style>html, body {{ margin: 0; height: 100%; }} #hand {{ height: 100vh; }} noscript {{ font: 18px sans-serif; display: block; padding: 2em; }}</style>
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
mount(document.getElementById("hand"), recorded(bytes(data.scene), clips), data.options);
</script>
</body>
</html>
"""


def track(clip: Clip, most: int = MOST_TRACK_ROWS) -> bytes:
    """The curves of a clip: float32 rows of time, fibre lengths (muscle,) and angles (dof,), at most ``most`` of them."""
    rows = np.unique(np.linspace(0, len(clip.time) - 1, min(len(clip.time), most)).round().astype(int))
    table = np.column_stack([clip.time[rows] - clip.time[0], clip.fibre_length[rows], clip.angle[rows]])
    return table.astype("<f4").tobytes()


def frames(story: Story, fps: float, count: int) -> bytes:
    """``count`` frames of a story, one after another."""
    hand, silent = story.hand, np.zeros(len(story.hand.muscle_names))
    packed = []
    for k in range(count):
        moment = story.at(k / fps)
        length: Array = silent + hand.rest_length if story.clip is None else np.array(lengths(story, moment.time))
        packed.append(
            wire.frame(
                hand,
                moment.angle,
                time=k / fps,
                contraction=silent if moment.contraction is None else moment.contraction,
                fibre_length=length,
                force=silent if moment.force is None else moment.force,
                flags=wire.CLIP,
                seconds=story.seconds,
            )
        )
    return b"".join(packed)


def lengths(story: Story, time: float) -> Array:
    """Fibre lengths (muscle,) of a clip at a time."""
    clip = story.clip
    result: Array = np.array([np.interp(time, clip.time, column) for column in clip.fibre_length.T])
    return result


def page(stories: Iterable[Story], *, title: str = "", **options: Any) -> str:
    """The HTML text of one or more stories of one hand; ``options`` go to the viewer (``view``, ``skin``, ``bones``)."""
    told = list(stories)
    if not told or any(one.hand is not told[0].hand for one in told):
        raise ValueError("a page shows one or more clips of one hand")
    hand = told[0].hand
    size = len(wire.frame(hand, hand.bind, time=0.0, contraction=hand.rest_length, fibre_length=hand.rest_length, force=hand.rest_length))
    seconds = sum(one.seconds for one in told)
    fps = min(FPS, max((MOST_FRAME_BYTES / size - len(told)) / seconds, 0.5)) if seconds else FPS
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
                "frames": b64encode(frames(one, fps, count)).decode(),
                "track": None if one.clip is None else b64encode(track(one.clip)).decode(),
            }
        )
    shown = [{key: clip[key] for key in ("name", "title", "seconds")} for clip in clips]
    data = {"scene": b64encode(wire.scene(hand, shown_clips=shown)).decode(), "clips": clips, "options": options}
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return TEMPLATE.format(title=escape(title or f"handlab: {clips[0]['name']}"), data=text, module=viewer_module(exports=False).replace("</script", "<\\/script"))


def write_html(story: Story, out: Path, **options: Any) -> None:
    """Write the page of one story, whole or not at all."""
    write_text(out, page([story], **options))
