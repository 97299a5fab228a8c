"""The live hand behind a viewer: messages in, frames out."""

import json
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import handlab as hl
from handlab.show import wire
from handlab.show.exports import fulfilled
from handlab.show.session import ACTS, FORMATS, MINE, Session
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.skin import blend

DT = 1 / 60


@pytest.fixture
def session(hand):
    return Session(hand)


def unpacked(frame, hand):
    kind, flags, echo = struct.unpack_from("<III", frame)
    sizes = [len(hand.muscle_names), len(hand.dof_names), len(hand.muscle_names), len(hand.muscle_names), 12 * len(hand.body_names)]
    words = np.frombuffer(frame, "<f4", 5 + sum(sizes))
    parts = np.split(words[5:], np.cumsum(sizes))[:-1]
    names = ("contraction", "angle", "fibre_length", "force", "motion")
    whole = np.frombuffer(frame, "<i2", offset=words.nbytes)
    points = 3 * len(hand.skin.points)
    skin, segments = (whole[:points], whole[points + points % 2 :]) if kind & wire.SKIN else (whole[:0], whole)
    return {
        "kind": kind, "flags": flags, "echo": echo, "time": words[3], "seconds": words[4], "skin": wire.UNIT * skin.reshape(-1, 3),
        "segments": segments.reshape(-1, 10), **dict(zip(names, parts, strict=True)),
    }  # fmt: skip


def until_still(session, most=2000):
    frames = []
    for _ in range(most):
        frame = session.tick(DT)
        if frame is None:
            return frames
        frames.append(frame)
    raise AssertionError("never still")


def answers(session):
    return [reply["text"] for reply in session.replies() if reply["kind"] == "answer"]


def test_a_frame_holds_the_state_and_is_below_four_kilobytes(session, hand):
    session.message({"kind": "set", "contraction": {"FDP2": 0.5}, "n": 7})
    frame = until_still(session)[-1]
    assert 1000 < len(frame) <= 4096
    got = unpacked(frame, hand)
    assert got["kind"] == wire.BODIES
    assert got["echo"] == 7
    assert np.allclose(got["angle"], session.state.angle, atol=1e-6)
    assert np.allclose(got["fibre_length"], session.state.fibre_length, atol=1e-8)
    assert np.allclose(got["motion"].reshape(-1, 3, 4), relative_transforms(hand, session.state.angle)[:, :3], atol=1e-6)
    assert got["contraction"][hand.muscle_names.index(hand.muscles["FDP2"].name)] == pytest.approx(0.5)
    assert got["force"].max() > 1.0


def test_a_frame_with_skin_points_is_below_twenty_kilobytes(hand):
    frame = Session(hand, skin_points=True).tick(DT)
    assert 10_000 < len(frame) <= 20_000
    got = unpacked(frame, hand)
    assert got["kind"] == wire.BODIES | wire.SKIN
    assert np.abs(got["skin"] - blend(hand, hl.rest(hand).angle)).max() <= 0.501 * wire.UNIT


def test_a_resting_hand_gives_one_frame_and_then_none(session):
    assert session.tick(DT) is not None
    assert [session.tick(DT) for _ in range(50)] == [None] * 50


def test_a_moved_hand_comes_to_rest_where_simulation_says(session, hand):
    session.message({"kind": "set", "contraction": {"EDC3": 0.6}})
    until_still(session)
    end = hl.simulate(hand, {"EDC3": 0.6}, seconds=4).states[-1]
    assert np.abs(session.state.angle - end.angle).max() < np.deg2rad(0.5)


def test_a_host_that_slept_does_not_make_the_hand_jump(session):
    session.message({"kind": "set", "contraction": {"EDC3": 0.6}})
    session.tick(3600.0)
    assert session.state.time == pytest.approx(0.1)


def test_a_held_joint_stays(session, hand):
    session.message({"kind": "hold", "joints": ["wrist"]})
    session.message({"kind": "set", "contraction": {"FCR": 1.0, "FCU": 1.0}})
    until_still(session)
    wrist = [k for k, name in enumerate(hand.dof_names) if name.startswith("wrist")]
    assert np.array_equal(session.state.angle[wrist], hl.rest(hand).angle[wrist])


