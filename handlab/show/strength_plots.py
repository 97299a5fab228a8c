"""How strong, how long, and in which direction: Brand's plot of tension and fibre length, and lever arms of two rotations as a map."""

from __future__ import annotations

from collections.abc import Iterable
from math import pi
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, DegreeOfFreedom, Hand
from handlab.anatomy.terms import find
from handlab.show.colours import FAINT, INK, RULE
from handlab.show.figures import dot
from handlab.show.muscle_panel import newton_note, regions
from handlab.show.wall_plots import TEXT, abbreviations, heading, label_dots, same_places, together, wall

# The area under the active force-length curve from 0.6 to 1.6: work of one full contraction over F_max l0.
WORK = 2.0 / 3.0
JOULES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
DISC = 150.0  # points^2 of a disc for 1 % of tension
SIZES = (1.0, 3.0, 6.0)  # % of the discs that the key shows
EDGE = 0.09  # of a map's width stays free on every side


def brand_plot(hand: Hand) -> Any:
    """Brand's plot: tension fraction against fibre length of all 42 muscles, with lines of equal work.

    Both axes are logarithmic, so that muscles that can do the same work (2/3 F_max l0 from 1.6 to 0.6 of the rest length) lie on
    straight lines. Strong and short is top left, weak and far-reaching bottom right.
    """
    length = 1000.0 * hand.rest_length
    tension = np.array([muscle.tension_percent for muscle in hand.muscles.values()])
    points = np.stack([length, tension], axis=1)
    with wall() as figure:
        axes = figure.subplots()
        axes.set(xscale="log", yscale="log", xlim=(13.0, 106.0), ylim=(0.08, 9.0))
        axes.set(
            xlabel="fibre length at rest (mm): how far it can move", ylabel="tension fraction (% of all muscles): how hard it can pull"
        )
        _plain_ticks(axes.xaxis, (15, 20, 30, 40, 50, 60, 80, 100))
        _plain_ticks(axes.yaxis, (0.1, 0.2, 0.5, 1, 2, 5))
        _equal_work(axes, hand)
        for k, name in enumerate(regions(hand)):
            rows = [i for i, muscle in enumerate(hand.muscles.values()) if muscle.region == name]
            axes.scatter(length[rows], tension[rows], s=190, label=name, zorder=3, edgecolors="white", linewidths=1.2, **dot(k))
        axes.legend(loc="lower left", ncols=2, columnspacing=1.2, handletextpad=0.3, labelspacing=0.35)
        heading(
            figure,
            "Force or excursion: what a muscle is built for",
            f"work of one full contraction from 1.6 to 0.6 of the rest length; {newton_note(hand)}",
        )
        _label(axes, hand, points, radius=7.5)
    return figure


def _plain_ticks(axis: Any, values: Iterable[float]) -> None:
    axis.set_ticks(list(values), [f"{value:g}" for value in values])
    axis.set_ticks([], minor=True)


def _equal_work(axes: Any, hand: Hand) -> None:
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    for joule in JOULES:
        product = joule / (WORK * 1e-3 * hand.newton_per_percent)  # mm times percent
        ends = max(left, product / top), min(right, product / bottom)
        axes.plot(ends, [product / end for end in ends], color=FAINT, linewidth=1.3, linestyle=(0, (5, 4)), zorder=1)
        if product / right > bottom:
            words = f"{joule:g} J"
            axes.text(1.005 * right, product / right, words, va="center", fontsize=TEXT - 1, color=FAINT, clip_on=False)
    axes.text(1.005 * right, top, "work", va="top", fontsize=TEXT - 1, color=FAINT)


def _label(axes: Any, hand: Hand, points: Array, radius: float | Array) -> None:
    names, groups = abbreviations(hand), same_places(points)
    reach = np.broadcast_to(radius, len(points))
    label_dots(
        axes,
        np.array([points[group[0]] for group in groups]),
        [together([names[k] for k in group]) for group in groups],
        radius=[float(max(reach[group])) for group in groups],
    )


