"""Where the fibres of all 42 muscles stand on the force-length curve: in one state, or in several side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.physics.muscle import active_force_length, passive_force_length
from handlab.show.colours import BLACK, BLUE, FAINT, INK, OKABE_ITO, ORANGE, VERMILION
from handlab.show.figures import dot
from handlab.show.muscle_panel import newton_note, regions
from handlab.show.wall_plots import SMALL, TEXT, abbreviations, heading, together, wall
from handlab.simulation.state import State
from handlab.studies.excursion import ACTIVE_RANGE

MOST_STATES = 3
LOOKS = (("o", "white"), ("D", BLACK), ("s", OKABE_ITO[1]))  # marker and filling of the first, second, third state


def force_length(hand: Hand, state: State | Mapping[str, State] | None = None, *, contraction: float = 1.0) -> Any:
    """The active, passive and total force-length curve (section 4.1) with all 42 muscles of ``state`` (default: relaxed) as dots.

    Left the curves, in multiples of the maximum force, with ``contraction`` from 0 to 1 for the active part. Right every
    muscle on a line of its own, at the same length scale, with the force it would exert there in newtons. Several states by title,
    such as ``{"flat": flat, "fist": fist}``, stand side by side (at most three); below them every muscle goes from one to the next.
    """
    if not 0.0 <= contraction <= 1.0:
        raise ValueError(f"contraction is {contraction:g}; contraction values lie between 0 and 1")
    if isinstance(state, Mapping):
        if not 1 <= len(state) <= MOST_STATES:
            raise ValueError(f"{len(state)} states side by side; give one to {MOST_STATES}")
        return _several(hand, {title: one.fibre_length / hand.rest_length for title, one in state.items()}, contraction)
    if state is None:
        from handlab.simulation.skeleton import rest

        state = rest(hand)
    return _one(hand, state.fibre_length / hand.rest_length, contraction)


def share_of(ratio: Array, contraction: float) -> Array:
    """Force over maximum force at a fibre length ratio: (1')."""
    result: Array = contraction * active_force_length(ratio) + passive_force_length(ratio)
    return result


def _one(hand: Hand, ratio: Array, contraction: float) -> Any:
    with wall() as figure:
        left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
        _curves(left, contraction)
        left.set_title("force-length curve and 42 muscles")
        _dots(left, hand, ratio, contraction)
        left.legend(loc="upper left", fontsize=SMALL + 1, handlelength=2.5)
        _rows(right, hand, ratio, share_of(ratio, contraction) * hand.max_force)
        right.set_title(f"force in N at contraction {contraction:g}")
        figure.supxlabel(newton_note(hand), fontsize=SMALL + 1, color=FAINT)
    return figure


def _several(hand: Hand, ratios: Mapping[str, Array], contraction: float) -> Any:
    names = abbreviations(hand)
    with wall() as figure:
        upper, lower = figure.subfigures(2, 1, height_ratios=[1.25, 1.0])
        panels = upper.subplots(1, len(ratios), sharey=True, squeeze=False)[0]
        for axes, (title, ratio) in zip(panels, ratios.items(), strict=True):
            _curves(axes, contraction)
            _dots(axes, hand, ratio, contraction)
            slack = [name for name, one in zip(names, ratio, strict=True) if one < ACTIVE_RANGE[0]]
            axes.set(title=title, xlim=(0.2, 1.9), ylabel="")
            words = _wrapped(f"below {ACTIVE_RANGE[0]:g}, no active force: {together(slack)}") if slack else "every fibre can pull"
            axes.text(0.03, 0.97, words, transform=axes.transAxes, va="top", fontsize=TEXT - 2, color=INK)
        panels[0].set_ylabel("force / maximum force")
        handles, words = panels[0].get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=5, handlelength=2.2, columnspacing=1.3, fontsize=TEXT - 2)
        _strip(lower.subplots(), hand, ratios)
        heading(figure, "Where every fibre stands on its force-length curve")
    return figure


