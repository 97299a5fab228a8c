"""The running server: what it lets in, and what it survives."""

import asyncio
import json
import struct
import subprocess
import sys
import time

import numpy as np
import pytest

import handlab as hl
from handlab.show import wire

FRAME_MOST = 20_000  # with a soft skin; 1,560 bytes before it is ready


def angles(frame, hand):
    """Angles (dof,) in a frame."""
    values = np.frombuffer(frame, "<f4")
    start = wire.HEAD_WORDS + len(hand.muscle_names)
    return values[start : start + len(hand.dof_names)]


@pytest.fixture(scope="module")
def hand():
    return hl.load_hand()


# Who is let in ------------------------------------------------------------------------------------------------------------


def test_the_page_comes_with_the_key_and_is_refused_without(served):
    status, headers, body = served.get(f"/index.html?secret={served.key}")
    assert status == 200
    assert b"<title>handlab</title>" in body
    assert "frame-ancestors" in headers["Content-Security-Policy"]
    assert headers["Referrer-Policy"] == "no-referrer"
    for address in ("/index.html", "/index.html?secret=wslink-secret"):
        status, _, body = served.get(address)
        assert status == 403
        assert b"<script src=" not in body


@pytest.mark.parametrize("path", ["/handlab/data/scene", "/handlab/data/scene?secret=wrong", "/handlab/data/file/x"])
def test_data_is_refused_without_the_key(served, path):
    status, _, body = served.get(path)
    assert status == 403
    assert b"key" in body


def test_a_foreign_page_and_a_foreign_name_are_refused_even_with_the_key(served):
    assert served.get("/handlab/data/scene", key=served.key, Origin="https://evil.example")[0] == 403
    assert served.get("/handlab/data/scene", key=served.key, host=f"evil.example:{served.port}")[0] == 403
    assert served.get("/handlab/data/scene", key=served.key, Origin=f"http://{served.host}:{served.port}")[0] == 200


@pytest.mark.parametrize(
    "path", ["/handlab/static/../app/guard.py", "/handlab/static/%2e%2e%2fapp%2fguard.py", "/handlab/static/..%5c..%5ccli.py",
             "/../../etc/passwd", "//etc/passwd"]
)  # fmt: skip
def test_no_file_outside_the_page_is_served(served, path):
    status, _, body = served.get(path)
    assert status in (403, 404)
    assert b"root:" not in body
    assert b"import" not in body


def test_the_socket_refuses_a_wrong_key_and_answers_nothing_before(served, join, converse):
    async def work(http_session):
        page = await join(http_session, served, key="wslink-secret")
        assert page.hello["error"]["message"] == "Authentication failed"
        answer = await page.answer("handlab.message", {"kind": "play", "clip": "fist"})
        assert "Unauthorized" in answer["error"]["message"]
        await asyncio.sleep(0.2)
        assert not page.frames

    converse(work)


def test_the_socket_refuses_a_foreign_origin(served, join, converse):
    async def work(http_session):
        import aiohttp

        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await join(http_session, served, Origin="https://evil.example")
        assert refused.value.status == 403

    converse(work)


@pytest.mark.parametrize(("key", "headers"), [("", {}), ("wslink-secret", {}), (None, {"Origin": "https://evil.example"})])
def test_the_socket_of_frames_refuses_a_wrong_key_and_a_foreign_origin(served, converse, key, headers):
    async def work(http_session):
        import aiohttp

        address = f"ws://{served.host}:{served.port}/handlab/data/frames?secret={served.key if key is None else key}"
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await http_session.ws_connect(address, headers=headers)
        assert refused.value.status == 403

    converse(work)


def test_a_page_that_sends_nonsense_for_a_drawn_frame_loses_its_frames_and_nothing_else(served, join, converse):
    async def work(http_session):
        loud, calm = await join(http_session, served), await join(http_session, served)
        await loud.looking.send_bytes(bytes(100_000))
        await loud.until(lambda: loud.looking.closed)
        await calm.send({"kind": "play", "clip": "fist"})
        count = len(calm.frames)
        await calm.until(lambda: len(calm.frames) > count + 5)

    converse(work)


