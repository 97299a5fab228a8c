import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handlab.anatomy.records import frozen
from handlab.simulation import skin_kernel
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skeleton import pose, rest
from handlab.simulation.skin import binding, blend, fine_points, normals, packed


def rigid(rng, count):
    transform = np.tile(np.eye(4), (count, 1, 1))
    transform[:, :3, :3] = Rotation.random(count, random_state=7).as_matrix()
    transform[:, :3, 3] = rng.normal(0, 0.05, (count, 3))
    return transform


def dual(points, index, weight, transform):
    quaternion, out = np.empty((len(transform), 8)), np.empty_like(points)
    skin_kernel.dual_quaternions(transform, quaternion)
    skin_kernel.blend_dual(points, index, weight, quaternion, out)
    return out


def product(a, b):
    """Product of quaternions w x y z."""
    w, v = a[0] * b[0] - a[1:] @ b[1:], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([w, *v])


def dual_by_algebra(point, weight, transform):
    """Dual quaternion blending written out with scipy's quaternions."""
    real, part, pivot = np.zeros(4), np.zeros(4), None
    for w, t in zip(weight, transform, strict=True):
        q = Rotation.from_matrix(t[:3, :3]).as_quat()[[3, 0, 1, 2]]
        pivot = q if pivot is None else pivot
        q = q if q @ pivot >= 0 else -q
        real, part = real + w * q, part + w * 0.5 * product(np.array([0.0, *t[:3, 3]]), q)
    length = np.linalg.norm(real)
    real, part = real / length, part / length
    shift = 2.0 * product(part, real * [1, -1, -1, -1])[1:]
    return Rotation.from_quat(real[[1, 2, 3, 0]]).apply(point) + shift


def test_a_point_of_one_body_moves_rigidly(rng):
    transform, points = rigid(rng, 19), rng.normal(size=(19, 3))
    index = np.array([[b, 0, 0, 0] for b in range(19)], np.uint32)
    weight = np.tile([1.0, 0, 0, 0], (19, 1))
    expected = np.einsum("bij,bj->bi", transform[:, :3, :3], points) + transform[:, :3, 3]
    linear = np.empty_like(points)
    skin_kernel.blend_linear(points, index, weight, transform, linear)
    np.testing.assert_allclose(dual(points, index, weight, transform), expected, atol=1e-12)
    np.testing.assert_allclose(linear, expected, atol=1e-12)


def test_dual_quaternions_blend_as_their_algebra_says(rng):
    transform, points = rigid(rng, 8), rng.normal(size=(200, 3))
    index = np.array([rng.permutation(8)[:4] for _ in points], np.uint32)
    weight = -np.sort(-rng.dirichlet(np.ones(4), len(points)), axis=1)
    expected = [dual_by_algebra(p, w, transform[i]) for p, w, i in zip(points, weight, index, strict=True)]
    np.testing.assert_allclose(dual(points, index, weight, transform), expected, atol=1e-9)


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 2, 3]])
@pytest.mark.parametrize("degrees", [10, 90, 179.9, 180, 181, 350])
def test_every_rotation_has_its_quaternion(axis, degrees):
    turn = Rotation.from_rotvec(np.deg2rad(degrees) * np.array(axis) / np.linalg.norm(axis))
    transform = np.eye(4)[None]
    transform[0, :3, :3] = turn.as_matrix()
    out = np.empty((1, 8))
    skin_kernel.dual_quaternions(transform, out)
    assert abs(out[0, :4] @ turn.as_quat()[[3, 0, 1, 2]]) == pytest.approx(1.0, abs=1e-12)
    assert np.linalg.norm(out[0, :4]) == pytest.approx(1.0, abs=1e-12)


def test_half_way_between_two_turns_about_one_axis_is_half_the_turn():
    """Where averaged matrices pull a twisted limb together, dual quaternions keep its girth."""
    transform = np.tile(np.eye(4), (2, 1, 1))
    transform[1, :3, :3] = Rotation.from_rotvec([np.pi / 2, 0, 0]).as_matrix()
    points, index = np.array([[0.0, 1.0, 0.0]]), np.array([[0, 1, 0, 0]], np.uint32)
    weight = np.array([[0.5, 0.5, 0, 0]])
    turned = dual(points, index, weight, transform)
    np.testing.assert_allclose(turned, [[0.0, np.sqrt(0.5), np.sqrt(0.5)]], atol=1e-12)
    linear = np.empty_like(points)
    skin_kernel.blend_linear(points, index, weight, transform, linear)
    assert np.linalg.norm(linear) == pytest.approx(np.sqrt(0.5))


def test_in_the_bind_posture_the_skin_is_where_it_is_stored(hand):
    for method in ("dual", "linear"):
        np.testing.assert_allclose(blend(hand, hand.bind, method=method), hand.skin.points, atol=1e-12)


def test_on_the_bind_posture_the_fine_skin_is_where_it_is_stored(hand):
    off = np.linalg.norm(fine_points(hand, hand.skin.points) - hand.skin_fine.points, axis=1)
    assert np.median(off) < 1e-6 and off.max() < 1e-4


def test_the_fine_skin_moves_rigidly_with_the_even_one(hand):
    turn = Rotation.from_rotvec([0.3, -0.7, 1.1])
    shift = np.array([0.1, -0.2, 0.05])
    moved = fine_points(hand, turn.apply(np.array(hand.skin.points)) + shift)
    np.testing.assert_allclose(moved, turn.apply(fine_points(hand, hand.skin.points)) + shift, atol=1e-7)  # 32-bit coordinates


