"""The fitting panel of a notebook: what code can do, what a page sends, what is kept, and how things are said."""

import json
import re
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import handlab as hl
from handlab.fitting.fit import fit_points
from handlab.fitting.landmarks import LANDMARKS, NAMES, read_landmarks
from handlab.fitting.mistakes import FitError, FitQuestion
from handlab.fitting.preview import sketch
from handlab.show.complexion import complexion
from handlab.show.fit_clicks import Clicks, read, read_file
from handlab.show.fit_drawing import drawing
from handlab.show.fit_keepsakes import open_hand
from handlab.show.fit_room import FitRoom
from handlab.show.fit_words import CALLED, ORDER, plain, points, trouble

sys.path.insert(0, str(Path(__file__).parents[1] / "fitting"))  # for people.py and photograph.py
import people
import photograph


@pytest.fixture(scope="module")
def shot():
    return photograph.photograph(people.everyone()["woman"], view="palmar", ground="light")


@pytest.fixture(scope="module")
def whole(shot):
    """All that a user says, as the page sends it."""
    scale = {"ruler": [list(map(float, end)) for end in shot.ruler], "mm": photograph.RULER_MM}
    return {
        "landmarks": {name: list(map(float, at)) for name, at in shot.marks.items()},
        "scale": scale,
        "view": "palmar",
        "camera_mm": 600,
    }


