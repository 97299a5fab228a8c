"""What tightens near the limits of a joint."""

from __future__ import annotations

from dataclasses import dataclass

from handlab.anatomy.meshes import Array


@dataclass(frozen=True, eq=False)
class Capsule:
    """Capsule and ligaments of each degree of freedom; a follower has none of its own, what it follows holds it.

    ``width`` (dof,) rad: so far before a limit it begins; ``torque`` (dof, 2) N m at the lower and the upper limit;
    ``time`` (dof,) s: it brakes by its stiffness times this; ``hard_stop`` rad past a limit nothing gives any more.
    """

    width: Array
    torque: Array
    time: Array
    hard_stop: float
