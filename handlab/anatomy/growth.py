"""What muscles and passive structures of a hand of another size are, from those of the tables.

A hand of the same shape and L times as long has fibres and lever arms L times as long and muscles of L^2 times the section, so
forces grow with L^2, torques with L^3; its inertia, from its own geometry, with L^5. The paper keeps all but the inertia.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from handlab.anatomy.meshes import Array, frozen
from handlab.anatomy.pseudo_muscles import Muscle

if TYPE_CHECKING:
    from handlab.anatomy.records import Hand

# Assumption: passive structures are as stiff as those of a body of the same stuff, and as slow: torque L^3, times L.
TORQUE_POWER, TIME_POWER = 3, 1


@dataclass(frozen=True, eq=False)
class Growth:
    """``length`` L: fibres are so many times as long as in the tables; ``lever_arm`` (dof,): and lever arms at each joint."""

    length: float
    lever_arm: Array


def grown_muscles(muscles: Mapping[str, Muscle], growth: Growth, dof_names: tuple[str, ...]) -> dict[str, Muscle]:
    """Muscles of the tables with fibres and lever arms (both readings) times ``growth``."""
    factor = dict(zip(dof_names, growth.lever_arm.tolist(), strict=True))
    return {
        name: replace(
            muscle,
            rest_length=muscle.rest_length * growth.length,
            rest_length_printed=muscle.rest_length_printed * growth.length,
            lever_arms=tuple(
                replace(arm, used=arm.used * factor[arm.dof], printed=arm.printed * factor[arm.dof]) for arm in muscle.lever_arms
            ),
        )
        for name, muscle in muscles.items()
    }


def grown(hand: Hand, growth: Growth) -> Hand:
    """``hand`` (not grown before) with muscles and passive structures of another size; its geometry is left as it is.

    Raises ``ValueError`` for a hand that was grown before, or factors that are not positive.
    """
    if hand.growth is not None:
        raise ValueError("this hand was made from the tables with a size of its own already; grow the reference hand instead")
    length = float(growth.length)
    factor = np.asarray(growth.lever_arm, dtype=np.float64)
    if not (np.isfinite(length) and length > 0.0) or factor.shape != (len(hand.dof_names),) or not (factor > 0.0).all():
        raise ValueError(f"a growth needs a positive length and {len(hand.dof_names)} positive factors of lever arms")
    growth = Growth(length, frozen(factor))
    torque, time = length**TORQUE_POWER, length**TIME_POWER
    capsule = hand.capsule
    return hand.with_(
        growth=growth,
        muscles=hand.muscles.with_items(grown_muscles(hand.muscles, growth, hand.dof_names)),  # type: ignore[attr-defined]
        newton_per_percent=hand.newton_per_percent * length**2,
        stiffness=frozen(hand.stiffness * torque),
        friction=frozen(hand.friction * torque * time),
        capsule=None if capsule is None else replace(capsule, torque=frozen(capsule.torque * torque), time=frozen(capsule.time * time)),
    )
