"""The tables: complete, sourced, and true to Table 1 in both readings."""

import copy
import csv
import math
from collections import Counter, defaultdict
from itertools import pairwise
from pathlib import Path

import pytest

from handlab.anatomy import data, table_rules, tables
from handlab.anatomy.table_rules import TableError
from handlab.anatomy.terms import BODIES, BONES, SIGNS

DATA = Path(__file__).parents[1] / "data"
FILES = ("muscles.json", "joints.json", "thenar_rows.json", "passive.json")
DOF_ORDER = (
    *("wrist.flexion_extension", "wrist.deviation"),
    *("cmc1.flexion_opposition", "cmc1.abduction_adduction", "cmc1.axial_rotation", "mcp1.flexion_extension", "ip1.flexion_extension"),
    *("cmc4.flexion_opposition", "cmc4.axial_rotation", "cmc5.flexion_opposition", "cmc5.axial_rotation"),
    *(f"mcp{digit}.{kind}" for digit in (2, 3, 4, 5) for kind in ("flexion_extension", "deviation", "axial_rotation")),
    *(f"{joint}{digit}.flexion_extension" for joint in ("pip", "dip") for digit in (2, 3, 4, 5)),
)


def table(file):
    return data.read_json(f"anatomy/{file}")


def by_abbreviation():
    return {muscle.abbreviation: muscle for muscle in tables.muscles().values()}


def arms(abbreviation, reading):
    """{dof: mm} of one muscle in one reading, without zeros."""
    pairs = {arm.dof: 1000 * getattr(arm, reading) for arm in by_abbreviation()[abbreviation].lever_arms}
    return {dof: pytest.approx(value) for dof, value in pairs.items() if value}


# ---------------------------------------------------------------- sources


def unsourced(node, known, sources=None, place=""):
    """Every number below ``node`` whose own object names no source that exists (written again here, not taken from the package)."""
    if isinstance(node, dict):
        own = node.get("sources")
        return [bad for key, value in node.items() for bad in unsourced(value, known, own, f"{place}/{key}")]
    if isinstance(node, list):
        return [bad for index, value in enumerate(node) for bad in unsourced(value, known, sources, f"{place}/{index}")]
    if type(node) in (int, float) and not (sources and set(sources) <= known):
        return [place]
    return []


def count_numbers(node):
    if isinstance(node, (dict, list)):
        return sum(map(count_numbers, node.values() if isinstance(node, dict) else node))
    return int(type(node) in (int, float))


@pytest.mark.parametrize("file", FILES)
def test_every_number_of_the_tables_has_a_source_that_exists(file):
    assert unsourced(table(file), set(tables.sources())) == []


def test_the_search_for_sources_meets_every_figure():
    assert count_numbers(table("muscles.json")) == 2 * 180 + 2 * 42 + 42 + 3  # arms, rest lengths, tension, force scale
    assert count_numbers(table("thenar_rows.json")) == 3
    assert count_numbers(table("joints.json")) > 2 * 31 + 2 * 23 + 2 * 8


def without_its_source(content):
    """One copy of ``content`` for each object that holds a number, with its sources taken away."""

    def walk(node, path):
        items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
        for key, value in items:
            yield from walk(value, [*path, key])
        if isinstance(node, dict) and "sources" in node and count_numbers({key: v for key, v in node.items() if not isinstance(v, dict)}):
            yield path

    for path in walk(content, []):
        broken = copy.deepcopy(content)
        node = broken
        for key in path:
            node = node[key]
        del node["sources"]
        yield path, broken


def test_a_figure_without_source_is_found_wherever_it_stands():
    known = tables.sources()
    content = table("joints.json")
    tried = 0
    for path, broken in without_its_source(content):
        assert unsourced(broken, set(known)), path
        with pytest.raises(TableError, match="has no source"):
            table_rules.validate_joints(broken, known)
        tried += 1
    assert tried > 100
    small = {**table("muscles.json"), "muscles": table("muscles.json")["muscles"][:2]}
    for path, broken in without_its_source(small):
        assert unsourced(broken, set(known)), path
        with pytest.raises(TableError, match="has no source"):
            table_rules.validate_muscles(broken, known, tables.dof_names())


