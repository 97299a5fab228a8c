"""Films in a process of their own: what they show, and what happens where they cannot be drawn."""

import asyncio
import os

import imageio.v3 as iio
import numpy as np
import pytest

import handlab as hl
from handlab.show.app import files
from handlab.show.app.drawing import DrawingFailed, aimed, draw, pack, unpack, why
from handlab.show.session import Session
from handlab.show.views import camera

TINY = {"size": (96, 64), "fps": 10.0, "muscles": False}


@pytest.fixture(scope="module")
def clip():
    return hl.simulate(hl.load_hand(side="left"), {"FDP2": [(0.0, 0.0), (0.3, 0.6)]}, seconds=0.3)


def test_a_recording_goes_through_a_file_unchanged(clip, tmp_path):
    pack(clip, tmp_path / "one.npz")
    again = unpack(tmp_path / "one.npz", clip.hand, clip.fps, "again")
    assert all(np.array_equal(getattr(again, name), getattr(clip, name)) for name in ("time", "angle", "contraction", "force", "torque"))


def test_a_recording_that_holds_code_is_refused(clip, tmp_path):
    np.savez(tmp_path / "evil.npz", time=np.array([print], dtype=object))
    with pytest.raises(ValueError, match="allow_pickle"):
        unpack(tmp_path / "evil.npz", clip.hand, 60.0, "")


def test_the_page_s_camera_is_the_camera_of_the_picture(clip):
    want = camera(clip.hand, "oblique", [clip.hand.skin.points], 1.5)
    given = {"eye": (want.to_eye * 1.001).tolist(), "up": want.up.tolist(), "focus": want.focus.tolist(), "distance": want.distance}
    got = aimed(given)
    for name in ("to_eye", "up", "right", "focus"):
        assert getattr(got, name) == pytest.approx(getattr(want, name), abs=1e-9)
    assert got.position == pytest.approx(want.position)


@pytest.mark.parametrize(
    "broken", [{"eye": [0, 0, 0]}, {"eye": [1, 0, 0], "up": [1, 0, 0]}, {"distance": 0}, {"distance": float("nan")}, {"focus": [1, 2]}]
)
def test_a_camera_that_sees_nothing_is_refused(broken):
    with pytest.raises(ValueError, match=r"camera|operands|dimension"):
        aimed({"eye": [0, 1, 0], "up": [1, 0, 0], "focus": [0, 0, 0], "distance": 1.0, **broken})


def test_a_film_is_drawn_by_another_process_and_leaves_nothing_else(clip, tmp_path):
    out = tmp_path / "film.mp4"
    asyncio.run(draw(clip, out, TINY, tmp_path))
    assert iio.imread(out).shape == (4, 64, 96, 3)
    assert [path.name for path in tmp_path.iterdir()] == ["film.mp4"]


@pytest.mark.skipif(os.name != "posix", reason="windows of X exist on Linux only")
def test_a_crash_of_the_graphics_library_is_told_with_what_to_install(clip, tmp_path, monkeypatch):
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkXOpenGLRenderWindow")
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(DrawingFailed, match="libegl1"):
        asyncio.run(draw(clip, tmp_path / "film.png", TINY, tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_the_last_line_of_a_failed_process_is_the_sentence():
    assert why(1, "Traceback\n  somewhere\n\nno library to draw with\n") == "no library to draw with"
    assert "code 3" in why(3, "")
    assert "libegl1" in why(-11, "")


def test_only_plain_values_of_a_page_steer_the_drawing():
    session = Session(hl.load_hand())
    look = {
        "skin": "translucent", "view": 7, "bones": "yes", "muscles": False, "size": [10_000, 1], "camera": {"eye": "__import__('os')"},
        "story": 1, "out": "/etc/passwd", "fps": 1e9,
    }  # fmt: skip
    session.message({"kind": "export", "format": "png", "look": look})
    assert files.arguments(session.wishes()[0]) == {"skin": "translucent", "muscles": False, "size": [1920, 64]}


def test_a_full_disk_leaves_no_half_file_and_the_next_export_works(tmp_path, monkeypatch):
    session = Session(hl.load_hand())
    session.message({"kind": "play", "clip": "fist"})
    session.message({"kind": "export", "format": "csv"})
    session.message({"kind": "export", "format": "csv"})
    first, second = session.wishes()
    kept = files.write

    async def full(wish, path, folder):
        path.write_text("half")
        raise OSError(28, "No space left on device")

    async def main():
        made = files.Files()
        monkeypatch.setattr(files, "write", full)
        with pytest.raises(OSError, match="No space"):
            await made.fulfil(first)
        assert list(made.folder.iterdir()) == []
        monkeypatch.setattr(files, "write", kept)
        reply = await made.fulfil(second)
        assert reply["name"] == "fist.csv"
        word = reply["address"].rpartition("/")[2]
        assert made.find(word).path.stat().st_size > 1000
        folder = made.folder
        made.close()
        assert not folder.exists()

    asyncio.run(main())


def test_files_that_nobody_fetches_do_not_pile_up(monkeypatch):
    session = Session(hl.load_hand())

    async def small(wish, path, folder):
        path.write_text("x")

    async def main():
        made = files.Files()
        monkeypatch.setattr(files, "write", small)
        for _ in range(files.MOST_KEPT + 5):
            session.message({"kind": "export", "format": "html"})
            await made.fulfil(session.wishes()[0])
        assert len(list(made.folder.iterdir())) == files.MOST_KEPT
        made.close()

    asyncio.run(main())


@pytest.mark.slow
def test_a_picture_of_another_hand_is_drawn_with_that_hand(tmp_path):
    child = hl.load_hand("child")
    for name, own in (("child", child), ("reference", hl.load_hand())):
        clip = hl.simulate(own, "fist", seconds=0.05)
        asyncio.run(draw(clip, tmp_path / f"{name}.png", {"view": "palm", "size": [320, 320]}, tmp_path))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["child.png", "reference.png"]  # nothing is left behind
    hl.save(hl.simulate(child, "fist", seconds=0.05), tmp_path / "here.png", size=(320, 320))
    there, here, other = (iio.imread(tmp_path / f"{name}.png")[..., :3].astype(int) for name in ("child", "here", "reference"))
    assert np.abs(there - here).mean() < 0.5
    assert np.abs(there - other).mean() > 2.0
