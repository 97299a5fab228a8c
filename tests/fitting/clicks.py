"""Exact clicks on a hand for the tests: an orthographic picture, nothing of ``handlab.fitting`` but names."""

import numpy as np

from handlab.fitting.landmarks import NAMES

PX_PER_MM = 8.0


def clicks(hand, view="palmar", *, names=NAMES, turn=0.4, direction=(0.0, 1.0, 0.0), size=1.0, mirror=False):
    """name -> (x, y) px of the hand's feature points, seen along ``direction`` (for the back: from the other side)."""
    towards = np.array(direction) * (1.0 if view == "palmar" else -1.0)
    towards /= np.linalg.norm(towards)
    up = np.array([1.0, 0, 0]) - towards[0] * towards
    up /= np.linalg.norm(up)
    across = np.cross(up, towards)
    points = hand.skin.points[[hand.feature_points[name][view] for name in names]] * size * 1e3
    flat = np.stack([points @ across, points @ up], axis=1)
    flat = flat @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    px = flat * [-PX_PER_MM if mirror else PX_PER_MM, -PX_PER_MM] + [2000.0, 2200.0]
    return dict(zip(names, map(tuple, px.tolist()), strict=True))
