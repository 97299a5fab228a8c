import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import handlab
from handlab.physics.ligament import between, capsule_slope, capsule_torque, collateral_energy, spring_torque
from handlab.physics.muscle import muscle_force
from handlab.simulation import skeleton
from handlab.simulation.balance import settled
from handlab.simulation.dynamics import bias, energy, mass_matrix, passive_torque
from handlab.simulation.laws import SUBSTEP, Laws
from handlab.simulation.mechanics import coupled, fibre_lengths, mechanics, moments_of_inertia
from handlab.simulation.skeleton import held_coordinates, integrate, pose, rest, state_at, step, substeps_of

DT = 1 / 60


def readable_torque(hand, y, contraction):
    """Torque, slope, drag and stops (moving,) from the functions of ``handlab.physics`` alone."""
    m = mechanics(hand)
    ratio = fibre_lengths(hand, coupled(hand, y)) / hand.rest_length
    torque = hand.coupling.T @ (hand.lever_arm.T @ muscle_force(contraction, ratio, hand.max_force))
    flexion = np.where(m.tightened_by >= 0, y[m.tightened_by], 0.0)
    left, stiffness = between(1.0, m.range_fraction, flexion), m.stiffness * between(1.0, m.stiffness_factor, flexion)
    bounds = left * m.limits[:, 0], left * m.limits[:, 1], left * m.width, *m.torque_at_limit.T
    torque += spring_torque(stiffness, y, m.relaxed) + capsule_torque(y, *bounds)
    for k in np.flatnonzero(m.tightened_by >= 0):  # flexion stretches what it tightens
        ligament = m.stiffness[k], m.stiffness_factor, m.range_fraction
        rest = y[k], m.relaxed[k], *m.limits[k], m.width[k], *m.torque_at_limit[k]
        f, h = m.tightened_by[k], 1e-5
        torque[f] -= (collateral_energy(*ligament, y[f] + h, *rest) - collateral_energy(*ligament, y[f] - h, *rest)) / (2 * h)
    slope = capsule_slope(y, *bounds)
    stops = left[:, None] * m.limits + m.hard_stop * np.array([-1.0, 1.0])
    return torque, stiffness + slope, m.friction + m.time * slope, stops


def readable_advance(hand, y, speed, contraction, dt, held, laws):
    """One substep, away from hard stops."""
    torque, slope, drag, _ = readable_torque(hand, y, contraction)
    angle = coupled(hand, y)
    if laws.dynamics == "coupled":
        mass, force = mass_matrix(hand, angle), torque - bias(hand, angle, hand.coupling @ speed, laws.gravity)
    else:
        mass = np.diag((hand.coupling**2).T @ moments_of_inertia(hand, angle))
        force = torque - bias(hand, angle, np.zeros(31), laws.gravity)
    free = np.flatnonzero(~held)
    end = drag + dt * slope
    change = np.linalg.solve((mass + dt * np.diag(end))[np.ix_(free, free)], dt * (force - end * speed)[free])
    speed = np.where(held, 0.0, speed)
    speed[free] += change
    return y + dt * speed, speed


@pytest.mark.parametrize("dynamics", ["coupled", "decoupled"])
@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), (3.0, 9.0, -2.0)])
def test_the_compiled_step_is_the_readable_laws(hand, rng, dynamics, gravity):
    m, laws, dt = mechanics(hand), Laws(dynamics=dynamics, gravity=gravity), 1e-4
    for trial in range(30):
        y = rng.uniform(*m.limits.T)
        held = rng.uniform(size=len(y)) < 0.2 * (trial % 2)
        speed = np.where(held, 0.0, rng.normal(0, 2, len(y)))
        y[m.tightened_by >= 0] *= 0.3  # inside the stops of a flexed joint
        contraction = rng.uniform(size=42)
        path_y, path_speed = integrate(hand, y, speed, contraction[None], dt, held, laws)
        expected_y, expected_speed = readable_advance(hand, y, speed, contraction, dt, held, laws)
        np.testing.assert_allclose(path_y[1], expected_y, atol=1e-9)
        np.testing.assert_allclose(path_speed[1], expected_speed, rtol=1e-7, atol=1e-6)


