"""The man's and the child's hand that come with handlab."""

import numpy as np
import people
import pytest

import handlab as hl
from handlab.anatomy import data

SHIPPED = {"man": "man", "child": "small_child"}


@pytest.fixture(scope="module", params=sorted(SHIPPED))
def shipped(request):
    return request.param, hl.load_hand(data.folder() / "people" / request.param)


def test_its_bones_are_those_of_the_person_it_was_photographed_from(shipped):
    name, hand = shipped
    true, found = people.everyone()[SHIPPED[name]].lengths_mm, people.hand_lengths_mm(hand)
    assert 0.05 < np.mean([abs(found[bone] - true[bone]) for bone in people.BONES]) < 2.0


def test_it_has_the_names_faces_and_weights_of_the_reference_hand(shipped):
    name, hand = shipped
    reference = people.hand()
    assert hand.name == name and hand.side == "right"
    assert hand.dof_names == reference.dof_names and hand.muscle_names == reference.muscle_names
    np.testing.assert_array_equal(hand.skin.faces, reference.skin.faces)
    np.testing.assert_array_equal(hand.skin.weights, reference.skin.weights)
    np.testing.assert_array_equal(hand.skin_fine.texture, reference.skin_fine.texture)


def test_saved_again_it_comes_back_to_the_last_bit(shipped, tmp_path):
    name, hand = shipped
    again = hl.load_hand(hand.save(tmp_path / name))
    for one, other in ((hand.skin.points, again.skin.points), (hand.skin_fine.points, again.skin_fine.points), (hand.bind, again.bind)):
        np.testing.assert_array_equal(one, other)
    for joint in hand.joints:
        np.testing.assert_array_equal(hand.joints[joint].centre, again.joints[joint].centre)


def test_a_man_weighs_more_and_a_child_less_than_the_reference_hand():
    def mass(hand):
        return sum(body.mass for name, body in hand.bodies.items() if name != "forearm")

    man, child = (hl.load_hand(data.folder() / "people" / name) for name in ("man", "child"))
    reference = mass(people.hand())
    assert 1.3 < mass(man) / reference < 2.2
    assert 0.2 < mass(child) / reference < 0.6


def test_it_plays_a_clip_and_closes_its_fist(shipped):
    _, hand = shipped
    clip = hl.simulate(hand, hl.keyframes("fist"), seconds=1.0)
    flexed = np.degrees(clip.angle[-1][[hand.dof_names.index(f"pip{k}.flexion_extension") for k in range(2, 6)]])
    assert np.isfinite(clip.angle).all() and flexed.min() > 40.0