def test_every_source_says_what_it_is_and_is_used():
    text = "".join((data.folder() / "anatomy" / file).read_text(encoding="utf-8") for file in FILES)
    for key, source in tables.sources().items():
        assert set(source) == {"what", "kind"}
        assert all(source.values())
        assert f'"{key}"' in text, f"no table uses {key}"


# ---------------------------------------------------------------- counts


def test_there_are_42_muscles_20_joints_31_degrees_of_freedom_and_23_of_them_move_freely():
    joints = tables.joints_table()
    dofs = [dof for joint in joints.values() for dof in joint.dofs]
    assert len(tables.muscles()) == 42
    assert Counter(muscle.group for muscle in tables.muscles().values()) == {"extrinsic": 24, "intrinsic": 18}
    of_fingers = [f"{joint}{digit}" for joint in ("cmc", "mcp", "pip", "dip") for digit in (2, 3, 4, 5)]
    assert list(joints) == ["wrist", "cmc1", "mcp1", "ip1", *of_fingers]
    assert [dof.name for dof in dofs] == list(DOF_ORDER) == list(tables.dof_names())
    assert sum(dof.driver is None for dof in dofs) == 23
    assert [name for name, joint in joints.items() if not joint.dofs] == ["cmc2", "cmc3"]


def test_every_muscle_has_words_for_its_action_nerve_roots_origin_and_insertion_and_a_region():
    regions = Counter(muscle.region for muscle in tables.muscles().values())
    assert regions == {
        "forearm flexors": 11,
        "forearm extensors": 9,
        "long thumb muscles": 4,
        "thenar": 4,
        "hypothenar": 3,
        "lumbricals": 4,
        "interossei": 7,
    }
    for muscle in tables.muscles().values():
        for word in (muscle.action, muscle.nerve, muscle.branch, muscle.roots, muscle.origin, muscle.insertion):
            assert len(word) >= 5, muscle.name
        assert muscle.latin.startswith("musculus ")
        assert muscle.roots.startswith(("C6", "C7", "C8"))
        assert muscle.paralysed_in or muscle.partially_paralysed_in
    assert len({muscle.latin for muscle in tables.muscles().values()}) == 42
    assert len({muscle.action for muscle in tables.muscles().values()}) == 42


def test_a_high_ulnar_palsy_takes_sixteen_muscles_and_half_of_the_short_thumb_flexor():
    ulnar = {name for name, muscle in by_abbreviation().items() if "high_ulnar" in muscle.paralysed_in}
    interossei = {"PI1", "PI2", "PI3", "DI1", "DI2", "DI3", "DI4"}
    assert ulnar == {"FCU", "FDP4", "FDP5", "ADM", "FDMB", "ODM", "ADP", "LUM3", "LUM4"} | interossei
    assert by_abbreviation()["FPB"].partially_paralysed_in == ("low_median", "high_median", "low_ulnar", "high_ulnar")
    radial = {name for name, muscle in by_abbreviation().items() if "high_radial" in muscle.paralysed_in}
    assert radial == {"ECRL", "ECRB", "EDC2", "EDC3", "EDC4", "EDC5", "EDM", "ECU", "EPL", "EIP", "APL", "EPB"}


def test_a_muscle_prints_as_a_table_with_units_and_sources():
    shown = repr(tables.muscles()["opponens_digiti_minimi"])
    for part in ("15.0 mm", "(printed 34.0 mm)", "2.0 %", "BRAND81", "ulnar", "cmc5.flexion_opposition"):
        assert part in shown


# ---------------------------------------------------------------- the printed reading

TOWARDS_MIDDLE = {"index": -1, "middle": -1, "ring": +1, "pinky": +1}  # radial is positive
DIGIT = {"thumb": 1, "index": 2, "middle": 3, "ring": 4, "pinky": 5}


