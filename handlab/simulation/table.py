"""Columns of numbers with units in their names: what a clip hands to a spreadsheet."""

from __future__ import annotations

import os

import numpy as np

from handlab.anatomy.records import Array
from handlab.simulation.writing import write_text

SHOWN_COLUMNS = 6
SHOWN_ROWS = 4


class Table(dict[str, Array]):
    """Columns (T,) by heading; ``pandas.DataFrame(table)`` takes it as it is."""

    def __repr__(self) -> str:
        """The first columns of the first rows and the last."""
        headings = list(self)[:SHOWN_COLUMNS]
        rows = len(next(iter(self.values()), ()))
        shown = [*range(min(rows, SHOWN_ROWS)), *range(max(SHOWN_ROWS, rows - 1), rows)]
        width = [max(len(heading), 9) for heading in headings]
        text = ["  ".join(f"{heading:>{w}}" for heading, w in zip(headings, width, strict=True))]
        for k, row in enumerate(shown):
            if k and row != shown[k - 1] + 1:
                text.append("  ".join(f"{'...':>{w}}" for w in width))
            text.append("  ".join(f"{self[heading][row]:>{w}.4g}" for heading, w in zip(headings, width, strict=True)))
        return "\n".join([*text, f"{rows} rows, {len(self)} columns"])

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a CSV file with nine digits, whole or not at all."""
        rows = np.column_stack(list(self.values()))
        body = "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows)
        write_text(path, ",".join(self) + "\n" + body)
