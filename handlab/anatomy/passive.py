"""Passive structures of the joints: stiffness, friction, capsule and collateral ligaments, from the one table ``passive.json``.

The paper has none of them but the friction. Millimetres, degrees and milliseconds end here. A broken table raises ``TableError``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.capsule import Capsule
from handlab.anatomy.data import read_json
from handlab.anatomy.meshes import Array, frozen
from handlab.anatomy.table_rules import TableError, check_sources, known_name, number
from handlab.anatomy.tables import joints_table, sources

FILE = "passive.json"


@dataclass(frozen=True, eq=False)
class Passive:
    """Passive properties (dof,): ``stiffness`` N m/rad, ``friction`` N m s/rad, ``capsule``; ``collateral`` of the finger MCP joints."""

    stiffness: Array
    friction: Array
    capsule: Capsule
    collateral: Mapping[str, float]


@cache
def _table() -> dict[str, Any]:
    table: dict[str, Any] = read_json(f"anatomy/{FILE}")
    validate_passive(table)
    return table


def validate_passive(table: Mapping[str, Any]) -> None:
    """Raise ``TableError`` unless every rotation that moves by itself has one row, complete, positive and with sources."""
    check_sources(FILE, table, sources())
    dofs = {dof.name: dof for row in joints_table().values() for dof in row.dofs}
    seen: set[str] = set()
    for row in table["rows"]:
        name = known_name(FILE, "degree of freedom", row["dof"], dofs)
        if dofs[name].driver is not None:
            raise TableError(f"{FILE}: {name} follows {dofs[name].driver}, so it has no passive row of its own")
        if name in seen:
            raise TableError(f"{FILE}: {name} stands there twice")
        seen.add(name)
        for part, key in (("stiffness", "newton_metre_per_rad"), ("friction", "newton_metre_second_per_rad")):
            if part not in row:
                raise TableError(f"{FILE}: {name} has no {part!r}")
            if number(FILE, f"{part} of {name}", row[part], key) <= 0.0:
                raise TableError(f"{FILE}: the {part} of {name} must be positive")
        capsule = row["capsule"]
        low, high = dofs[name].limits
        width = np.deg2rad(number(FILE, f"capsule of {name}", capsule, "begins_deg_before_limit"))
        torque = capsule["newton_metre_at_limits"]
        if not 0.0 < width < 0.5 * (high - low) or min(torque) <= 0.0 or len(torque) != 2 or capsule["relaxation_ms"] < 0.0:
            raise TableError(f"{FILE}: the capsule of {name} needs a positive begin before the middle, and two positive torques")
    missing = [name for name, dof in dofs.items() if dof.driver is None and name not in seen]
    if missing:
        raise TableError(f"{FILE}: {missing[0]} moves by itself but has no row")


def passive() -> Passive:
    """The passive structures of the sound reading."""
    table = _table()
    rows = {row["dof"]: row for row in table["rows"]}
    names = [dof.name for joint in joints_table().values() for dof in joint.dofs]
    ligament = table["collateral_ligaments"]

    def column(part: str, key: str, nothing: Any, unit: float = 1.0) -> Array:
        values: Array = frozen(unit * np.array([rows[name][part][key] if name in rows else nothing for name in names], dtype=np.float64))
        return values

    return Passive(
        stiffness=column("stiffness", "newton_metre_per_rad", 0.0),
        friction=column("friction", "newton_metre_second_per_rad", 0.0),
        capsule=Capsule(
            width=column("capsule", "begins_deg_before_limit", 0.0, np.pi / 180.0),
            torque=column("capsule", "newton_metre_at_limits", [0.0, 0.0]),
            time=column("capsule", "relaxation_ms", 0.0, 1e-3),
            hard_stop=float(np.deg2rad(table["hard_stop"]["deg_past_limit"])),
        ),
        collateral={"range_fraction_at_90": ligament["range_fraction"], "stiffness_factor_at_90": float(ligament["stiffness_factor"])},
    )


def printed_friction() -> float:
    """mu of equation (2'), one figure for all joints, read as a viscous coefficient in N m s/rad."""
    return float(_table()["printed_friction"]["newton_metre_second_per_rad"])
