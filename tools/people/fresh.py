"""Sixteen more people, drawn at random, never used to choose anything: ``python -m tools.people.fresh`` writes their file.

The people of ``shapes`` are those whose pictures were looked at while handlab's photo fit was made. These are for the verdict alone:
sex, age, ancestry, build, and length, thickness and spacing of the fingers and size of the hand are drawn from one seed, each
evenly over the range that ``shapes`` spans, and nobody is left out.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from tools.people.build import FILE, written
from tools.people.shapes import ANCESTRIES, hand

SEED = 20261122
KINDS = ("woman", "man", "child", "mixture")
EACH = 4
RANGES = {"length": (-0.5, 0.35), "diameter": (-0.6, 0.6), "distance": (-0.6, 0.6), "scale": (-0.4, 0.2)}
SEXES = {"woman": {"female": 1.0}, "man": {"male": 1.0}}


def people(seed: int = SEED) -> dict[str, dict[str, float]]:
    """Shapes by name, such as ``woman_1``."""
    rng = np.random.default_rng(seed)
    return {f"{kind}_{number}": _one(kind, rng) for kind in KINDS for number in range(1, EACH + 1)}


def _one(kind: str, rng: np.random.Generator) -> dict[str, float]:
    female = float(rng.uniform())
    sexes = SEXES.get(kind, {"female": female, "male": 1.0 - female})
    share = float(rng.uniform())
    ages = {
        "woman": {"young": 1.0 - share, "old": share},
        "man": {"young": 1.0 - share, "old": share},
        "child": {"child": 1.0 - 0.5 * share, "baby": 0.5 * share},
        "mixture": {"child": 1.0 - share, "young": share},  # half grown
    }[kind]
    ancestry = dict(zip(ANCESTRIES, rng.dirichlet(np.ones(len(ANCESTRIES))), strict=True))
    builds = dict(zip(("minmuscle", "averagemuscle", "maxmuscle"), rng.dirichlet(np.ones(3)), strict=True))
    shape: dict[str, float] = {}
    for sex, part in sexes.items():
        for age, weight in ages.items():
            shape |= {f"macrodetails/{a}-{sex}-{age}": part * weight * s for a, s in ancestry.items()}
            shape |= {f"macrodetails/universal-{sex}-{age}-{b}-averageweight": part * weight * s for b, s in builds.items()}
    amounts = {part: float(rng.uniform(low, high)) for part, (low, high) in RANGES.items()}
    return shape | hand(**amounts)


if __name__ == "__main__":
    written(people(), Path(sys.argv[1]) if len(sys.argv) > 1 else FILE.with_name("people_fresh.npz"))
