"""Masses and springs: the laws of a mass-spring skin, arrays in, arrays out (section 3.1, after Kähler, Haber, Seidel 2001).

Plain functions for reading and testing; the compiled substeps are in ``simulation.soft_skin_kernel``. Marks: *recalled* are laws
remembered of the sources, *derived* those worked out here. Lengths in metres, stiffness in N/m, mass in kg, time in s.
"""

from __future__ import annotations

from collections.abc import Callable
from math import ceil, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SAFETY = 0.7  # share of the stable step that is used: a stretched or turned spring may be up to twice as stiff as at rest


def spring_force(node: ArrayLike, other: ArrayLike, stiffness: ArrayLike, rest_length: ArrayLike) -> Array:
    """Force (..., 3) on ``node`` (..., 3) of a linear spring to ``other``: k (l - l0) towards it.

    >>> spring_force([0.0, 0.0, 0.0], [2.0, 0.0, 0.0], 3.0, 1.0).tolist()
    [3.0, 0.0, 0.0]
    """
    way = np.asarray(other, dtype=np.float64) - np.asarray(node, dtype=np.float64)
    length = np.linalg.norm(way, axis=-1)
    result: Array = (np.asarray(stiffness) * (1.0 - np.asarray(rest_length) / length))[..., None] * way
    return result


def biphasic(strain: ArrayLike, soft: float, stiff: float, critical: float) -> Array:
    """Tension of a spring that is soft up to ``critical`` strain and stiff beyond (recalled): k1 e, then k1 ec + k2 (e - ec).

    >>> biphasic([0.1, 0.3, 0.5], soft=1.0, stiff=8.0, critical=0.3).round(9).tolist()
    [0.1, 0.3, 1.9]
    """
    e = np.asarray(strain, dtype=np.float64)
    result: Array = soft * np.minimum(e, critical) + stiff * np.maximum(e - critical, 0.0)
    return result


def wrinkling(strain: ArrayLike, stiffness: float, slack: float) -> Array:
    """Tension of a thin sheet along a line (derived): k e when stretched, ``slack`` k e when pressed, because it wrinkles.

    Skin 1.5 mm thick buckles in waves shorter than an edge of the mesh; what the mesh feels of pressure is a small part.

    >>> wrinkling([0.1, -0.1], stiffness=10.0, slack=0.02).round(9).tolist()
    [1.0, -0.02]
    """
    e = np.asarray(strain, dtype=np.float64)
    result: Array = stiffness * np.where(e > 0.0, e, slack * e)
    return result


def mirrored_pair(node: ArrayLike, centre: ArrayLike, arm: ArrayLike, stiffness: ArrayLike, rest_length: ArrayLike) -> Array:
    """Force (..., 3) on ``node`` of a spring to its anchor ``centre - arm`` below and of its mirror image at ``centre + arm`` (recalled).

    The mirror stands for the outward pressure of tissue. Normal stiffness is 2 k. Across the arm it is 2 k (1 - l0 / |arm|): nothing
    if the springs are at rest; with l0 = 2/3 |arm| a third of the normal one, as in incompressible tissue, where G = E / 3 (derived).

    >>> force = mirrored_pair([0.0, 0.0, 0.001], [0.0, 0.0, 0.0], [0.0, 0.0, 0.005], 2.0, 0.005)
    >>> (1e6 * force).round(3).tolist()
    [0.0, 0.0, -4000.0]
    """
    middle, half = np.asarray(centre, dtype=np.float64), np.asarray(arm, dtype=np.float64)
    return spring_force(node, middle - half, stiffness, rest_length) + spring_force(node, middle + half, stiffness, rest_length)


def membrane_stiffness(young: float, thickness: float, area: ArrayLike, length: ArrayLike) -> Array:
    """Stiffness (e,) of the edges of a sheet: E t (sum of the areas of the two triangles) / length^2 (Van Gelder 1998).

    Exact for equilateral triangles, sqrt(3)/2 E t; Poisson's ratio of such a net is 1/3.
    """
    result: Array = young * thickness * np.asarray(area, dtype=np.float64) / np.asarray(length, dtype=np.float64) ** 2
    return result


def column_stiffness(young: ArrayLike, area: ArrayLike, depth: ArrayLike) -> Array:
    """Stiffness E A / d of columns of tissue with cross-section ``area`` and ``depth``."""
    result: Array = np.asarray(young, dtype=np.float64) * np.asarray(area, dtype=np.float64) / np.asarray(depth, dtype=np.float64)
    return result


