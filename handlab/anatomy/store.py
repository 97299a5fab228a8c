"""A hand as a folder of open files: ``hand.glb`` (meshes, any 3D viewer opens it), ``hand.json`` (joints, bodies, marks) and, for a
hand with colours of its own, ``skin.png``.

Points, texture and weights are stored with 32 bits: a hand that was loaded comes back to the last bit, one that was computed
comes back within a nanometre or so, and then to the last bit. Tables of anatomy (muscles, limits) are not part of a hand's files.
"""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np

from handlab.anatomy.glb import INDICES, write_glb
from handlab.anatomy.load import exact_weights, load_hand
from handlab.anatomy.picture import PICTURE, write_picture
from handlab.anatomy.records import Array, FineSkin, Hand, Index, Skin

FILES = ("hand.glb", "hand.json")
INFLUENCES = 4
NOTICE = "see LICENSES.md of handlab"
UNITS = "metres, degrees, kilograms; joints in the zero posture, bodies in the bind posture"
CLOSE = 1e-6  # what 32 bits may change: far less than a micrometre, or a millionth of a weight
DIGITS = range(6, 18)


def save_hand(hand: Hand, folder: str | os.PathLike[str]) -> Path:
    """Write ``hand`` into ``folder`` (made if it is not there), whole or not at all; ``load_hand(folder)`` gives it back.

    An older hand in that folder is replaced. Raises ``FileExistsError`` if the folder holds anything else, ``ValueError`` for a
    hand that its files could not give back (muscles or joints unlike the tables, painted muscles), ``OSError`` if it cannot be written.
    """
    if hand.grids is not None:
        raise ValueError("painted muscles are not in a hand's files: save_grids(folder, hand.grids), and hand.with_(grids=None).save(...)")
    place = Path(folder)
    with _whole_folder(place) as part:
        write_meshes(
            part / "hand.glb",
            hand.skin,
            hand.skin_fine,
            hand.bones,
            {name: bone.body for name, bone in hand.bones.items()},
            hand.body_names,
        )
        (part / "hand.json").write_text(json.dumps(_table(hand), indent=1) + "\n", encoding="utf-8")
        if hand.picture is not None:
            write_picture(part / PICTURE, hand.picture)
        _check(hand, load_hand(part))
    return place


def write_meshes(
    path: Path, skin: Skin, fine: FineSkin, bones: Mapping[str, Any], carriers: Mapping[str, str], bodies: tuple[str, ...]
) -> None:
    """Skins with weights, texture and binding, and bones, as one glTF binary file. ``carriers``: body of each bone."""
    weights = exact_weights(skin.weights)
    order = np.argsort(-weights, axis=1, kind="stable")[:, :INFLUENCES]
    meshes: dict[str, dict[str, Any]] = {
        "skin": {INDICES: skin.faces, "POSITION": skin.points, "JOINTS_0": order, "WEIGHTS_0": np.take_along_axis(weights, order, axis=1)}
    }
    indices, point, texture = seams(fine.faces, fine.texture)
    meshes["skin_fine"] = {
        INDICES: indices,
        "POSITION": fine.points[point],
        "TEXCOORD_0": texture,
        "_POINT": point,
        "_TRIANGLE": fine.triangle[point],
        "_BARYCENTRIC": fine.barycentric[point],
        "_HEIGHT": fine.height[point],
    }
    for name, bone in bones.items():
        meshes[name] = {INDICES: bone.faces, "POSITION": bone.points}
    write_glb(path, meshes, bodies, carriers, NOTICE)


def seams(faces: Index, texture: Array) -> tuple[Index, Index, Array]:
    """A mesh whose points have one texture coordinate each, as files want it: points along seams stand there more than once.

    ``faces`` (M, 3), ``texture`` (M, 3, 2) per corner -> indices (M, 3), the point (K,) and the texture (K, 2) of each stored point.
    """
    corner = np.concatenate([faces.reshape(-1, 1).astype(np.float64), texture.reshape(-1, 2)], axis=1)
    rows, indices = np.unique(corner, axis=0, return_inverse=True)
    return indices.reshape(-1, 3), rows[:, 0].astype(np.int64), rows[:, 1:]


