"""The other hand: everything mirrored at the plane between radial and ulnar (z = 0).

Points are mirrored, and triangles turned round so that they still face outwards. An axis is an axial vector: a mirror keeps
the part along its normal and reverses the part in its plane, so equal angles are mirrored motions and lever arms stay as they are.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Bone, FineSkin, Hand, Named, Skin, frozen

MIRROR = np.array([1.0, 1.0, -1.0])
TURNED = [0, 2, 1]  # corners of a triangle after the mirror


def mirrored(hand: Hand) -> Hand:
    """The left hand of a right one, or the right of a left; twice gives the first again, to the last bit."""
    return hand.with_(
        side="left" if hand.side == "right" else "right",
        skin=Skin(points=point(hand.skin.points), faces=turned(hand.skin.faces), weights=hand.skin.weights),
        skin_fine=FineSkin(
            points=point(hand.skin_fine.points),
            faces=turned(hand.skin_fine.faces),
            texture=frozen(hand.skin_fine.texture[:, TURNED], hand.skin_fine.texture.dtype),
            triangle=hand.skin_fine.triangle,
            barycentric=turned(hand.skin_fine.barycentric),
            height=hand.skin_fine.height,
        ),
        bones=renamed(hand.bones, {name: mirrored_bone(bone) for name, bone in hand.bones.items()}),
        bodies=renamed(
            hand.bodies,
            {
                name: replace(body, centre=point(body.centre), inertia=frozen(body.inertia * np.outer(MIRROR, MIRROR)))
                for name, body in hand.bodies.items()
            },
        ),
        joints=renamed(
            hand.joints,
            {
                name: replace(
                    joint,
                    centre=point(joint.centre),
                    dofs=tuple(replace(dof, axis=axis(dof.axis), anchor=point(dof.anchor)) for dof in joint.dofs),
                )
                for name, joint in hand.joints.items()
            },
        ),
    )


def point(points: Array) -> Array:
    """Points (..., 3) behind the mirror; adding 0 turns -0 into 0."""
    result: Array = frozen(points * MIRROR + 0.0)
    return result


def axis(axes: Array) -> Array:
    """Axes (..., 3) behind the mirror: -diag(1, 1, -1) axis."""
    result: Array = frozen(axes * -MIRROR + 0.0)
    return result


def turned(rows: Any) -> Any:
    """Rows (N, 3) per triangle corner, in the order of the mirrored triangle."""
    return frozen(rows[:, TURNED], rows.dtype)


def mirrored_bone(bone: Bone) -> Bone:
    """One bone behind the mirror."""
    return replace(bone, points=point(bone.points), faces=turned(bone.faces))


def renamed(old: Any, items: dict[str, Any]) -> Any:
    """A mapping like ``old`` (same kind and aliases) with other items."""
    return old.with_items(items) if isinstance(old, Named) else type(old)(items)
