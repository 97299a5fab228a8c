"""A hand of the same shape and another size, and a hand of another shape that keeps its muscles: what size alone does (section 6).

The paper keeps muscles and masses when it warps a hand, so that only lengths and inertias change; grown people are stronger.
"""

from __future__ import annotations

from dataclasses import replace
from math import isfinite

import numpy as np

from handlab.anatomy.growth import Growth, grown
from handlab.anatomy.mirror import renamed
from handlab.anatomy.records import Hand, Joint, frozen
from handlab.fitting.bodies import with_masses_of
from handlab.fitting.warp import MECHANICS, Mechanics

SMALLEST, LARGEST = 0.3, 3.0


def enlarged(hand: Hand, size: float, *, mechanics: Mechanics = "scaled") -> Hand:
    """``hand`` with every length times ``size`` and all angles as they were.

    ``mechanics`` "scaled": forces go with size^2, torques (muscles, springs of the joints, capsules) with size^3, masses with size^3,
    inertias with size^5. "kept": muscles, springs and masses stay, so inertias go with size^2.
    Raises ``ValueError`` for a size outside 0.3 to 3, and for a hand that has a size of its own already.
    """
    if not (isinstance(size, int | float) and isfinite(size) and SMALLEST <= size <= LARGEST):
        raise ValueError(f"size is {size!r}; give a number between {SMALLEST:g} and {LARGEST:g}, such as 0.7")
    if mechanics not in MECHANICS:
        raise ValueError(f"mechanics is {mechanics!r}; it must be 'scaled' or 'kept'")
    if hand.growth is not None:
        raise ValueError(f"{hand.name} has a size of its own already; enlarge the reference hand, hl.load_hand()")
    joints = {
        name: replace(
            joint, centre=frozen(size * joint.centre), dofs=tuple(replace(dof, anchor=frozen(size * dof.anchor)) for dof in joint.dofs)
        )
        for name, joint in hand.joints.items()
    }
    named: dict[str, Joint] = renamed(hand.joints, joints)
    fine = hand.skin_fine
    bodies = {
        name: replace(body, mass=body.mass * size**3, centre=frozen(size * body.centre), inertia=frozen(size**5 * body.inertia))
        for name, body in hand.bodies.items()
    }
    result = hand.with_(
        name=f"{hand.name}, {size:g} times as long",
        skin=replace(hand.skin, points=frozen(size * hand.skin.points)),
        skin_fine=replace(fine, points=frozen(size * fine.points), height=frozen(size * fine.height)),
        bones=renamed(hand.bones, {name: replace(bone, points=frozen(size * bone.points)) for name, bone in hand.bones.items()}),
        joints=named,
        bodies=renamed(hand.bodies, bodies),
    )
    if mechanics == "kept":
        return with_masses_of(result, hand)
    return grown(result, Growth(float(size), frozen(np.full(len(hand.dof_names), float(size)))))


def with_mechanics_of(hand: Hand, other: Hand) -> Hand:
    """``hand`` with muscles, joint springs and masses of ``other``, as the paper warps it; inertias are those of its own shape.

    Raises ``ValueError`` for hands with other muscles or joints.
    """
    if hand.muscle_names != other.muscle_names or hand.dof_names != other.dof_names:
        raise ValueError("the two hands have different muscles or joints; both must come from the reference hand")
    result = hand.with_(
        name=f"{hand.name} with the mechanics of {other.name}",
        growth=other.growth,
        muscles=other.muscles,
        newton_per_percent=other.newton_per_percent,
        stiffness=other.stiffness,
        friction=other.friction,
        capsule=other.capsule,
    )
    return with_masses_of(result, other)
