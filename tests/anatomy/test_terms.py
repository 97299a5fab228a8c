"""Words of the hand, and what happens to a name that nothing carries."""

import difflib
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from handlab.anatomy import data, tables
from handlab.anatomy.terms import BODIES, BONES, DIGITS, FINGERS, SIGNS, UnknownName, find, match, nearest

MUSCLES = tuple(tables.muscles())


def test_there_are_29_bones_in_19_bodies_and_every_body_holds_one():
    assert len(BONES) == 29
    assert len(BODIES) == 19 == len(set(BODIES))
    assert {bone.body for bone in BONES.values()} == set(BODIES)
    assert sum(bone.body == "carpus" for bone in BONES.values()) == 10  # eight carpal bones, metacarpals 2 and 3
    assert [bone.body for bone in (BONES["radius"], BONES["metacarpal_3"], BONES["metacarpal_4"])] == ["forearm", "carpus", "metacarpal_4"]


def test_every_bone_has_a_latin_and_an_english_name_of_its_own():
    assert len({bone.latin for bone in BONES.values()}) == len({bone.english for bone in BONES.values()}) == 29
    assert BONES["hamate"].latin == "os hamatum"
    assert BONES["middle_phalanx_5"] == ("middle_phalanx_5", "phalanx media V", "middle phalanx of the little finger", "middle_phalanx_5")
    assert BONES["distal_phalanx_1"].english == "distal phalanx of the thumb"
    assert "middle_phalanx_1" not in BONES


def test_digits_count_from_the_thumb_and_flexion_radial_palmar_abduction_and_pronation_are_positive():
    assert DIGITS == {"thumb": 1, "index": 2, "middle": 3, "ring": 4, "little": 5}
    assert tuple(DIGITS) == FINGERS
    assert {kind: words[0].split(" (")[0] for kind, words in SIGNS.items()} == {
        "flexion_extension": "flexion",
        "flexion_opposition": "flexion",
        "deviation": "radial",
        "abduction_adduction": "palmar abduction",
        "axial_rotation": "pronation",
    }


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("flexor_carpi_ulnaris", "flexor_carpi_ulnaris"),
        ("FDP2", "flexor_digitorum_profundus_index"),
        ("fdp2", "flexor_digitorum_profundus_index"),
        ("lumbrical I", "lumbrical_1"),
        ("Lumbrical iv", "lumbrical_4"),
        ("first dorsal interosseous", "dorsal_interosseus_1"),
        ("Flexor carpi-radialis", "flexor_carpi_radialis"),
        ("ED4", "extensor_digitorum_ring"),
    ],
)
def test_a_muscle_is_found_by_name_abbreviation_and_common_name_in_any_case(written, meant):
    assert find(written, MUSCLES, kind="muscle", aliases=tables.aliases()) == meant


def test_every_alias_leads_to_its_muscle_and_none_to_two():
    aliases = tables.aliases()
    folded = [alias.casefold().replace(" ", "_") for alias in aliases]
    assert len(set(folded)) == len(folded)
    for alias, name in aliases.items():
        assert find(alias.upper(), MUSCLES, kind="muscle", aliases=aliases) == name
    assert {muscle.abbreviation for muscle in tables.muscles().values()} <= set(aliases)


def test_an_unknown_muscle_is_answered_with_the_three_nearest():
    with pytest.raises(KeyError) as caught:
        find("flexor_digitorum", MUSCLES, kind="muscle", aliases=tables.aliases())
    assert isinstance(caught.value, UnknownName)
    sentence = str(caught.value)
    assert re.fullmatch(
        r"unknown muscle 'flexor_digitorum'; did you mean (flexor_digitorum_\w+), (flexor_digitorum_\w+) or (flexor_digitorum_\w+)\?",
        sentence,
    )