def test_a_clip_plays_to_its_end_at_its_speed_and_stops(session, hand):
    for speed, tolerance in ((1.0, 3), (0.5, 5)):
        session.message({"kind": "play", "clip": "fist", "speed": speed})
        seconds = hl.keyframes("fist").time[-1]
        assert len(until_still(session)) == pytest.approx(seconds / speed / DT, abs=tolerance)
        assert session.clip_time == pytest.approx(seconds)
    assert np.allclose(unpacked(session.frame(), hand)["angle"], hl.simulate(hand, "fist").angle[-1], atol=1e-6)


def test_a_repeated_clip_goes_on(session):
    session.message({"kind": "play", "clip": "fist", "loop": True})
    assert all(session.tick(DT) for _ in range(600))


def test_a_slider_in_the_middle_of_a_clip_takes_over_from_there(session):
    session.message({"kind": "play", "clip": "fist"})
    for _ in range(60):
        session.tick(DT)
    before = session.present().angle
    session.message({"kind": "set", "contraction": {"EDC2": 0.5}})
    assert session.clip is None
    assert np.allclose(session.state.angle, before)
    assert session.contraction.max() >= 0.5


def test_scrubbing_shows_the_moment(session, hand):
    session.message({"kind": "play", "clip": "fist"})
    session.message({"kind": "pause"})
    session.message({"kind": "seek", "t": 1.0})
    assert np.allclose(unpacked(session.tick(DT), hand)["angle"], hl.simulate(hand, "fist").angle[60], atol=1e-6)
    assert session.tick(DT) is None


def test_holding_a_joint_changes_the_clip_that_is_loaded(session, hand):
    session.message({"kind": "play", "clip": "fist"})
    session.message({"kind": "hold", "joints": ["pip2"]})
    k = hand.dof_names.index("pip2.flexion_extension")
    assert np.ptp(session.clip.angle[:, k]) < 1e-12


def test_ten_thousand_settings_leave_the_last_one(session, hand):
    for k in range(10_000):
        session.message({"kind": "set", "contraction": {"FDP2": k / 10_000}})
    assert session.contraction[hand.muscle_names.index(hand.muscles["FDP2"].name)] == 0.9999
    assert len(session.replies()) < 10


BAD = [
    (None, "mapping"),
    ({"kind": "dance"}, "did you mean"),
    ({"kind": "set"}, "contraction is missing"),
    ({"kind": "set", "contraction": {"FDP9": 0.1}}, "did you mean"),
    ({"kind": "set", "contraction": {"FDP2": 1.2}}, "between 0 and 1"),
    ({"kind": "set", "contraction": {"FDP2": float("nan")}}, "between 0 and 1"),
    ({"kind": "set", "contraction": {"FDP2": "much"}}, "give a number"),
    ({"kind": "hold", "joints": "wrist"}, "list of names"),
    ({"kind": "hold", "joints": ["elbow"]}, "unknown joint"),
    ({"kind": "play"}, "choose one of"),
    ({"kind": "play", "clip": "fits"}, "fist"),
    ({"kind": "play", "clip": "fist", "speed": 99}, "between 0.05 and 4"),
    ({"kind": "seek", "t": 1}, "no clip is loaded"),
    ({"kind": "record", "on": False}, "nothing is being recorded"),
    ({"kind": "save", "what": "clip"}, "no motion yet"),
    ({"kind": "load", "text": "{", "name": "a.json"}, "a.json, line 1"),
    ({"kind": "load", "text": "[" * 100_000}, "not a pose or clip"),
    ({"kind": "load", "text": '{"angle_deg": {"mcp2.flexion_extension": 500}}'}, "limits"),
    ({"kind": "load", "text": '{"time": [0, 1e9], "contraction": {"FDP2": [0, 1]}}'}, "longest"),
    ({"kind": "load", "text": '{"time": [0, NaN], "contraction": {"FDP2": [0, 1]}}'}, "not a pose or clip"),
    ({"kind": "export", "format": "exe"}, "did you mean"),
    ({"kind": "wear", "skin": "leather"}, "unknown way to wear the skin"),
    ({"kind": "wear", "muscles": "all"}, "unknown choice of muscles"),
]


@pytest.mark.parametrize(("message", "sentence"), BAD)
def test_a_bad_message_is_answered_by_one_sentence_and_changes_nothing(session, message, sentence):
    session.message(message)
    (said,) = answers(session)
    assert sentence in said
    assert "\n" not in said
    assert np.array_equal(session.contraction, np.zeros_like(session.contraction))
    assert session.clip is None


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)
NAMES = "contraction joints clip speed loop t what text name format look on n skin muscles"
KEYS = st.sampled_from(NAMES.split())


