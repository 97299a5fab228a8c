"""What every muscle does alone: directions from anatomy books, not from the table of lever arms."""

import numpy as np
import pytest

from handlab.simulation.balance import settled
from handlab.simulation.skeleton import pose, rest

# The wrist is held, except for the muscles that move it. "+" flexion, radial, palmar abduction; "-" extension, ulnar, adduction.
WRIST = {
    "FCR": {"wrist.flexion_extension": +1, "wrist.deviation": +1},
    "PL": {"wrist.flexion_extension": +1},
    "FCU": {"wrist.flexion_extension": +1, "wrist.deviation": -1},
    "ECRL": {"wrist.flexion_extension": -1, "wrist.deviation": +1},
    "ECRB": {"wrist.flexion_extension": -1, "wrist.deviation": +1},
    "ECU": {"wrist.flexion_extension": -1, "wrist.deviation": -1},
}
THUMB = {
    "FPL": {"ip1.flexion_extension": +1, "mcp1.flexion_extension": +1, "cmc1.flexion_opposition": +1},
    "EPL": {"ip1.flexion_extension": -1, "mcp1.flexion_extension": -1, "cmc1.flexion_opposition": -1, "cmc1.abduction_adduction": -1},
    "EPB": {"mcp1.flexion_extension": -1, "cmc1.flexion_opposition": -1},
    "APL": {"cmc1.abduction_adduction": +1, "cmc1.flexion_opposition": -1},
    "APB": {"cmc1.abduction_adduction": +1},
    "FPB": {"mcp1.flexion_extension": +1, "cmc1.flexion_opposition": +1},
    "OPP": {"cmc1.flexion_opposition": +1, "cmc1.abduction_adduction": +1},
    "ADP": {"cmc1.abduction_adduction": -1, "cmc1.flexion_opposition": +1},
}
FINGERS = {
    **{f"FDS{k}": {f"mcp{k}.flexion_extension": +1, f"pip{k}.flexion_extension": +1} for k in range(2, 6)},
    **{f"FDP{k}": {f"{joint}{k}.flexion_extension": +1 for joint in ("mcp", "pip", "dip")} for k in range(2, 6)},
    **{f"EDC{k}": {f"mcp{k}.flexion_extension": -1} for k in range(2, 6)},
    "EDM": {"mcp5.flexion_extension": -1},
    "EIP": {"mcp2.flexion_extension": -1},
    "ADM": {"mcp5.deviation": -1},
    "FDMB": {"mcp5.flexion_extension": +1},
    "ODM": {"cmc5.flexion_opposition": +1},
    **{
        f"LUM{k - 1}": {f"mcp{k}.flexion_extension": +1, f"pip{k}.flexion_extension": -1, f"dip{k}.flexion_extension": -1}
        for k in range(2, 6)
    },
    "PI1": {"mcp2.deviation": -1, "mcp2.flexion_extension": +1},
    "PI2": {"mcp4.deviation": +1, "mcp4.flexion_extension": +1},
    "PI3": {"mcp5.deviation": +1, "mcp5.flexion_extension": +1},
    "DI1": {"mcp2.deviation": +1, "mcp2.flexion_extension": +1},
    "DI2": {"mcp3.deviation": +1, "mcp3.flexion_extension": +1},
    "DI3": {"mcp3.deviation": -1, "mcp3.flexion_extension": +1},
    "DI4": {"mcp4.deviation": -1, "mcp4.flexion_extension": +1},
}
# Finger of each long extensor.
LONG_EXTENSORS = {"EDC2": 2, "EDC3": 3, "EDC4": 4, "EDC5": 5, "EDM": 5, "EIP": 2}
ACTIONS = {**WRIST, **THUMB, **FINGERS}


def moved(hand, muscle, hold):
    """Degrees that every angle moves when one muscle alone contracts by half for half a second."""
    state = settled(hand, {muscle: 0.5}, hold=hold, seconds=0.5)
    return dict(zip(hand.dof_names, np.rad2deg(state.angle - rest(hand).angle), strict=True))


def test_the_table_has_all_42_muscles(hand):
    assert sorted(ACTIONS) == sorted(muscle.abbreviation for muscle in hand.muscles.values())


@pytest.mark.parametrize("muscle", ACTIONS)
def test_each_muscle_alone_moves_its_joints_as_anatomy_says(hand, muscle):
    turned = moved(hand, muscle, hold=() if muscle in WRIST else ("wrist",))
    for dof, direction in ACTIONS[muscle].items():
        assert direction * turned[dof] > 0.5, f"{muscle} turns {dof} by {turned[dof]:.2f} degrees"


@pytest.mark.parametrize("muscle", LONG_EXTENSORS)
def test_a_long_extensor_straightens_the_whole_finger_where_its_knuckle_is_held(hand, muscle):
    """Bouvier's test: with the knuckle free, the flexors that it stretches claw the finger instead."""
    finger = LONG_EXTENSORS[muscle]
    turned = moved(hand, muscle, hold=("wrist", f"mcp{finger}"))
    for joint in ("pip", "dip"):
        assert turned[f"{joint}{finger}.flexion_extension"] < -5.0


@pytest.mark.parametrize("muscle", [name for name in ACTIONS if name not in WRIST])
def test_with_the_wrist_held_a_muscle_moves_only_its_own_digit(hand, muscle):
    digits = {dof.partition(".")[0][-1] for dof in ACTIONS[muscle]}
    if "5" in digits:
        digits |= {"4"}  # the ring finger's metacarpal follows that of the little finger
    for dof, degrees in moved(hand, muscle, hold=("wrist",)).items():
        if dof.partition(".")[0][-1] not in digits:
            assert abs(degrees) < 0.5, f"{muscle} turns {dof} by {degrees:.2f} degrees"


def test_with_the_wrist_held_the_first_dorsal_interosseus_moves_only_the_index(hand):
    state = settled(hand, {"DI1": 1.0}, hold=["wrist"], seconds=3.0)
    for dof, degrees in zip(hand.dof_names, np.rad2deg(state.angle - rest(hand).angle), strict=True):
        if dof.partition(".")[0] not in ("mcp2", "pip2", "dip2"):
            assert abs(degrees) < 0.5, dof


def test_a_flexed_wrist_opens_the_fingers_and_an_extended_one_closes_them(hand):
    """Tenodesis: the stretched tendons of a relaxed hand move its fingers."""
    k = hand.dof_names.index("mcp3.flexion_extension")
    flexion = [
        settled(hand, {}, start=pose(hand, {"wrist.flexion_extension": np.deg2rad(degrees)}), hold=["wrist"], seconds=3.0).angle[k]
        for degrees in (-60, 60)
    ]
    assert np.rad2deg(flexion[0] - flexion[1]) > 5.0
