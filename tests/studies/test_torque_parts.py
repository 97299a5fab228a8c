"""The parts of a torque add up to what turns the joint, as the speed after a very short step shows."""

from dataclasses import replace

import numpy as np
import pytest

import handlab as hl
from handlab.simulation.laws import Laws
from handlab.studies.step_limits import moving_inertia
from handlab.studies.torque_parts import torque_parts, weight_torque

CONTRACTION = {"FDP2": 0.3, "DI1": 0.4, "EDC2": 0.2, "FCR": 0.3, "OPP": 0.2, "ODM": 0.5, "LUM1": 0.9}
POSTURE = {"mcp2.flexion_extension": 1.2, "mcp2.deviation": 0.06, "pip2.flexion_extension": 1.88, "wrist.flexion_extension": 0.9}
GRAVITY = (3.0, 9.0, -2.0)


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), GRAVITY])
def test_the_sum_is_the_torque_that_a_short_step_of_every_joint_shows(hand, gravity):
    """J omega / dt from rest: friction has not begun, every rotation by itself."""
    state = hl.pose(hand, {name: np.clip(value, *hand.dofs[name].limits) for name, value in POSTURE.items()})
    dt = 1e-8
    after = hl.step(hand, state, CONTRACTION, dt, laws=Laws(dynamics="decoupled", gravity=gravity))
    moving = [hand.dof_names.index(name) for name in hand.moving_names]
    shown = moving_inertia(hand, state) * after.speed[moving] / dt
    summed = [sum(part.torque for part in torque_parts(hand, state, CONTRACTION, name, gravity=gravity)) for name in hand.moving_names]
    assert np.abs(shown).max() > 0.05
    assert np.allclose(summed, shown, atol=2e-5, rtol=0.01)


def test_the_muscles_are_those_of_the_recorded_torque(hand):
    clip = hl.simulate(hand, CONTRACTION, seconds=0.2)
    for frame in (0, 6, 12):
        for name in ("wrist.deviation", "mcp2.flexion_extension", "cmc5.flexion_opposition"):
            parts = torque_parts(hand, clip.states[frame], clip.contraction[frame], name)
            muscles = sum(part.torque for part in parts if any(part.name == one.abbreviation for one in hand.muscles.values()))
            expected = hand.coupling[:, hand.moving_names.index(name)] @ clip.torque[frame]
            assert muscles == pytest.approx(expected, abs=1e-12)


def test_a_contraction_is_active_and_a_stretch_is_passive(hand):
    state = hl.pose(hand, {"wrist.flexion_extension": 1.0})
    parts = {part.name: part for part in torque_parts(hand, state, {"FDP2": 0.3}, "mcp2.flexion_extension")}
    assert parts["FDP2"].active > 0.01
    assert parts["FDP2"].passive == 0.0
    assert parts["EDC2"].active == 0.0
    assert parts["EDC2"].passive < -0.001, "the flexed wrist has stretched the extensor"


def test_friction_opposes_the_motion(hand):
    state = hl.rest(hand)
    speed = np.zeros(len(hand.dof_names))
    speed[hand.dof_names.index("pip3.flexion_extension")] = 4.0
    (part,) = [one for one in torque_parts(hand, replace(state, speed=speed), {}, "pip3.flexion_extension") if one.name == "friction"]
    k = hand.dof_names.index("pip3.flexion_extension")
    assert part.torque == pytest.approx(-4.0 * float(np.broadcast_to(hand.friction, len(hand.dof_names))[k]))


def test_the_weight_at_the_wrist_is_its_arm_times_the_mass_of_the_hand(hand):
    """With the hand flat and the palm down, the weight flexes the wrist: m g times the distance of the centre of mass."""
    state = hl.pose(hand, dict.fromkeys(hand.moving_names, 0.0))
    from handlab.simulation.skeleton import centres_of_mass

    mass = np.array([body.mass for body in hand.bodies.values()])
    mass[list(hand.bodies).index("forearm")] = 0.0
    dof = hand.dofs["wrist.flexion_extension"]
    centre = mass @ centres_of_mass(hand, state.angle) / mass.sum()
    arm = np.cross(dof.axis, centre - dof.anchor)
    expected = mass.sum() * 9.81 * arm[1]
    assert weight_torque(hand, state, dof.name, (0.0, 9.81, 0.0)) == pytest.approx(expected, rel=1e-6)
    assert 0.1 < expected < 0.5


def test_the_largest_part_comes_first_and_a_follower_is_refused(hand):
    sizes = [abs(part.torque) for part in torque_parts(hand, hl.pose(hand, POSTURE), CONTRACTION, "wrist.flexion_extension")]
    assert sizes == sorted(sizes, reverse=True)
    with pytest.raises(ValueError, match=r"mcp3\.flexion_extension"):
        torque_parts(hand, hl.rest(hand), {}, "mcp3.axial_rotation")
    with pytest.raises(KeyError, match="wrist"):
        torque_parts(hand, hl.rest(hand), {}, "wirst.deviation")