@settings(max_examples=300, deadline=None)
@given(
    kind=st.sampled_from(sorted(ACTS)),
    rest=st.dictionaries(KEYS, JSON),
)
def test_no_message_raises_or_stops_the_hand(kind, rest):
    session = SHARED.setdefault("session", Session(SHARED.setdefault("hand", hl.load_hand())))
    session.message({"kind": kind, **rest})
    session.tick(DT)
    for reply in session.replies():
        assert reply["kind"] in {"answer", "status", "clips", "file", "track", "layers"}


SHARED = {}


@settings(max_examples=200, deadline=None)
@given(
    content=st.fixed_dictionaries(
        {}, optional={"angle_deg": JSON, "contraction": JSON, "hold": JSON, "time": JSON, "name": JSON, "title": JSON}
    )
)
def test_no_file_that_is_loaded_raises_or_stops_the_hand(content):
    session = SHARED.setdefault("session", Session(SHARED.setdefault("hand", hl.load_hand())))
    session.message({"kind": "load", "name": "x.json", "text": json.dumps(content)})
    session.tick(DT)


def test_a_pose_and_a_clip_survive_a_file(session, hand, tmp_path):
    session.message({"kind": "play", "clip": "pinch"})
    session.message({"kind": "seek", "t": 1.5})
    session.message({"kind": "save", "what": "pose"})
    session.message({"kind": "save", "what": "clip"})
    pose, clip = (reply for reply in session.replies() if reply["kind"] == "file")
    present = session.present().angle
    session.message({"kind": "reset"})
    session.message({"kind": "load", "text": pose["text"], "name": pose["name"]})
    assert np.abs(session.state.angle - present).max() < np.deg2rad(0.01)
    (tmp_path / "pinch.json").write_text(clip["text"])
    again = hl.simulate(hand, hl.keyframes(str(tmp_path / "pinch.json")))
    assert np.abs(again.angle[-1] - hl.simulate(hand, "pinch").angle[-1]).max() < np.deg2rad(1.0)
    session.message({"kind": "load", "text": clip["text"], "name": clip["name"]})
    assert session.clip_name == "pinch"
    assert [one["name"] for one in session.clips()].count("pinch") == 1


def test_a_recording_is_a_clip_of_what_happened(session, hand):
    session.message({"kind": "record", "on": True})
    session.message({"kind": "set", "contraction": {"EDC2": 0.6}})
    angles = [unpacked(session.tick(DT), hand)["angle"] for _ in range(60)]
    session.message({"kind": "record", "on": False})
    assert session.clip_name == MINE
    assert np.allclose(session.clip.angle, angles, atol=1e-6)


def test_a_scene_tells_names_limits_and_the_number_behind_every_force(session, hand):
    data = session.scene()
    (size,) = struct.unpack_from("<I", data)
    head = json.loads(data[4 : 4 + size])
    assert [muscle["name"] for muscle in head["muscles"]] == list(hand.muscle_names)
    assert [dof["name"] for dof in head["dofs"]] == list(hand.dof_names)
    assert np.allclose([dof["limits"] for dof in head["dofs"]], hand.limits)
    assert head["newton_per_percent"] == hand.newton_per_percent
    assert {clip["name"] for clip in head["clips"]} == set(hl.clips())
    kind, shape, offset = head["arrays"]["skin_points"]
    points = np.frombuffer(data, f"<{kind}", int(np.prod(shape)), 4 + size + offset).reshape(shape)
    assert np.allclose(points, hand.skin.points, atol=1e-7)
    assert 100_000 < len(data) < 600_000


@pytest.mark.parametrize("kind", ["csv", "glb", "html"])
def test_a_wish_becomes_a_file(session, kind):
    session.message({"kind": "play", "clip": "fist"})
    session.message({"kind": "export", "format": kind, "look": {"skin": "solid", "view": "palm"}})
    (wish,) = session.wishes()
    reply = fulfilled(wish)
    assert reply["name"] == f"fist.{kind}"
    assert len(reply["data"]) > 10_000


def test_a_host_may_write_fewer_formats(hand):
    session = Session(hand, exports=("csv",))
    session.message({"kind": "export", "format": "mp4"})
    assert "does not write .mp4" in answers(session)[0]
    assert set(FORMATS) == {"png", "mp4", "gif", "glb", "html", "csv"}
