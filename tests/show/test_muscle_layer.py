"""Muscles, tendons and grids in pictures."""

import numpy as np
import pytest

from handlab.show.muscle_layer import MuscleLayer, grid_picture, picture, tones
from handlab.show.scene import Scene
from handlab.simulation.geometric_muscle import ellipsoids, geometric_muscles
from handlab.simulation.muscle_surface import surface_points

SIZE = (220, 280)


def red(seen):
    """Where muscle shows: much more red than green."""
    values = seen.astype(int)
    return (values[..., 0] > 90) & (values[..., 0] - values[..., 1] > 60)


def test_bellies_are_red_and_their_fibres_and_ends_differ():
    u, v = np.array([0.5, 0.5, 0.0]), np.array([-1.0, -0.8, 0.0])
    colours = tones(u, v, bundles=5).astype(int)
    assert colours[0, 0] > colours[0, 1] + 60
    assert np.abs(colours[0] - colours[1]).max() > 20
    assert colours[2].min() > 150


def test_a_picture_shows_muscles_where_there_were_none(hand):
    with_muscles = picture(hand, view="palm", size=SIZE)
    assert with_muscles.shape == (SIZE[1], SIZE[0], 3)
    assert 0.02 < red(with_muscles).mean() < 0.3
    bare = picture(hand, view="palm", size=SIZE, only=())
    assert red(bare).mean() < 0.2 * red(with_muscles).mean()


def test_points_are_replaced_in_place(hand):
    with Scene(hand, skin="hidden", size=SIZE) as scene:
        layer = MuscleLayer(scene)
        names = set(scene.plotter.actors)
        before = scene.picture()
        actors = {name: scene.plotter.actors[name] for name in names}
        angle = hand.bind.copy()
        angle[hand.dof_names.index("cmc1.flexion_opposition")] += 0.3
        layer.pose(angle, np.ones(len(hand.muscles)))
        assert {name: scene.plotter.actors[name] for name in scene.plotter.actors} == actors
        assert np.abs(scene.picture().astype(int) - before).mean() > 0.3
        drawn = scene.plotter.actors["muscle opponens_pollicis"].mapper.dataset.points
        muscles = geometric_muscles(hand)
        meant = surface_points(muscles, ellipsoids(hand, angle, np.ones(len(hand.muscles))))[muscles.index("opponens_pollicis")]
        np.testing.assert_allclose(drawn, meant, atol=1e-6)
        layer.pose(hand.bind)
        assert np.abs(scene.picture().astype(int) - before).mean() < 0.01


def test_every_actor_has_a_name(hand):
    with Scene(hand, skin="hidden", size=SIZE) as scene:
        MuscleLayer(scene)
        names = list(scene.plotter.actors)
    assert {f"muscle {name}" for name in geometric_muscles(hand).names} <= set(names)
    assert sum(name.startswith("tendon ") for name in names) == 32


def test_figure_4_shows_a_blue_grid_and_green_dots(hand):
    values = grid_picture(hand, "abductor_digiti_minimi", view="ulnar", size=SIZE).astype(int)
    blue = (values[..., 2] > 120) & (values[..., 2] - values[..., 0] > 80)
    green = (values[..., 1] - values[..., 0] > 30) & (values[..., 1] - values[..., 2] > 10)
    assert blue.sum() > 60
    assert green.sum() > 20


def test_an_unknown_muscle_is_answered_with_the_nearest(hand):
    with pytest.raises(KeyError, match="abductor_digiti_minimi"):
        grid_picture(hand, "abductor_digiti", size=SIZE)
