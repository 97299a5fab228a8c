"""The one table of passive structures: complete, sourced, and off in the printed reading."""

import copy

import numpy as np
import pytest

import handlab
from handlab.anatomy.data import read_json
from handlab.anatomy.passive import passive, printed_friction, validate_passive
from handlab.anatomy.table_rules import TableError
from handlab.anatomy.tables import joints_table

DOFS = {dof.name: dof for row in joints_table().values() for dof in row.dofs}


@pytest.fixture(scope="module")
def hand():
    return handlab.load_hand()


def test_moving_joints_have_a_small_stiffness_and_followers_none():
    stiffness = dict(zip(DOFS, passive().stiffness, strict=True))
    assert stiffness["wrist.deviation"] == 0.5
    assert stiffness["cmc1.flexion_opposition"] == 0.15
    assert stiffness["pip3.flexion_extension"] == 0.04
    assert stiffness["dip3.flexion_extension"] == 0.035
    for name, dof in DOFS.items():
        assert (stiffness[name] == 0) == (dof.driver is not None)
        assert stiffness[name] == 0 or 0.035 <= stiffness[name] <= 0.5


def test_every_moving_joint_has_a_capsule_of_its_own_and_the_relaxed_hand_stretches_none(hand):
    for k, (name, dof) in enumerate(hand.dofs.items()):
        width, torque = hand.capsule.width[k], hand.capsule.torque[k]
        if dof.driver is not None:
            assert width == 0.0 and np.all(torque == 0.0)
            continue
        assert np.deg2rad(3) <= width <= np.deg2rad(8)
        assert np.all(torque >= 0.05)
        low, high = dof.limits
        assert low + width <= hand.relaxed[k] <= high - width, name
    assert len(np.unique(hand.capsule.torque)) > 10  # not one stiffness for all


def test_fingers_cannot_be_spread_in_a_fist():
    ligament = passive().collateral
    assert 0.1 <= ligament["range_fraction_at_90"] <= 0.25
    assert 5 <= ligament["stiffness_factor_at_90"] <= 10


def test_friction_is_the_printed_figure_but_at_the_wrist(hand):
    assert printed_friction() == 0.015
    friction = dict(zip(DOFS, hand.friction, strict=True))
    for name, dof in DOFS.items():
        assert friction[name] == (0.0 if dof.driver else 0.05 if name.startswith("wrist") else 0.015)


def test_every_rotation_without_a_muscle_is_said_to_be_held_by_something(hand):
    told = {name for row in read_json("anatomy/passive.json")["undriven"] for name in row["dofs"]}
    driven = np.any(hand.lever_arm != 0.0, axis=0)
    assert {name for name, any_arm in zip(hand.dof_names, driven, strict=True) if not any_arm} <= told
    assert {name for name, joint in hand.joints.items() if not joint.dofs} <= told


def test_the_printed_reading_has_no_passive_structures():
    printed = handlab.load_hand(reading="printed")
    assert printed.capsule is None and not printed.collateral
    assert np.all(printed.stiffness == 0.0)
    assert np.all(printed.friction == 0.015)


def test_a_hand_can_do_without_passive_structures(hand):
    bare = hand.without_passive()
    assert bare.capsule is None and np.all(bare.stiffness == 0.0) and not bare.collateral
    assert hand.capsule is not None


def broken(change):
    table = copy.deepcopy(read_json("anatomy/passive.json"))
    change(table)
    return table


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (
            lambda table: table["rows"][0]["stiffness"].update(newton_metre_per_rad=-1),
            "stiffness of wrist.flexion_extension must be",
        ),
        (lambda table: table["rows"][0].pop("friction"), "wrist.flexion_extension has no 'friction'"),
        (lambda table: table["rows"][0].update(dof="wirst.flexion"), "unknown degree of freedom 'wirst.flexion'; nearest are wrist"),
        (lambda table: table["rows"][0].update(dof="mcp3.axial_rotation"), "follows mcp3.flexion_extension"),
        (lambda table: table["rows"].append(table["rows"][0]), "stands there twice"),
        (lambda table: table["rows"].pop(), "moves by itself but has no row"),
        (lambda table: table["rows"][3]["capsule"].update(begins_deg_before_limit=60), "needs a positive begin before the middle"),
        (lambda table: table["rows"][3]["capsule"].update(newton_metre_at_limits=[0.1, -0.1]), "two positive torques"),
        (lambda table: table["rows"][3]["capsule"].pop("sources"), "has no source"),
    ],
)
def test_a_broken_table_is_refused_with_its_place(change, complaint):
    validate_passive(broken(lambda table: None))
    with pytest.raises(TableError, match=complaint):
        validate_passive(broken(change))


def test_fibres_can_have_their_rest_length_in_three_postures_by_name(hand):
    flat, half = hand.with_fibre_rest("flat"), hand.with_fibre_rest("half-closed")
    k = [hand.dof_names.index(name) for name in ("wrist.flexion_extension", "mcp2.flexion_extension", "mcp5.axial_rotation")]
    np.testing.assert_allclose(np.rad2deg(hand.fibre_rest[k]), [-15, 30, -3.9], atol=1e-9)
    np.testing.assert_allclose(np.rad2deg(half.fibre_rest[k]), [-10, 45, -4.5], atol=1e-9)
    np.testing.assert_allclose(flat.fibre_rest[k], 0.0)
    np.testing.assert_array_equal(flat.relaxed, hand.relaxed)
    np.testing.assert_array_equal(handlab.load_hand(reading="printed").fibre_rest, flat.fibre_rest)
    with pytest.raises(KeyError, match="half-closed"):
        hand.with_fibre_rest("half-open")
