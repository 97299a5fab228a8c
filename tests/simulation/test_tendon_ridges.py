import numpy as np
import pytest
from scipy.spatial import cKDTree

import handlab as hl
from handlab.simulation import tendon_ridges as ridged
from handlab.simulation.skin import fine_points
from handlab.simulation.tendons import courses, tendons
from handlab.studies.relief import valleys

EXTENSORS = {"EDC2": 1.0, "EDC3": 1.0, "EDC4": 1.0, "EDC5": 1.0}


def contraction(hand, **values):
    out = np.zeros(len(hand.muscles))
    for name, value in values.items():
        out[hand.muscle_names.index(hand.muscles[name].name)] = value
    return out


def bent_back(hand, degrees):
    angle = np.array(hl.rest(hand).angle)
    for k in range(2, 6):
        angle[hand.dof_names.index(f"mcp{k}.flexion_extension")] = np.deg2rad(-degrees)
    return angle


def test_a_slack_tendon_leaves_the_skin_as_it_is(hand):
    assert np.all(ridged.ridge_heights(hand, hl.rest(hand).angle, contraction(hand)) == 0.0)
    assert np.all(ridged.ridge_heights(hand, bent_back(hand, 20), contraction(hand)) == 0.0)


def test_extensors_that_pull_stand_out_by_a_millimetre_and_more_over_a_knuckle_that_is_bent_back(hand):
    pull = contraction(hand, **EXTENSORS)
    straight, back = (ridged.ridge_heights(hand, bent_back(hand, degrees), pull).max() for degrees in (0, 20))
    assert 0.0008 < straight < 0.002
    assert straight + 0.001 < back < 0.0035
    half = ridged.ridge_heights(hand, bent_back(hand, 0), 0.1 * pull)
    assert 0.2 * straight < half.max() < 0.8 * straight


def test_a_ridge_lies_over_its_tendon_and_nowhere_else(hand):
    pose, pull = bent_back(hand, 0), contraction(hand, EDC3=1.0)
    passive = ridged.ridge_heights(hand, hand.bind, contraction(hand))  # of stretched muscles
    height = ridged.ridge_heights(hand, hand.bind, pull) - passive
    line = next(tube for tube in tendons(hand, hand.bind) if tube.name == "common extensor, middle").points
    far = cKDTree(line).query(hand.skin_fine.points)[0]
    high = height > 0.5 * height.max()
    assert far[high].max() < 0.007 and far[height > 1e-6].max() < 0.012
    assert len(np.flatnonzero(high)) > 10
    assert hand.skin_fine.points[high, 1].max() < np.median(hand.skin_fine.points[:, 1])  # on the back: y is palmar
    assert np.all(np.isin(np.flatnonzero(ridged.ridge_heights(hand, pose, pull)), ridged.ridge_points(hand)))


def test_beside_a_tendon_the_skin_falls_off_as_a_strip_on_an_elastic_bed():
    """B w'''' = -k w, by differences; no kink at the tendon."""
    length = ridged.LENGTH
    x = np.linspace(0.0, 3.0 * length, 601)
    w = np.exp(-x / length) * (np.cos(x / length) + np.sin(x / length))
    step = x[1]
    fourth = np.diff(w, 4) / step**4
    bending = ridged.YOUNG * ridged.THICKNESS**3 / 12.0
    np.testing.assert_allclose(bending * fourth, -ridged.BED_STIFFNESS * w[2:-2], atol=2e-3 * ridged.BED_STIFFNESS)
    assert abs(w[1] - w[0]) / step < 0.02 / length


def test_over_a_knuckle_that_is_bent_back_a_tendon_that_pulls_leaves_the_bone(hand):
    name = "common extensor, middle"
    for degrees, low, high in ((-60, 0.0, 1e-9), (20, 0.0010, ridged.MOST_BOW + 1e-4)):
        pose = bent_back(hand, degrees)
        slack, straight = (
            next(tube.points for tube in tendons(hand, pose, pull) if tube.name == name)
            for pull in (contraction(hand), contraction(hand, EDC3=1.0))
        )
        assert low <= np.linalg.norm(straight - slack, axis=1).max() <= high
    one = next(one for one in ridged.taut(hand) if courses(hand)[one.course].name == name)
    assert one.tent.argmax() == np.linalg.norm(one.way, axis=1).argmax() and one.tent.max() == pytest.approx(1.0)


def test_the_left_hand_has_the_same_ridges(hand):
    left, pull = hl.load_hand(side="left"), contraction(hand, **EXTENSORS)
    pose = bent_back(hand, 10)
    np.testing.assert_allclose(ridged.ridge_heights(left, pose, pull), ridged.ridge_heights(hand, pose, pull), atol=2e-5)


def test_in_a_fist_four_knuckles_stand_out_from_the_valleys_and_tendons_make_them_higher(hand):
    clip = hl.simulate(hand, "fist", fps=30, skin="springs and muscles")
    angle, skin = clip.angle[-1], clip.skin(-1)
    bare = valleys(hand, fine_points(hand, skin), angle)
    whole = valleys(hand, fine_points(hand, skin, ridged.ridge_heights(hand, angle, clip.contraction[-1])), angle)
    blended = valleys(hand, fine_points(hand, clip.skin(-1, method="dual")), angle)
    assert np.all(bare > blended + 0.001)
    assert np.all((whole > bare + 0.0005) & (whole > 0.0025) & (whole < 0.006))
