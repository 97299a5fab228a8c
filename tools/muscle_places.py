"""Places on the bones of the reference hand, in the words of an anatomy book: a height along a bone, a side of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.physics.distance import closest
from handlab.simulation.geometric_kernel import first_hit
from handlab.simulation.kinematics import relative_transforms, transforms, tree


@dataclass(frozen=True)
class Frame:
    """A bone's ``base``, ``head`` and unit vectors: distal, palmar, radial."""

    base: Array
    head: Array
    distal: Array
    palmar: Array
    radial: Array


class Places:
    """Where things are on one hand in its bind posture."""

    def __init__(self, hand: Hand) -> None:
        self.hand = hand
        self._axes = transforms(tree(hand), hand.bind)[1]
        assert np.allclose(relative_transforms(hand, hand.bind), np.eye(4), atol=1e-9)

    def frame(self, bone: str) -> Frame:
        """Frame of a metacarpal or phalanx; its palmar side is where its own finger bends to."""
        points = self.hand.bones[bone].points
        centre = points.mean(axis=0)
        distal = np.linalg.svd(points - centre)[2][0]
        if distal[0] < 0:
            distal = -distal
        along = (points - centre) @ distal
        bend = self._axes[self.hand.dof_names.index(f"mcp{bone[-1]}.flexion_extension")]
        palmar = np.cross(bend, distal)
        palmar /= np.linalg.norm(palmar)
        low, high = (centre + value * distal for value in (along.min(), along.max()))
        # The shaft is bowed: base and head are the middles of the ends.
        ends = [points[np.abs(along - value) < 0.004].mean(axis=0) for value in (along.min(), along.max())]
        low, high = (
            end + ((value - (end - centre) @ distal) * distal) for end, value in zip(ends, (along.min(), along.max()), strict=True)
        )
        return Frame(low, high, distal, palmar, np.cross(distal, palmar))

    def on(self, bone: str, along: float, palmar: float, radial: float, lift_mm: float = 0.0) -> Array:
        """Place ``lift_mm`` above the surface of a long bone, ``along`` it (0 base, 1 head), on the side (palmar, radial)."""
        frame = self.frame(bone)
        axis = frame.base + along * (frame.head - frame.base)
        side = palmar * frame.palmar + radial * frame.radial
        return self._surface(bone, axis, side / np.linalg.norm(side), lift_mm)

    def under(self, bone: str, along: float, palmar: float, radial: float, depth_mm: float) -> Array:
        """Place ``depth_mm`` below the skin, seen from the axis of a long bone like ``on``; never in the bone."""
        frame = self.frame(bone)
        axis = frame.base + along * (frame.head - frame.base)
        side = palmar * frame.palmar + radial * frame.radial
        side /= np.linalg.norm(side)
        skin = np.ascontiguousarray(self.hand.skin.points[self.hand.skin.faces])
        out = first_hit(axis[None], side[None], skin)[0][0]
        lowest = self._surface(bone, axis, side, 0.5)
        place: Array = axis + max(out - 1e-3 * depth_mm, float((lowest - axis) @ side)) * side
        return place

    def carpal(self, bone: str, direction: tuple[float, float, float], lift_mm: float = 0.0) -> Array:
        """Place above a carpal bone, seen from its middle in ``direction`` (distal, palmar, radial)."""
        way = np.array(direction, dtype=np.float64)
        return self._surface(bone, self.hand.bones[bone].points.mean(axis=0), way / np.linalg.norm(way), lift_mm)

    def _surface(self, bone: str, start: Array, way: Array, lift_mm: float) -> Array:
        mesh = self.hand.bones[bone]
        far = start + 0.05 * way  # from outside, so that hollows of the bone do not count
        distance, _ = first_hit(far[None], -way[None], np.ascontiguousarray(mesh.points[mesh.faces]))
        if not np.isfinite(distance[0]):
            far_place: Array = closest(start[None], np.ascontiguousarray(mesh.points[mesh.faces]))[2][0]
            return far_place + 1e-3 * lift_mm * way
        result: Array = far + (-distance[0] + 1e-3 * lift_mm) * way
        return result
