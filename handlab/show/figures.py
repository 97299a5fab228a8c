"""matplotlib, set up to be read from ten metres, and figures that show once in a notebook."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from handlab.show.colours import FAINT, INK, LINES, MARKERS, OKABE_ITO, RULE

STYLE: dict[str, Any] = {
    "font.size": 15,
    "axes.titlesize": 17,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.labelsize": 15,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": RULE,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 3.0,
    "legend.frameon": False,
    "legend.handlelength": 3.6,
    "figure.constrained_layout.use": True,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
}


@contextmanager
def drawing(**figure: Any) -> Iterator[Any]:
    """A new figure in the house style; in a notebook it shows as the cell's result, once."""
    import matplotlib as mpl
    import matplotlib.pyplot as plt

    with plt.rc_context(STYLE):
        fig = plt.figure(**figure)
        try:
            yield fig
        except BaseException:
            plt.close(fig)
            raise
    if "inline" in mpl.get_backend():
        plt.close(fig)  # the inline backend would show it a second time at the end of the cell


def line(k: int) -> dict[str, Any]:
    """Colour and dash of the k-th line: neighbours differ in both, so that colour is never alone."""
    return {"color": OKABE_ITO[k % len(OKABE_ITO)], "linestyle": LINES[k % len(LINES)]}


def dot(k: int) -> dict[str, Any]:
    """Colour and shape of the k-th group of dots."""
    return {"color": OKABE_ITO[k % len(OKABE_ITO)], "marker": MARKERS[k % len(MARKERS)]}
