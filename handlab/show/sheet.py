"""Still pictures and contact sheets: moments or postures below each other, views beside each other."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from handlab.anatomy.records import Hand
from handlab.show.colours import FAINT, INK, PAPER
from handlab.show.lettering import fit, write
from handlab.show.moments import Moment, Story, story
from handlab.show.outputs import checked, progress
from handlab.show.tiles import Layout, Tiles, layout
from handlab.show.views import FOUR_SIDES
from handlab.simulation.writing import whole_file

CLIP_MOMENTS = 5


def write_png(told: Story, out: Path, plan: Layout) -> None:
    """A still of a state; of a clip, its moments below each other with the muscles beside them."""
    moments = told.sample(CLIP_MOMENTS)
    image = stack([(f"{moment.time:.2f} s" if told.clip is not None else "", told, moment) for moment in moments], plan)
    store(image, out)


def store(image: Any, out: Path) -> None:
    """Write a Pillow image, whole or not at all."""
    with whole_file(out) as temporary:
        image.save(temporary, format="PNG", optimize=True)


def stack(rows: Sequence[tuple[str, Story, Moment]], plan: Layout) -> Any:
    """Rows of tiles as one Pillow image: (title, story, moment) each, all of one hand, all at one scale."""
    from PIL import Image

    width, height = plan.size
    image = Image.new("RGB", (width, height * len(rows)), PAPER)
    framing = [moment for _, _, moment in rows]
    tiles = Tiles(rows[0][1], plan, quality="still", framing=framing)
    try:
        for k, (title, _, moment) in enumerate(progress(rows, "pictures", len(rows))):
            image.paste(Image.fromarray(tiles.picture(moment, title=title)), (0, k * height))
    finally:
        tiles.close()
    return image


def sheet(
    hand: Hand,
    postures: Mapping[str, Any],
    path: str | os.PathLike[str] | None = None,
    *,
    view: str | Sequence[str] = FOUR_SIDES,
    skin: str | Sequence[str] = ("solid", "translucent"),
    bones: bool = True,
    layers: str | Sequence[str] = (),
    tile: tuple[int, int] = (300, 380),
) -> Any:
    """A contact sheet as a Pillow image: a row per posture (name -> state), a column per skin and view.

    Skins are worn as in the states: ``clip.states[k]`` of a clip with a soft skin, or ``dress(hand, state)``. ``layers``: as in ``save``.
    Written to ``path`` (.png) if one is given. ``tile`` is the size of one picture in pixels.
    """
    from PIL import Image, ImageDraw

    out = None if path is None else checked(path, [".png"])
    plan = layout(view, skin, bones, tile, muscles=False, layers=layers)
    columns = [(skin_, view_) for skin_ in plan.skins for view_ in plan.views]
    width, height = plan.size
    margin, head = round(0.42 * width), round(0.16 * height)
    image = Image.new("RGB", (margin + width * len(columns), head + height * len(postures)), PAPER)
    draw = ImageDraw.Draw(image)
    size = 0.055 * width
    for k, (skin_, view_) in enumerate(columns):
        write(draw, (margin + (k + 0.5) * width, 0.42 * head), view_, 1.3 * size, colour=INK, anchor="ms", bold=True)
        write(draw, (margin + (k + 0.5) * width, 0.80 * head), f"skin {skin_}", size, colour=FAINT, anchor="ms")
    told = {name: story(state, hand) for name, state in postures.items()}
    moments = {name: one.at(0.0) for name, one in told.items()}
    each = Layout(plan.views, plan.skins, bones, (width * len(plan.views), height * len(plan.skins)), muscles=False, layers=plan.layers)
    tiles = Tiles(story(hand), each, quality="still", framing=moments.values())
    try:
        for row, name in enumerate(progress(moments, "pictures", len(moments))):
            letters = fit(draw, name, 1.3 * size, margin - size, bold=True)
            write(draw, (0.5 * size, head + (row + 0.5) * height), name, letters, colour=INK, bold=True, anchor="lm")
            tiles.scene.pose(moments[name])
            for k, (skin_, view_) in enumerate(columns):
                tiles.scene.set(skin=skin_, view=tiles.cameras[view_])
                image.paste(Image.fromarray(tiles.scene.picture()), (margin + k * width, head + row * height))
    finally:
        tiles.close()
    if out is not None:
        store(image, out)
    return image