def test_at_rest_every_fibre_has_its_rest_length_and_nothing_moves(hand):
    state = rest(hand)
    np.testing.assert_allclose(state.fibre_length, hand.rest_length, atol=1e-15)
    later = step(hand, state, {}, 1.0)
    np.testing.assert_allclose(later.angle, state.angle, atol=1e-12)
    np.testing.assert_allclose(later.speed, 0.0, atol=1e-12)


def test_the_relaxed_hand_is_a_cascade_from_index_to_little_finger(hand):
    angle = dict(zip(hand.dof_names, rest(hand).angle, strict=True))
    for joint in ("mcp", "pip", "dip"):
        flexion = [angle[f"{joint}{finger}.flexion_extension"] for finger in range(2, 6)]
        assert np.all(np.diff(flexion) > 0)


def test_a_step_returns_another_state_and_leaves_the_old_one(hand):
    state = rest(hand)
    before = [np.array(x) for x in (state.angle, state.speed, state.fibre_length, state.skin)]
    later = step(hand, state, {"FDP2": 0.4}, DT)
    assert later is not state
    for old, now in zip(before, (state.angle, state.speed, state.fibre_length, state.skin), strict=True):
        np.testing.assert_array_equal(old, now)
    assert later.time == pytest.approx(DT)
    with pytest.raises(ValueError, match="read-only"):
        later.angle[0] = 1.0


def test_a_step_taken_twice_is_the_same_step(hand):
    state = rest(hand)
    np.testing.assert_array_equal(step(hand, state, {"FDP2": 0.4}, DT).angle, step(hand, state, {"FDP2": 0.4}, DT).angle)


def test_names_abbreviations_and_arrays_mean_the_same_contraction(hand):
    state = rest(hand)
    values = np.zeros(42)
    values[hand.muscle_names.index("flexor_digitorum_profundus_index")] = 0.4
    expected = step(hand, state, values, DT).angle
    for contraction in ({"FDP2": 0.4}, {"fdp2": 0.4}, {"flexor_digitorum_profundus_index": 0.4}):
        np.testing.assert_array_equal(step(hand, state, contraction, DT).angle, expected)


def test_fibres_follow_the_angles_without_drift(hand):
    state = rest(hand)
    for k in range(60):
        state = step(hand, state, {"FDP2": 0.5 + 0.5 * np.sin(k), "EDC2": 0.3}, DT)
    np.testing.assert_allclose(state.fibre_length, hand.rest_length - hand.lever_arm @ (state.angle - rest(hand).angle), atol=1e-15)


def test_muscle_work_is_joint_work(hand, rng):
    """Virtual work: force times shortening of all fibres equals torque times turning."""
    state = rest(hand)
    force = rng.uniform(0, 50, 42)
    turn = 1e-3 * hand.coupling @ rng.normal(size=hand.coupling.shape[1])
    shortening = fibre_lengths(hand, state.angle) - fibre_lengths(hand, state.angle + turn)
    assert np.dot(force, shortening) == pytest.approx(np.dot(hand.lever_arm.T @ force, turn), rel=1e-9)


@pytest.mark.parametrize("dt", [1 / 60, 1 / 30, 0.1, 1.0])
def test_large_steps_are_stable_and_show_the_same_motion(hand, dt):
    contraction = {"FDP2": 0.8, "FDS3": 0.6, "FCR": 0.9, "EPL": 1.0}
    coarse = fine = rest(hand)
    for _ in range(round(1.0 / dt)):
        coarse = step(hand, coarse, contraction, dt)
    for _ in range(1000):
        fine = step(hand, fine, contraction, 1e-3)
    assert np.rad2deg(np.abs(coarse.angle - fine.angle)).max() < 0.5


