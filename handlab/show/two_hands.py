"""The same contraction on two hands, side by side at one scale: what it makes of torque, inertia and angle (section 6)."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from math import radians, tan
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show.colours import INK
from handlab.show.figures import line
from handlab.show.moments import Moment, story
from handlab.show.outputs import checked
from handlab.show.save import save_figure
from handlab.show.scene import Scene, skin_name
from handlab.show.views import LENS_DEG, Camera, camera, view_name
from handlab.show.wall_plots import SMALL, heading, wall
from handlab.simulation.clip import Clip, dofs_of
from handlab.simulation.inertia_tables import tensor_inertia
from handlab.simulation.keyframes import Source, keyframes
from handlab.simulation.play import simulate

KG_MM2 = 1e6
TILE = (390, 740)  # pixels of one hand
FOOT, HEAD = 0.075, 0.085  # of the height of a tile: for names and times
BAR_MM = 50
SAMPLES = 61  # points of the line of inertia


def two_hands(
    a: Hand,
    b: Hand,
    clip: Source = "fist",
    path: str | os.PathLike[str] | None = None,
    *,
    joint: str = "mcp2",
    moments: int = 3,
    hold: Iterable[str] = ("wrist",),
    view: str = "palm",
    skin: str = "solid",
) -> Any:
    """Both hands under the same contraction: at a few moments at one scale, above torque, inertia and angle of a joint over time.

    ``clip``: a named clip, key frames, or contractions by muscle; both hands begin relaxed and play it with the joints ``hold`` held.
    ``joint``: a joint (its first rotation) or a rotation by name. Torque: of the muscles (N m). Inertia: of what hangs on that rotation
    (kg mm^2), in the posture of the moment. Behind each name: ratio of b to a. A matplotlib figure, written to ``path`` (.png) if given.
    """
    out = None if path is None else checked(path, [".png"])
    seen, worn = view_name(view), skin_name(skin)
    if not 1 <= int(moments) <= 6:
        raise ValueError(f"moments is {moments}; give 1 to 6")
    if a.muscle_names != b.muscle_names or a.dof_names != b.dof_names:
        raise ValueError("the two hands have different muscles or joints; both must come from the reference hand")
    keys, held = keyframes(clip), tuple([hold] if isinstance(hold, str) else hold)
    dof = dofs_of(a, [joint])[0]
    seconds = None if float(keys.time[-1]) > 0.0 else 1.0
    played = [simulate(hand, keys, seconds=seconds, hold=held) for hand in (a, b)]
    names = [a.name, b.name] if a.name != b.name else [f"{a.name} (first)", f"{b.name} (second)"]
    at = telling(played[0], int(moments))
    strip, px_per_mm = pictures(played, at, seen, worn)
    with wall() as figure:
        top, bottom = figure.subfigures(2, 1, height_ratios=(1.5, 1.0))
        _strip(top.subplots(), strip, names, at, px_per_mm)
        plots = bottom.subplots(1, 3)
        rows = ("muscle torque (N m)", "moment of inertia (kg mm²)", "angle (degrees)")
        for axes, title, curves in zip(plots, rows, measured(played, dof), strict=True):
            _plot(axes, title, curves, names, at)
        plots[0].legend(loc="best", handlelength=2.6)
        lengths = [hand_length_mm(hand) for hand in (a, b)]
        ratio = lengths[1] / lengths[0]
        note = (
            f"wrist to middle tip {lengths[0]:.0f} and {lengths[1]:.0f} mm: L = {ratio:.2f}, L² = {ratio**2:.2f}, "
            f"L³ = {ratio**3:.2f}, L⁵ = {ratio**5:.2f};   forces: {a.newton_per_percent:.3g} and {b.newton_per_percent:.3g} N per percent"
        )
        name = f" ({keys.name})" if keys.name else ""
        heading(figure, f"The same contraction{name} on two hands: {dof}", note)
    if out is not None:
        save_figure(figure, out)
    return figure


def measured(played: list[Clip], dof: str) -> list[list[tuple[Array, Array]]]:
    """Torque (N m), inertia (kg mm^2) and angle (degrees) of a rotation: for each of them, for each clip, time and values."""
    k = played[0].hand.dof_names.index(dof)
    torque = [(clip.time, clip.torque[:, k]) for clip in played]
    angle = [(clip.time, np.rad2deg(clip.angle[:, k])) for clip in played]
    inertia = []
    for clip in played:
        hand = clip.hand
        driver = hand.dofs[dof].driver or dof
        column, moving = hand.moving_names.index(driver), [hand.dof_names.index(name) for name in hand.moving_names]
        frames = np.unique(np.linspace(0, len(clip) - 1, SAMPLES).round().astype(int))
        values = [tensor_inertia(hand, clip.angle[frame, moving])[column] for frame in frames]
        inertia.append((clip.time[frames], KG_MM2 * np.array(values)))
    return [torque, inertia, angle]


def telling(clip: Clip, count: int) -> Array:
    """Times (count,) s between which the posture changes equally much, from the first to the last; the last alone if only one is asked."""
    if count == 1:
        return clip.time[-1:]
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(clip.angle, axis=0)).sum(axis=1))])
    if way[-1] <= 0.0:
        return np.linspace(clip.time[0], clip.time[-1], count)
    # where the hand stands still at the end, the earliest time counts
    found: Array = np.array([clip.time[np.searchsorted(way, share * way[-1])] for share in np.linspace(0.0, 1.0, count)])
    return found


def hand_length_mm(hand: Hand) -> float:
    """Wrist centre to tip of the middle finger as the hand is stored."""
    return 1e3 * float(np.linalg.norm(hand.skin.points[hand.feature_points["tip_middle"]["palmar"]] - hand.joints["wrist"].centre))


def pictures(played: list[Clip], at: Array, view: str, skin: str) -> tuple[Any, float]:
    """One strip (height, width, 3): for every moment both hands beside each other, seen by one camera; and its pixels per mm."""
    told = [story(clip) for clip in played]
    shown: list[list[Moment]] = [[one.at(float(time)) for time in at] for one in told]
    free = 1.0 - FOOT - HEAD
    aim: Camera = camera(played[0].hand, view, [moment.skin for row in shown for moment in row], TILE[0] / (free * TILE[1]))
    # the hands stand between their names and the time, at the size that fits there
    distance = aim.distance / free
    lower = (HEAD - FOOT) * tan(radians(LENS_DEG / 2.0)) * distance
    aim = replace(aim, focus=aim.focus + lower * aim.up, distance=distance)
    columns = []
    for clip, row in zip(played, shown, strict=True):
        with Scene(clip.hand, skin=skin, size=TILE, quality="film") as scene:
            scene.set(view=aim)
            tiles = []
            for moment in row:
                scene.pose(moment)
                tiles.append(scene.picture())
        columns.append(tiles)
    px_per_mm = TILE[1] / 2.0 / tan(radians(LENS_DEG / 2.0)) / (1e3 * aim.distance)
    return np.hstack([tile for pair in zip(*columns, strict=True) for tile in pair]), px_per_mm


def _strip(axes: Any, strip: Any, names: list[str], at: Array, px_per_mm: float) -> None:
    axes.imshow(strip)
    axes.set_axis_off()
    width, height = TILE
    words: dict[str, Any] = {"ha": "center", "va": "center"}
    for k, time in enumerate(at):
        for i, name in enumerate(names):
            place = (2 * k + i + 0.5) * width, (1.0 - 0.5 * FOOT) * height
            axes.text(*place, name, color=line(i)["color"], fontsize=SMALL + 2, fontweight="bold", **words)
        axes.text((2 * k + 1.0) * width, 0.5 * HEAD * height, f"{time:.2f} s", color=INK, **words)
        if k:
            axes.plot([2 * k * width] * 2, [0, height], color="white", linewidth=6.0)
    left, right = 0.06 * width, 0.06 * width + BAR_MM * px_per_mm
    axes.plot([left, right], [0.62 * HEAD * height] * 2, color=INK, linewidth=5.0, solid_capstyle="butt")
    axes.text((left + right) / 2, 0.28 * HEAD * height, f"{BAR_MM} mm", color=INK, fontsize=SMALL, **words)
    axes.set(xlim=(0, strip.shape[1]), ylim=(strip.shape[0], 0))


def _plot(axes: Any, title: str, curves: list[tuple[Array, Array]], names: list[str], at: Array) -> None:
    for k, ((time, values), name) in enumerate(zip(curves, names, strict=True)):
        axes.plot(time, values, label=name, zorder=3 - k, **line(k))
        axes.plot(at, np.interp(at, time, values), linestyle="", marker="os"[k], markersize=11, color=line(k)["color"], zorder=4)
    axes.set(title=title, xlabel="time (s)")
    axes.margins(y=0.12)
    (_, one), (time, other) = curves
    if abs(one[-1]) <= 1e-9:
        return
    # above its line where there is room between the two, else below both
    low, high = axes.get_ylim()
    above = one[-1] - other[-1] > 0.2 * (high - low)
    ratio, how = f"× {other[-1] / one[-1]:.2f}", {"ha": "right", "va": "bottom" if above else "top", "color": line(1)["color"]}
    axes.annotate(ratio, (time[-1], other[-1]), (4, 12 if above else -14), textcoords="offset points", fontweight="bold", **how)
