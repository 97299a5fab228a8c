"""The hand as a MuJoCo model: what a user gets."""

import re
import subprocess
import sys
from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

from handlab.anatomy.mirror import mirrored
from handlab.anatomy.named import Named
from handlab.physics.muscle import active_force_length, passive_force_length
from handlab.simulation.kinematics import body_transforms, posed_axes, posed_bone
from handlab.simulation.mechanics import coupled, fibre_lengths, mechanics
from handlab.simulation.mjcf_meshes import fine_weights
from handlab.simulation.skeleton import centres_of_mass, integrate
from handlab.simulation.to_mjcf import DIFFERENCES, to_mjcf


@pytest.fixture(scope="module")
def text(hand):
    return to_mjcf(hand)


@pytest.fixture(scope="module")
def model(text):
    return mujoco.MjModel.from_xml_string(text)


def column(model, hand):
    """Where each degree of freedom stands in MuJoCo's vectors."""
    return np.array([model.joint(name).dofadr[0] for name in hand.dof_names])


def at(model, hand, angle, speed=None, ctrl=None):
    """Data of the model in a posture."""
    data = mujoco.MjData(model)
    data.qpos[column(model, hand)] = angle
    data.qvel[column(model, hand)] = 0.0 if speed is None else speed
    data.ctrl[:] = 0.0 if ctrl is None else ctrl
    mujoco.mj_forward(model, data)
    return data


def posture(hand, rng):
    return coupled(hand, rng.uniform(*mechanics(hand).limits.T))


def names(model, kind, count):
    return tuple(mujoco.mj_id2name(model, kind, k) for k in range(count))


def test_every_part_bears_its_name(hand, model):
    kind = mujoco.mjtObj
    assert names(model, kind.mjOBJ_BODY, model.nbody)[1:] == hand.body_names
    assert sorted(names(model, kind.mjOBJ_JOINT, model.njnt)) == sorted(hand.dof_names)
    assert names(model, kind.mjOBJ_ACTUATOR, model.nu) == hand.muscle_names
    assert names(model, kind.mjOBJ_TENDON, 42) == hand.muscle_names
    assert names(model, kind.mjOBJ_MESH, model.nmesh) == tuple(hand.bones)
    assert model.nskin == 1 and model.neq == sum(dof.driver is not None for dof in hand.dofs.values()) == 8


def test_the_file_needs_no_other_file_and_says_what_differs(text):
    root = ElementTree.fromstring(text)
    assert not [element.tag for element in root.iter() if "file" in element.attrib]
    assert len(text) < 1_500_000
    words = re.sub(r"\s+", " ", text)
    assert all(difference in words for difference in DIFFERENCES)


def test_bodies_are_where_their_joints_are(hand, model, rng):
    for _ in range(3):
        angle = posture(hand, rng)
        data, moved = at(model, hand, angle), body_transforms(hand, angle)
        for row, (name, body) in enumerate(hand.bodies.items()):
            centre = np.zeros(3) if body.joint is None else hand.joints[body.joint].centre
            np.testing.assert_allclose(data.body(name).xpos, moved[row, :3, :3] @ centre + moved[row, :3, 3], atol=1e-12)
            np.testing.assert_allclose(data.body(name).xmat.reshape(3, 3), moved[row, :3, :3], atol=1e-12)
        np.testing.assert_allclose(data.xipos[1:], centres_of_mass(hand, angle), atol=1e-12)


def test_mass_matrix_and_weight_are_those_of_rigid_bodies_on_their_axes(hand, model, rng):
    """Independent: sum of m Jv'Jv + Jw'I Jw over bodies, with the geometric Jacobian of the posed axes."""
    gravity = rng.normal(0, 9, 3)
    heavy = mujoco.MjModel.from_xml_string(to_mjcf(hand, gravity=gravity, laws=False, bones=False, skin=False))
    carriers = {}
    for name, body in hand.bodies.items():
        own = [] if body.joint is None else [hand.dof_names.index(dof.name) for dof in hand.joints[body.joint].dofs]
        carriers[name] = own + (carriers[body.parent] if body.parent else [])
    for _ in range(3):
        angle = posture(hand, rng)
        (axis, anchor), turn, centre = posed_axes(hand, angle), body_transforms(hand, angle)[:, :3, :3], centres_of_mass(hand, angle)
        mass, weight = np.zeros((31, 31)), np.zeros(31)
        for row, (name, body) in enumerate(hand.bodies.items()):
            spin, slide = np.zeros((3, 31)), np.zeros((3, 31))
            for k in carriers[name]:
                spin[:, k], slide[:, k] = axis[k], np.cross(axis[k], centre[row] - anchor[k])
            inertia = turn[row] @ mechanics(hand).inertia[row] @ turn[row].T
            mass += body.mass * slide.T @ slide + spin.T @ inertia @ spin
            weight += body.mass * gravity @ slide
        data, order = at(heavy, hand, angle), column(heavy, hand)
        found = np.empty((31, 31))
        mujoco.mj_fullM(heavy, data, found)
        np.testing.assert_allclose(found[np.ix_(order, order)], mass, atol=1e-12 * mass.max())
        np.testing.assert_allclose(data.qfrc_bias[order], -weight, atol=1e-12 * np.abs(weight).max())


