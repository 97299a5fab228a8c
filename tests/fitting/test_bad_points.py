"""Clicks that cannot be right: each is told in one sentence that says what to do, and none is ever lost."""

import clicks as c
import numpy as np
import people
import pytest

from handlab.anatomy.terms import UnknownName
from handlab.fitting.fit import fit_photo, fit_points
from handlab.fitting.landmarks import LANDMARKS, NAMES, SIXTEEN, checked, read_landmarks, write_landmarks
from handlab.fitting.mistakes import FitError, FitQuestion

MM_PER_PX = 1.0 / c.PX_PER_MM


@pytest.fixture(scope="module")
def hand():
    return people.hand()


def refused(hand, points, match, kind=FitError, scale=MM_PER_PX, **options):
    with pytest.raises(kind, match=match) as error:
        fit_points(hand, points, scale, **{"view": "palmar", **options})
    kept = {name: place for name, place in points.items() if place is not None}
    assert dict(error.value.landmarks) == kept
    assert str(error.value).count("\n") == 0
    return error.value


def test_there_are_26_names_as_the_paper_counts_them():
    assert len(NAMES) == 26
    assert len(set(SIXTEEN)) == 16
    assert set(SIXTEEN) < set(NAMES)
    assert [sum(name.startswith(kind) for name in NAMES) for kind in ("tip", "dip", "ip_", "pip", "mcp", "web", "wrist", "head")] == [
        5,
        4,
        1,
        4,
        5,
        4,
        2,
        1,
    ]
    assert all(LANDMARKS.values())
    assert set(people.hand().feature_points) == set(NAMES)


def test_no_points_three_points_and_a_line_are_too_little(hand):
    points = c.clicks(hand)
    refused(hand, {}, "no feature points yet")
    refused(hand, {name: points[name] for name in NAMES[:3]}, "3 feature points do not determine a hand")
    line = {name: (100.0 + 50.0 * k, 200.0 + 30.0 * k) for k, name in enumerate(NAMES)}
    refused(hand, line, "on one line")


def test_two_at_one_place_are_both_named(hand):
    points = c.clicks(hand)
    points["pip_ring"] = points["pip_middle"]
    assert set(refused(hand, points, "at one place").names) == {"pip_ring", "pip_middle"}


@pytest.mark.parametrize("name", ["tip_index", "mcp_middle", "wrist_ulnar", "pip_little"])
@pytest.mark.parametrize("way", [(900.0, 700.0), (-800.0, 300.0)])
def test_a_point_far_off_the_hand_is_named(hand, name, way):
    points = c.clicks(hand)
    points[name] = tuple(np.add(points[name], way))
    assert name in refused(hand, points, name).names


@pytest.mark.parametrize(("one", "other"), [("index", "ring"), ("middle", "ring"), ("index", "little"), ("ring", "little")])
def test_two_fingers_that_were_exchanged_are_named(hand, one, other):
    points = c.clicks(hand)
    for joint in ("tip", "dip", "pip", "mcp"):
        a, b = f"{joint}_{one}", f"{joint}_{other}"
        points[a], points[b] = points[b], points[a]
    assert set(refused(hand, points, "exchanged").names) == {one, other}


def test_two_labels_that_were_exchanged_are_named(hand):
    points = c.clicks(hand)
    points["tip_index"], points["tip_ring"] = points["tip_ring"], points["tip_index"]
    assert set(refused(hand, points, "exchanged").names) == {"tip_index", "tip_ring"}
    points = c.clicks(hand)
    points["wrist_radial"], points["wrist_ulnar"] = points["wrist_ulnar"], points["wrist_radial"]
    refused(hand, points, "exchanged|away from|fold|thin")


@pytest.mark.parametrize("view", ["palmar", "dorsal"])
def test_nobody_among_the_known_people_is_doubted(view):
    """No label, no size and no point of fifteen people of different shape raises a question, with 26 points or 16."""
    for person in people.everyone().values():
        for names in (NAMES, SIXTEEN):
            rng = np.random.default_rng(3)
            sign = 1.0 if view == "palmar" else -1.0
            px = {n: (4e3 * p[2] * sign + rng.normal(), -4e3 * p[0] + rng.normal()) for n, p in person.marks[view].items() if n in names}
            with people.only_shapes():
                assert fit_points(people.hand(), px, 0.25, view=view).side == "right"


