"""What the skin does at a bent joint: a piece of the hand and its volume, lines of ink on the skin, a section through both.

All three are bound to the skin in the bind posture and go with it, whatever moves it. Lengths in metres.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, Index, frozen
from handlab.anatomy.terms import find
from handlab.simulation.skin import blend
from handlab.simulation.soft_anchors import SKINS
from handlab.simulation.soft_frame import begin
from handlab.simulation.soft_skin import Network, soft_skin
from handlab.simulation.state import State
from handlab.simulation.surface_graph import edges_of
from handlab.studies.places import joint_place

WAYS = ("linear", *SKINS)
REACH = 0.012  # on either side of a joint
GIRTH = 0.020  # a finger's skin lies nearer to its joint than this; at the wrist more is asked for
LINE = 0.0125  # on either side: 25 mm of ink


class Piece(NamedTuple):
    """A part of the skin between two girdles: its triangles ``faces`` (M, 3), and ``rims``, rings of points that close it."""

    faces: Index
    rims: tuple[Index, ...]


class Ink(NamedTuple):
    """A line drawn on the skin: points on the edges ``first`` to ``second`` (k,), at ``share`` (k,) of the way."""

    first: Index
    second: Index
    share: Array


def worn(hand: Hand, state: State, way: str = SKINS[1], *, network: Network | None = None, contraction: ArrayLike | None = None) -> Array:
    """Points (N, 3) of the even skin at rest in the posture of ``state``.

    ``way``: ``"linear"`` (averaged matrices), ``"blend"`` (dual quaternions), ``"springs"``, ``"springs and muscles"``. ``network``: one
    of ``soft_skin`` with other constants; ``contraction`` (muscle,) makes muscles bulge.
    """
    name = find(way, WAYS, kind="way to wear the skin")
    if name in ("linear", "blend"):
        return blend(hand, state.angle, method="linear" if name == "linear" else "dual")
    net = soft_skin(hand) if network is None else network
    return begin(hand, net, state.angle, contraction, skin=next(skin for skin in SKINS if skin == name)).points


def signed_volume(points: Array, faces: Index) -> float:
    """Volume of a closed mesh, sum of the tetrahedra from the origin to every triangle: a . (b x c) / 6."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def piece(hand: Hand, joint: str, reach: float = REACH, *, girth: float = GIRTH) -> Piece:
    """The skin around a joint, as far as ``reach`` along the digit and ``girth`` from the joint; one connected part."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    place, faces = joint_place(hand, joint), hand.skin.faces
    middle = hand.skin.points[faces].mean(axis=1) - place.centre
    mine = np.flatnonzero((np.abs(middle @ place.distal) < reach) & (np.linalg.norm(middle, axis=1) < girth))
    if not len(mine):
        raise ValueError(f"no triangle of the skin lies within {1000 * reach:g} mm of {joint!r}; ask for a longer reach, such as 0.012")
    sides = np.concatenate([faces[mine][:, [0, 1]], faces[mine][:, [1, 2]]])
    count = len(hand.skin.points)
    part = connected_components(coo_matrix((np.ones(len(sides)), sides.T), shape=(count, count)), directed=False)[1]
    nearest = mine[np.linalg.norm(middle[mine], axis=1).argmin()]
    kept = faces[mine][part[faces[mine][:, 0]] == part[faces[nearest, 0]]]
    return Piece(frozen(kept, np.int64), tuple(frozen(rim, np.int64) for rim in rims(kept)))


def rims(faces: Index) -> list[list[int]]:
    """Rings of points along the open edges of a mesh, in the order in which a lid has to go round."""
    sides = {(int(a), int(b)) for t in faces for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))}
    after = {b: a for a, b in sorted(sides) if (b, a) not in sides}
    found = []
    while after:
        first = next(iter(after))
        ring, here = [first], after.pop(first)
        while here != first:
            ring.append(here)
            here = after.pop(here)
        found.append(ring)
    return found


def piece_volume(points: ArrayLike, part: Piece) -> float:
    """Volume in m^3 of a piece, closed by a lid from every rim to its middle; ``points`` (N, 3) of the whole skin."""
    skin = np.asarray(points, dtype=np.float64)
    total = signed_volume(skin, part.faces)
    for rim in part.rims:
        ring = skin[rim]
        # lids share their middle with nobody, so it need not be a point of the skin
        total += float(np.einsum("ij,ij->", ring, np.cross(np.roll(ring, -1, axis=0), ring.mean(axis=0)[None, :])) / 6.0)
    return total


def ink(hand: Hand, joint: str, side: str = "dorsal", reach: float = LINE, *, girth: float = GIRTH) -> Ink:
    """A line on the ``"dorsal"`` or ``"palmar"`` skin along the digit, ``reach`` to either side of a joint, proximal end first."""
    name = find(side, ("dorsal", "palmar"), kind="side")
    place, edges = joint_place(hand, joint), edges_of(hand.skin)
    offset = hand.skin.points - place.centre
    aside = offset @ place.flexion
    crossing = edges[(aside[edges[:, 0]] > 0.0) != (aside[edges[:, 1]] > 0.0)]
    share = aside[crossing[:, 0]] / (aside[crossing[:, 0]] - aside[crossing[:, 1]])
    at = (1.0 - share)[:, None] * offset[crossing[:, 0]] + share[:, None] * offset[crossing[:, 1]]
    along, palmar = at @ place.distal, at @ place.palmar
    right = (palmar > 0.0) if name == "palmar" else (palmar < 0.0)
    mine = np.flatnonzero(right & (np.abs(along) < reach) & (np.linalg.norm(at, axis=1) < girth))
    mine = mine[np.argsort(along[mine])]
    return Ink(frozen(crossing[mine, 0], np.int64), frozen(crossing[mine, 1], np.int64), frozen(share[mine]))


def ink_points(points: ArrayLike, line: Ink) -> Array:
    """Where the ink (k, 3) is when the skin has ``points`` (N, 3)."""
    skin = np.asarray(points, dtype=np.float64)
    result: Array = (1.0 - line.share)[:, None] * skin[line.first] + line.share[:, None] * skin[line.second]
    return result


def ink_length(points: ArrayLike, line: Ink) -> float:
    """Length of the ink in metres."""
    return float(np.linalg.norm(np.diff(ink_points(points, line), axis=0), axis=1).sum())


def section(points: Array, faces: Index, origin: Array, normal: Array) -> list[Array]:
    """Closed lines (k, 3) in which a plane cuts a closed mesh."""
    height = (points - origin) @ normal
    above = height > 0.0
    cut = faces[above[faces].any(axis=1) & ~above[faces].all(axis=1)]
    after: dict[tuple[int, int], tuple[int, int]] = {}
    for t in cut.tolist():
        into = out = (0, 0)
        for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0])):
            if above[a] != above[b]:
                edge = (min(a, b), max(a, b))
                into, out = (edge, out) if above[b] else (into, edge)
        after[into] = out
    found = []
    while after:
        first = next(iter(after))
        ring, here = [first], after.pop(first)
        while here != first:
            ring.append(here)
            here = after.pop(here)
        pair = np.array(ring)
        low, high = height[pair[:, 0]], height[pair[:, 1]]
        share = (low / (low - high))[:, None]
        found.append((1.0 - share) * points[pair[:, 0]] + share * points[pair[:, 1]])
    return found
