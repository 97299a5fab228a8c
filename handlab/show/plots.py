"""All 42 muscles at all 31 rotations: the signed lever arms as a map."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlab.anatomy.records import Hand
from handlab.show.colours import FAINT, RULE
from handlab.show.figures import drawing
from handlab.show.force_length_plots import force_length as force_length


def lever_arm_map(hand: Hand) -> Any:
    """Signed heat map of R (muscle, degree of freedom) in millimetres, every number written into its cell.

    Positive: flexion, radial, palmar abduction, pronation. Colour is stretched by a square root, so that small arms show.
    """
    from matplotlib.colors import PowerNorm

    arm = 1000.0 * hand.lever_arm
    reach = float(np.abs(arm).max())
    shade = np.sign(arm) * PowerNorm(0.5, 0.0, reach)(np.abs(arm))
    with drawing(figsize=(19, 15.5)) as figure:
        axes = figure.subplots()
        axes.imshow(np.ma.masked_equal(shade, 0.0), cmap="PuOr_r", vmin=-1.15, vmax=1.15, aspect="auto")
        for row, column in np.argwhere(arm):
            dark = abs(shade[row, column]) > 0.72
            axes.text(column, row, f"{arm[row, column]:+.1f}", ha="center", va="center", fontsize=9.5, color="white" if dark else "black")
        axes.set_xticks(range(len(hand.dof_names)), [spelled(name) for name in hand.dof_names], rotation=90, fontsize=11)
        axes.set_yticks(range(len(hand.muscle_names)), [muscle.abbreviation for muscle in hand.muscles.values()], fontsize=12)
        axes.tick_params(top=True, labeltop=True, bottom=False, labelbottom=False, length=0)
        axes.grid(False)
        axes.set_xticks(np.arange(-0.5, len(hand.dof_names)), minor=True)
        axes.set_yticks(np.arange(-0.5, len(hand.muscle_names)), minor=True)
        axes.grid(True, which="minor", color=RULE, linewidth=0.6)
        axes.tick_params(which="minor", length=0)
        _separate(axes, [name.partition(".")[0] for name in hand.dof_names], axes.axvline)
        _separate(axes, [muscle.region for muscle in hand.muscles.values()], axes.axhline)
        _name_groups(axes, hand)
        signs = "+ flexion, radial, palmar abduction, pronation;  − the opposite"
        axes.set_title(f"Lever arms in mm (reading: {hand.reading}).  {signs}", pad=18)
    return figure


def spelled(dof: str) -> str:
    """``mcp2.flexion_extension`` as words."""
    joint, _, motion = dof.partition(".")
    return f"{joint} {motion.replace('_rotation', ' rotation').replace('_', '/')}"


def _separate(axes: Any, labels: list[str], draw: Any) -> None:
    for k in range(1, len(labels)):
        if labels[k] != labels[k - 1]:
            draw(k - 0.5, color=FAINT, linewidth=1.4)


def _name_groups(axes: Any, hand: Hand) -> None:
    labels = [muscle.region for muscle in hand.muscles.values()]
    starts = [k for k in range(len(labels)) if k == 0 or labels[k] != labels[k - 1]]
    for start, stop in zip(starts, [*starts[1:], len(labels)], strict=True):
        if stop - start > 2:  # a lone row of another group has no room for a name
            axes.text(len(hand.dof_names) - 0.3, (start + stop - 1) / 2, labels[start], va="center", fontsize=12, color=FAINT)
