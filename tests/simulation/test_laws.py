"""Which law is meant by which name, and where the printed ones fail."""

import numpy as np
import pytest

import handlab
from handlab.simulation.dynamics import bias
from handlab.simulation.inertia_tables import from_tables
from handlab.simulation.laws import SOUND, SUBSTEP, Laws
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skeleton import integrate, rest, step

SOME = {"FDP2": 0.3, "EDC3": 0.2, "ECRB": 0.4, "APB": 0.5, "DI1": 0.2}


def alone(hand, name):
    """Everything held but one coordinate."""
    held = np.ones(len(hand.moving_names), dtype=bool)
    held[hand.moving_names.index(name)] = False
    return held


def test_the_default_is_coupled_without_gravity():
    assert Laws() == SOUND and SOUND.dynamics == "coupled" and SOUND.gravity == (0.0, 0.0, 0.0) and SOUND.substep == SUBSTEP


def test_the_papers_laws_have_one_name():
    laws = Laws.printed()
    assert (laws.dynamics, laws.force, laws.friction, laws.inertia) == ("decoupled", "printed", "printed", "nearest table")


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"dynamics": "couple"}, "coupled"),
        ({"friction": "none"}, "friction"),
        ({"inertia": "rod"}, "inertia"),
        ({"force": "strong"}, "force"),
    ],
)
def test_an_unknown_law_is_answered_with_those_there_are(changes, complaint):
    with pytest.raises(KeyError, match=complaint):
        Laws(**changes)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"friction": "printed"}, "need dynamics='decoupled'"),
        ({"inertia": "table"}, "need dynamics='decoupled'"),
        ({"gravity": 9.81}, "three numbers"),
        ({"gravity": (0, 9.81)}, "three numbers"),
        ({"gravity": (0, float("nan"), 0)}, "three numbers"),
        ({"substep": 0.0}, "substep"),
        ({"substep": -1e-3}, "substep"),
        ({"substep": 0.1}, "substep"),
        ({"substep": float("nan")}, "substep"),
    ],
)
def test_laws_that_cannot_be_are_refused(changes, complaint):
    with pytest.raises(ValueError, match=complaint):
        Laws(**changes)


def test_explicit_and_implicit_friction_agree_where_both_are_stable(hand):
    ends = {}
    for friction in ("implicit", "explicit"):
        laws = Laws(dynamics="decoupled", friction=friction, substep=5e-6)
        ends[friction] = step(hand, rest(hand), SOME, 0.1, laws=laws).angle
    assert np.rad2deg(np.abs(ends["implicit"] - ends["explicit"])).max() < 0.02
    assert np.rad2deg(np.abs(ends["explicit"] - rest(hand).angle)).max() > 10.0


@pytest.mark.parametrize("name", ["dip2.flexion_extension", "dip5.flexion_extension", "pip3.flexion_extension", "mcp2.flexion_extension"])
def test_the_explicit_step_explodes_where_theory_says(hand, name):
    """dt > 2 J / mu: two percent below it a push dies away, two percent above it every step throws the bone back harder."""
    bare = hand.without_passive().with_newton_per_percent(1e-9)
    m, k, held = mechanics(bare), bare.moving_names.index(name), alone(bare, name)
    limit = 2.0 * from_tables(bare, m.rest_y)[k] / m.friction[k]
    for share, grows in ((0.98, False), (1.02, True)):
        speed = np.zeros(len(m.rest_y))
        speed[k] = 1e-6
        laws = Laws(dynamics="decoupled", friction="explicit", inertia="table", substep=share * limit)
        path = integrate(bare, m.rest_y, speed, np.zeros((200, 42)), share * limit, held, laws)[1][:, k]
        assert np.all(path[1:10] * path[:9] < 0.0)  # back and forth
        assert (abs(path[-1]) > 50.0 * abs(path[0])) if grows else (abs(path[-1]) < abs(path[0]) / 50.0)


def test_at_60_hertz_the_printed_hand_is_thrown_from_limit_to_limit_and_the_sound_one_is_not(hand):
    printed = handlab.load_hand(reading="printed")
    states = {"printed": rest(printed), "sound": rest(hand)}
    turned = {"printed": [], "sound": []}
    for _ in range(30):
        for name, one, laws in (("printed", printed, Laws.printed(1 / 60)), ("sound", hand, SOUND)):
            before = states[name].angle
            states[name] = step(one, states[name], {"FDP2": 0.2}, 1 / 60, laws=laws)
            turned[name].append(np.rad2deg(np.abs(states[name].angle - before)).max())
    assert max(turned["printed"][10:]) > 60.0  # degrees in a sixtieth of a second, again and again
    assert max(turned["sound"][10:]) < 5.0


