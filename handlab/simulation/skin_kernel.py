"""Compiled skinning: blend of rigid transforms, vertex normals, and the fine skin on the even one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Index = NDArray[np.uint32]


@compiled
def dual_quaternions(transform: Array, out: Array) -> None:
    """Unit dual quaternions (b, 8) of rigid transforms (b, 3, 4): rotation w x y z, then half of translation times rotation."""
    for b in range(transform.shape[0]):
        t = transform[b]
        # the largest of the four squares, so that the square root is never of a small number
        trace = t[0, 0] + t[1, 1] + t[2, 2]
        if trace > 0.0:
            s = 2.0 * np.sqrt(trace + 1.0)
            w, x, y, z = 0.25 * s, (t[2, 1] - t[1, 2]) / s, (t[0, 2] - t[2, 0]) / s, (t[1, 0] - t[0, 1]) / s
        elif t[0, 0] > t[1, 1] and t[0, 0] > t[2, 2]:
            s = 2.0 * np.sqrt(1.0 + t[0, 0] - t[1, 1] - t[2, 2])
            w, x, y, z = (t[2, 1] - t[1, 2]) / s, 0.25 * s, (t[0, 1] + t[1, 0]) / s, (t[0, 2] + t[2, 0]) / s
        elif t[1, 1] > t[2, 2]:
            s = 2.0 * np.sqrt(1.0 + t[1, 1] - t[0, 0] - t[2, 2])
            w, x, y, z = (t[0, 2] - t[2, 0]) / s, (t[0, 1] + t[1, 0]) / s, 0.25 * s, (t[1, 2] + t[2, 1]) / s
        else:
            s = 2.0 * np.sqrt(1.0 + t[2, 2] - t[0, 0] - t[1, 1])
            w, x, y, z = (t[1, 0] - t[0, 1]) / s, (t[0, 2] + t[2, 0]) / s, (t[1, 2] + t[2, 1]) / s, 0.25 * s
        p, q, r = 0.5 * t[0, 3], 0.5 * t[1, 3], 0.5 * t[2, 3]
        out[b, 0], out[b, 1], out[b, 2], out[b, 3] = w, x, y, z
        out[b, 4] = -p * x - q * y - r * z
        out[b, 5] = p * w + q * z - r * y
        out[b, 6] = q * w + r * x - p * z
        out[b, 7] = r * w + p * y - q * x


@compiled
def blend_dual(points: Array, index: Index, weight: Array, quaternion: Array, out: Array) -> None:
    """Blend unit dual quaternions (b, 8) by ``weight`` (n, 4) of bodies ``index`` (n, 4) and move ``points`` (n, 3).

    The first body of a row is the heaviest; others are taken from its side of the sphere of quaternions (shortest turn).
    """
    for n in range(points.shape[0]):
        first = index[n, 0]
        w0, x0, y0, z0 = quaternion[first, 0], quaternion[first, 1], quaternion[first, 2], quaternion[first, 3]
        g = weight[n, 0]
        w, x, y, z = g * w0, g * x0, g * y0, g * z0
        dw, dx, dy, dz = g * quaternion[first, 4], g * quaternion[first, 5], g * quaternion[first, 6], g * quaternion[first, 7]
        for k in range(1, index.shape[1]):
            g = weight[n, k]
            if g == 0.0:
                break
            b = index[n, k]
            if w0 * quaternion[b, 0] + x0 * quaternion[b, 1] + y0 * quaternion[b, 2] + z0 * quaternion[b, 3] < 0.0:
                g = -g
            w += g * quaternion[b, 0]
            x += g * quaternion[b, 1]
            y += g * quaternion[b, 2]
            z += g * quaternion[b, 3]
            dw += g * quaternion[b, 4]
            dx += g * quaternion[b, 5]
            dy += g * quaternion[b, 6]
            dz += g * quaternion[b, 7]
        scale = 1.0 / (w * w + x * x + y * y + z * z)
        p, q, r = points[n, 0], points[n, 1], points[n, 2]
        # rotation: p + 2 v x (v x p + w p), translation: 2 (w dv - dw v + v x dv), both over |quaternion|^2
        a, b_, c = y * r - z * q + w * p, z * p - x * r + w * q, x * q - y * p + w * r
        out[n, 0] = p + 2.0 * scale * (y * c - z * b_ + w * dx - dw * x + y * dz - z * dy)
        out[n, 1] = q + 2.0 * scale * (z * a - x * c + w * dy - dw * y + z * dx - x * dz)
        out[n, 2] = r + 2.0 * scale * (x * b_ - y * a + w * dz - dw * z + x * dy - y * dx)


@compiled
def blend_linear(points: Array, index: Index, weight: Array, transform: Array, out: Array) -> None:
    """Blend transforms (b, 3, 4) entry by entry and move ``points`` (n, 3)."""
    for n in range(points.shape[0]):
        p, q, r = points[n, 0], points[n, 1], points[n, 2]
        x, y, z = 0.0, 0.0, 0.0
        for k in range(index.shape[1]):
            g = weight[n, k]
            if g == 0.0:
                break
            t = transform[index[n, k]]
            x += g * (t[0, 0] * p + t[0, 1] * q + t[0, 2] * r + t[0, 3])
            y += g * (t[1, 0] * p + t[1, 1] * q + t[1, 2] * r + t[1, 3])
            z += g * (t[2, 0] * p + t[2, 1] * q + t[2, 2] * r + t[2, 3])
        out[n, 0], out[n, 1], out[n, 2] = x, y, z


@compiled
def vertex_normals(points: Array, faces: Index, out: Array) -> None:
    """Unit normals (n, 3), weighted by the area of the triangles around each point."""
    out[:, :] = 0.0
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
        bx, by, bz = points[k, 0] - points[i, 0], points[k, 1] - points[i, 1], points[k, 2] - points[i, 2]
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        for v in (i, j, k):
            out[v, 0] += nx
            out[v, 1] += ny
            out[v, 2] += nz
    for v in range(out.shape[0]):
        length = np.sqrt(out[v, 0] ** 2 + out[v, 1] ** 2 + out[v, 2] ** 2)
        if length > 0.0:
            out[v, 0] /= length
            out[v, 1] /= length
            out[v, 2] /= length


@compiled
def bound_points(points: Array, normals: Array, corners: Index, barycentric: Array, height: Array, out: Array) -> None:
    """Points (n, 3) on an even skin: sum_i barycentric_i (p_i + height n_i), ``corners`` (n, 3) its point indices."""
    for n in range(corners.shape[0]):
        h = height[n]
        x, y, z = 0.0, 0.0, 0.0
        for i in range(3):
            v, g = corners[n, i], barycentric[n, i]
            x += g * (points[v, 0] + h * normals[v, 0])
            y += g * (points[v, 1] + h * normals[v, 1])
            z += g * (points[v, 2] + h * normals[v, 2])
        out[n, 0], out[n, 1], out[n, 2] = x, y, z


@compiled
def sagitta(points: Array, normals: Array, corners: Index, barycentric: Array, out: Array) -> None:
    """How far (n,) a surface that is as curved as its normals say rises over its flat triangles: -1/2 sum_i b_i (p - p_i) . n_i.

    Exact to third order in the edges: (1 - s) s k l^2 / 2 on an edge l of curvature k, where Phong tessellation has twice that.
    """
    for n in range(corners.shape[0]):
        i, j, k = corners[n, 0], corners[n, 1], corners[n, 2]
        a, b, c = barycentric[n, 0], barycentric[n, 1], barycentric[n, 2]
        total = 0.0
        for x in range(3):
            p = a * points[i, x] + b * points[j, x] + c * points[k, x]
            total += a * (p - points[i, x]) * normals[i, x]
            total += b * (p - points[j, x]) * normals[j, x]
            total += c * (p - points[k, x]) * normals[k, x]
        out[n] = -0.5 * total
