"""Masses of a new hand: the inside of its skin, shared among the bodies by the nearest bone, as for the reference hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from handlab.anatomy.mirror import renamed
from handlab.anatomy.records import Array, Body, Hand, Mesh, frozen
from handlab.physics.filling import filled

DENSITY = 1100.0  # kg/m^3, bone and soft tissue together: an assumption, the same as for the reference hand
STEP = 0.0015  # of the grid in a hand of the size of the reference hand, m


def weighed(hand: Hand, size: float = 1.0) -> Mapping[str, Body]:
    """Bodies of ``hand`` with mass, centre and inertia from its own skin and bones; ``size``: its length over the reference hand's.

    Numbers are rounded as a file keeps them.
    """
    from scipy.spatial import cKDTree

    step = STEP * size
    skin = Mesh(hand.skin.points, hand.skin.faces)
    mirrored = hand.side == "left"  # the grid begins at a corner: the same one, so that a mirrored hand weighs the same
    turn = np.array([1.0, 1.0, -1.0 if mirrored else 1.0])
    cells = filled(skin.points * turn, skin.faces, step) * turn
    cell = skin.volume / len(cells) * DENSITY  # the grid is brought to the exact volume
    names = list(hand.bodies)
    owner = np.concatenate([np.full(len(bone.points), names.index(bone.body)) for bone in hand.bones.values()])
    body = owner[cKDTree(np.concatenate([bone.points for bone in hand.bones.values()])).query(cells)[1]]
    found = {}
    for number, (name, old) in enumerate(hand.bodies.items()):
        mine = cells[body == number]
        if len(mine) == 0:
            raise ValueError(f"no part of this skin belongs to {name}: the skin and the bones do not fit together")
        centre = mine.mean(axis=0)
        r = mine - centre
        square = r.T @ r
        inertia = cell * (np.eye(3) * np.trace(square) - square) + np.eye(3) * cell * len(mine) * step**2 / 6.0
        inertia = np.array([[float(f"{value:.9e}") for value in row] for row in 0.5 * (inertia + inertia.T)])
        found[name] = replace(old, mass=round(cell * len(mine), 12), centre=frozen(centre.round(9)), inertia=frozen(inertia))
    result: Mapping[str, Body] = renamed(hand.bodies, found)
    return result


def with_masses_of(hand: Hand, other: Hand) -> Hand:
    """``hand`` with the masses of ``other`` and inertias of its own shape: the paper takes masses from tables, lengths from the bones."""
    kept: dict[str, Body] = {}
    for name, body in hand.bodies.items():
        mass = other.bodies[name].mass
        inertia: Array = frozen(body.inertia * (mass / body.mass))
        kept[name] = replace(body, mass=mass, inertia=inertia)
    return hand.with_(bodies=renamed(hand.bodies, kept))
