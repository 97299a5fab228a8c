"""The skin as masses and springs: a network built once per hand, and its state (sections 3.1 and 4.2, after Kähler, Haber, Seidel 2001).

A node per vertex of the even skin, a spring per edge, and per node a mirrored pair of springs to what lies below: bone, or the surface of
a geometric muscle. Everything is in physical units; constants marked *assumption* have no source for this hand.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from handlab.anatomy.records import Array, Hand, Index, Mesh, frozen
from handlab.physics.springs import (
    column_stiffness,
    largest_frequency,
    membrane_stiffness,
    mirrored_pair,
    spring_force,
    spring_tensor,
    stiffness_matrix,
    substeps,
)
from handlab.simulation.bones_below import bodies, nearest_bone
from handlab.simulation.geometric_muscle import GeometricMuscles, geometric_muscles
from handlab.simulation.hairy_skin import TISSUE, firmness
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skin import packed
from handlab.simulation.soft_skin_kernel import Node
from handlab.simulation.soft_ties import Ties, ties_of
from handlab.simulation.surface_graph import diffused, edge_areas, edges_of, face_normals, node_areas

YOUNG = 100e3  # Pa, skin in tension: the order of most measurements in vivo
THICKNESS = 0.0015  # m, epidermis and dermis, between the back of the hand (about 1) and the palm (about 2): assumption
DENSITY = 1100.0  # kg/m^3
PRESTRETCH = 0.03  # skin of the resting hand is taut by this much (cut skin gapes): assumption, at the low end
SLACK = 0.0  # share of its stiffness that skin has when pressed along its surface, because it wrinkles: assumption
PAIR_REST = 2.0 / 3.0  # rest length of the mirrored pair over its arm: stiffness across is then E / 3, as in incompressible tissue
DAMPING = 600.0  # 1/s: the slowest parts of the skin come to rest within a frame: assumption
SHALLOWEST = 0.0015  # m: columns of tissue are not taken to be shorter; springs of the thinnest would set the step for all
SMOOTHING = 1.0  # how far weights of deep nodes spread, against ``SMOOTHING_DEPTH``; see ``anchor_weights``
SMOOTHING_DEPTH = 0.004  # m
BELOW, BELOW_NEAR, BELOW_FAR = (
    0.9,
    0.012,
    0.020,
)  # least weight of the bone below, up to which depth (m), and where it has faded: assumption


@dataclass(frozen=True, eq=False)
class Network:
    """Masses and springs of one hand, in the bind posture: n nodes, e edges; arrays of the kernels are (3, n).

    ``first``, ``second`` (e,) nodes of each edge, ``stiffness`` (e,) N/m, ``rest`` (e,) m natural and ``longest`` (e,) m bind length;
    ``mass`` (n,) kg. Per node: ``points`` (n, 3), ``centre`` (n, 3) of its mirrored pair, ``arm`` (n, 3) from the centre away from the
    anchor, ``hold`` (n,) N/m of one of the two springs, ``depth`` (n,) m of the tissue column, ``area`` (n,) m^2 of the net of centres,
    ``degree`` (n,) edges; all move with the blend of bodies ``index``, ``weight`` (n, 4).
    Per triangle: ``face_normal`` (M, 3), as long as twice its area; those at node v are ``fan[fan_start[v]:fan_start[v + 1]]``.
    ``ties``: which nodes lie on which ellipsoids of ``muscles``. ``frequency`` rad/s: the highest of the net at rest.
    """

    points: Array
    faces: Node
    first: Node
    second: Node
    stiffness: Array
    rest: Array
    slack: float
    mass: Array
    inverse_mass: Array
    centre: Array
    arm: Array
    hold: Array
    depth: Array
    area: Array
    degree: Array
    index: Node
    weight: Array
    damping: float
    frequency: float
    volume: float
    compliance: float
    face_normal: Array
    fan_start: Node
    fan: Node
    longest: Array
    ties: Ties
    muscles: GeometricMuscles | None
    young: float
    tissue: float

    def substeps(self, dt: float) -> int:
        """Leapfrog steps in ``dt`` seconds: from the largest eigenvalue, never from trial."""
        return substeps(dt, self.frequency)

    @property
    def anchors(self) -> Array:
        """Where the nodes are tied below the skin (n, 3), in the bind posture."""
        result: Array = self.centre - self.arm
        return result


@dataclass(frozen=True, eq=False)
class SoftSkin:
    """The skin at one moment; a step returns another one.

    ``position`` (3, n) m; ``velocity`` (3, n) m/s, half a step behind; ``centre`` (3, n) of the mirrored pairs; ``normal`` (3, n);
    ``swelling``: relative stretch of all tissue columns that keeps the volume; ``volume`` m^3; ``push`` (3, n) m: how far limits have
    moved the columns; ``faults``: triangles still inverted.
    """

    position: Array
    velocity: Array
    centre: Array
    normal: Array
    swelling: float
    volume: float
    push: Array
    faults: int = 0

    @property
    def points(self) -> Array:
        """Skin points (n, 3)."""
        return frozen(self.position.T)


@per_hand
def _built(hand: Hand) -> dict[tuple[float, ...], Network]:
    return {}


def soft_skin(
    hand: Hand,
    young: float = YOUNG,
    *,
    tissue: float = TISSUE,
    thickness: float = THICKNESS,
    slack: float = SLACK,
    prestretch: float = PRESTRETCH,
    damping: float = DAMPING,
    muscles: GeometricMuscles | None = None,
) -> Network:
    """The network of a hand, built once for every set of constants.

    ``young`` Pa of the skin, ``tissue`` Pa of what is below that of the palm (less below hairy skin, see ``hairy_skin``), ``thickness`` m
    of the skin; ``slack`` and ``prestretch`` as in the constants above; ``muscles``: others than the shipped ones, such as painted
    ones. Raises ``ValueError`` for numbers that make no net.
    """
    numbers = {"young": young, "tissue": tissue, "thickness": thickness, "slack": slack, "prestretch": prestretch, "damping": damping}
    for name, value in numbers.items():
        low = 0.0 if name in ("slack", "prestretch", "damping") else 1e-9
        if not isfinite(value) or value < low:
            raise ValueError(f"{name} is {value:g}; give a number that is {'not negative' if low == 0.0 else 'positive'}")
    if muscles is not None:
        return _network(hand, muscles, **numbers)
    kept, key = _built(hand), tuple(numbers.values())
    if key not in kept:
        kept[key] = _network(hand, geometric_muscles(hand), **numbers)
    return kept[key]


def anchor_weights(hand: Hand, edges: Index, depth: Array, nearest: Index) -> tuple[Node, Array]:
    """Blend weights (n, 4) by which anchors move: those of the skin, with two changes.

    An anchor on one bone alone would tear the net at every joint, so anchors move with the dual-quaternion blend. But the body whose bone
    is ``nearest`` (n,) has at least the weight ``BELOW`` where it is near: tissue over the carpal bones is tied to them, though the skin's
    own weights pass from forearm to thumb there. And weights spread where bone is far: the skin's own change within one edge between two
    fingers, where nothing holds it to one of them. They solve c (w - w0) = L w with the pull c = (depth0 / depth)^2.
    """
    wanted = hand.skin.weights.copy()
    row = np.arange(len(wanted))
    floor = BELOW * np.clip((BELOW_FAR - depth) / (BELOW_FAR - BELOW_NEAR), 0.0, 1.0)
    own = wanted[row, nearest]
    raised = np.maximum(own, floor)
    wanted *= ((1.0 - raised) / np.maximum(1.0 - own, 1e-9))[:, None]
    wanted[row, nearest] = raised
    wanted /= wanted.sum(axis=1, keepdims=True)
    pull = (SMOOTHING_DEPTH / np.maximum(depth, 0.001)) ** 2
    return packed(diffused(hand.skin, edges, wanted, pull / SMOOTHING))


def _network(
    hand: Hand,
    muscles: GeometricMuscles,
    *,
    young: float,
    tissue: float,
    thickness: float,
    slack: float,
    prestretch: float,
    damping: float,
) -> Network:
    skin = hand.skin
    points, edges = skin.points, edges_of(skin)
    way = points[edges[:, 1]] - points[edges[:, 0]]
    length, area = np.linalg.norm(way, axis=1), node_areas(skin)
    stiffness = membrane_stiffness(young, thickness, edge_areas(skin, edges), length)
    rest, mass = length / (1.0 + prestretch), area * thickness * DENSITY
    place, distance, nearest = nearest_bone(hand, points)
    ties, cover, foot = ties_of(skin, muscles, distance)
    below = place + cover[:, None] * (foot - place)
    arm = points - below
    depth = np.linalg.norm(arm, axis=1)
    arm *= (np.maximum(depth, SHALLOWEST) / depth)[:, None]
    depth = np.maximum(depth, SHALLOWEST)
    hold = column_stiffness(tissue * firmness(hand, depth, thickness), area, depth) / 2.0
    centre = balanced(points, arm, hold, tension(points, edges, stiffness, rest))
    centre_area = node_areas(Mesh(centre, skin.faces))
    index, weight = anchor_weights(hand, edges, distance, bodies(hand)[nearest])
    grounded = pair_tensor(points - centre, arm, hold)
    frequency = largest_frequency(stiffness_matrix(len(points), edges, spring_tensor(way, stiffness, rest), grounded), mass)
    return Network(
        points=frozen(points),
        faces=frozen(skin.faces, np.uint32),
        first=frozen(edges[:, 0], np.uint32),
        second=frozen(edges[:, 1], np.uint32),
        stiffness=frozen(stiffness),
        rest=frozen(rest),
        slack=slack,
        mass=frozen(mass),
        inverse_mass=frozen(1.0 / mass),
        centre=frozen(centre),
        arm=frozen(arm),
        hold=frozen(hold),
        depth=frozen(depth),
        area=frozen(centre_area),
        degree=frozen(np.bincount(edges.ravel(), minlength=len(points))),
        index=index,
        weight=weight,
        damping=damping,
        frequency=frequency,
        volume=skin.volume,
        compliance=float(area @ depth),
        face_normal=frozen(face_normals(skin)),
        fan_start=frozen(np.concatenate([[0], np.cumsum(np.bincount(skin.faces.ravel(), minlength=len(points)))]), np.uint32),
        fan=frozen(np.argsort(skin.faces.ravel(), kind="stable") // 3, np.uint32),
        longest=frozen(length),
        ties=ties,
        muscles=muscles,
        young=young,
        tissue=tissue,
    )


def tension(points: Array, edges: Index, stiffness: Array, rest: Array) -> Array:
    """Pull (n, 3) N of taut edges (e, 2) on nodes at ``points`` (n, 3); edges shorter than at rest do nothing."""
    ends = points[edges[:, 0]], points[edges[:, 1]]
    force = spring_force(*ends, stiffness, np.minimum(rest, np.linalg.norm(ends[1] - ends[0], axis=1)))
    pull = np.zeros_like(points)
    np.add.at(pull, edges[:, 0], force)
    np.add.at(pull, edges[:, 1], -force)
    return pull


def pair_tensor(offset: Array, arm: Array, hold: Array) -> Array:
    """Stiffness tensors (n, 3, 3) of mirrored pairs with the node at ``offset`` (n, 3) from their centre."""
    rest = PAIR_REST * np.linalg.norm(arm, axis=1)
    return spring_tensor(arm + offset, hold, rest) + spring_tensor(arm - offset, hold, rest)


def balanced(points: Array, arm: Array, hold: Array, load: Array) -> Array:
    """Centres (n, 3) of the mirrored pairs with which nodes at ``points`` rest under ``load`` (n, 3) N: the pull of taut skin."""
    rest = PAIR_REST * np.linalg.norm(arm, axis=1)
    centre = points.copy()
    for _ in range(20):  # Newton, column by column
        left = load + mirrored_pair(points, centre, arm, hold, rest)
        centre -= np.linalg.solve(pair_tensor(points - centre, arm, hold), left[:, :, None])[:, :, 0]
    return centre
