"""Two pictures of all 42 muscles: the signed lever arms, and where every fibre stands on the force-length curve."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.physics.muscle import active_force_length, passive_force_length
from handlab.show.colours import BLACK, BLUE, FAINT, INK, RULE, VERMILION
from handlab.show.figures import dot, drawing
from handlab.show.muscle_panel import newton_note, regions
from handlab.simulation.state import State


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


def force_length(hand: Hand, state: State | None = None, *, contraction: float = 1.0) -> Any:
    """The active, passive and total force-length curve (section 4.1) with all 42 muscles of ``state`` (default: relaxed) as dots.

    Left the curves, in multiples of the maximum force, with ``contraction`` from 0 to 1 for the active part. Right every
    muscle on a line of its own, at the same length scale, with the force it would exert there in newtons.
    """
    if not 0.0 <= contraction <= 1.0:
        raise ValueError(f"contraction is {contraction:g}; contraction values lie between 0 and 1")
    if state is None:
        from handlab.simulation.skeleton import rest

        state = rest(hand)
    ratio: Array = state.fibre_length / hand.rest_length
    share: Array = contraction * active_force_length(ratio) + passive_force_length(ratio)
    group = {name: k for k, name in enumerate(regions(hand))}
    with drawing(figsize=(19, 12)) as figure:
        left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
        _curves(left, contraction)
        for name, k in group.items():
            rows = [i for i, muscle in enumerate(hand.muscles.values()) if muscle.region == name]
            left.scatter(ratio[rows], share[rows], s=110, label=name, zorder=3, edgecolors="white", linewidths=1.0, **dot(k))
        left.legend(loc="upper left", fontsize=13, handlelength=2.5)
        _rows(right, hand, ratio, share * hand.max_force, group)
        right.set_title(f"force in N at contraction {contraction:g}")
        figure.supxlabel(newton_note(hand), fontsize=13, color=FAINT)
    return figure


def _curves(axes: Any, contraction: float) -> None:
    ratio = np.linspace(0.4, 1.8, 281)
    active, passive = contraction * active_force_length(ratio), passive_force_length(ratio)
    axes.plot(ratio, active, label=f"active, contraction {contraction:g}", color=BLUE)
    axes.plot(ratio, passive, label="passive", color=VERMILION, linestyle="--")
    axes.plot(ratio, active + passive, label="total", color=BLACK, linestyle=":")
    axes.set(title="force-length curve and 42 muscles", xlabel="fibre length / rest length", ylabel="force / maximum force")
    axes.set(xlim=(0.4, 1.8), ylim=(-0.05, 1.6))


def _rows(axes: Any, hand: Hand, ratio: Array, force: Array, group: dict[str, int]) -> None:
    for row, muscle in enumerate(hand.muscles.values()):
        axes.plot(ratio[row], row, markersize=9, linestyle="", markeredgecolor="white", **dot(group[muscle.region]))
        axes.text(1.01, row, f"{force[row]:.0f}", transform=axes.get_yaxis_transform(), va="center", fontsize=11, color=INK)
    for edge in (0.6, 1.0, 1.6):
        axes.axvline(edge, color="0.45", linewidth=1.2, zorder=0)
    low, high = min(0.5, float(ratio.min()) - 0.05), max(1.7, float(ratio.max()) + 0.05)
    axes.set(xlabel="fibre length / rest length", xlim=(low, high), ylim=(len(ratio) - 0.4, -0.6))
    axes.set_yticks(range(len(ratio)), [muscle.abbreviation for muscle in hand.muscles.values()], fontsize=11)
    axes.grid(axis="x", visible=False)