def _table(hand: Hand) -> dict[str, Any]:
    joints: dict[str, Any] = {}
    bind = dict(zip(hand.dof_names, hand.bind.tolist(), strict=True))
    for name, joint in hand.joints.items():
        dofs = {
            dof.name: {"axis": dof.axis.tolist(), "anchor_m": dof.anchor.tolist(), "bind_deg": degrees(bind[dof.name])}
            for dof in joint.dofs
        }
        joints[name] = {"centre_m": joint.centre.tolist(), "dofs": dofs}
    bodies = {
        name: {
            "parent": body.parent,
            "joint": body.joint,
            "mass_kg": body.mass,
            "centre_m": body.centre.tolist(),
            "inertia_kg_m2": body.inertia.tolist(),
        }
        for name, body in hand.bodies.items()
    }
    return {
        "name": hand.name,
        "side": hand.side,
        "reading": hand.reading,
        "units": UNITS,
        "joints": joints,
        "bodies": bodies,
        "feature_points": {name: dict(views) for name, views in hand.feature_points.items()},
        "settings": {
            "newton_per_percent": hand.newton_per_percent,
            "friction": hand.friction.tolist(),
            "fibre_rest_rad": hand.fibre_rest.tolist(),
            "stiffness": hand.stiffness.tolist(),
            "collateral": dict(hand.collateral),
            "relaxed_rad": hand.relaxed.tolist(),
            **({} if hand.growth is None else {"growth": {"length": hand.growth.length, "lever_arm": hand.growth.lever_arm.tolist()}}),
            "capsule": None if hand.capsule is None else {name: np.asarray(v).tolist() for name, v in asdict(hand.capsule).items()},
        },
        "sources": dict(hand.sources),
    }


def degrees(angle: float) -> float:
    """The shortest number of degrees that reads back as ``angle`` radians to the last bit; the nearest one if none does."""
    exact = math.degrees(angle)
    candidates = [float(f"{exact:.{digits}g}") for digits in DIGITS]
    near = [exact, math.nextafter(exact, math.inf), math.nextafter(exact, -math.inf)]
    return next((value for value in candidates + near if math.radians(value) == angle), exact)


def _check(hand: Hand, again: Hand) -> None:
    """Refuse to keep files that do not give the hand back."""
    lost = [name for name in ("name", "side", "reading", "newton_per_percent") if getattr(hand, name) != getattr(again, name)]
    lost += [name for name in ("muscles", "feature_points", "collateral") if dict(getattr(hand, name)) != dict(getattr(again, name))]
    for name in ("bind", "fibre_rest", "relaxed", "stiffness", "friction", "limits", "coupling", "coupling_offset"):
        if not np.allclose(getattr(hand, name), getattr(again, name), rtol=0.0, atol=CLOSE):
            lost.append(name)
    if (hand.picture is None) != (again.picture is None) or not np.array_equal(hand.picture, again.picture):  # type: ignore[arg-type]
        lost.append("picture")
    one, other = ({} if capsule is None else asdict(capsule) for capsule in (hand.capsule, again.capsule))
    if one.keys() != other.keys() or not all(_alike(np.asarray(value), np.asarray(other[name])) for name, value in one.items()):
        lost.append("capsule")
    for name in ("skin", "skin_fine"):
        for key, values in asdict(getattr(hand, name)).items():
            if not _alike(values, getattr(getattr(again, name), key)):
                lost.append(f"{name}.{key}")
    lost += [f"bone {name}" for name, bone in hand.bones.items() if not _alike(bone.points, again.bones[name].points)]
    if lost:
        raise ValueError(
            f"a hand's files cannot hold what was changed in this one: {', '.join(lost)}; "
            "save the hand without these changes, and make them again after loading"
        )


def _alike(one: Array, other: Array) -> bool:
    return one.shape == other.shape and bool(np.allclose(one, other, rtol=0.0, atol=CLOSE))


@contextmanager
def _whole_folder(place: Path) -> Iterator[Path]:
    """A temporary folder that takes the place of ``place`` when the block ends well, and vanishes when it fails."""
    if place.exists() and not place.is_dir():
        raise FileExistsError(f"cannot save a hand as {place}: it is a file; a hand is a folder")
    if place.is_dir() and (others := {path.name for path in place.iterdir()} - {*FILES, PICTURE}):
        raise FileExistsError(f"cannot save a hand in {place}: it holds other files ({', '.join(sorted(others)[:3])}); choose a new folder")
    if not place.absolute().parent.is_dir():
        raise FileNotFoundError(f"cannot save a hand in {place}: the folder {place.absolute().parent} does not exist; create it first")
    mark = uuid4().hex[:8]
    part, old = (place.absolute().with_name(f".{place.name}-{kind}-{mark}") for kind in ("new", "old"))
    try:
        try:
            part.mkdir()
        except OSError as error:
            raise type(error)(f"cannot save a hand in {place}: {error.strerror}; choose a folder that you may write to") from error
        yield part
        if place.exists():
            place.rename(old)
        try:
            part.rename(place)
        except OSError:
            if old.exists():
                old.rename(place)
            raise
    finally:
        shutil.rmtree(part, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)
