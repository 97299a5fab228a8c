"""What a table in ``assets/anatomy`` must be: complete, finite, single, and with a source for every number."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from handlab.anatomy.terms import BONES, SIGNS, nearest

PRINTED = "printed"
ANALOGOUS = "analogous"
ELSEWHERE = "printed at another joint"
NOT_PRINTED = "not printed, used value"
BASES = (PRINTED, ANALOGOUS, ELSEWHERE, NOT_PRINTED)
STATUS_WORDS = ("as_printed", "corrected", "reconstructed_row", "inferred_analogous", "added", "printed_only")
CONFIDENCE_WORDS = ("high", "medium", "low")


class TableError(ValueError):
    """A table that cannot be used, and where it is broken."""


def numbers_without_source(table: Any, known: Mapping[str, Any]) -> list[str]:
    """Places of all numbers in ``table`` whose own record (the nearest enclosing object) lacks ``sources`` that ``known`` lists."""
    return [place for place, record in _numbers(table, "", {}) if not _sourced(record, known)]


def _numbers(node: Any, place: str, record: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Place and nearest enclosing object of every number below ``node``."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield from _numbers(value, f"{place}.{key}" if place else str(key), node)
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from _numbers(value, f"{place}[{index}]", record)
    elif isinstance(node, (int, float)) and not isinstance(node, bool):
        yield place, record


def _sourced(record: Mapping[str, Any], known: Mapping[str, Any]) -> bool:
    sources = record.get("sources")
    return isinstance(sources, list) and bool(sources) and all(source in known for source in sources)


def check_sources(file: str, table: Any, known: Mapping[str, Any]) -> None:
    """Raise ``TableError`` if a number has no source that ``known`` lists."""
    bad = numbers_without_source(table, known)
    if bad:
        raise TableError(f"{file}: {bad[0]} has no source, or one that sources.json does not list ({len(bad)} such numbers)")


def _value(file: str, where: str, record: Mapping[str, Any], key: str) -> Any:
    if key not in record:
        raise TableError(f"{file}: {where} has no {key!r}")
    return record[key]


def number(file: str, where: str, record: Mapping[str, Any], key: str) -> float:
    """A finite number of a record, or ``TableError``."""
    value = _value(file, where, record, key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise TableError(f"{file}: {key} of {where} is {value!r}; it must be a finite number")
    return float(value)


def _word(file: str, where: str, record: Mapping[str, Any], key: str, allowed: tuple[str, ...]) -> str:
    value = _value(file, where, record, key)
    if value not in allowed:
        raise TableError(f"{file}: {key} of {where} is {value!r}; it must be one of {', '.join(allowed)}")
    return str(value)


def known_name(file: str, what: str, name: str, known: Collection[str]) -> str:
    """``name``, if the table may use it; else ``TableError`` with the nearest three."""
    if name not in known:  # a table gives the full name: no alias, no other case
        raise TableError(f"{file}: unknown {what} {name!r}; nearest are {', '.join(nearest(str(name), known))}")
    return name


def _unique(file: str, what: str, names: list[str]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise TableError(f"{file}: {what} {twice[0]!r} stands there twice")


def validate_muscles(table: Mapping[str, Any], sources: Mapping[str, Any], dofs: tuple[str, ...]) -> None:
    """Raise ``TableError`` unless every row of the muscle table is complete, finite, sourced and single, and every change has a reason."""
    file = "muscles.json"
    check_sources(file, table, sources)
    rows = table["muscles"]
    _unique(file, "muscle", [row["id"] for row in rows])
    _unique(file, "abbreviation", [row["abbreviation"].casefold() for row in rows])
    for row in rows:
        name = row["id"]
        for key in ("latin", "group", "region", "origin", "insertion", "action", "rest_length", "tension", "innervation", "lever_arms"):
            _value(file, name, row, key)
        rest = row["rest_length"]
        for record, key in ((rest, "used_mm"), (rest, "printed_mm"), (row["tension"], "percent")):
            if number(file, name, record, key) <= 0.0:
                raise TableError(f"{file}: {key} of {name} is {record[key]}; it must be positive")
        _word(file, f"the rest length of {name}", rest, "printed_basis", (PRINTED, NOT_PRINTED))
        if rest["printed_basis"] == NOT_PRINTED and rest["used_mm"] != rest["printed_mm"]:
            raise TableError(f"{file}: the rest length of {name} is not printed, so both readings must have the same figure")
        _unique(file, f"lever arm of {name} at", [arm["dof"] for arm in row["lever_arms"]])
        for arm in row["lever_arms"]:
            _check_arm(file, name, arm, dofs)


def _check_arm(file: str, muscle: str, arm: Mapping[str, Any], dofs: tuple[str, ...]) -> None:
    where = f"the lever arm of {muscle} at {arm['dof']}"
    known_name(f"{file}, {muscle}", "degree of freedom", arm["dof"], dofs)
    used = number(file, where, arm, "used_mm")
    printed = number(file, where, arm, "printed_mm")
    _word(file, where, arm, "status", STATUS_WORDS)
    _word(file, where, arm, "confidence", CONFIDENCE_WORDS)
    basis = _word(file, where, arm, "printed_basis", BASES)
    if used != printed and not arm.get("reason"):
        raise TableError(f"{file}: {where} is used as {used:g} mm but printed as {printed:g} mm, without a 'reason'")
    if (basis == PRINTED) != (arm.get("printed_as") is not None):
        raise TableError(f"{file}: {where} must have 'printed_as' exactly if its basis is {PRINTED!r}")
    if basis == ELSEWHERE and printed != 0.0:
        raise TableError(f"{file}: {where} is printed at another joint, so its printed figure here must be 0")
    if basis == NOT_PRINTED and used != printed:
        raise TableError(f"{file}: {where} is not printed, so both readings must have the same figure")


def validate_joints(table: Mapping[str, Any], sources: Mapping[str, Any]) -> None:
    """Raise ``TableError`` unless joints, limits, couplings and relaxed posture of the joint table fit together."""
    file = "joints.json"
    check_sources(file, table, sources)
    _unique(file, "joint", [joint["name"] for joint in table["joints"]])
    rows = {dof["name"]: dof for joint in table["joints"] for dof in joint["dofs"]}
    _unique(file, "degree of freedom", [dof["name"] for joint in table["joints"] for dof in joint["dofs"]])
    _unique(file, "coupling of", [coupling["dof"] for coupling in table["couplings"]])
    for joint in table["joints"]:
        for bone in (*joint["parent_bones"], *joint["child_bones"]):
            known_name(f"{file}, {joint['name']}", "bone", bone, BONES)
        for name in (dof["name"] for dof in joint["dofs"]):
            if name.partition(".")[0] != joint["name"] or name.partition(".")[2] not in SIGNS:
                raise TableError(f"{file}: {name!r} of {joint['name']} must read {joint['name']}.KIND with KIND one of {', '.join(SIGNS)}")
    drivers = {}
    for coupling in table["couplings"]:
        for key in ("dof", "driver"):
            if coupling[key] not in rows:
                raise TableError(f"{file}: a coupling names {coupling[key]!r}, which no joint has")
        number(file, f"the coupling of {coupling['dof']}", coupling, "ratio")
        number(file, f"the coupling of {coupling['dof']}", coupling, "offset_deg")
        drivers[coupling["dof"]] = coupling["driver"]
    for name in drivers:
        seen, leader = {name}, drivers[name]
        while leader in drivers:
            if leader in seen:
                raise TableError(f"{file}: the coupling of {name} runs in a circle through {leader}")
            seen.add(leader)
            leader = drivers[leader]
    for name, row in rows.items():
        low, high = _range(file, name, row["limits"])
        if "printed_limits" in row:
            _range(file, name, row["printed_limits"])
        if name in drivers:
            if "fibre_rest" in row:
                raise TableError(f"{file}: {name} follows {drivers[name]}, so it can have no 'fibre_rest' of its own")
            continue
        rest = number(file, f"fibre_rest of {name}", _value(file, name, row, "fibre_rest"), "deg")
        if not low <= rest <= high:
            raise TableError(f"{file}: the relaxed posture of {name}, {rest:g} degrees, lies outside its limits {low:g} to {high:g}")


def _range(file: str, name: str, record: Mapping[str, Any]) -> tuple[float, float]:
    values = record.get("deg")
    if not isinstance(values, list) or len(values) != 2 or not all(math.isfinite(value) for value in values) or values[0] >= values[1]:
        raise TableError(f"{file}: the limits of {name} are {values!r}; they must be two numbers, the lower one first")
    return float(values[0]), float(values[1])
