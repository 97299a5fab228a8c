import csv

import imageio.v3 as iio
import numpy as np
import pytest

import handlab as hl
from handlab.show import film

SMALL = {"size": (320, 240)}


def test_a_film_read_again_has_its_frames_size_and_motion(grip, tmp_path, drawn):
    path = hl.save(grip, tmp_path / "grip.mp4", fps=30, **SMALL)
    frames = iio.imread(path)
    facts = iio.immeta(path)
    assert frames.shape == (16, 240, 320, 3)
    assert facts["fps"] == 30
    assert facts["codec"] == "h264"
    assert "yuv420p" in facts["pix_fmt"]
    for frame in frames:
        assert 0.05 < drawn(frame[:, :220]).mean() < 0.8
    hand_only = frames[:, :, :220].astype(int)
    assert np.abs(hand_only[-1] - hand_only[0]).mean() > 3


def test_the_motion_is_the_same_at_any_frame_rate(grip, tmp_path, drawn):
    slow = iio.imread(hl.save(grip, tmp_path / "slow.mp4", fps=10, muscles=False, **SMALL))
    fast = iio.imread(hl.save(grip, tmp_path / "fast.mp4", fps=50, muscles=False, **SMALL))
    assert (len(slow), len(fast)) == (6, 26)
    for k, frame in enumerate(slow):
        same = np.abs(frame.astype(int) - fast[5 * k].astype(int)).mean()
        assert same < 2.0
    assert np.abs(fast[25].astype(int) - fast[0].astype(int)).mean() > 4.0


def test_a_gif_read_again_moves(grip, tmp_path, drawn):
    path = hl.save(grip, tmp_path / "grip.gif", fps=10, muscles=False, **SMALL)
    frames = iio.imread(path)
    assert frames.shape == (6, 240, 320, 3)
    assert all(0.05 < drawn(frame).mean() < 0.8 for frame in frames)
    assert np.abs(frames[-1].astype(int) - frames[0].astype(int)).mean() > 3


def test_a_still_of_a_hand_has_the_size_asked_for(hand, tmp_path, drawn):
    picture = iio.imread(hl.save(hand, tmp_path / "hand.png", **SMALL))
    assert picture.shape == (240, 320, 3)
    assert drawn(picture).mean() > 0.05


def test_a_picture_of_a_clip_shows_five_moments_below_each_other(grip, tmp_path, drawn):
    picture = iio.imread(hl.save(grip, tmp_path / "grip.png", size=(300, 200)))
    assert picture.shape == (1000, 300, 3)
    assert all(drawn(picture[200 * k : 200 * (k + 1), :200]).any() for k in range(5))


def test_views_stand_beside_each_other_and_skins_below(hand, tmp_path, drawn):
    path = hl.save(hand, tmp_path / "grid.png", view=["palm", "back"], skin=["solid", "hidden"], size=(400, 400))
    picture = iio.imread(path)
    tiles = [drawn(picture[y : y + 200, x : x + 200]).mean() for y in (0, 200) for x in (0, 200)]
    assert all(share > 0.04 for share in tiles)
    assert tiles[2] < 0.7 * tiles[0]


def test_a_state_is_drawn_with_its_hand(hand, tmp_path):
    state = hl.pose(hand, {"mcp2.flexion_extension": 1.0})
    assert hl.save(state, tmp_path / "state.png", hand=hand, **SMALL).stat().st_size > 1000


def test_a_table_holds_the_clip(grip, tmp_path):
    path = hl.save(grip, tmp_path / "grip.csv")
    with path.open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(grip.time)
    assert float(rows[-1]["time_s"]) == pytest.approx(grip.time[-1])
    k = grip.hand.dof_names.index("pip2.flexion_extension")
    assert float(rows[-1]["pip2.flexion_extension.angle_deg"]) == pytest.approx(np.rad2deg(grip.angle[-1, k]), rel=1e-6)


def test_a_hand_has_no_table_over_time(hand, tmp_path):
    with pytest.raises(ValueError, match="save a clip"):
        hl.save(hand, tmp_path / "hand.csv")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["grip.avi", "grip", "grip.mp4.txt"])