def test_the_key_stands_in_no_command_line(served):
    assert served.key not in subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True).stdout


def test_a_page_cannot_end_the_server(served, join, converse):
    async def work(http_session):
        page = await join(http_session, served)
        await page.call("application.exit")
        await page.call("application.exit.later", 0)
        await asyncio.sleep(0.5)

    converse(work)
    assert served.alive()


# What it does ---------------------------------------------------------------------------------------------------------------


def test_a_slider_moves_the_hand_and_frames_are_small(served, join, converse, hand):
    async def work(http_session):
        page = await join(http_session, served)
        await page.send({"kind": "reset"})
        await page.until(lambda: page.frames)
        before = angles(page.frames[-1], hand)
        await page.send({"kind": "set", "contraction": {"FDP2": 0.5}})
        dip = hand.dof_names.index("dip2.flexion_extension")
        await page.until(lambda: angles(page.frames[-1], hand)[dip] > before[dip] + 0.3)
        assert max(map(len, page.frames)) <= FRAME_MOST

    converse(work)


async def dressed(page):
    """Wait until the hand wears its soft skin: that brings a frame of its own."""
    await page.send({"kind": "reset"})
    await page.until(lambda: any(note.get("soft") for note in page.notes))


def test_a_clip_plays_at_sixty_frames_a_second_and_can_be_paused(served, join, converse):
    async def work(http_session):
        page = await join(http_session, served)
        await dressed(page)
        await page.send({"kind": "play", "clip": "fist"})
        await page.until(lambda: len(page.frames) > 5)
        count, start = len(page.frames), time.perf_counter()
        await asyncio.sleep(1.0)
        rate = (len(page.frames) - count) / (time.perf_counter() - start)
        assert 20.0 <= rate <= 66.0  # 60 on a quiet machine
        await page.send({"kind": "pause"})
        await asyncio.sleep(0.2)
        count = len(page.frames)
        await asyncio.sleep(0.5)
        assert len(page.frames) == count

    converse(work)


def test_an_idle_page_costs_no_processor_time(served, join, converse):
    async def work(http_session):
        page = await join(http_session, served)
        await page.until(lambda: any(note.get("soft") for note in page.notes))  # the soft skin is made ready once
        await page.send({"kind": "reset"})
        await page.until(lambda: page.frames and not page.frames[-1][4] & (wire.MOVING | wire.CLIP))
        await asyncio.sleep(0.5)
        count, before = len(page.frames), served.cpu()
        await asyncio.sleep(2.0)
        assert len(page.frames) == count
        assert served.cpu() - before <= 0.04

    converse(work)


def test_two_pages_show_the_same_hand(served, join, converse):
    async def work(http_session):
        one, two = await join(http_session, served), await join(http_session, served)
        await one.send({"kind": "reset"})
        await one.send({"kind": "set", "contraction": {"FDS3": 0.4}})
        await asyncio.sleep(1.5)
        await two.until(lambda: one.frames and two.frames and one.frames[-1] == two.frames[-1])

    converse(work)


def test_a_file_goes_only_to_the_page_that_asked(served, join, converse):
    async def work(http_session):
        one, two = await join(http_session, served), await join(http_session, served)
        await one.send({"kind": "save", "what": "pose"})
        await one.until(lambda: any(note["kind"] == "file" for note in one.notes))
        await asyncio.sleep(0.1)
        assert not any(note["kind"] == "file" for note in two.notes)

    converse(work)


