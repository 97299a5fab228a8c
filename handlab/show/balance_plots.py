"""The torque at one joint as a ranked list that sums to what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import floor, log10
from typing import Any

from numpy.typing import ArrayLike

from handlab.anatomy.records import Hand
from handlab.anatomy.terms import find
from handlab.show.colours import BLACK, BLUE, FAINT, INK, VERMILION
from handlab.show.muscle_panel import newton_note
from handlab.show.wall_plots import SMALL, TEXT, heading, wall
from handlab.simulation.clip import Clip
from handlab.simulation.state import State
from handlab.studies.torque_parts import NONE, Part, torque_parts

MOST = 14  # parts that get a bar of their own; the rest share one
VISIBLE = 0.004  # of the largest part: a smaller one has no width on the wall


def torque_balance(
    what: Clip | Hand,
    joint: str,
    *,
    time: float | None = None,
    state: State | None = None,
    contraction: Mapping[str, float] | ArrayLike | None = None,
    gravity: ArrayLike | None = None,
) -> Any:
    """Every torque at ``joint`` (its flexion, or a degree of freedom by name), largest first; each bar begins where the last ends.

    Of a clip at ``time`` in seconds (default: its end), or of a hand in a ``state`` (default: relaxed) with contractions. The last
    bar is the net torque: what is left to turn the joint. Solid: active; hatched: passive (stretched fibres, joint, friction, and the
    weight of what it carries under ``gravity`` (3,) m/s^2: for a clip that of its laws, else none).
    """
    if isinstance(what, Clip):
        if state is not None or contraction is not None:
            raise ValueError("a clip has its own states and contractions; choose a moment of it with time=")
        frame = _frame(what, time)
        hand, state, contraction = what.hand, what.states[frame], what.contraction[frame]
        moment = f" at {what.time[frame]:.2f} s"
        gravity = what.laws.gravity if gravity is None else gravity
    else:
        from handlab.simulation.skeleton import rest

        if time is not None:
            raise ValueError("a hand has no time; give a clip, or a state=")
        hand, moment = what, ""
        state = rest(hand) if state is None else state
    dof = flexion_of(hand, joint)
    parts = shortened(
        torque_parts(hand, state, {} if contraction is None else contraction, dof, gravity=NONE if gravity is None else gravity)
    )
    with wall() as figure:
        axes = figure.subplots()
        _waterfall(axes, hand, parts, dof)
        heading(figure, f"Who turns {_joint(dof)}{moment}: torques about its {_axis(dof)}")
        figure.supxlabel(newton_note(hand), x=0.012, ha="left", fontsize=SMALL + 1, color=FAINT)
    return figure


def _frame(clip: Clip, time: float | None) -> int:
    if time is None:
        return len(clip) - 1
    if not clip.time[0] <= time <= clip.time[-1]:
        raise ValueError(f"time is {time:g} s; this clip goes from {clip.time[0]:g} to {clip.time[-1]:g} s")
    return int(abs(clip.time - time).argmin())


def flexion_of(hand: Hand, joint: str) -> str:
    """A degree of freedom by its name, or the first one of a joint: its flexion."""
    known = {name: row.dofs[0].name for name, row in hand.joints.items() if row.dofs} | {name: name for name in hand.dof_names}
    return known[find(joint, known, kind="joint or degree of freedom")]


def shortened(parts: Sequence[Part], most: int = MOST) -> list[Part]:
    """At most ``most`` parts: the largest, and all others, with those too small to see, as one."""
    seen = [part for part in parts if abs(part.torque) > VISIBLE * abs(parts[0].torque)]
    count = min(len(seen), most if len(parts) <= most and len(seen) == len(parts) else most - 1)
    kept, rest = list(parts[:count]), parts[count:]
    if not rest:
        return kept
    name = rest[0].name if len(rest) == 1 else f"{len(rest)} more"
    return [*kept, Part(name, sum(part.active for part in rest), sum(part.passive for part in rest))]


def _joint(dof: str) -> str:
    joint = dof.partition(".")[0]
    return "the wrist" if joint == "wrist" else joint


def _axis(dof: str) -> str:
    return dof.partition(".")[2].replace("_rotation", " rotation").replace("_", " and ") + " axis"


def _waterfall(axes: Any, hand: Hand, parts: Sequence[Part], dof: str) -> None:
    begin, edges = 0.0, [0.0]
    for k, part in enumerate(parts):
        colour = BLUE if part.torque > 0.0 else VERMILION
        axes.barh(k, part.active, left=begin, height=0.66, color=colour)
        axes.barh(k, part.passive, left=begin + part.active, height=0.66, color="white", edgecolor=colour, hatch="///", linewidth=1.8)
        stop = begin + part.torque
        axes.plot([stop, stop], [k - 0.33, k + 1.33], color=FAINT, linewidth=1.2, zorder=0)
        begin = stop
        edges.append(stop)
    axes.barh(len(parts), begin, height=0.66, color=BLACK)
    low, high = min(edges), max(edges)
    span = max(high - low, 1e-6)
    digits = max(0, 2 - floor(log10(max(abs(part.torque) for part in parts)))) if parts else 3
    for k, part in enumerate([*parts, Part("net torque", begin, 0.0)]):
        start = edges[k] if k < len(parts) else 0.0
        right = max(start, start + part.torque)
        words = f"{part.torque:+.{digits}f}".replace("-", "\N{MINUS SIGN}")
        weight = "bold" if k == len(parts) else "normal"
        axes.text(right + 0.012 * span, k, words, va="center", fontsize=TEXT - 1, color=INK, fontweight=weight)
    axes.axvline(0.0, color=FAINT, linewidth=1.8, zorder=0)
    own = hand.dofs[dof]
    signs = "\N{LEFTWARDS ARROW} {0}      torque (N m), each bar begins where the last ends      {1} \N{RIGHTWARDS ARROW}"
    axes.set(xlabel=signs.format(own.negative, own.positive), ylim=(len(parts) + 0.6, -0.7))
    axes.set_xlim(low - 0.04 * span, high + 0.13 * span)
    size = TEXT if len(parts) < MOST else TEXT - 2
    axes.set_yticks(range(len(parts) + 1), [*(part.name for part in parts), "net torque"], fontsize=size)
    axes.get_yticklabels()[-1].set_fontweight("bold")
    axes.grid(axis="y", visible=False)
    axes.set_axisbelow(True)
    _keys(axes)


def _keys(axes: Any) -> None:
    from matplotlib.patches import Patch

    keys = [Patch(facecolor=FAINT), Patch(facecolor="white", edgecolor=FAINT, hatch="///"), Patch(facecolor=BLACK)]
    axes.figure.legend(keys, ["active", "passive", "net"], loc="outside lower right", ncols=3, handlelength=2.0)
