"""Signs of all lever arms in use against two independent models; every disagreement stands here with its reason.

MyoHand (``moment_arms_myohand.csv``) and the OpenSim wrist model (``moment_arms_opensim_wrist.csv``), both in their neutral
posture. Their columns ``positive_r_means`` say which way their positive arm turns.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from handlab.anatomy import tables

DATA = Path(__file__).parents[1] / "data"

# Abbreviation -> path in MyoHand, where the name differs. ADM: its ulnar band of the little finger, the nearest path it has.
MYOHAND_NAMES = {"PI1": "UI_UB2", "PI2": "RI4", "PI3": "RI5", "DI1": "RI2", "DI2": "RI3", "DI3": "UI_UB3", "DI4": "UI_UB4"}
MYOHAND_NAMES |= {"LUM1": "LU_RB2", "LUM2": "LU_RB3", "LUM3": "LU_RB4", "LUM4": "LU_RB5", "OPP": "OP", "ADM": "UI_UB5"}
OPENSIM_NAMES = {
    **{f"{tendon}{digit}": f"{tendon}{letter}" for tendon in ("FDS", "FDP", "EDC") for digit, letter in zip("2345", "IMRL", strict=True)},
    "ECU": "ECU_pre-surgery",
}
NEGATIVE_WORDS = ("extension", "ulnar deviation")

# Muscles (and one joint) that neither model has.
WITHOUT_COUNTERPART = {"FDMB", "ODM", "APB", "FPB", "ADP"}
WITHOUT_COUNTERPART_AT = {("ADM", "cmc5.flexion_opposition")}

RADIAL_PATH = "MyoHand leads this tendon radial of the deviation axis of the wrist; the OpenSim wrist model has it ulnar, as used"
LITERAL = "adduction, read literally, is motion towards the middle finger, so radial here; MyoHand leads the tendon ulnar of the joint"
CENTRAL = "0.2 mm, a tendon over the middle of the joint: the copied row read literally, below 1 mm; MyoHand shifts it radially"
ENDS_BEFORE = "MyoHand's path ends before this joint (arm 0); the slip to the extensor hood, which extends it, is not modelled there"
SMALL = "below 1 mm in one of the two, and the model's sign changes or nearly so over the range"

DISAGREEMENTS = {
    ("FDS2", "wrist.deviation", "MyoHand"): RADIAL_PATH,
    ("FDS3", "wrist.deviation", "MyoHand"): RADIAL_PATH,
    ("FDS4", "wrist.deviation", "MyoHand"): RADIAL_PATH,
    ("FDP2", "wrist.deviation", "MyoHand"): RADIAL_PATH,
    ("FDP3", "wrist.deviation", "MyoHand"): RADIAL_PATH,
    ("FDP4", "wrist.deviation", "MyoHand"): RADIAL_PATH,
    ("FDP5", "wrist.deviation", "MyoHand"): RADIAL_PATH,
    ("FDS2", "mcp2.deviation", "MyoHand"): SMALL + "; 1.7 ulnar is An's measurement",
    ("FDP2", "mcp2.deviation", "MyoHand"): SMALL + "; 1.1 ulnar is An's measurement",
    ("FDS4", "mcp4.deviation", "MyoHand"): LITERAL,
    ("FDS5", "mcp5.deviation", "MyoHand"): LITERAL,
    ("FDP4", "mcp4.deviation", "MyoHand"): LITERAL,
    ("FDP5", "mcp5.deviation", "MyoHand"): LITERAL,
    ("FPL", "cmc1.abduction_adduction", "MyoHand"): "used as 0: Smutz 1998 calls it a pure flexor; MyoHand has 1.5 mm of abduction",
    ("EDC2", "wrist.deviation", "OpenSim"): "its path jumps at neutral; the slope over +-2 degrees about it, 1.8 mm radial, is used",
    ("EDC2", "mcp2.deviation", "MyoHand"): "0.2 mm as printed against 0.4 mm: both below 1 mm, a tendon over the middle of the joint",
    ("EDC4", "mcp4.deviation", "MyoHand"): CENTRAL,
    ("EDC5", "mcp5.deviation", "MyoHand"): CENTRAL,
    ("EIP", "wrist.deviation", "MyoHand"): "the OpenSim wrist model has 3.6 mm radial, as used; MyoHand's sign changes over its range",
    ("EIP", "mcp2.deviation", "MyoHand"): "printed and measured by An: it lies ulnar to the common extensor; MyoHand has it radial",
    ("EPB", "wrist.flexion_extension", "MyoHand"): "near the axis; OpenSim has flexion, as printed; MyoHand's sign changes over its range",
    ("EPB", "cmc1.abduction_adduction", "MyoHand"): "printed abduction; MyoHand has less than 1 mm of adduction",
    ("OPP", "cmc1.abduction_adduction", "MyoHand"): "MyoHand has 0.06 mm in its neutral posture and 4.2 mm of abduction further on",
    ("DI1", "mcp2.flexion_extension", "MyoHand"): "MyoHand's path extends at 0 only; from a quarter of the range on it flexes, 5 to 7 mm",
    ("LUM1", "dip2.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("LUM2", "dip3.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("LUM3", "dip4.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("LUM4", "dip5.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("PI1", "dip2.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("PI2", "pip4.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("PI2", "dip4.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("PI3", "pip5.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("PI3", "dip5.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("DI2", "pip3.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("DI2", "dip3.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("DI3", "dip3.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("DI4", "dip4.flexion_extension", "MyoHand"): ENDS_BEFORE,
    ("ADM", "dip5.flexion_extension", "MyoHand"): ENDS_BEFORE,
}


def joint_words(dof):
    """`mcp2.flexion_extension` -> how the two models name the joint, and the words of its two directions."""
    joint, kind = dof.split(".")
    fingers = {"1": "thumb", "2": "index", "3": "middle", "4": "ring", "5": "little"}
    name = joint if joint == "wrist" else f"{joint[:-1].upper()} {fingers[joint[-1]]}"
    special = {"deviation": ("radial deviation", "ulnar deviation"), "abduction_adduction": ("abduction",)}
    return name, special.get(kind, ("flexion", "extension"))


def read(file):
    with (DATA / file).open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def signed(row, column="r_neutral_mm"):
    return float(row[column]) * (-1.0 if row["positive_r_means"] in NEGATIVE_WORDS else 1.0)


def models():
    """(model, muscle, joint, direction word) -> row of the file."""
    myohand = {("MyoHand", row["muscle"], row["anatomical_joint"], row["positive_r_means"]): row for row in read("moment_arms_myohand.csv")}
    opensim = {("OpenSim", row["muscle"], "wrist", row["positive_r_means"]): row for row in read("moment_arms_opensim_wrist.csv")}
    return myohand | opensim


def comparisons():
    """(abbreviation, dof, model) -> (arm in use, arm of the model), millimetres, in our signs."""
    known, found = models(), {}
    for muscle in tables.muscles().values():
        for arm in muscle.lever_arms:
            if arm.status == "printed_only":  # not in use
                continue
            joint, directions = joint_words(arm.dof)
            for model, names in (("MyoHand", MYOHAND_NAMES), ("OpenSim", OPENSIM_NAMES)):
                name = names.get(muscle.abbreviation, muscle.abbreviation)
                for word in directions:
                    row = known.get((model, name, joint, word))
                    if row is not None:
                        found[muscle.abbreviation, arm.dof, model] = (arm.used * 1000, signed(row))
    return found


def disagreements(pairs):
    return {key for key, (used, theirs) in pairs.items() if np.sign(used) != np.sign(theirs)}


def test_the_signs_of_all_lever_arms_agree_with_both_models_except_where_a_reason_is_given():
    assert disagreements(comparisons()) - set(DISAGREEMENTS) == set()


def test_no_listed_disagreement_has_become_an_agreement():
    assert set(DISAGREEMENTS) - disagreements(comparisons()) == set()
    assert all(len(reason) > 20 for reason in DISAGREEMENTS.values())


def test_every_lever_arm_in_use_is_compared_or_known_to_have_no_counterpart():
    compared = {(muscle, dof) for muscle, dof, _ in comparisons()}
    alone = {
        (muscle.abbreviation, arm.dof)
        for muscle in tables.muscles().values()
        for arm in muscle.lever_arms
        if arm.status != "printed_only" and (muscle.abbreviation, arm.dof) not in compared
    }
    assert {pair for pair in alone if pair[0] not in WITHOUT_COUNTERPART} == WITHOUT_COUNTERPART_AT
    assert {muscle for muscle, _ in alone} - {"ADM"} == WITHOUT_COUNTERPART
    models_of_wrist = {muscle for muscle, _, model in comparisons() if model == "OpenSim"}
    assert len(models_of_wrist) == 24  # all extrinsic muscles


@pytest.mark.parametrize(
    ("muscle", "dof", "model"), [("FDP2", "wrist.flexion_extension", "OpenSim"), ("EDC3", "mcp3.flexion_extension", "MyoHand")]
)
def test_a_turned_sign_would_be_noticed(muscle, dof, model):
    pairs = comparisons()
    used, theirs = pairs[muscle, dof, model]
    assert disagreements({**pairs, (muscle, dof, model): (-used, theirs)}) - set(DISAGREEMENTS) == {(muscle, dof, model)}


def test_the_columns_of_the_models_are_read_with_their_own_signs():
    pairs = comparisons()  # what anatomy leaves no doubt about
    assert pairs["ECU", "wrist.deviation", "OpenSim"][1] < -20  # ulnar, though positive in its file
    assert pairs["ECRL", "wrist.deviation", "OpenSim"][1] > 20
    assert pairs["ECRL", "wrist.deviation", "MyoHand"][1] > 20
    assert pairs["FPL", "ip1.flexion_extension", "MyoHand"][1] > 3  # flexes, though negative in its file
    assert pairs["EPL", "mcp1.flexion_extension", "MyoHand"][1] < -3


def test_the_reasons_that_cite_a_range_or_a_slope_are_true():
    known = models()
    kink = known["OpenSim", "EDCI", "wrist", "ulnar deviation"]
    assert kink["kink_at_neutral"] == "1"
    assert signed(kink, "r_fd_pm2deg_mm") == pytest.approx(1.8, abs=0.05)
    first = known["MyoHand", "RI2", "MCP index", "flexion"]
    assert min(signed(first, column) for column in ("r_q25_mm", "r_q50_mm", "r_q75_mm")) > 5
    for name, joint, word in (("EIP", "wrist", "radial deviation"), ("EPB", "wrist", "flexion")):
        row = known["MyoHand", name, joint, word]
        assert signed(row) * signed(row, "r_q75_mm") < 0
    for (muscle, dof, _), reason in DISAGREEMENTS.items():
        joint, words = joint_words(dof)
        if reason is ENDS_BEFORE:
            row = known["MyoHand", MYOHAND_NAMES[muscle], joint, words[0]]
            assert all(float(row[column]) == 0 for column in ("r_neutral_mm", "r_q25_mm", "r_q50_mm", "r_q75_mm"))
        if reason is RADIAL_PATH:
            used, theirs = comparisons()[muscle, dof, "OpenSim"]
            assert used < 0 > theirs
        if reason in (CENTRAL,) or reason.startswith(SMALL):
            used, theirs = comparisons()[muscle, dof, "MyoHand"]
            assert min(abs(used), abs(theirs)) < 1