def resolve(joint, motion, mm):
    """Printed joint, motion and figure -> (dof, signed mm), after the rules in the table's ``meta``."""
    kind, _, finger = joint.partition(" ")
    at = kind.lower() + (str(DIGIT[finger]) if finger else "")
    if motion == "opp.":
        return f"{at}.flexion_opposition", mm
    if motion in ("flex.", "ext."):
        dof = "flexion_opposition" if at == "cmc1" else "flexion_extension"
        return f"{at}.{dof}", mm if motion == "flex." else -mm
    if motion.startswith("radial"):
        return f"{at}.deviation", mm
    if at == "cmc1":
        return f"{at}.abduction_adduction", mm if motion == "abd." else -mm
    if at == "wrist":
        return f"{at}.deviation", mm if motion == "abd." else -mm
    towards = TOWARDS_MIDDLE[finger]
    return f"{at}.deviation", mm * (towards if motion == "add." else -towards)


def printed_lines():
    """muscle -> [(joint, motion, mm)] of Table 1, rows of the slipped block assigned to their muscles."""
    lines = defaultdict(list)
    with (DATA / "table_1_as_printed.csv").open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            lines[row["muscle"]].append((row["joint"], row["motion"], row["lever_arm_mm"]))
    return lines


def test_the_printed_reading_has_every_line_of_table_1_where_and_as_it_is_printed():
    lines = printed_lines()
    assert sum(map(len, lines.values())) == 109
    for abbreviation, muscle in by_abbreviation().items():
        ours = {(arm.dof, 1000 * arm.printed, arm.printed_as) for arm in muscle.lever_arms if arm.printed_basis == "printed"}
        printed = lines.get(abbreviation, [])
        theirs = {(*resolve(joint, motion, float(mm)), f"{joint} {motion} {float(mm):g}") for joint, motion, mm in printed}
        assert len(theirs) == len(printed)
        assert {(dof, words) for dof, _, words in ours} == {(dof, words) for dof, _, words in theirs}, abbreviation
        for (_, mine, _), (_, other, _) in zip(sorted(ours), sorted(theirs), strict=True):
            assert mine == pytest.approx(other, abs=1e-12)


