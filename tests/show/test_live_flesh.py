"""Muscles of moving pictures lie where the exact ones do."""

import numpy as np
import pytest

import handlab as hl
from handlab.show.live_flesh import Product, drawn
from handlab.show.moments import Moment
from handlab.show.scene import Scene
from handlab.simulation.geometric_muscle import ellipsoids, geometric_muscles
from handlab.simulation.muscle_surface import skeletons, surface_points


@pytest.mark.parametrize("side", ["right", "left"])
def test_points_drawn_live_are_those_of_the_exact_surface_to_four_tenths_of_a_millimetre(side):
    hand = hl.load_hand(side=side)
    muscles = geometric_muscles(hand)
    clip = hl.simulate(hand, "fist")
    segments = ellipsoids(hand, clip.angle[-1], np.full(len(hand.muscles), 0.7))
    exact = [points[drawn(kept)] for points, kept in zip(surface_points(muscles, segments), skeletons(muscles), strict=True)]
    off = np.linalg.norm(Product(muscles).points(segments) - np.concatenate(exact), axis=1)
    assert off.max() < 4e-4
    at_rest = [points[drawn(kept)] for points, kept in zip(surface_points(muscles, muscles.rest), skeletons(muscles), strict=True)]
    assert np.abs(Product(muscles).points(muscles.rest) - np.concatenate(at_rest)).max() < 1e-9


@pytest.mark.xdist_group("pictures")
def test_a_live_scene_shows_the_muscles_that_a_still_shows(hand, grip):
    moment = Moment(0.5, grip.skin(-1), grip.angle[-1], grip.contraction[-1])
    seen = {}
    for quality in ("live", "film"):
        with Scene(hand, skin="translucent", layers=["muscles"], size=(300, 300), quality=quality) as scene:
            scene.pose(moment)
            picture = scene.picture().astype(int)
        seen[quality] = (picture[..., 0] - picture[..., 1] > 50) & (picture[..., 1] < 150)
    assert seen["film"].sum() > 400
    assert (seen["live"] ^ seen["film"]).sum() < 0.25 * seen["film"].sum()
