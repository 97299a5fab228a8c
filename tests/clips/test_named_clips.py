"""What the named clips promise, each simulated from the relaxed hand with its wrist free.

Angles in degrees, lengths in millimetres; the bounds stand in the project's specification, none is taken from a clip.
"""

import json

import numpy as np
import pytest
from motion import FINGERS, FPS, motion

import handlab
from handlab.anatomy import data
from handlab.simulation.kinematics import body_transforms, posed_axes
from handlab.simulation.skin import blend
from handlab.studies import measures

SINGLE = ("open", "fist", "point", "pinch", "key-pinch", "ok", "thumbs-up", "spread", "hook", "l")
OPPOSITIONS = {"opposition-index": 2, "opposition-middle": 3, "opposition-ring": 4, "opposition-little": 5}
NAMED = (*SINGLE, "count-to-five", "wave", "opposition", *OPPOSITIONS)
DEEPEST_FLESH = 2.0
DEEPEST_BONE = 1.0
FINGER_LOOKS_BACK = 65.0  # degrees; no promise is made for the finger, but beyond this the thumb would touch its side
WRIST_EXTENSORS = ("ECRL", "ECRB", "ECU")
every_clip = pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.xdist_group(name)) for name in NAMED])


def group(name):
    """Tests of one clip run in one process, so that it is played once."""
    return pytest.mark.xdist_group(name)


# ---------------------------------------------------------------- what every clip must keep


def test_the_named_clips_are_those_that_were_promised():
    assert set(handlab.clips()) == set(NAMED)


@every_clip
def test_a_clip_holds_nothing_but_contraction_values(name):
    content = json.loads((data.folder() / "clips" / f"{name}.json").read_text(encoding="utf-8"))
    assert set(content) <= {"name", "title", "about", "time", "contraction"}
    hand = handlab.load_hand()
    assert set(content["contraction"]) <= set(hand.muscle_names)
    assert content["name"] == name and content["title"]
    for values in content["contraction"].values():
        assert len(values) == len(content["time"])
        assert all(isinstance(value, int | float) and 0.0 <= value <= 1.0 for value in values)


@every_clip
def test_contractions_start_at_0_and_stay_between_0_and_1(name):
    keys = handlab.keyframes(name)
    dense = keys.at(np.linspace(-0.5, keys.time[-1] + 0.5, 5000))
    assert dense.min() >= 0.0 and dense.max() <= 1.0
    assert dense.max() > 0.02  # and something contracts
    assert not keys.at(0.0).any()
    assert np.abs(np.diff(dense, axis=0)).max() < 0.02  # smooth: no jump between neighbours