def _wrapped(text: str, width: int = 44) -> str:
    from textwrap import fill

    return fill(text, width)


def _curves(axes: Any, contraction: float) -> None:
    ratio = np.linspace(0.2, 1.9, 341)
    active, passive = contraction * active_force_length(ratio), passive_force_length(ratio)
    axes.plot(ratio, active, label=f"active, contraction {contraction:g}", color=BLUE)
    axes.plot(ratio, passive, label="passive", color=VERMILION, linestyle="--")
    axes.plot(ratio, active + passive, label="total", color=BLACK, linestyle=":")
    axes.set(xlabel="fibre length / rest length", ylabel="force / maximum force", xlim=(0.4, 1.8), ylim=(-0.05, 1.6))


def _dots(axes: Any, hand: Hand, ratio: Array, contraction: float) -> None:
    share = share_of(ratio, contraction)
    axes.set_xlim(min(0.4, float(ratio.min()) - 0.05), max(1.8, float(ratio.max()) + 0.05))
    for k, name in enumerate(regions(hand)):
        rows = [i for i, muscle in enumerate(hand.muscles.values()) if muscle.region == name]
        axes.scatter(ratio[rows], share[rows], s=120, label=name, zorder=3, edgecolors="white", linewidths=1.0, clip_on=False, **dot(k))


def _rows(axes: Any, hand: Hand, ratio: Array, force: Array) -> None:
    group = {name: k for k, name in enumerate(regions(hand))}
    for row, muscle in enumerate(hand.muscles.values()):
        axes.plot(ratio[row], row, markersize=10, linestyle="", markeredgecolor="white", **dot(group[muscle.region]))
        axes.text(1.01, row, f"{force[row]:.0f}", transform=axes.get_yaxis_transform(), va="center", fontsize=SMALL, color=INK)
    for edge in (ACTIVE_RANGE[0], 1.0, ACTIVE_RANGE[1]):
        axes.axvline(edge, color="0.45", linewidth=1.2, zorder=0)
    low, high = min(0.5, float(ratio.min()) - 0.05), max(1.7, float(ratio.max()) + 0.05)
    axes.set(xlabel="fibre length / rest length", xlim=(low, high), ylim=(len(ratio) - 0.4, -0.6))
    axes.set_yticks(range(len(ratio)), abbreviations(hand), fontsize=SMALL)
    axes.grid(axis="x", visible=False)


def _strip(axes: Any, hand: Hand, ratios: Mapping[str, Array]) -> None:
    """All muscles beside each other; a line leads from the first state to the last."""
    table = np.array(list(ratios.values()))
    column = np.arange(table.shape[1])
    axes.axhspan(*ACTIVE_RANGE, color=ORANGE, alpha=0.13, zorder=0, linewidth=0)
    axes.vlines(column, table.min(axis=0), table.max(axis=0), color=FAINT, linewidth=2.0, zorder=1)
    for (title, ratio), (marker, fill) in zip(ratios.items(), LOOKS, strict=False):
        how = {"marker": marker, "markerfacecolor": fill, "markeredgecolor": BLACK, "markeredgewidth": 1.8, "markersize": 10}
        axes.plot(column, ratio, linestyle="", label=title, zorder=3, **how)
    axes.axhline(1.0, color=FAINT, linewidth=1.6, zorder=0)
    low, high = min(0.5, float(table.min()) - 0.06), max(1.7, float(table.max()) + 0.06)
    axes.set(xlim=(-0.8, len(column) - 0.2), ylim=(low, high), ylabel="fibre length\n/ rest length")
    axes.set_yticks([0.6, 1.0, 1.6], ["0.6", "1", "1.6"])
    axes.set_xticks(column, abbreviations(hand), rotation=90, fontsize=SMALL + 1)
    axes.grid(axis="x", visible=False)
    axes.set_title("an active fibre pulls in the shaded range", fontweight="normal", fontsize=TEXT - 1)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(ratios), borderaxespad=0.0, handletextpad=0.1, fontsize=TEXT - 1)
