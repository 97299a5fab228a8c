"""The Kapandji score: how far round the hand the thumb's pulp can reach, 0 to 10.

A test of reach, asked of skin, joints and their limits alone: no muscle pulls here. Each stage is a small bounded least-squares
problem: the thumb's coordinates, and those with which the finger helps, bring the pulp onto a place of the posed skin.
Source: Kapandji 1986, clinical test of thumb opposition (recalled).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.physics.distance import closest
from handlab.simulation.kinematics import posed_axes
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skin import blend, normals
from handlab.studies.measures import flesh_depth, pulps, segment_faces, skin_distance

WITHIN = 0.004  # the pulp counts as there at this distance (assumption: an examiner's eye)
SOFT = 0.003  # deeper than this the pulp would have to go through flesh (assumption)
GAP = 0.0005  # aimed at between the two skins
THUMB = ("cmc1.flexion_opposition", "cmc1.abduction_adduction", "mcp1.flexion_extension", "ip1.flexion_extension")
# A finger that stands still is a little flexed, and may flex this much to help where it is not brought to the thumb, degrees.
# Assumption: the score calls for the finger's natural posture and gives no angles.
AT_EASE = {"mcp": 15.0, "pip": 20.0, "dip": 10.0}
HELP_AT_MOST = {"mcp": 45.0, "pip": 45.0, "dip": 30.0}
CUPPING = "cmc5.flexion_opposition"  # the palm hollows for the ring and the little finger
PALM = ("carpus", "metacarpal_4", "metacarpal_5")
ROUNDS = 25


@dataclass(frozen=True)
class Stage:
    """One stage: the place, how far from it the pulp stays in metres, how deep flesh is in flesh then, and the pose (dof,)."""

    number: int
    target: str
    distance: float
    depth: float
    reached: bool
    angle: Array


@dataclass(frozen=True)
class Opposition:
    """The ten stages; ``score`` counts those reached without one missed before."""

    stages: tuple[Stage, ...]

    @property
    def score(self) -> int:
        """0 to 10."""
        missed = [stage.number for stage in self.stages if not stage.reached]
        return missed[0] - 1 if missed else len(self.stages)


@dataclass(frozen=True)
class Place:
    """Where the pulp shall go: skin points, the finger they belong to, and whether that finger comes to meet the thumb."""

    name: str
    points: Index
    finger: int
    comes: bool = False


@per_hand
def places(hand: Hand) -> tuple[Place, ...]:
    """The ten places on the skin of a hand, in order."""
    marks, pulp = hand.feature_points, pulps(hand)

    def one(index: int) -> Index:
        points: Index = frozen([index], np.int64)
        return points

    def tip(name: str, k: int) -> Place:
        return Place(f"tip of the {name} finger", frozen(np.union1d(pulp[k], [marks[f"tip_{name}"]["palmar"]]), np.int64), k, comes=True)

    return (
        Place("radial side of the index finger's proximal phalanx", one(_beside(hand, "mcp2", "pip2")), 2),
        Place("radial side of the index finger's middle phalanx", one(_beside(hand, "pip2", "dip2")), 2),
        tip("index", 2),
        tip("middle", 3),
        tip("ring", 4),
        tip("little", 5),
        Place("distal crease of the little finger (DIP)", one(marks["dip_little"]["palmar"]), 5),
        Place("middle crease of the little finger (PIP)", one(marks["pip_little"]["palmar"]), 5),
        Place("crease at the base of the little finger", one(_base_crease(hand)), 5),
        Place("distal palmar crease below the little finger", one(marks["mcp_little"]["palmar"]), 5),
    )


def kapandji(hand: Hand, *, progress: Callable[[float], None] | None = None) -> Opposition:
    """The Kapandji opposition score of a hand: for each stage the nearest that the thumb's pulp comes, joints inside their limits.

    Minimises sum (pulp - place)^2 + sum (depth of flesh in flesh)^2 over the thumb's four coordinates and those of the finger
    that helps. ``progress`` is called with the finished fraction. Source: Kapandji 1986 (recalled). Takes a few seconds.
    """
    stages: list[Stage] = []
    found: dict[str, float] = {}
    for number, place in enumerate(places(hand), start=1):
        stage, last = _reach(hand, number, place, found if place.comes else {})
        if not stage.reached:  # a search can get stuck: once more from the other side
            again, other = _reach(hand, number, place, {} if place.comes else found)
            stage, last = min((stage, last), (again, other), key=lambda one: (not one[0].reached, one[0].distance + one[0].depth))
        stages.append(stage)
        found = last
        if progress is not None:
            progress(number / len(places(hand)))
    return Opposition(tuple(stages))


def _reach(hand: Hand, number: int, place: Place, start: dict[str, float]) -> tuple[Stage, dict[str, float]]:
    """One stage from where the thumb is already, and the coordinates found."""
    from scipy.optimize import least_squares

    fixed = _at_ease(hand)
    limits = _limits(hand, place)
    columns = np.array([hand.moving_names.index(name) for name in limits])
    low, high = np.array(list(limits.values())).T
    first = np.clip([start.get(name, fixed[k]) for name, k in zip(limits, columns, strict=True)], low + 1e-3, high - 1e-3)
    pulp, own, obstacle = pulps(hand)[1], _thumb_points(hand), _obstacle(hand, place)

    def angle(x: Array) -> Array:
        y = fixed.copy()
        y[columns] = x
        return coupled(hand, y)

    def residual(x: Array) -> Array:
        skin = blend(hand, angle(x))
        outward = normals(hand, skin)
        apart = skin[pulp].mean(axis=0) - skin[place.points].mean(axis=0)
        turned = outward[pulp].mean(axis=0) + outward[place.points].mean(axis=0)
        depth = np.maximum(0.0, -skin_distance(hand, skin, own, obstacle))
        return np.concatenate([[(_gap(hand, skin, place) - GAP) / 0.0007], apart / 0.004, turned / 0.5, depth / 0.001, (x - first) / 4.0])

    found = least_squares(residual, first, bounds=(low, high), diff_step=1e-3, max_nfev=ROUNDS).x
    skin = blend(hand, angle(found))
    distance, depth = _gap(hand, skin, place), float(flesh_depth(hand, skin).max())
    stage = Stage(number, place.name, distance, depth, distance <= WITHIN and depth <= SOFT, frozen(angle(found)))
    return stage, dict(zip(limits, found, strict=True))


def _at_ease(hand: Hand) -> Array:
    """Moving coordinates of the hand at the test: relaxed, the fingers a little flexed."""
    y = np.array(mechanics(hand).relaxed)
    for k in range(2, 6):
        for joint, degrees in AT_EASE.items():
            y[hand.moving_names.index(f"{joint}{k}.flexion_extension")] = np.deg2rad(degrees)
    return y


def _limits(hand: Hand, place: Place) -> dict[str, tuple[float, float]]:
    """Coordinates that may move, and how far, radians."""
    moving = mechanics(hand).limits
    free = [*THUMB, *([CUPPING] if place.finger >= 4 else [])]
    limits = {name: tuple(moving[hand.moving_names.index(name)]) for name in free}
    for joint, degrees in HELP_AT_MOST.items():
        name = f"{joint}{place.finger}.flexion_extension"
        low, high = moving[hand.moving_names.index(name)]
        limits[name] = (low, high) if place.comes else (max(low, 0.0), min(high, np.deg2rad(degrees)))
    return limits


def _gap(hand: Hand, skin: Array, place: Place) -> float:
    """Distance from the place to the skin of the thumb's pulp."""
    points, pulp = np.ascontiguousarray(skin[place.points]), np.ascontiguousarray(skin[hand.skin.faces[_pulp_faces(hand)]])
    return float(closest(points, pulp)[0].min())


