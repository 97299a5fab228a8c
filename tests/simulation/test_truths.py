"""What every hand does must come out of forces and lever arms, with nothing tuned for it. The wrist is held, unless said otherwise."""

from itertools import pairwise

import numpy as np
import pytest

import handlab as hl
from handlab.physics.muscle import active_force_length
from handlab.simulation.balance import tangent
from handlab.simulation.mechanics import mechanics
from handlab.simulation.skeleton import contraction_of

FINGERS = (2, 3, 4, 5)
JOINTS = ("mcp", "pip", "dip")
WEAK, SOME, FULL = 0.1, 0.3, 1.0
# Muscles and the finger that they move. The first dorsal interosseus inserts on bone, so it is not among them.
LUMBRICALS = {f"LUM{finger - 1}": finger for finger in FINGERS}
INTEROSSEI = {"DI2": 3, "DI3": 3, "DI4": 4, "PI1": 2, "PI2": 4, "PI3": 5}
DEEP = {f"FDP{finger}": finger for finger in FINGERS}
EXTENSORS = {f"EDC{finger}": finger for finger in FINGERS}
FLEXORS = [f"{name}{finger}" for name in ("FDP", "FDS") for finger in FINGERS]
FIST_DEG = {"mcp": 75.0, "pip": 95.0, "dip": 45.0}  # an assumption: what a closed hand shows


def columns(hand, finger):
    return [hand.dof_names.index(f"{joint}{finger}.flexion_extension") for joint in JOINTS]


def row(hand, muscle):
    return hand.muscle_names.index(hand.muscles[muscle].name)


def flexions(hand, contraction, finger, **more):
    """MCP, PIP and DIP flexion (3,) at rest, degrees."""
    angle = hl.settle(hand, contraction, hold=["wrist"], look_for_others=False, **more).state.angle
    return np.rad2deg(angle[columns(hand, finger)])


def change(hand, contraction, finger):
    return flexions(hand, contraction, finger) - np.rad2deg(hl.rest(hand).angle[columns(hand, finger)])


@pytest.mark.parametrize("much", [WEAK, SOME, FULL])
@pytest.mark.parametrize("muscle", [*LUMBRICALS, *INTEROSSEI])
def test_a_lumbrical_or_interosseus_alone_flexes_the_mcp_and_extends_pip_and_dip(hand, muscle, much):
    mcp, pip, dip = change(hand, {muscle: much}, {**LUMBRICALS, **INTEROSSEI}[muscle])
    assert mcp > 1.0
    assert pip < -0.3 and dip < -0.15
    assert pip < dip, "the PIP opens further than the DIP"


@pytest.mark.parametrize("muscle", [*LUMBRICALS, *INTEROSSEI])
def test_they_open_pip_and_dip_themselves_not_only_by_stretching_the_extensor(hand, muscle):
    """With the MCP held it cannot flex, and the extensor is not stretched by it."""
    finger = {**LUMBRICALS, **INTEROSSEI}[muscle]
    state = hl.settle(hand, {muscle: FULL}, hold=["wrist", f"mcp{finger}"], look_for_others=False).state
    mcp, pip, dip = np.rad2deg(state.angle - hl.rest(hand).angle)[columns(hand, finger)]
    assert mcp == pytest.approx(0.0, abs=1e-9)
    assert pip < -1.0 and dip < -0.4


def test_the_small_muscles_of_a_finger_make_the_duckbill_knuckle_bent_and_finger_nearly_straight(hand):
    for finger, muscles in {2: ["PI1", "LUM1"], 3: ["DI2", "DI3"], 4: ["DI4", "PI2"], 5: ["PI3", "LUM4"]}.items():
        mcp, pip, dip = flexions(hand, dict.fromkeys(muscles, FULL), finger)
        assert 60 < mcp < 92 and -2 < pip < 30 and -2 < dip < 12, finger


