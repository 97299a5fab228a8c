"""Rigid bodies: what mass of this hand moves with which bone.

The inside of the skin is filled with a grid of points; each belongs to the body of the nearest bone. Density as in
``facts/segments.json`` (1100 kg/m3 for bone and soft tissue together, an assumption).
"""

from __future__ import annotations

import numpy as np
import pyvista as pv
from scipy.spatial import cKDTree

from .skeleton import polydata

DENSITY = 1100.0
STEP = 0.0015
PARENTS = {
    "forearm": (None, None),
    "carpus": ("forearm", "wrist"),
    "metacarpal_1": ("carpus", "cmc1"),
    "proximal_phalanx_1": ("metacarpal_1", "mcp1"),
    "distal_phalanx_1": ("proximal_phalanx_1", "ip1"),
}
for _k in range(2, 6):
    if _k > 3:
        PARENTS[f"metacarpal_{_k}"] = ("carpus", f"cmc{_k}")
    PARENTS[f"proximal_phalanx_{_k}"] = (f"metacarpal_{_k}" if _k > 3 else "carpus", f"mcp{_k}")
    PARENTS[f"middle_phalanx_{_k}"] = (f"proximal_phalanx_{_k}", f"pip{_k}")
    PARENTS[f"distal_phalanx_{_k}"] = (f"middle_phalanx_{_k}", f"dip{_k}")
CARPUS = ("scaphoid", "lunate", "triquetrum", "pisiform", "trapezium", "trapezoid", "capitate", "hamate", "metacarpal_2", "metacarpal_3")


def body_of(bone: str) -> str:
    """The rigid body that a bone belongs to."""
    return "forearm" if bone in ("radius", "ulna") else "carpus" if bone in CARPUS else bone


def mass_properties(skin: tuple[np.ndarray, np.ndarray], bones: dict[str, tuple[np.ndarray, np.ndarray]]) -> dict[str, dict]:
    """Mass, centre and inertia about the centre of every body, bind posture."""
    points, faces = skin
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.ceil((high - low) / STEP).astype(int)
    grid = pv.ImageData(dimensions=size + 1, spacing=(STEP,) * 3, origin=low + STEP / 2)
    inside = (
        grid.select_interior_points(polydata(points, faces))
        if hasattr(grid, "select_interior_points")
        else grid.select_enclosed_points(polydata(points, faces))
    )
    mask = np.asarray(inside.point_data[inside.point_data.keys()[-1]]).astype(bool)
    cells = np.asarray(grid.points)[mask]
    vertices = np.vstack([p for p, _ in bones.values()])
    owner = np.concatenate([np.full(len(p), list(PARENTS).index(body_of(name))) for name, (p, _) in bones.items()])
    body = owner[cKDTree(vertices).query(cells)[1]]
    polyhedron = abs(float(polydata(points, faces).volume))
    cell = polyhedron / len(cells) * DENSITY  # the grid is scaled to the exact volume
    result = {}
    for number, (name, (parent, joint)) in enumerate(PARENTS.items()):
        mine = cells[body == number]
        centre = mine.mean(axis=0)
        r = mine - centre
        square = np.einsum("ij,ik->jk", r, r)
        inertia = cell * (np.eye(3) * np.trace(square) - square) + np.eye(3) * cell * len(mine) * STEP**2 / 6
        result[name] = {"parent": parent, "joint": joint, "mass_kg": cell * len(mine), "centre_m": centre, "inertia_kg_m2": inertia}
    return result
