"""Figures for the wall of a lecture hall: 19 x 12 inches, large letters, and labels that find a free place for themselves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show.colours import FAINT, INK
from handlab.show.figures import drawing

SIZE = (19.0, 12.0)
# The smallest letters are 1.6 % of the picture's height: about 10 minutes of arc from ten metres at a screen of two metres.
SMALL, TEXT, TITLE = 14.0, 18.0, 21.0
LETTERS = {
    "font.size": TEXT,
    "axes.titlesize": TITLE,
    "axes.labelsize": TEXT + 1,
    "xtick.labelsize": TEXT - 1,
    "ytick.labelsize": TEXT - 1,
    "legend.fontsize": TEXT - 1,
    "figure.titlesize": TITLE + 3,
    "hatch.linewidth": 1.6,
}
# Where a label may stand beside its dot: directions, and gaps in points.
DIRECTIONS = 16
GAPS = (3.0, 9.0, 18.0, 30.0, 45.0, 62.0)
SWEEPS = 6


@contextmanager
def wall(size: tuple[float, float] = SIZE) -> Iterator[Any]:
    """A figure of ``size`` inches in the house style with letters for the last row."""
    import matplotlib.pyplot as plt

    with drawing(figsize=size) as figure, plt.rc_context(LETTERS):
        figure.get_layout_engine().set(w_pad=0.14, h_pad=0.12, wspace=0.03, hspace=0.03)
        yield figure


def heading(figure: Any, title: str, note: str = "") -> None:
    """The title above everything, and a fainter line below everything."""
    figure.suptitle(title, x=0.012, ha="left", fontweight="bold")
    if note:
        figure.supxlabel(note, fontsize=SMALL + 1, color=FAINT)


def together(names: Sequence[str]) -> str:
    """Names of one place as one label: ``FDP2``, ``FDP3``, ``FDP4`` become ``FDP 2 3 4``.

    >>> together(["FDP2", "FDP3", "EIP", "DI1"])
    'FDP 2 3, EIP, DI1'
    """
    families: dict[str, list[str]] = {}
    for name in names:
        families.setdefault(name.rstrip("0123456789"), []).append(name)
    return ", ".join(
        group[0] if len(group) == 1 else f"{family} {' '.join(name.removeprefix(family) for name in group)}"
        for family, group in families.items()
    )


def abbreviations(hand: Hand) -> list[str]:
    """Abbreviations (muscle,) in the order of every array."""
    return [muscle.abbreviation for muscle in hand.muscles.values()]


def same_places(points: Array, near: float = 1e-9) -> list[list[int]]:
    """Rows of ``points`` (N, 2) that lie on one another, as groups in order of their first member."""
    groups: list[list[int]] = []
    for k, point in enumerate(points):
        own = next((group for group in groups if np.abs(points[group[0]] - point).max() <= near), None)
        if own is None:
            groups.append([k])
        else:
            own.append(k)
    return groups


def label_dots(
    axes: Any, points: Array, texts: Sequence[str], *, radius: Sequence[float] | float = 8.0, size: float = TEXT - 1
) -> list[Any]:
    """Write ``texts`` beside ``points`` (N, 2) in data coordinates, clear of one another and of the dots (``radius`` in points each).

    Call it when nothing else of the figure will change: places are found in the drawn layout. A label that had to go away from its
    dot is tied to it by a line. The annotations.
    """
    from matplotlib.patheffects import withStroke

    figure = axes.figure
    figure.draw_without_rendering()
    scale = 72.0 / figure.dpi
    at = axes.transData.transform(np.asarray(points, dtype=np.float64)) * scale
    reach = np.broadcast_to(np.asarray(radius, dtype=np.float64), len(at))
    how: dict[str, Any] = {"textcoords": "offset points", "fontsize": size, "ha": "center", "va": "center", "color": INK, "zorder": 6}
    how["path_effects"] = [withStroke(linewidth=4.0, foreground="white")]  # a line that passes behind stays behind
    made = [axes.annotate(text, xy=point, xytext=(0, 0), **how) for text, point in zip(texts, points, strict=True)]
    renderer = figure.canvas.get_renderer()
    extent = [note.get_window_extent(renderer) for note in made]
    half = np.array([[box.width, box.height] for box in extent]) * scale / 2.0 + 1.5
    frame = np.array([axes.bbox.min, axes.bbox.max]) * scale
    middle = places(at, reach, half, frame)
    for note, here, there, far, box in zip(made, at, middle, reach, half, strict=True):
        note.set_position(tuple(there - here))
        note.set_in_layout(False)
        edge = np.clip(here, there - box, there + box)
        if np.linalg.norm(edge - here) > far + 7.0:
            start = axes.transData.inverted().transform((here + far * (edge - here) / np.linalg.norm(edge - here)) / scale)
            stop = axes.transData.inverted().transform(edge / scale)
            axes.plot(*np.transpose([start, stop]), color=FAINT, linewidth=1.2, zorder=2.5, scalex=False, scaley=False)
    return made


def places(at: Array, reach: Array, half: Array, frame: Array) -> Array:
    """Middles (N, 2) for boxes of half size ``half`` (N, 2) beside dots ``at`` (N, 2) of radius ``reach`` (N,) inside ``frame`` (2, 2).

    Every box takes the cheapest of its candidates against all others, a few times over: overlap with a box counts most, then with a
    dot, then distance. All in one unit.
    """
    turn = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    way = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    options = []
    for here, far, box in zip(at, reach, half, strict=True):
        # along each direction until the box's nearest edge clears the dot
        clear = np.min(np.where(np.abs(way) > 1e-9, box / np.maximum(np.abs(way), 1e-9), np.inf), axis=1)
        options.append(np.concatenate([here + way * (far + gap + clear)[:, None] for gap in GAPS]))
    gap = np.repeat(GAPS, DIRECTIONS)
    level = np.tile(0.8 * np.abs(way[:, 1]) + 0.4 * (way[:, 0] < 0.0), len(GAPS))  # beside is easier to read than above, right than left
    crowd = (np.linalg.norm(at[:, None] - at[None], axis=2) < 60.0).sum(axis=1)
    middle = np.array([choice[0] for choice in options])
    placed = np.zeros(len(at), dtype=bool)
    for _ in range(SWEEPS):
        for k in np.argsort(-crowd, kind="stable"):
            others = placed.copy()
            others[k] = False
            cost = 0.12 * gap + level
            cost = cost + 40.0 * overlap(options[k], half[k], middle[others], half[others]).sum(axis=1)
            square = np.stack([reach, reach], axis=1) * 0.9
            cost = cost + 6.0 * overlap(options[k], half[k], at, square).sum(axis=1)
            outside = np.maximum(frame[0] - (options[k] - half[k]), 0.0) + np.maximum(options[k] + half[k] - frame[1], 0.0)
            cost = cost + 100.0 * outside.sum(axis=1)
            middle[k] = options[k][int(np.argmin(cost))]
            placed[k] = True
    return middle


def overlap(middle: Array, half: Array, others: Array, other_half: Array) -> Array:
    """Square root of the area (n, m) that boxes at ``middle`` (n, 2) share with boxes at ``others`` (m, 2)."""
    apart = np.abs(middle[:, None] - others[None])
    shared = np.maximum(0.0, np.minimum(half + other_half - apart, 2.0 * np.minimum(half, other_half)))
    result: Array = np.sqrt(shared[..., 0] * shared[..., 1])
    return result
