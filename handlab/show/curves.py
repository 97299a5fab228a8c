"""``curves``: what muscles and joints of a clip did over time."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show.figures import drawing, line
from handlab.simulation.clip import Clip, dofs_of

MOST_LINES = 8  # more colours and dashes cannot be told apart
CHOSEN = 4  # so many muscles and joints if none are named


def curves(clip: Clip, muscles: Iterable[str] = (), joints: Iterable[str] = ()) -> Any:
    """A matplotlib figure: contraction (%), fibre length (mm, and relative to rest) of muscles, angles (degrees) of joints, over time.

    ``muscles`` by name or abbreviation; ``joints`` by joint (all its rotations that follow no other) or degree of freedom. If
    neither is given: the muscles that contract most and the joints that move most. Raises ``UnknownName`` with the nearest
    names, and ``ValueError`` for more than 8 lines in a panel.
    """
    hand = clip.hand
    rows = [hand.muscle_names.index(hand.muscles[name].name) for name in listed(muscles)]
    columns = [hand.dof_names.index(name) for name in chosen_dofs(hand, listed(joints))]
    if not rows and not columns:
        rows, columns = busiest(clip)
    for what, numbers in (("muscles", rows), ("joint angles", columns)):
        if len(numbers) > MOST_LINES:
            raise ValueError(f"{len(numbers)} {what} in one panel; choose at most {MOST_LINES}, or use clip.table() for all")
    panels = ["contraction", "length", "ratio"] * bool(rows) + ["angle"] * bool(columns)
    across = 2 if len(panels) > 1 else 1
    with drawing(figsize=(15, 9 if len(panels) > 2 else 6)) as figure:
        grid = figure.subplots((len(panels) + 1) // across, across, sharex=True, squeeze=False).ravel()
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        for axes, panel in zip(grid, panels, strict=False):
            DRAW[panel](axes, clip, columns if panel == "angle" else rows)
            axes.set_xlabel("time (s)")
            axes.set_xlim(clip.time[0], max(clip.time[-1], clip.time[0] + 1e-9))
            axes.tick_params(labelbottom=True)
    return figure


def listed(names: Iterable[str]) -> list[str]:
    """Names once each, in order; a single string is one name."""
    return list(dict.fromkeys([names] if isinstance(names, str) else names))


def chosen_dofs(hand: Hand, names: list[str]) -> list[str]:
    """Degrees of freedom by name; a joint stands for those of its own that follow no other."""
    found = [dof for name in names for dof in dofs_of(hand, [name]) if "." in name or hand.dofs[dof].driver is None]
    return list(dict.fromkeys(found))


def busiest(clip: Clip) -> tuple[list[int], list[int]]:
    """Rows of the muscles that contract most, columns of the degrees of freedom that move most."""
    moving = [clip.hand.dof_names.index(name) for name in clip.hand.moving_names]
    contraction = np.argsort(-clip.contraction.max(axis=0), kind="stable")[:CHOSEN]
    travel = np.ptp(clip.angle, axis=0)[moving]
    return sorted(int(k) for k in contraction), sorted(moving[int(k)] for k in np.argsort(-travel, kind="stable")[:CHOSEN])


def _lines(axes: Any, clip: Clip, values: Array, labels: list[str]) -> None:
    for k, label in enumerate(labels):
        axes.plot(clip.time, values[:, k], label=label, **line(k))
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _names(clip: Clip, rows: list[int]) -> list[str]:
    return [clip.hand.muscles[clip.hand.muscle_names[row]].abbreviation for row in rows]


def _contraction(axes: Any, clip: Clip, rows: list[int]) -> None:
    axes.set(title="contraction", ylabel="%", ylim=(-3, 103))
    _lines(axes, clip, 100.0 * clip.contraction[:, rows], _names(clip, rows))


def _length(axes: Any, clip: Clip, rows: list[int]) -> None:
    axes.set(title="fibre length", ylabel="mm")
    _lines(axes, clip, 1000.0 * clip.fibre_length[:, rows], _names(clip, rows))


def _ratio(axes: Any, clip: Clip, rows: list[int]) -> None:
    axes.set(title="fibre length / rest length", ylabel="1 = at rest", ylim=(0.5, 1.7))
    axes.axhspan(0.6, 1.6, color="0.95", zorder=0)
    for edge in (0.6, 1.6):
        axes.axhline(edge, color="0.45", linewidth=1.2)
    axes.text(0.01, 0.615, "a fibre pulls actively between 0.6 and 1.6", transform=axes.get_yaxis_transform(), fontsize=11, color="0.35")
    _lines(axes, clip, clip.fibre_length[:, rows] / clip.hand.rest_length[rows], _names(clip, rows))


def _angle(axes: Any, clip: Clip, columns: list[int]) -> None:
    axes.set(title="joint angles", ylabel="degrees")
    axes.axhline(0.0, color="0.45", linewidth=1.2)
    dofs = [clip.hand.dofs[clip.hand.dof_names[column]] for column in columns]
    _lines(axes, clip, np.rad2deg(clip.angle[:, columns]), [f"{dof.joint} {dof.positive} +" for dof in dofs])


DRAW = {"contraction": _contraction, "length": _length, "ratio": _ratio, "angle": _angle}
