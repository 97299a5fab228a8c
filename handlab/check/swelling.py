"""What the checks of lesson 08 measure on a fresh hand: painted muscles, their arms, their bellies, the skin above them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.grids import MuscleGrid
from handlab.anatomy.records import Array
from handlab.check.answers import reference
from handlab.check.verdict import Wrong
from handlab.simulation.geometric_muscle import Ellipsoids, GeometricMuscles, geometric_muscles, muscles_of, shape
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.muscle_below import below, influenced
from handlab.simulation.muscle_fit import checked_skin
from handlab.simulation.soft_frame import begin
from handlab.simulation.soft_skin import soft_skin
from handlab.studies.fibre_arm import fibre_arms

FPB = "flexor_pollicis_brevis"
CMC = "cmc1.flexion_opposition"


@cache
def _fitted(grid: MuscleGrid) -> GeometricMuscles:
    return muscles_of(reference(), [grid])


def painted(grid: Any) -> GeometricMuscles:
    """The muscle of a student's grid, on a fresh hand. Raises ``Wrong`` for what is no grid."""
    grid = getattr(grid, "grid", grid)  # the panel itself is as good
    if not isinstance(grid, MuscleGrid):
        raise Wrong(f"Give the painted grid, panel.grid; this is a {type(grid).__name__}.")
    return _fitted(grid)


@cache
def arm_ratio() -> float:
    """Of the arms of the shipped muscle at both limits of the CMC joint, the larger over the smaller."""
    hand, muscles = reference(), geometric_muscles(reference())
    dof = hand.dof_names.index(CMC)
    arms = []
    for limit in hand.limits[dof]:
        angle = hand.bind.copy()
        angle[dof] = limit
        arms.append(float(fibre_arms(hand, muscles, FPB, CMC, angle).mean()))
    return max(arms) / min(arms)


def swollen(contraction: float) -> Ellipsoids:
    """The ellipsoids of the shipped muscle in the bind posture."""
    hand, muscles = reference(), geometric_muscles(reference())
    pull = np.zeros(len(hand.muscles))
    pull[hand.muscle_names.index(FPB)] = contraction
    found = shape(muscles, relative_transforms(hand, hand.bind), pull)
    part = muscles.of(FPB)
    return Ellipsoids(found.centre[part], found.frame[part], found.half[part])


@cache
def covered_points(name: str) -> tuple[int, int]:
    """Above how many of the skin points that a shipped muscle influences another one lies in between, and how many there are."""
    hand, muscles = reference(), geometric_muscles(reference())
    owner = np.append(muscles.owner, -1)[below(hand, muscles)[1]]
    points = influenced(hand, muscles, name)
    return int(np.count_nonzero(owner[points] != muscles.index(name))), len(points)


def rise(muscles: GeometricMuscles) -> Array:
    """How far (N,) every skin point goes outwards when FPB contracts fully and the bones stay, metres."""
    hand = reference()
    network = soft_skin(hand, muscles=muscles)
    pull = np.zeros(len(hand.muscles))
    still = begin(hand, network, hand.bind, pull).points
    pull[hand.muscle_names.index(FPB)] = 1.0
    after = begin(hand, network, hand.bind, pull).points
    result: Array = np.einsum("nd,nd->n", after - still, checked_skin(hand))
    return result
