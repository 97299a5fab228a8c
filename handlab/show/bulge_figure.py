"""Figure 5: one pose with muscles off and on, the difference in millimetres in colour, and a cut through it. Nothing is exaggerated."""

from __future__ import annotations

import os
from collections.abc import Iterable
from math import radians, tan
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.show.colours import FAINT, INK, PAPER, VERMILION
from handlab.show.lettering import fit, write
from handlab.show.moments import Moment
from handlab.show.outputs import checked
from handlab.show.scene import Scene
from handlab.show.section_picture import Cut, Plane, muscle_cuts, scale_bar
from handlab.show.sheet import store
from handlab.show.views import LENS_DEG, Camera, camera, view_name
from handlab.simulation.clip import Clip
from handlab.simulation.geometric_muscle import geometric_muscles, shape
from handlab.simulation.keyframes import clips
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.play import simulate
from handlab.simulation.skin import fine_points, normals
from handlab.studies.swelling import Swelling, swelling

STEP_MM = 0.5  # from one box of the legend to the next
MOST_MM = 2.5  # more is drawn in the last colour
# From the paper's grey to Okabe and Ito's orange and vermilion where skin rises, to their blue where it sinks.
RISE = np.array([[222, 222, 218], [240, 205, 130], [230, 159, 0], [213, 94, 0], [150, 50, 0]], dtype=float)
SINK = np.array([[222, 222, 218], [86, 180, 233], [0, 114, 178]], dtype=float)
NEAR, TILT_DEG = 0.25, -15.0  # metres from the place that rises most, and how far from straight above it: the web is seen from the side
CUT_WIDTH = 0.058  # metres across the section
MUSCLE_ON, MUSCLE_OFF = "#C8685C", "#7A2020"
LINES = (
    (VERMILION, 1, "skin, contracted"),
    (INK, 3, "skin, at rest"),
    (MUSCLE_ON, 1, "muscle, contracted"),
    (MUSCLE_OFF, 3, "muscle, at rest"),
)  # colour, pieces of a dashed line, text


def bulge_figure(
    hand: Hand,
    clip: Clip | str = "key-pinch",
    muscles: str | Iterable[str] = "DI1",
    path: str | os.PathLike[str] | None = None,
    *,
    level: float = 1.0,
    view: str | None = None,
    size: tuple[int, int] = (1800, 1200),
) -> Any:
    """One pose with ``muscles`` off and on, as a Pillow image: both skins, the rise between them in colour, a section across it.

    The pose is the last of ``clip`` (or of the clip of that name); ``muscles`` by name or abbreviation are at 0 and at ``level``, all
    others as in the clip. The camera stands near the place that rises most, unless ``view`` names a view of the whole hand. Written to
    ``path`` (.png) if one is given. The numbers are those of ``studies.swelling``; all pictures are to scale.
    """
    from PIL import Image, ImageDraw

    out = None if path is None else checked(path, [".png"])
    seen = None if view is None else view_name(view)
    played = simulate(hand, find(clip, clips(), kind="clip")) if isinstance(clip, str) else clip
    found = swelling(hand, played.angle[-1], played.contraction[-1], muscles, level=level)
    letters = 0.020 * size[0]
    head, width = round(2.2 * letters), size[0] // 3
    height = round(0.56 * (size[1] - head))
    aim = close_up(hand, found) if seen is None else camera(hand, seen, [found.off, found.on], width / height)
    image = Image.new("RGB", size, PAPER)
    draw = ImageDraw.Draw(image)
    for k, picture in enumerate(drawn(hand, found, aim, (width, height))):
        image.paste(Image.fromarray(picture), (k * width, head))
    names = ", ".join(hand.muscles[name].abbreviation for name in found.muscles)
    for k, title in enumerate((f"{names} at rest", f"{names} at {100 * level:.0f} %", "how far the skin rises")):
        write(draw, (k * width + letters, 1.5 * letters), title, fit(draw, title, letters, width - 2 * letters), colour=INK, bold=True)
    mark(draw, found, aim, (2 * width, head, width, height), letters)
    below = (0, head + height, size[0], size[1] - head - height)
    across(image, draw, hand, found, below, letters)
    legend(draw, found, (size[0] - 5.5 * letters, size[1] - 1.2 * letters), letters)
    note = f"{names} in {played.name or 'the clip'}: bones and camera are the same in all pictures, and nothing is exaggerated"
    write(draw, (letters, size[1] - 0.7 * letters), note, fit(draw, note, 0.62 * letters, 2 * width), colour=FAINT)
    if out is not None:
        store(image, out)
    return image


def fibre_way(hand: Hand, found: Swelling) -> Array:
    """Mean direction (3,) of the fibres that swell, towards the fingertips."""
    every = geometric_muscles(hand)
    frame = shape(every, relative_transforms(hand, found.angle), found.contraction).frame
    both, wanted = zip(every.segments, every.drives, strict=True), set(found.muscles)
    own = [np.arange(part.start, part.stop) for part, drives in both if wanted & set(drives)]
    way: Array = frame[np.concatenate(own), :, 0].mean(axis=0) if own else np.array([1.0, 0.0, 0.0])
    return way / (np.linalg.norm(way) * (1.0 if way[0] > 0.0 else -1.0))


def upright(hand: Hand, found: Swelling) -> tuple[Array, Array, Array]:
    """At the place that rises most: unit vectors out of the skin, along the fibres and across them, towards the fingers' side."""
    out = normals(hand, found.off)[found.most[1]]
    along = fibre_way(hand, found)
    along = along - out * (along @ out)
    along /= np.linalg.norm(along)
    return out, along, np.cross(along, out)


