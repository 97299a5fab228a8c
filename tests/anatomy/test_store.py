"""Saving a hand and loading it again, and what happens to broken files."""

import json
import os
import shutil
import struct
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

import handlab
from handlab.anatomy import data, glb, store
from handlab.anatomy.load import exact_weights
from handlab.anatomy.records import frozen
from handlab.simulation.mechanics import mechanics

REFERENCE = data.folder() / "reference_hand"


@pytest.fixture(scope="module")
def hand():
    return handlab.load_hand()


@pytest.fixture
def copy(tmp_path):
    """The reference hand's files, to be broken."""
    return shutil.copytree(REFERENCE, tmp_path / "copy")


def held(folder):
    """Names in a folder, hidden ones too."""
    return sorted(path.name for path in folder.iterdir())


def differences(one, other, place="hand"):
    """Where two records differ in any bit."""
    if is_dataclass(one):
        return [
            found
            for field in fields(one)
            for found in differences(getattr(one, field.name), getattr(other, field.name), f"{place}.{field.name}")
        ]
    if isinstance(one, np.ndarray):
        same = one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
        return [] if same else [place]
    if hasattr(one, "items"):
        if list(one) != list(other):
            return [place]
        return [found for key in one for found in differences(one[key], other[key], f"{place}[{key}]")]
    if isinstance(one, tuple | list):
        return [found for i, (a, b) in enumerate(zip(one, other, strict=True)) for found in differences(a, b, f"{place}[{i}]")]
    return [] if one == other and type(one) is type(other) else [place]


# ---------------------------------------------------------------- there and back


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("reading", ["sound", "printed"])
def test_a_saved_hand_comes_back_to_the_last_bit(tmp_path, side, reading):
    hand = handlab.load_hand(side=side, reading=reading)
    assert hand.save(tmp_path / "mine") == tmp_path / "mine"
    again = handlab.load_hand(tmp_path / "mine")
    assert (again.side, again.reading) == (side, reading)
    assert differences(hand, again) == []
    for name in ("lever_arm", "rest_length", "max_force", "limits", "coupling", "coupling_offset"):
        np.testing.assert_array_equal(getattr(again, name), getattr(hand, name))
    assert held(tmp_path / "mine") == ["hand.glb", "hand.json"]
    assert held(tmp_path) == ["mine"]


def test_differences_would_be_seen(hand):
    points = np.array(hand.skin.points)
    points[7, 1] = np.nextafter(points[7, 1], 1.0)
    assert differences(hand, hand.with_(skin=replace(hand.skin, points=frozen(points)))) == ["hand.skin.points"]
    assert differences(hand, hand.with_newton_per_percent(21.0)) == ["hand.newton_per_percent"]


def test_saving_what_was_loaded_writes_the_same_bytes_again(tmp_path, hand):
    hand.save(tmp_path / "one")
    handlab.load_hand(tmp_path / "one").save(tmp_path / "two")
    for name in store.FILES:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_the_saved_meshes_are_those_that_the_tools_wrote(tmp_path, hand):
    hand.save(tmp_path / "mine")
    there, here = glb.read_glb(REFERENCE / "hand.glb"), glb.read_glb(tmp_path / "mine" / "hand.glb")
    assert set(there) == set(here)
    for name, arrays in there.items():
        assert set(arrays) == set(here[name])
        for key, values in arrays.items():
            np.testing.assert_allclose(here[name][key], values, atol=3e-6)


def test_settings_are_saved_with_the_hand(tmp_path, hand):
    rest = np.array(hand.fibre_rest)
    rest[5] += 0.1
    mine = hand.with_newton_per_percent(25.0).with_(
        friction=frozen(2.0 * hand.friction),
        fibre_rest=frozen(rest),
        stiffness=frozen(0.5 * hand.stiffness),
        name="mine",
        relaxed=frozen(rest),
        capsule=replace(hand.capsule, torque=frozen(2.0 * hand.capsule.torque)),
    )
    mine.save(tmp_path / "mine")
    again = handlab.load_hand(tmp_path / "mine")
    assert differences(mine, again) == []
    np.testing.assert_array_equal(again.capsule.torque, 2.0 * hand.capsule.torque)
    np.testing.assert_allclose(again.friction, 2.0 * hand.friction)
    mine.without_passive().save(tmp_path / "bare")
    assert handlab.load_hand(tmp_path / "bare").capsule is None
    other = handlab.load_hand(tmp_path / "mine", side="left", reading="printed")
    assert (other.side, other.reading, other.newton_per_percent, other.stiffness.max()) == ("left", "printed", 25.0, 0.0)


