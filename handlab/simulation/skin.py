"""The skin follows the bones by blend weights.

Dual quaternions (Kavan, Collins, Zara, O'Sullivan 2008, "Geometric skinning with approximate dual quaternion blending") keep
the girth of a bent or twisted limb, where averaged matrices let it collapse; both are here by name.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand, frozen
from handlab.simulation import skin_kernel as kernel
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.per_hand import per_hand

Method = Literal["dual", "linear"]
INFLUENCES = 4  # bodies that move one skin point; where a hand names more, the lightest are left out


@dataclass(frozen=True)
class Binding:
    """Blend weights packed: bodies ``index`` (N, 4), heaviest first, and ``weight`` (N, 4), rows adding to 1.

    ``faces`` (M, 3) of the even skin; ``corners`` (Nf, 3): its points under each point of the fine skin.
    """

    index: NDArray[np.uint32]
    weight: Array
    faces: NDArray[np.uint32]
    corners: NDArray[np.uint32]


@per_hand
def binding(hand: Hand) -> Binding:
    """The blend weights of a hand, packed once."""
    index, weight = packed(hand.skin.weights)
    return Binding(index, weight, frozen(hand.skin.faces, np.uint32), frozen(hand.skin.faces[hand.skin_fine.triangle], np.uint32))


def packed(weights: ArrayLike) -> tuple[NDArray[np.uint32], Array]:
    """Indices and weights (N, 4) of the four heaviest bodies of every point, from ``weights`` (N, body)."""
    weights = np.asarray(weights, dtype=np.float64)
    order = np.argsort(-weights, axis=1, kind="stable")[:, :INFLUENCES]
    heaviest = np.take_along_axis(weights, order, axis=1)
    return frozen(order, np.uint32), frozen(heaviest / heaviest.sum(axis=1, keepdims=True))


def blend(hand: Hand, angle: ArrayLike, *, method: Method = "dual") -> Array:
    """Points (N, 3) of the even skin at ``angle`` (dof,) in radians."""
    out = np.empty_like(hand.skin.points)
    blend_into(hand, relative_transforms(hand, angle), out, method=method)
    out.setflags(write=False)
    return out


def blend_into(hand: Hand, transform: Array, out: Array, *, method: Method = "dual") -> None:
    """``blend`` into an array that exists, from ``relative_transforms``: for live views that reuse their points."""
    bound = binding(hand)
    if method == "dual":
        quaternion = np.empty((len(transform), 8))
        kernel.dual_quaternions(transform, quaternion)
        kernel.blend_dual(hand.skin.points, bound.index, bound.weight, quaternion, out)
    elif method == "linear":
        kernel.blend_linear(hand.skin.points, bound.index, bound.weight, transform, out)
    else:
        raise ValueError(f"method is {method!r}; choose 'dual' (keeps girth) or 'linear' (averages matrices)")


def normals(hand: Hand, skin_points: ArrayLike) -> Array:
    """Unit vertex normals (N, 3) of the even skin, weighted by triangle area."""
    points = skin_array(hand, skin_points)
    out = np.empty(points.shape)
    kernel.vertex_normals(points, binding(hand).faces, out)
    return out


def fine_points(hand: Hand, skin_points: ArrayLike, raised: Array | None = None) -> Array:
    """Points (Nf, 3) of the detailed skin on an even skin (N, 3): sum_i barycentric_i (p_i + height n_i).

    Where the even skin is more curved than in the bind posture, heights grow by as much as it rises over its flat triangles
    (``sagitta``). ``raised`` (Nf,) m is added to them: ridges of tendons.
    """
    points = skin_array(hand, skin_points)
    fine, bound, upright = hand.skin_fine, binding(hand), normals(hand, points)
    height, out = np.empty(len(fine.points)), np.empty_like(fine.points)
    kernel.sagitta(points, upright, bound.corners, fine.barycentric, height)
    height += flat_height(hand)
    if raised is not None:
        height += raised
    kernel.bound_points(points, upright, bound.corners, fine.barycentric, frozen(height), out)
    return out


@per_hand
def flat_height(hand: Hand) -> Array:
    """Heights (Nf,) of the fine skin over the even one, were that as flat between its points as its triangles are."""
    fine, sag = hand.skin_fine, np.empty(len(hand.skin_fine.points))
    kernel.sagitta(hand.skin.points, normals(hand, hand.skin.points), binding(hand).corners, fine.barycentric, sag)
    return frozen(fine.height - sag)


def skin_array(hand: Hand, skin_points: ArrayLike) -> Array:
    """Skin points (N, 3) in the layout of the kernels."""
    points = np.ascontiguousarray(skin_points, dtype=np.float64).view()
    points.setflags(write=False)  # kernels are compiled anew for arrays that can be written
    if points.shape != hand.skin.points.shape:
        raise ValueError(f"skin points have shape {points.shape}; this hand's even skin has {hand.skin.points.shape}")
    return points