@pytest.mark.parametrize("dynamics", ["coupled", "decoupled"])
def test_10000_random_contractions_and_steps_leave_every_joint_finite_and_within_2_degrees_of_its_limits(hand, rng, dynamics):
    """Steps between 0.1 ms and 1/30 s, gravity from everywhere."""
    m, held = mechanics(hand), np.zeros(23, dtype=bool)
    y, speed, worst = np.array(m.rest_y), np.zeros(23), -np.inf
    for trial in range(10_000):
        contraction = rng.uniform(size=42) * (rng.uniform(size=42) < rng.uniform())
        dt = 10.0 ** rng.uniform(-4, np.log10(1 / 30))
        laws = Laws(dynamics=dynamics, gravity=tuple(9.81 * rng.normal(size=3)) if trial % 2 else (0.0, 0.0, 0.0))
        n = substeps_of(dt, laws)
        path_y, path_speed = integrate(hand, y, speed, np.tile(contraction, (n, 1)), dt / n, held, laws)
        y, speed = path_y[-1], path_speed[-1]
        assert np.isfinite(path_y).all() and np.isfinite(path_speed).all()
        worst = max(worst, np.max(m.limits[:, 0] - path_y), np.max(path_y - m.limits[:, 1]))
    assert 0.0 < np.rad2deg(worst) <= 2.0 + 1e-9


def test_every_joint_is_back_within_5_degrees_one_second_after_any_single_muscle(hand):
    home = rest(hand).angle
    for muscle in hand.muscle_names:
        relaxed = settled(hand, {}, start=settled(hand, {muscle: 1.0}), seconds=1.0)
        off = np.rad2deg(np.abs(relaxed.angle - home))
        assert off.max() < 5.0, f"{muscle}: {hand.dof_names[off.argmax()]} is {off.max():.1f} degrees off"


@pytest.mark.parametrize("dynamics", ["coupled", "decoupled"])
@pytest.mark.parametrize("side", [0, 1])
def test_a_joint_thrown_into_its_capsule_neither_passes_it_nor_bounces(hand, dynamics, side):
    """At 15 rad/s, all others held: at most 2 degrees past the limit, and out again with less than a quarter of the speed.

    The muscles are taken away: their stretched fibres would throw the joint back. So are the springs, but for the capsule.
    """
    hand = hand.with_newton_per_percent(1e-9).with_(stiffness=np.zeros(31))
    m, sign = mechanics(hand), 2 * side - 1
    for k, name in enumerate(hand.moving_names):
        held = np.ones(23, dtype=bool)
        held[k] = False
        y, speed = np.array(m.rest_y), np.zeros(23)
        y[k], speed[k] = m.limits[k, side] - sign * m.width[k], 15.0 * sign
        path, rate = integrate(hand, y, speed, np.zeros((1200, 42)), SUBSTEP, held, Laws(dynamics=dynamics))
        assert np.max(sign * (path[:, k] - m.limits[k, side])) <= np.deg2rad(2.0) + 1e-12, name
        assert np.max(-sign * rate[:, k]) < 0.25 * 15.0, name


def test_two_degrees_past_a_limit_a_capsule_holds_all_muscles_of_its_joint(hand):
    """Between 1.2 and 1.5 times as much as they can pull, or a floor of 0.05 N m at the limit."""
    m = mechanics(hand)
    pull = m.arm * m.max_force[:, None]
    strongest = np.stack([-np.minimum(pull, 0.0).sum(axis=0), np.maximum(pull, 0.0).sum(axis=0)], axis=1)
    holds = m.torque_at_limit * (1.0 + np.deg2rad(2.0) / m.width[:, None]) ** 3
    floor = m.torque_at_limit <= 0.05
    assert np.all(holds >= 1.2 * strongest)
    assert np.all((holds <= 1.5 * strongest) | floor)


def test_in_a_fist_a_finger_cannot_be_spread(hand):
    """Collateral ligaments: at 90 degrees of flexion a quarter of the range, and no more."""
    k = hand.dof_names.index("mcp2.deviation")
    spread = {muscle: 1.0 for muscle, row in zip(hand.muscle_names, hand.lever_arm, strict=True) if row[k] > 0}
    reached = []
    for flexion in (0.0, 90.0):
        start = pose(hand, {"mcp2.flexion_extension": np.deg2rad(flexion)})
        state = settled(hand, spread, start=start, hold=["wrist", "mcp2.flexion_extension", "pip2", "dip2"])
        reached.append(np.rad2deg(state.angle[k]))
    assert reached[0] == pytest.approx(np.rad2deg(hand.limits[k, 1]), abs=2.0)
    assert 0.0 < reached[1] <= 0.25 * np.rad2deg(hand.limits[k, 1]) + 2.0