def test_a_computed_hand_comes_back_within_a_nanometre_or_so_and_then_to_the_last_bit(tmp_path, hand):
    rng = np.random.default_rng(4)
    moved = hand.with_(
        skin=replace(hand.skin, points=frozen(hand.skin.points * 1.0371 + 1e-3 * rng.random(hand.skin.points.shape))),
        bind=frozen(hand.bind + 0.1 * rng.random(31)),
    )
    moved.save(tmp_path / "mine")
    again = handlab.load_hand(tmp_path / "mine")
    np.testing.assert_allclose(again.skin.points, moved.skin.points, atol=1e-8)
    np.testing.assert_allclose(again.bind, moved.bind, atol=1e-15)
    again.save(tmp_path / "again")
    assert differences(again, handlab.load_hand(tmp_path / "again")) == []


def test_a_saved_hand_moves(tmp_path, hand):
    hand.save(tmp_path / "mine")
    again = handlab.load_hand(tmp_path / "mine")
    np.testing.assert_array_equal(handlab.rest(again).skin, handlab.rest(hand).skin)
    np.testing.assert_array_equal(mechanics(again).limits, mechanics(hand).limits)


@pytest.mark.parametrize("seed", range(5))
def test_weights_are_rounded_to_rows_that_add_to_exactly_1_and_fit_32_bits(seed):
    weights = np.random.default_rng(seed).dirichlet(np.full(4, 0.3), 500)
    rounded = exact_weights(weights)
    np.testing.assert_array_equal(rounded.sum(axis=1), 1.0)
    np.testing.assert_array_equal(rounded.astype(np.float32), rounded)
    np.testing.assert_array_equal(exact_weights(rounded), rounded)
    np.testing.assert_allclose(rounded, weights, atol=3e-6)
    assert rounded.min() >= 0.0


def test_an_angle_is_written_in_the_fewest_digits_that_give_it_back():
    assert store.degrees(np.radians(12.5)) == 12.5
    assert repr(store.degrees(float(np.radians(6.270455)))) == "6.270455"
    for angle in np.random.default_rng(1).uniform(-3, 3, 200):
        assert np.radians(store.degrees(float(angle))) == pytest.approx(angle, abs=5e-16)


# ---------------------------------------------------------------- whole or not at all


def test_a_hand_that_its_files_cannot_give_back_is_refused_and_nothing_is_written(tmp_path, hand):
    weaker = {name: replace(muscle, tension_percent=1.0) for name, muscle in hand.muscles.items()}
    with pytest.raises(ValueError, match="muscles"):
        hand.with_(muscles=hand.muscles.with_items(weaker)).save(tmp_path / "mine")
    with pytest.raises(ValueError, match=r"skin\.points"):
        hand.with_(skin=replace(hand.skin, points=frozen(hand.skin.points * np.nan))).save(tmp_path / "mine")
    assert held(tmp_path) == []


def test_an_older_hand_is_replaced_whole_and_survives_a_failure(tmp_path, hand, monkeypatch):
    place = tmp_path / "mine"
    hand.save(place)
    handlab.load_hand(side="left").save(place)
    assert handlab.load_hand(place).side == "left"

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(store, "write_glb", full)
    with pytest.raises(OSError, match="No space left"):
        hand.save(place)
    assert handlab.load_hand(place).side == "left"
    assert held(tmp_path) == ["mine"]


def test_when_the_new_folder_cannot_take_its_place_the_old_one_comes_back(tmp_path, hand, monkeypatch):
    place = tmp_path / "mine"
    hand.save(place)
    real = store.Path.rename

    def busy(path, target):
        if "-new-" in path.name:
            raise PermissionError(13, "Permission denied")
        return real(path, target)

    monkeypatch.setattr(store.Path, "rename", busy)
    with pytest.raises(PermissionError):
        handlab.load_hand(side="left").save(place)
    assert handlab.load_hand(place).side == "right"
    assert held(tmp_path) == ["mine"]


def test_a_folder_with_other_things_a_file_and_a_missing_place_are_refused(tmp_path, hand):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.txt").write_text("mine")
    with pytest.raises(FileExistsError, match=r"chapter\.txt.*choose a new folder"):
        hand.save(tmp_path / "thesis")
    with pytest.raises(FileExistsError, match="a hand is a folder"):
        hand.save(tmp_path / "thesis" / "chapter.txt")
    with pytest.raises(FileNotFoundError, match="create it first"):
        hand.save(tmp_path / "nowhere" / "mine")
    assert (tmp_path / "thesis" / "chapter.txt").read_text() == "mine"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_place_that_cannot_be_written_is_named(tmp_path, hand):
    tmp_path.chmod(0o500)
    with pytest.raises(PermissionError, match="choose a folder that you may write to"):
        hand.save(tmp_path / "mine")


