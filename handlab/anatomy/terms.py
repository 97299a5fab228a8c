"""The words of the hand, each in one place: fingers, signs, bones, bodies; and ``find``, which forgives small slips.

Only the standard library, and ``difflib`` only after a name was not found: everything else imports this module.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

FINGERS = ("thumb", "index", "middle", "ring", "little")
DIGITS = {finger: number for number, finger in enumerate(FINGERS, start=1)}

# Signs of every angle, lever arm and torque: kind of rotation -> (positive direction, negative direction).
SIGNS = {
    "flexion_extension": ("flexion", "extension"),
    "flexion_opposition": ("flexion (opposition)", "extension"),
    "deviation": ("radial", "ulnar"),
    "abduction_adduction": ("palmar abduction", "adduction"),
    "axial_rotation": ("pronation", "supination"),
}

# Rigid bodies, parents before children. The carpus carries the eight carpal bones and metacarpals 2 and 3.
BODIES = (
    "forearm",
    "carpus",
    "metacarpal_1",
    "proximal_phalanx_1",
    "distal_phalanx_1",
    "proximal_phalanx_2",
    "middle_phalanx_2",
    "distal_phalanx_2",
    "proximal_phalanx_3",
    "middle_phalanx_3",
    "distal_phalanx_3",
    "metacarpal_4",
    "proximal_phalanx_4",
    "middle_phalanx_4",
    "distal_phalanx_4",
    "metacarpal_5",
    "proximal_phalanx_5",
    "middle_phalanx_5",
    "distal_phalanx_5",
)


class BoneTerm(NamedTuple):
    """Names of one bone, and the rigid body that it belongs to."""

    name: str
    latin: str
    english: str
    body: str


_ROMAN = ("", "I", "II", "III", "IV", "V")
_ORDINAL = ("", "first", "second", "third", "fourth", "fifth")


def _metacarpal(digit: int) -> BoneTerm:
    name = f"metacarpal_{digit}"
    body = name if name in BODIES else "carpus"
    return BoneTerm(name, f"os metacarpale {_ROMAN[digit]}", f"{_ORDINAL[digit]} metacarpal", body)


def _phalanx(row: str, latin: str, digit: int) -> BoneTerm:
    finger = "the thumb" if digit == 1 else f"the {FINGERS[digit - 1]} finger"
    return BoneTerm(f"{row}_phalanx_{digit}", f"phalanx {latin} {_ROMAN[digit]}", f"{row} phalanx of {finger}", f"{row}_phalanx_{digit}")


# The 29 bones. Latin after the Terminologia Anatomica.
BONES: dict[str, BoneTerm] = {
    bone.name: bone
    for bone in (
        BoneTerm("radius", "radius", "radius", "forearm"),
        BoneTerm("ulna", "ulna", "ulna", "forearm"),
        BoneTerm("scaphoid", "os scaphoideum", "scaphoid", "carpus"),
        BoneTerm("lunate", "os lunatum", "lunate", "carpus"),
        BoneTerm("triquetrum", "os triquetrum", "triquetrum", "carpus"),
        BoneTerm("pisiform", "os pisiforme", "pisiform", "carpus"),
        BoneTerm("trapezium", "os trapezium", "trapezium", "carpus"),
        BoneTerm("trapezoid", "os trapezoideum", "trapezoid", "carpus"),
        BoneTerm("capitate", "os capitatum", "capitate", "carpus"),
        BoneTerm("hamate", "os hamatum", "hamate", "carpus"),
        *(_metacarpal(digit) for digit in range(1, 6)),
        *(_phalanx("proximal", "proximalis", digit) for digit in range(1, 6)),
        *(_phalanx("middle", "media", digit) for digit in range(2, 6)),
        *(_phalanx("distal", "distalis", digit) for digit in range(1, 6)),
    )
}


class UnknownName(KeyError):  # noqa: N818 (reads as what it is: the name is unknown)
    """A name that nothing carries. ``str()`` is the plain sentence (a bare ``KeyError`` would show it in quotes)."""

    def __str__(self) -> str:
        """The sentence, without quotes."""
        return str(self.args[0]) if self.args else ""


def _folded(name: str) -> str:
    """Upper or lower case, blanks and hyphens make no difference."""
    return "_".join(name.casefold().replace("-", " ").replace("_", " ").split())


def match(name: object, known: Collection[str], aliases: Mapping[str, str] | None = None) -> str | None:
    """The entry of ``known`` that ``name`` means, or None.

    The exact name comes first; then names and ``aliases`` (alias -> name) without regard to case, blanks and hyphens.
    """
    if not isinstance(name, str):
        return None
    if name in known:
        return name
    folded = _folded(name)
    for candidate in known:
        if _folded(candidate) == folded:
            return candidate
    for alias, target in (aliases or {}).items():
        if target in known and _folded(alias) == folded:
            return target
    return None


def nearest(name: str, known: Collection[str], aliases: Mapping[str, str] | None = None, *, count: int = 3) -> list[str]:
    """The ``count`` entries of ``known`` most like ``name`` (fewer only if ``known`` is smaller), best first.

    Entries that contain ``name`` come before merely similar ones; an alias that is like ``name`` counts for what it stands for.
    """
    from difflib import SequenceMatcher

    folded = _folded(name)
    spellings = [(entry, entry) for entry in known] + [(alias, entry) for alias, entry in (aliases or {}).items() if entry in known]
    likeness: dict[str, float] = {}
    for spelling, entry in spellings:
        ratio = SequenceMatcher(None, _folded(spelling), folded).ratio() + (len(folded) >= 3 and folded in _folded(spelling))
        likeness[entry] = max(ratio, likeness.get(entry, 0.0))
    return sorted(likeness, key=lambda entry: -likeness[entry])[:count]


def find(name: str, known: Collection[str], *, kind: str, aliases: Mapping[str, str] | None = None) -> str:
    """The name in ``known`` that ``name`` means: itself, or what its alias stands for (see ``match``).

    >>> find("FDP2", ["flexor_digitorum_profundus_index"], kind="muscle", aliases={"FDP2": "flexor_digitorum_profundus_index"})
    'flexor_digitorum_profundus_index'

    Raises ``UnknownName`` (a ``KeyError``) that names the three nearest entries.
    """
    found = match(name, known, aliases)
    if found is None:
        close = nearest(str(name), known, aliases)
        choice = " or ".join(part for part in (", ".join(close[:-1]), *close[-1:]) if part)
        raise UnknownName(f"unknown {kind} {name!r}" + (f"; did you mean {choice}?" if choice else "; there are none here"))
    return found