def test_hyperextension_does_not_soften_the_collateral_ligaments(hand):
    m = mechanics(hand)
    assert float(between(1.0, m.stiffness_factor, np.deg2rad(-30))) == 1.0
    assert m.stiffness_factor >= 5.0
    assert 0.0 < m.range_fraction <= 0.25


def stored(hand, state, gravity=(0.0, 0.0, 0.0)):
    """Energy of motion, springs, capsules, ligaments, height and stretched fibres, J."""
    stretch = np.maximum(0.0, state.fibre_length / hand.rest_length - 1.0)
    return sum(energy(hand, state, gravity)) + np.sum(2.77 / 3.0 * stretch**3 * hand.max_force * hand.rest_length)


@pytest.mark.parametrize("dynamics", ["coupled", "decoupled"])
def test_a_relaxed_hand_never_gains_energy(hand, rng, dynamics):
    m = mechanics(hand)
    held, laws = np.zeros(len(m.rest_y), dtype=bool), Laws(dynamics=dynamics)
    for _ in range(10):
        y = rng.uniform(*m.limits.T)
        y[m.tightened_by >= 0] *= m.range_fraction
        path, speed = integrate(hand, y, np.zeros(len(y)), np.zeros((2400, 42)), SUBSTEP, held, laws)
        energies = np.array([stored(hand, state_at(hand, path[k], speed[k], 0.0)) for k in range(0, 2401, 40)])
        assert energies.max() <= energies[0] * 1.02 + 1e-9
        assert energies[-1] < 0.05 * energies[0] + 1e-6


def test_held_joints_keep_their_angle(hand):
    state = rest(hand)
    held = settled(hand, {"FCR": 1.0, "FDP2": 1.0}, hold=["wrist", "mcp2"])
    for name in ("wrist.flexion_extension", "wrist.deviation", "mcp2.flexion_extension", "mcp2.deviation", "mcp2.axial_rotation"):
        k = hand.dof_names.index(name)
        assert held.angle[k] == state.angle[k]
    k = hand.dof_names.index("pip2.flexion_extension")
    assert np.rad2deg(held.angle[k] - state.angle[k]) > 20.0


def test_a_held_joint_keeps_an_angle_that_is_not_that_of_rest(hand):
    start = pose(hand, {"wrist.flexion_extension": 0.5})
    assert settled(hand, {"ECRB": 1.0}, start=start, hold="wrist").angle[0] == 0.5


def test_holding_a_follower_holds_its_driver(hand):
    for follower, driver in (("cmc4", "cmc5.flexion_opposition"), ("mcp5.axial_rotation", "mcp5.flexion_extension")):
        held = held_coordinates(hand, [follower])
        assert [hand.moving_names[k] for k in np.flatnonzero(held)] == [driver]


def test_an_unknown_joint_to_hold_is_answered_with_the_nearest(hand):
    with pytest.raises(KeyError, match=r"'wirst'.*wrist"):
        step(hand, rest(hand), {}, DT, hold=["wirst"])


def test_a_contraction_of_1_4_is_refused_by_name(hand):
    with pytest.raises(ValueError, match=r"^contraction of 'lumbrical_1' is 1\.4; contraction values lie between 0 and 1$"):
        step(hand, rest(hand), {"lumbrical_1": 1.4}, DT)


@pytest.mark.parametrize("value", [float("nan"), -0.1, float("inf")])
def test_contractions_that_are_none_are_refused(hand, value):
    with pytest.raises(ValueError, match="lie between 0 and 1"):
        step(hand, rest(hand), {"FDP2": value}, DT)
    with pytest.raises(ValueError, match="lie between 0 and 1"):
        step(hand, rest(hand), np.full(42, value), DT)


def test_a_contraction_that_is_no_number_is_refused(hand):
    with pytest.raises(ValueError, match="give a number"):
        step(hand, rest(hand), {"FDP2": "much"}, DT)


def test_an_unknown_muscle_is_answered_with_three(hand):
    with pytest.raises(KeyError, match=r"'FDP9'.*flexor_digitorum_profundus\w+, \w+ or \w+"):
        step(hand, rest(hand), {"FDP9": 0.4}, DT)