def test_a_place_that_cannot_be_made_is_named(tmp_path, hand, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(store.Path, "mkdir", refuse)
    with pytest.raises(PermissionError, match="choose a folder that you may write to"):
        hand.save(tmp_path / "mine")


# ---------------------------------------------------------------- what cannot be loaded


def test_an_unknown_side_or_reading_is_named_with_the_choices():
    with pytest.raises(ValueError, match="side is 'both'; it must be 'right' or 'left'"):
        handlab.load_hand(side="both")
    with pytest.raises(ValueError, match="reading is 'guess'; it must be one of sound, printed"):
        handlab.load_hand(reading="guess")


def test_a_folder_without_a_hand_is_named(tmp_path):
    for place in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(FileNotFoundError, match=r"holds no hand: a hand is a folder with hand\.json and hand\.glb"):
            handlab.load_hand(place)


@pytest.mark.parametrize("keep", [0, 3, 11, 19, 500, 30_000, -1])
def test_a_truncated_mesh_file_is_named(copy, keep):
    whole = (copy / "hand.glb").read_bytes()
    (copy / "hand.glb").write_bytes(whole[:keep])
    with pytest.raises(ValueError, match=r"hand\.glb is not a hand's mesh file.*again"):
        handlab.load_hand(copy)


def test_a_mesh_file_with_something_behind_it_is_named(copy):
    (copy / "hand.glb").write_bytes((copy / "hand.glb").read_bytes() + b"more")
    with pytest.raises(ValueError, match=r"not a complete glTF 2\.0 binary file"):
        handlab.load_hand(copy)


def with_document(path, change):
    """A binary glTF file whose JSON text is changed."""
    whole = path.read_bytes()
    (size,) = struct.unpack_from("<I", whole, 12)
    document = json.loads(whole[20 : 20 + size])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + whole[20 + size :]
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body)


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.pop("meshes"),
        lambda d: d["accessors"].clear(),
        lambda d: d["bufferViews"][3].update(byteOffset=10**9),
        lambda d: d["accessors"][0].update(componentType=1),
        lambda d: d["accessors"][1].update(type="CUBE"),
        lambda d: d["meshes"].pop(0),
        lambda d: d["meshes"].pop(9),
        lambda d: d["meshes"][1]["primitives"][0]["attributes"].pop("_HEIGHT"),
    ],
)
def test_a_mesh_file_that_lacks_something_is_named(copy, change):
    with_document(copy / "hand.glb", change)
    with pytest.raises(ValueError, match="again"):
        handlab.load_hand(copy)


def test_garbage_instead_of_meshes_is_named(copy):
    (copy / "hand.glb").write_bytes(np.random.default_rng(0).bytes(5000))
    with pytest.raises(ValueError, match=r"not a complete glTF 2\.0 binary file"):
        handlab.load_hand(copy)


@pytest.mark.parametrize("text", ["", "{", "not json at all", '{"name": "x"', "\x00\x01\x02"])
def test_a_broken_joint_file_is_named(copy, text):
    (copy / "hand.json").write_text(text)
    with pytest.raises(ValueError, match=r"hand\.json is not readable.*again"):
        handlab.load_hand(copy)


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.pop("joints"),
        lambda d: d["joints"].pop("mcp2"),
        lambda d: d["joints"]["mcp2"]["dofs"]["mcp2.deviation"].pop("axis"),
        lambda d: d["joints"]["mcp2"]["dofs"]["mcp2.deviation"].update(axis=["a", "b", "c"]),
        lambda d: d["joints"]["mcp2"]["dofs"]["mcp2.deviation"].update(bind_deg=None),
        lambda d: d["bodies"]["carpus"].pop("mass_kg"),
        lambda d: d["bodies"]["carpus"].update(mass_kg="heavy"),
        lambda d: d["bodies"].clear(),
        lambda d: d.pop("feature_points"),
        lambda d: d.pop("side"),
        lambda d: d.update(joints=[]),
    ],
)
def test_a_joint_file_that_lacks_something_is_named(copy, change):
    content = json.loads((copy / "hand.json").read_text())
    change(content)
    (copy / "hand.json").write_text(json.dumps(content))
    with pytest.raises(ValueError, match=r"is not a complete hand.*again"):
        handlab.load_hand(copy)


@pytest.mark.parametrize("content", ["[]", "3", "null"])
def test_a_joint_file_that_is_no_record_is_named(copy, content):
    (copy / "hand.json").write_text(content)
    with pytest.raises(ValueError, match="is not a complete hand"):
        handlab.load_hand(copy)


def test_a_side_or_reading_that_no_hand_has_is_found_in_the_file_too(copy):
    for key, value in (("side", "middle"), ("reading", "loud")):
        content = json.loads((REFERENCE / "hand.json").read_text()) | {key: value}
        (copy / "hand.json").write_text(json.dumps(content))
        with pytest.raises(ValueError, match=value):
            handlab.load_hand(copy)


def test_arrays_of_a_loaded_hand_cannot_be_written(hand):
    for array in (hand.skin.points, hand.skin.faces, hand.skin.weights, hand.skin_fine.texture, hand.bind, hand.bones["radius"].points):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
