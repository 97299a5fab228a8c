"""The state of a hand: a frozen record of arrays."""

from __future__ import annotations

from dataclasses import dataclass

from handlab.anatomy.records import Array


@dataclass(frozen=True, eq=False)
class State:
    """A hand at one moment. A step returns another one and leaves this one as it is.

    ``time`` s, ``angle`` (dof,) rad, ``speed`` (dof,) rad/s, ``fibre_length`` (muscle,) m, ``skin`` (N, 3) m.
    """

    time: float
    angle: Array
    speed: Array
    fibre_length: Array
    skin: Array

    def __repr__(self) -> str:
        """One line."""
        return f"State at {self.time:.4g} s: {len(self.angle)} angles, {len(self.fibre_length)} muscles, {len(self.skin)} skin points"
