"""How much bone and tendon stand out on the back of the hand: knuckles over the valleys between them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand
from handlab.simulation.kinematics import posed_axes, relative_transforms

KNUCKLES = ("mcp2", "mcp3", "mcp4", "mcp5")
BESIDE = 0.006  # m: the top of a knuckle is sought this far to either side of its joint
STATIONS = 140


def outline(hand: Hand, fine_points: ArrayLike, angle: ArrayLike) -> tuple[Array, Array, Array]:
    """What is seen of the knuckles against the light, looking halfway between along the fingers' backs and onto the back of the hand.

    Across the hand (s,) m, from the little finger's side; height (s,) m of the highest skin there; the four joints' places (4,) m, index
    first. ``fine_points`` (Nf, 3) of the fine skin at ``angle`` (dof,) rad.
    """
    anchor = posed_axes(hand, angle)[1]
    joints = np.array([anchor[hand.dof_names.index(f"{name}.flexion_extension")] for name in KNUCKLES])
    carpus = relative_transforms(hand, angle)[hand.body_names.index("carpus")][:3, :3]
    up = carpus @ np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    across = joints[0] - joints[3]
    across = across - up * (across @ up)
    across /= np.linalg.norm(across)
    skin = np.asarray(fine_points, dtype=np.float64) - joints[3]
    x, z = skin @ across, skin @ up
    place = (joints - joints[3]) @ across
    station = np.linspace(place.min() - 2 * BESIDE, place.max() + 2 * BESIDE, STATIONS)
    height = np.full(STATIONS, -np.inf)
    faces = hand.skin_fine.faces
    for a, b in ((0, 1), (1, 2), (2, 0)):
        i, j = faces[:, a], faces[:, b]
        low, high = np.searchsorted(station, np.minimum(x[i], x[j])), np.searchsorted(station, np.maximum(x[i], x[j]))
        for k in range(int((high - low).max())):
            own = np.flatnonzero(low + k < high)
            at = low[own] + k
            share = (station[at] - x[i[own]]) / (x[j[own]] - x[i[own]])
            np.maximum.at(height, at, z[i[own]] + share * (z[j[own]] - z[i[own]]))
    return station, height, place


def valleys(hand: Hand, fine_points: ArrayLike, angle: ArrayLike) -> Array:
    """How deep (3,) m the skin sinks below a straight edge laid across two neighbouring knuckles, index and middle first; 0: it does not.

    Measured square to the edge, which touches where it touches: the row of knuckles falls towards the little finger, and what is highest
    near its joint is the slope up to the next.
    """
    station, height, place = outline(hand, fine_points, angle)
    found = []
    for one, other in pairwise(place):
        near = np.flatnonzero((station > other - BESIDE) & (station < one + BESIDE))
        left, right = touching(station[near], height[near], (one + other) / 2.0)
        across = near[left : right + 1]
        chord = np.interp(station[across], station[near[[left, right]]], height[near[[left, right]]])
        slope = (chord[-1] - chord[0]) / (station[across[-1]] - station[across[0]])
        found.append(float((chord - height[across]).max() / np.hypot(1.0, slope)))
    return np.array(found)


def touching(station: Array, height: Array, middle: float) -> tuple[int, int]:
    """Rows on either side of ``middle`` where a straight edge laid on an outline from above touches it."""
    hull: list[int] = []
    for k in range(len(station)):
        while len(hull) > 1 and _above(station, height, hull[-2], hull[-1], k):
            hull.pop()
        hull.append(k)
    right = next(n for n, k in enumerate(hull) if station[k] > middle)
    return hull[right - 1], hull[right]


def _above(station: Array, height: Array, one: int, between: int, other: int) -> bool:
    """Whether the line from one row to another passes above what lies between them."""
    run, rise = station[other] - station[one], height[other] - height[one]
    return bool((height[between] - height[one]) * run <= (station[between] - station[one]) * rise)