def test_printed_friction_pushes_a_bone_on_that_turns_against_its_muscle(hand):
    """From 5 rad/s of extension under a steady flexing torque: the sound law turns it back at once, the printed one speeds it up."""
    bare = hand.without_passive()
    name = "mcp2.flexion_extension"
    m, k, held = mechanics(bare), bare.moving_names.index(name), alone(bare, name)
    y, speed = np.array(m.rest_y), np.zeros(len(m.rest_y))
    speed[k] = -5.0
    contraction = np.zeros((400, 42))
    contraction[:, bare.muscle_names.index(bare.muscles["FDS2"].name)] = 0.05
    after = {}
    for friction in ("explicit", "printed"):
        laws = Laws(dynamics="decoupled", friction=friction, substep=1e-5)
        after[friction] = integrate(bare, y, speed, contraction, 1e-5, held, laws)[1][-1, k]
    assert after["explicit"] > -2.0
    assert after["printed"] < -5.0


def test_friction_never_adds_power_but_the_printed_one_does(hand, rng):
    from handlab.physics.torque import friction_opposing, friction_printed

    torque, speed = rng.normal(size=1000), rng.normal(size=1000)
    assert np.all((friction_opposing(torque, speed, 0.015) - torque) * speed <= 0.0)
    assert np.any((friction_printed(torque, speed, 0.015) - torque) * speed > 0.0)


def test_a_fibre_pushes_only_in_the_printed_reading(hand):
    """Below 0.6 of its rest length the fitted curve is negative: the flexor would straighten the finger."""
    flat = hand.with_fibre_rest("flat").without_passive()
    start = handlab.pose(flat, {"mcp2.flexion_extension": 1.5, "pip2.flexion_extension": 1.8, "dip2.flexion_extension": 1.3})
    after = {}
    for force in ("sound", "printed"):
        after[force] = step(flat, start, {"FDP2": 1.0}, 0.01, hold=["wrist"], laws=Laws(dynamics="decoupled", force=force))
    k = flat.dof_names.index("dip2.flexion_extension")
    assert after["printed"].speed[k] < after["sound"].speed[k] - 1.0


@pytest.mark.parametrize("dynamics", ["coupled", "decoupled"])
def test_a_limp_hand_falls_the_way_gravity_points(hand, dynamics):
    """Palm up and no muscle: fingers bend over backwards, palm down they close; the weight of the hand moves the wrist."""
    limp = hand.with_newton_per_percent(1e-6).with_(stiffness=1e-4 * hand.stiffness)
    fingers = [limp.dof_names.index(f"mcp{k}.flexion_extension") for k in range(2, 6)]
    ends = {}
    for way in (1.0, -1.0):
        laws = Laws(dynamics=dynamics, gravity=(0.0, 9.81 * way, 0.0))
        ends[way] = step(limp, rest(limp), {}, 1.0, hold=["wrist"], laws=laws).angle
        wrist = step(limp, rest(limp), {}, 0.2, laws=laws).angle[0] - rest(limp).angle[0]
        assert np.sign(wrist) == way
    assert np.all(ends[1.0][fingers] > ends[-1.0][fingers] + np.deg2rad(8))


def test_gravity_is_the_slope_of_height(hand, rng):
    from handlab.simulation.skeleton import centres_of_mass

    m, gravity = mechanics(hand), np.array([2.0, -5.0, 7.0])
    y = rng.uniform(*m.limits.T)

    def height(v):
        return -float(m.mass @ centres_of_mass(hand, coupled(hand, v)) @ gravity)

    slope = [(height(y + 1e-6 * e) - height(y - 1e-6 * e)) / 2e-6 for e in np.eye(len(y))]
    np.testing.assert_allclose(bias(hand, coupled(hand, y), np.zeros(31), gravity), slope, atol=1e-7)


def test_tables_and_tensors_show_the_same_clip_within_a_degree(hand):
    clips = {}
    for inertia in ("tensor", "table", "nearest table"):
        clips[inertia] = handlab.simulate(hand, "fist", laws=Laws(dynamics="decoupled", inertia=inertia))
    for inertia in ("table", "nearest table"):
        off = np.rad2deg(np.abs(clips[inertia].angle - clips["tensor"].angle)).max()
        assert 0.0 < off < 1.0
