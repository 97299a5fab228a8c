"""The skin over a muscle that contracts while the bones stand still."""

import numpy as np
import pytest

import handlab as hl
from handlab.studies.swelling import swelling


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.fixture(scope="module")
def pinch(hand):
    return hl.simulate(hand, "key-pinch")


def test_the_first_web_rises_by_two_millimetres_in_key_pinch_and_nothing_far_away_does(hand, pinch):
    found = swelling(hand, pinch.angle[-1], pinch.contraction[-1], ["DI1"])
    most, k = found.most
    assert 2.0e-3 <= most <= 4.0e-3
    way = np.linalg.norm(found.off - found.off[k], axis=1)
    assert np.abs(found.rise[way > 0.05]).max() < 0.3e-3
    names = [hand.bones[name].points.mean(axis=0) for name in ("metacarpal_1", "metacarpal_2")]
    bind = hand.skin.points[k]
    assert all(np.linalg.norm(bind - place) < 0.04 for place in names)  # between the first two metacarpals


def test_half_a_contraction_raises_the_skin_less_and_none_not_at_all(hand, pinch):
    angle, contraction = pinch.angle[-1], pinch.contraction[-1]
    half, none = (swelling(hand, angle, contraction, ["DI1"], level=level) for level in (0.5, 0.0))
    assert 0.3e-3 < half.most[0] < swelling(hand, angle, contraction, "DI1").most[0]
    assert np.abs(none.rise).max() == 0.0


def test_bad_names_and_levels_are_refused(hand, pinch):
    with pytest.raises(LookupError, match="did you mean"):
        swelling(hand, pinch.angle[-1], pinch.contraction[-1], ["DI9"])
    with pytest.raises(ValueError, match="between 0 and 1"):
        swelling(hand, pinch.angle[-1], pinch.contraction[-1], ["DI1"], level=1.5)