def pull_map(hand: Hand, joints: Iterable[str] = ("wrist", "cmc1")) -> Any:
    """In which direction every muscle pulls a joint with two rotations: flexion arm across, deviation or abduction arm up.

    One panel for each of at most two ``joints``; the area of a disc is the tension fraction, and muscles with the same two lever arms
    share a disc. Raises ``UnknownName`` or, for a joint that does not turn in two ways, ``ValueError``.
    """
    asked = [find(name, hand.joints, kind="joint") for name in ([joints] if isinstance(joints, str) else joints)]
    if not 1 <= len(asked) <= 2:
        raise ValueError(f"{len(asked)} joints in one map; give one or two")
    with wall() as figure:
        panels = figure.subplots(1, len(asked), squeeze=False)[0]
        found = [_directions(axes, hand, name) for axes, name in zip(panels, asked, strict=True)]
        shown = {k: group for k, group in enumerate(regions(hand)) if any(group in seen for *_, seen in found)}
        keys = [panels[0].scatter([], [], s=170, **dot(k)) for k in shown]
        keys += [panels[0].scatter([], [], s=DISC * one, color=FAINT, alpha=0.5) for one in SIZES]
        words = [*shown.values(), *(f"{one:g} %" for one in SIZES[:-1]), f"{SIZES[-1]:g} % tension"]
        figure.legend(keys, words, loc="outside lower center", ncols=len(keys), handletextpad=0.0, columnspacing=1.0)
        heading(figure, "Which way every muscle pulls, and how hard")
        for _ in range(2):  # new limits may change the layout a little
            figure.draw_without_rendering()
            for axes, (points, *_others) in zip(panels, found, strict=True):
                _same_scale(axes, points)
        for axes, (points, texts, radius, _) in zip(panels, found, strict=True):
            label_dots(axes, points, texts, radius=radius)
    return figure


def two_rotations(hand: Hand, joint: str) -> tuple[str, str]:
    """The flexion of a joint and its second moving rotation. Raises ``ValueError`` for a joint without two."""
    own = [dof.name for dof in hand.joints[joint].dofs if dof.driver is None]
    if len(own) != 2:
        two = [name for name, other in hand.joints.items() if sum(dof.driver is None for dof in other.dofs) == 2]
        raise ValueError(f"{joint!r} has {len(own)} rotations of its own, and a map needs two; choose from {', '.join(two)}")
    return own[0], own[1]


def _same_scale(axes: Any, points: Array) -> None:
    """Limits around ``points`` and the origin that give a millimetre the same length on both axes."""
    from matplotlib.ticker import MultipleLocator

    low, high = np.minimum(points.min(axis=0), 0.0), np.maximum(points.max(axis=0), 0.0)
    inches = np.array([axes.bbox.width, axes.bbox.height])
    scale = float(((high - low) / (inches * (1.0 - 2.0 * EDGE))).max())
    middle, half = (low + high) / 2.0, scale * inches / 2.0
    axes.set(xlim=(middle[0] - half[0], middle[0] + half[0]), ylim=(middle[1] - half[1], middle[1] + half[1]))
    step = 5.0 if half.max() > 15.0 else 2.0
    axes.xaxis.set_major_locator(MultipleLocator(step))
    axes.yaxis.set_major_locator(MultipleLocator(step))


def _both_ways(dof: DegreeOfFreedom) -> str:
    negative, positive = (word.split(" (")[0] for word in (dof.negative, dof.positive))
    return f"\N{LEFTWARDS ARROW} {negative}      arm (mm)      {positive} \N{RIGHTWARDS ARROW}"


def _directions(axes: Any, hand: Hand, joint: str) -> tuple[Array, list[str], list[float], set[str]]:
    """Draw one panel; points (N, 2) in mm, labels, radii in points, groups of muscles that are in it."""
    across, up = (hand.dofs[name] for name in two_rotations(hand, joint))
    arms = 1000.0 * (hand.lever_arm @ hand.coupling)[:, [hand.moving_names.index(across.name), hand.moving_names.index(up.name)]]
    tension = np.array([muscle.tension_percent for muscle in hand.muscles.values()])
    rows = np.flatnonzero(np.abs(arms).max(axis=1) > 0.0)
    names, region = abbreviations(hand), [muscle.region for muscle in hand.muscles.values()]
    number = {name: k for k, name in enumerate(regions(hand))}
    groups = [[int(rows[k]) for k in group] for group in same_places(arms[rows])]
    radii = []
    for group in sorted(groups, key=lambda group: -tension[group].sum()):
        area = DISC * float(tension[group].sum())
        style = dot(number[region[group[0]]])
        axes.plot([0.0, arms[group[0], 0]], [0.0, arms[group[0], 1]], color=RULE, linewidth=2.0, zorder=1)
        axes.scatter(*arms[group[0]], s=area, alpha=0.55, zorder=3, edgecolors=INK, linewidths=1.0, color=style["color"])
        axes.scatter(*arms[group[0]], s=34, zorder=4, color=INK, marker=style["marker"])
    for group in groups:
        radii.append(float(np.sqrt(DISC * tension[group].sum() / pi)))
    for draw in (axes.axhline, axes.axvline):
        draw(0.0, color=FAINT, linewidth=1.8, zorder=2)
    title = hand.joints[joint].english.split(" (")[0]
    axes.set(title=title if title == joint else f"{title} ({joint})")
    axes.set(xlabel=_both_ways(across), ylabel=_both_ways(up))
    points = np.array([arms[group[0]] for group in groups])
    return points, [together([names[k] for k in group]) for group in groups], radii, {region[k] for k in rows}