def test_an_unknown_format_is_answered_with_the_known_ones(grip, tmp_path, name):
    with pytest.raises(ValueError, match=r"\.mp4, \.gif, \.png, \.csv"):
        hl.save(grip, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_does_not_exist_is_named_before_any_work(grip, tmp_path, monkeypatch):
    monkeypatch.setattr(film, "frames", lambda *_: pytest.fail("it drew"))
    with pytest.raises(FileNotFoundError, match="nowhere"):
        hl.save(grip, tmp_path / "nowhere" / "grip.mp4")


def test_a_folder_that_cannot_be_written_to_is_named_before_any_work(grip, monkeypatch):
    monkeypatch.setattr(film, "frames", lambda *_: pytest.fail("it drew"))
    with pytest.raises(OSError, match="/proc"):
        hl.save(grip, "/proc/grip.mp4")


@pytest.mark.parametrize("suffix", [".mp4", ".gif", ".png"])
def test_a_failure_in_the_middle_leaves_no_file_and_keeps_the_old_one(grip, tmp_path, monkeypatch, suffix):
    path = tmp_path / f"grip{suffix}"
    path.write_text("old")
    seen = []

    def broken(tiles, moment, **_):
        seen.append(moment)
        if len(seen) == 3:
            raise RuntimeError("the disk is full")
        return np.zeros((240, 320, 3), np.uint8)

    monkeypatch.setattr("handlab.show.tiles.Tiles.picture", broken)
    with pytest.raises(RuntimeError, match="disk is full"):
        hl.save(grip, path, **SMALL)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    assert path.read_text() == "old"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"view": "plam"}, "palm"),
        ({"skin": "glass"}, "translucent"),
        ({"size": (10, 10)}, "64"),
        ({"fps": 0}, "frames per second"),
        ({"fps": float("nan")}, "frames per second"),
        ({"view": []}, "at least one view"),
    ],
)
def test_a_wrong_option_is_refused_before_any_work(grip, tmp_path, options, message):
    with pytest.raises((ValueError, KeyError), match=message):
        hl.save(grip, tmp_path / "grip.mp4", **options)
    assert not list(tmp_path.iterdir())


def test_an_odd_size_becomes_even_because_films_need_it(grip, tmp_path):
    assert iio.imread(hl.save(grip, tmp_path / "odd.mp4", size=(321, 241), fps=10)).shape[1:3] == (240, 320)


def test_long_work_shows_its_progress(capsys, monkeypatch):
    from handlab.show.outputs import progress

    monkeypatch.setattr("tqdm.auto.tqdm.__init__", lambda self, items, **options: capsys and setattr(self, "options", options))
    bar = progress([1, 2], "grip.mp4", 2)
    assert bar.options["delay"] == 1.0
    assert bar.options["total"] == 2


def test_a_sheet_has_a_row_per_posture_and_a_column_per_view_and_skin(hand, tmp_path, drawn):
    states = {"relaxed": hl.rest(hand), "bent": hl.pose(hand, {"pip2.flexion_extension": 1.2})}
    image = np.asarray(hl.sheet(hand, states, tmp_path / "sheet.png", view=["palm", "back"], tile=(100, 120)))
    margin, head = 42, 19
    assert image.shape == (head + 2 * 120, margin + 4 * 100, 3)
    assert all(
        drawn(image[head + 120 * r : head + 120 * (r + 1), margin + 100 * c : margin + 100 * (c + 1)]).mean() > 0.04
        for r in range(2)
        for c in range(4)
    )
    assert not drawn(image[:, :margin]).any()
    assert not drawn(image[:head]).any()
    assert np.array_equal(iio.imread(tmp_path / "sheet.png"), image)


@pytest.mark.xdist_group("pictures")
def test_muscles_are_drawn_under_a_translucent_skin_and_nothing_of_them_under_a_solid_one(hand, grip, tmp_path):
    from handlab.show.moments import story
    from handlab.show.tiles import Tiles, layout

    def seen(skin, layers):
        told = story(grip)
        tiles = Tiles(told, layout("palm", skin, size=(300, 380), muscles=False, layers=layers), quality="film")
        try:
            return tiles.picture(told.at(0.5)).astype(int)
        finally:
            tiles.close()

    assert np.array_equal(seen("solid", ()), seen("solid", ("muscles", "tendons")))
    bare, flesh = seen("translucent", ()), seen("translucent", ("muscles",))
    changed = np.abs(bare - flesh).max(axis=2) > 12
    assert 0.005 < changed.mean() < 0.2
    assert (flesh - bare)[changed][:, 1].mean() < -20  # red takes the green away
    with pytest.raises(LookupError, match="did you mean muscles"):
        hl.save(grip, tmp_path / "a.png", layers=["muscels"])
