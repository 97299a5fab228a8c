"""Loose tissue below hairy skin: where it is, how soft it is; and how deep a valley between two knuckles is."""

import numpy as np
import pytest

import handlab as hl
from handlab.simulation.hairy_skin import LOOSE, firmness, hairy, loose
from handlab.simulation.soft_skin import THICKNESS
from handlab.studies.relief import touching


def test_backs_and_the_forearm_are_hairy_and_palm_and_pulps_are_not(hand):
    share, normal = hairy(hand), hand.skin.points - hand.skin.points.mean(axis=0)
    assert share.min() == 0.0 and share.max() == 1.0
    weights = hand.skin.weights
    palm = weights[:, hand.body_names.index("carpus")] > 0.95
    flat = palm & (np.abs(normal[:, 1]) > 0.01)
    assert np.all(share[flat & (normal[:, 1] > 0.02)] < 0.1)
    assert np.all(share[weights[:, hand.body_names.index("forearm")] > 0.99] > 0.99)
    for k in range(1, 6):
        own = weights[:, hand.body_names.index(f"distal_phalanx_{k}")] > 0.95
        assert 0.2 < share[own].mean() < 0.8, k


def test_the_left_hand_is_hairy_where_the_right_one_is(hand):
    np.testing.assert_allclose(hairy(hl.load_hand(side="left")), hairy(hand), atol=1e-9)


def test_a_column_of_skin_and_loose_tissue_gives_as_two_springs_in_series_and_nowhere_less_than_in_the_palm(hand):
    depth = np.array([0.0016, 0.003, 0.006, 0.05])
    series = 1.0 / ((depth - THICKNESS) / LOOSE)  # per area, over the palm's modulus; skin itself does not give
    np.testing.assert_allclose(loose(depth, THICKNESS), np.minimum(1.0, series * depth), rtol=1e-12)
    assert loose(0.001, THICKNESS) == 1.0 and loose(10.0, THICKNESS) == pytest.approx(LOOSE, rel=1e-3)
    deep = np.full(len(hand.skin.points), 0.006)
    found = firmness(hand, deep, THICKNESS)
    np.testing.assert_allclose(found[hairy(hand) == 0.0], 1.0)
    np.testing.assert_allclose(found[hairy(hand) == 1.0], loose(0.006, THICKNESS))


@pytest.mark.parametrize("slope", [0.0, 0.5])
def test_a_straight_edge_touches_both_knuckles_however_the_row_falls(slope):
    x = np.linspace(0.0, 4.0 * np.pi, 801)
    left, right = touching(x, slope * x + np.cos(x - np.pi), 2.0 * np.pi)
    assert x[right] - x[left] == pytest.approx(2.0 * np.pi, abs=0.05)
    assert x[left] == pytest.approx(np.pi + np.arcsin(0.0), abs=0.05)
