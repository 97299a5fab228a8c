import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from handlab.simulation import pchip
from handlab.simulation.keyframes import KeyFrames, clips, keyframes

FDP2 = "flexor_digitorum_profundus_index"
EDC2 = "extensor_digitorum_index"


def column(keys, muscle=FDP2):
    return keys.muscle_names.index(muscle)


times = st.lists(st.floats(0, 10).map(lambda t: round(t, 3)), min_size=1, max_size=8, unique=True).map(sorted)
tracks = times.flatmap(lambda t: st.lists(st.floats(0, 1), min_size=len(t), max_size=len(t)).map(lambda c: list(zip(t, c, strict=True))))


def test_the_worked_numbers():
    keys = keyframes({"FDP2": [(0, 0), (0.5, 1), (1, 0.2), (1.5, 0.2)]})
    np.testing.assert_allclose(keys.at([0.25, 0.75, 1.25])[:, column(keys)], [0.7375, 0.6, 0.2], atol=1e-12)


@given(tracks)
def test_the_curve_is_scipys_pchip_and_never_leaves_0_to_1(track):
    keys = keyframes({"FDP2": track})
    at = np.linspace(-1, 11, 500)
    values = keys.at(at)[:, column(keys)]
    assert values.min() >= 0.0 and values.max() <= 1.0
    time, key = np.array(track).T
    if len(track) > 1:
        np.testing.assert_allclose(values, PchipInterpolator(time, key)(np.clip(at, time[0], time[-1])), atol=1e-7)
    np.testing.assert_allclose(keys.at(time)[:, column(keys)], key, atol=1e-12)


@given(tracks)
def test_the_curve_never_leaves_the_values_of_the_two_keys_around_it(track):
    time, key = np.array(track).T
    at = np.linspace(time[0], time[-1], 300)
    value = pchip.curve(time, key[:, None], pchip.slopes(time, key[:, None]), at)[:, 0]
    k = np.clip(np.searchsorted(time, at, side="right") - 1, 0, max(len(time) - 2, 0))
    right = np.minimum(k + 1, len(time) - 1)
    assert np.all(value >= np.minimum(key[k], key[right]) - 1e-9)
    assert np.all(value <= np.maximum(key[k], key[right]) + 1e-9)


def test_the_ends_hold():
    keys = keyframes({"FDP2": [(1, 0.3), (2, 0.7)]})
    np.testing.assert_allclose(keys.at([-5, 0, 2.5, 100])[:, column(keys)], [0.3, 0.3, 0.7, 0.7])


def test_muscles_without_keys_stay_at_0():
    assert keyframes({"FDP2": [(0, 1.0), (1, 0.5)]}).at(0.5).sum() == pytest.approx(0.75)


def test_every_muscle_keeps_its_own_times():
    """A key of one muscle does not bend the curve of another."""
    alone = keyframes({"FDP2": [(0, 0), (0.5, 1), (2, 0.2)]})
    together = keyframes({"FDP2": [(0, 0), (0.5, 1), (2, 0.2)], "EDC2": [(0.1, 0.5), (1.7, 0.1), (3, 0.4)]})
    at = np.linspace(0, 3, 100)
    np.testing.assert_array_equal(alone.at(at)[:, column(alone)], together.at(at)[:, column(together)])
    other = PchipInterpolator([0.1, 1.7, 3], [0.5, 0.1, 0.4])(np.clip(at, 0.1, 3))
    np.testing.assert_allclose(together.at(at)[:, column(together, EDC2)], other, atol=1e-12)


def test_one_time_gives_one_row_and_many_times_many():
    keys = keyframes({"FDP2": 0.4})
    assert keys.at(0.3).shape == (42,)
    assert keys.at([0.1, 0.2]).shape == (2, 42)
    assert keys.at(7.0)[column(keys)] == 0.4


def test_shared_times_and_pairs_are_the_same_key_frames():
    shared = keyframes({"time": [0, 1, 2], "FDP2": [0, 0.5, None], "EDC2": [None, 0.1, 0.2]})
    pairs = keyframes({"fdp2": [(0, 0), (1, 0.5)], "EDC2": [(1, 0.1), (2, 0.2)]})
    np.testing.assert_array_equal(shared.contraction, pairs.contraction)
    np.testing.assert_array_equal(shared.is_key, pairs.is_key)


