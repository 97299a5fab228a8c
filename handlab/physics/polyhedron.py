"""Exact volume, centre of mass and inertia tensor of a closed triangle mesh of uniform density.

The integrals of 1, x and x x' over the inside become sums over the surface (divergence theorem): every triangle spans a
tetrahedron with one reference point, and signed tetrahedra add up to the polyhedron. No grid, no sampling, no error but rounding.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class MassProperties(NamedTuple):
    """``mass`` kg, ``centre`` (3,) m, ``inertia`` (3, 3) kg m^2 about the centre, ``volume`` m^3."""

    mass: float
    centre: Array
    inertia: Array
    volume: float


def mass_properties(points: ArrayLike, faces: ArrayLike, *, mass: float | None = None, density: float | None = None) -> MassProperties:
    """Mass properties of a closed mesh: ``points`` (N, 3) m, ``faces`` (M, 3) counter-clockwise from outside.

    Give either ``mass`` in kg or ``density`` in kg/m^3. Exact for the polyhedron. Raises ``ValueError`` for a mesh that is open,
    has faces turned both ways, or is inside out.

    >>> corners, sides = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> found = mass_properties(corners, sides, mass=1.0)
    >>> round(found.volume, 6), round(float(found.inertia[0, 0]), 6)
    (0.166667, 0.075)
    """
    if (mass is None) == (density is None):
        raise ValueError("give either mass in kg or density in kg/m^3, and not both")
    points, faces = np.asarray(points, dtype=np.float64), np.asarray(faces, dtype=np.int64)
    require_closed(faces)
    # about the middle of the mesh: far from the origin the sums would lose digits
    origin = points.mean(axis=0)
    a, b, c = np.moveaxis((points - origin)[faces], 1, 0)
    six_volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
    volume = float(six_volumes.sum() / 6.0)
    if not volume > 0.0:
        raise ValueError(f"the mesh encloses {volume:g} m^3; its faces must be counter-clockwise seen from outside: reverse them")
    corners = a + b + c  # the fourth corner of every tetrahedron is the origin
    centre = six_volumes @ corners / (24.0 * volume)
    # integral of x x' over a tetrahedron with corners 0, a, b, c: V / 20 (s s' + a a' + b b' + c c') with s = a + b + c
    second = sum(np.einsum("n,ni,nj->ij", six_volumes, e, e) for e in (corners, a, b, c)) / 120.0
    second = second - volume * np.outer(centre, centre)
    rho = mass / volume if mass is not None else float(density or 0.0)
    inertia = rho * (np.trace(second) * np.eye(3) - second)
    return MassProperties(rho * volume, origin + centre, inertia, volume)


def require_closed(faces: NDArray[np.int64]) -> None:
    """Raise ``ValueError`` unless every edge of ``faces`` (M, 3) is run through once in each direction."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    forward, count = np.unique(edges, axis=0, return_counts=True)
    if (count > 1).any():
        raise ValueError(f"{int((count > 1).sum())} edges of the mesh are run through twice the same way; turn all faces outward")
    backward = np.unique(edges[:, ::-1], axis=0)
    if len(forward) != len(backward) or (forward != backward).any():
        known = {tuple(edge) for edge in forward.tolist()}
        lone = sum((end, start) not in known for start, end in known)
        raise ValueError(f"the mesh is open: {lone} edges belong to one face only; close it before asking for its mass")


def refined(points: ArrayLike, faces: ArrayLike) -> tuple[Array, NDArray[np.int64]]:
    """Points and faces of the same polyhedron with every triangle cut into four at the middles of its edges."""
    points, faces = np.asarray(points, dtype=np.float64), np.asarray(faces, dtype=np.int64)
    edges = np.sort(np.stack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]], axis=1), axis=2)
    lone, where = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    ab, bc, ca = (len(points) + where.reshape(-1, 3)).T
    a, b, c = faces.T
    cut = [np.stack(corners, axis=1) for corners in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
    return np.concatenate([points, points[lone].mean(axis=1)]), np.concatenate(cut)
