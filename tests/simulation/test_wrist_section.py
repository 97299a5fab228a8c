"""The bent wrist keeps its girth: cross-sections of the blended skin, cut by VTK."""

import numpy as np
import pytest
import pyvista as pv

from handlab.simulation.skeleton import pose
from handlab.simulation.skin import blend

BEND_ENDS = 0.03  # metres from the wrist centre at which the plane has turned with the hand


def section(hand, degrees, along, method="dual"):
    """Area of the cross-section ``along`` metres distal of the wrist centre, m^2.

    The plane stands across the bent middle line: it turns with the hand, half as far at the wrist centre itself.
    """
    bend = np.deg2rad(degrees)
    skin = blend(hand, pose(hand, {"wrist.flexion_extension": bend, "wrist.deviation": 0.0}).angle, method=method)
    turn = bend * np.clip(0.5 + 0.5 * along / BEND_ENDS, 0.0, 1.0)
    normal = np.array([np.cos(turn), np.sin(turn), 0.0])
    at = along * (np.array([np.cos(bend), np.sin(bend), 0.0]) if along > 0 else np.array([1.0, 0.0, 0.0]))
    surface = pv.make_tri_mesh(np.array(skin), np.array(hand.skin.faces))
    loops = [cell.points - at for cell in surface.slice(normal=normal, origin=at).strip(join=True).cell]
    assert len(loops) == 1  # the wrist, and nothing of the hand
    return abs(np.cross(loops[0], np.roll(loops[0], -1, axis=0)).sum(axis=0) @ normal) / 2.0


def test_the_straight_wrist_is_as_thick_as_a_wrist(hand):
    """Between 8 and 25 cm2."""
    assert 0.0008 < section(hand, 0.0, 0.0) < 0.0025


@pytest.mark.parametrize("degrees", [60.0, -60.0], ids=["flexed", "extended"])
@pytest.mark.parametrize("along", [-0.015, -0.01, -0.005, 0.0, 0.005, 0.01, 0.015])
def test_at_60_degrees_the_wrist_keeps_four_fifths_of_its_cross_section(hand, degrees, along):
    share = section(hand, degrees, along) / section(hand, 0.0, along)
    assert 0.80 <= share <= 1.30


def test_averaged_matrices_would_pinch_the_wrist_more_than_dual_quaternions(hand):
    """What the bound above guards against: the collapse shows in this measure."""
    dual, linear = (section(hand, 75.0, 0.0, method) / section(hand, 0.0, 0.0, method) for method in ("dual", "linear"))
    assert linear < dual - 0.05
