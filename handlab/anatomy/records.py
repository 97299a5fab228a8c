"""The hand as frozen records: what anatomy says, in arrays that nobody can change by accident.

All lengths in metres, angles in radians, masses in kilograms, forces in newtons.
Frame of a right hand: origin at the wrist centre, x distal along the middle metacarpal,
y palmar, z = x cross y (radial). Angles count from the *zero* posture (anatomically
straight); joint axes and centres are written in that posture. Meshes are stored in the
*bind* posture.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.capsule import Capsule as Capsule
from handlab.anatomy.growth import Growth as Growth
from handlab.anatomy.meshes import Array as Array
from handlab.anatomy.meshes import FineSkin as FineSkin
from handlab.anatomy.meshes import Index as Index
from handlab.anatomy.meshes import Mesh as Mesh
from handlab.anatomy.meshes import Skin as Skin
from handlab.anatomy.meshes import frozen as frozen
from handlab.anatomy.named import Named as Named
from handlab.anatomy.pseudo_muscles import LeverArm as LeverArm
from handlab.anatomy.pseudo_muscles import Muscle as Muscle

if TYPE_CHECKING:
    from handlab.anatomy.grids import MuscleGrid


@dataclass(frozen=True)
class Bone(Mesh):
    """One named bone; ``body`` is the rigid body it moves with (the carpal bones share one)."""

    name: str
    latin: str
    english: str
    body: str


@dataclass(frozen=True)
class Body:
    """A rigid body: bone and the tissue that moves with it, in the bind posture.

    ``mass`` kg, ``centre`` (3,) m, ``inertia`` (3, 3) kg m^2 about the centre; computed from
    the volume of this hand's geometry.
    """

    name: str
    parent: str | None
    joint: str | None
    mass: float
    centre: Array
    inertia: Array


@dataclass(frozen=True)
class DegreeOfFreedom:
    """One rotation of a joint. ``axis`` (3,) and ``anchor`` (3,) in the zero posture; ``limits`` (2,) rad.

    A coupled degree of freedom follows another one: angle = ``ratio`` * driver + ``offset``.
    """

    name: str
    joint: str
    positive: str
    negative: str
    axis: Array
    anchor: Array
    limits: Array
    sources: tuple[str, ...]
    driver: str | None = None
    ratio: float = 0.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A joint between two bones; ``centre`` (3,) in the zero posture."""

    name: str
    english: str
    parent: str
    child: str
    centre: Array
    dofs: tuple[DegreeOfFreedom, ...]


