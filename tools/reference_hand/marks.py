"""The 26 feature points of section 5.1 as indices of the even skin, for a palmar and for a dorsal picture."""

from __future__ import annotations

import numpy as np

from .skeleton import Skeleton

FINGER = {1: "thumb", 2: "index", 3: "middle", 4: "ring", 5: "little"}


def feature_points(
    points: np.ndarray, normals: np.ndarray, skeleton: Skeleton, pinned_web: dict[tuple[int, int], np.ndarray]
) -> dict[str, dict[str, int]]:
    """Names in the order of the paper's table; on the outline both views share one point."""
    centre = skeleton.centres
    marks: dict[str, dict[str, int]] = {}
    for k in range(1, 6):
        end = centre[f"dip{k}" if k > 1 else "ip1"]
        distal = _unit(centre[f"tip{k}"] - end)
        near = np.linalg.norm(points - centre[f"tip{k}"], axis=1) < 0.012
        tip = int(np.argmax(np.where(near, points @ distal, -np.inf)))
        marks[f"tip_{FINGER[k]}"] = {"palmar": tip, "dorsal": tip}
    for joint in ("dip", "ip", "pip", "mcp"):
        for k in range(1, 6):
            if f"{joint}{k}" not in centre or ((joint == "ip") != (k == 1) and joint != "mcp"):
                continue
            at = centre[f"{joint}{k}"]
            along = _unit(centre[f"tip{k}"] - at)
            palmar = _unit(np.cross(skeleton.flexion[k], along))
            marks[f"{joint}_{FINGER[k]}"] = {
                "palmar": _through(points, normals, at, palmar),
                "dorsal": _through(points, normals, at, -palmar),
            }
    for (k, m), web in pinned_web.items():
        index = int(np.argmin(np.linalg.norm(points - web, axis=1)))
        marks[f"web_{FINGER[k]}_{FINGER[m]}"] = {"palmar": index, "dorsal": index}
    ring = np.abs(points[:, 0]) < 0.004
    for name, sign in (("wrist_radial", 1.0), ("wrist_ulnar", -1.0)):
        index = int(np.argmax(np.where(ring, sign * points[:, 2], -np.inf)))
        marks[name] = {"palmar": index, "dorsal": index}
    ulna = skeleton.bones["ulna"][0]
    head = ulna[ulna[:, 0] > ulna[:, 0].max() - 0.008].mean(axis=0)
    dorsal, palmar = _unit(np.array([0, -1.0, -0.5])), _unit(np.array([0, 1.0, -0.5]))
    marks["head_of_ulna"] = {"palmar": _through(points, normals, head, palmar), "dorsal": _through(points, normals, head, dorsal)}
    return marks


def _through(points: np.ndarray, normals: np.ndarray, at: np.ndarray, direction: np.ndarray) -> int:
    """The skin point that a line from inside meets first."""
    r = points - at
    along = r @ direction
    aside = np.linalg.norm(r - along[:, None] * direction, axis=1)
    cost = np.where((along > 0) & (normals @ direction > 0.1), aside + 0.15 * along, np.inf)
    return int(np.argmin(cost))


def webs(points: np.ndarray, faces: np.ndarray, skeleton: Skeleton) -> dict[tuple[int, int], np.ndarray]:
    """Deepest point of the skin between neighbouring digits."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    edges = np.unique(np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    graph = coo_matrix((length, edges.T), shape=(len(points),) * 2)
    result = {}
    for k in range(1, 5):
        first, second = (_side(points, skeleton, k, k + 1), _side(points, skeleton, k + 1, k))
        _, before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
        path = [second]
        while path[-1] != first:
            path.append(before[path[-1]])
        line = points[path]
        axis = _unit(_unit(_tip(skeleton, k)) + _unit(_tip(skeleton, k + 1)))
        result[(k, k + 1)] = line[np.argmin(line @ axis)]
    return result


def _tip(skeleton: Skeleton, k: int) -> np.ndarray:
    return skeleton.centres[f"tip{k}"] - skeleton.centres[f"mcp{k}"]


def _side(points: np.ndarray, skeleton: Skeleton, k: int, other: int) -> int:
    """Skin point on the side of digit ``k`` that faces ``other``, beside its middle joint."""
    at = skeleton.centres[f"pip{k}" if k > 1 else "ip1"]
    across = skeleton.centres[f"pip{other}" if other > 1 else "ip1"] - at
    along = _unit(_tip(skeleton, k))
    across = _unit(across - along * (across @ along))
    return int(np.argmin(np.linalg.norm(points - (at + 0.008 * across), axis=1)))


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v)