@pytest.mark.parametrize("suffix", [".csv", ".json"])
@given(a=tracks, b=tracks)
def test_files_give_back_what_was_written(tmp_path_factory, suffix, a, b):
    path = tmp_path_factory.mktemp("keys") / f"wave{suffix}"
    keys = keyframes({"FDP2": a, "EDC2": b})
    (keys.to_csv if suffix == ".csv" else keys.to_json)(path)
    again = keyframes(path)
    at = np.linspace(0, 10, 77)
    np.testing.assert_array_equal(again.time, keys.time)
    np.testing.assert_array_equal(again.at(at), keys.at(at))
    assert list(path.parent.iterdir()) == [path]


def test_a_plain_table_is_read(tmp_path):
    path = tmp_path / "fist.csv"
    path.write_text("# a comment\n time, FDP2 ,extensor_digitorum_index\n0,0,0.1\n\n0.5,1,\n1,0.2,0.3\n")
    keys = keyframes(str(path))
    assert keys.keyed == tuple(sorted((FDP2, EDC2), key=keys.muscle_names.index))
    assert keys.name == "fist"
    np.testing.assert_allclose(keys.at(0.5)[column(keys)], 1.0)
    assert keys.is_key.sum() == 5


def test_json_leaves_other_entries_alone(tmp_path):
    path = tmp_path / "x.json"
    path.write_text(json.dumps({"name": "wave", "title": "Wave", "made_by": {"tool": 1}, "time": [0, 1], "contraction": {"FDP2": [0, 1]}}))
    keys = keyframes(path)
    assert (keys.name, keys.title) == ("wave", "Wave")


BROKEN_TABLES = {
    "time,FDP2\n0,0\n1,zero\n": "line 3: 'zero'",
    "time,FDP2\n0,0\n1\n": "line 3: 1 cells",
    "time,FDP2\n0,0\n1,0.1,0.2\n": "line 3: 3 cells",
    "time,FDP2\n0,0\n\n1,1.4\n": r"line 4: contraction of 'FDP2' is 1\.4; contraction values lie between 0 and 1",
    "time,FDP2\n0,0\n1,nan\n": "line 3: contraction of 'FDP2' is nan",
    "time,FDP2\n0,0\nnan,0\n": "line 3: the time is 'nan'",
    "time,FDP2\n0,0\n,0\n": "line 3: the time is ''",
    "time,FDP2\n1,0\n0,0\n": "line 3: 0 s comes after 1 s",
    "time,FDP2\n0,0\n0,0\n": "line 3: 0 s stands there twice",
    "FDP2,time\n0,0\n": "line 1: .* heading",
    "time\n0\n": "line 1: no muscle",
    "time,FDP2\n": "no key frames",
    "": "heading",
    "time,FDP2,FDP2\n0,0,0\n": "two columns",
    "time,FDP2,flexor_digitorum_profundus_index\n0,0,0\n": "same muscle",
    "time,FDP2,EDC2\n0,0,\n1,1,\n": "no key frames",
}


@pytest.mark.parametrize("text", BROKEN_TABLES, ids=lambda text: BROKEN_TABLES[text])
def test_a_broken_table_is_named_with_its_line(tmp_path, text):
    path = tmp_path / "broken.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=BROKEN_TABLES[text]) as error:
        keyframes(path)
    assert "broken.csv" in str(error.value)


def test_an_unknown_muscle_in_a_table_is_named_with_its_line_and_the_nearest_three(tmp_path):
    path = tmp_path / "broken.csv"
    path.write_text("time,FDP9\n0,0\n")
    with pytest.raises(KeyError, match=r"broken\.csv, line 1: .*'FDP9'.*profundus\w+, \w+ or"):
        keyframes(path)