def half_step(velocity: ArrayLike, acceleration: ArrayLike, dt: float) -> Array:
    """v_1/2 = v_0 + dt/2 a(x_0): the speed with which leapfrog starts (equations, section 13)."""
    result: Array = np.asarray(velocity, dtype=np.float64) + 0.5 * dt * np.asarray(acceleration, dtype=np.float64)
    return result


def leapfrog(
    position: ArrayLike, velocity: ArrayLike, acceleration: Callable[[Array], Array], dt: float, damping: float = 0.0
) -> tuple[Array, Array]:
    """One Verlet leapfrog step (section 3.1): x_n, v_n-1/2 -> x_n+1, v_n+1/2.

    v_n+1/2 = ((1 - g dt/2) v_n-1/2 + dt a(x_n)) / (1 + g dt/2), x_n+1 = x_n + dt v_n+1/2; ``damping`` g in 1/s.
    """
    x = np.asarray(position, dtype=np.float64)
    kept, gained = leapfrog_factors(dt, damping)
    v: Array = kept * np.asarray(velocity, dtype=np.float64) + gained * acceleration(x)
    return x + dt * v, v


def leapfrog_factors(dt: float, damping: float) -> tuple[float, float]:
    """What is kept of the speed, and what is gained per acceleration: (1 - g dt/2)/(1 + g dt/2) and dt/(1 + g dt/2)."""
    lost = 0.5 * damping * dt
    return (1.0 - lost) / (1.0 + lost), dt / (1.0 + lost)


def spring_tensor(way: ArrayLike, stiffness: ArrayLike, rest_length: ArrayLike) -> Array:
    """Stiffness tensors (..., 3, 3) of springs that are stretched to ``way`` (..., 3): k [n n' + (1 - l0/l) (1 - n n')]."""
    w = np.asarray(way, dtype=np.float64)
    length = np.linalg.norm(w, axis=-1)
    n = w / length[..., None]
    along = n[..., :, None] * n[..., None, :]
    across = (1.0 - np.asarray(rest_length) / length)[..., None, None]
    result: Array = np.asarray(stiffness, dtype=np.float64)[..., None, None] * (along + across * (np.eye(3) - along))
    return result


def stiffness_matrix(count: int, edges: Index, tensors: Array, grounded: Array | None = None) -> object:
    """K (3 count, 3 count), sparse: springs between ``edges`` (e, 2), ``tensors`` (e, 3, 3), and to anchors, ``grounded`` (count, 3, 3)."""
    from scipy.sparse import bsr_matrix, coo_matrix

    i, j = edges[:, 0], edges[:, 1]
    rows, columns = np.concatenate([i, j, i, j]), np.concatenate([i, j, j, i])
    blocks = np.concatenate([tensors, tensors, -tensors, -tensors])
    if grounded is not None:
        node = np.arange(count)
        rows, columns, blocks = np.concatenate([rows, node]), np.concatenate([columns, node]), np.concatenate([blocks, grounded])
    three = np.arange(3)
    row = (3 * rows[:, None, None] + three[None, :, None]).repeat(3, axis=2)
    column = (3 * columns[:, None, None] + three[None, None, :]).repeat(3, axis=1)
    shape = (3 * count, 3 * count)
    return bsr_matrix(coo_matrix((blocks.ravel(), (row.ravel(), column.ravel())), shape=shape), blocksize=(3, 3))


def largest_frequency(stiffness: object, mass: ArrayLike) -> float:
    """omega_max in rad/s: square root of the largest eigenvalue of M^-1 K; ``stiffness`` (3 n, 3 n) sparse, ``mass`` (n,) kg.

    Lanczos on M^-1/2 K M^-1/2, which has the same eigenvalues and is symmetric.
    """
    from scipy.sparse import diags
    from scipy.sparse.linalg import eigsh

    scale = diags(1.0 / np.sqrt(np.repeat(np.asarray(mass, dtype=np.float64), 3)))
    matrix = (scale @ stiffness @ scale).tocsr()
    if matrix.shape[0] < 12:
        return sqrt(float(np.linalg.eigvalsh(matrix.toarray())[-1]))
    start = np.cos(np.arange(matrix.shape[0]))  # the same every time
    return sqrt(float(eigsh(matrix, k=1, which="LA", v0=start, tol=1e-5, return_eigenvectors=False)[0]))


def stable_step(frequency: float) -> float:
    """Largest stable step 2 / omega_max of leapfrog, in s; damping does not change it.

    >>> round(stable_step((2.0 / 1e-4) ** 0.5), 6)
    0.014142
    """
    return 2.0 / frequency


def substeps(dt: float, frequency: float, *, safety: float = SAFETY) -> int:
    """How many equal steps make ``dt`` with none longer than ``safety`` times the stable one."""
    return max(1, ceil(dt / (safety * stable_step(frequency)) - 1e-9))
