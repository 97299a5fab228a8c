"""The tables in ``assets/anatomy`` as typed records: muscles with both readings of Table 1, joints with limits and couplings.

Millimetres, degrees and percent end here: what these functions return is SI. Every table is validated when it is read;
a broken one raises ``TableError`` that names the file, the row and what is wrong with it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

from handlab.anatomy.data import read_json
from handlab.anatomy.meshes import Array, frozen
from handlab.anatomy.pseudo_muscles import LeverArm, Muscle
from handlab.anatomy.table_rules import NOT_PRINTED, check_sources, known_name, validate_joints, validate_muscles
from handlab.anatomy.terms import BONES, SIGNS, find

FIBRE_REST = ("flat", "relaxed", "half-closed")


@dataclass(frozen=True)
class DofRow:
    """One degree of freedom as the tables know it: everything but axis and anchor. Radians.

    ``printed_limits`` are the paper's (equal to ``limits`` where it gives none of its own). A follower has a ``driver``:
    angle = ``ratio`` * driver + ``offset``; its ``fibre_rest`` follows from the driver's.
    """

    name: str
    joint: str
    positive: str
    negative: str
    limits: tuple[float, float]
    printed_limits: tuple[float, float]
    sources: tuple[str, ...]
    fibre_rest: float
    driver: str | None = None
    ratio: float = 0.0
    offset: float = 0.0
    remark: str | None = None


@dataclass(frozen=True)
class JointRow:
    """One joint as the tables know it; ``parent`` and ``child`` are rigid bodies (equal at the fixed CMC 2 and 3)."""

    name: str
    english: str
    latin: str
    parent: str
    child: str
    parent_bones: tuple[str, ...]
    child_bones: tuple[str, ...]
    dofs: tuple[DofRow, ...]


@cache
def sources() -> Mapping[str, Mapping[str, str]]:
    """Every source key that a table may use: what it is, and whether it was found, recalled, computed or chosen."""
    known: dict[str, dict[str, str]] = read_json("anatomy/sources.json")
    return MappingProxyType(known)


@cache
def _joint_table() -> dict[str, Any]:
    table: dict[str, Any] = read_json("anatomy/joints.json")
    validate_joints(table, sources())
    return table


@cache
def _muscle_table() -> dict[str, Any]:
    table: dict[str, Any] = read_json("anatomy/muscles.json")
    added = read_json("anatomy/thenar_rows.json")
    check_sources("thenar_rows.json", added, sources())
    table = {**table, "muscles": merge_added_rows(table["muscles"], added["rows"])}
    validate_muscles(table, sources(), dof_names())
    return table


def merge_added_rows(muscle_rows: list[dict[str, Any]], added: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows of ``muscles.json`` with those of ``thenar_rows.json``, which are printed nowhere and thus equal in both readings."""
    extra: dict[str, list[dict[str, Any]]] = {row["id"]: [] for row in muscle_rows}
    for row in added:
        muscle = known_name("thenar_rows.json", "muscle", row["muscle"], extra)
        arm = {key: value for key, value in row.items() if key != "muscle"}
        extra[muscle].append({"confidence": "low", **arm, "printed_mm": row["used_mm"], "printed_as": None, "printed_basis": NOT_PRINTED})
    return [{**row, "lever_arms": row["lever_arms"] + extra[row["id"]]} for row in muscle_rows]


def dof_names() -> tuple[str, ...]:
    """Names of the 31 degrees of freedom, in the order of every array."""
    return tuple(dof["name"] for joint in _joint_table()["joints"] for dof in joint["dofs"])


def muscles() -> dict[str, Muscle]:
    """The 42 pseudo muscles of Table 1 by name; metres, tension in percent.

    >>> muscles()["flexor_digitorum_profundus_index"].rest_length
    0.066
    """
    return {row["id"]: _muscle(row) for row in _muscle_table()["muscles"]}


def _muscle(row: Mapping[str, Any]) -> Muscle:
    rest, nerve = row["rest_length"], row["innervation"]
    remarks = [*row.get("remarks", ())]
    remarks += [f"rest length: {rest['remark']}"] if "remark" in rest else []
    remarks += [f"tension: {row['tension']['remark']}"] if "remark" in row["tension"] else []
    remarks += [f"nerve: {nerve['variant']}"] if "variant" in nerve else []
    return Muscle(
        name=row["id"],
        abbreviation=row["abbreviation"],
        latin=row["latin"],
        group=row["group"],
        region=row["region"],
        rest_length=_metres(rest["used_mm"]),
        rest_length_printed=_metres(rest["printed_mm"]),
        rest_length_basis=rest["printed_basis"],
        rest_length_source=", ".join(rest["sources"]),
        tension_percent=float(row["tension"]["percent"]),
        tension_source=", ".join(row["tension"]["sources"]),
        nerve=nerve["nerve"],
        branch=nerve["branch"],
        roots=nerve["roots"],
        paralysed_in=tuple(nerve["paralysed_in"]),
        partially_paralysed_in=tuple(nerve.get("partially_paralysed_in", ())),
        action=row["action"],
        origin=row["origin"],
        insertion=row["insertion"],
        lever_arms=tuple(_lever_arm(arm) for arm in row["lever_arms"]),
        remarks=tuple(remarks),
        also_called=tuple(row["also_called"]),
    )


