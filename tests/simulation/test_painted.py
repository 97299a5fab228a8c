"""Painted muscles in use: one keyword, and the skin above them rises."""

from dataclasses import replace

import numpy as np
import pytest

import handlab as hl
from handlab.anatomy.grids import as_text, load_grids, save_grids
from handlab.show.session import Session
from handlab.simulation.geometric_muscle import geometric_muscles, muscles_of
from handlab.simulation.painted import grids_of, with_painted
from handlab.simulation.skin import normals

SOFT = "springs and muscles"


@pytest.fixture(scope="module")
def grid():
    """Under the skin of the ball of the little finger, but driven by a muscle of the thumb: nothing shipped does that."""
    shipped = next(one for one in load_grids() if one.name == "abductor_digiti_minimi")
    return replace(shipped, name="impostor", drives=("flexor_pollicis_longus",))


@pytest.fixture(scope="module")
def painted(hand, grid):
    return with_painted(hand, grid)


def rise(hand, contraction):
    """How far the skin rises in half a second while all bones are held."""
    clip = hl.simulate(hand, contraction, seconds=0.5, fps=30, skin=SOFT, muscles="geometric")
    return ((clip.skin(-1) - clip.skin(0)) * normals(hand, clip.skin(0))).sum(axis=1)


def test_a_painted_muscle_lifts_the_skin_above_it_when_its_pseudo_muscle_contracts(hand, painted):
    drive = {"time": [0.0, 0.1], "FPL": [0.0, 1.0]}
    without, with_it = rise(hand, drive), rise(painted, drive)
    muscles = geometric_muscles(painted)
    net = hl.soft_skin(painted)
    over = np.unique(net.ties.node[muscles.owner[net.ties.ellipsoid.astype(int)] == muscles.index("impostor")])
    assert without[over].max() < 1e-4 < 3e-4 < with_it[over].max() < 0.003  # it shares its place with the shipped muscle there
    assert np.abs(np.delete(with_it - without, over)).max() < 0.0007


def test_simulate_takes_painted_muscles_by_one_keyword_and_its_clip_knows_them(hand, grid):
    clip = hl.simulate(hand, "pinch", seconds=0.1, painted=grid)
    assert clip.hand is not hand and hand.grids is None
    assert set(geometric_muscles(clip.hand).names) == {*geometric_muscles(hand).names, "impostor"}
    np.testing.assert_array_equal(clip.angle, hl.simulate(hand, "pinch", seconds=0.1).angle)  # no force comes of them


def test_painted_muscles_come_as_grid_list_muscles_file_folder_or_panel(hand, grid, tmp_path):
    file = save_grids(tmp_path, [grid])[0]
    panel = type("Panel", (), {"painting": None, "grid": grid})()
    for form in (grid, [grid], muscles_of(hand, [grid]), file, str(tmp_path), panel):
        assert [one.name for one in grids_of(form)] == ["impostor"]
    for wrong in (3, [], object(), b"x"):
        with pytest.raises(TypeError, match="give a muscle grid"):
            grids_of(wrong)


def test_a_painted_muscle_takes_the_place_of_one_with_its_name(hand, painted, grid):
    assert len(with_painted(painted, replace(grid, drives=("flexor_pollicis_brevis",))).grids) == len(painted.grids)
    assert with_painted(hand, None) is hand


def test_a_grid_that_makes_no_muscle_is_refused_and_a_painted_hand_says_that_its_files_cannot_hold_it(hand, painted, grid, tmp_path):
    with pytest.raises(LookupError, match="flexor"):
        with_painted(hand, replace(grid, drives=("flexor_polli",)))
    with pytest.raises(ValueError, match="save_grids"):
        painted.save(tmp_path / "mine")
    assert not (tmp_path / "mine").exists()


def test_a_painted_muscle_loaded_into_the_live_hand_is_in_its_frames_and_its_skin(hand, grid):
    session = Session(hand, wear=SOFT)
    session.message({"kind": "layers"})
    before = [reply for reply in session.replies() if reply["kind"] == "layers"][-1]["data"]
    session.message({"kind": "load", "text": as_text(grid), "name": "impostor.json"})
    replies = session.replies()
    assert next(reply for reply in replies if reply["kind"] == "answer")["text"].startswith("the muscle 'impostor' is in")
    after = next(reply for reply in replies if reply["kind"] == "layers")["data"]
    assert b"impostor" in after and b"impostor" not in before
    assert session.wardrobe.network is None  # the host prepares it anew
    session.prepare()
    session.ready()
    assert "impostor" in session.wardrobe.network.muscles.names
    assert 15_000 < len(session.tick(1 / 60)) <= 20_000
    session.message({"kind": "load", "text": as_text(grid).replace('"pisiform"', '"pisform"'), "name": "wrong.json"})
    assert session.replies()[-1]["good"] is False and session.hand.grids is not None