def test_a_pose_and_a_clip_that_were_saved_load_again(served, join, converse, hand):
    async def work(http_session):
        page = await join(http_session, served)

        async def saved(what):
            page.notes.clear()
            await page.send({"kind": "save", "what": what})
            await page.until(lambda: any(note["kind"] == "file" for note in page.notes))
            return next(note for note in page.notes if note["kind"] == "file")

        def clock():
            return float(np.frombuffer(page.frames[-1], "<f4", 1, 12)[0])

        await page.send({"kind": "reset"})
        await page.send({"kind": "set", "contraction": {"FDP3": 0.6, "FDS3": 0.3}})
        await page.until(lambda: clock() < 0.3)  # the frames from before are gone
        await page.until(lambda: clock() > 0.6)  # on a busy machine the hand's clock is late
        await asyncio.sleep(0.5)
        kept = angles(page.frames[-1], hand)
        file, clip = await saved("pose"), await saved("clip")
        await page.send({"kind": "reset"})
        await page.until(lambda: np.abs(angles(page.frames[-1], hand) - kept).max() > 0.3)
        await page.send({"kind": "load", "text": file["text"], "name": file["name"]})
        await page.until(lambda: np.abs(angles(page.frames[-1], hand) - kept).max() < 0.02)
        page.notes.clear()
        await page.send({"kind": "load", "text": clip["text"], "name": clip["name"]})
        await page.until(lambda: any(note["kind"] == "status" and note["seconds"] > 0.5 for note in page.notes))

    converse(work)


@pytest.mark.parametrize("kind", ["csv", "glb", "html"])
def test_an_export_is_fetched_once_and_then_gone(served, join, converse, kind):
    async def work(http_session):
        page = await join(http_session, served)
        await page.send({"kind": "play", "clip": "fist"})
        await page.send({"kind": "export", "format": kind})
        await page.until(lambda: any("address" in note or note.get("good") is False for note in page.notes))
        note = next((note for note in page.notes if "address" in note), None)
        assert note, page.notes
        path = "/" + note["address"]
        assert served.get(path)[0] == 403
        status, headers, body = served.get(path, key=served.key)
        assert status == 200
        assert f'filename="{note["name"]}"' in headers["Content-Disposition"]
        assert served.get(path, key=served.key)[0] == 404
        return body

    body = converse(work)
    assert {"csv": body[:7] == b"time_s,", "glb": body[:4] == b"glTF", "html": b"<html" in body[:500].lower()}[kind]


# What it survives -------------------------------------------------------------------------------------------------------------


def test_ten_thousand_slider_events_leave_the_last_value(served, join, converse, hand):
    async def work(http_session):
        page, other = await join(http_session, served), await join(http_session, served)
        await page.send({"kind": "reset"})
        start = time.perf_counter()
        for k in range(10_000):
            await page.send({"kind": "set", "n": k, "contraction": {"FDP2": (k % 100) / 99.0 if k < 9_999 else 0.25}})
        await page.until(lambda: struct.unpack_from("<3I", page.frames[-1])[2] == 9_999)
        spent = time.perf_counter() - start
        column = wire.HEAD_WORDS + hand.muscle_names.index(hand.muscles["FDP2"].name)
        assert np.frombuffer(page.frames[-1], "<f4")[column] == np.float32(0.25)
        assert len(page.frames) < 80 * spent + 20  # events are many, frames are not
        await other.until(lambda: other.frames and np.frombuffer(other.frames[-1], "<f4")[column] == np.float32(0.25))
        assert spent < 20.0

    converse(work)


def test_a_page_that_draws_nothing_gets_two_frames_and_the_newest_when_it_is_back(served, join, converse):
    async def work(http_session):
        slow = await join(http_session, served, draws=False)
        quick = await join(http_session, served)
        await dressed(quick)
        await quick.send({"kind": "play", "clip": "fist"})
        await asyncio.sleep(1.0)
        assert len(slow.frames) <= 3
        assert len(quick.frames) > 25
        await quick.send({"kind": "pause"})
        await asyncio.sleep(0.2)
        await slow.drawn()
        await slow.until(lambda: slow.frames[-1] == quick.frames[-1])

    converse(work)


