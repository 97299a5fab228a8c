"""Pictures of moments of inertia: the wrist from the open hand to the fist, and how far tables are off at every joint."""

from __future__ import annotations

from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show.colours import BLACK, BLUE, FAINT, ORANGE, VERMILION
from handlab.show.wall_plots import heading, wall
from handlab.simulation.inertia_tables import DE_LEVA, inertia_tables, table_errors, wrist_constant, wrist_inertia_error

AXES = (("flexion", BLUE, "-"), ("deviation", VERMILION, "--"))
KG_MM2 = 1e6  # one kilogram square metre in kilogram square millimetres


def wrist_inertia(hand: Hand, *, constant: str = "relaxed") -> Any:
    """The moment of inertia of the whole hand about the wrist while it closes, and the error of the constant that stands for it.

    Section 4.1.2 takes a constant; ``constant`` names it (see ``simulation.inertia_tables.wrist_constant``). Left kg mm^2, right
    percent, from the open hand (0) to the fist (100 % closed), wrist straight.
    """
    found = wrist_inertia_error(hand, constant=constant)
    closed, inertia, error = 100.0 * found.closed, KG_MM2 * found.inertia, 100.0 * found.error
    means = ",  ".join(
        f"{name.removeprefix('de leva ')} {' / '.join(f'{KG_MM2 * value:.0f}' for value in wrist_constant(hand, name))}" for name in DE_LEVA
    )
    with wall((19.0, 10.0)) as figure:
        left, right = figure.subplots(1, 2)
        for k, (name, colour, dash) in enumerate(AXES):
            style = {"color": colour, "linestyle": dash}
            left.plot(closed, inertia[:, k], label=f"about the {name} axis", linewidth=4.0, **style)
            left.axhline(KG_MM2 * found.constant[k], linewidth=1.6, **style)
            right.plot(closed, error[:, k], label=f"about the {name} axis", linewidth=4.0, **style)
        for at, side, where in ((0, -9, "right"), (-1, 9, "left")):
            _ends(right, closed[at], error[at], side, where, close=0.06 * float(np.ptp(error)))
        line = KG_MM2 * found.constant.max()
        free = -1 if abs(inertia[-1] - line).min() > abs(inertia[0] - line).min() else 0
        where = "right" if free else "left"
        left.annotate(found_name(constant), (closed[free], line), (0, 8), textcoords="offset points", ha=where, ma=where, color=FAINT)
        low, high = min(inertia.min(), KG_MM2 * found.constant.min()), max(inertia.max(), line)
        left.set(
            title="Moment of inertia of the hand",
            xlabel="closed (%)",
            ylabel="kg mm²",
            ylim=(low - 0.4 * (high - low), high + 0.18 * (high - low)),
        )
        right.axhline(0.0, color=BLACK, linewidth=1.4)
        right.set(title="Error of the constant", xlabel="closed (%)", ylabel="% of the true value", xlim=(-20.0, 120.0))
        right.set_xticks(range(0, 101, 20))
        left.legend(loc="lower left")
        right.legend(loc="upper left")
        note = f"published means of whole hands about the wrist, flexion / deviation in kg mm²: {means} (de Leva 1996)"
        heading(figure, "The wrist carries the whole hand, and a fist is not an open hand", note)
    return figure


def _ends(axes: Any, at: float, values: Array, side: int, where: str, close: float) -> None:
    """Write the percentages at one end of the lines beside them, clear of each other."""
    near = abs(values[0] - values[1]) < close
    for k, value in enumerate(values):
        text = f"{value:+.0f} %".replace("-", "\N{MINUS SIGN}")
        if round(value) == 0 or (near and k and round(values[0]) == round(value)):
            continue
        lift = 0 if not near or round(values[0]) == round(values[1]) else 12 if value == values.max() else -12
        axes.annotate(text, (at, value), (side, lift), textcoords="offset points", ha=where, va="center")


def found_name(constant: str) -> str:
    """What a constant's name means, in words."""
    words = {"relaxed": "the relaxed hand", "open": "the open hand", "fist": "the fist"}
    return f"thin lines: the constant,\n{words.get(constant, constant)}"


def inertia_table_errors(hand: Hand, *, step_deg: float = 5.0, samples: int = 500) -> Any:
    """How far tables of section 4.1.2 are off in random postures: a row for every moving coordinate, percent on a logarithmic scale.

    Open squares: the nearest entry, as in the paper; filled dots: linear between entries. The largest of ``samples`` postures.
    Joints whose moment of inertia never changes are left out.
    """
    tables = inertia_tables(hand, step=float(np.deg2rad(step_deg)))
    both = [100.0 * np.abs(table_errors(hand, samples=samples, nearest=how, tables=tables)).max(axis=0) for how in (True, False)]
    rows = [k for k in range(len(hand.moving_names)) if both[0][k] > 1e-6]
    rows.sort(key=lambda k: float(both[1][k]))
    with wall() as figure:
        axes = figure.subplots()
        at = np.arange(len(rows))
        nearest, linear = both[0][rows], both[1][rows]
        axes.hlines(at, linear, nearest, color=FAINT, linewidth=1.8, zorder=1)
        style = {"linestyle": "", "markersize": 15}
        axes.plot(nearest, at, marker="s", label="nearest entry", color=ORANGE, markerfacecolor="white", markeredgewidth=3.5, **style)
        axes.plot(linear, at, marker="o", label="linear between entries", color=BLUE, **style)
        beside = {"xycoords": axes.get_yaxis_transform(), "va": "center"}
        for row, (one, other) in enumerate(zip(nearest, linear, strict=True)):
            axes.annotate(f"{percent(one)} / {percent(other)}", (1.01, row), **beside)
        axes.annotate("nearest / linear, %", (1.01, len(rows) - 0.2), color=FAINT, **beside)
        axes.set_xscale("log")
        axes.set_yticks(at, [hand.moving_names[k] for k in rows])
        axes.set(ylim=(-0.7, len(rows) - 0.3), xlabel="largest error of the moment of inertia (%)")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.legend(loc="lower right")
        heading(figure, f"Tables in steps of {step_deg:g} degrees against the tensors, {samples} random postures")
    return figure


def percent(value: float) -> str:
    """Two digits that count."""
    return f"{value:.0f}" if value >= 9.95 else f"{value:.1f}" if value >= 0.995 else f"{value:.2f}"
