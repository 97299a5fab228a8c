"""Triangle meshes and the read-only arrays that they are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@overload
def frozen(values: Any) -> Array: ...


@overload
def frozen(values: Any, dtype: Any) -> Any: ...


def frozen(values: Any, dtype: Any = np.float64) -> Any:
    """A read-only C-ordered copy of ``values``."""
    array = np.array(values, dtype=dtype, order="C")
    array.setflags(write=False)
    return array


@dataclass(frozen=True)
class Mesh:
    """A closed triangle mesh: ``points`` (N, 3) metres, ``faces`` (M, 3) counter-clockwise from outside."""

    points: Array
    faces: Index

    @property
    def volume(self) -> float:
        """Enclosed volume in cubic metres (divergence theorem, exact for the polyhedron)."""
        a, b, c = (self.points[self.faces[:, i]] for i in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


@dataclass(frozen=True)
class Skin(Mesh):
    """The even skin that physics uses, with blend weights: ``weights`` (N, body), rows add to 1."""

    weights: Array


@dataclass(frozen=True)
class FineSkin(Mesh):
    """The detailed skin for the eye, bound once to the even skin.

    ``texture`` (M, 3, 2): texture coordinates of every triangle corner, in [0, 1], without overlaps.
    ``triangle`` (N,), ``barycentric`` (N, 3), ``height`` (N,): where each point sits on the even skin,
    point = sum_i barycentric_i (p_i + height n_i), p and n the corners and vertex normals of that triangle.
    """

    texture: Array
    triangle: Index
    barycentric: Array
    height: Array
