"""Tendons as tubes: whose they are, where they run, that they follow the bones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import minimum_filter

import handlab as hl
from handlab.physics.distance import closest, winding
from handlab.simulation.kinematics import posed_bone, relative_transforms
from handlab.simulation.skin import blend
from handlab.simulation.tendon_balls import MARGIN, none
from handlab.simulation.tendons import ENDING, courses, laid, tendons


@pytest.fixture(scope="module")
def fist(hand):
    return hl.simulate(hand, hl.keyframes("fist")).angle[-1]


def named(tubes):
    return {tube.name: tube for tube in tubes}


def test_every_muscle_of_the_forearm_has_a_tendon(hand):
    drawn = {tube.muscle for tube in tendons(hand, hand.bind)}
    assert drawn == {name for name, muscle in hand.muscles.items() if muscle.group == "extrinsic"}
    assert len(drawn) == 24


def test_a_tendon_has_as_many_points_in_every_pose(hand, fist):
    for one, other in zip(tendons(hand, hand.bind), tendons(hand, fist), strict=True):
        assert one.points.shape == other.points.shape
        assert np.all(np.isfinite(other.points))
        assert one.radius == other.radius


@pytest.mark.parametrize("posture", ["bind", "fist"])
def test_tendons_run_below_the_skin(hand, fist, posture):
    angle = hand.bind if posture == "bind" else fist
    skin = np.ascontiguousarray(blend(hand, angle)[hand.skin.faces])
    for tube in tendons(hand, angle):
        points = np.ascontiguousarray(tube.points[2:-5])
        outside = points[winding(points, skin) < 0.5]
        assert len(outside) == 0 or closest(np.ascontiguousarray(outside), skin)[0].max() < 1.5e-3, tube.name


def above_bone(hand, angle, points):
    """How far points are from bone by its triangles, less than nothing inside."""
    bones = np.ascontiguousarray(np.concatenate([posed_bone(hand, name, angle)[bone.faces] for name, bone in hand.bones.items()]))
    return np.where(winding(points, bones) > 0.5, -1.0, 1.0) * closest(points, bones)[0]


@pytest.mark.parametrize(
    ("clip", "share"), [("fist", 1.0), ("opposition-little", 1.0), ("wave", 0.55), ("thumbs-up", 1.0), ("spread", 1.0)]
)
def test_a_tendon_keeps_its_own_radius_outside_bone_and_is_lifted_no_further_than_that(hand, clip, share):
    """But for its end, which goes into bone; beside it and in the grooves of the wrist a tube may graze bone."""
    played = hl.simulate(hand, hl.keyframes(clip), fps=10)
    angle = played.angle[round(share * (len(played.time) - 1))]
    moved = relative_transforms(hand, angle)
    tight, freed = [], []
    for course, tube in zip(courses(hand), tendons(hand, angle), strict=True):
        bare = laid(replace(course, balls=none()), moved)
        rows = slice(0, len(bare) - ENDING)
        before, after = (above_bone(hand, angle, np.ascontiguousarray(line[rows])) - course.radius for line in (bare, tube.points))
        assert after.min() > -0.9e-3 and after.min() + course.radius > 0.0, course.name
        assert np.mean(after < -0.25e-3) < 0.06, course.name
        far = np.linalg.norm(tube.points - bare, axis=1)[rows]
        free = minimum_filter(before, size=9) > MARGIN  # nothing near, nor beside it
        freed.append(far[free])
        tight.append(after[far > 0.5e-3])
        assert far.max() < 6e-3 and far.max() < 2.5 * np.maximum(-before, 0.0).max() + 1.5e-3, course.name
    assert np.concatenate(freed).max() < 1e-4
    assert np.concatenate(tight).min() < 2e-4 and np.median(np.concatenate(tight)) < 0.8e-3


def test_via_points_ride_on_their_bodies(hand, fist):
    moved = relative_transforms(hand, fist)
    for course, tube in zip(courses(hand), tendons(hand, fist), strict=True):
        carried = moved[course.body[-1]]
        np.testing.assert_allclose(tube.points[-1], carried[:3, :3] @ course.point[-1] + carried[:3, 3], atol=2e-3)


@pytest.mark.parametrize(("finger", "name"), [(2, "index"), (3, "middle"), (4, "ring"), (5, "little")])
def test_extensors_are_dorsal_and_flexors_palmar_of_the_knuckle(hand, finger, name):
    tubes = named(tendons(hand, hand.bind))
    base = hand.bones[f"proximal_phalanx_{finger}"].points
    middle = base[np.argsort(base[:, 0])[:40]].mean(axis=0)
    for tube, side in (
        (tubes[f"common extensor, {name}"], -1.0),
        (tubes[f"deep flexor, {name}"], 1.0),
        (tubes[f"superficial flexor, {name}"], 1.0),
    ):
        near = tube.points[np.linalg.norm(tube.points - middle, axis=1).argmin()]
        assert side * (near - middle)[1] > 2e-3, tube.name


@pytest.mark.parametrize("finger", [2, 3, 4, 5])
def test_an_extensor_lies_over_the_knuckle_of_a_fist(hand, fist, finger):
    """It stands out: no point of the knuckle's head reaches further from the joint than the tendon does there."""
    name = {2: "index", 3: "middle", 4: "ring", 5: "little"}[finger]
    course = next(c for c in courses(hand) if c.name == f"common extensor, {name}")
    joint = 1  # the wrist comes first
    moved = relative_transforms(hand, fist)[course.carrier[joint]]
    centre = moved[:3, :3] @ course.centre[joint] + moved[:3, 3]
    line = named(tendons(hand, fist))[course.name].points
    axis = moved[:3, :3] @ course.axis[joint]
    way = line - centre
    reach = np.linalg.norm(way - (way @ axis)[:, None] * axis, axis=1)
    near = reach < 1.6 * course.reach[joint]
    assert near.sum() >= 3
    assert reach[near].min() > course.reach[joint] - 1e-6


def test_the_deep_flexor_reaches_the_last_phalanx_and_the_superficial_one_the_middle(hand):
    tubes = named(tendons(hand, hand.bind))
    for tube, bone in (("deep flexor, index", "distal_phalanx_2"), ("superficial flexor, index, radial slip", "middle_phalanx_2")):
        mesh = hand.bones[bone]
        distance = closest(tubes[tube].points[-1:].copy(), np.ascontiguousarray(mesh.points[mesh.faces]))[0][0]
        assert distance < 2e-3


def test_the_left_hand_has_mirrored_tendons(hand):
    left = hl.load_hand(side="left")
    for one, other in zip(tendons(hand, hand.bind), tendons(left, left.bind), strict=True):
        # the grid in which bone is looked for is not mirrored
        np.testing.assert_allclose(other.points * [1.0, 1.0, -1.0], one.points, atol=2e-4)
