"""What the skin is tied to at one moment (sections 3.1 and 4.2): it follows from bones and muscles alone, not from where the skin is.

Three ways to wear the skin, by name: ``"blend"`` (bones alone move it), ``"springs"`` (the network follows the bones), ``"springs and
muscles"`` (and the surfaces of the geometric muscles below it).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.simulation import skin_kernel
from handlab.simulation import soft_anchor_kernel as kernel
from handlab.simulation.geometric_muscle import Ellipsoids, shape
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.skin import binding
from handlab.simulation.soft_skin import Network

Skin = Literal["blend", "springs", "springs and muscles"]
SKINS: tuple[Skin, ...] = ("blend", "springs", "springs and muscles")

# A column of tissue under skin that is stretched to twice its area would have half its length, were nothing to flow sideways: assumption.
# By area to the power of -3/4, written as roots in ``swollen``.
COLUMN, COLUMN_REACH, COLUMN_PASSES = (0.6, 1.4), 0.010, 3
LIFT = 0.012  # m: a node follows a muscle's surface by less than this


class Anchors(NamedTuple):
    """Where the network is tied at one moment: ``centre``, ``arm`` (3, n) of the mirrored pairs; ``turn`` (4, n), how nodes are turned.

    ``stretch`` (n,): relative area of the net of centres, less 1, evened out.
    """

    centre: Array
    arm: Array
    turn: Array
    stretch: Array

    def swell(self, network: Network, swelling: float) -> None:
        """Columns of tissue take up volume, in place; ``swelling``: relative stretch of all of them."""
        kernel.swollen(self.centre, self.arm, self.stretch, network.depth, swelling, *COLUMN, COLUMN_REACH)


class Below(NamedTuple):
    """What lies below the skin at one moment: ``transforms`` (body, 4, 4) of the bones, ``anchors`` before they swell (none where bones
    alone move the skin), ``plane`` (3, M), rest normals of the triangles as the skin's own blend carries them."""

    transforms: Array
    anchors: Anchors | None
    plane: Array


def below(hand: Hand, network: Network, angle: ArrayLike, contraction: ArrayLike | None, *, skin: str = SKINS[2]) -> Below:
    """What lies below the skin with bones at ``angle`` (dof,) rad and muscles at ``contraction`` (muscle,)."""
    worn = find(skin, SKINS, kind="way to wear the skin")
    transforms = relative_transforms(hand, angle)
    if worn == SKINS[0]:
        return Below(transforms, None, np.empty((3, 0)))
    shapes = None
    if worn == SKINS[2] and network.muscles is not None:
        shapes = shape(network.muscles, transforms, np.zeros(len(hand.muscles)) if contraction is None else contraction)
    bound, quaternion = binding(hand), _quaternions(transforms)
    turn, plane = np.empty((4, len(network.points))), np.empty((3, len(network.faces)))
    kernel.turned(quaternion, bound.index, bound.weight, turn)
    kernel.planes(turn, network.faces, network.face_normal, plane)
    return Below(transforms, anchors(network, transforms, shapes), plane)


def anchors(network: Network, transforms: Array, ellipsoids: Ellipsoids | None = None) -> Anchors:
    """Anchors for ``transforms`` (body, 4, 4), as ``relative_transforms`` gives them, before columns of tissue swell.

    ``ellipsoids``: muscles that lift the skin above them, of ``network.muscles``; without them bones alone count.
    """
    count = len(network.points)
    out = Anchors(np.empty((3, count)), np.empty((3, count)), np.empty((4, count)), np.empty(count))
    quaternion = _quaternions(transforms)
    kernel.carried(quaternion, network.index, network.weight, network.centre, network.arm, out.turn, out.centre, out.arm)
    if ellipsoids is not None:
        ties = network.ties
        kernel.lifted(
            ties.node, ties.ellipsoid, ties.share, ties.local, ties.below, network.centre, out.turn, *ellipsoids, LIFT, out.centre
        )
    kernel.stretched(
        out.centre, network.faces, network.first, network.second, network.degree, network.area, COLUMN_PASSES, out.stretch
    )  # fmt: skip
    return out


def _quaternions(transforms: Array) -> Array:
    quaternion = np.empty((len(transforms), 8))
    skin_kernel.dual_quaternions(transforms, quaternion)
    return quaternion