@dataclass(frozen=True, eq=False)
class Hand:
    """A hand: meshes, joints, muscles and the arrays that mechanics needs. Never changes; ``with_...`` returns another.

    Order of all arrays: muscles as in ``muscle_names`` (42), degrees of freedom as in ``dof_names`` (31),
    moving coordinates as in ``moving_names`` (23), rigid bodies as in ``body_names`` (19, parents first).

    Fibres have their rest length at ``fibre_rest`` (dof,) rad. Passive structures: springs of ``stiffness`` (dof,) about
    ``relaxed`` (dof,) (in the printed reading the straight hand), ``friction`` (dof,), ``capsule`` (None: hard limits),
    ``collateral`` ligaments of the finger MCP joints.
    ``growth``: how muscles differ from the tables in a hand of another size (None: not at all; see ``growth.grown``).
    ``grids``: of its geometric muscles (None: the shipped ones). ``picture`` (S, S, 3) uint8: colours of the fine skin in its texture
    coordinates, first row at v = 0, such as those of a photograph (None: painted from the shape).
    """

    name: str
    side: str
    reading: str
    skin: Skin
    skin_fine: FineSkin
    bones: Mapping[str, Bone]
    bodies: Mapping[str, Body]
    joints: Mapping[str, Joint]
    muscles: Mapping[str, Muscle]
    feature_points: Mapping[str, Mapping[str, int]]
    bind: Array
    fibre_rest: Array
    relaxed: Array
    stiffness: Array
    friction: Array
    capsule: Capsule | None
    collateral: Mapping[str, float]
    newton_per_percent: float
    sources: Mapping[str, Any] = field(repr=False)
    growth: Growth | None = None
    grids: tuple[MuscleGrid, ...] | None = None
    picture: NDArray[np.uint8] | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        return (
            f"Hand {self.name!r} ({self.side}, reading {self.reading!r}): {len(self.bones)} bones, {len(self.muscles)} muscles, "
            f"{len(self.joints)} joints, {len(self.dof_names)} degrees of freedom, skin of {len(self.skin.faces)} triangles"
        )

    @cached_property
    def dofs(self) -> Mapping[str, DegreeOfFreedom]:
        """Degrees of freedom by name, in the order of every array."""
        return Named("degree of freedom", {dof.name: dof for joint in self.joints.values() for dof in joint.dofs})

    @cached_property
    def dof_names(self) -> tuple[str, ...]:
        """Names like ``mcp2.flexion_extension``."""
        return tuple(self.dofs)

    @cached_property
    def muscle_names(self) -> tuple[str, ...]:
        """Full names of the 42 muscles."""
        return tuple(self.muscles)

    @cached_property
    def body_names(self) -> tuple[str, ...]:
        """Names of the rigid bodies, parents first."""
        return tuple(self.bodies)

    @cached_property
    def moving_names(self) -> tuple[str, ...]:
        """Names of the degrees of freedom that follow no other: the moving coordinates y."""
        return tuple(name for name, dof in self.dofs.items() if dof.driver is None)

    @cached_property
    def zero(self) -> Array:
        """Angles (dof,) of the anatomically straight hand: all zero by definition."""
        return frozen(np.zeros(len(self.dof_names)))

    @cached_property
    def lever_arm(self) -> Array:
        """R, signed lever arms (muscle, dof) in metres, of the hand's reading."""
        column = {name: k for k, name in enumerate(self.dof_names)}
        matrix = np.zeros((len(self.muscles), len(column)))
        for i, muscle in enumerate(self.muscles.values()):
            for arm in muscle.lever_arms:
                matrix[i, column[arm.dof]] += arm.printed if self.reading == "printed" else arm.used
        return frozen(matrix)

    @cached_property
    def rest_length(self) -> Array:
        """Fibre resting lengths (muscle,) in metres, of the hand's reading."""
        printed = self.reading == "printed"
        return frozen([muscle.rest_length_printed if printed else muscle.rest_length for muscle in self.muscles.values()])

    @cached_property
    def max_force(self) -> Array:
        """F_max (muscle,) in newtons: tension fraction times the settable ``newton_per_percent``."""
        return frozen([muscle.tension_percent * self.newton_per_percent for muscle in self.muscles.values()])

    @cached_property
    def limits(self) -> Array:
        """Lower and upper limit (dof, 2) in radians."""
        return frozen([dof.limits for dof in self.dofs.values()])

    @cached_property
    def coupling(self) -> Array:
        """C (dof, moving): angle = C @ y + ``coupling_offset``."""
        moving = {name: k for k, name in enumerate(self.moving_names)}
        matrix = np.zeros((len(self.dof_names), len(moving)))
        for row, dof in enumerate(self.dofs.values()):
            ratio = 1.0
            while dof.driver is not None:  # a follower may follow a follower
                ratio, dof = ratio * dof.ratio, self.dofs[dof.driver]
            matrix[row, moving[dof.name]] = ratio
        return frozen(matrix)

    @cached_property
    def coupling_offset(self) -> Array:
        """c0 (dof,) in radians."""
        offset = np.zeros(len(self.dof_names))
        row = {name: k for k, name in enumerate(self.dof_names)}
        for name, dof in self.dofs.items():  # drivers come before their followers' followers
            if dof.driver is not None:
                offset[row[name]] = dof.ratio * offset[row[dof.driver]] + dof.offset
        return frozen(offset)

    def with_(self, **changes: Any) -> Hand:
        """Another hand with these fields changed."""
        return replace(self, **changes)

    def with_newton_per_percent(self, newton_per_percent: float) -> Hand:
        """Another hand whose muscles pull this many newtons per percent of tension fraction."""
        if not np.isfinite(newton_per_percent) or newton_per_percent <= 0:
            raise ValueError(f"newton_per_percent is {newton_per_percent}; it must be a positive number (20 is the default, an assumption)")
        return self.with_(newton_per_percent=float(newton_per_percent))

    def with_fibre_rest(self, posture: str | Array) -> Hand:
        """Another hand whose fibres have their rest length in ``posture``: ``"flat"`` (the paper), ``"relaxed"`` (the default),
        ``"half-closed"``, or angles (dof,) in radians. Followers take the angle that their driver gives them."""
        from handlab.anatomy.tables import fibre_rest

        return self.with_(fibre_rest=fibre_rest(posture) if isinstance(posture, str) else frozen(posture))

    def without_passive(self) -> Hand:
        """Another hand without stiffness, capsule and collateral ligaments: joints that only friction and hard limits hold."""
        return self.with_(stiffness=frozen(np.zeros(len(self.stiffness))), capsule=None, collateral={})

    def save(self, folder: str | PathLike[str]) -> Path:
        """Write this hand into ``folder``, whole or not at all; ``load_hand(folder)`` gives it back (see ``store.save_hand``)."""
        from handlab.anatomy.store import save_hand  # loading a hand needs no writer

        return save_hand(self, folder)
