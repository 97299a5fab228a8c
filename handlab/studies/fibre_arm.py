"""Lever arms of geometric muscles from their paths: r = -dL/d(angle), the length that a fibre loses per angle (tendon excursion)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.simulation.geometric_muscle import GeometricMuscles
from handlab.simulation.kinematics import relative_transforms

STEP = 1e-4  # radians to either side: far above rounding, far below any bend of the path


def fibre_path(hand: Hand, muscles: GeometricMuscles, name: str, angle: ArrayLike) -> Array:
    """Control points (fibres, points, 3) of one muscle from origin to insertion at ``angle`` (dof,) rad, metres.

    Every point rides on its bones: p = sum over bones of share * T(bone) * point.
    """
    chains, k = muscles.chains, muscles.index(name)
    rows = np.flatnonzero(chains.grid == k)
    start, count = int(chains.first_node[rows[0]]), int(chains.nodes[rows].sum())
    part = slice(start, start + count)
    bodies = relative_transforms(hand, angle)[chains.body[part]]  # (points, 2, 4, 4)
    home = np.concatenate([chains.point[part], np.ones((count, 1))], axis=1)
    placed: Array = np.einsum("nb,nbij,nj->ni", chains.share[part], bodies, home)[:, :3].reshape(len(rows), -1, 3)
    return placed


def fibre_lengths(hand: Hand, muscles: GeometricMuscles, name: str, angle: ArrayLike) -> Array:
    """Lengths (fibres,) in metres of one muscle's fibres at ``angle`` (dof,) rad, along straight segments, tendinous ends included."""
    steps = np.diff(fibre_path(hand, muscles, name, angle), axis=1)
    result: Array = np.linalg.norm(steps, axis=2).sum(axis=1)
    return result


def fibre_arms(hand: Hand, muscles: GeometricMuscles, name: str, rotation: str, angle: ArrayLike | None = None) -> Array:
    """Lever arms (fibres,) in metres of one muscle about ``rotation``, such as ``"cmc1.flexion_opposition"``: r = -dL/d(angle).

    ``angle`` (dof,) rad, the bind posture if not given. Rotations that follow this one do not move: it is the arm about one axis.
    """
    dof = hand.dof_names.index(hand.dofs[rotation].name)
    middle = np.array(hand.bind if angle is None else angle, dtype=np.float64)
    more, less = middle.copy(), middle.copy()
    more[dof] += STEP
    less[dof] -= STEP
    lost = fibre_lengths(hand, muscles, name, less) - fibre_lengths(hand, muscles, name, more)
    result: Array = lost / (2.0 * STEP)
    return result
