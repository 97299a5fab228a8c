"""Every symbol of NOTATION.md leads to code that exists."""

import importlib
import re
from pathlib import Path
from types import ModuleType

import pytest

import handlab as hl

PAGE = Path(__file__).parents[2] / "NOTATION.md"
UNITS = {"1", "m", "mm", "s", "N", "N/%", "%", "rad", "rad/s", "N m", "N m/rad", "N m s/rad", "kg", "kg m²", "m³", "Pa", "1/s"}


def rows():
    """(symbol, meaning, names in code, unit, place) of every row of every table with these five columns."""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if line.startswith("|") and len(cells) == 5 and not set(cells[0]) <= set("-: ") and cells[0] != "symbol":
            yield cells


ROWS = list(rows())


@pytest.fixture(scope="module")
def things():
    hand = hl.load_hand()
    clip = hl.simulate(hand, {"FDP2": 0.2}, seconds=0.05)
    return {
        "hand": hand,
        "clip": clip,
        "state": clip.states[0],
        "muscle": hand.muscles["FDP2"],
        "dof": hand.dofs["mcp2.flexion_extension"],
        "body": next(iter(hand.bodies.values())),
        "keyframes": hl.keyframes({"FDP2": 0.2}),
    }


def follow(name, things):
    head, *rest = name.split(".")
    thing = hl if head == "handlab" else things[head]
    for part in rest:
        if isinstance(thing, ModuleType) and not hasattr(thing, part):
            importlib.import_module(f"{thing.__name__}.{part}")
        thing = getattr(thing, part)
    return thing


def test_the_page_has_the_symbols_of_the_paper():
    symbols = " ".join(row[0] for row in ROWS)
    for symbol in ("c", "ℓ", "ℓ₀", "F_contr", "F_stretch", "F_max", "T", "J", "ω", "φ", "μ", "R"):
        assert symbol in symbols
    assert len(ROWS) >= 25


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_a_symbol_has_a_meaning_a_unit_and_a_name_that_exists(row, things):
    _, meaning, code, unit, place = row
    assert meaning
    assert place
    assert unit in UNITS
    names = re.findall(r"`([^`]+)`", code)
    assert names
    for name in names:
        assert follow(name, things) is not None
