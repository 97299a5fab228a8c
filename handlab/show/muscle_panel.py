"""The muscles beside a picture: by group, a bar for the contraction, its percent and the force in newtons."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show.colours import FAINT, INK, OKABE_ITO, PAPER, RULE
from handlab.show.lettering import fit, write
from handlab.show.moments import Moment, Story

ACTIVE_FROM = 0.02  # a muscle is listed if its contraction exceeds this at some time
MOST = 24  # so many fit; of more, those with the largest contraction


def regions(hand: Hand) -> dict[str, str]:
    """Every group of muscles with its colour, in the order of the table."""
    names = dict.fromkeys(muscle.region for muscle in hand.muscles.values())
    return {name: OKABE_ITO[k % len(OKABE_ITO)] for k, name in enumerate(names)}


def newton_note(hand: Hand) -> str:
    """The sentence that stands wherever a force is shown."""
    return f"newtons at {hand.newton_per_percent:g} N per % of tension (an assumption)"


def active(story: Story, samples: int = 121) -> list[int]:
    """Rows of the muscles that contract in a story, in the order of the table."""
    if story.clip is None:
        return []
    peak = np.max([moment.contraction for moment in story.sample(samples) if moment.contraction is not None], axis=0)
    busiest = [int(k) for k in np.argsort(-peak, kind="stable") if peak[k] > ACTIVE_FROM][:MOST]
    return sorted(busiest)


def panel(hand: Hand, rows: list[int], moment: Moment, size: tuple[int, int]) -> Any:
    """The panel as a Pillow image of ``size``: the muscles ``rows`` at one moment."""
    from PIL import Image, ImageDraw

    width, height = size
    image = Image.new("RGB", size, PAPER)
    draw = ImageDraw.Draw(image)
    groups = grouped(hand, rows)
    pad = width * 0.05
    unit = min(height / (len(rows) + 1.5 * len(groups) + 5.0), width * 0.085)
    y = 1.7 * unit
    write(draw, (pad, y), "muscles", 0.85 * unit, colour=INK, bold=True)
    write(draw, (width - pad, y), f"{moment.time:.2f} s", 0.8 * unit, colour=FAINT, anchor="rs")
    for name, members in groups.items():
        y += 1.55 * unit
        write(draw, (pad, y), name, 0.62 * unit, colour=FAINT)
        for row in members:
            y += unit
            draw_row(draw, hand, row, moment, regions(hand)[name], (pad, y, width - pad, unit))
    note = newton_note(hand)
    write(draw, (pad, height - 0.7 * unit), note, fit(draw, note, 0.6 * unit, width - 2 * pad), colour=FAINT)
    return image


def grouped(hand: Hand, rows: list[int]) -> dict[str, list[int]]:
    """``rows`` by group."""
    muscles = list(hand.muscles.values())
    groups: dict[str, list[int]] = {}
    for row in rows:
        groups.setdefault(muscles[row].region, []).append(row)
    return groups


def draw_row(draw: Any, hand: Hand, row: int, moment: Moment, colour: str, place: tuple[float, float, float, float]) -> None:
    """One muscle: abbreviation, bar, percent, newtons. ``place``: left, baseline, right, height."""
    left, base, right, unit = place
    muscle = hand.muscles[hand.muscle_names[row]]
    contraction, force = value(moment.contraction, row), value(moment.force, row)
    span = right - left
    write(draw, (left, base), muscle.abbreviation, 0.72 * unit, colour=INK, bold=contraction > ACTIVE_FROM)
    start, stop = left + 0.25 * span, left + 0.58 * span
    top, bottom = base - 0.52 * unit, base - 0.04 * unit
    draw.rectangle((start, top, stop, bottom), fill=RULE)
    if contraction > 0.004:
        draw.rectangle((start, top, start + contraction * (stop - start), bottom), fill=colour)
    write(draw, (left + 0.78 * span, base), f"{100 * contraction:.0f} %", 0.66 * unit, colour=INK, anchor="rs")
    write(draw, (right, base), f"{force:.0f} N", 0.66 * unit, colour=INK, anchor="rs")


def value(values: Array | None, row: int) -> float:
    """One number, 0 where muscles are not known."""
    return 0.0 if values is None else float(values[row])
