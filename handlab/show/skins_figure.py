"""Three ways to wear one skin in one pose, and what each adds to the one before, in millimetres in colour."""

from __future__ import annotations

import os
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.show.bulge_figure import colours, on_fine, steps
from handlab.show.colours import FAINT, INK, PAPER
from handlab.show.lettering import fit, write
from handlab.show.moments import Moment
from handlab.show.outputs import checked
from handlab.show.scene import Scene
from handlab.show.sheet import store
from handlab.show.views import camera, view_name
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import clips
from handlab.simulation.play import simulate
from handlab.simulation.skin import normals
from handlab.simulation.soft_anchors import SKINS
from handlab.simulation.tendon_ridges import ridge_heights
from handlab.studies.knuckle import worn

TITLES = ("blend: bones alone", "springs", "springs and muscles")
COARSE = 2.0  # springs move skin further than muscles do: their colours stand for twice as many millimetres


def skins_figure(
    hand: Hand,
    clip: Clip | str = "fist",
    path: str | os.PathLike[str] | None = None,
    *,
    view: str = "back",
    size: tuple[int, int] = (1800, 1350),
) -> Any:
    """The last pose of ``clip`` (or of the clip of that name) with its skin worn in three ways, as a Pillow image.

    Below the second and the third: how far they lie outside (orange) or inside (blue) of the one before, along the normals of that one.
    ``view``: from where; written to ``path`` (.png) if one is given.
    """
    from PIL import Image, ImageDraw

    out = None if path is None else checked(path, [".png"])
    seen = view_name(view)
    played = simulate(hand, find(clip, clips(), kind="clip")) if isinstance(clip, str) else clip
    skins = three(hand, played)
    added = [differences(hand, one, other) for one, other in pairwise(skins)]
    letters = 0.020 * size[0]
    head, width = round(2.0 * letters), size[0] // 3
    height = (size[1] - 2 * head) // 2
    aim = camera(hand, seen, skins, width / height)
    image = Image.new("RGB", size, PAPER)
    draw = ImageDraw.Draw(image)
    last = Moment(0.0, skins[0], played.angle[-1])
    ridges = ridge_heights(hand, played.angle[-1], played.contraction[-1])
    with Scene(hand, skin="solid", view="palm", size=(width, height), quality="still") as scene:
        scene.set(view=aim)
        for k, points in enumerate(skins):
            scene.pose(replace(last, skin=points, raised=ridges if k == 2 else None))
            image.paste(Image.fromarray(scene.picture()), (k * width, head))
        for k, (rise, factor) in enumerate(zip(added, (COARSE, 1.0), strict=True)):
            scene.pose(replace(last, skin=skins[k + 1]))
            scene.tint(colours(1e3 * on_fine(hand, rise) / factor))
            image.paste(Image.fromarray(scene.picture()), ((k + 1) * width, 2 * head + height))
    for k, title in enumerate(TITLES):
        write(draw, (k * width + letters, 1.4 * letters), title, fit(draw, title, letters, width - 2 * letters), colour=INK, bold=True)
    top = head + height
    for k, (rise, factor, title) in enumerate(zip(added, (COARSE, 1.0), ("what springs add", "what muscles add"), strict=True)):
        left = (k + 1) * width
        write(draw, (left + letters, top + 1.4 * letters), title, letters, colour=INK, bold=True)
        low, high = (int(np.clip(round(1e3 * v / factor / 0.5), -5, 5)) for v in (rise.min(), rise.max()))
        steps(draw, range(min(low, 0), max(high, 1) + 1), (left + 0.4 * letters, size[1] - letters), 0.82 * letters, factor)
    for k, text in enumerate(told(played, added)):
        small = fit(draw, text, 0.68 * letters, width - 2 * letters)
        write(draw, (letters, top + head + (1.5 + 1.3 * k) * letters), text, small, colour=INK if k else FAINT)
    if out is not None:
        store(image, out)
    return image


def three(hand: Hand, clip: Clip) -> list[Array]:
    """Skin points (N, 3) at rest in the last pose of a clip, as in ``SKINS``."""
    state = clip.states[-1]
    return [worn(hand, state, way, contraction=clip.contraction[-1]) for way in SKINS]


def differences(hand: Hand, one: Array, other: Array) -> Array:
    """How far (N,) m ``other`` lies outside of ``one`` (N, 3), along the normals of ``one``."""
    result: Array = np.einsum("ni,ni->n", other - one, normals(hand, one))
    return result


def told(clip: Clip, added: list[Array]) -> list[str]:
    """The numbers in words."""
    springs, muscles = (1e3 * rise for rise in added)
    return [
        f"the end of {clip.name or 'the clip'}; bones are the same",
        f"springs: {springs.min():+.1f} to {springs.max():+.1f} mm".replace("-", "−"),
        f"muscles: {muscles.min():+.1f} to {muscles.max():+.1f} mm".replace("-", "−"),
        "points of the skin moved by more than 1 mm:",
        f"springs {100 * np.mean(np.abs(springs) > 1):.0f} %, muscles {100 * np.mean(np.abs(muscles) > 1):.0f} %",
        "tendons stand out in the third picture",
    ]
