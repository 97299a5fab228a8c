"""How long a time step may be: the printed explicit step against the implicit one, joint by joint."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show.colours import BLACK, BLUE, FAINT, GREEN, INK, VERMILION
from handlab.show.wall_plots import SMALL, TEXT, heading, wall
from handlab.simulation.laws import SUBSTEP
from handlab.simulation.state import State
from handlab.studies.step_limits import speed_factor, step_limits

STEPS_MS = {"step of this package": 1000.0 * SUBSTEP, "60 pictures a second": 1000.0 / 60.0}
SHOWN = {"dip2.flexion_extension": (BLUE, "-"), "pip2.flexion_extension": (GREEN, "--"), "wrist.flexion_extension": (BLACK, "-.")}


def step_plot(hand: Hand, state: State | None = None) -> Any:
    """Longest stable time step 2 J / mu of the printed explicit friction for every rotation, and what one step does to the speed.

    Right of its dot a joint runs away as printed. Below, the factor by which friction alone changes the speed in one step of the
    printed rule (beyond -1 it grows and changes its sign) and of the implicit one (always between 0 and 1).
    """
    limit = 1000.0 * step_limits(hand, state)
    with wall() as figure:
        left, right = figure.subplots(1, 2, width_ratios=[1.25, 1.0])
        _limits(left, hand, limit)
        _factors(right, hand, limit)
        handles, words = right.get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower right", ncols=3, handlelength=3.4, columnspacing=1.4)
        heading(figure, "How long may a time step be?")
    return figure


def _limits(axes: Any, hand: Hand, limit: Array) -> None:
    order = np.argsort(limit, kind="stable")
    line = np.arange(len(order))
    left, right = 0.6 * float(limit.min()), max(8.0 * float(limit.max()), 600.0)
    axes.hlines(line, limit[order], right, color=VERMILION, alpha=0.22, linewidth=9.0)
    axes.hlines(line, left, limit[order], color=BLUE, alpha=0.35, linewidth=9.0)
    axes.plot(limit[order], line, "o", markersize=11, color=INK, zorder=3)
    for (name, ms), side in zip(STEPS_MS.items(), (-1, 1), strict=True):
        axes.axvline(ms, color=BLACK, linewidth=2.2, linestyle="--")
        where: dict[str, Any] = {"ha": "right" if side < 0 else "left", "va": "center", "fontsize": TEXT - 1, "color": INK}
        axes.text(ms * 1.15**side, len(order) + 0.55, f"{name}\n{ms:.3g} ms", linespacing=1.15, **where)
    axes.set(xscale="log", xlim=(left, right), ylim=(len(order) + 1.7, -0.7), xlabel="time step (ms)")
    ticks = [one for one in (0.001, 0.01, 0.1, 1.0, 10.0, 100.0, 1000.0) if left <= one <= right]
    axes.set_xticks(ticks, [f"{one:g}" for one in ticks])
    axes.set_yticks(line, [short(hand.moving_names[k]) for k in order], fontsize=SMALL + 1)
    axes.grid(axis="y", visible=False)
    axes.set_title("printed step: calm (blue) up to the dot, 2 J / \N{GREEK SMALL LETTER MU}")


def short(dof: str) -> str:
    """``mcp2.flexion_extension`` as ``mcp2 flexion``."""
    joint, _, motion = dof.partition(".")
    return f"{joint} {motion.partition('_')[0]}"


def _factors(axes: Any, hand: Hand, limit: Array) -> None:
    dt = np.geomspace(0.003, 40.0, 400)
    for name, (colour, dash) in SHOWN.items():
        rate = 2.0 / limit[hand.moving_names.index(hand.dofs[name].name)]
        printed = speed_factor(dt, rate, implicit=False)
        axes.plot(dt, np.where(printed > -4.0, printed, np.nan), color=colour, linestyle=dash, label=f"{short(name)}, printed")
        axes.plot(
            dt,
            speed_factor(dt, rate, implicit=True),
            color=colour,
            linestyle=dash,
            alpha=0.4,
            linewidth=6.0,
            label=f"{short(name)}, implicit",
        )
    axes.axhspan(-4.0, -1.0, color=VERMILION, alpha=0.13, zorder=0, linewidth=0)
    axes.text(0.02, -3.9, "runs away", transform=axes.get_yaxis_transform(), va="bottom", fontsize=TEXT, color=INK)
    axes.text(0.02, -0.95, "swings", transform=axes.get_yaxis_transform(), va="bottom", fontsize=TEXT, color=INK)
    axes.axhline(0.0, color=FAINT, linewidth=1.6)
    axes.set(xscale="log", xlabel="time step (ms)", ylabel="speed after one step / before", ylim=(-4.0, 1.15), xlim=(dt[0], dt[-1]))
    axes.set_xticks([0.01, 0.1, 1.0, 10.0], ["0.01", "0.1", "1", "10"])
    axes.set_title("what friction does in one step")