def test_the_first_dorsal_interosseus_inserts_on_bone_and_opens_little(hand):
    """Its arms at PIP and DIP are nothing; what opens there is the extensor that the bent knuckle stretches."""
    assert np.all(hand.lever_arm[row(hand, "DI1"), columns(hand, 2)[1:]] == 0.0)
    mcp, pip, _ = change(hand, {"DI1": FULL}, 2)
    assert mcp > 30.0 and -15.0 < pip < 0.0
    _, with_hood, _ = change(hand, {"DI2": FULL}, 3)
    assert with_hood < 3.0 * pip


@pytest.mark.parametrize("much", [0.02, WEAK, SOME, FULL])
@pytest.mark.parametrize("muscle", DEEP)
def test_the_deep_flexor_alone_flexes_all_three_joints(hand, muscle, much):
    assert change(hand, {muscle: much}, DEEP[muscle]).min() > (15.0 if much >= WEAK else 3.0)


@pytest.mark.parametrize("muscle", DEEP)
def test_the_deep_flexor_flexes_its_joints_together_not_one_after_another(hand, muscle):
    """All the time on the way each joint has gone at least a third of the share that another one has."""
    clip = hl.simulate(hand, {muscle: [(0, 0), (1, SOME), (3, SOME)]}, hold=["wrist"])
    angle = clip.angle[:, columns(hand, DEEP[muscle])]
    share = (angle - angle[0]) / (angle[-1] - angle[0])
    assert np.all(np.diff(share, axis=0) > -0.01), "none turns back"
    under_way = (share.max(axis=1) > 0.1) & (share.max(axis=1) < 0.95)
    assert under_way.sum() > 10
    assert np.all(share[under_way].min(axis=1) > share[under_way].max(axis=1) / 3.0)


@pytest.mark.parametrize("much", [WEAK, SOME, FULL])
@pytest.mark.parametrize("muscle", EXTENSORS)
def test_the_finger_extensor_alone_extends_the_mcp_most_and_leaves_the_pip_bent(hand, muscle, much):
    finger = EXTENSORS[muscle]
    by = change(hand, {muscle: much}, finger)
    assert by[0] < -10.0
    assert by[0] == by.min() and by[0] < 2.0 * by[1]
    assert 25.0 < flexions(hand, {muscle: much}, finger)[1] < 50.0


def test_with_its_knuckle_held_the_extensor_does_open_the_pip(hand):
    """Bouvier's test, at the middle finger: what it lacks alone is someone who keeps the MCP from giving way."""
    start = hl.pose(hand, {"mcp3.flexion_extension": np.deg2rad(40)})
    held = hl.settle(hand, {"EDC3": FULL}, start, hold=["wrist", "mcp3"], look_for_others=False).state.angle
    assert -2.0 < np.rad2deg(held[columns(hand, 3)[1]]) < 5.0
    assert flexions(hand, {"EDC3": FULL}, 3)[1] > 35.0


def of_finger(hand, finger):
    """Contraction (muscle,): 1 for every muscle that moves a finger."""
    return (np.abs(hand.lever_arm[:, columns(hand, finger)]).max(axis=1) > 0.0).astype(float)


def stiffness(hand, finger, contraction, *, flat=False, wrist_deg=-15.0):
    """(3, 3) N m/rad that an examiner feels who turns the joints of a finger a little; both others stay where they are."""
    angles = {f"{joint}{finger}.flexion_extension": 0.0 for joint in JOINTS} if flat else {}
    state = hl.pose(hand, angles | {"wrist.flexion_extension": np.deg2rad(wrist_deg)})
    k = [hand.moving_names.index(f"{joint}{finger}.flexion_extension") for joint in JOINTS]
    return -tangent(hand, state.angle, contraction)[np.ix_(k, k)]


@pytest.mark.parametrize("finger", FINGERS)
def test_co_contraction_stiffens_a_relaxed_finger_in_every_direction(hand, finger):
    every = of_finger(hand, finger)
    steps = [stiffness(hand, finger, much * every) for much in (0.0, 0.25, 0.5, 1.0)]
    for less, more in pairwise(steps):
        assert np.linalg.eigvalsh(more - less).min() > 0.0
    assert 4.0 < steps[-1][0, 0] / steps[0][0, 0] < 12.0


