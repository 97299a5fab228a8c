import numpy as np
import oracle
import pytest

from handlab.simulation import kinematics
from handlab.simulation.mechanics import coupled, mechanics, moments_of_inertia
from handlab.simulation.skeleton import centres_of_mass, rest


def random_angles(hand, rng, count):
    low, high = mechanics(hand).limits.T
    return coupled(hand, rng.uniform(low, high, (count, len(low))))


def test_every_body_stands_where_mujoco_puts_it(hand, rng):
    model = oracle.model(hand)
    free = rng.uniform(hand.limits[:, 0], hand.limits[:, 1], (20, len(hand.dof_names)))  # every angle by itself
    for angle in np.concatenate([free, random_angles(hand, rng, 20)]):
        data = oracle.at(model, hand, angle)
        for name, transform in zip(hand.body_names, kinematics.body_transforms(hand, angle), strict=True):
            body = data.body(name)
            np.testing.assert_allclose(transform[:3, :3], body.xmat.reshape(3, 3), atol=1e-9)
            np.testing.assert_allclose(transform[:3, 3], body.xpos, atol=1e-9)


def test_axes_and_anchors_stand_where_mujoco_puts_them(hand, rng):
    model = oracle.model(hand)
    angle = random_angles(hand, rng, 1)[0]
    data = oracle.at(model, hand, angle)
    axis, anchor = kinematics.posed_axes(hand, angle)
    for k, name in enumerate(hand.dof_names):
        np.testing.assert_allclose(axis[k], data.joint(name).xaxis, atol=1e-9)
        np.testing.assert_allclose(anchor[k], data.joint(name).xanchor, atol=1e-9)


def test_the_compiled_kinematics_are_the_readable_ones(hand, rng):
    for angle in random_angles(hand, rng, 5):
        np.testing.assert_allclose(kinematics.body_transforms(hand, angle), kinematics.body_transforms_readable(hand, angle), atol=1e-14)


def test_moments_of_inertia_are_the_diagonal_of_mujocos_mass_matrix(hand, rng):
    m = mechanics(hand)
    model = oracle.model(hand, (m.centre, m.inertia))
    for angle in [hand.zero, *random_angles(hand, rng, 10)]:
        data = oracle.at(model, hand, angle)
        expected = oracle.mass_matrix(model, data).diagonal()[oracle.address(model, hand)]
        np.testing.assert_allclose(moments_of_inertia(hand, angle), expected, rtol=1e-8)
        np.testing.assert_allclose(centres_of_mass(hand, angle), [data.body(name).xipos for name in hand.body_names], atol=1e-9)


def test_in_the_zero_posture_nothing_is_turned(hand):
    np.testing.assert_allclose(kinematics.body_transforms(hand, hand.zero), np.tile(np.eye(4), (len(hand.bodies), 1, 1)), atol=1e-15)


def test_in_the_bind_posture_bones_are_where_they_are_stored(hand):
    for name, bone in hand.bones.items():
        np.testing.assert_allclose(kinematics.posed_bone(hand, name, hand.bind), bone.points, atol=1e-12)


def test_bones_keep_their_shape_in_any_posture(hand, rng):
    angle = random_angles(hand, rng, 1)[0]
    for name, bone in hand.bones.items():
        moved = kinematics.posed_bone(hand, name, angle)
        pairs = rng.integers(0, len(moved), (2, 50))
        before, after = (np.linalg.norm(p[pairs[0]] - p[pairs[1]], axis=1) for p in (bone.points, moved))
        np.testing.assert_allclose(after, before, atol=1e-12)


def test_followers_follow(hand):
    angle = dict(zip(hand.dof_names, rest(hand).angle, strict=True))
    for name, dof in hand.dofs.items():
        if dof.driver is not None:
            assert angle[name] == pytest.approx(dof.ratio * angle[dof.driver] + dof.offset, abs=1e-12)


def test_an_unknown_bone_is_answered_with_the_nearest(hand):
    with pytest.raises(KeyError, match="capitate"):
        kinematics.posed_bone(hand, "capitatum", hand.zero)


def test_too_few_angles_are_refused(hand):
    with pytest.raises(ValueError, match="31 degrees of freedom"):
        kinematics.body_transforms(hand, np.zeros(23))


def test_a_broken_hierarchy_of_bodies_is_refused_by_name(hand):
    """A body before its parent, two that hang on each other, a joint or parent that does not exist; the hand that was there stays valid."""
    from dataclasses import replace

    bodies = dict(hand.bodies)
    first, second = "proximal_phalanx_2", "middle_phalanx_2"
    wrong = {
        f"{first!r} comes before its parent {second!r}": {**bodies, first: replace(bodies[first], parent=second)},
        "no body 'ulna'": {**bodies, first: replace(bodies[first], parent="ulna")},
        "no joint 'mcp9'": {**bodies, first: replace(bodies[first], joint="mcp9")},
    }
    for complaint, broken in wrong.items():
        with pytest.raises(ValueError, match=complaint):
            rest(hand.with_(bodies=broken))
    assert np.isfinite(rest(hand).angle).all()
