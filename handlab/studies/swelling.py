"""What contraction does to the skin while the bones stand still: the same pose with muscles off and on (Figure 5)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.simulation.skeleton import number
from handlab.simulation.skin import normals
from handlab.simulation.soft_frame import begin
from handlab.simulation.soft_skin import Network, soft_skin


@dataclass(frozen=True, eq=False)
class Swelling:
    """One pose twice: skin points (N, 3) m with the muscles ``off`` and ``on``; ``contraction`` (muscle,) with which they are on.

    ``rise`` (N,) m: how far the skin comes outwards, along the normals of the skin at rest; negative where it sinks.
    """

    muscles: tuple[str, ...]
    angle: Array
    contraction: Array
    off: Array
    on: Array
    rise: Array

    @property
    def most(self) -> tuple[float, int]:
        """The largest rise in metres, and at which skin point."""
        k = int(self.rise.argmax())
        return float(self.rise[k]), k


def swelling(
    hand: Hand,
    angle: ArrayLike,
    contraction: ArrayLike,
    muscles: Iterable[str],
    *,
    level: float = 1.0,
    network: Network | None = None,
) -> Swelling:
    """The skin at ``angle`` (dof,) rad and ``contraction`` (muscle,), with ``muscles`` (by name or abbreviation) at 0 and at ``level``.

    Both skins have come to rest. Raises ``UnknownName`` and ``ValueError`` for a level outside [0, 1].
    """
    level = number(level, "level")
    if not 0.0 <= level <= 1.0:
        raise ValueError(f"level is {level:g}; contraction values lie between 0 and 1")
    names = tuple(hand.muscles[name].name for name in ([muscles] if isinstance(muscles, str) else muscles))
    pose, net = np.asarray(angle, dtype=np.float64), soft_skin(hand) if network is None else network
    off = np.array(contraction, dtype=np.float64)
    on = off.copy()
    rows = [hand.muscle_names.index(name) for name in names]
    off[rows], on[rows] = 0.0, level
    still, raised = (begin(hand, net, pose, value).points for value in (off, on))
    rise: Array = np.einsum("ni,ni->n", raised - still, normals(hand, still))
    return Swelling(names, pose, on, still, raised, rise)
