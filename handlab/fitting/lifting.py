"""From the picture's plane to three dimensions (section 5.2): every click gets the height of its own feature point, scaled.

    t_i = origin + turned back(k p_i) + h_i' v,    h_i' = h_i * scale

``k`` millimetres per pixel from the calibration; v the direction towards the camera; h_i the height of feature point i over the plane.
Rays of a real camera meet in one point: with ``distance`` every click is first moved to where it would be seen from far away.
"""

from __future__ import annotations

from typing import NamedTuple

from handlab.anatomy.records import Array
from handlab.fitting.alignment import Aligned


class Lifted(NamedTuple):
    """``target`` (N, 3) m in the frame of the reference hand; ``height`` (N,) m over the plane, before scaling."""

    target: Array
    height: Array


def lift(aligned: Aligned, picture: Array) -> Lifted:
    """Targets of the feature points from their places ``picture`` (N, 2) mm, y upwards. Sizes in the plane are those of the picture."""
    fit, frame = aligned.fit, aligned.frame
    height = frame.height(aligned.source)
    middle = frame.flat(aligned.source).mean(axis=0)
    flat = middle + 1e-3 * (picture - picture.mean(axis=0)) @ fit.matrix
    # heights keep their mean, so that a hand of another size lies at the same place
    return Lifted(frame.lifted(flat, height.mean() + fit.scale * (height - height.mean())), height)


def from_far(aligned: Aligned, picture: Array, centre: Array, distance_mm: float) -> Array:
    """Places (N, 2) mm as a camera far away would see them, from those that a camera at ``distance_mm`` over the table sees.

    ``centre`` (2,) mm: the foot of the camera's axis, on most pictures their middle. What lies h above the ruler's plane looks larger by
    distance / (distance - h); the lowest point of the skin lies on the table, as the ruler does.
    """
    skin = aligned.frame.height(aligned.hand.skin.points)
    above = 1e3 * aligned.fit.scale * (aligned.frame.height(aligned.source) - skin.min())
    result: Array = centre + (picture - centre) * (1.0 - above / distance_mm)[:, None]
    return result


def lowest(aligned: Aligned) -> float:
    """Height (m) of the table in the lifted hand: where its lowest skin would lie, scaled as ``lift`` scales heights."""
    middle = float(aligned.frame.height(aligned.source).mean())
    return middle + aligned.fit.scale * (float(aligned.frame.height(aligned.hand.skin.points).min()) - middle)


def seen_by(flat: Array, above: Array, centre: Array, distance_mm: float) -> Array:
    """The reverse of ``from_far``: where a camera at ``distance_mm`` sees places ``flat`` (N, 2) mm, ``above`` (N,) mm over the table."""
    result: Array = centre + (flat - centre) * (distance_mm / (distance_mm - above))[:, None]
    return result
