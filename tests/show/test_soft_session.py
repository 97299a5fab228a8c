"""The live hand with a soft skin: it shows when it is ready, rests when the hand rests, and stays small on the wire."""

import subprocess
import sys

import numpy as np
import pytest

import handlab as hl
from handlab.show import wire
from handlab.show.app.drawing import pack, unpack
from handlab.show.moments import story
from handlab.show.page import page
from handlab.show.session import Session
from handlab.simulation.geometric_muscle import ellipsoids
from handlab.simulation.skin import blend
from handlab.simulation.soft_frame import begin
from handlab.simulation.soft_skin import soft_skin

DT, SOFT = 1 / 60, "springs and muscles"

FIRST_MINUTE = """
import sys
from numba.core.dispatcher import Dispatcher
import handlab as hl
from handlab.show.session import Session

def compiled():
    mine = [module for name, module in sys.modules.items() if name.startswith("handlab.")]
    kernels = {found for module in mine for found in vars(module).values() if isinstance(found, Dispatcher)}
    return {f"{kernel.__name__}{signature}" for kernel in kernels for signature in kernel.signatures}

session = Session(hl.load_hand(), wear="springs and muscles")
session.tick(1 / 60)
session.prepare()
session.ready()
session.tick(1 / 60)
before = compiled()
assert len(before) > 20, before
for message in (
    {"kind": "play", "clip": "fist"},
    {"kind": "seek", "t": 0.5},
    {"kind": "set", "contraction": {"FDP2": 0.4}},
    {"kind": "hold", "joints": ["wrist"]},
    {"kind": "layers"},
    {"kind": "set", "contraction": {"DI1": 0.4}},
    {"kind": "wear", "skin": "springs", "muscles": "geometric"},
    {"kind": "reset"},
):
    session.message(message)
    for _ in range(4):
        session.tick(1 / 60)
    new = compiled() - before
    assert not new, (message, new)
assert all(reply.get("good", True) for reply in session.replies())
"""


@pytest.fixture
def session(hand):
    dressed = Session(hand, wear=SOFT)
    dressed.prepare()
    dressed.ready()
    return dressed


def points_of(frame, hand):
    kind = int(np.frombuffer(frame, "<u4", 1)[0])
    assert kind & wire.SKIN
    count = 3 * len(hand.skin.points)
    start = 4 * (wire.HEAD_WORDS + 3 * len(hand.muscles) + len(hand.dof_names) + 12 * len(hand.bodies))
    return wire.UNIT * np.frombuffer(frame, "<i2", count, start).reshape(-1, 3)


def until_still(session, most=600):
    frames = []
    while (frame := session.tick(DT)) is not None:
        frames.append(frame)
        assert len(frames) < most
    return frames


def test_until_it_is_ready_the_skin_is_left_to_the_viewer(hand):
    session = Session(hand, wear=SOFT)
    frame = session.tick(DT)
    assert 1000 < len(frame) <= 4096
    session.prepare()
    session.ready()
    assert 10_000 < len(session.tick(DT)) <= 20_000
    assert session.replies()[-1]["soft"] is True


def test_nothing_is_compiled_any_more_once_a_session_is_prepared():
    """In a process of its own, where no other test has compiled anything."""
    done = subprocess.run([sys.executable, "-c", FIRST_MINUTE], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


def test_a_soft_hand_comes_to_rest_and_so_does_its_page(session, hand):
    session.message({"kind": "set", "contraction": {"DI1": 0.8}})
    frames = until_still(session)
    assert len(frames) > 20
    assert [session.tick(DT) for _ in range(30)] == [None] * 30
    still = begin(hand, soft_skin(hand), session.state.angle, session.contraction).points
    shown = points_of(frames[-1], hand)
    assert np.abs(shown - session.state.skin).max() <= 0.501 * wire.UNIT
    assert np.abs(shown - still).max() < 1e-4
    assert np.abs(shown - blend(hand, session.state.angle)).max() > 5e-4


def test_a_skin_that_never_rests_does_not_keep_the_page_awake(session, monkeypatch):
    session.tick(DT)
    monkeypatch.setattr(type(session.wardrobe), "moving", True, raising=False)
    monkeypatch.setattr(session.wardrobe, "points", lambda *_: session.state.skin)
    session.wardrobe.moving = True
    session.message({"kind": "set", "contraction": {"DI1": 0.1}})
    assert 60 < len(until_still(session)) < 600


def test_with_muscles_a_frame_is_still_below_twenty_kilobytes(session, hand):
    session.message({"kind": "layers"})
    assert [reply["kind"] for reply in session.replies()][-1] == "layers"
    session.message({"kind": "set", "contraction": {"DI1": 0.5}})
    frame = until_still(session)[-1]
    assert 15_000 < len(frame) <= 20_000
    segments = np.frombuffer(frame, "<i2")[-10 * len(ellipsoids(hand, hand.bind).centre) :].reshape(-1, 10)
    wanted = ellipsoids(hand, session.state.angle, session.contraction)
    assert np.abs(wire.UNIT * segments[:, :3] - wanted.centre).max() < 1e-5
    assert np.abs(wire.HALF_UNIT * segments[:, 7:] - wanted.half).max() < 1e-6
    w, x, y, z = (segments[:, 3:7] / 32767.0).T
    along = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=1)
    assert np.abs(along - wanted.frame[:, :, 0]).max() < 2e-4