def _obstacle(hand: Hand, place: Place) -> Index:
    """Triangles of the palm and of the finger in question."""
    faces = segment_faces(hand)
    return np.unique(np.concatenate([faces[name] for name in faces if name in PALM or name.endswith(f"phalanx_{place.finger}")]))


@per_hand
def _pulp_faces(hand: Hand) -> Index:
    """Triangles of the thumb's pulp."""
    return np.flatnonzero(np.isin(hand.skin.faces, pulps(hand)[1]).all(axis=1))


@per_hand
def _thumb_points(hand: Hand) -> Index:
    """Skin of the thumb's last phalanx."""
    return np.flatnonzero(hand.skin.weights[:, hand.body_names.index("distal_phalanx_1")] > 0.5)


def _beside(hand: Hand, near: str, far: str) -> int:
    """Skin point radial of the middle of a phalanx, in the bind posture."""
    axis, anchor = posed_axes(hand, hand.bind)
    row = [hand.dof_names.index(f"{joint}.flexion_extension") for joint in (near, far)]
    radial = axis[row[0]] if hand.side == "right" else -axis[row[0]]  # flexion is positive about the radial side of a right hand
    return _through(hand, anchor[row].mean(axis=0), radial)


def _base_crease(hand: Hand) -> int:
    """Palmar skin of the little finger at the level of its web."""
    axis, anchor = posed_axes(hand, hand.bind)
    row = hand.dof_names.index("mcp5.flexion_extension")
    start, along = anchor[row], anchor[hand.dof_names.index("pip5.flexion_extension")] - anchor[row]
    along = along / np.linalg.norm(along)
    web = hand.skin.points[hand.feature_points["web_ring_little"]["palmar"]]
    return _through(hand, start + along * ((web - start) @ along), np.cross(axis[row], along))


def _through(hand: Hand, at: Array, direction: Array) -> int:
    """The skin point nearest to where a line from inside comes out."""
    beyond = hand.skin.points - at
    along = beyond @ direction
    aside = np.linalg.norm(beyond - along[:, None] * direction, axis=1)
    facing = normals(hand, hand.skin.points) @ direction > 0.3
    return int(np.argmin(np.where((along > 0.0) & facing, aside + 0.15 * along, np.inf)))