def close_up(hand: Hand, found: Swelling) -> Camera:
    """From near the place that rises most, a little from the side, fingertips up."""
    out, along, side = upright(hand, found)
    to_eye = np.cos(radians(TILT_DEG)) * out + np.sin(radians(TILT_DEG)) * side * (1.0 if hand.side == "right" else -1.0)
    up = along - to_eye * (along @ to_eye)
    up /= np.linalg.norm(up)
    return Camera(to_eye, up, np.cross(up, to_eye), found.off[found.most[1]], NEAR)


def drawn(hand: Hand, found: Swelling, aim: Camera, size: tuple[int, int]) -> list[Any]:
    """The skin off, on, and on in the colours of its rise."""
    pictures = []
    with Scene(hand, skin="solid", view="palm", size=size, quality="still", light="raking") as scene:
        scene.set(view=aim)
        for points in (found.off, found.on):
            scene.pose(Moment(0.0, points, found.angle))
            pictures.append(scene.picture())
    with Scene(hand, skin="solid", view="palm", size=size, quality="still") as scene:
        scene.set(view=aim)
        scene.pose(Moment(0.0, found.on, found.angle))
        scene.tint(colours(1e3 * on_fine(hand, found.rise)))
        pictures.append(scene.picture())
    return pictures


def across(image: Any, draw: Any, hand: Hand, found: Swelling, place: tuple[int, int, int, int], letters: float) -> None:
    """The section across the muscle through the place that rises most: skin and muscle at rest dashed, contracted drawn out."""
    left, top, width, height = place
    out, _, side = upright(hand, found)
    thumb_left = side if hand.side == "right" else -side
    plane = Plane(found.on[found.most[1]], thumb_left, out)
    wide = round(0.62 * width)
    cut = Cut(plane, (wide, height - round(1.6 * letters)), CUT_WIDTH, (0.0, -0.0095))
    rest = np.where([name in found.muscles for name in hand.muscle_names], 0.0, found.contraction)
    faces = hand.skin_fine.faces
    relaxed, swollen = (plane.cut(fine_points(hand, points), faces) for points in (found.off, found.on))
    cut.fill(swollen, "#F6DDD0")
    cut.bones(hand, found.angle)
    cut.fill(muscle_cuts(hand, plane, found.angle, found.contraction, found.muscles), MUSCLE_ON)
    cut.line(muscle_cuts(hand, plane, found.angle, rest, found.muscles), MUSCLE_OFF, 0.09 * letters, dashed=True)
    cut.line(relaxed, INK, 0.09 * letters, dashed=True)
    cut.line(swollen, VERMILION, 0.12 * letters)
    image.paste(cut.picture(), (left, top))
    write(draw, (left + letters, top + 1.3 * letters), "a cut across the muscle", 0.9 * letters, colour=INK, bold=True)
    scale_bar(draw, (left + 0.64 * width, top + height - 2.0 * letters), 1e-3 * wide / CUT_WIDTH, letters)
    key(draw, (left + 0.64 * width, top + 2.0 * letters), letters)


def key(draw: Any, corner: tuple[float, float], letters: float) -> None:
    """What the lines of the section are."""
    x, y = corner
    for colour, pieces, text in LINES:
        for part in range(pieces):
            begin, span = x + part * 2.0 * letters / pieces, 2.0 * letters / pieces
            draw.line([(begin, y), (begin + span * (0.6 if pieces > 1 else 1.0), y)], fill=colour, width=max(2, round(0.14 * letters)))
        write(draw, (x + 2.5 * letters, y + 0.25 * letters), text, 0.72 * letters, colour=INK)
        y += 1.4 * letters


def on_fine(hand: Hand, values: Array) -> Array:
    """Values (N,) of the even skin at the points (Nf,) of the fine one."""
    fine = hand.skin_fine
    result: Array = np.einsum("ni,ni->n", fine.barycentric, values[hand.skin.faces[fine.triangle]])
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
    steps(draw, range(min(low, 0), max(high, 1) + 1), corner, letters)


def steps(draw: Any, numbers: Iterable[int], corner: tuple[float, float], letters: float, factor: float = 1.0) -> None:
    """A box for every step of the colours, from below upwards; one stands for ``factor`` times as many millimetres."""
    x, y = corner
    for k in numbers:
        y -= letters
        box = (x, y, x + 1.3 * letters, y + 0.8 * letters)
        draw.rectangle(box, fill=tuple(int(v) for v in colours(np.array([k * STEP_MM]))[0]))
        text = f"{k * STEP_MM * factor:+.1f} mm" if k else "0"
        write(draw, (x + 1.6 * letters, y + 0.7 * letters), text.replace("-", "−"), 0.72 * letters, colour=INK)


def mark(draw: Any, found: Swelling, aim: Camera, place: tuple[int, int, int, int], letters: float) -> None:
    """A ring and the number where the skin rises most."""
    most, k = found.most
    left, top, width, height = place
    way = found.on[k] - aim.position
    depth = -float(way @ aim.to_eye)
    scale = 0.5 * height / tan(radians(LENS_DEG / 2)) / depth
    x, y = left + width / 2 + scale * float(way @ aim.right), top + height / 2 - scale * float(way @ aim.up)
    r = 0.35 * letters
    draw.ellipse((x - r, y - r, x + r, y + r), outline=INK, width=max(2, round(0.08 * letters)))
    write(draw, (x + 1.6 * r, y - 1.2 * r), f"{1e3 * most:.1f} mm", letters, colour=INK, bold=True)
