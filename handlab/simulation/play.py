"""Key frames in, a recorded motion out."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import floor, isfinite
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand, frozen
from handlab.physics.muscle import muscle_force
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import KeyFrames, Source, keyframes
from handlab.simulation.laws import SOUND, Laws
from handlab.simulation.mechanics import coupled, fibre_lengths, mechanics
from handlab.simulation.skeleton import held_coordinates, integrate, number, substeps_of
from handlab.simulation.state import State

CHUNK = 1200  # substeps between two reports of progress, and a whole number of INERTIA_EVERY


def simulate(
    hand: Hand,
    source: Source,
    *,
    seconds: float | None = None,
    fps: float = 60.0,
    hold: Iterable[str] = (),
    start: State | None = None,
    laws: Laws = SOUND,
    skin: str = "blend",
    muscles: str = "both",
    painted: Any = None,
    progress: Callable[[float], None] | None = None,
) -> Clip:
    """The motion that key frames (or the name of a clip, a mapping, a file) give, from ``start`` or the relaxed hand.

    ``seconds``: until the last key if not given; ``fps``: frames per second; ``hold``: joints or degrees of freedom that an
    examiner's hand holds; ``laws``: which laws of motion, and gravity (see ``Laws``); ``progress`` is called with the finished
    fraction in [0, 1].

    ``skin``: ``"blend"`` (bones alone move it; default, because numbers need no more and it is thirty times faster), ``"springs"``, or
    ``"springs and muscles"`` (and geometric muscles swell below it); recorded frame by frame. ``muscles``: ``"both"``, ``"pseudo"``
    (bones turn, nothing swells by contraction) or ``"geometric"`` (muscles swell, all bones stand still). ``painted``: muscles that swell
    besides the shipped ones: a grid, several, a ``PaintPanel`` or a folder; the clip's hand has them then.

    Substeps lie on one grid of ``laws.substep`` from time 0, whatever the frame rate: 24, 30, 60 or 97 frames a second show the
    same motion. A frame between two substeps is interpolated linearly.
    """
    if painted is not None:
        from handlab.simulation.painted import with_painted

        hand = with_painted(hand, painted)
    keys = keyframes(source).for_hand(hand)
    used, chosen = chosen_names(muscles, skin)
    held = hand.joints if used == "geometric" else hold
    fps = positive(fps, "fps", "frames per second, such as 60")
    if seconds is None:
        seconds = float(keys.time[-1])
        if seconds <= 0.0:
            raise ValueError("these key frames end at 0 s; say how long to simulate, such as seconds=2")
    seconds = positive(seconds, "seconds", "seconds, such as 2")
    time = np.arange(floor(seconds * fps + 1e-6) + 1) / fps
    y, speed = path(hand, keys, substeps_of(seconds, laws), time, held, start, laws, progress if chosen == "blend" else None)
    angle = coupled(hand, y)
    contraction, length = keys.at(time), fibre_lengths(hand, angle)
    force = muscle_force(contraction, length / hand.rest_length, hand.max_force, reading=laws.force)
    clip = Clip(
        hand=hand,
        time=frozen(time),
        contraction=frozen(contraction),
        angle=frozen(angle),
        speed=frozen(speed @ hand.coupling.T),
        fibre_length=frozen(length),
        force=frozen(force),
        torque=frozen(force @ hand.lever_arm),
        fps=fps,
        name=keys.name,
        laws=laws,
        muscles=used,
    )
    if chosen == "blend":
        return clip
    dressed = clip.with_skin(chosen, progress=progress)
    dressed.skin(-1)
    return dressed


def chosen_names(muscles: str, skin: str) -> tuple[str, str]:
    """Checked names of ``muscles`` and ``skin``. The springs are imported only if they are asked for."""
    if (muscles, skin) == ("both", "blend"):
        return muscles, skin
    from handlab.simulation.worn import muscles_used, skin_worn

    return muscles_used(muscles), skin_worn(skin)


def path(
    hand: Hand,
    keys: KeyFrames,
    substeps: int,
    time: Array,
    hold: Iterable[str],
    start: State | None,
    laws: Laws,
    progress: Callable[[float], None] | None,
) -> tuple[Array, Array]:
    """Moving coordinates and speeds (T, moving) at ``time`` (T,)."""
    m = mechanics(hand)
    held = held_coordinates(hand, hold)
    y = m.relaxed if start is None else start.angle[m.moving]
    speed = np.zeros(len(y)) if start is None else start.speed[m.moving]
    out_y, out_speed = np.empty((len(time), len(y))), np.empty((len(time), len(y)))
    at = np.minimum(time / laws.substep, substeps)
    # a frame that lies on the grid but for rounding is taken from the grid
    at = np.where(np.abs(at - np.rint(at)) < 1e-6, np.rint(at), at)
    for begin in range(0, max(substeps, 1), CHUNK):
        n = min(CHUNK, substeps - begin)
        contraction = keys.at((begin + np.arange(n) + 0.5) * laws.substep)
        path_y, path_speed = integrate(hand, y, speed, contraction, laws.substep, held, laws)
        frames = np.flatnonzero((at >= begin) & (at <= begin + n))
        low = np.minimum(np.floor(at[frames] - begin).astype(np.int64), n - 1)
        part = (at[frames] - begin - low)[:, None]
        out_y[frames] = (1.0 - part) * path_y[low] + part * path_y[low + 1]
        out_speed[frames] = (1.0 - part) * path_speed[low] + part * path_speed[low + 1]
        y, speed = path_y[-1], path_speed[-1]
        if progress is not None:
            progress((begin + n) / substeps)
    return out_y, out_speed


def positive(value: float, name: str, what: str) -> float:
    """A positive finite number, or an error."""
    value = number(value, name)
    if not isfinite(value) or value <= 0.0:
        raise ValueError(f"{name} is {value:g}; give a positive number of {what}")
    return value
