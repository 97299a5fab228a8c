"""A motion with a soft skin: what is recorded, how it is switched, what stays as it was."""

import threading

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.terms import UnknownName
from handlab.simulation.skin import blend
from handlab.simulation.soft_frame import begin, follow
from handlab.simulation.soft_skin import soft_skin
from handlab.simulation.worn import dress

SWELL = {"DI1": [(0.0, 0.0), (0.25, 1.0)]}
SOFT = "springs and muscles"


@pytest.fixture(scope="module")
def soft(hand):
    return hl.simulate(hand, SWELL, seconds=0.4, skin=SOFT)


def test_the_bones_do_not_hear_of_the_skin(hand, soft):
    plain = hl.simulate(hand, SWELL, seconds=0.4)
    assert np.array_equal(plain.angle, soft.angle)
    assert plain.wear == "blend"
    assert np.array_equal(plain.skin(-1), blend(hand, plain.angle[-1]))
    assert soft.wear == SOFT
    assert "springs and muscles" in repr(soft)


def test_every_frame_is_the_one_that_the_network_gives(hand, soft):
    network = soft_skin(hand)
    frames = [begin(hand, network, soft.angle[0], soft.contraction[0])]
    for k in range(1, len(soft)):
        frames.append(follow(hand, network, frames[-1], soft.angle[k], soft.contraction[k], soft.time[k] - soft.time[k - 1]))
    for k in (0, 7, len(soft) - 1):
        assert np.abs(frames[k].position.T - soft.skin(k)).max() < 1e-7
    assert 5e-4 < np.abs(soft.skin(-1) - blend(hand, soft.angle[-1])).max() < 2e-2
    assert np.array_equal(soft.states[-1].skin, soft.skin(len(soft) - 1))


def test_the_skin_can_be_changed_afterwards_and_taken_off(hand, soft):
    again = soft.with_skin("blend").with_skin(SOFT)
    assert np.array_equal(again.skin(len(again) // 2), soft.skin(len(soft) // 2))
    assert np.array_equal(soft.with_skin("blend").skin(3), blend(hand, soft.angle[3]))
    springs = soft.with_skin("springs")
    assert 3e-4 < np.abs(springs.skin(-1) - soft.skin(-1)).max() < 2e-2


def test_with_geometric_muscles_only_the_flesh_swells_and_the_bones_stand_still(hand):
    clip = hl.simulate(hand, SWELL, seconds=0.6, skin=SOFT, muscles="geometric")
    assert np.ptp(clip.angle, axis=0).max() == 0.0
    assert 1.5e-3 < np.linalg.norm(clip.skin(-1) - clip.skin(0), axis=1).max() < 6e-3


def test_with_pseudo_muscles_only_contraction_does_not_lift_the_skin(hand, soft):
    clip = hl.simulate(hand, SWELL, seconds=0.4, skin=SOFT, muscles="pseudo")
    assert np.array_equal(clip.angle, soft.angle)
    assert clip.contraction.max() == 1.0
    still = hl.simulate(hand, SWELL, seconds=0.4).with_skin(SOFT)
    assert np.linalg.norm(clip.skin(-1) - still.skin(-1), axis=1).max() > 1.5e-3
    quiet = begin(hand, soft_skin(hand), clip.angle[0], None)
    assert np.abs(clip.skin(0) - quiet.points).max() < 1e-7


def test_an_unknown_name_is_answered_with_the_nearest(hand):
    with pytest.raises(UnknownName, match="springs"):
        hl.simulate(hand, SWELL, seconds=0.1, skin="sprigns")
    with pytest.raises(UnknownName, match="pseudo"):
        hl.simulate(hand, SWELL, seconds=0.1, muscles="pseud")


def test_a_dressed_state_has_the_same_bones_and_a_skin_at_rest(hand):
    state = hl.pose(hand, {"mcp2.flexion_extension": 1.2})
    other = dress(hand, state)
    assert np.array_equal(other.angle, state.angle)
    assert 3e-4 < np.abs(other.skin - state.skin).max() < 2e-2
    assert np.abs(dress(hand, state, skin="blend").skin - state.skin).max() < 1e-12


def test_threads_that_ask_at_once_get_the_same_frames(hand, soft):
    clip, got = soft.with_skin("blend").with_skin(SOFT), {}
    threads = [threading.Thread(target=lambda k=k: got.__setitem__(k, clip.skin(k))) for k in (20, 3, 12, 20, 7)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(points, soft.skin(k)) for k, points in got.items())


def test_progress_reaches_the_end_once(hand):
    told = []
    hl.simulate(hand, SWELL, seconds=0.2, skin="springs", progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0