def _metres(millimetres: float) -> float:
    """Through the decimal number, so that 66 mm is 0.066 m to the last bit."""
    return float(f"{millimetres!r}e-3")


def _lever_arm(arm: Mapping[str, Any]) -> LeverArm:
    return LeverArm(
        dof=arm["dof"],
        used=_metres(arm["used_mm"]),
        printed=_metres(arm["printed_mm"]),
        printed_as=arm.get("printed_as"),
        printed_basis=arm["printed_basis"],
        status=arm["status"],
        reason=arm.get("reason"),
        confidence=arm["confidence"],
        sources=tuple(arm["sources"]),
        remark=arm.get("remark"),
        assumption=bool(arm.get("assumption", False)),
    )


def aliases() -> dict[str, str]:
    """Other names of the muscles (abbreviations, "lumbrical I") -> full name. ``find`` disregards their case."""
    return {
        alias: row["id"] for row in _muscle_table()["muscles"] for alias in (row["abbreviation"], *row["also_called"]) if alias != row["id"]
    }


def not_printed() -> list[tuple[str, str]]:
    """(muscle, what) for every figure of the reading ``printed`` that Table 1 does not have, so that the used one serves."""
    found = []
    for muscle in muscles().values():
        found += [(muscle.name, "rest length")] if muscle.rest_length_basis == NOT_PRINTED else []
        found += [(muscle.name, arm.dof) for arm in muscle.lever_arms if arm.printed_basis == NOT_PRINTED]
    return found


def joints_table() -> dict[str, JointRow]:
    """The 20 joints by name, in the order of every array, with their 31 degrees of freedom."""
    table = _joint_table()
    couplings = {coupling["dof"]: coupling for coupling in table["couplings"]}
    rows = {dof["name"]: dof for joint in table["joints"] for dof in joint["dofs"]}

    def rest_deg(name: str) -> float:
        if name not in couplings:
            return float(rows[name]["fibre_rest"]["deg"])
        coupling = couplings[name]
        return float(coupling["ratio"] * rest_deg(coupling["driver"]) + coupling["offset_deg"])

    def dof(joint: str, row: Mapping[str, Any]) -> DofRow:
        name, coupling, limits = row["name"], couplings.get(row["name"]), row["limits"]
        positive, negative = SIGNS[name.partition(".")[2]]
        printed = row.get("printed_limits", limits)
        found = {*limits["sources"], *(coupling["sources"] if coupling else ())}
        return DofRow(
            name=name,
            joint=joint,
            positive=positive,
            negative=negative,
            limits=(math.radians(limits["deg"][0]), math.radians(limits["deg"][1])),
            printed_limits=(math.radians(printed["deg"][0]), math.radians(printed["deg"][1])),
            sources=tuple(key for key in sources() if key in found),
            fibre_rest=math.radians(rest_deg(name)),
            driver=coupling["driver"] if coupling else None,
            ratio=float(coupling["ratio"]) if coupling else 0.0,
            offset=math.radians(coupling["offset_deg"]) if coupling else 0.0,
            remark=limits.get("remark"),
        )

    return {
        joint["name"]: JointRow(
            name=joint["name"],
            english=joint["english"],
            latin=joint["latin"],
            parent=BONES[joint["parent_bones"][0]].body,
            child=BONES[joint["child_bones"][0]].body,
            parent_bones=tuple(joint["parent_bones"]),
            child_bones=tuple(joint["child_bones"]),
            dofs=tuple(dof(joint["name"], row) for row in joint["dofs"]),
        )
        for joint in table["joints"]
    }


def newton_per_percent() -> float:
    """Newtons per percent of tension fraction: an assumption, settable on every hand."""
    return float(_muscle_table()["meta"]["force_scale"]["newton_per_percent"])


def fibre_rest(posture: str) -> Array:
    """Angles (dof,) in radians of a posture in which fibres may have their rest length; followers follow.

    ``flat``: the straight hand, as in the paper; ``relaxed``: a cascade that rises from index to little finger (the default);
    ``half-closed``: the same with fingers and wrist of a half-closed hand. Any other name raises ``UnknownName``.
    """
    dofs = {dof.name: dof for joint in joints_table().values() for dof in joint.dofs}
    posture = find(posture, FIBRE_REST, kind="posture of rest length")
    own = {name: 0.0 if posture == "flat" else dof.fibre_rest for name, dof in dofs.items()}
    if posture == "half-closed":
        own |= {row["dof"]: math.radians(row["deg"]) for row in _joint_table()["half_closed"]}

    def angle(dof: DofRow) -> float:
        return own[dof.name] if dof.driver is None else dof.ratio * angle(dofs[dof.driver]) + dof.offset

    return frozen([angle(dof) for dof in dofs.values()])
