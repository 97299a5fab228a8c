"""What the joints ask of every fibre beside what it can give: required against potential excursion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from handlab.anatomy.records import Hand
from handlab.show.colours import BLACK, BLUE, GREEN, INK, ORANGE, PURPLE, SKY
from handlab.show.wall_plots import SMALL, abbreviations, heading, wall
from handlab.studies.excursion import LEVELS, potential_excursion, required_excursion

# A level of joints: colour and hatching, so that colour is never alone.
LOOK = dict(zip(LEVELS, ((BLUE, ""), (PURPLE, "xx"), (ORANGE, "//"), (GREEN, "\\\\"), (SKY, "..")), strict=True))


def excursion_plot(hand: Hand) -> Any:
    """Bars: how far every muscle must shorten for its joints to go from limit to limit; diamonds: what its fibre can, its rest length.

    A muscle whose bar passes its diamond cannot serve all its joints at once; the ratio stands behind it.
    """
    required, potential = required_excursion(hand), potential_excursion(hand)
    group = [muscle.group for muscle in hand.muscles.values()]
    with wall() as figure:
        columns = figure.subplots(1, 2)
        for axes, name in zip(columns, ("extrinsic", "intrinsic"), strict=True):
            rows = [k for k, one in enumerate(group) if one == name]
            _bars(axes, rows, abbreviations(hand), {level: 1000.0 * mm for level, mm in required.items()}, 1000.0 * potential)
            axes.set_title(f"{name} muscles")
        handles, words = columns[0].get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=len(words), handlelength=2.0, columnspacing=1.3)
        heading(figure, "Excursion: what the joints ask, and what the fibre can give")
    return figure


def _bars(axes: Any, rows: Sequence[int], names: Sequence[str], required: dict[str, Any], potential: Any) -> None:
    line = np.arange(len(rows))
    begin = np.zeros(len(rows))
    for level, mm in required.items():
        colour, hatch = LOOK[level]
        axes.barh(line, mm[rows], left=begin, height=0.72, color=colour, hatch=hatch, edgecolor="white", linewidth=0.0, label=level)
        begin = begin + mm[rows]
    axes.plot(potential[rows], line, marker="D", markersize=11, linestyle="", color=BLACK, markeredgecolor="white", label="the fibre can")
    right = 1.16 * max(begin.max(), potential[rows].max())
    for k, (need, can) in enumerate(zip(begin, potential[rows], strict=True)):
        if need > can:
            axes.text(max(need, can) + 0.02 * right, k, f"{need / can:.2f} times", va="center", fontsize=SMALL + 1, color=INK)
    axes.set_yticks(line, [names[k] for k in rows], fontsize=SMALL + 2)
    axes.set(xlabel="excursion (mm)", xlim=(0.0, right), ylim=(len(rows) - 0.4, -0.6))
    axes.grid(axis="y", visible=False)
    axes.set_axisbelow(True)