def test_a_hand_of_40_cm_is_asked_about_and_can_be_confirmed(hand):
    points = c.clicks(hand)
    question = refused(hand, points, "4[0-9][0-9] mm long", kind=FitQuestion, scale=2.6 * MM_PER_PX)
    assert {"sure": True} in question.choices
    assert fit_points(hand, points, 2.6 * MM_PER_PX, view="palmar", sure=True).growth == pytest.approx(2.6, rel=1e-3)
    refused(hand, points, "mm long", kind=FitQuestion, scale=0.4 * MM_PER_PX)


def test_a_point_outside_the_picture_is_named(hand):
    points = c.clicks(hand)
    points["tip_middle"] = (9000.0, 10.0)
    with pytest.raises(FitError, match="outside the picture of 4000 x 4000") as error:
        fit_photo((4000, 4000), landmarks=points, scale=MM_PER_PX, view="palmar")
    assert error.value.names == ("tip_middle",)
    assert len(error.value.landmarks) == 26


def test_a_scale_that_cannot_be_read_keeps_the_clicks(hand):
    with pytest.raises(FitError, match="pixels apart") as error:
        fit_photo((4000, 4000), landmarks=c.clicks(hand), scale={"ruler": [(5, 5), (5, 5)], "mm": 100}, view="palmar")
    assert len(error.value.landmarks) == 26


def test_unknown_names_places_and_options_are_told(hand):
    points = c.clicks(hand)
    with pytest.raises(UnknownName, match="tip_index"):
        fit_points(hand, points | {"tip_indx": (1, 2)}, MM_PER_PX, view="palmar")
    for option in ({"view": "front"}, {"side": "both"}, {"rule": "newest"}, {"mechanics": "half"}, {"camera_mm": 10.0}, {"marks": "any"}):
        with pytest.raises(ValueError, match=next(iter(option))):
            fit_points(hand, points, MM_PER_PX, **{"view": "palmar", **option})
    with pytest.raises(FitError, match="finite"):
        checked(points | {"tip_index": (np.nan, 1.0)})
    with pytest.raises(FitError, match="as \\(x, y\\)"):
        checked(points | {"tip_index": "here"})
    with pytest.raises(TypeError, match="mapping"):
        checked([1, 2, 3])


@pytest.mark.parametrize("suffix", [".json", ".csv"])
def test_clicks_come_back_from_their_file_to_the_last_bit(hand, tmp_path, suffix):
    points = c.clicks(hand) | {"web_index_middle": None}
    file = write_landmarks(points, tmp_path / f"me{suffix}")
    assert read_landmarks(file) == points
    assert "web_index_middle" not in checked(file)
    assert fit_points(hand, file, MM_PER_PX, view="palmar").names == tuple(checked(file))


def test_broken_files_of_points_are_told(tmp_path):
    with pytest.raises(FileNotFoundError, match="no file of feature points"):
        checked(tmp_path / "none.csv")
    (tmp_path / "bad.csv").write_text("tip_index,12,abc\n")
    with pytest.raises(ValueError, match="line 1"):
        checked(tmp_path / "bad.csv")
    (tmp_path / "bad.json").write_text("[1, 2")
    with pytest.raises(ValueError, match="holds no feature points"):
        checked(tmp_path / "bad.json")
    with pytest.raises(ValueError, match=r"\.json or \.csv"):
        write_landmarks({}, tmp_path / "me.txt")


def test_ignoring_a_missing_finger_is_said(hand):
    names = tuple(name for name in NAMES if not name.endswith("ring") or name.startswith("web"))
    fit = fit_points(hand, c.clicks(hand, names=names), MM_PER_PX, view="palmar")
    assert "no point on ring" in " ".join(fit.warnings)