@every_clip
def test_a_clip_is_the_same_motion_at_any_frame_rate(name, hand):
    times = {fps: handlab.simulate(hand, name, fps=fps) for fps in (24, 30, 60, 97)}
    np.testing.assert_allclose(times[30].angle, times[60].angle[::2][: len(times[30])], atol=1e-12)
    np.testing.assert_allclose(times[24].angle[::4], times[60].angle[::10][: len(times[24].angle[::4])], atol=1e-12)
    for k in range(len(hand.dof_names)):
        between = np.interp(times[97].time, times[60].time, times[60].angle[:, k])
        seen = times[97].time <= times[60].time[-1]
        assert np.rad2deg(np.abs(times[97].angle[:, k] - between))[seen].max() < 0.6  # chords of a curve, 1/60 s long
    np.testing.assert_allclose(motion(name).clip.angle, times[60].angle[:: 60 // FPS][: len(motion(name).clip)], atol=1e-12)


@every_clip
def test_no_skin_lies_deeper_than_2_mm_in_skin_where_the_hand_holds(name):
    played = motion(name)
    assert played.held
    for frame in played.held:
        deepest = played.flesh[frame].max()
        assert deepest <= DEEPEST_FLESH, f"{deepest:.1f} mm at {played.clip.time[frame]:.1f} s: {played.where(frame)}"


@every_clip
def test_no_skin_lies_deeper_than_2_mm_in_skin_on_the_way(name):
    played = motion(name)
    deepest = played.flesh.max(axis=1)
    worst = int(deepest.argmax())
    found = (
        f"{deepest[worst]:.1f} mm at {played.clip.time[worst]:.1f} s: {played.where(worst)}; {int((deepest > DEEPEST_FLESH).sum())} frames"
    )
    assert deepest[worst] <= DEEPEST_FLESH, found


@every_clip
def test_no_bone_enters_another_by_more_than_1_mm(name):
    played = motion(name)
    found = [(depth, pair, played.clip.time[k]) for k, bones in enumerate(played.bones) for pair, depth in bones.items()]
    assert not [one for one in found if one[0] > DEEPEST_BONE]


@every_clip
def test_the_blended_skin_keeps_its_volume_within_6_percent_of_rest(name, hand):
    played = motion(name)
    assert np.abs(played.volume - 1.0).max() <= 0.06
    assert played.volume[0] == pytest.approx(1.0, abs=1e-12)  # it starts in the relaxed hand
    assert np.ptp(played.volume) > 1e-4  # and is measured on skin that moves
    worst = int(np.abs(played.volume - 1.0).argmax())
    skin, rest = (tetrahedra(hand.skin.faces, points) for points in (played.clip.skin(worst), handlab.rest(hand).skin))
    assert skin / rest == pytest.approx(played.volume[worst], abs=1e-6)


def tetrahedra(faces, points):
    """Volume once more, by VTK."""
    import pyvista as pv

    return pv.make_tri_mesh(np.array(points), np.array(faces)).volume


@every_clip
def test_every_joint_stays_inside_its_limits(name, hand):
    angle = motion(name).clip.angle
    slack = np.deg2rad(2.0)
    assert np.all(angle >= hand.limits[:, 0] - slack) and np.all(angle <= hand.limits[:, 1] + slack)


@pytest.mark.parametrize("name", [pytest.param(name, marks=group(name)) for name in (*SINGLE, *OPPOSITIONS)])
def test_a_posture_is_held_not_passed_through(name):
    """In the last 0.3 s no joint moves by more than 3 degrees."""
    angle = np.rad2deg(motion(name).clip.angle)
    assert np.abs(angle[-1] - angle[-1 - round(0.3 * FPS)]).max() < 3.0
    assert np.abs(angle[-1] - angle[0]).max() > 10.0


# ---------------------------------------------------------------- fist


@group("fist")
def test_the_fist_is_closed_in_all_four_fingers():
    played = motion("fist")
    assert played.flexion("mcp", -1).min() >= 75.0
    assert played.flexion("pip", -1).min() >= 90.0
    assert played.flexion("dip", -1).min() >= 45.0


@group("fist")
@pytest.mark.parametrize("finger", FINGERS)
def test_the_pulps_of_the_fist_lie_at_the_palm(finger):
    assert -DEEPEST_FLESH <= motion("fist").to_palm(finger, -1) <= 10.0


@group("fist")
def test_the_thumb_lies_across_the_middle_phalanges_of_index_and_middle_finger():
    """Its pulp is within 5 mm of the skin of one and within 6 mm of the other."""
    near, far = sorted(motion("fist").thumb_to((f"middle_phalanx_{k}",), -1) for k in (2, 3))
    assert near <= 5.0
    assert far <= 6.0


@group("fist")
def test_the_thumb_lies_outside_the_fist(hand):
    """Its pulp looks at the backs of the middle phalanges, and the fingers' pulps are not between: they look the same way round."""
    played = motion("fist")
    angle, skin = played.clip.angle[-1], played.clip.skin(len(played.clip) - 1)
    axis, anchor = posed_axes(hand, angle)
    pulp = measures.pulp_normal(hand, skin, 1)
    thumb = skin[measures.pulps(hand)[1]].mean(axis=0)
    for k in (2, 3):
        pip, dip = (hand.dof_names.index(f"{joint}{k}.flexion_extension") for joint in ("pip", "dip"))
        back = np.cross(anchor[dip] - anchor[pip], axis[pip])
        back /= np.linalg.norm(back)
        assert np.rad2deg(np.arccos(-pulp @ back)) < 75.0
        assert (thumb - anchor[pip]) @ back > 0.004  # behind the bone, seen from the finger's palmar side


@group("fist")
def test_the_wrist_of_the_fist_is_extended():
    assert -35.0 <= motion("fist").angle("wrist.flexion_extension", -1) <= -10.0


@group("fist")
def test_the_wrist_of_the_fist_is_extended_by_its_own_extensors(hand):
    """They contract; and with them silent the wrist is no longer extended by 10 degrees."""
    played = motion("fist")
    assert max(played.contraction(muscle, -1) for muscle in WRIST_EXTENSORS) > 0.05
    column = hand.dof_names.index("wrist.flexion_extension")
    rows = [hand.muscle_names.index(hand.muscles[muscle].name) for muscle in WRIST_EXTENSORS]
    torque = played.clip.force[-1] * hand.lever_arm[:, column]
    assert torque[rows].sum() < torque[torque < 0].sum() / 3.0 < 0.0  # more than a third of all extension, finger extensors included
    silent = dict(zip(hand.muscle_names, played.keys.at(played.keys.time).T, strict=True))
    for row in rows:
        silent[hand.muscle_names[row]] = np.zeros(len(played.keys.time))
    without = handlab.simulate(hand, {"time": list(played.keys.time), **{name: list(values) for name, values in silent.items()}}, fps=FPS)
    assert np.rad2deg(without.angle[-1, column]) > max(-10.0, played.angle("wrist.flexion_extension", -1) + 5.0)


# ---------------------------------------------------------------- pulp to pulp

MEETINGS = [pytest.param("pinch", 2, marks=group("pinch")), pytest.param("ok", 2, marks=group("ok"))]
MEETINGS += [pytest.param(name, finger, marks=group(name)) for name, finger in OPPOSITIONS.items()]


@pytest.mark.parametrize(("name", "finger"), MEETINGS)
def test_the_thumbs_pulp_meets_the_fingers_pulp(name, finger):
    assert -1.0 <= motion(name).gap(finger, -1) <= 4.0


@pytest.mark.parametrize(("name", "finger"), MEETINGS)
def test_the_thumbs_pulp_faces_the_fingers_pulp_within_45_degrees(name, finger):
    """And the finger looks back: its own pulp, not its side, is turned to the thumb."""
    there, back = motion(name).facing(finger, -1)
    assert there <= 45.0
    assert back <= FINGER_LOOKS_BACK


@pytest.mark.parametrize(("name", "finger"), MEETINGS)
def test_facing_is_what_vtk_says_of_the_pulps(name, finger, hand):
    """Area vectors and centres of the pulps' triangles."""
    import pyvista as pv

    frame = len(motion(name).clip) - 1
    centre, normal = [], []
    for k in (1, finger):
        faces = hand.skin.faces[np.isin(hand.skin.faces, measures.pulps(hand)[k]).all(axis=1)]
        pulp = pv.make_tri_mesh(np.array(motion(name).clip.skin(frame)), faces)
        centre.append(pulp.cell_centers().points.mean(axis=0))
        normal.append(
            (
                pulp.compute_cell_sizes()["Area"][:, None]
                * pulp.compute_normals(auto_orient_normals=False, consistent_normals=False).cell_data["Normals"]
            ).sum(axis=0)
        )
    for (one, other), found in zip(((0, 1), (1, 0)), motion(name).facing(finger, frame), strict=True):
        way = centre[other] - centre[one]
        expected = np.rad2deg(np.arccos(normal[one] @ way / np.linalg.norm(normal[one]) / np.linalg.norm(way)))
        assert found == pytest.approx(expected, abs=10.0)


@group("opposition")
def test_the_thumb_meets_one_finger_after_the_other():
    played = motion("opposition")
    assert len(played.held) == 4
    for frame, finger in zip(played.held, FINGERS, strict=True):
        assert -1.0 <= played.gap(finger, frame) <= 4.0
        there, back = played.facing(finger, frame)
        assert there <= 45.0 and back <= FINGER_LOOKS_BACK
        assert all(played.gap(other, frame) > 6.0 for other in FINGERS if other != finger)


@group("ok")
def test_three_fingers_stay_straight_in_ok():
    played = motion("ok")
    for joint, most in (("mcp", 25.0), ("pip", 30.0), ("dip", 25.0)):
        assert played.flexion(joint, -1, (3, 4, 5)).min() > -15.0 and played.flexion(joint, -1, (3, 4, 5)).max() < most
    assert played.flexion("pip", -1, (2,))[0] > 35.0


# ---------------------------------------------------------------- the other postures


def straight(played, frame, which):
    """Whether these fingers are straight enough to be counted."""
    bend = [played.flexion(joint, frame, which) for joint in ("mcp", "pip", "dip")]
    return bool(all(part.max() <= 20.0 for part in bend) and bend[0].min() >= -20.0)


def closed(played, frame, which):
    """Whether these fingers are closed as in a fist."""
    return bool(played.flexion("mcp", frame, which).min() >= 70.0 and played.flexion("pip", frame, which).min() >= 85.0)


@group("open")
def test_the_open_hand_is_flat():
    played = motion("open")
    assert straight(played, -1, FINGERS)
    assert -25.0 <= played.angle("wrist.flexion_extension", -1) <= 15.0
    assert all(played.to_palm(finger, -1) > 35.0 for finger in FINGERS)


@group("point")
def test_the_index_finger_points_and_the_others_are_closed():
    assert straight(motion("point"), -1, (2,)) and closed(motion("point"), -1, (3, 4, 5))


@group("hook")
def test_the_hook_bends_the_fingers_but_hardly_their_knuckles():
    played = motion("hook")
    assert played.flexion("mcp", -1).min() >= -5.0 and played.flexion("mcp", -1).max() <= 30.0
    assert played.flexion("pip", -1).min() >= 70.0
    assert played.flexion("dip", -1).min() >= 20.0


@group("thumbs-up")
def test_thumbs_up_is_a_fist_with_the_thumb_up(hand):
    """The thumb points radially, away from the fingers' middle phalanges, and is straight."""
    played = motion("thumbs-up")
    assert closed(played, -1, FINGERS)
    assert abs(played.angle("ip1.flexion_extension", -1)) < 20.0
    direction = of_thumb(hand, played.clip.angle[-1])
    assert np.rad2deg(np.arccos(direction @ across_the_palm(hand, played.clip.angle[-1]))) < 60.0
    assert played.thumb_to(("middle_phalanx_2",), -1) > 25.0


@group("l")
def test_thumb_and_index_finger_stand_as_an_l(hand):
    """Index finger straight, the others closed, and 38 to 60 degrees between it and the thumb, whose limits allow 48."""
    played = motion("l")
    assert straight(played, -1, (2,)) and closed(played, -1, (3, 4, 5))
    angle = played.clip.angle[-1]
    between = np.rad2deg(np.arccos(of_thumb(hand, angle) @ of_finger(hand, angle, 2)))
    assert 38.0 <= between <= 60.0


@group("key-pinch")
def test_the_key_is_held_between_the_thumbs_pulp_and_the_index_fingers_radial_side(hand):
    played = motion("key-pinch")
    frame = len(played.clip) - 1
    assert played.thumb_to(("middle_phalanx_2", "distal_phalanx_2"), frame) <= 4.0
    skin = played.clip.skin(frame)
    axis, anchor = posed_axes(hand, played.clip.angle[frame])
    pip, dip = (hand.dof_names.index(f"{joint}2.flexion_extension") for joint in ("pip", "dip"))
    thumb = skin[measures.pulps(hand)[1]].mean(axis=0)
    along = (anchor[dip] - anchor[pip]) / np.linalg.norm(anchor[dip] - anchor[pip])
    aside = thumb - anchor[pip] - along * ((thumb - anchor[pip]) @ along)
    assert np.rad2deg(np.arccos(aside @ axis[pip] / np.linalg.norm(aside))) < 60.0  # radial, not the pulp nor the back


@group("spread")
def test_spread_fingers_stand_apart_and_wider_than_open_ones(hand):
    """At least 5 degrees between neighbours, none nearer than in the open hand, at least 10 more in all."""
    wide, narrow = (fan(hand, motion(name).clip.angle[-1]) for name in ("spread", "open"))
    assert straight(motion("spread"), -1, FINGERS)
    assert wide.min() >= 5.0
    assert np.all(wide > narrow)
    assert 10.0 <= (wide - narrow).sum() <= 60.0


@group("count-to-five")
def test_one_finger_after_the_other_is_counted(hand):
    played = motion("count-to-five")
    assert len(played.held) == 5
    for number, frame in enumerate(played.held, start=1):
        up = FINGERS[:number]
        assert straight(played, frame, up)
        if number < 4:
            assert closed(played, frame, FINGERS[number:])
    four, five = (of_thumb(hand, played.clip.angle[played.held[k]]) for k in (3, 4))
    palm = across_the_palm(hand, played.clip.angle[played.held[4]])
    assert np.rad2deg(np.arccos(five @ palm)) + 25.0 < np.rad2deg(np.arccos(four @ palm))  # the thumb comes last


@group("wave")
def test_the_hand_waves_from_side_to_side():
    played = motion("wave")
    side = np.array([played.angle("wrist.deviation", k) for k in range(len(played.clip))])
    far = np.where(side > 5.0, 1, np.where(side < -8.0, -1, 0))
    turns = [a for a, b in zip(far[far != 0], np.append(far[far != 0][1:], 0), strict=True) if a != b]
    assert len(turns) >= 4  # radial, ulnar, radial, ulnar
    assert 20.0 <= np.ptp(side) <= 55.0
    assert all(straight(played, frame, FINGERS) for frame in range(FPS, len(played.clip)))  # open after the first second


# ---------------------------------------------------------------- directions


def of_thumb(hand, angle):
    """From the thumb's MCP joint to its tip, unit vector."""
    _, anchor = posed_axes(hand, angle)
    tip = blend(hand, angle)[hand.feature_points["tip_thumb"]["palmar"]]
    along = tip - anchor[hand.dof_names.index("mcp1.flexion_extension")]
    return along / np.linalg.norm(along)


def of_finger(hand, angle, k):
    """From a finger's MCP to its PIP joint, unit vector."""
    _, anchor = posed_axes(hand, angle)
    mcp, pip = (hand.dof_names.index(f"{joint}{k}.flexion_extension") for joint in ("mcp", "pip"))
    return (anchor[pip] - anchor[mcp]) / np.linalg.norm(anchor[pip] - anchor[mcp])


def across_the_palm(hand, angle):
    """Radial direction of the palm, unit vector."""
    turned = body_transforms(hand, angle)[hand.body_names.index("carpus")]
    return turned[:3, :3] @ [0.0, 0.0, 1.0]


def fan(hand, angle):
    """Degrees between neighbouring fingers, seen from the palm: (3,), positive where they part."""
    turned = body_transforms(hand, angle)[hand.body_names.index("carpus")][:3, :3]
    flat = [turned.T @ of_finger(hand, angle, k) for k in FINGERS]
    bearing = np.rad2deg([np.arctan2(direction[2], direction[0]) for direction in flat])
    return -np.diff(bearing)