@pytest.fixture
def file(shot, tmp_path, monkeypatch):
    """A photograph in the current folder."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "me.png"
    Image.fromarray(shot.pixels).save(path)
    return path


@pytest.fixture
def room(shot):
    made = FitRoom()
    made.open(shot.pixels, "me.png")
    return made


# Words and drawing ---------------------------------------------------------------------------------------------------------------


def test_every_point_is_asked_for_once_and_has_a_name_of_its_own():
    assert sorted(ORDER) == sorted(NAMES)
    texts = [row["text"] for row in points()]
    assert len(set(texts)) == 26
    assert not any("_" in text for text in texts)


CODE = re.compile(r"=|\w_\w|\bsay \w|True|None")


@pytest.mark.parametrize(
    "error",
    [
        FitQuestion("this hand would be 412 mm long; check the scale; or say sure=True if it is right", choices=({"sure": True},)),
        FitQuestion(
            "this is the palm of a right hand or the back of a left hand, and points cannot tell which; "
            "say view='palmar' or view='dorsal' (or side='right' or side='left')",
            choices=({"view": "palmar"}, {"view": "dorsal"}),
        ),
        FitError("tip_index and tip_ring look exchanged: swap them, or say sure=True", names=("tip_index", "tip_ring")),
        FitError("give side='left' or view='dorsal', or mirror=True if the picture itself is mirrored"),
    ],
)
def test_what_code_would_write_never_reaches_the_page(error):
    told = trouble(error)
    assert CODE.search(str(error))
    assert not CODE.search(told["text"]), told["text"]
    assert told["choices"]
    assert not any(CODE.search(choice["label"]) for choice in told["choices"])


def test_every_refusal_of_a_whole_fit_is_said_without_code(room, whole):
    at = whole["landmarks"]
    wrong = {
        "40 cm": {"scale": {**whole["scale"], "mm": 330.0}},
        "swapped": {"landmarks": {**at, "tip_index": at["tip_ring"], "tip_ring": at["tip_index"]}},
        "one place": {"landmarks": {**at, "pip_ring": at["tip_ring"]}},
        "few": {"landmarks": {name: at[name] for name in ORDER[:3]}},
        "none": {"landmarks": {}},
        "outside": {"landmarks": {**at, "tip_ring": [-40.0, 3.0]}},
        "line": {"landmarks": {name: [10.0 + 9 * k, 20.0 + 9 * k] for k, name in enumerate(ORDER[:6])}},
        "which": {"view": None},
        "both": {"side": "left"},
        "no scale": {"scale": {}},
        "half a ruler": {"scale": {"ruler": whole["scale"]["ruler"]}},
    }
    for kind, change in wrong.items():
        told = room.ask({"kind": "fit", "clicks": {**whole, **change}})
        assert not told["good"], kind
        assert told["text"].endswith(tuple("abcdefghijklmnopqrstuvwxyz)?”")), (kind, told["text"])
        assert not CODE.search(told["text"]), (kind, told["text"])
        assert room.clicks == read({**whole, **change})  # nothing clicked is lost


def test_the_drawing_s_thumb_lies_right_in_a_palm_and_left_on_a_back_and_marks_lie_on_it():
    for view, side in (("palmar", 1), ("dorsal", -1)):
        made = drawing(view)
        assert (made.places["tip_thumb"][0] - made.places["tip_little"][0]) * side > 0.3
        assert made.places["tip_middle"][1] < made.places["wrist_radial"][1]
        import io

        alpha = np.asarray(Image.open(io.BytesIO(made.png)))[..., 3]
        height, width = alpha.shape
        for name, (u, v) in made.places.items():
            x, y = int(u * width), int(v * height)
            assert alpha[max(y - 8, 0) : y + 9, max(x - 8, 0) : x + 9].max() > 200, (view, name)


# The outline that answers a click ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("names", [ORDER, ORDER[:12]])
def test_the_quick_outline_is_that_of_the_finished_hand(hand, shot, names):
    clicks = {name: shot.marks[name] for name in names}
    how = {"view": "palmar", "camera_mm": 600.0, "centre_px": np.array(shot.pixels.shape[1::-1]) / 2}
    from handlab.fitting.calibration import Scale

    scale = Scale(1 / photograph.PX_PER_MM, "given")
    quick = sketch(hand, clicks, scale, **how)
    slow = fit_points(hand, clicks, scale, **how).with_picture(None, shot.pixels.shape[1::-1])
    from scipy.spatial import cKDTree

    apart = cKDTree(slow.outline).query(quick.outline)[0]
    assert np.quantile(apart, 0.99) < 2.0  # px, 0.5 mm: two pixels of its coarse grid
    assert quick.side == slow.side == "right"
    for name, place in clicks.items():
        assert np.linalg.norm(np.array(quick.places[name]) - place) < 2.5


def test_the_outline_comes_from_the_fourth_point_on_and_fits_better_and_better(room, whole):
    overlaps = []
    for count in range(1, 27):
        told = room.ask({"kind": "clicks", "clicks": {**whole, "landmarks": {name: whole["landmarks"][name] for name in ORDER[:count]}}})
        assert told["good"]
        assert ("sketch" in told) == (count >= 4)
        if count >= 4:
            overlaps.append(told["sketch"]["iou"])
    assert overlaps[-1] > 0.93
    assert min(overlaps[3:]) > 0.88
    assert overlaps[0] < overlaps[-1]


# The panel ---------------------------------------------------------------------------------------------------------------------


def test_what_a_click_does_code_does_too_and_the_hand_moves(file, whole):
    panel = hl.FitPanel(file)
    assert "0 of 26 points" in repr(panel)
    with pytest.raises(FitError, match="how large is a pixel"):
        _ = panel.fit
    panel.set(**{key: value for key, value in whole.items() if key != "landmarks"})
    panel.set(landmarks=dict(list(whole["landmarks"].items())[:20]))
    panel.set(landmarks=dict(list(whole["landmarks"].items())[20:]))
    assert panel.fit.side == "right"
    assert panel.fit.iou > 0.9
    assert panel.hand.name == "me"
    clip = hl.simulate(panel.hand, "fist", seconds=1.5)
    assert 30.0 < np.rad2deg(np.abs(clip.angle[-1] - clip.angle[0]).max()) < 110.0
    with pytest.raises(TypeError, match="there is no colour"):
        panel.set(colour="red")
    with pytest.raises(ValueError, match="view is 'side'"):
        panel.set(view="side")
    assert panel.clicks.view == "palmar"


def test_clicks_are_kept_after_every_change_and_found_again_for_the_same_picture_only(file, whole, shot):
    panel = hl.FitPanel(file)
    panel.set(landmarks={"tip_index": (100.5, 200.25), "dip_index": None}, view="palmar")
    kept = file.with_name("me.points.json")
    assert panel.file == Path(kept.name)
    assert read_landmarks(kept) == {"tip_index": (100.5, 200.25), "dip_index": None}
    again = hl.FitPanel(file)
    assert again.clicks == panel.clicks
    Image.fromarray(255 - shot.pixels).save(file)
    other = hl.FitPanel(file)
    assert other.clicks == Clicks()
    other.set(view="dorsal")
    assert other.file == Path("me.points-2.json")
    assert read(json.loads(kept.read_text())).view == "palmar"  # untouched
    with pytest.raises(ValueError, match="something else"):
        hl.FitPanel(file, keep=kept)
    hl.FitPanel(file, keep=False).set(view="palmar")
    assert sorted(path.name for path in file.parent.iterdir()) == ["me.png", "me.points-2.json", "me.points.json"]


def test_a_saved_hand_loads_back_bit_by_bit_with_its_colours(file, whole):
    panel = hl.FitPanel(file, keep=False)
    panel.set(**whole)
    hand = open_hand(panel.save("me.zip"))
    assert np.array_equal(hand.skin.points, panel.hand.skin.points)
    assert np.array_equal(hand.lever_arm, panel.hand.lever_arm)
    assert np.array_equal(hand.picture, panel.hand.picture)
    assert "index, metacarpal" in panel.save("me.txt").read_text()
    assert Image.open(panel.save("me.jpg")).size == (panel.room.photo.size)
    with pytest.raises(ValueError, match=r"\.zip, \.jpg, \.txt"):
        panel.save("me.docx")
    Path("me.zip").write_bytes(b"no archive")
    with pytest.raises(ValueError, match="no archive with a hand"):
        open_hand("me.zip")


class Front:
    """The page's side of the panel."""

    def __init__(self, panel):
        pytest.importorskip("anywidget")
        self.panel, self.got = panel, []
        panel.page.widget.send = lambda content, buffers=None: self.got.append(content)

    def asks(self, message, data=None, parts=1):
        pieces = [[]] if data is None else [[data[k * len(data) // parts : (k + 1) * len(data) // parts]] for k in range(parts)]
        for k, piece in enumerate(pieces):
            self.panel.page.hear(
                None,
                {"page": "p", "id": len(self.got) + 7, "message": message, "part": k, "of": len(pieces), "data": data is not None},
                piece,
            )
        return self.got[-1]["reply"]


def test_a_page_sends_a_picture_in_parts_then_clicks_and_moves_the_hand(file, whole):
    panel = hl.FitPanel()
    front = Front(panel)
    assert front.asks({"kind": "hello"})["good"]
    assert front.asks({"kind": "clicks", "clicks": whole})["missing"] == "picture"
    told = front.asks({"kind": "picture", "name": "../../me.png"}, file.read_bytes(), parts=3)
    assert told["good"]
    assert told["picture"]["name"] == "me.png"
    assert front.asks({"kind": "clicks", "clicks": whole})["sketch"]["iou"] > 0.9
    assert Path("me.points.json").is_file()
    assert front.asks({"kind": "move"})["good"]
    assert panel.view.hand is panel.hand
    assert not np.array_equal(complexion(panel.hand), complexion(panel.hand.with_(picture=None)))
    assert len(panel.widget.children) == 2
    panel.set(landmarks={"tip_index": (300, 300)})
    assert front.got[-1]["told"]["landmarks"]["tip_index"] == [300.0, 300.0]


def test_points_are_guessed_and_the_guess_is_near_enough_to_correct(room, shot):
    found = room.ask({"kind": "find", "view": "palmar"})["landmarks"]
    assert set(found) == set(NAMES)
    off = {name: np.linalg.norm(np.array(found[name]) - at) / photograph.PX_PER_MM for name, at in shot.marks.items()}
    assert max(off[name] for name in NAMES if name.startswith("tip")) < 6.0  # mm
    assert max(off.values()) < 20.0


def test_a_large_picture_is_made_smaller_for_the_page_and_clicks_stay_those_of_its_own_pixels(shot, whole):
    large = np.asarray(Image.fromarray(shot.pixels).resize((4 * shot.pixels.shape[1], 4 * shot.pixels.shape[0])))
    room, factor = FitRoom(), 4.0
    room.open(large, "large.png")
    assert max(room.photo.shown.size) == 2400
    scale = {"ruler": [[factor * x for x in end] for end in whole["scale"]["ruler"]], "mm": photograph.RULER_MM}
    marks = {name: [factor * x for x in at] for name, at in whole["landmarks"].items()}
    told = room.ask({"kind": "clicks", "clicks": {**whole, "landmarks": marks, "scale": scale}})
    assert told["sketch"]["iou"] > 0.93
    assert abs(told["scale"]["mm_per_px"] * factor * photograph.PX_PER_MM - 1.0) < 1e-3
    assert np.linalg.norm(np.array(told["sketch"]["places"]["tip_index"]) - marks["tip_index"]) < 4 * factor


def test_messages_that_are_nonsense_are_answered_and_change_nothing(room, whole):
    room.ask({"kind": "clicks", "clicks": whole})
    before = room.clicks
    bad = [
        None, [], {"kind": "clap"}, {"kind": "clicks", "clicks": 3}, {"kind": "clicks", "clicks": {"landmarks": {"tip_index": ["x", 1]}}},
        {"kind": "clicks", "clicks": {"landmarks": {"tip_index": [float("nan"), 1]}}},
        {"kind": "clicks", "clicks": {"scale": {"coin": [1, 2], "name": "doubloon"}}},
        {"kind": "clicks", "clicks": {"camera_mm": 3}}, {"kind": "read", "name": "a.csv", "text": "tip_index,1"}, {"kind": "picture"},
        {"kind": "file", "what": "soul"}, {"kind": "move"},
    ]  # fmt: skip
    for message in bad:
        told = room.ask(message)
        assert not told["good"], message
        assert len(told["text"]) > 15
        assert room.clicks == before
    assert room.ask({"kind": "fit"})["good"]


def test_two_pages_at_once_get_answers_of_their_own(room, whole):
    answers = {}

    def asks(count):
        part = {name: whole["landmarks"][name] for name in ORDER[:count]}
        answers[count] = room.ask({"kind": "clicks", "clicks": {**whole, "landmarks": part}})

    threads = [threading.Thread(target=asks, args=(count,)) for count in (2, 10, 26)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert ["sketch" in answers[count] for count in (2, 10, 26)] == [False, True, True]


def test_files_of_points_with_or_without_a_scale_are_read(whole):
    found = read_file("a.json", json.dumps(whole))
    assert found == read(whole)
    assert read_file("a.csv", "name,x_px,y_px\ntip_index,10,20\ndip_index,,\n").landmarks == {"tip_index": (10.0, 20.0), "dip_index": None}
    with pytest.raises(ValueError, match="line 2"):
        read_file("a.csv", "tip_index,1,2\ntip_ring,oops\n")


def test_names_in_messages_become_what_the_page_calls_them():
    for name in LANDMARKS:
        assert plain(f"{name} is far off") == f"“{CALLED[name]}” is far off"
    assert plain("me.png is empty") == "me.png is empty"