def test_a_tendon_shortens_as_its_fibre_does(hand, model, rng):
    one, other = posture(hand, rng), posture(hand, rng)
    shorter = at(model, hand, one).ten_length[:42] - at(model, hand, other).ten_length[:42]
    np.testing.assert_allclose(shorter, fibre_lengths(hand, one) - fibre_lengths(hand, other), atol=1e-14)


def test_without_laws_an_actuator_pulls_with_its_control_in_newtons(hand, rng):
    bare = mujoco.MjModel.from_xml_string(to_mjcf(hand, laws=False, bones=False, skin=False))
    assert (bare.neq, bare.ntendon, bare.nmesh, bare.nskin) == (0, 42, 0, 0)
    assert not bare.jnt_limited.any() and not bare.dof_damping.any() and not bare.jnt_stiffness.any()
    force = rng.uniform(0, 100, 42)
    data = at(bare, hand, posture(hand, rng), ctrl=force)
    np.testing.assert_allclose(data.qfrc_actuator[column(bare, hand)], hand.lever_arm.T @ force, atol=1e-12)
    assert not data.qfrc_passive.any()


def test_a_muscle_of_the_model_pulls_as_ours_from_0_75_to_1_45_and_no_stronger_than_0_18_too_much_outside(hand, model, rng):
    too_much = []
    for _ in range(200):
        angle, contraction = posture(hand, rng), rng.uniform(0.1, 1.0, 42)
        ratio = fibre_lengths(hand, angle) / hand.rest_length
        data = at(model, hand, angle, speed=rng.normal(0, 20, 31), ctrl=contraction)
        active = -data.actuator_force / hand.max_force / contraction
        exact = (ratio > 0.75) & (ratio < 1.45)
        np.testing.assert_allclose(active[exact], active_force_length(ratio[exact]), atol=1e-6)
        too_much += list((active - active_force_length(ratio))[~exact])
    assert len(too_much) > 500
    assert min(too_much) > -1e-6
    assert 0.15 < max(too_much) < 0.18


def test_springs_are_ours_capsules_included(hand, rng):
    """At rest, without contraction: stiffness, capsules and stretched fibres, for a hand without collateral ligaments."""
    plain = hand.with_(collateral={})
    model, m = mujoco.MjModel.from_xml_string(to_mjcf(plain, bones=False, skin=False)), mechanics(plain)
    for _ in range(20):
        y = rng.uniform(*m.limits.T)
        angle = coupled(plain, y)
        low = np.maximum(0.0, 1.0 + (m.limits[:, 0] - y) / m.width)
        high = np.maximum(0.0, 1.0 + (y - m.limits[:, 1]) / m.width)
        capsule = m.torque_at_limit[:, 0] * low**3 - m.torque_at_limit[:, 1] * high**3
        stretched = passive_force_length(fibre_lengths(plain, angle) / plain.rest_length) * plain.max_force
        expected = m.arm.T @ stretched + capsule - m.stiffness * (y - m.relaxed)
        found = plain.coupling.T @ at(model, plain, angle).qfrc_passive[column(model, plain)]
        np.testing.assert_allclose(found, expected, atol=1e-9)


def test_friction_opposes_the_motion(hand, model, rng):
    speed = rng.normal(0, 5, 31)
    slow, fast = (at(model, hand, coupled(hand, mechanics(hand).relaxed), s).qfrc_passive for s in (None, speed))
    np.testing.assert_allclose((fast - slow)[column(model, hand)], -np.broadcast_to(hand.friction, 31) * speed, atol=1e-12)