BROKEN_JSON = {
    "{": "line 1",
    "[]": "holds no key frames",
    '{"time": [0], "contraction": {}}': "no key frames",
    '{"time": [0], "contraction": {"FDP2": [1.4]}}': r"is 1\.4 at 0 s",
    '{"time": [0], "contraction": {"FDP2": [NaN]}}': "NaN",
    '{"time": [0, 1], "contraction": {"FDP2": [1]}}': "1 values for 2 times",
    '{"time": [0], "contraction": {"FDP2": 1}}': "give one value for every time",
    '{"time": 0, "contraction": {"FDP2": [1]}}': "plain list",
    '{"time": ["a"], "contraction": {"FDP2": [1]}}': "list of numbers",
    '{"time": [1, 0], "contraction": {"FDP2": [1, 0]}}': "not sorted",
    '{"time": [0], "contraction": {"time": [1]}}': "beside",
}


@pytest.mark.parametrize("text", BROKEN_JSON, ids=lambda text: BROKEN_JSON[text])
def test_a_broken_json_file_is_named(tmp_path, text):
    path = tmp_path / "broken.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=BROKEN_JSON[text]) as error:
        keyframes(path)
    assert "broken.json" in str(error.value)


BROKEN_MAPPINGS = [
    ({}, "no key frames"),
    ({"FDP2": []}, "no key frames"),
    ({"FDP2": [(1, 0), (0, 1)]}, "not sorted: 0 s comes after 1 s"),
    ({"FDP2": [(0, 0), (0, 1)]}, "0 s twice"),
    ({"FDP2": [(0, 1.4)]}, r"contraction of 'flexor_digitorum_profundus_index' is 1\.4 at 0 s; contraction values lie between 0 and 1"),
    ({"FDP2": [(0, float("nan"))]}, "is nan at 0 s"),
    ({"FDP2": [(float("inf"), 0)]}, "time inf"),
    ({"FDP2": "fast"}, "pairs of time and value"),
    ({"FDP2": [0, 1]}, "pairs of time and value"),
    ({"FDP2": None}, "pairs of time and value"),
    ({"time": [0, 1], "FDP2": [0]}, "1 values for 2 times"),
    ({"time": [0, 1], "FDP2": [float("nan"), 1]}, "is nan"),
    ({"FDP2": [(0, 0)], FDP2: [(0, 1)]}, "same muscle"),
]


@pytest.mark.parametrize(("mapping", "message"), BROKEN_MAPPINGS, ids=[message for _, message in BROKEN_MAPPINGS])
def test_key_frames_that_are_none_are_refused(mapping, message):
    with pytest.raises(ValueError, match=message):
        keyframes(mapping)


def test_an_unknown_muscle_is_answered_with_three():
    with pytest.raises(KeyError, match=r"'FDP9'.*profundus\w+, \w+ or \w+"):
        keyframes({"FDP9": 0.4})


def test_every_clip_that_comes_along_can_be_read():
    for name in clips():
        assert keyframes(name).time[-1] > 0.0


def test_an_unknown_clip_is_refused_with_the_nearest():
    with pytest.raises(KeyError, match="unknown clip 'fisst'"):
        keyframes("fisst")


@pytest.mark.parametrize("name", ["no/such/file.csv", "nothing.json"])
def test_a_missing_file_is_named(name):
    with pytest.raises(FileNotFoundError, match="no file"):
        keyframes(name)


def test_a_file_of_another_kind_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"\.csv or \.json"):
        keyframes(tmp_path / "clip.mp4")


def test_a_file_that_is_no_text_is_refused(tmp_path):
    (tmp_path / "x.csv").write_bytes(b"time,FDP2\n0,\xff\n")
    with pytest.raises(ValueError, match="not a text file"):
        keyframes(tmp_path / "x.csv")


def test_a_folder_is_no_file_of_key_frames(tmp_path):
    (tmp_path / "x.csv").mkdir()
    with pytest.raises(OSError, match=r"cannot read .*x\.csv"):
        keyframes(tmp_path / "x.csv")


def test_key_frames_cannot_be_built_from_wrong_arrays():
    with pytest.raises(ValueError, match="times, muscles"):
        KeyFrames(np.zeros(2), np.zeros((1, 1)), np.ones((1, 1), bool), ("a",))
    with pytest.raises(ValueError, match="lie between 0 and 1"):
        KeyFrames(np.zeros(1), np.full((1, 1), 1.4), np.ones((1, 1), bool), ("a",))
