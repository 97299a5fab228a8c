"""How many steps a frame of the spring skin needs: said before by the largest eigenvalue, and found out by trial.

The prediction is ``Network.frequency``; a trial disturbs the resting skin by a nanometre and looks whether that grows.
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, frozen
from handlab.physics.springs import largest_frequency, spring_tensor, stiffness_matrix
from handlab.simulation.soft_anchors import Anchors
from handlab.simulation.soft_frame import advance, at_bind
from handlab.simulation.soft_skin import Network, balanced, pair_tensor, tension

FRAME = 1.0 / 60.0  # s
NUDGE = 1e-9  # m: so small that every spring is a straight line
STEPS = 800  # near the limit a disturbance needs many steps to show which way it goes
GROWN = 10.0  # times the nudge
MOST_STEPS = 1e6
SETTLED, SHORT = 4, 1.5  # frames of rest before the nudge, in steps shorter by this factor than the longest stable one


def predicted(network: Network, frame: float = FRAME) -> float:
    """Fewest leapfrog steps in ``frame`` seconds with which the skin is stable, not rounded: omega_max frame / 2."""
    return 0.5 * frame * network.frequency


def anchored(network: Network) -> Anchors:
    """The anchors of the bind posture, which stand still."""
    turn = np.zeros((4, len(network.mass)))
    turn[0] = 1.0
    return Anchors(np.ascontiguousarray(network.centre.T), np.ascontiguousarray(network.arm.T), turn, np.zeros(len(turn[0])))


def growth(network: Network, substeps: float, *, frame: float = FRAME, steps: int = STEPS) -> float:
    """How many times larger a disturbance of the resting skin has become after ``steps`` steps of ``frame / substeps`` seconds.

    ``substeps`` need not be a whole number. Infinite where the numbers overflowed.
    """
    if not substeps > 0.0:
        raise ValueError(f"substeps is {substeps:g}; give a positive number of steps in a frame")
    soft = at_bind(network)
    nudge = NUDGE * np.random.default_rng(0).standard_normal(soft.position.shape)
    still = anchored(network)
    # Very taut skin creeps a little from where it was bound. That is no fault of the step, so it comes to rest first, in short steps.
    calm = ceil(SETTLED * SHORT * predicted(network))
    position, velocity = advance(network, soft, still, SETTLED * FRAME, steps=calm)
    start = replace(soft, position=position + nudge, velocity=velocity)
    with np.errstate(all="ignore"):
        disturbed, _ = advance(network, start, still, steps * frame / substeps, steps=steps)
        grown = float(np.abs(disturbed - position).max() / np.abs(nudge).max())
    return grown if np.isfinite(grown) else float("inf")


def grows(network: Network, substeps: float, *, frame: float = FRAME) -> bool:
    """Whether the skin is unstable with so many steps in a frame."""
    return growth(network, substeps, frame=frame) > GROWN


def border(network: Network, *, frame: float = FRAME, part: float = 1e-3) -> float:
    """The number of steps at which stability begins, to ``part`` of itself, by trial alone: intervals are halved."""
    low, high = 1.0, 2.0
    while grows(network, high, frame=frame):
        low, high = high, 2.0 * high
        if high > MOST_STEPS:
            raise ArithmeticError(f"this net is not stable with {MOST_STEPS:g} steps in a frame; its stiffnesses or masses make no net")
    while high - low > part * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if grows(network, middle, frame=frame) else (low, middle)
    return 0.5 * (low + high)


def seconds_per_step(network: Network, steps: int = STEPS) -> float:
    """What one leapfrog step of this skin takes on this computer: the best of three tries."""
    soft, tries = at_bind(network), []
    still = anchored(network)
    for _ in range(3):
        begin = perf_counter()
        advance(network, soft, still, steps * FRAME / (2.0 * predicted(network)), steps=steps)
        tries.append((perf_counter() - begin) / steps)
    return min(tries)


def stiffness(network: Network) -> Any:
    """K (3 n, 3 n) N/m, sparse, of the resting net: how the forces on all nodes change with their places, x y z of node 0 first."""
    edges = np.stack([network.first, network.second], axis=1).astype(np.int64)
    way = network.points[edges[:, 1]] - network.points[edges[:, 0]]
    columns = pair_tensor(network.points - network.centre, network.arm, network.hold)
    matrix: Any = stiffness_matrix(len(network.points), edges, spring_tensor(way, network.stiffness, network.rest), columns)
    return matrix.tocsr()


def worst_pattern(network: Network) -> Array:
    """How far (n, 3) every node swings in the fastest swing of the net, the farthest by 1: the pattern that explodes first."""
    from scipy.sparse import diags
    from scipy.sparse.linalg import eigsh

    root = np.sqrt(np.repeat(network.mass, 3))
    scale = diags(1.0 / root)
    start = np.cos(np.arange(len(root)))  # the same every time
    vector = eigsh((scale @ stiffness(network) @ scale).tocsr(), k=1, which="LA", v0=start, tol=1e-8)[1][:, 0]
    swing = (vector / root).reshape(-1, 3)
    result: Array = swing / np.linalg.norm(swing, axis=1).max()
    return result


def with_mass(network: Network, mass: ArrayLike) -> Network:
    """The same springs with other masses (n,) kg, and the frequency that goes with them."""
    new = np.asarray(mass, dtype=np.float64)
    if new.shape != network.mass.shape or not (np.isfinite(new).all() and (new > 0.0).all()):
        raise ValueError(f"mass has shape {new.shape}; give {len(network.mass)} positive masses in kg, such as 2 * network.mass")
    return replace(network, mass=frozen(new), inverse_mass=frozen(1.0 / new), frequency=largest_frequency(stiffness(network), new))


def with_moduli(network: Network, young: float, tissue: float) -> Network:
    """The same skin with other Young's moduli in Pa, of the skin and of the tissue below it: what ``soft_skin`` makes, but quicker.

    Made for counting steps at rest. For motion take ``soft_skin``, which also measures the net of the moved centres.
    """
    for name, value in (("young", young), ("tissue", tissue)):
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value:g}; give a positive number of pascals, such as 100e3")
    springs, hold = network.stiffness * (young / network.young), network.hold * (tissue / network.tissue)
    edges = np.stack([network.first, network.second], axis=1).astype(np.int64)
    centre = balanced(network.points, network.arm, hold, tension(network.points, edges, springs, network.rest))
    changed = replace(network, stiffness=frozen(springs), hold=frozen(hold), centre=frozen(centre), young=young, tissue=tissue)
    return replace(changed, frequency=largest_frequency(stiffness(changed), network.mass))