@pytest.mark.parametrize(
    ("muscle", "printed"),
    [
        ("FDP2", {"wrist.flexion_extension": 6, "wrist.deviation": -13, "mcp2.flexion_extension": 11.1, "mcp2.deviation": -6,
                  "pip2.flexion_extension": 7.9, "dip2.flexion_extension": 4.1}),
        ("FDP3", {"wrist.flexion_extension": 6, "wrist.deviation": -13, "mcp3.flexion_extension": 11.1, "mcp3.deviation": -6,
                  "pip3.flexion_extension": 7.9, "dip3.flexion_extension": 4.1}),
        ("FDP5", {"wrist.flexion_extension": 6, "wrist.deviation": -13, "mcp5.flexion_extension": 11.1, "mcp5.deviation": 6,
                  "pip5.flexion_extension": 7.9, "dip5.flexion_extension": 4.1}),
        ("FDS4", {"wrist.flexion_extension": 15, "wrist.deviation": -3, "mcp4.flexion_extension": 11.9, "mcp4.deviation": 1.7,
                  "pip4.flexion_extension": 6.2}),
        ("EDC4", {"wrist.flexion_extension": -13, "wrist.deviation": -7.5, "mcp4.flexion_extension": -8.6, "mcp4.deviation": -0.2,
                  "pip4.flexion_extension": -2.8, "dip4.flexion_extension": -2.2}),
        ("EIP", {"wrist.flexion_extension": 1.4, "wrist.deviation": 0.4, "mcp2.flexion_extension": -9, "mcp2.deviation": -1.3,
                 "pip2.flexion_extension": -2.6, "dip2.flexion_extension": -1.9}),
        ("FPL", {"wrist.flexion_extension": 5, "wrist.deviation": 13, "cmc1.abduction_adduction": -10, "cmc1.flexion_opposition": 10,
                 "mcp1.flexion_extension": 7.5, "ip1.flexion_extension": 5.5}),
        ("ECRB", {"wrist.flexion_extension": -13, "wrist.deviation": 24}),
        ("FDMB", {"cmc5.flexion_opposition": 6, "mcp2.flexion_extension": 4, "mcp2.deviation": 4}),
        ("OPP", {"cmc1.flexion_opposition": 4, "cmc1.abduction_adduction": -8.5}),
        ("PI1", {"mcp2.flexion_extension": 6.6, "mcp2.deviation": -5.8, "pip2.flexion_extension": -1.6, "dip2.flexion_extension": -2.6}),
        ("PI2", {"mcp4.flexion_extension": 6.6, "mcp4.deviation": 5.8, "pip4.flexion_extension": -1.6, "dip4.flexion_extension": -2.6}),
        ("DI1", {"mcp2.flexion_extension": 3.7, "mcp2.deviation": 6.1, "pip2.flexion_extension": -2.6, "dip3.flexion_extension": -1.6}),
        ("DI3", {"mcp3.flexion_extension": 3.7, "mcp3.deviation": -6.1, "pip3.flexion_extension": -2.6, "dip3.flexion_extension": -1.6}),
        ("DI4", {"mcp5.flexion_extension": 3.7, "mcp5.deviation": -6.1, "pip5.flexion_extension": -2.6, "dip5.flexion_extension": -1.6}),
        ("LUM4", {"mcp5.flexion_extension": 5, "mcp5.deviation": 4.8, "pip5.flexion_extension": -1.8, "dip5.flexion_extension": -0.7}),
    ],
)  # fmt: skip
def test_the_printed_reading_moves_each_joint_as_the_words_of_table_1_say(muscle, printed):
    assert arms(muscle, "printed") == printed


@pytest.mark.parametrize(
    ("muscle", "used"),
    [
        ("FDP2", {"wrist.flexion_extension": 13, "wrist.deviation": -0.5, "mcp2.flexion_extension": 11.1, "mcp2.deviation": -1.1,
                  "pip2.flexion_extension": 7.9, "dip2.flexion_extension": 4.1}),
        ("FDMB", {"cmc5.flexion_opposition": 6, "mcp5.flexion_extension": 4, "mcp5.deviation": -4}),
        ("DI1", {"mcp2.flexion_extension": 3.7, "mcp2.deviation": 6.1}),
        ("DI4", {"mcp4.flexion_extension": 3.7, "mcp4.deviation": -6.1, "pip4.flexion_extension": -2.6, "dip4.flexion_extension": -1.6}),
        ("OPP", {"cmc1.flexion_opposition": 8.5, "cmc1.abduction_adduction": 4}),
        ("EIP", {"wrist.flexion_extension": -14, "wrist.deviation": 4, "mcp2.flexion_extension": -9, "mcp2.deviation": -1.3,
                 "pip2.flexion_extension": -2.6, "dip2.flexion_extension": -1.9}),
        ("APL", {"wrist.flexion_extension": 7.4, "wrist.deviation": 24, "cmc1.flexion_opposition": -0.5, "cmc1.abduction_adduction": 2.7}),
    ],
)  # fmt: skip
def test_the_default_reading_keeps_every_muscle_at_its_own_joints(muscle, used):
    assert arms(muscle, "used") == used


