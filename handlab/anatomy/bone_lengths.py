"""Natural lengths of metacarpals and phalanges: ``assets/anatomy/bone_lengths.csv``, whose first line names the source."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from handlab.anatomy import data
from handlab.anatomy.terms import DIGITS

FILE = "anatomy/bone_lengths.csv"
BONES = ("metacarpal", "proximal_phalanx", "middle_phalanx", "distal_phalanx")
PULP = "pulp"


@cache
def bone_lengths_mm() -> Mapping[int, Mapping[str, float]]:
    """Length in mm of each bone of digit 1 to 5, and of the soft tissue beyond it (``pulp``); the thumb has no middle phalanx.

    Raises ``FileNotFoundError`` where the file is missing, ``ValueError`` (with its line) where it is broken.

    >>> bone_lengths_mm()[2]["metacarpal"]
    68.12
    """
    lines = (data.folder() / FILE).read_text(encoding="utf-8").splitlines()
    rows: dict[int, Mapping[str, float]] = {}
    reader = csv.reader(lines)
    heading: list[str] = []
    for cells in reader:
        if not cells or cells[0].startswith("#"):
            continue
        if not heading:
            heading = cells
            if set(heading) != {"digit", *BONES, PULP}:
                raise ValueError(
                    f"{FILE}, line {reader.line_num}: the columns are {heading}; they must be digit, {', '.join(BONES)}, {PULP}"
                )
            continue
        try:
            row = dict(zip(heading, cells, strict=True))
            rows[DIGITS[row["digit"]]] = MappingProxyType({name: _length(row[name]) for name in heading if name != "digit" and row[name]})
        except (KeyError, ValueError) as error:
            raise ValueError(f"{FILE}, line {reader.line_num}: {cells} is not a digit with its lengths in mm ({error})") from error
    if set(rows) != set(DIGITS.values()):
        raise ValueError(f"{FILE}: it must have one line for each of {', '.join(DIGITS)}")
    return MappingProxyType(rows)


@cache
def source() -> str:
    """Where the lengths come from: the file's first line."""
    return (data.folder() / FILE).read_text(encoding="utf-8").splitlines()[0].lstrip("# ")


def _length(text: str) -> float:
    value = float(text)
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{text} is not a length")
    return value
