"""``save``: a hand, a state, a clip or a figure becomes a file, its format chosen by the suffix."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from handlab.anatomy.records import Hand
from handlab.show.moments import Story, story
from handlab.show.outputs import checked
from handlab.simulation.writing import whole_file

FORMATS = (".mp4", ".gif", ".png", ".csv", ".glb", ".html", ".xml")
FIGURE_FORMATS = (".png", ".svg", ".pdf")


def save(
    what: Any,
    path: str | os.PathLike[str],
    *,
    hand: Hand | None = None,
    view: str | Sequence[str] = "palm",
    skin: str | Sequence[str] = "solid",
    bones: bool = True,
    muscles: bool = True,
    layers: str | Sequence[str] = (),
    size: tuple[int, int] = (800, 600),
    fps: float = 30.0,
) -> Path:
    """Write a clip, a hand (relaxed), a state (say whose: ``hand=``) or a figure to ``path``; the path it went to.

    ``.mp4`` and ``.gif`` are films, ``.png`` is a still or the moments of a clip, ``.csv`` is a clip's table, ``.glb`` is animated
    glTF (skin and bones), ``.html`` is one page that plays offline in any browser, ``.xml`` is the hand as a MuJoCo model (``to_mjcf``).
    Several views stand beside each other, several skins below each other: ``view=["palm", "back"], skin=["solid", "translucent"]``.
    ``muscles`` lists the contracting muscles by group, with percent and newtons; ``layers=["muscles", "tendons"]`` draws geometric
    muscles and tendons under a skin that is not solid. The skin is worn as in the clip or state (``simulate(..., skin="springs and
    muscles")``, ``clip.with_skin()``), except in ``.glb``, which has bones and the blended skin. ``size`` is width and height in
    pixels of the whole picture, ``fps`` frames per second; the motion is the same at any rate.

    Raises ``ValueError`` (unknown format, view, skin, size or rate) and ``OSError`` (a place that cannot be written to) before
    anything is drawn. A file is written whole or not at all.
    """
    from handlab.show.tiles import layout

    if hasattr(what, "savefig"):
        return save_figure(what, path)
    out = checked(path, FORMATS)
    told = story(what, hand)
    plan = layout(view, skin, bones, size, muscles, layers)
    if not 1.0 <= fps <= 240.0:
        raise ValueError(f"fps is {fps:g}; frames per second lie between 1 and 240")
    WRITERS[out.suffix.lower()](told, out, plan, float(fps))
    return out


def save_figure(figure: Any, path: str | os.PathLike[str]) -> Path:
    """Write a matplotlib figure."""
    out = checked(path, FIGURE_FORMATS)
    with whole_file(out) as temporary:
        figure.savefig(temporary, dpi=100)
    return out


def _mp4(told: Story, out: Path, plan: Any, fps: float) -> None:
    from handlab.show.film import write_mp4

    write_mp4(told, out, plan, fps)


def _gif(told: Story, out: Path, plan: Any, fps: float) -> None:
    from handlab.show.film import write_gif

    write_gif(told, out, plan, fps)


def _png(told: Story, out: Path, plan: Any, fps: float) -> None:
    from handlab.show.sheet import write_png

    write_png(told, out, plan)


def _csv(told: Story, out: Path, plan: Any, fps: float) -> None:
    if told.clip is None:
        raise ValueError("a .csv holds a table over time: save a clip, as simulate(hand, keyframes) returns it")
    with whole_file(out) as temporary:
        told.clip.to_csv(temporary)


def _glb(told: Story, out: Path, plan: Any, fps: float) -> None:
    from handlab.show.gltf import write_glb

    write_glb(told, out, fps)


def _html(told: Story, out: Path, plan: Any, fps: float) -> None:
    from handlab.show.page import write_html

    write_html(
        told, out, view=plan.views[0], skin=plan.skins[0], bones=plan.bones, **({"layers": list(plan.layers)} if plan.layers else {})
    )


def _xml(told: Story, out: Path, plan: Any, fps: float) -> None:
    from handlab.simulation.to_mjcf import to_mjcf

    if told.clip is not None:
        raise ValueError("a .xml holds a hand, not a motion: save clip.hand, or the clip as .csv or .glb")
    with whole_file(out) as temporary:
        temporary.write_text(to_mjcf(told.hand), encoding="utf-8")


WRITERS = {".mp4": _mp4, ".gif": _gif, ".png": _png, ".csv": _csv, ".glb": _glb, ".html": _html, ".xml": _xml}