@pytest.mark.parametrize(
    ("follower", "named", "digits"),
    [
        *(("FDS4", "FDS3", "34"), ("FDS5", "FDS3", "35")),
        *(("FDP3", "FDP2", "23"), ("FDP4", "FDP2", "24"), ("FDP5", "FDP2", "25")),
        *(("EDC3", "EDC2", "23"), ("EDC4", "EDC2", "24"), ("EDC5", "EDC2", "25")),
        *(("LUM2", "LUM1", "23"), ("LUM4", "LUM3", "45"), ("PI2", "PI1", "24"), ("DI3", "DI2", "33")),
    ],
)  # fmt: skip
def test_analogously_copies_the_printed_row_of_the_named_muscle(follower, named, digits):
    def unsigned(muscle):
        return {arm.dof: abs(arm.printed) for arm in by_abbreviation()[muscle].lever_arms if arm.printed}

    moved = {dof.replace(digits[0], digits[1]): size for dof, size in unsigned(named).items()}
    assert unsigned(follower) == moved
    for arm in by_abbreviation()[follower].lever_arms:
        assert arm.printed_basis == "analogous"
        if not arm.dof.endswith("deviation"):  # which way that is depends on the finger
            assert math.copysign(1, arm.printed) == math.copysign(1, next(
                source.printed for source in by_abbreviation()[named].lever_arms if source.dof.replace(*digits) == arm.dof))  # fmt: skip


def test_every_difference_between_printed_and_used_has_its_reason():
    different = [(muscle.abbreviation, arm) for muscle in tables.muscles().values() for arm in muscle.lever_arms if arm.used != arm.printed]
    assert all(arm.reason and len(arm.reason) > 30 for _, arm in different)
    equal = [arm for muscle in tables.muscles().values() for arm in muscle.lever_arms if arm.used == arm.printed]
    assert all(arm.reason is None or arm.status == "added" for arm in equal)
    assert Counter(name for name, _ in different) == {
        "FDS2": 1, "FDP2": 3, "FDP3": 3, "FDP4": 3, "FDP5": 3, "FPL": 3, "ECRB": 1, "EDC2": 1, "EDC3": 1, "EDC4": 1, "EDC5": 1, "EIP": 2,
        "FDMB": 4, "OPP": 2, "PI1": 2, "PI2": 2, "PI3": 2, "DI1": 2, "DI4": 8,
    }  # fmt: skip


def test_what_is_not_printed_takes_the_used_value_and_is_listed_in_the_readme():
    listed = tables.not_printed()
    names = {muscle.name: muscle.abbreviation for muscle in tables.muscles().values()}
    assert sorted((names[muscle], what) for muscle, what in listed) == sorted(
        [(name, "rest length") for name in ["FDS4", "FDS5", "FDP3", "FDP4", "FDP5", "EDC3", "EDC4", "EDC5"]]
        + [("EDM", "mcp5.deviation"), ("APL", "cmc1.abduction_adduction")]
        + [(name, "mcp1.flexion_extension") for name in ("APB", "FPB", "ADP")]
    )
    readme = (data.folder() / "anatomy" / "README.md").read_text(encoding="utf-8")
    for muscle, what in listed:
        assert f"{names[muscle]}: {what}" in readme
        if what != "rest length":
            assert all(arm.used == arm.printed for arm in tables.muscles()[muscle].lever_arms if arm.dof == what)


def test_rest_lengths_differ_only_where_table_1_repeats_a_line():
    muscles = by_abbreviation()
    assert {name for name, muscle in muscles.items() if muscle.rest_length != muscle.rest_length_printed} == {"ODM"}
    assert (muscles["ODM"].rest_length, muscles["ODM"].rest_length_printed) == (0.015, 0.034)
    assert sum(muscle.rest_length_basis == "printed" for muscle in muscles.values()) == 34
    printed = {"FCR": 52, "FDS2": 72, "FDS3": 70, "FDP2": 66, "ECRL": 93, "EDC2": 55, "EPB": 43}
    printed |= {"ADM": 40, "OPP": 24, "LUM2": 66, "PI3": 15, "DI4": 25}
    assert {name: round(1000 * muscles[name].rest_length_printed, 9) for name in printed} == printed


