import numpy as np
import pytest

import handlab as hl
from handlab.show.moments import story


def test_a_moment_at_a_frame_is_that_frame(grip):
    moment = story(grip).at(10 / 60)
    assert np.allclose(moment.angle, grip.angle[10], atol=1e-12)
    assert np.allclose(moment.skin, grip.skin(10), atol=1e-12)
    assert np.allclose(moment.force, grip.force[10], atol=1e-9)


def test_a_moment_between_two_frames_lies_between_them(grip):
    moment = story(grip).at(10.25 / 60)
    assert np.allclose(moment.angle, 0.75 * grip.angle[10] + 0.25 * grip.angle[11], atol=1e-12)
    assert np.allclose(moment.contraction, 0.75 * grip.contraction[10] + 0.25 * grip.contraction[11], atol=1e-12)


def test_time_beyond_the_clip_shows_its_last_frame(grip):
    assert np.array_equal(story(grip).at(99.0).angle, grip.angle[-1])
    assert np.array_equal(story(grip).at(-1.0).angle, grip.angle[0])


def test_a_hand_is_drawn_relaxed(hand):
    assert np.array_equal(story(hand).at(0.0).skin, hl.rest(hand).skin)


def test_a_state_needs_its_hand(hand):
    with pytest.raises(TypeError, match="hand=hand"):
        story(hl.rest(hand))
    assert story(hl.rest(hand), hand).hand is hand


def test_something_else_cannot_be_drawn():
    with pytest.raises(TypeError, match="cannot draw a list"):
        story([1, 2, 3])
