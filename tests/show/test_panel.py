import numpy as np

from handlab.show.colours import OKABE_ITO
from handlab.show.moments import Moment, story
from handlab.show.muscle_panel import active, grouped, newton_note, panel, regions


def test_the_muscles_that_contract_are_listed_and_no_other(grip):
    rows = active(story(grip))
    contracting = np.flatnonzero(grip.contraction.max(axis=0) > 0.02)
    assert rows == list(contracting)


def test_a_relaxed_hand_lists_no_muscle(hand):
    assert active(story(hand)) == []


def test_every_group_has_a_colour_of_its_own(hand):
    colours = regions(hand)
    assert len(colours) == len(set(colours.values())) == 7
    assert set(colours.values()) <= set(OKABE_ITO)


def test_groups_keep_every_row(hand, grip):
    rows = active(story(grip))
    assert sorted(k for own in grouped(hand, rows).values() for k in own) == rows


def test_a_bar_is_as_long_as_the_contraction(hand):
    row = hand.muscle_names.index("flexor_digitorum_profundus_index")
    colour = np.array([int(regions(hand)[hand.muscles["FDP2"].region][k : k + 2], 16) for k in (1, 3, 5)])
    width = []
    for contraction in (0.25, 0.5, 1.0):
        values = np.zeros(42)
        values[row] = contraction
        moment = Moment(0.0, hand.skin.points, hand.bind, values, values * hand.max_force)
        image = np.asarray(panel(hand, [row], moment, (300, 200)))
        bar = (np.abs(image.astype(int) - colour).sum(axis=2) == 0).any(axis=0)
        width.append(bar.sum())
    assert np.allclose(np.diff(np.array(width) / 0.33 / 270), [0.25, 0.5], atol=0.03)


def test_the_note_names_the_newtons_per_percent(hand):
    assert newton_note(hand.with_newton_per_percent(12.5)).startswith("newtons at 12.5 N per %")
