"""Guesses of the feature points, from computed pictures whose points are known and from two real ones that were clicked by eye."""

import json
import os
from pathlib import Path

import numpy as np
import people
import photograph
import pytest

from handlab.fitting import found_joints
from handlab.fitting.fit import fit_photo
from handlab.fitting.found import find_landmarks
from handlab.fitting.landmarks import NAMES

PHOTOS = os.environ.get("HANDLAB_PHOTOS")
ANNOTATED = json.loads((Path(__file__).parents[1] / "data" / "photographs.json").read_text(encoding="utf-8"))
CASES = (
    ("woman_2", "pinhole", "palmar", False, 0.0, "dark"),
    ("man_3", "flatbed", "dorsal", False, 1.4, "light"),
    ("child_1", "pinhole", "dorsal", True, -2.1, "green"),
    ("mixture_4", "flatbed", "palmar", True, 3.0, "dark"),
)


def off_mm(guess, true, mm_per_px):
    return {name: mm_per_px * float(np.hypot(*np.subtract(guess[name], place))) for name, place in true.items()}


@pytest.mark.parametrize(("name", "camera", "view", "left", "turn", "ground"), CASES)
def test_the_outline_tells_tips_and_webs_of_any_hand_turned_in_any_way(name, camera, view, left, turn, ground):
    person = people.everyone(people.FRESH)[name]
    picture = photograph.photograph(person, camera=camera, view=view, left=left, turn=turn, ground=ground)
    guess = find_landmarks(picture.pixels, view=view, by="outline")
    off = off_mm(guess, picture.marks, 1.0 / photograph.PX_PER_MM)
    assert tuple(guess) == NAMES == tuple(name for name in NAMES if name in off)
    print(
        name, {kind: round(float(np.mean([v for k, v in off.items() if k.startswith(kind)])), 1) for kind in ("tip", "web", "pip", "mcp")}
    )
    assert np.mean([off[name] for name in NAMES if name.startswith("tip")]) < 2.0
    assert np.mean([off[name] for name in NAMES if name.startswith("web")]) < 4.0
    assert 0.5 < np.mean(list(off.values())) < 4.5
    assert max(off.values()) < 16.0


def test_the_guess_alone_already_gives_a_hand_of_the_right_side():
    person = people.everyone(people.FRESH)["man_1"]
    picture = photograph.photograph(person, view="palmar", left=True, seed=3)
    guess = find_landmarks(picture.pixels, by="outline")
    scale = {"ruler": picture.ruler, "mm": photograph.RULER_MM}
    fit = fit_photo(picture.pixels, landmarks=guess, scale=scale, view="palmar")
    assert fit.side == "left" and 0.85 < fit.iou < 1.0


@pytest.mark.parametrize("name", ["hand_a.jpg", "hand_b.jpg"])
@pytest.mark.parametrize(("by", "most"), [("outline", 8.0), ("mediapipe", 4.5)])
def test_the_guess_on_a_real_picture_is_a_few_millimetres_off(name, by, most):
    if not PHOTOS or not (Path(PHOTOS) / name).is_file():
        pytest.skip("HANDLAB_PHOTOS names no folder with the two real pictures")
    if by == "mediapipe" and not found_joints.installed():
        pytest.skip("mediapipe is not installed")
    row = ANNOTATED[name]
    mm_per_px = row["coin"]["diameter_mm"] / np.hypot(*np.subtract(*row["coin"]["ends_px"]))
    off = off_mm(find_landmarks(Path(PHOTOS) / name, by=by), row["landmarks"], mm_per_px)
    print(name, by, f"mean {np.mean(list(off.values())):.1f} mm, worst {max(off.values()):.1f} mm")
    assert 1.0 < np.mean(list(off.values())) < most
    assert np.mean([v for k, v in off.items() if k.startswith("tip")]) < 3.5


def disc(radius=150, ground=20):
    pixels = np.full((600, 500, 3), ground, np.uint8)
    y, x = np.mgrid[0:600, 0:500]
    pixels[np.hypot(x - 250, y - 300) < radius] = [200, 150, 130]
    return pixels


def test_a_picture_without_five_fingers_says_what_to_do():
    with pytest.raises(ValueError, match="fingers were found instead of five; spread the fingers"):
        find_landmarks(disc(), by="outline")
    with pytest.raises(ValueError, match="nothing stands out"):
        find_landmarks(np.full((400, 300, 3), 90, np.uint8), by="outline")
    with pytest.raises(ValueError, match="by is 'magic'"):
        find_landmarks(disc(), by="magic")


def test_without_the_extra_package_its_name_is_told(monkeypatch):
    monkeypatch.setattr(found_joints, "installed", lambda: False)
    with pytest.raises(ValueError, match=r"handlab\[points\].*mediapipe==0\.10\.21"):
        find_landmarks(disc(), by="mediapipe")


def test_joints_that_were_found_are_kept_and_the_outline_gives_the_rest(monkeypatch):
    """As if the model had seen every joint where it is."""
    picture = photograph.photograph(people.everyone(people.FRESH)["woman_4"], view="palmar", seed=1)
    seen = {name: place for name, place in picture.marks.items() if name.startswith(("tip", "dip", "pip", "mcp", "ip"))}
    wrist = (picture.marks["wrist_radial"] + picture.marks["wrist_ulnar"]) / 2.0
    monkeypatch.setattr(found_joints, "installed", lambda: True)
    monkeypatch.setattr(found_joints, "joints", lambda pixels: {**seen, "wrist": wrist})
    off = off_mm(find_landmarks(picture.pixels), picture.marks, 1.0 / photograph.PX_PER_MM)
    assert max(off[name] for name in seen if not name.startswith("tip")) < 1e-6
    assert 0.1 < np.mean(list(off.values())) < 1.5
    # fingers that cannot be told apart from the ground: joints alone
    monkeypatch.setattr("handlab.fitting.found.small_mask", lambda *given: (_ for _ in ()).throw(ValueError("no outline")))
    off = off_mm(find_landmarks(picture.pixels), picture.marks, 1.0 / photograph.PX_PER_MM)
    assert max(off[name] for name in seen) < 1e-6 and np.mean(list(off.values())) < 4.0