def test_a_page_that_goes_away_in_mid_clip_stops_the_work_and_nothing_else(served, join, converse):
    def time_of(frame):
        return struct.unpack_from("<f", frame, 12)[0]

    async def leave(http_session):
        page = await join(http_session, served)
        await page.send({"kind": "play", "clip": "fist"})
        await page.until(lambda: len(page.frames) > 10 and time_of(page.frames[-1]) > 0.1)
        for socket in (page.socket, page.looking):
            socket._response.connection.transport.abort()  # as a browser that was killed: no goodbye
        return time_of(page.frames[-1])

    left = converse(leave)
    time.sleep(0.2)
    before = served.cpu()
    time.sleep(1.5)
    assert served.cpu() - before <= 0.05

    async def come_back(http_session):
        page = await join(http_session, served)
        await page.until(lambda: len(page.frames) > 3)
        return time_of(page.frames[0])

    assert left <= converse(come_back) < left + 0.5  # the clip waited for somebody to look


@pytest.mark.parametrize(
    "message",
    [
        None, 7, "play", [], {}, {"kind": None}, {"kind": "explode"}, {"kind": "set"}, {"kind": "set", "contraction": {"FDP22": 1}},
        {"kind": "set", "contraction": {"FDP2": 7}}, {"kind": "set", "contraction": {"FDP2": float("nan")}}, {"kind": "seek", "t": "x"},
        {"kind": "hold", "joints": 3}, {"kind": "play", "clip": "../../etc/passwd"}, {"kind": "play", "speed": 1e9},
        {"kind": "load", "text": "{\"time\": [0, 1"}, {"kind": "load", "text": "[" * 100_000}, {"kind": "load", "text": b"\x80\x04K*."},
        {"kind": "load", "text": json.dumps({"time": [0, 1], "contraction": {"FDP2": [0, 9]}})},
        {"kind": "load", "text": "cos\nsystem\n(S'touch /tmp/handlab-was-here'\ntR."}, {"kind": "export", "format": "exe"},
    ],
)  # fmt: skip
def test_a_bad_message_is_answered_by_one_sentence(served, join, converse, message):
    async def work(http_session):
        page = await join(http_session, served)
        await page.send({"kind": "reset"})
        answer = await page.answer("handlab.message", message)
        assert "error" not in answer
        await page.until(lambda: any(note.get("good") is False for note in page.notes), 5.0)
        text = next(note["text"] for note in page.notes if note.get("good") is False)
        assert "Traceback" not in text
        assert "\n" not in text

    converse(work)
    assert served.alive()


def test_bytes_that_are_no_message_close_that_page_only(served, join, converse):
    async def work(http_session):
        good = await join(http_session, served)
        for rubbish in (
            b"",
            b"\xff" * 40,
            struct.pack("<III", 1, 0, 5) + b"\xc1\xc1\xc1\xc1\xc1",
            struct.pack("<III", 1, 0, 2**32 - 1) + b"x",
        ):
            socket = await http_session.ws_connect(f"ws://{served.host}:{served.port}/ws")
            await socket.send_bytes(rubbish)
            await socket.close()
        await good.send({"kind": "reset"})
        await good.until(lambda: good.frames)

    converse(work)
    assert served.alive()


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit of the size of files")
@pytest.mark.parametrize("kind", ["csv", "mp4"])
def test_a_full_disk_on_export_is_told_and_the_hand_moves_on(serve, join, converse, hand, kind):
    import resource

    server = serve()
    resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (4096, 4096))  # as if the disk were full after 4 kB

    async def work(http_session):
        page = await join(http_session, server)
        await page.send({"kind": "play", "clip": "fist"})
        await page.send({"kind": "export", "format": kind, "look": {"size": [128, 96]}})
        await page.until(lambda: any(note.get("good") is False for note in page.notes))
        text = next(note["text"] for note in page.notes if note.get("good") is False)
        assert text.startswith(f"no .{kind}")
        assert "File too large" in text or "file too large" in text or "cannot write" in text
        count = len(page.frames)
        await page.send({"kind": "play", "clip": "fist"})
        await page.until(lambda: len(page.frames) > count + 5)

    converse(work)
    assert server.alive()


def test_ctrl_c_ends_the_server_with_code_0_and_leaves_no_files(serve, tmp_path):
    server = serve(TMPDIR=str(tmp_path))
    assert server.stop() == 0
    assert server.said[-1].strip().endswith("Stopped.")
    assert list(tmp_path.iterdir()) == []