def test_the_thenar_muscles_get_their_thumb_row_as_a_marked_assumption():
    muscles = tables.muscles()
    marked = [(muscle.abbreviation, arm) for muscle in muscles.values() for arm in muscle.lever_arms if arm.assumption]
    assert sorted(name for name, _ in marked) == ["ADP", "APB", "FPB"]
    for _, arm in marked:
        assert (arm.dof, arm.status, arm.confidence) == ("mcp1.flexion_extension", "added", "low")
        assert 0.001 < arm.used < 0.012  # flexes, and stays inside the thumb
        assert arm.reason is None or len(arm.reason) > 20


def test_forces_are_of_the_size_that_the_tension_fractions_say():
    assert tables.newton_per_percent() == 20.0
    assert sum(muscle.tension_percent for muscle in tables.muscles().values()) == pytest.approx(84.4, abs=0.05)
    assert max(tables.muscles().values(), key=lambda muscle: muscle.tension_percent).abbreviation == "FCU"


# ---------------------------------------------------------------- joints


def dofs():
    return {dof.name: dof for joint in tables.joints_table().values() for dof in joint.dofs}


@pytest.mark.parametrize(
    ("name", "limits", "printed"),
    [
        ("wrist.flexion_extension", (-70, 75), (-70, 75)),
        ("wrist.deviation", (-35, 20), (-35, 20)),
        ("cmc1.flexion_opposition", (-20, 33), (-20, 33)),
        ("cmc1.abduction_adduction", (-7, 45), (-7, 45)),
        ("mcp1.flexion_extension", (-10, 55), (-10, 55)),
        ("ip1.flexion_extension", (-15, 80), (-15, 80)),
        ("cmc4.axial_rotation", (-21.6, 5.4), (-21.6, 5.4)),
        ("cmc5.flexion_opposition", (-5, 22), (-5, 22)),
        ("mcp4.flexion_extension", (-30, 90), (0, 90)),
        ("mcp3.deviation", (-15, 15), (-15, 15)),
        ("pip5.flexion_extension", (0, 110), (0, 110)),
        ("dip2.flexion_extension", (0, 90), (0, 90)),
    ],
)
def test_limits_are_those_of_the_sources_and_the_paper_lets_no_finger_hyperextend(name, limits, printed):
    row = dofs()[name]
    assert [math.degrees(value) for value in row.limits] == pytest.approx(limits)
    assert [math.degrees(value) for value in row.printed_limits] == pytest.approx(printed)
    assert row.sources


def test_followers_have_the_ratios_and_offsets_of_the_sources():
    followers = {name: (dof.driver, dof.ratio, math.degrees(dof.offset)) for name, dof in dofs().items() if dof.driver}
    assert followers == {
        "cmc1.axial_rotation": ("cmc1.flexion_opposition", pytest.approx(17 / 53), pytest.approx(17 / 53 * 20)),
        "cmc4.flexion_opposition": ("cmc5.flexion_opposition", 0.5, 0.0),
        "cmc4.axial_rotation": ("cmc4.flexion_opposition", -0.8, 0.0),
        "cmc5.axial_rotation": ("cmc5.flexion_opposition", -0.8, 0.0),
        "mcp2.axial_rotation": ("mcp2.flexion_extension", 0.0, 0.0),
        "mcp3.axial_rotation": ("mcp3.flexion_extension", -0.03, 0.0),
        "mcp4.axial_rotation": ("mcp4.flexion_extension", -0.08, 0.0),
        "mcp5.axial_rotation": ("mcp5.flexion_extension", -0.10, 0.0),
    }


def test_a_follower_stays_within_its_own_limits_over_the_whole_range_of_its_driver():
    rows = dofs()

    def reach(dof):
        if dof.driver is None:
            return dof.limits
        low, high = sorted(dof.ratio * angle + dof.offset for angle in reach(rows[dof.driver]))
        return low, high

    for dof in rows.values():
        low, high = reach(dof)
        assert dof.limits[0] - 1e-12 <= low <= high <= dof.limits[1] + 1e-12, dof.name
    assert [math.degrees(angle) for angle in reach(rows["cmc1.axial_rotation"])] == pytest.approx([0, 17])


