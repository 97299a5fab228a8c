"""Compiled look-up of moments of inertia in tables (section 4.1.2): arrays in, arrays out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

if TYPE_CHECKING:
    from handlab.simulation.inertia_tables import InertiaTables

Array = NDArray[np.float64]


@compiled
def look_up(tables: InertiaTables, y: Array, nearest: bool, out: Array) -> None:
    """Fill ``out`` (k,) with the moment of inertia of every moving coordinate at ``y`` (k,), kg m^2.

    ``nearest``: the entry of the nearest angles, as in the paper; otherwise linear between the entries around. Beyond the ends
    of a table its last entry holds; an angle that is no number counts as the first.
    """
    per_radian = 1.0 / tables.step
    values = tables.values
    for k in range(tables.inner.shape[0]):
        base, inner, outer = tables.start[k], tables.inner[k], tables.outer[k]
        if inner < 0:
            out[k] = values[base]
            continue
        row, rows = (y[inner] - tables.low[k, 0]) * per_radian, tables.entries[k, 0]
        if not row > 0.0:
            row = 0.0
        row = min(row, rows - 1.0)
        column, columns = 0.0, tables.entries[k, 1]
        if outer >= 0:
            column = (y[outer] - tables.low[k, 1]) * per_radian
            if not column > 0.0:
                column = 0.0
            column = min(column, columns - 1.0)
        if nearest:
            out[k] = values[base + int(row + 0.5) * columns + int(column + 0.5)]
            continue
        i, j = min(int(row), rows - 2), int(column)
        part = row - i
        here = base + i * columns + j
        if outer < 0:
            out[k] = values[here] + part * (values[here + 1] - values[here])
            continue
        if j > columns - 2:
            j -= 1
            here -= 1
        aside = column - j
        near = values[here] + aside * (values[here + 1] - values[here])
        here += columns
        far = values[here] + aside * (values[here + 1] - values[here])
        out[k] = near + part * (far - near)
