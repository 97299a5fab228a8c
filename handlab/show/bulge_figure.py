"""Figure 5: one pose with muscles off and on, and the difference in millimetres in colour."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.show.colours import FAINT, INK, PAPER
from handlab.show.lettering import write
from handlab.show.moments import Moment
from handlab.show.outputs import checked
from handlab.show.scene import Scene
from handlab.show.sheet import store
from handlab.show.views import Camera, camera, view_name
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import clips
from handlab.simulation.play import simulate
from handlab.studies.swelling import Swelling, swelling

STEP_MM = 0.5  # from one box of the legend to the next
MOST_MM = 2.5  # more is drawn in the last colour
# From the paper's grey to Okabe and Ito's orange and vermilion where skin rises, to their blue where it sinks.
RISE = np.array([[222, 222, 218], [240, 205, 130], [230, 159, 0], [213, 94, 0], [150, 50, 0]], dtype=float)
SINK = np.array([[222, 222, 218], [86, 180, 233], [0, 114, 178]], dtype=float)


def bulge_figure(
    hand: Hand,
    clip: Clip | str = "key-pinch",
    muscles: str | Iterable[str] = "DI1",
    path: str | os.PathLike[str] | None = None,
    *,
    level: float = 1.0,
    view: str = "oblique back",
    size: tuple[int, int] = (1800, 900),
) -> Any:
    """Three pictures side by side as a Pillow image: muscles off, on, and how far the skin rises between them.

    The pose is the last of ``clip`` (or of the clip of that name); ``muscles`` by name or abbreviation are at 0 and at ``level``, all
    others as in the clip. Written to ``path`` (.png) if one is given. The numbers are those of ``studies.swelling``.
    """
    from PIL import Image, ImageDraw

    out = None if path is None else checked(path, [".png"])
    seen = view_name(view)
    played = simulate(hand, find(clip, clips(), kind="clip")) if isinstance(clip, str) else clip
    found = swelling(hand, played.angle[-1], played.contraction[-1], muscles, level=level)
    letters = 0.036 * size[1]
    head = round(2.4 * letters)
    width, height = size[0] // 3, size[1] - head
    aim = camera(hand, seen, [found.off, found.on], width / height)
    pictures = drawn(hand, found, aim, (width, height))
    image = Image.new("RGB", size, PAPER)
    for k, picture in enumerate(pictures):
        image.paste(Image.fromarray(picture), (k * width, head))
    draw = ImageDraw.Draw(image)
    names = ", ".join(hand.muscles[name].abbreviation for name in found.muscles)
    for k, title in enumerate((f"{names} at rest", f"{names} at {100 * level:.0f} %", "the skin rises by")):
        write(draw, (k * width + letters, 1.6 * letters), title, letters, colour=INK, bold=True)
    legend(draw, found, (2 * width + letters, size[1] - 1.2 * letters), letters)
    mark(draw, found, aim, (2 * width, head, width, height), letters)
    note = f"the bones are in the same pose (end of {played.name or 'the clip'})"
    write(draw, (letters, size[1] - 0.8 * letters), note, 0.62 * letters, colour=FAINT)
    if out is not None:
        store(image, out)
    return image


def drawn(hand: Hand, found: Swelling, aim: Camera, size: tuple[int, int]) -> list[Any]:
    """The skin off, on, and on in the colours of its rise."""
    pictures = []
    with Scene(hand, skin="solid", view="palm", size=size, quality="still") as scene:
        scene.set(view=aim)
        for points in (found.off, found.on):
            scene.pose(Moment(0.0, points, found.angle))
            pictures.append(scene.picture())
        scene.tint(colours(1e3 * fine_rise(hand, found)))
        pictures.append(scene.picture())
    return pictures


def fine_rise(hand: Hand, found: Swelling) -> Array:
    """The rise (Nf,) m at the points of the fine skin."""
    fine = hand.skin_fine
    result: Array = np.einsum("ni,ni->n", fine.barycentric, found.rise[hand.skin.faces[fine.triangle]])
    return result


def colours(rise_mm: Array) -> Any:
    """Colours (n, 3) of a rise in millimetres."""
    result = np.empty((len(rise_mm), 3))
    for ramp, sign in ((RISE, 1.0), (SINK, -1.0)):
        own = sign * rise_mm >= 0.0
        place = np.clip(sign * rise_mm[own] / MOST_MM, 0.0, 1.0) * (len(ramp) - 1)
        for k in range(3):
            result[own, k] = np.interp(place, np.arange(len(ramp)), ramp[:, k])
    return np.rint(result).astype(np.uint8)


def legend(draw: Any, found: Swelling, corner: tuple[float, float], letters: float) -> None:
    """A box for every half millimetre that occurs, from below upwards."""
    low, high = (round(1e3 * float(v) / STEP_MM) for v in (found.rise.min(), found.rise.max()))
    x, y = corner
    for k in range(min(low, 0), max(high, 1) + 1):
        y -= letters
        box = (x, y, x + 1.3 * letters, y + 0.8 * letters)
        draw.rectangle(box, fill=tuple(int(v) for v in colours(np.array([k * STEP_MM]))[0]))
        text = f"{k * STEP_MM:+.1f} mm" if k else "0"
        write(draw, (x + 1.6 * letters, y + 0.7 * letters), text.replace("-", "−"), 0.72 * letters, colour=INK)


def mark(draw: Any, found: Swelling, aim: Camera, place: tuple[int, int, int, int], letters: float) -> None:
    """A ring and the number where the skin rises most."""
    from handlab.show.views import LENS_DEG

    most, k = found.most
    left, top, width, height = place
    way = found.on[k] - aim.position
    depth = -float(way @ aim.to_eye)
    scale = 0.5 * height / np.tan(np.deg2rad(LENS_DEG / 2)) / depth
    x, y = left + width / 2 + scale * float(way @ aim.right), top + height / 2 - scale * float(way @ aim.up)
    r = 0.35 * letters
    draw.ellipse((x - r, y - r, x + r, y + r), outline=INK, width=max(2, round(0.08 * letters)))
    write(draw, (x + 1.6 * r, y - 1.2 * r), f"{1e3 * most:.1f} mm", letters, colour=INK, bold=True)
