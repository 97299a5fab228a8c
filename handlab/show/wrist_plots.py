"""The strength of the fingers against the angle of the wrist."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from handlab.anatomy.records import Hand
from handlab.show.colours import BLACK, BLUE, FAINT, GREEN, ORANGE, VERMILION
from handlab.show.muscle_panel import newton_note
from handlab.show.wall_plots import TEXT, heading, wall
from handlab.studies.grip import FIST_DEG, WristForce, wrist_force

LINES: dict[str, dict[str, Any]] = {
    "all long flexors, active": {"color": BLACK, "linestyle": "-", "linewidth": 5.0},
    "deep flexors (FDP), active": {"color": BLUE, "linestyle": "--"},
    "superficial flexors (FDS), active": {"color": GREEN, "linestyle": "-."},
    "finger extensors, stretched": {"color": VERMILION, "linestyle": ":", "linewidth": 4.0},
}


def wrist_plot(hand: Hand | Mapping[str, Hand], *, fingers_deg: Mapping[str, float] = FIST_DEG) -> Any:
    """Force of the finger flexors at full contraction against the wrist's angle, fingers closed (``fingers_deg``, degrees).

    The extensors' line is what they pull back because they are stretched, without any contraction. Several hands by title, such as
    ``{"relaxed": hand, "flat": hand.with_fibre_rest("flat")}``, are shown side by side (at most three).
    """
    hands = {"": hand} if isinstance(hand, Hand) else dict(hand)
    if not 1 <= len(hands) <= 3:
        raise ValueError(f"{len(hands)} hands side by side; give one to three")
    found = {title: wrist_force(one, fingers_deg=fingers_deg) for title, one in hands.items()}
    top = 1.06 * max(max(one.flexors.max(), one.extensors.max()) for one in found.values())
    with wall() as figure:
        columns = figure.subplots(1, len(hands), sharey=True, squeeze=False)[0]
        for axes, (title, one) in zip(columns, found.items(), strict=True):
            _lines(axes, one, top)
            axes.set(title=title, xlabel="\N{LEFTWARDS ARROW} extension    wrist (degrees)    flexion \N{RIGHTWARDS ARROW}")
        columns[0].set_ylabel(f"force, {newton_note(next(iter(hands.values())))}")
        handles, words = columns[0].get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=2, handlelength=3.4)
        posture = ", ".join(f"{joint.upper()} {value:g}" for joint, value in fingers_deg.items())
        heading(figure, f"A flexed wrist weakens the grip (fingers closed: {posture} degrees)")
    return figure


def _lines(axes: Any, force: WristForce, top: float) -> None:
    values = (force.flexors, force.deep, force.superficial, force.extensors)
    for (label, style), value in zip(LINES.items(), values, strict=True):
        axes.plot(force.angle_deg, value, label=label, **style)
    best = int(np.argmax(force.flexors))
    half = force.flexors[best] / 2.0
    weak = force.angle_deg[(force.flexors < half) & (force.angle_deg > force.angle_deg[best])]
    axes.axvline(0.0, color=FAINT, linewidth=1.6, zorder=0)
    axes.set(xlim=(force.angle_deg[0], force.angle_deg[-1]), ylim=(0.0, top))
    if len(weak):
        axes.axvspan(weak[0], force.angle_deg[-1], color=ORANGE, alpha=0.13, zorder=0, linewidth=0)
        axes.text(
            force.angle_deg[-1] - 1.5, 0.985 * top, "less than half\nof its best", ha="right", va="top", fontsize=TEXT - 1, color=FAINT
        )