@pytest.fixture(scope="module")
def violent(hand, model):
    """Half a second of half of all muscles at full contraction, three times: angles (3, steps, dof)."""
    rng, order, paths = np.random.default_rng(7), column(model, hand), []
    for _ in range(3):
        path = []
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        data.ctrl[:] = rng.uniform(size=42) < 0.5
        for _ in range(round(0.5 / model.opt.timestep)):
            mujoco.mj_step(model, data)
            path.append(data.qpos[order])
        assert not any(warning.number for warning in data.warning)
        paths.append(path)
    return np.array(paths)


def test_limits_are_stiff(hand, violent):
    y, limits = violent[..., mechanics(hand).moving], mechanics(hand).limits
    beyond = np.rad2deg(np.maximum(limits[:, 0] - y, y - limits[:, 1]).max())
    assert 0.0 < beyond < 1.0


def test_followers_follow_within_a_degree_and_soon_within_a_fiftieth(hand, model, violent):
    lag = np.rad2deg(np.abs(violent - coupled(hand, violent[..., mechanics(hand).moving])).max(axis=(0, 2)))
    assert 0.1 < lag.max() < 1.0
    assert 1e-5 < lag[round(0.05 / model.opt.timestep) :].max() < 0.02


def test_flexion_narrows_the_range_of_deviation(hand, model):
    """A finger bent by 90 degrees and pushed aside stays within a quarter of the range of a straight one, and a degree."""
    data, flexion, deviation = mujoco.MjData(model), model.joint("mcp2.flexion_extension"), model.joint("mcp2.deviation")
    reached = {}
    for degrees in (0.0, 90.0):
        mujoco.mj_resetDataKeyframe(model, data, 0)
        for _ in range(2500):
            data.qfrc_applied[flexion.dofadr[0]] = 20.0 * (np.deg2rad(degrees) - data.qpos[flexion.qposadr[0]])
            data.qfrc_applied[deviation.dofadr[0]] = 0.5
            mujoco.mj_step(model, data)
        reached[degrees] = float(np.rad2deg(data.qpos[deviation.qposadr[0]]))
    assert 14.5 < reached[0.0] < 16.0
    assert 2.5 < reached[90.0] < 4.75


def test_weak_muscles_move_the_model_as_they_move_ours(hand, rng):
    """One second against ``integrate``: without collateral ligaments the laws are the same in the middle of all ranges."""
    plain = hand.with_(collateral={})
    model, m = mujoco.MjModel.from_xml_string(to_mjcf(plain, bones=False, skin=False)), mechanics(plain)
    steps = round(1.0 / model.opt.timestep)
    rise = np.sin(np.linspace(0, np.pi / 2, steps)) ** 2
    contraction = rise[:, None] * rng.uniform(0.0, 0.05, 42)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    order, found = column(model, plain), []
    for now in contraction:
        data.ctrl[:] = now
        mujoco.mj_step(model, data)
        found.append(data.qpos[order])
    ours, _ = integrate(plain, m.rest_y, np.zeros(23), contraction, model.opt.timestep, np.zeros(23, dtype=bool))
    apart = np.rad2deg(np.abs(np.array(found) - coupled(plain, ours[1:])).max())
    assert np.rad2deg(np.abs(ours[-1] - m.rest_y).max()) > 5.0
    assert 1e-6 < apart < 0.05


def test_bones_are_where_ours_are(hand, model, rng):
    angle = posture(hand, rng)
    data = at(model, hand, angle)
    for name in hand.bones:
        geom, mesh = data.geom(name), model.mesh(name)
        points = model.mesh_vert[mesh.vertadr[0] : mesh.vertadr[0] + mesh.vertnum[0]]
        posed = points @ geom.xmat.reshape(3, 3).T + geom.xpos
        np.testing.assert_allclose(posed, posed_bone(hand, name, angle), atol=2e-7)
    assert not model.geom_contype.any() and not model.geom_conaffinity.any()


