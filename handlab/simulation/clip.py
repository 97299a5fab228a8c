"""A recorded motion."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, overload

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.simulation.laws import SOUND, Laws
from handlab.simulation.skin import Method, blend
from handlab.simulation.state import State
from handlab.simulation.table import Table

if TYPE_CHECKING:
    from handlab.simulation.soft_skin import Network
    from handlab.simulation.worn import Worn


@dataclass(frozen=True, eq=False)
class Clip:
    """What a hand did, frame by frame.

    ``time`` (T,) s, ``contraction`` (T, muscle), ``angle`` (T, dof) rad, ``speed`` (T, dof) rad/s, ``fibre_length``
    (T, muscle) m, ``force`` (T, muscle) N, ``torque`` (T, dof) N m: of the muscles alone, R' F, without friction, joint
    stiffness and stops. ``laws``: those of the motion. ``worn``: the soft skin if one was recorded; without, the bones alone
    move it. ``muscles``: which of them contracted (see ``simulate``).
    """

    hand: Hand = field(repr=False)
    time: Array
    contraction: Array
    angle: Array
    speed: Array
    fibre_length: Array
    force: Array
    torque: Array
    fps: float
    name: str = ""
    laws: Laws = SOUND
    worn: Worn | None = field(default=None, repr=False)
    muscles: str = "both"

    def __repr__(self) -> str:
        """One line, with the number that every force in it depends on."""
        label = f" {self.name!r}" if self.name else ""
        scale = f"forces at {self.hand.newton_per_percent:g} N per percent"
        skin = "" if self.worn is None else f", skin worn as {self.wear!r}"
        return f"Clip{label}: {len(self.time)} frames, {self.time[-1]:g} s at {self.fps:g} frames/s, {scale}{skin}"

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.time)

    @property
    def states(self) -> Sequence[State]:
        """One state per frame; each gets its skin when it is asked for."""
        return States(self)

    @property
    def wear(self) -> str:
        """How the skin is worn: ``"blend"``, ``"springs"`` or ``"springs and muscles"``."""
        return "blend" if self.worn is None else self.worn.skin

    def skin(self, frame: int, *, method: Method | None = None) -> Array:
        """Points (N, 3) of the even skin in a frame: the recorded soft skin, or the blend (always, if a ``method`` is given)."""
        if self.worn is not None and method is None:
            return self.worn.points(frame)
        return blend(self.hand, self.angle[frame], method=method or "dual")

    def with_skin(
        self, skin: str = "springs and muscles", *, network: Network | None = None, progress: Callable[[float], None] | None = None
    ) -> Clip:
        """The same motion with its skin worn another way. A soft skin is recorded as far as frames are asked for (about 2 ms each).

        ``network``: springs with other constants or muscles, as ``soft_skin`` makes them. Raises ``UnknownName`` for an unknown skin.
        """
        from handlab.simulation.worn import skin_worn, swelling_contraction, worn

        chosen = skin_worn(skin)
        if chosen == "blend":
            return replace(self, worn=None)
        heard = swelling_contraction(self.contraction, self.muscles)
        return replace(self, worn=worn(self.hand, self.time, self.angle, heard, chosen, network=network, progress=progress))

    def table(self, *, muscles: Iterable[str] | None = None, joints: Iterable[str] | None = None) -> Table:
        """Columns with units in their headings.

        Time, then contraction, fibre length and force of muscles, then angle, speed and torque of degrees of freedom.
        ``muscles`` by name or abbreviation, ``joints`` by joint or degree of freedom; all of them if not given.
        """
        hand = self.hand
        table = Table({"time_s": self.time})
        for name in hand.muscle_names if muscles is None else muscles:
            muscle = hand.muscles[name]
            k = hand.muscle_names.index(muscle.name)
            table[f"{muscle.abbreviation}.contraction"] = self.contraction[:, k]
            table[f"{muscle.abbreviation}.fibre_length_mm"] = self.fibre_length[:, k] * 1000.0
            table[f"{muscle.abbreviation}.force_N"] = self.force[:, k]
        for name in hand.dof_names if joints is None else dofs_of(hand, joints):
            k = hand.dof_names.index(name)
            table[f"{name}.angle_deg"] = np.rad2deg(self.angle[:, k])
            table[f"{name}.speed_deg_per_s"] = np.rad2deg(self.speed[:, k])
            table[f"{name}.muscle_torque_Nm"] = self.torque[:, k]
        return table

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write ``table()`` as CSV, whole or not at all."""
        self.table().to_csv(path)


def dofs_of(hand: Hand, names: Iterable[str]) -> list[str]:
    """Degrees of freedom of joints or degrees of freedom by name."""
    known = {**{name: [dof.name for dof in joint.dofs] for name, joint in hand.joints.items()}, **{name: [name] for name in hand.dof_names}}
    asked = (names,) if isinstance(names, str) else names
    return [dof for name in asked for dof in known[find(name, known, kind="joint or degree of freedom")]]


class States(Sequence[State]):
    """The states of a clip, made when asked for."""

    def __init__(self, clip: Clip) -> None:
        self._clip = clip

    def __len__(self) -> int:
        """Number of frames."""
        return len(self._clip.time)

    @overload
    def __getitem__(self, frame: int) -> State: ...
    @overload
    def __getitem__(self, frame: slice) -> list[State]: ...
    def __getitem__(self, frame: int | slice) -> State | list[State]:
        """The state of a frame, or a list of them."""
        if isinstance(frame, slice):
            return [self[k] for k in range(*frame.indices(len(self)))]
        clip = self._clip
        return State(float(clip.time[frame]), clip.angle[frame], clip.speed[frame], clip.fibre_length[frame], clip.skin(frame))