def test_one_muscle_under_two_names_is_refused(hand):
    with pytest.raises(ValueError, match="same muscle"):
        step(hand, rest(hand), {"FDP2": 0.4, "flexor_digitorum_profundus_index": 0.2}, DT)


def test_too_few_contractions_are_refused(hand):
    with pytest.raises(ValueError, match="42"):
        step(hand, rest(hand), np.zeros(41), DT)


@pytest.mark.parametrize("dt", [0.0, -1.0, float("nan"), float("inf"), "soon"])
def test_a_step_of_no_length_is_refused(hand, dt):
    with pytest.raises(ValueError, match="dt is"):
        step(hand, rest(hand), {}, dt)


def test_a_pose_sets_angles_and_lets_followers_follow(hand):
    state = pose(hand, {"mcp5.flexion_extension": np.deg2rad(60), "cmc5.flexion_opposition": np.deg2rad(20)})
    angle = dict(zip(hand.dof_names, np.rad2deg(state.angle), strict=True))
    assert angle["mcp5.flexion_extension"] == pytest.approx(60.0)
    assert angle["mcp5.axial_rotation"] == pytest.approx(-6.0)
    assert angle["cmc4.flexion_opposition"] == pytest.approx(10.0)
    assert angle["cmc4.axial_rotation"] == pytest.approx(-8.0)


def test_a_pose_of_a_follower_names_what_it_follows(hand):
    with pytest.raises(ValueError, match=r"follows 'mcp5\.flexion_extension'"):
        pose(hand, {"mcp5.axial_rotation": 0.1})


def test_a_pose_beyond_a_limit_is_refused(hand):
    with pytest.raises(ValueError, match="limits"):
        pose(hand, {"pip2.flexion_extension": 3.0})
    with pytest.raises(ValueError, match="limits"):
        pose(hand, {"pip2.flexion_extension": float("nan")})


def test_twice_the_newtons_per_percent_make_every_muscle_twice_as_strong(hand):
    strong = hand.with_newton_per_percent(2 * hand.newton_per_percent)
    np.testing.assert_allclose(mechanics(strong).max_force, 2 * mechanics(hand).max_force)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.floats(0, 1), st.integers(0, 41), st.floats(1e-4, 0.3))
def test_any_single_contraction_moves_the_hand_within_its_limits(hand, contraction, muscle, dt):
    values = np.zeros(42)
    values[muscle] = contraction
    angle = step(hand, rest(hand), values, dt).angle
    assert np.all(angle >= hand.limits[:, 0] - np.deg2rad(2.01)) and np.all(angle <= hand.limits[:, 1] + np.deg2rad(2.01))


def test_inertia_is_renewed_often_enough(hand, rng, monkeypatch):
    """Refreshing it at every substep changes a lively motion by less than a degree."""
    m = mechanics(hand)
    contraction = np.repeat(np.clip(rng.normal(0.1, 0.3, (12, 42)), 0, 1), 200, axis=0)
    held = np.zeros(len(m.rest_y), dtype=bool)
    paths = []
    for every in (1, skeleton.INERTIA_EVERY):
        monkeypatch.setattr(skeleton, "INERTIA_EVERY", every)
        paths.append(integrate(hand, m.rest_y, np.zeros(len(m.rest_y)), contraction, SUBSTEP, held, Laws(dynamics="decoupled"))[0])
    assert np.rad2deg(np.abs(paths[0] - paths[1])).max() < 1.0


def test_the_printed_reading_stays_finite_and_does_not_come_back_by_itself():
    """Without joint stiffness nothing but stretched fibres brings a joint back."""
    printed = handlab.load_hand(reading="printed")
    np.testing.assert_allclose(rest(printed).fibre_length, printed.rest_length, atol=1e-15)
    bent = settled(printed, {"FDP2": 1.0}, hold=["wrist"])
    assert np.isfinite(bent.angle).all()
    k = printed.dof_names.index("pip2.flexion_extension")
    relaxed = settled(printed, {}, start=bent, hold=["wrist"], seconds=1.0)
    assert np.rad2deg(relaxed.angle[k] - rest(printed).angle[k]) > 5.0
    assert np.all(passive_torque(printed, relaxed.angle) == 0.0)