def test_the_relaxed_posture_is_a_cascade_between_the_two_postures_that_were_tried():
    rest = {name: math.degrees(dof.fibre_rest) for name, dof in dofs().items()}
    for joint, relaxed, half_closed in (("mcp", 30, 45), ("pip", 40, 50), ("dip", 20, 25)):
        cascade = [rest[f"{joint}{digit}.flexion_extension"] for digit in (2, 3, 4, 5)]
        assert all(a < b for a, b in pairwise(cascade))
        assert relaxed - 1e-9 <= cascade[0]
        assert cascade[-1] <= half_closed
    assert -15 <= rest["wrist.flexion_extension"] <= -10
    assert (rest["cmc1.flexion_opposition"], rest["cmc1.abduction_adduction"]) == pytest.approx((10, 20))
    assert (rest["mcp1.flexion_extension"], rest["ip1.flexion_extension"]) == pytest.approx((10, 15))
    assert rest["cmc1.axial_rotation"] == pytest.approx(17 / 53 * 30)  # followers follow
    assert rest["mcp5.axial_rotation"] == pytest.approx(-0.1 * rest["mcp5.flexion_extension"])
    assert all(dof.limits[0] <= dof.fibre_rest <= dof.limits[1] for dof in dofs().values())
    assert all(rest[f"mcp{k}.deviation"] == 0 for k in (2, 3, 4, 5))


def test_joints_connect_the_19_bodies_to_one_tree_and_name_their_bones():
    joints = tables.joints_table()
    children = [joint.child for joint in joints.values() if joint.dofs]
    assert sorted(children) == sorted(set(BODIES) - {"forearm"})
    reached = ["forearm"]
    for joint in joints.values():  # parents come first, so the order of the table builds the tree
        assert joint.parent in reached
        reached.append(joint.child)
    for joint in joints.values():
        assert {*joint.parent_bones, *joint.child_bones} <= set(BONES)
        assert {BONES[bone].body for bone in joint.child_bones} == {joint.child}
        assert {BONES[bone].body for bone in joint.parent_bones} == {joint.parent}
    assert (joints["cmc3"].parent, joints["cmc3"].child) == ("carpus", "carpus")
    assert len({joint.english for joint in joints.values()}) == len({joint.latin for joint in joints.values()}) == 20
    for dof in dofs().values():
        assert (dof.positive, dof.negative) == SIGNS[dof.name.split(".")[1]]


# ---------------------------------------------------------------- broken tables


def broken_muscles(change):
    content = copy.deepcopy({**table("muscles.json"), "muscles": table("muscles.json")["muscles"][:3]})
    change(content["muscles"])
    return content


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda rows: rows[0]["lever_arms"][0].update(sources=["T9"]), r"muscles\[0\]\.lever_arms\[0\]\.used_mm has no source"),
        (lambda rows: rows[0]["lever_arms"][0].update(sources=[]), "has no source"),
        (
            lambda rows: rows[0]["lever_arms"][0].update(dof="wrist.flexion"),
            "unknown degree of freedom 'wrist.flexion'; nearest are wrist.flexion_extension",
        ),
        (
            lambda rows: rows[0]["lever_arms"][0].update(used_mm=math.nan),
            "used_mm of the lever arm of flexor_carpi_radialis at wrist.flexion_extension is nan",
        ),
        (lambda rows: rows[0]["lever_arms"][0].update(printed_mm="17"), "must be a finite number"),
        (lambda rows: rows[0]["lever_arms"][0].update(used_mm=1), "used as 1 mm but printed as 17.5 mm, without a 'reason'"),
        (
            lambda rows: rows[0]["lever_arms"].append(rows[0]["lever_arms"][1]),
            "lever arm of flexor_carpi_radialis at 'wrist.deviation' stands there twice",
        ),
        (lambda rows: rows.append(rows[0]), "muscle 'flexor_carpi_radialis' stands there twice"),
        (lambda rows: rows[1].update(abbreviation="fcr"), "abbreviation 'fcr' stands there twice"),
        (lambda rows: rows[0]["rest_length"].update(used_mm=0), "must be positive"),
        (lambda rows: rows[0]["rest_length"].update(printed_basis="not printed, used value", used_mm=9), "must have the same figure"),
        (lambda rows: rows[0]["tension"].update(percent=math.inf), "must be a finite number"),
        (lambda rows: rows[0].pop("origin"), "flexor_carpi_radialis has no 'origin'"),
        (lambda rows: rows[0]["lever_arms"][0].update(status="guessed"), "it must be one of as_printed"),
        (lambda rows: rows[0]["lever_arms"][0].update(printed_as=None), "must have 'printed_as' exactly if"),
        (lambda rows: rows[0]["lever_arms"][0].update(printed_basis="printed at another joint", printed_as=None), "must be 0"),
        (
            lambda rows: rows[0]["lever_arms"][0].update(printed_basis="not printed, used value", printed_as=None, used_mm=1, reason="x"),
            "same figure",
        ),
    ],
)
def test_a_broken_muscle_table_is_refused_with_its_place(change, complaint):
    table_rules.validate_muscles(broken_muscles(lambda rows: None), tables.sources(), tables.dof_names())
    with pytest.raises(TableError, match=complaint):
        table_rules.validate_muscles(broken_muscles(change), tables.sources(), tables.dof_names())


