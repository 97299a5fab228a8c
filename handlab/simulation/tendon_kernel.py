"""Compiled: balls that stand for bone, and a tendon's centre line, lifted out of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handlab.physics.compiled import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@compiled
def lifted(line: Array, up: Array, centre: Array, reach: Array, first: Index, last: Index, rounds: int) -> None:
    """Rows ``first`` to ``last`` (b,) of ``line`` (n, 3) are lifted out of balls ``centre`` (b, 3), ``reach`` (b,), in place.

    Straight out of the ball, and the more ``up`` (n, 3) the less that leads down: two walls of a groove would only push to and fro, and
    the roof of a tunnel must not be climbed. After every round but the last what rows were moved by is spread to their neighbours, so
    that a lift has no corners. The two ends stay.
    """
    count = line.shape[0]
    before, moved = line.copy(), np.zeros_like(line)
    for turn in range(rounds):
        for b in range(centre.shape[0]):
            for n in range(max(first[b], 1), min(last[b], count - 2) + 1):
                x, y, z = line[n, 0] - centre[b, 0], line[n, 1] - centre[b, 1], line[n, 2] - centre[b, 2]
                square = x * x + y * y + z * z
                if square >= reach[b] * reach[b]:
                    continue
                scale = 1.0 / max(np.sqrt(square), 1e-6)
                p, q, r = scale * x, scale * y, scale * z
                share = 1.0 + p * up[n, 0] + q * up[n, 1] + r * up[n, 2]
                p, q, r = p + share * up[n, 0], q + share * up[n, 1], r + share * up[n, 2]
                scale = 1.0 / np.sqrt(p * p + q * q + r * r)
                along = scale * (p * x + q * y + r * z)
                way = scale * (np.sqrt(along * along + reach[b] * reach[b] - square) - along)
                line[n, 0] += way * p
                line[n, 1] += way * q
                line[n, 2] += way * r
        if turn == rounds - 1:
            break
        moved[:] = line - before
        for n in range(1, count - 1):
            for k in range(3):
                line[n, k] = before[n, k] + 0.5 * moved[n, k] + 0.25 * (moved[n - 1, k] + moved[n + 1, k])


@compiled
def inscribed(touch: Array, normal: Array, radius: Array) -> None:
    """Radius (n,) of the largest ball that touches a surface from inside at ``touch`` (n, 3), ``normal`` (n, 3), and holds no such point.

    It is the least (p - q)^2 / (2 n . (q - p)) over all others p of a point q, or what ``radius`` says at first; in place.
    """
    for q in range(touch.shape[0]):
        for p in range(touch.shape[0]):
            x, y, z = touch[q, 0] - touch[p, 0], touch[q, 1] - touch[p, 1], touch[q, 2] - touch[p, 2]
            deep = 2.0 * (x * normal[q, 0] + y * normal[q, 1] + z * normal[q, 2])
            square = x * x + y * y + z * z
            if deep > 2e-6 and square < radius[q] * deep:
                radius[q] = square / deep
