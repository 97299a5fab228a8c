"""Which reading of each law of motion a simulation uses: the sound one, or what the paper prints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from handlab.anatomy.terms import find
from handlab.physics.muscle import Reading

DYNAMICS = ("coupled", "decoupled")
FORCE = ("sound", "printed")
FRICTION = ("implicit", "explicit", "printed")
INERTIA = ("tensor", "table", "nearest table")

# Friction, stiffness and capsule are taken at the end of a substep and the muscles at its beginning. 1/1200 s keeps a smooth clip
# within 0.1 degree of the limit of short steps, and 24, 25, 30, 40, 50, 60, 100 and 120 frames a second are whole numbers of it.
SUBSTEP = 1.0 / 1200.0
# The strongest joint is the wrist: with all muscles pulling it is stable to about 1/150 s.
LONGEST_SUBSTEP = 1.0 / 240.0


@dataclass(frozen=True)
class Laws:
    """The laws of motion by name.

    ``dynamics``: ``coupled`` (the full mass matrix with velocity terms: a bone that turns takes its neighbours along) or
    ``decoupled`` (the paper: every rotation on its own, with a moment of inertia J).
    ``gravity`` (3,) m/s^2 in the frame of the forearm: x distal, y palmar, z radial; ``(0, 9.81, 0)`` with the palm downward.
    ``force``: ``printed`` lets a fibre outside 0.6 to 1.6 of its rest length push, as the fitted curve does.
    ``friction``: ``implicit`` opposes the motion and is stable at any step; ``explicit`` opposes it, stable for dt < 2 J / mu;
    ``printed`` is (2'), which brakes along the muscle's torque. The last two need ``decoupled``.
    ``inertia``: ``tensor`` from the pose; ``table`` in steps of 5 degrees, interpolated; ``nearest table`` as in 4.1.2. Tables
    need ``decoupled``. ``substep`` s: the longest step; explicit friction takes it as it is and may run away.
    """

    dynamics: str = "coupled"
    gravity: Sequence[float] = (0.0, 0.0, 0.0)
    force: Reading = "sound"
    friction: str = "implicit"
    inertia: str = "tensor"
    substep: float = SUBSTEP

    def __post_init__(self) -> None:
        for name, known in (("dynamics", DYNAMICS), ("force", FORCE), ("friction", FRICTION), ("inertia", INERTIA)):
            object.__setattr__(self, name, find(getattr(self, name), known, kind=name))
        if self.dynamics == "coupled" and (self.friction != "implicit" or self.inertia != "tensor"):
            raise ValueError(f"friction {self.friction!r} and inertia {self.inertia!r} need dynamics='decoupled'")
        try:
            gravity = [float(value) for value in self.gravity]
        except (TypeError, ValueError):
            gravity = []
        if len(gravity) != 3 or not all(isfinite(value) for value in gravity):
            raise ValueError(f"gravity is {self.gravity!r}; give three numbers in m/s^2, such as (0, 9.81, 0) with the palm downward")
        object.__setattr__(self, "gravity", tuple(gravity))
        longest = LONGEST_SUBSTEP if self.friction == "implicit" else 1.0
        if not isfinite(self.substep) or not 1e-7 <= self.substep <= longest * (1.0 + 1e-12):
            raise ValueError(f"substep is {self.substep:g} s; give at least 1e-7 s and at most {longest:g} s, such as 1/1200")

    @classmethod
    def printed(cls, substep: float = 1e-5) -> Laws:
        """The paper's own: decoupled, tables in steps of 5 degrees, the fitted curves without a guard, friction (2') and the explicit step.

        With a step of 1/60 s, as the paper's film would have it, every finger joint blows up; 10 microseconds are stable.
        """
        return cls(dynamics="decoupled", force="printed", friction="printed", inertia="nearest table", substep=substep)


SOUND = Laws()