def test_blended_points_are_what_the_matrices_say(hand):
    angle = pose(hand, {"mcp2.flexion_extension": 1.2, "wrist.flexion_extension": 0.8}).angle
    transform = relative_transforms(hand, angle)
    homogeneous = np.c_[hand.skin.points, np.ones(len(hand.skin.points))]
    expected = np.einsum("nb,bij,nj->ni", hand.skin.weights, transform[:, :3], homogeneous)
    np.testing.assert_allclose(blend(hand, angle, method="linear"), expected, atol=1e-9)


def test_the_heaviest_four_bodies_are_packed_and_add_to_1(rng):
    weights = rng.dirichlet(np.full(19, 0.2), 50)
    index, weight = packed(weights)
    np.testing.assert_allclose(weight.sum(axis=1), 1.0)
    assert np.all(np.diff(weight, axis=1) <= 0)
    np.testing.assert_array_equal(index[:, 0], weights.argmax(axis=1))


def test_the_reference_hand_has_no_more_than_four_bodies_to_a_point(hand):
    assert (hand.skin.weights > 0).sum(axis=1).max() <= 4
    assert binding(hand) is binding(hand)


def test_normals_of_a_sphere_point_outwards_and_are_weighted_by_area(hand):
    n = normals(hand, hand.skin.points)
    a, b, c = (hand.skin.points[hand.skin.faces[:, i]] for i in range(3))
    expected = np.zeros_like(n)
    for i in range(3):
        np.add.at(expected, hand.skin.faces[:, i], np.cross(b - a, c - a))
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(n, expected, atol=1e-9)
    bulk = hand.with_(skin=type(hand.skin)(frozen(hand.skin.points + 1e-4 * n), hand.skin.faces, hand.skin.weights))
    assert bulk.skin.volume > hand.skin.volume


def test_the_skin_keeps_up_with_the_bones(hand, rng):
    """No point of the skin is left behind: it stays as near to the nearest body as it was."""
    m = mechanics(hand)
    for _ in range(10):
        angle = coupled(hand, rng.uniform(*m.limits.T))
        skin = blend(hand, angle)
        assert np.isfinite(skin).all()
        edges = hand.skin.faces[:, [0, 1]]
        length = np.linalg.norm(skin[edges[:, 0]] - skin[edges[:, 1]], axis=1)
        assert length.max() < 0.06


def test_the_skin_of_the_relaxed_hand_cannot_be_changed(hand):
    with pytest.raises(ValueError, match="read-only"):
        rest(hand).skin[0] = 0.0


def test_an_unknown_method_and_a_skin_of_another_hand_are_refused(hand):
    with pytest.raises(ValueError, match="'dual'"):
        blend(hand, hand.bind, method="magic")
    with pytest.raises(ValueError, match="even skin"):
        fine_points(hand, np.zeros((7, 3)))


def off_the_cylinder(edge, radius=0.01):
    """How far the middle and a third of an edge around a cylinder are from it: as flat, and with what normals say."""
    turn = edge / radius
    around = np.array([[radius * np.cos(a), radius * np.sin(a), 0.0] for a in (0.0, turn)])
    points = frozen(np.concatenate([around, [[radius, 0.0, edge]]]))
    normal = points * [1.0, 1.0, 0.0] / radius
    share = frozen([[0.5, 0.5, 0.0], [1 / 3, 2 / 3, 0.0]])
    corners, sag = np.array([[0, 1, 2], [0, 1, 2]], np.uint32), np.empty(2)
    skin_kernel.sagitta(points, normal, corners, share, sag)
    between = share @ normal
    flat = share @ points
    return [np.abs(np.linalg.norm((flat + s[:, None] * between)[:, :2], axis=1) - radius) for s in (np.zeros(2), sag)]


def test_between_its_points_the_skin_is_as_round_as_its_normals_say():
    (flat, curved), (flat_half, curved_half) = off_the_cylinder(0.005), off_the_cylinder(0.0025)
    np.testing.assert_allclose(flat[0], 0.01 * (1 - np.cos(0.25)), rtol=1e-9)
    assert np.all(curved < 0.1 * flat)
    np.testing.assert_allclose(np.log2(flat / flat_half), 2.0, atol=0.1)
    np.testing.assert_allclose(np.log2(curved / curved_half), 4.0, atol=0.1)


def test_on_a_knuckle_the_fine_skin_bends_with_the_even_one_and_at_rest_it_is_where_it_was(hand):
    assert np.abs(fine_points(hand, hand.skin.points) - hand.skin_fine.points).max() < 1e-6
    bound, fine = binding(hand), hand.skin_fine
    bent = pose(hand, {f"pip{k}.flexion_extension": np.pi / 2 for k in range(2, 6)}).skin
    corner = bound.corners.astype(int)
    flat = np.einsum("ni,nid->nd", fine.barycentric, bent[corner] + fine.height[:, None, None] * normals(hand, bent)[corner])
    moved = np.linalg.norm(fine_points(hand, bent) - flat, axis=1)
    assert 0.0003 < moved.max() < 0.0015
    far = np.all(hand.skin.weights[corner, hand.body_names.index("forearm")] > 0.99, axis=1)
    assert far.sum() > 50 and moved[far].max() < 5e-5