@pytest.mark.parametrize("finger", FINGERS)
def test_no_single_muscle_makes_a_relaxed_hand_softer(hand, finger):
    """At its rest length a fibre is on the rising side of its curve: 0.8 of its maximum force per rest length."""
    nothing = stiffness(hand, finger, np.zeros(42))
    for k in np.flatnonzero(of_finger(hand, finger)):
        alone = np.eye(42)[k]
        arm = hand.lever_arm[k, columns(hand, finger)]
        expected = 0.8 * hand.max_force[k] / hand.rest_length[k] * np.outer(arm, arm)
        np.testing.assert_allclose(stiffness(hand, finger, alone) - nothing, expected, atol=2e-5)


@pytest.mark.parametrize("finger", FINGERS)
def test_flexor_and_extensor_in_balance_at_the_knuckle_stiffen_it_and_a_weight_sinks_less(hand, finger):
    """The other joints are held. Measured by how far the weight of the finger turns its knuckle, palm down, without settle or tangent."""
    hold = [name for name in hand.moving_names if name != f"mcp{finger}.flexion_extension"]
    k = columns(hand, finger)[0]
    flexor, extensor = row(hand, f"FDP{finger}"), row(hand, f"EDC{finger}")
    full = hand.lever_arm[:, k] * hand.max_force * 0.96  # all fibres have their rest length
    both = np.zeros(42)
    both[extensor], both[flexor] = 1.0, -full[extensor] / full[flexor]
    assert 0.1 < both[flexor] < 0.9
    palm_down = hl.Laws(gravity=(0.0, 9.81, 0.0))
    sunk = []
    for contraction in (np.zeros(42), both):
        tracks = {"time": [0], **dict(zip(hand.muscle_names, contraction[:, None], strict=True))}
        clip = hl.simulate(hand, tracks, seconds=10, fps=1, hold=hold, start=hl.rest(hand), laws=palm_down)
        sunk.append(np.rad2deg(clip.angle[-1, k] - clip.angle[0, k]))
    assert sunk[0] > 0.5
    assert 0.2 < sunk[1] / sunk[0] < 0.85
    still = hl.settle(hand, both, hold=hold, look_for_others=False).state
    assert abs(np.rad2deg(still.angle[k] - hl.rest(hand).angle[k])) < 0.1, "it was in balance before the weight came"


def added_at_the_knuckle(hand, finger, wrist_deg):
    every = of_finger(hand, finger)
    flat = [stiffness(hand, finger, much * every, flat=True, wrist_deg=wrist_deg) for much in (0.0, 1.0)]
    return float((flat[1] - flat[0])[0, 0])


def test_in_the_flat_hand_the_fitted_curve_softens_the_knuckle_where_the_flexors_are_stretched(hand):
    """Measured, not asked for: beyond 1.1 of its rest length a fibre pulls less the more it is stretched.

    Fingers straight. With the wrist where it rests (15 degrees of extension) three of four knuckles get softer when all muscles of
    the finger contract, with 30 degrees all four; with a straight wrist most still get stiffer.
    """
    at_rest = {finger: added_at_the_knuckle(hand, finger, -15.0) for finger in FINGERS}
    extended = {finger: added_at_the_knuckle(hand, finger, -30.0) for finger in FINGERS}
    straight = {finger: added_at_the_knuckle(hand, finger, 0.0) for finger in FINGERS}
    assert [finger for finger, added in at_rest.items() if added < 0.0] == [3, 4, 5]
    assert max(extended.values()) < -0.01
    assert sum(added > 0.0 for added in straight.values()) == 3
    for finger in FINGERS:
        relaxed = stiffness(hand, finger, of_finger(hand, finger)) - stiffness(hand, finger, np.zeros(42))
        assert extended[finger] < at_rest[finger] < straight[finger] < relaxed[0, 0]


def test_with_fibres_at_rest_in_the_flat_hand_it_stiffens_there_too(hand):
    flat = hand.with_fibre_rest("flat")
    assert min(added_at_the_knuckle(flat, finger, -15.0) for finger in FINGERS) > 0.1


