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
    """How deep (3,) m the skin sinks below the straight line from one knuckle's top to the next, index to middle first; 0: it does not."""
    station, height, place = outline(hand, fine_points, angle)
    top = [near[height[near].argmax()] for near in (np.flatnonzero(np.abs(station - x) < BESIDE) for x in place)]
    found = []
    for one, other in pairwise(top):
        low, high = sorted((one, other))
        between = slice(low, high + 1)
        chord = np.interp(station[between], station[[low, high]], height[[low, high]])
        found.append(float((chord - height[between]).max(initial=0.0)))
    return np.array(found)
