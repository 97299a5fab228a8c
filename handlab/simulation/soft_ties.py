"""Which skin points lie on which geometric muscles, and how much of a muscle's motion reaches them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handlab.anatomy.meshes import Mesh
from handlab.anatomy.records import Array, frozen
from handlab.simulation.geometric_muscle import GeometricMuscles
from handlab.simulation.soft_skin_kernel import Node

NEAR = 0.004  # m: a node this near a muscle moves with it wholly: assumption
FAR = 0.010  # m: a node this far feels nothing of it: assumption; tissue between them gives way
FACING = 0.3  # cosine: a muscle must lie below the skin, not beside it


class Ties(NamedTuple):
    """Tie t of ``node`` (t,), in rising order, to ``ellipsoid`` (t,) with ``share`` (t,); shares of a node add to at most 1.

    ``local`` (t, 3): the foot on the ellipsoid in its half-axes, a unit vector; ``below`` (t, 3) m from the node's rest place to the foot.
    """

    node: Node
    ellipsoid: Node
    share: Array
    local: Array
    below: Array


def ties_of(skin: Mesh, muscles: GeometricMuscles, bone_distance: Array) -> tuple[Ties, Array, Array]:
    """Ties of all nodes, the cover (n,) of each, 0 to 1, and the mean foot (n, 3) of those covered.

    The foot lies on the line to the ellipsoid's middle, in its half-axes. Near ellipsoids weigh more, so that the motion is
    smooth along the skin; what lies deeper than bone reaches no skin.
    """
    centre, frame, half = muscles.rest
    points = skin.points
    local = np.einsum("nsi,sij->nsj", points[:, None] - centre, frame) / half
    size = np.linalg.norm(local, axis=2)
    local /= np.maximum(size, 1e-9)[..., None]
    foot = centre + np.einsum("sij,nsj->nsi", frame, local * half)
    way = points[:, None] - foot
    distance = np.linalg.norm(way, axis=2)
    facing = np.einsum("nsi,ni->ns", way, _normals(skin)) / np.maximum(distance, 1e-9)
    inside = size < 1.0  # the muscle comes out of the skin there: its surface is the node itself
    distance = np.where(inside, 0.0, distance)
    shallow = np.minimum(distance, bone_distance[:, None] + NEAR) == distance
    raw = np.clip((FAR - distance) / (FAR - NEAR), 0.0, None) ** 2 * np.where(
        inside, 1.0, np.clip((facing - FACING) / (1.0 - FACING), 0.0, 1.0)
    )
    raw = np.where(shallow, raw, 0.0)
    raw[raw < 1e-3 * np.maximum(raw.max(axis=1, keepdims=True), 1e-30)] = 0.0
    cover = np.clip(raw.max(axis=1, initial=0.0), 0.0, 1.0)
    share = raw**2 / np.maximum((raw**2).sum(axis=1, keepdims=True), 1e-30) * cover[:, None]
    node, ellipsoid = np.nonzero(share > 1e-3)
    mean = np.einsum("ns,nsi->ni", share, foot) / np.maximum(share.sum(axis=1), 1e-30)[:, None]
    ties = Ties(
        frozen(node, np.uint32),
        frozen(ellipsoid, np.uint32),
        frozen(share[node, ellipsoid]),
        frozen(local[node, ellipsoid]),
        frozen((foot - points[:, None])[node, ellipsoid]),
    )
    return ties, frozen(cover), frozen(np.where(cover[:, None] > 0.0, mean, points))


def _normals(skin: Mesh) -> Array:
    corners = skin.points[skin.faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = np.zeros_like(skin.points)
    for k in range(3):
        np.add.at(normal, skin.faces[:, k], area)
    result: Array = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return result
