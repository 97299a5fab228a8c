"""Where the data is: one function finds ``assets`` in a clone and in an installed wheel."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NoReturn

PACKAGE = Path(__file__).resolve().parents[1]


def folder() -> Path:
    """The folder ``assets``: inside the package (installed wheel) or beside it (clone).

    Raises ``FileNotFoundError`` that names both places if neither holds the tables.
    """
    places = (PACKAGE / "assets", PACKAGE.parent / "assets")
    for place in places:
        # Not just any folder of that name: beside an installed package lies the rest of site-packages.
        if (place / "anatomy" / "muscles.json").is_file():
            return place
    raise FileNotFoundError(
        f"the data of handlab is missing: neither {places[0]} nor {places[1]} holds anatomy/muscles.json; "
        "install handlab again, or clone the whole repository"
    )


def _no_such_number(word: str) -> NoReturn:
    raise ValueError(f"{word} is not a number that a table may hold")


def read_json(name: str) -> Any:
    """Content of the JSON file ``name`` (like ``anatomy/joints.json``) in ``folder()``.

    NaN and infinity, which Python's reader would let pass, are refused.
    Raises ``FileNotFoundError`` (no such file) or ``ValueError`` (file, and line where the reader knows it).
    """
    path = folder() / name
    try:
        return json.loads(path.read_text(encoding="utf-8"), parse_constant=_no_such_number)
    except FileNotFoundError:
        raise FileNotFoundError(f"{name} is missing in {folder()}; install handlab again, or clone the whole repository") from None
    except ValueError as error:
        raise ValueError(f"{path} is not readable as a table: {error}") from error
