"""A flexed wrist leaves the closed fingers no force: active insufficiency."""

import numpy as np
import pytest

import handlab as hl
from handlab.studies.grip import FIST_DEG, wrist_force


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


def by_hand(hand, abbreviation, wrist_deg):
    """Fibre ratio from lever arms one by one."""
    muscle = hand.muscles[abbreviation]
    digit = abbreviation[-1]
    angle = {f"{joint}{digit}.flexion_extension": value for joint, value in FIST_DEG.items()} | {"wrist.flexion_extension": wrist_deg}
    rest = dict(zip(hand.dof_names, hand.fibre_rest, strict=True))
    moved = sum(arm.used * (np.deg2rad(angle[arm.dof]) - rest[arm.dof]) for arm in muscle.lever_arms if arm.dof in angle)
    return 1.0 - moved / muscle.rest_length


@pytest.mark.parametrize("wrist_deg", [-60.0, 0.0, 20.0, 70.0])
def test_the_force_is_that_of_the_lengths_from_the_lever_arms(hand, wrist_deg):
    found = wrist_force(hand, wrist_deg)
    expected = sum(
        max(0.0, 1 - 4 * (by_hand(hand, f"FDS{k}", wrist_deg) - 1.1) ** 2) * hand.muscles[f"FDS{k}"].tension_percent * 20
        for k in range(2, 6)
    )
    assert float(found.superficial[0]) == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert float(found.flexors[0]) == pytest.approx(float(found.superficial[0] + found.deep[0]))


def test_the_fist_is_strong_with_an_extended_wrist_and_powerless_with_a_flexed_one(hand):
    extended, neutral, flexed = wrist_force(hand, [-35.0, 0.0, 70.0]).flexors
    assert extended > 1.4 * neutral
    assert flexed < 0.05 * extended


def test_the_flat_rest_posture_of_the_paper_loses_the_deep_flexors_before_the_fist_closes(hand):
    flat = wrist_force(hand.with_fibre_rest("flat"), [0.0])
    relaxed = wrist_force(hand, [0.0])
    assert float(flat.deep[0]) == 0.0
    assert float(relaxed.deep[0]) > 40.0


def test_flexing_the_wrist_stretches_the_finger_extensors(hand):
    found = wrist_force(hand)
    assert found.angle_deg[0] == pytest.approx(-70)
    assert found.angle_deg[-1] == pytest.approx(75)
    assert (np.diff(found.extensors) >= -1e-9).all()
    assert found.extensors[-1] > 3 * found.extensors[len(found.extensors) // 2] > 0
