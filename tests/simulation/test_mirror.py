import numpy as np
import pytest

import handlab
from handlab.anatomy.mirror import mirrored
from handlab.simulation.kinematics import body_transforms, posed_bone
from handlab.simulation.mechanics import coupled, mechanics, moments_of_inertia
from handlab.simulation.play import simulate
from handlab.simulation.skin import blend, fine_points

FLIP = np.array([1.0, 1.0, -1.0])


@pytest.fixture(scope="module")
def left(hand):
    return mirrored(hand)


def test_mirrored_twice_is_the_same_hand_to_the_last_bit(hand, left):
    again = mirrored(left)
    assert (left.side, again.side) == ("left", "right")
    for name in ("points", "faces", "weights"):
        np.testing.assert_array_equal(getattr(again.skin, name), getattr(hand.skin, name))
    for name in ("points", "faces", "texture", "triangle", "barycentric", "height"):
        np.testing.assert_array_equal(getattr(again.skin_fine, name), getattr(hand.skin_fine, name))
    for name, bone in hand.bones.items():
        np.testing.assert_array_equal(again.bones[name].points, bone.points)
        np.testing.assert_array_equal(again.bones[name].faces, bone.faces)
    for name, dof in hand.dofs.items():
        np.testing.assert_array_equal(again.dofs[name].axis, dof.axis)
        np.testing.assert_array_equal(again.dofs[name].anchor, dof.anchor)
    for name, body in hand.bodies.items():
        np.testing.assert_array_equal(again.bodies[name].inertia, body.inertia)
        np.testing.assert_array_equal(again.bodies[name].centre, body.centre)


def test_at_equal_angles_every_point_is_the_mirror_image(hand, left, rng):
    m = mechanics(hand)
    for _ in range(5):
        angle = coupled(hand, rng.uniform(*m.limits.T))
        flip = np.diag([*FLIP, 1.0])
        np.testing.assert_allclose(body_transforms(left, angle), flip @ body_transforms(hand, angle) @ flip, atol=1e-14)
        for name in hand.bones:
            np.testing.assert_allclose(posed_bone(left, name, angle), posed_bone(hand, name, angle) * FLIP, atol=1e-14)
        skin = blend(hand, angle)
        np.testing.assert_allclose(blend(left, angle), skin * FLIP, atol=1e-14)
        np.testing.assert_allclose(fine_points(left, skin * FLIP), fine_points(hand, skin) * FLIP, atol=1e-14)
        np.testing.assert_allclose(moments_of_inertia(left, angle), moments_of_inertia(hand, angle), rtol=1e-10)


def test_meshes_of_the_left_hand_face_outwards(hand, left):
    assert left.skin.volume == pytest.approx(hand.skin.volume, rel=1e-12) and left.skin.volume > 0
    assert left.skin_fine.volume == pytest.approx(hand.skin_fine.volume, rel=1e-12)
    for name, bone in left.bones.items():
        assert bone.volume == pytest.approx(hand.bones[name].volume, rel=1e-9) and bone.volume > 0


def test_equal_contractions_move_both_hands_alike(hand, left):
    tracks = {"FDP2": [(0, 0), (0.5, 1)], "FCU": [(0, 0.5), (0.5, 0)], "OPP": 0.7}
    np.testing.assert_allclose(simulate(left, tracks).angle, simulate(hand, tracks).angle, atol=1e-9)


def test_anatomy_stays_what_it_is(hand, left):
    np.testing.assert_array_equal(left.lever_arm, hand.lever_arm)
    assert left.feature_points == hand.feature_points
    assert "bone" in repr(left.bones)
    assert left.muscles["FDP2"] is hand.muscles["FDP2"]
    with pytest.raises(KeyError, match="did you mean"):
        left.bones["metacarpal_9"]


def test_radial_is_towards_the_thumb_in_both_hands(hand, left):
    for side in (hand, left):
        angle = np.array(side.zero)
        angle[side.dof_names.index("wrist.deviation")] = 0.2
        finger, thumb = (side.joints[name].centre for name in ("mcp3", "cmc1"))
        moved = (body_transforms(side, angle)[side.body_names.index("carpus")] @ [*finger, 1.0])[:3] - finger
        assert moved[2] * thumb[2] > 0.0


def test_the_left_hand_can_be_loaded():
    assert handlab.load_hand(side="left").side == "left"
