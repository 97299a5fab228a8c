"""What the checks of lesson 07 compute on a fresh hand: its springs, how many steps they need, rows of masses between walls."""

from __future__ import annotations

from functools import cache

import numpy as np

from handlab.anatomy.records import Array
from handlab.check.answers import reference
from handlab.physics.springs import stable_step
from handlab.simulation.hairy_skin import TISSUE
from handlab.simulation.soft_skin import YOUNG, Network, soft_skin
from handlab.studies import shaking

MASS, STIFFNESS = 1e-4, 2.0  # kg, N/m: of the single mass and of the row


@cache
def network(young: float = YOUNG, tissue: float = TISSUE) -> Network:
    """The skin of a fresh hand."""
    usual = soft_skin(reference())
    return usual if (young, tissue) == (YOUNG, TISSUE) else shaking.with_moduli(usual, young, tissue)


@cache
def fewest(young: float = YOUNG, tissue: float = TISSUE) -> int:
    """Smallest whole number of steps in a picture with which that skin is stable, by trial around the prediction."""
    net = network(young, tissue)
    count = int(shaking.predicted(net))
    while not shaking.grows(net, count):
        count -= 1
    while shaking.grows(net, count):
        count += 1
    return count


def row_limit_ms(masses: int, stiffness: float = STIFFNESS) -> float:
    """Longest step of a row between two walls, milliseconds."""
    matrix = stiffness * (2.0 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1))
    return 1e3 * stable_step(float(np.sqrt(np.linalg.eigvalsh(matrix)[-1] / MASS)))


def single_limit_ms(stiffness: float = STIFFNESS) -> float:
    """Longest step of one mass on springs of ``stiffness`` in all, milliseconds."""
    return 1e3 * stable_step(float(np.sqrt(stiffness / MASS)))


@cache
def saving(chosen: tuple[int, ...]) -> float:
    """Part of the steps that is saved when these nodes are twice as heavy."""
    mass: Array = network().mass.copy()
    mass[list(chosen)] *= 2.0
    return 1.0 - shaking.predicted(shaking.with_mass(network(), mass)) / shaking.predicted(network())


def stiff_alone(young: float) -> float:
    """What the root of the stiffness alone would give."""
    return shaking.predicted(network()) * float(np.sqrt(young / YOUNG))
