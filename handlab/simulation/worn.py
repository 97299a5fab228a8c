"""The soft skin of a motion, recorded frame by frame, and the names by which parts of the model are switched.

The skin does not act back on the bones: a motion can be given another skin afterwards, at about 2 ms a frame.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from threading import Lock
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, frozen
from handlab.anatomy.terms import find
from handlab.simulation.soft_anchors import SKINS, Skin
from handlab.simulation.soft_frame import begin, skins
from handlab.simulation.soft_skin import Network, SoftSkin, soft_skin
from handlab.simulation.state import State

Muscles = Literal["both", "pseudo", "geometric"]
MUSCLES: tuple[Muscles, ...] = ("both", "pseudo", "geometric")


def skin_worn(name: str) -> Skin:
    """The way to wear the skin that ``name`` means; an unknown one is answered with the nearest."""
    found: Any = find(name, SKINS, kind="way to wear the skin")
    return found  # type: ignore[no-any-return]


def muscles_used(name: str) -> Muscles:
    """Which muscles contract: ``"pseudo"`` turn the bones, ``"geometric"`` swell below the skin, ``"both"``."""
    found: Any = find(name, MUSCLES, kind="choice of muscles")
    return found  # type: ignore[no-any-return]


def swelling_contraction(contraction: Array, muscles: str) -> Array:
    """What the geometric muscles hear of ``contraction``: nothing where only pseudo muscles are used."""
    return np.zeros_like(contraction) if muscles == "pseudo" else contraction


class Worn:
    """The soft skin in the frames of a motion.

    Frames are made in order, as far as the one that is asked for, and kept in single precision (a thousandth of a micrometre).
    ``skin``: how it is worn; ``faults``: triangles that stayed inverted in frames made so far. Safe to ask from several threads.
    """

    def __init__(self, skin: Skin, points: Any, frames: Iterator[SoftSkin] | None = None) -> None:
        self.skin = skin
        self.faults = 0
        self._points = points
        self._swelling = np.zeros(len(points))
        self._frames = frames
        self._done = 0 if frames is not None else len(points)
        self._lock = Lock()

    def __len__(self) -> int:
        """Number of frames."""
        return len(self._points)

    def points(self, frame: int) -> Array:
        """Skin points (N, 3) in a frame."""
        points: Array = frozen(self._points[self._made(frame)], np.float64)
        return points

    def swelling(self, frame: int) -> float:
        """Relative stretch of all columns of tissue in a frame, which keeps the volume."""
        return float(self._swelling[self._made(frame)])

    def all_points(self) -> Any:
        """Skin points (T, N, 3) in all frames, float32."""
        self._made(-1)
        return self._points

    def _made(self, frame: int) -> int:
        k = range(len(self._points))[frame]
        if k >= self._done:
            with self._lock:
                while k >= self._done:
                    self._make()
        return k

    def _make(self) -> None:
        assert self._frames is not None
        soft = next(self._frames)
        self._points[self._done] = soft.position.T
        self._swelling[self._done] = soft.swelling
        self.faults += soft.faults
        self._done += 1
        if self._done == len(self._points):
            self._frames = None


def worn(
    hand: Hand,
    time: Array,
    angle: Array,
    contraction: Array,
    skin: Skin,
    *,
    network: Network | None = None,
    progress: Callable[[float], None] | None = None,
) -> Worn:
    """The soft skin of ``angle`` (T, dof) rad and ``contraction`` (T, muscle) at ``time`` (T,) s, at rest in the first frame.

    ``network``: the hand's own if not given.
    """
    net = soft_skin(hand) if network is None else network

    def frames() -> Iterator[SoftSkin]:
        for k, soft in enumerate(skins(hand, net, time, angle, contraction, skin=skin)):
            if progress is not None:
                progress((k + 1) / len(time))
            yield soft

    return Worn(skin, np.empty((len(time), *hand.skin.points.shape), dtype=np.float32), frames())


def dress(hand: Hand, state: State, contraction: ArrayLike | None = None, *, skin: str = SKINS[2], network: Network | None = None) -> State:
    """The state with its skin worn as ``skin`` says, at rest, geometric muscles at ``contraction`` (muscle,), none if not given."""
    chosen = skin_worn(skin)
    net = soft_skin(hand) if network is None else network
    soft = begin(hand, net, state.angle, contraction, skin=chosen)
    return replace(state, skin=soft.points)