@pytest.mark.parametrize("side", ["right", "left"])
def test_a_quaternion_on_the_wire_is_the_rotation(side):
    from scipy.spatial.transform import Rotation

    hand = hl.load_hand(side=side)
    frame = np.concatenate([ellipsoids(hand, hand.bind).frame, Rotation.random(200, random_state=3).as_matrix()])
    back = Rotation.from_quat(wire.quaternions(frame)[:, [1, 2, 3, 0]]).as_matrix()
    assert np.abs(back - frame).max() < 1e-9


def test_a_clip_plays_with_the_recorded_skin_and_scrubs_to_the_same_moment(session, hand):
    session.message({"kind": "play", "clip": "pinch"})
    for _ in range(40):
        session.tick(DT)
    session.message({"kind": "pause"})
    session.message({"kind": "seek", "t": 0.5})
    shown = points_of(session.tick(DT), hand)
    clip = hl.simulate(hand, "pinch").with_skin(SOFT)
    assert np.abs(shown - clip.skin(30)).max() <= 0.6 * wire.UNIT


# Limits put a few folded nodes of a fist elsewhere when the springs had a millisecond than when they had a whole frame.
def test_a_slider_in_a_clip_takes_the_skin_over_without_a_jump(session):
    session.message({"kind": "play", "clip": "fist"})
    for _ in range(60):
        session.tick(DT)
    before = session.present().skin
    session.message({"kind": "set", "contraction": {"EDC2": 0.1}})
    session.tick(1e-3)
    assert np.abs(session.state.skin - before).max() < 1e-3


def test_skins_and_muscles_are_switched_by_name(session, hand):
    session.message({"kind": "wear", "skin": "blend"})
    assert len(session.tick(DT)) <= 4096
    session.message({"kind": "wear", "skin": SOFT, "muscles": "geometric"})
    until_still(session)
    angle, skin = session.state.angle, session.state.skin
    session.message({"kind": "set", "contraction": {"DI1": 1.0}})
    until_still(session)
    assert np.array_equal(session.state.angle, angle)
    assert 1.5e-3 < np.linalg.norm(session.state.skin - skin, axis=1).max() < 6e-3
    session.message({"kind": "wear", "muscles": "pseudo"})
    until_still(session)
    assert not np.array_equal(session.state.angle, angle)
    status = [reply for reply in session.replies() if reply["kind"] == "status"][-1]
    assert (status["wear"], status["muscles"]) == (SOFT, "pseudo")


def test_a_recording_keeps_the_skin_that_was_seen(session, hand, tmp_path):
    session.message({"kind": "record", "on": True})
    session.message({"kind": "set", "contraction": {"DI1": 1.0}})
    shown = [points_of(session.tick(DT), hand) for _ in range(20)]
    session.message({"kind": "record", "on": False})
    clip = session.clip
    assert clip.wear == SOFT
    assert max(np.abs(clip.skin(k) - shown[k]).max() for k in range(20)) < wire.UNIT
    pack(clip, tmp_path / "clip.npz")
    again = unpack(tmp_path / "clip.npz", hand, clip.fps, clip.name, clip.wear, clip.muscles)
    assert np.array_equal(again.skin(7), clip.skin(7))


def test_a_page_shows_the_skin_of_a_soft_clip_and_blends_a_long_one(hand):
    short = hl.simulate(hand, {"DI1": [(0, 0), (0.3, 1)]}, seconds=0.5)
    plain, soft = page([story(short)]), page([story(short.with_skin(SOFT))])
    assert 1.05 * len(plain) < len(soft) < 3_000_000
    long = hl.simulate(hand, {"DI1": [(0, 0), (0.3, 1)]}, seconds=30).with_skin(SOFT)
    assert len(page([story(long)])) < 3_000_000
