"""``load_hand``: geometry from ``hand.glb`` and ``hand.json``, facts from the tables, joined into one ``Hand``."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from handlab.anatomy import data, tables
from handlab.anatomy.capsule import Capsule
from handlab.anatomy.glb import read_glb
from handlab.anatomy.growth import Growth, grown_muscles
from handlab.anatomy.mirror import mirrored
from handlab.anatomy.passive import passive, printed_friction
from handlab.anatomy.picture import PICTURE, read_picture
from handlab.anatomy.records import Array, Body, Bone, DegreeOfFreedom, FineSkin, Hand, Joint, Named, Skin, frozen
from handlab.anatomy.terms import BONES, UnknownName

READINGS = ("sound", "printed")
SIDES = ("right", "left")
PEOPLE = ("man", "child")  # hands that ship with the package, made from photographs
WEIGHT_STEPS = 2**20  # blend weights are multiples of 1/2^20: 32 bits hold them, and rows add to exactly 1


def load_hand(path: str | os.PathLike[str] | None = None, *, side: str | None = None, reading: str | None = None) -> Hand:
    """Load the reference hand, ``"man"`` or ``"child"``, or a hand saved in the folder ``path``.

    ``side``: "right" or "left"; where it is not the side of the stored hand, that is mirrored. ``reading``: "sound", or "printed":
    lever arms, rest lengths and MCP limits as printed in the paper, the straight hand as posture of rest length, hard
    limits without capsule, no stiffness, no collateral ligaments. Not given, both are as saved; the reference hand is right and sound.
    Raises ``ValueError`` for an unknown side or reading or a broken file, ``FileNotFoundError`` if ``path`` holds no hand.

    >>> hand = load_hand()
    >>> len(hand.bones), len(hand.muscles), len(hand.dof_names)
    (29, 42, 31)
    """
    if side not in (None, *SIDES):
        raise ValueError(f"side is {side!r}; it must be 'right' or 'left'")
    if reading not in (None, *READINGS):
        raise ValueError(f"reading is {reading!r}; it must be one of {', '.join(READINGS)}")
    folder = data.folder() / "reference_hand" if path is None else data.folder() / "people" / path if path in PEOPLE else Path(path)
    if not (folder / "hand.json").is_file() or not (folder / "hand.glb").is_file():
        raise FileNotFoundError(f"{folder} holds no hand: a hand is a folder with hand.json and hand.glb")
    try:
        geometry = json.loads((folder / "hand.json").read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{folder / 'hand.json'} is not readable: {error}; build or save the hand again") from error
    meshes = read_glb(folder / "hand.glb")
    try:
        hand = _assemble(geometry, meshes, reading or geometry.get("reading", READINGS[0]))
    except (AttributeError, KeyError, TypeError, IndexError) as error:
        raise ValueError(f"{folder} is not a complete hand: {error!r} is missing or misplaced; build or save it again") from error
    except ValueError as error:
        raise ValueError(f"{folder} is not a complete hand: {error}; build or save it again") from error
    if (folder / PICTURE).is_file():
        hand = hand.with_(picture=read_picture(folder / PICTURE))
    return hand if side in (None, hand.side) else mirrored(hand)


def _assemble(geometry: dict[str, Any], meshes: dict[str, dict[str, Any]], reading: str) -> Hand:
    if geometry["side"] not in SIDES or reading not in READINGS:
        raise ValueError(f"its side is {geometry['side']!r} and its reading {reading!r}")
    printed = reading == "printed"
    rows = tables.joints_table()
    joints = {}
    for name, row in rows.items():
        place = geometry["joints"][name]
        dofs = tuple(
            DegreeOfFreedom(
                name=dof.name,
                joint=name,
                positive=dof.positive,
                negative=dof.negative,
                axis=frozen(place["dofs"][dof.name]["axis"]),
                anchor=frozen(place["dofs"][dof.name]["anchor_m"]),
                limits=frozen(dof.printed_limits if printed else dof.limits),
                sources=dof.sources,
                driver=dof.driver,
                ratio=dof.ratio,
                offset=dof.offset,
            )
            for dof in row.dofs
        )
        joints[name] = Joint(name, row.english, row.parent, row.child, frozen(place["centre_m"]), dofs)
    flat = [dof for row in rows.values() for dof in row.dofs]
    bind = [np.radians(geometry["joints"][dof.joint]["dofs"][dof.name]["bind_deg"]) for dof in flat]
    found = passive()
    settings = geometry.get("settings", {})
    own = settings if reading == geometry.get("reading") else {}  # another reading has its own posture and stiffness
    growth = _growth(settings.get("growth"))
    muscles = tables.muscles()
    return Hand(
        name=geometry["name"],
        side=geometry["side"],
        reading=reading,
        skin=_skin(meshes["skin"], list(geometry["bodies"])),
        skin_fine=_fine_skin(meshes["skin_fine"]),
        bones=Named("bone", {name: _bone(name, meshes[name]) for name in BONES}),
        bodies=Named("body", {name: _body(name, row) for name, row in geometry["bodies"].items()}),
        joints=Named("joint", joints),
        muscles=Named("muscle", grown_muscles(muscles, growth, tables.dof_names()) if growth else muscles, tables.aliases()),
        feature_points=Named("feature point", geometry["feature_points"]),
        bind=frozen(bind),
        fibre_rest=frozen(own.get("fibre_rest_rad", tables.fibre_rest("flat" if printed else "relaxed"))),
        relaxed=frozen(own.get("relaxed_rad", tables.fibre_rest("flat" if printed else "relaxed"))),
        stiffness=frozen(own.get("stiffness", np.zeros(len(flat)) if printed else found.stiffness)),
        friction=frozen(own.get("friction", np.full(len(flat), printed_friction()) if printed else found.friction)),
        capsule=_capsule(own["capsule"]) if "capsule" in own else None if printed else found.capsule,
        collateral=dict(own.get("collateral", {} if printed else found.collateral)),
        newton_per_percent=float(settings.get("newton_per_percent", tables.newton_per_percent())),
        sources=geometry["sources"],
        growth=growth,
    )


def _growth(saved: dict[str, Any] | None) -> Growth | None:
    return None if saved is None else Growth(float(saved["length"]), frozen(saved["lever_arm"]))


def _capsule(saved: dict[str, Any] | None) -> Capsule | None:
    if saved is None:
        return None
    return Capsule(frozen(saved["width"]), frozen(saved["torque"]), frozen(saved["time"]), float(saved["hard_stop"]))


def _skin(arrays: dict[str, Any], bodies: list[str]) -> Skin:
    weights = np.zeros((len(arrays["POSITION"]), len(bodies)))
    np.add.at(weights, (np.arange(len(weights))[:, None], arrays["JOINTS_0"].astype(int)), arrays["WEIGHTS_0"].astype(float))
    return Skin(_points(arrays), frozen(arrays["indices"], np.int64), frozen(exact_weights(weights)))


def exact_weights(weights: Array) -> Array:
    """Blend weights (N, body) rounded to multiples of 1/2^20 so that every row adds to exactly 1."""
    steps = np.round(weights / weights.sum(axis=1, keepdims=True) * WEIGHT_STEPS)
    steps[np.arange(len(steps)), steps.argmax(axis=1)] += WEIGHT_STEPS - steps.sum(axis=1)
    result: Array = steps / WEIGHT_STEPS
    return result


def _fine_skin(arrays: dict[str, Any]) -> FineSkin:
    """Points stand once per texture chart in the file; ``_POINT`` says which of them are one point of the skin."""
    point = arrays["_POINT"].astype(np.int64)
    first = np.unique(point, return_index=True)[1]
    corners = arrays["indices"].astype(np.int64)
    return FineSkin(
        points=frozen(_points(arrays)[first]),
        faces=frozen(point[corners], np.int64),
        texture=frozen(arrays["TEXCOORD_0"][corners]),
        triangle=frozen(arrays["_TRIANGLE"][first], np.int64),
        barycentric=frozen(arrays["_BARYCENTRIC"][first]),
        height=frozen(arrays["_HEIGHT"][first]),
    )


def _bone(name: str, arrays: dict[str, Any]) -> Bone:
    term = BONES[name]
    return Bone(_points(arrays), frozen(arrays["indices"], np.int64), name, term.latin, term.english, term.body)


def _body(name: str, row: dict[str, Any]) -> Body:
    return Body(name, row["parent"], row["joint"], float(row["mass_kg"]), frozen(row["centre_m"]), frozen(row["inertia_kg_m2"]))


def _points(arrays: dict[str, Any]) -> Array:
    points: Array = frozen(arrays["POSITION"])
    return points


__all__ = ["READINGS", "UnknownName", "load_hand"]