@pytest.mark.parametrize(
    "misspelt", ["flexor_carpi_radialsi", "extensor_pollcis_brevis", "abductor_digiti_minim", "oponens_pollicis", "lumbrica_3"]
)
def test_the_nearest_three_agree_with_difflib(misspelt):
    likeness = {name: difflib.SequenceMatcher(None, name, misspelt).ratio() for name in MUSCLES}
    named = nearest(misspelt, MUSCLES)
    assert named[0] == difflib.get_close_matches(misspelt, MUSCLES, n=1)[0]
    assert min(likeness[name] for name in named) >= max(likeness[name] for name in MUSCLES if name not in named)


def test_a_misspelt_abbreviation_is_answered_with_its_neighbours():
    wanted = {"flexor_digitorum_profundus_" + finger for finger in FINGERS[1:]}
    assert set(nearest("FDP6", MUSCLES, tables.aliases())) < wanted


@given(st.one_of(st.text(), st.integers(), st.none()))
def test_whatever_is_asked_find_returns_a_known_name_or_names_exactly_three(asked):
    try:
        assert find(asked, MUSCLES, kind="muscle") in MUSCLES
    except UnknownName as error:
        answer = str(error)[len(f"unknown muscle {asked!r}") :]
        named = [word for word in re.findall(r"\w+", answer) if word in MUSCLES]
        assert len(named) == 3 == len(set(named))
        assert repr(asked) in str(error)


def test_an_exact_name_wins_over_an_alias_of_another_entry():
    assert find("b", ["a", "b"], kind="thing", aliases={"b": "a"}) == "b"
    assert find("B", ["a", "b"], kind="thing", aliases={"B": "a"}) == "b"
    assert match("c", ["a"], {"c": "z"}) is None  # an alias of something that is not here


def test_with_nothing_known_the_error_says_so():
    with pytest.raises(UnknownName, match="there are none here"):
        find("x", [], kind="clip")


def test_terms_load_neither_numpy_nor_difflib():
    code = "import sys; from handlab.anatomy import terms; print([name for name in ('numpy', 'difflib') if name in sys.modules])"
    root = Path(data.__file__).parents[2]
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=root, check=True)
    assert ran.stdout.strip() == "[]"


def test_the_data_folder_is_found_in_a_clone_and_in_a_wheel_and_its_absence_names_both_places(tmp_path, monkeypatch):
    assert (data.folder() / "anatomy" / "joints.json").is_file()
    package = tmp_path / "site-packages" / "handlab"
    monkeypatch.setattr(data, "PACKAGE", package)
    with pytest.raises(FileNotFoundError, match="install handlab again") as caught:
        data.folder()
    assert str(package / "assets") in str(caught.value)
    assert str(package.parent / "assets") in str(caught.value)
    (package.parent / "assets").mkdir(parents=True)  # somebody else's folder of that name
    with pytest.raises(FileNotFoundError, match="handlab is missing"):
        data.folder()
    beside, inside = package.parent / "assets", package / "assets"
    for place in (beside, inside):
        (place / "anatomy").mkdir(parents=True)
        (place / "anatomy" / "muscles.json").write_text("{}")
        assert data.folder() == place  # the one inside the package comes first


def test_a_broken_or_absent_table_file_is_named(tmp_path, monkeypatch):
    place = tmp_path / "assets" / "anatomy"
    place.mkdir(parents=True)
    (place / "muscles.json").write_text('{"a": 1,\n "b": NaN}')
    monkeypatch.setattr(data, "PACKAGE", tmp_path / "handlab")
    with pytest.raises(ValueError, match=r"muscles\.json is not readable.*NaN"):
        data.read_json("anatomy/muscles.json")
    (place / "muscles.json").write_text('{"a": 1,\n oops}')
    with pytest.raises(ValueError, match=r"muscles\.json is not readable.*line 2"):
        data.read_json("anatomy/muscles.json")
    with pytest.raises(FileNotFoundError, match=r"joints\.json is missing"):
        data.read_json("anatomy/joints.json")
    (place / "muscles.json").write_text(json.dumps({"a": [1]}))
    assert data.read_json("anatomy/muscles.json") == {"a": [1]}
