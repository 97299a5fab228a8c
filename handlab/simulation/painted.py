"""Painted muscles put to use: a hand that has them besides the shipped ones, in every place where muscles swell or are seen."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from handlab.anatomy.grids import MuscleGrid, load_grid, load_grids
from handlab.anatomy.records import Hand
from handlab.simulation.geometric_muscle import GeometricMuscles, geometric_muscles


def with_painted(hand: Hand, painted: Any) -> Hand:
    """Another hand that has ``painted`` muscles too; one takes the place of the muscle with its name. ``None``: ``hand`` itself.

    ``painted``: a grid, several, what ``hl.PaintPanel`` or ``muscles_of`` made, or a file or folder of grids. Whatever follows from the
    hand's muscles, its soft skin too, is computed anew for the new hand (a second or two). Raises ``ValueError`` for a grid that makes no
    muscle on this hand, ``TypeError`` for anything else; then nothing is kept.
    """
    if painted is None:
        return hand
    new = grids_of(painted)
    names = {grid.name for grid in new}
    others = load_grids() if hand.grids is None else hand.grids
    made = hand.with_(grids=(*(one for one in others if one.name not in names), *new))
    geometric_muscles(made)
    return made


def grids_of(painted: Any) -> tuple[MuscleGrid, ...]:
    """The grids in whatever painted muscles came as."""
    if isinstance(painted, MuscleGrid):
        return (painted,)
    if isinstance(painted, str | os.PathLike):
        return (load_grid(painted),) if Path(painted).is_file() else load_grids(painted)
    if isinstance(painted, GeometricMuscles):
        return tuple(one.grid for one in painted.fitted)
    if hasattr(painted, "painting") and hasattr(painted, "grid"):  # a panel, which this layer does not know
        return grids_of(painted.grid)
    if isinstance(painted, Iterable) and not isinstance(painted, bytes):
        found = tuple(grid for one in painted for grid in grids_of(one))
        if found:
            return found
    raise TypeError(f"painted is a {type(painted).__name__}; give a muscle grid, several of them, a PaintPanel, or a folder of grids")