def rows_of(content):
    return {dof["name"]: dof for joint in content["joints"] for dof in joint["dofs"]}


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda content: rows_of(content)["mcp2.deviation"]["limits"].update(deg=[15, -15]), "the lower one first"),
        (lambda content: rows_of(content)["mcp2.deviation"]["limits"].update(deg=[15]), "the lower one first"),
        (lambda content: rows_of(content)["mcp2.deviation"]["fibre_rest"].update(deg=20), "outside its limits"),
        (
            lambda content: rows_of(content)["mcp2.axial_rotation"].update(fibre_rest={"deg": 0, "sources": ["CHOICE"]}),
            "can have no 'fibre_rest'",
        ),
        (lambda content: content["couplings"][0].update(driver="cmc9.flexion"), "a coupling names 'cmc9.flexion', which no joint has"),
        (lambda content: content["couplings"][0].update(ratio=math.nan), "must be a finite number"),
        (lambda content: content["couplings"].append(content["couplings"][0]), "stands there twice"),
        (lambda content: content["couplings"][1].update(driver="cmc4.axial_rotation"), "runs in a circle"),
        (lambda content: content["joints"][0].update(parent_bones=["radios"]), "unknown bone 'radios'; nearest are radius"),
        (lambda content: rows_of(content)["mcp2.deviation"].update(name="mcp2.spread"), "must read mcp2.KIND"),
        (lambda content: content["joints"].append(content["joints"][4]), "joint 'cmc2' stands there twice"),
    ],
)
def test_a_broken_joint_table_is_refused_with_its_place(change, complaint):
    content = copy.deepcopy(table("joints.json"))
    table_rules.validate_joints(content, tables.sources())
    change(content)
    with pytest.raises(TableError, match=complaint):
        table_rules.validate_joints(content, tables.sources())


def test_an_added_row_for_an_unknown_muscle_or_on_top_of_an_existing_row_is_refused():
    rows = table("muscles.json")["muscles"]
    row = {**table("thenar_rows.json")["rows"][0]}
    with pytest.raises(TableError, match="unknown muscle 'adductor_policis'; nearest are adductor_pollicis"):
        tables.merge_added_rows(rows, [{**row, "muscle": "adductor_policis"}])
    merged = tables.merge_added_rows(rows, [{**row, "dof": "cmc1.flexion_opposition"}])
    with pytest.raises(TableError, match="stands there twice"):
        table_rules.validate_muscles({**table("muscles.json"), "muscles": merged}, tables.sources(), tables.dof_names())