def fist(hand, share, wrist_deg):
    """A share of the way from the straight hand into the fist."""
    angles = {f"{joint}{finger}.flexion_extension": share * np.deg2rad(angle) for joint, angle in FIST_DEG.items() for finger in FINGERS}
    return hl.pose(hand, angles | {"wrist.flexion_extension": np.deg2rad(wrist_deg)})


def deep_activity(hand, state):
    """Active force over maximum force (4,) of the deep flexors at full contraction."""
    rows = [row(hand, muscle) for muscle in DEEP]
    return active_force_length(state.fibre_length[rows] / hand.rest_length[rows])


@pytest.mark.parametrize("wrist_deg", [0.0, -15.0])
def test_with_fibres_at_rest_in_the_flat_hand_the_deep_flexors_lose_their_force_before_the_fist_closes(hand, wrist_deg):
    flat = hand.with_fibre_rest("flat")
    assert np.all(deep_activity(flat, fist(flat, 1.0, wrist_deg)) == 0.0)
    assert np.all(deep_activity(flat, fist(flat, 0.8, wrist_deg)) > 0.0), "until four fifths of the way they do pull"
    assert np.all(deep_activity(hand, fist(hand, 1.0, wrist_deg)) > 0.2), "with the relaxed hand as posture of rest they never stop"


def test_the_flat_hand_as_posture_of_rest_cannot_close_its_fist(hand):
    """All eight flexors at full contraction, straight wrist: what is left open, and what is left of the force."""
    closed, force = {}, {}
    rows = [row(hand, muscle) for muscle in DEEP]
    for name, one in (("flat", hand.with_fibre_rest("flat")), ("relaxed", hand)):
        contraction = dict.fromkeys(FLEXORS, FULL)
        start = hl.pose(one, {"wrist.flexion_extension": 0.0})
        state = hl.settle(one, contraction, start, hold=["wrist"], look_for_others=False).state
        closed[name] = np.array([np.rad2deg(state.angle[columns(one, finger)].sum()) for finger in FINGERS])
        force[name] = float(deep_activity(one, state) @ one.max_force[rows])
    assert np.all(closed["flat"] < 175.0) and np.all(closed["relaxed"] > 215.0)
    assert 0.0 <= force["flat"] < 0.2 * force["relaxed"]


def grip(hand, wrist_deg):
    """(sum of flexions (4,) in degrees, force of the eight finger flexors in newtons) of the hardest fist, wrist held."""
    contraction = dict.fromkeys(FLEXORS, FULL)
    start = hl.pose(hand, {"wrist.flexion_extension": np.deg2rad(wrist_deg)})
    state = hl.settle(hand, contraction, start, hold=["wrist"], look_for_others=False).state
    active = contraction_of(hand, contraction) * active_force_length(state.fibre_length / hand.rest_length) * hand.max_force
    return np.array([np.rad2deg(state.angle[columns(hand, finger)].sum()) for finger in FINGERS]), float(active.sum())


def test_a_fist_with_a_flexed_wrist_is_weak_and_does_not_close(hand):
    """Active insufficiency: both the flexed wrist and the flexed fingers bring the ends of the same fibres together."""
    extended, straight, flexed = (grip(hand, wrist) for wrist in (-30.0, 0.0, 60.0))
    assert np.all(extended[0] > 260.0) and np.all(flexed[0] < 165.0)
    assert np.all(extended[0] > straight[0]) and np.all(straight[0] > flexed[0])
    assert 0.1 < flexed[1] / extended[1] < 0.4
    assert flexed[1] < straight[1] < extended[1]


def test_springs_and_stretched_fibres_hold_the_relaxed_hand_in_a_cascade(hand):
    """From index to little finger the fingers are more and more bent, and no joint of a moving hand is at its limit."""
    angle = hl.settle(hand, {}, hl.pose(hand, {"mcp3.flexion_extension": 1.2, "pip5.flexion_extension": 0.2})).state.angle
    sums = [np.rad2deg(angle[columns(hand, finger)].sum()) for finger in FINGERS]
    assert all(2.0 < later - earlier < 10.0 for earlier, later in pairwise(sums))
    y, limits = angle[mechanics(hand).moving], mechanics(hand).limits
    assert np.all(y > limits[:, 0]) and np.all(y < limits[:, 1])