def test_the_skin_follows_the_bodies_by_the_weights_of_the_skin_under_it(hand, model, rng):
    """MuJoCo's skin from its own arrays, against averaged matrices."""
    angle = posture(hand, rng)
    data = at(model, hand, angle)
    shown = np.zeros(hand.skin_fine.points.shape)
    for k, body in enumerate(model.skin_bonebodyid):
        start, count = model.skin_bonevertadr[k], model.skin_bonevertnum[k]
        vertex, weight = model.skin_bonevertid[start : start + count], model.skin_bonevertweight[start : start + count]
        bound = np.empty(9)
        mujoco.mju_quat2Mat(bound, model.skin_bonebindquat[k].astype(float))
        local = (model.skin_vert[vertex] - model.skin_bonebindpos[k]) @ bound.reshape(3, 3)
        shown[vertex] += weight[:, None] * (local @ data.xmat[body].reshape(3, 3).T + data.xpos[body])
    moved = body_transforms(hand, angle) @ np.linalg.inv(body_transforms(hand, hand.bind))
    points = np.c_[hand.skin_fine.points, np.ones(len(shown))]
    expected = np.einsum("nb,bij,nj->ni", fine_weights(hand), moved[:, :3], points)
    np.testing.assert_allclose(shown, expected, atol=2e-6)
    np.testing.assert_allclose(fine_weights(hand).sum(axis=1), 1.0, atol=1e-12)


def test_the_key_frame_is_the_hand_at_rest(hand, model):
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("relaxed").id)
    np.testing.assert_allclose(data.qpos[column(model, hand)], coupled(hand, mechanics(hand).relaxed), atol=1e-14)
    for _ in range(500):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.qpos[column(model, hand)], coupled(hand, mechanics(hand).relaxed), atol=np.deg2rad(0.1))


def test_a_left_hand_and_a_printed_one_can_be_exported(hand):
    import handlab

    for other in (mirrored(hand), handlab.load_hand(reading="printed")):
        model = mujoco.MjModel.from_xml_string(to_mjcf(other))
        data = mujoco.MjData(model)
        for _ in range(100):
            mujoco.mj_step(model, data)
        assert not any(warning.number for warning in data.warning)


def test_what_mujoco_cannot_hold_is_refused_by_name(hand):
    def with_body(**changes):
        return hand.with_(bodies=Named("body", {**hand.bodies, "carpus": replace(hand.bodies["carpus"], **changes)}))

    with pytest.raises(ValueError, match=r"carpus.*mass"):
        to_mjcf(with_body(mass=0.0))
    with pytest.raises(ValueError, match=r"carpus.*no solid body"):
        to_mjcf(with_body(inertia=np.diag([1e-5, 1e-5, 3e-5])))
    idle = Named("muscle", {**hand.muscles, "opponens_pollicis": replace(hand.muscles["opponens_pollicis"], lever_arms=())})
    with pytest.raises(ValueError, match=r"opponens_pollicis.*lever arm"):
        to_mjcf(hand.with_(muscles=idle))
    for gravity in ((0, 9.81), "down", (0, np.nan, 0)):
        with pytest.raises(ValueError, match="gravity is"):
            to_mjcf(hand, gravity=gravity)
    with pytest.raises(TypeError, match=r"clip\.hand"):
        to_mjcf("hand")


PICTURE = """
import sys, mujoco, numpy
model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, 0)
mujoco.mj_forward(model, data)
for camera in ("palm", "back"):
    with mujoco.Renderer(model, 240, 240) as renderer:
        renderer.update_scene(data, camera=camera)
        picture = renderer.render().astype(float)
        renderer.enable_segmentation_rendering()
        renderer.update_scene(data, camera=camera)
        kind = renderer.render()[..., 1]
    skin = kind == int(mujoco.mjtObj.mjOBJ_SKIN)
    rows, columns = numpy.nonzero(skin)
    colour = picture[skin].mean(axis=0)
    print(skin.mean(), numpy.ptp(rows), numpy.ptp(columns), *colour)
"""


def test_the_hand_fills_the_picture_of_both_cameras(text, tmp_path):
    """In a process of its own: drawing needs EGL or a screen."""
    (tmp_path / "hand.xml").write_text(text)
    code = [sys.executable, "-c", PICTURE, str(tmp_path / "hand.xml")]
    done = subprocess.run(code, capture_output=True, text=True, cwd=tmp_path, env={"MUJOCO_GL": "egl"}, timeout=120)
    if done.returncode:
        pytest.skip(f"MuJoCo cannot draw here: {done.stderr.strip().splitlines()[-1:]}")
    for line in done.stdout.splitlines():
        share, tall, wide, red, _, blue = map(float, line.split())
        assert 0.1 < share < 0.6 and 140 < tall < 236 and 60 < wide < 200
        assert red > blue + 20  # skin, not bone
