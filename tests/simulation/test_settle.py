"""Where a hand comes to rest, against motions of 20 s that know nothing of balance."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import handlab as hl
from handlab.anatomy.records import frozen
from handlab.anatomy.terms import UnknownName
from handlab.simulation.balance import tangent, total_torque, unbalanced
from handlab.simulation.mechanics import mechanics
from handlab.simulation.skeleton import contraction_of, held_coordinates, state_at

CASES = 24
DECOUPLED = hl.Laws(dynamics="decoupled")
RIGHT_ANGLE = np.deg2rad(90)


def degrees(angle, other):
    return float(np.rad2deg(np.abs(angle - other)).max())


def case(k):
    """Random contractions of few or many muscles; every other one with held joints, every third with gravity from anywhere."""
    rng = np.random.default_rng([20030726, k])
    contraction = rng.uniform(size=42) * (rng.uniform(size=42) < rng.uniform(0.1, 1.0))
    hold = [(), ("wrist",), (), ("wrist", "mcp3", "cmc1.abduction_adduction")][k % 4]
    way = rng.normal(size=3)
    gravity = tuple(9.81 * way / np.linalg.norm(way)) if k % 3 == 0 else (0.0, 0.0, 0.0)
    return contraction, hold, gravity, rng


def somewhere(hand, rng):
    """A start anywhere within the limits."""
    limits = mechanics(hand).limits
    return hl.pose(hand, {name: rng.uniform(*limits[k]) for k, name in enumerate(hand.moving_names)})


@pytest.mark.parametrize("k", range(CASES))
def test_a_hand_settles_where_it_is_after_20_seconds(hand, k):
    """Both laws of motion end there: the mass matrix decides how a hand gets to its rest, not where it is."""
    contraction, hold, gravity, rng = case(k)
    start = somewhere(hand, rng) if k % 2 else hl.rest(hand)
    found = hl.settle(hand, contraction, start, hold=hold, gravity=gravity, look_for_others=False)
    for laws in (hl.Laws(gravity=gravity), replace(DECOUPLED, gravity=gravity)):
        clip = hl.simulate(hand, {"time": [0], **dict(zip(hand.muscle_names, contraction[:, None], strict=True))}, seconds=20, fps=1,
                           start=start, hold=hold, laws=laws)  # fmt: skip
        assert degrees(clip.angle[-1], found.state.angle) <= 0.1, laws.dynamics
    assert np.all(found.state.speed == 0.0)
    assert np.abs(found.unbalanced).max() < 1e-9
    assert found.stable


def test_the_random_hands_do_move(hand):
    """So that the comparison above is no comparison of hands that stay where they are."""
    moved = []
    for k in range(0, CASES, 4):
        contraction, hold, gravity, _ = case(k)
        moved.append(
            degrees(hl.settle(hand, contraction, hold=hold, gravity=gravity, look_for_others=False).state.angle, hl.rest(hand).angle)
        )
    assert min(moved) > 5.0


def test_the_relaxed_hand_rests_as_it_is_with_the_stiffness_of_its_springs(hand):
    found = hl.settle(hand, {})
    assert degrees(found.state.angle, hl.rest(hand).angle) < 1e-9
    assert found.stable and found.others == ()
    m = mechanics(hand)
    # in the relaxed hand nothing else resists but the springs, and those that MCP flexion tightens
    assert found.stiffness[0] == pytest.approx(m.stiffness.min(), rel=1e-6)
    assert found.stiffness[-1] == pytest.approx(m.stiffness.max(), rel=1e-6)
    assert len(found.stiffness) == len(m.moving)


def test_held_joints_stay_where_they_are_and_have_no_stiffness_of_their_own(hand):
    start = hl.pose(hand, {"wrist.flexion_extension": 0.7})
    found = hl.settle(hand, {"FDP3": 0.3}, start, hold=["wrist", "mcp3.flexion_extension"], look_for_others=False)
    held = [hand.dof_names.index(name) for name in ("wrist.flexion_extension", "wrist.deviation", "mcp3.flexion_extension")]
    np.testing.assert_array_equal(found.state.angle[held], start.angle[held])
    assert len(found.stiffness) == 20
    assert np.all(found.unbalanced[[hand.moving_names.index(hand.dof_names[k]) for k in held]] == 0.0)


def test_a_rest_at_a_hard_stop_is_found_and_the_stop_has_no_stiffness():
    """In the printed reading limits are hard: the extensor presses the finger into them."""
    hand = hl.load_hand(reading="printed")
    found = hl.settle(hand, {"EDC3": 1.0, "LUM2": 1.0}, hold=["wrist"], look_for_others=False)
    clip = hl.simulate(hand, {"EDC3": 1.0, "LUM2": 1.0}, seconds=20, fps=1, hold=["wrist"])
    assert degrees(clip.angle[-1], found.state.angle) <= 0.1
    pip = hand.dof_names.index("pip3.flexion_extension")
    assert found.state.angle[pip] == pytest.approx(hand.limits[pip, 0], abs=1e-9)
    assert len(found.stiffness) < 21


def test_a_small_push_dies_away_from_a_stable_rest(hand, rng):
    moving = mechanics(hand).moving
    for k in range(6):
        contraction, hold, gravity, _ = case(k)
        found = hl.settle(hand, contraction, hold=hold, gravity=gravity, look_for_others=False)
        assert found.stable and found.stiffness[0] > 0.01
        free = ~held_coordinates(hand, hold)
        pushed = state_at(hand, found.state.angle[moving] + np.deg2rad(1.0) * free * rng.choice([-1.0, 1.0], 23), np.zeros(23), 0.0)
        late = hl.step(hand, pushed, contraction, 10.0, hold=hold, laws=hl.Laws(gravity=gravity))
        assert degrees(pushed.angle, found.state.angle) > 0.9
        assert degrees(late.angle, found.state.angle) < 0.1


def test_stiffness_is_the_torque_that_a_small_turn_takes(hand):
    """Seen from outside: turn the settled hand a little and ask what torque is left."""
    contraction = {"FDP3": 0.4, "EDC3": 0.6, "DI2": 0.3}
    found = hl.settle(hand, contraction, hold=["wrist"], look_for_others=False)
    moving, by = mechanics(hand).moving, 1e-6
    y = found.state.angle[moving]
    columns = [-(total_torque(hand, y + by * e, contraction_of(hand, contraction)))[2:] / by for e in np.eye(23)[2:]]
    np.testing.assert_allclose(found.stiffness, np.linalg.eigvalsh(np.array(columns)), rtol=1e-3, atol=1e-4)


@pytest.fixture(scope="module")
def two_rests(hand):
    """(hand, contraction, start, hold) of a finger between two interossei that have been stretched beyond their best length.

    With fibres at rest in a straight finger whose MCP is bent to 90 degrees, the claw stretches DI2 and DI3 to 1.56 of that: the
    nearer one side comes, the harder it pulls. FDS3, which runs a little to the ulnar side, makes up for their different strength.
    """
    straight = np.array(hand.fibre_rest)
    for joint, angle in (("mcp3", RIGHT_ANGLE), ("pip3", 0.0), ("dip3", 0.0)):
        straight[hand.dof_names.index(f"{joint}.flexion_extension")] = angle
    stretched = hand.with_fibre_rest(straight)
    start = claw(stretched, 0.0)
    k = hand.moving_names.index("mcp3.deviation")
    y = start.angle[mechanics(stretched).moving]

    def left(pull):
        return total_torque(stretched, y, contraction_of(stretched, {"DI2": 1.0, "DI3": 1.0, "FDS3": pull}))[k]

    pull = brentq(left, 0.0, 1.0, xtol=1e-15)
    return stretched, {"DI2": 1.0, "DI3": 1.0, "FDS3": pull}, start, [name for name in hand.moving_names if name != "mcp3.deviation"]


def claw(hand, deviation_deg):
    angles = {"mcp3.flexion_extension": -30, "pip3.flexion_extension": 100, "dip3.flexion_extension": 60, "mcp3.deviation": deviation_deg}
    return hl.pose(hand, {name: np.deg2rad(angle) for name, angle in angles.items()})


def deviation(hand, angle):
    return float(np.rad2deg(angle[hand.dof_names.index("mcp3.deviation")]))


def test_between_two_muscles_on_the_falling_side_a_rest_is_unstable(two_rests):
    hand, contraction, start, hold = two_rests
    ratio = hl.rest(hand).fibre_length / hand.rest_length
    rows = [hand.muscle_names.index(hand.muscles[name].name) for name in ("DI2", "DI3")]
    assert np.all(np.abs(ratio[rows] - 1.0) < 0.3) and np.all(start.fibre_length[rows] / hand.rest_length[rows] > 1.4)
    found = hl.settle(hand, contraction, start, hold=hold)
    assert deviation(hand, found.state.angle) == pytest.approx(0.0, abs=1e-3)
    assert not found.stable
    assert -0.2 < found.stiffness[0] < -0.005
    assert np.abs(found.unbalanced).max() < 1e-9


def test_both_other_rests_are_found_and_a_push_decides_which_one(two_rests):
    hand, contraction, start, hold = two_rests
    found = hl.settle(hand, contraction, start, hold=hold)
    others = sorted(deviation(hand, angle) for angle in found.others)
    assert len(others) == 2
    assert -15.0 < others[0] < -5.0 and 5.0 < others[1] < 15.0
    for side, expected in zip((-0.5, 0.5), others, strict=True):
        pushed = hl.settle(hand, contraction, claw(hand, side), hold=hold)
        assert pushed.stable and pushed.stiffness[0] > 0.05
        assert deviation(hand, pushed.state.angle) == pytest.approx(expected, abs=1e-6)
        clip = hl.simulate(hand, contraction, seconds=20, fps=1, start=claw(hand, side), hold=hold)
        assert deviation(hand, clip.angle[-1]) == pytest.approx(expected, abs=0.1)
        # from there the one on the other side is another rest; the unstable one in the middle is none to settle in
        assert [deviation(hand, angle) for angle in pushed.others] == pytest.approx([sum(others) - expected], abs=1e-3)


def test_other_rests_are_rests(two_rests):
    hand, contraction, start, hold = two_rests
    for angle in hl.settle(hand, contraction, start, hold=hold).others:
        assert np.abs(unbalanced(hand, angle, contraction, hold=hold)).max() < 1e-9
        k = hand.moving_names.index("mcp3.deviation")
        assert tangent(hand, angle, contraction)[k, k] < 0.0


def test_others_are_not_looked_for_if_nobody_asks(two_rests):
    hand, contraction, start, hold = two_rests
    assert hl.settle(hand, contraction, start, hold=hold, look_for_others=False).others == ()


def test_a_hand_without_stiffness_that_stands_upright_may_lean_to_either_side(hand):
    """Gravity toward the forearm; only stretched fibres catch the hand. With its springs it stands, and there is one rest."""
    hold = [name for name in hand.moving_names if name != "wrist.flexion_extension"]
    upright = (-9.81, 0.0, 0.0)
    found = hl.settle(hand.without_passive(), {}, hold=hold, gravity=upright)
    assert found.stable and len(found.others) == 1
    ends = sorted(float(np.rad2deg(angle[0])) for angle in (found.state.angle, *found.others))
    assert ends[1] - ends[0] > 5.0
    middle = (hl.pose(hand, {"wrist.flexion_extension": np.deg2rad(end)}) for end in (ends[0] - 3, ends[1] + 3))
    for begin, end in zip(middle, ends, strict=True):
        clip = hl.simulate(hand.without_passive(), {"FDP3": 0.0}, seconds=20, fps=1, start=begin, hold=hold, laws=hl.Laws(gravity=upright))
        assert np.rad2deg(clip.angle[-1, 0]) == pytest.approx(end, abs=0.1)
    assert hl.settle(hand, {}, hold=hold, gravity=upright).others == ()


def test_gravity_moves_a_rest_the_way_it_pulls(hand):
    """Palm downward the knuckles drop into flexion, palm upward into extension; and so does the wrist, if nobody holds it."""
    columns = [hand.dof_names.index(f"{joint}.flexion_extension") for joint in ("wrist", "mcp2", "mcp3", "mcp4", "mcp5")]
    for hold, moved in ((("wrist",), columns[1:]), ((), columns[:1])):
        rests = (hl.settle(hand, {}, hold=hold, gravity=(0.0, g, 0.0), look_for_others=False) for g in (9.81, 0.0, -9.81))
        down, none, up = (found.state.angle for found in rests)
        assert np.all(down[moved] > none[moved] + np.deg2rad(1.0)) and np.all(none[moved] > up[moved] + np.deg2rad(1.0))


def test_the_time_of_a_rest_counts_from_its_start(hand):
    start = replace(hl.rest(hand), time=5.0)
    assert 7.0 <= hl.settle(hand, {"FDP2": 0.1}, start, look_for_others=False).state.time <= 65.0


def test_what_creeps_on_for_a_minute_is_an_error_that_names_it(hand):
    with pytest.raises(RuntimeError, match=r"has not come to rest after 60 s: \w+\.\w+ still turns by [\d.]+ degrees/s"):
        hl.settle(hand.with_(friction=frozen(np.full(31, 20.0))), {"FDP2": 0.3}, look_for_others=False)


BAD = {
    "a contraction above 1": ({"FDP2": 1.5}, {}, ValueError, "contraction of 'flexor_digitorum_profundus_index' is 1.5"),
    "a contraction that is no number": ({"FDP2": float("nan")}, {}, ValueError, "between 0 and 1"),
    "a muscle that does not exist": ({"FDP9": 1.0}, {}, UnknownName, "unknown muscle 'FDP9'"),
    "too few contractions": (np.zeros(3), {}, ValueError, r"shape \(3,\); give 42"),
    "a joint that does not exist": ({}, {"hold": ["wirst"]}, UnknownName, "wrist"),
    "gravity of one number": ({}, {"gravity": 9.81}, ValueError, "three numbers"),
    "gravity that is no number": ({}, {"gravity": (0.0, float("nan"), 0.0)}, ValueError, "three numbers"),
}


@pytest.mark.parametrize("bad", BAD)
def test_bad_input_is_named(hand, bad):
    contraction, more, error, text = BAD[bad]
    with pytest.raises(error, match=text):
        hl.settle(hand, contraction, **more)


def test_the_start_stays_as_it_was(hand):
    start = hl.pose(hand, {"mcp2.flexion_extension": 0.3})
    angle = start.angle.copy()
    hl.settle(hand, {"FDP2": 0.5}, start)
    with pytest.raises(ValueError):
        hl.settle(hand, {"FDP2": 5.0}, start)
    np.testing.assert_array_equal(start.angle, angle)


def test_a_joint_that_nothing_holds_rests_where_it_is_and_is_not_stable(hand):
    loose = hand.with_(stiffness=np.zeros(31))
    found = hl.settle(loose, {"LUM1": 0.3}, hold=["wrist"], look_for_others=False)
    assert not found.stable
    assert np.abs(found.unbalanced).max() < 1e-6


@pytest.mark.parametrize("start", ["relaxed", None])
def test_a_start_that_is_no_state_of_this_hand_is_refused(hand, start):
    good = hl.rest(hand)
    wrong = "relaxed" if start == "relaxed" else replace(good, angle=np.full(31, np.nan))
    with pytest.raises(ValueError, match="give a state of this hand"):
        hl.settle(hand, {}, wrong)
    with pytest.raises(ValueError, match="give a state of this hand"):
        hl.settle(hand, {}, replace(good, angle=np.zeros(30)))
