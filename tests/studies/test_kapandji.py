"""The Kapandji score: how far round the hand the thumb's pulp reaches."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

import handlab
from handlab.anatomy.records import frozen
from handlab.simulation.kinematics import posed_axes
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.skeleton import rest
from handlab.simulation.skin import blend
from handlab.studies.kapandji import AT_EASE, HELP_AT_MOST, SOFT, THUMB, WITHIN, kapandji, places
from handlab.studies.measures import pulps

pytestmark = pytest.mark.xdist_group("kapandji")


@pytest.fixture(scope="module")
def hand():
    return handlab.load_hand()


@pytest.fixture(scope="module")
def found(hand):
    return kapandji(hand)


def with_limits(hand, **degrees):
    """The same hand with other limits of some degrees of freedom, by name with __ for the dot."""
    wanted = {name.replace("__", "."): np.deg2rad(pair) for name, pair in degrees.items()}
    joints = {
        name: replace(joint, dofs=tuple(replace(dof, limits=frozen(wanted.get(dof.name, dof.limits))) for dof in joint.dofs))
        for name, joint in hand.joints.items()
    }
    return hand.with_(joints=hand.joints.with_items(joints))


def surface(hand, skin, triangles):
    return pv.make_tri_mesh(np.array(skin), hand.skin.faces[triangles])


def test_the_thumb_of_the_reference_hand_reaches_all_ten_places(found):
    assert found.score == 10
    assert [stage.number for stage in found.stages] == list(range(1, 11))
    for stage in found.stages:
        assert stage.reached
        assert 0.0 <= stage.distance <= WITHIN
        assert stage.depth <= SOFT


def test_what_is_reported_is_where_the_pulp_is(hand, found):
    """Distance to the place measured again by VTK."""
    for stage, place in zip(found.stages, places(hand), strict=True):
        skin = blend(hand, stage.angle)
        pulp = surface(hand, skin, np.flatnonzero(np.isin(hand.skin.faces, pulps(hand)[1]).all(axis=1)))
        _, nearest = pulp.find_closest_cell(skin[place.points], return_closest_point=True)
        assert np.linalg.norm(nearest - skin[place.points], axis=1).min() == pytest.approx(stage.distance, abs=2e-6)


def test_every_joint_stays_inside_its_limits_and_followers_follow(hand, found):
    for stage in found.stages:
        assert np.all(stage.angle >= hand.limits[:, 0] - 1e-9)
        assert np.all(stage.angle <= hand.limits[:, 1] + 1e-9)
        np.testing.assert_allclose(coupled(hand, stage.angle[mechanics(hand).moving]), stage.angle, atol=1e-12)


def test_only_the_thumb_the_finger_that_helps_and_the_hollow_of_the_palm_move(hand, found):
    for stage, place in zip(found.stages, places(hand), strict=True):
        for name, angle, relaxed in zip(hand.dof_names, np.rad2deg(stage.angle), np.rad2deg(rest(hand).angle), strict=True):
            joint, kind = name.split(".")
            if name in THUMB or joint in ("cmc1", "cmc4", "cmc5") or kind == "axial_rotation":
                continue
            if kind == "flexion_extension" and joint[:3] in AT_EASE:
                if joint[3] != str(place.finger):
                    assert angle == pytest.approx(AT_EASE[joint[:3]])
                elif not place.comes:
                    assert -1e-6 <= angle <= HELP_AT_MOST[joint[:3]] + 1e-6
            else:
                assert angle == pytest.approx(relaxed, abs=1e-9)


def test_the_places_lie_where_anatomy_says(hand):
    """Bind posture, x distal, y palmar, z radial, against joint centres: which side, and in which order along the finger."""
    skin, (_, anchor) = hand.skin.points, posed_axes(hand, hand.bind)
    centre = {name.split(".")[0]: anchor[k] for k, name in enumerate(hand.dof_names) if name.endswith("flexion_extension")}
    at = [skin[place.points].mean(axis=0) for place in places(hand)]
    for k, (near, far) in enumerate((("mcp2", "pip2"), ("pip2", "dip2"))):
        middle = (centre[near] + centre[far]) / 2
        assert 0.004 < at[k][2] - middle[2] < 0.014  # radial of the bone, on the skin
        assert abs(at[k] - middle)[:2].max() < 0.006
    for k in range(4):
        finger = k + 2
        assert np.linalg.norm(at[2 + k] - centre[f"dip{finger}"]) > 0.010
        along = centre[f"dip{finger}"] - centre[f"pip{finger}"]
        assert (at[2 + k] - centre[f"dip{finger}"]) @ along > 0.0
    for k, joint in ((6, "dip5"), (7, "pip5"), (9, "mcp5")):
        assert at[k][1] - centre[joint][1] > 0.003  # palmar
        assert np.linalg.norm(at[k] - centre[joint]) < 0.025
    assert 0.25 < (at[8] - centre["mcp5"])[0] / (centre["pip5"] - centre["mcp5"])[0] < 0.75  # the base crease lies beyond the joint
    assert np.all(np.diff([place[0] for place in at[5:]]) < -0.003)  # tip, creases, palm: ever more proximal


def test_the_left_hand_scores_as_the_right(hand, found):
    left = kapandji(handlab.load_hand(side="left"))
    assert left.score == found.score
    for one, other in zip(left.stages, found.stages, strict=True):
        assert one.distance == pytest.approx(other.distance, abs=5e-4)


@pytest.mark.parametrize(
    ("flexion", "abduction", "least", "most"),
    [(15.0, 0.0, 4, 6), (10.0, 45.0, 6, 8)],
    ids=["no abduction", "little flexion"],
)
def test_a_thumb_whose_saddle_joint_moves_less_reaches_fewer_places(hand, flexion, abduction, least, most):
    """The fingers still come to meet it; the base of the little finger and the palm stay out of reach."""
    stiff = with_limits(hand, cmc1__flexion_opposition=(-20.0, flexion), cmc1__abduction_adduction=(-7.0, abduction))
    result = kapandji(stiff)
    assert least <= sum(stage.reached for stage in result.stages) <= most
    assert result.score < 10
    assert not result.stages[9].reached and 0.010 < result.stages[9].distance < 0.030


def test_a_thumb_fused_at_every_joint_reaches_little(hand):
    fused = with_limits(
        hand,
        cmc1__flexion_opposition=(-15.0, -14.0),
        cmc1__abduction_adduction=(10.0, 11.0),
        mcp1__flexion_extension=(-1.0, 0.0),
        ip1__flexion_extension=(0.0, 1.0),
    )
    result = kapandji(fused)
    assert result.score <= 1
    assert result.stages[9].distance > 0.020


def test_the_score_stops_at_the_first_place_that_is_missed(found):
    missed = replace(found, stages=tuple(replace(stage, reached=stage.number != 4) for stage in found.stages))
    assert missed.score == 3
    assert replace(found, stages=found.stages[:0]).score == 0


def test_progress_rises_to_1(hand):
    seen = []
    kapandji(hand, progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1.0 and len(seen) == 10
