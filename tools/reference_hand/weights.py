"""Blend weights of the even skin, derived for this hand: smooth (biharmonic) between rings of skin that a bone surely carries.

For every rigid body the skin beside the middle of its bone is pinned to 1 and the middles of the others to 0; between
them each weight minimises the squared Laplacian on the skin (Jacobson et al. 2011 use the same energy in a volume).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import splu

from .skeleton import Skeleton

INFLUENCES = 4
# What part of a bone's length (0 proximal joint, 1 distal joint or tip) carries its skin rigidly, on the dorsal side, at the
# sides (where the webs are) and on the palmar side (where flesh needs room to fold)
PINNED = {
    "metacarpal": ((0.05, 0.84), (0.05, 0.70), (0.05, 0.64)),
    "proximal": ((0.28, 0.78), (0.64, 0.70), (0.56, 0.66)),
    "middle": ((0.28, 0.72), (0.36, 0.64), (0.44, 0.58)),
    "distal": ((0.30, 9.0), (0.36, 9.0), (0.42, 9.0)),
}
TUBE = {1: 0.013, 2: 0.0098, 3: 0.0098, 4: 0.0096, 5: 0.0086}  # a proximal phalanx carries no skin farther from it: that is web
PINNED_THUMB = (0.34, 0.72)
WRIST_BLEND = (-0.020, 0.020)  # forearm proximal of this, carpus distal of it (metres along x)
THENAR_REACH = 0.020  # skin this near to metacarpal 1 moves with it


def blend_weights(points: np.ndarray, faces: np.ndarray, normals: np.ndarray, skeleton: Skeleton, bodies: list[str]) -> np.ndarray:
    """Weights (N, body), rows sum to 1, at most four per point."""
    pinned = _pins(points, normals, skeleton, bodies)
    stiffness, mass = cotangent_laplacian(points, faces)
    energy = (stiffness.T @ diags(1.0 / mass) @ stiffness).tocsc()
    fixed = np.flatnonzero(pinned >= 0)
    free = np.flatnonzero(pinned < 0)
    values = np.zeros((len(points), len(bodies)))
    values[fixed, pinned[fixed]] = 1.0
    solver = splu(energy[free][:, free])
    values[free] = solver.solve(-(energy[free][:, fixed] @ values[fixed]))
    values = np.clip(values, 0.0, 1.0)
    smallest = np.sort(values, axis=1)[:, -INFLUENCES]
    values[values < smallest[:, None]] = 0.0
    values[values < 0.01] = 0.0
    return values / values.sum(axis=1, keepdims=True)


def _pins(points: np.ndarray, normals: np.ndarray, skeleton: Skeleton, bodies: list[str]) -> np.ndarray:
    """Body index that a skin point is pinned to, -1 where it is free."""
    centre = skeleton.centres
    foot = {k: _end(skeleton.bones[f"metacarpal_{k}"][0], centre[f"mcp{k}"]) for k in range(2, 6)}
    foot[1] = centre["cmc1"]
    segments: list[tuple[str, np.ndarray, np.ndarray, str, int]] = []
    for k in range(1, 6):
        segments.append((f"metacarpal_{k}", foot[k], centre[f"mcp{k}"], "metacarpal", k))
        names = ("mcp", "pip", "dip", "tip") if k > 1 else ("mcp", "ip", "tip")
        kinds = ("proximal", "middle", "distal") if k > 1 else ("proximal", "distal")
        for kind, near, far in zip(kinds, names, names[1:], strict=False):
            segments.append((f"{kind}_phalanx_{k}", centre[f"{near}{k}"], centre[f"{far}{k}"], kind, k))
    distance = np.stack([_to_segment(points, near, far) for _, near, far, _, _ in segments])
    nearest = distance.argmin(axis=0)
    pinned = np.full(len(points), -1)
    for row, (name, near, far, kind, k) in enumerate(segments):
        axis = (far - near) / np.linalg.norm(far - near)
        along = (points - near) @ axis / np.linalg.norm(far - near)
        mine = nearest == row
        if kind == "metacarpal":
            low, high = PINNED_THUMB if k == 1 else _range(PINNED[kind], normals, skeleton.flexion[k], axis)
            ring = mine & (along > low) & (along < high) & (distance[row] < (THENAR_REACH if k == 1 else 1.0))
            if k in (2, 3, 4, 5):
                ring &= points[:, 0] > WRIST_BLEND[1]
        else:
            low, high = _range(PINNED[kind], normals, skeleton.flexion[k], axis)
            ring = mine & (along > low) & (along < high)
            if kind == "proximal":
                ring &= distance[row] < TUBE[k]
        body = name if name in bodies else "carpus"
        pinned[ring] = bodies.index(body)
    pinned[(pinned < 0) & (points[:, 0] < WRIST_BLEND[0])] = bodies.index("forearm")
    return pinned


def _range(pinned: tuple, normals: np.ndarray, flexion: np.ndarray, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pinned part of the bone for every skin point, between the values for dorsal, side and palmar."""
    palmar = normals @ np.cross(flexion, axis)
    share = np.stack([np.maximum(0, -palmar), 1 - np.abs(palmar), np.maximum(0, palmar)])
    low, high = np.array(pinned).T
    return low @ share, high @ share


def cotangent_laplacian(points: np.ndarray, faces: np.ndarray) -> tuple[coo_matrix, np.ndarray]:
    """Cotangent stiffness matrix and barycentric vertex areas (Pinkall and Polthier 1993)."""
    rows, columns, values = [], [], []
    area = np.zeros(len(points))
    for i in range(3):
        a, b, c = faces[:, i], faces[:, (i + 1) % 3], faces[:, (i + 2) % 3]
        u, v = points[b] - points[a], points[c] - points[a]
        double = np.linalg.norm(np.cross(u, v), axis=1)
        cot = 0.5 * np.einsum("ij,ij->i", u, v) / double
        rows += [b, c, b, c]
        columns += [c, b, b, c]
        values += [-cot, -cot, cot, cot]
        np.add.at(area, a, double / 6)
    n = len(points)
    return coo_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(n, n)).tocsc(), area


def _to_segment(points: np.ndarray, near: np.ndarray, far: np.ndarray) -> np.ndarray:
    along = np.clip((points - near) @ (far - near) / ((far - near) @ (far - near)), 0, 1)
    return np.linalg.norm(points - near - along[:, None] * (far - near), axis=1)


def _end(points: np.ndarray, head: np.ndarray) -> np.ndarray:
    axis = (head - points.mean(axis=0)) / np.linalg.norm(head - points.mean(axis=0))
    along = points @ axis
    return points[along < along.min() + 0.003].mean(axis=0)
