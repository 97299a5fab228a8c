"""What the named postures must be: windows of angles in degrees, and distances in millimetres. No contraction stands here.

A window is (low, high); a single number is a wish that gives way. ``meet``: pulps that touch; ``rest_on``: a pulp on the skin of
other bones. Everything that is not named stays near the relaxed posture.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

FINGERS = (2, 3, 4, 5)
STRAIGHT = {"mcp": (-8, 12), "pip": (0, 10), "dip": (0, 10)}
CLOSED = {"mcp": (75.8, 83), "pip": (91, 104), "dip": (46.4, 60)}


@dataclass(frozen=True)
class Posture:
    """One posture: angle windows by degree of freedom, wishes, and what touches what."""

    window: dict[str, tuple[float, float]] = field(default_factory=dict)
    wish: dict[str, float] = field(default_factory=dict)
    meet: tuple[int, ...] = ()  # the thumb's pulp meets the pulps of these fingers
    rest_on: dict[int, tuple[str, ...]] = field(default_factory=dict)  # pulp of a digit -> bodies whose skin it touches
    near_palm: tuple[int, ...] = ()  # pulps within 10 mm of the palm
    starts: tuple[dict[str, float], ...] = ({},)  # other places to start the search from; the best result counts


def fingers(shape: dict[str, Any], which: tuple[int, ...] = FINGERS) -> dict[str, Any]:
    """The same angles for several fingers."""
    return {f"{joint}{k}.flexion_extension": value for k in which for joint, value in shape.items()}


# fingers side by side, in line with their metacarpals
SIDE_BY_SIDE = {"mcp2.deviation": (-4, 4), "mcp3.deviation": (-3, 3), "mcp4.deviation": (-6, -1), "mcp5.deviation": (-9, -2)}


def thumb(flexion: Any, abduction: Any, mcp: Any, ip: Any) -> dict[str, Any]:
    """Angles of the thumb."""
    return {
        "cmc1.flexion_opposition": flexion,
        "cmc1.abduction_adduction": abduction,
        "mcp1.flexion_extension": mcp,
        "ip1.flexion_extension": ip,
    }


def wrist(flexion: Any, deviation: Any = (-6, 6)) -> dict[str, Any]:
    """Angles of the wrist."""
    return {"wrist.flexion_extension": flexion, "wrist.deviation": deviation}


ACROSS = {1: ("middle_phalanx_2", "middle_phalanx_3")}  # the thumb lies over the fist
THUMB_STARTS = ({}, thumb(26, 28, 48, 50), thumb(20, 40, 30, 30), thumb(10, 44, 20, 40), thumb(28, 44, 10, 20), thumb(25, 36, 45, 55))
THUMB_OUT = thumb((-16, -4), (12, 34), (-4, 14), (-6, 14))

POSTURES: dict[str, Posture] = {
    "open": Posture({**fingers(STRAIGHT), **SIDE_BY_SIDE, **THUMB_OUT, **wrist((-20, 2))}),
    "fist": Posture(
        {**fingers(CLOSED), **wrist((-30, -14))}, thumb(22, 32, 38, 45), rest_on=ACROSS, near_palm=FINGERS, starts=THUMB_STARTS
    ),
    "point": Posture(
        {**fingers(STRAIGHT, (2,)), **fingers(CLOSED, (3, 4, 5)), **wrist((-30, -10))},
        thumb(24, 30, 40, 45),
        rest_on={1: ("middle_phalanx_3",)},
        near_palm=(3, 4, 5),
        starts=THUMB_STARTS,
    ),
    "two": Posture(
        {**fingers(STRAIGHT, (2, 3)), "mcp2.deviation": (2, 10), "mcp3.deviation": (-8, 0), **fingers(CLOSED, (4, 5)), **wrist((-30, -10))},
        thumb(28, 32, 45, 45),
        near_palm=(4, 5),
    ),
    "three": Posture(
        {
            **fingers(STRAIGHT, (2, 3, 4)),
            **{k: v for k, v in SIDE_BY_SIDE.items() if k[3] != "5"},
            **fingers(CLOSED, (5,)),
            **wrist((-30, -8)),
        },
        thumb(30, 34, 48, 48),
    ),
    "four": Posture({**fingers(STRAIGHT), **SIDE_BY_SIDE, **wrist((-25, 0))}, thumb(32, 22, 50, 50)),
    "pinch": Posture(
        wrist((-30, -5)),
        {
            **thumb(16, 38, 12, 22),
            **fingers({"mcp": 58, "pip": 42, "dip": 15}, (2,)),
            **fingers({"mcp": 40, "pip": 50, "dip": 25}, (3, 4, 5)),
        },
        meet=(2,),
    ),
    "key-pinch": Posture(
        {**fingers({"mcp": (35, 65), "pip": (65, 100), "dip": (15, 50)}), **wrist((-30, -5))},
        thumb(10, 6, 18, 25),
        rest_on={1: ("middle_phalanx_2",)},
    ),
    "ok": Posture(
        {**fingers({"mcp": (-10, 20), "pip": (0, 22), "dip": (0, 20)}, (3, 4, 5)), **wrist((-30, 0))},
        {**thumb(18, 36, 15, 20), **fingers({"mcp": 55, "pip": 50, "dip": 18}, (2,))},
        meet=(2,),
    ),
    "thumbs-up": Posture({**fingers(CLOSED), **thumb((-20, -8), (0, 34), (-8, 12), (-12, 10)), **wrist((-20, 8))}, near_palm=FINGERS),
    "spread": Posture(
        {
            **fingers(STRAIGHT),
            **THUMB_OUT,
            **wrist((-20, 8)),
            "mcp2.deviation": (8, 15),
            "mcp4.deviation": (-15, -7),
            "mcp5.deviation": (-15, -9),
            "mcp3.deviation": (-5, 5),
        }
    ),
    "hook": Posture(
        {**fingers({"mcp": (0, 27), "pip": (80, 104), "dip": (25, 65)}), **SIDE_BY_SIDE, **wrist((-25, 10))}, thumb(0, 20, 10, 15)
    ),
    "l": Posture(
        {
            **fingers(STRAIGHT, (2,)),
            **fingers({"mcp": (70, 77), "pip": (88, 98), "dip": (40, 60)}, (3, 4, 5)),
            **thumb((-20, -15), (-6, 14), (-10, 0), (-15, -2)),
            **wrist((-25, 4)),
        },
        near_palm=(3, 4, 5),
    ),
    "wave-radial": Posture({**fingers(STRAIGHT), **SIDE_BY_SIDE, **THUMB_OUT, **wrist((-15, 5), (9, 18))}),
    "wave-ulnar": Posture({**fingers(STRAIGHT), **SIDE_BY_SIDE, **THUMB_OUT, **wrist((-15, 5), (-22, -13))}),
} | {
    f"opposition-{name}": Posture(
        wrist((-30, -3)),
        {
            **thumb(20, 40, 15, 15),
            **fingers({"mcp": 58, "pip": 40, "dip": 12}, (k,)),
            **fingers({"mcp": 22, "pip": 30, "dip": 14}, tuple(m for m in FINGERS if m != k)),
        },
        meet=(k,),
        starts=({}, thumb(28, 30, 15, 25) | fingers({"mcp": 65, "pip": 50, "dip": 20}, (k,))),
    )
    for k, name in ((2, "index"), (3, "middle"), (4, "ring"), (5, "little"))
}

# Clip -> title, its postures, the time in which each is reached, how long it stays (seconds), and to which share the muscles
# slacken between two postures (1: not at all)
SINGLE = (1.6, 0.8, 1.0)
CLIPS: dict[str, tuple[str, tuple[str, ...], float, float, float]] = {
    "open": ("The hand opens", ("open",), *SINGLE),
    "fist": ("The hand closes its fist", ("fist",), 1.0, 1.2, 1.0),
    "point": ("The index finger points", ("point",), 2.2, 0.6, 1.0),
    "pinch": ("Tip pinch of thumb and index finger", ("pinch",), *SINGLE),
    "key-pinch": ("Key pinch: the thumb against the side of the index finger", ("key-pinch",), *SINGLE),
    "ok": ("OK", ("ok",), *SINGLE),
    "thumbs-up": ("Thumbs up", ("thumbs-up",), 2.2, 0.6, 1.0),
    "spread": ("The fingers spread", ("spread",), *SINGLE),
    "hook": ("Hook grip", ("hook",), *SINGLE),
    "l": ("L: thumb and index finger", ("l",), 2.6, 0.7, 1.0),
    "count-to-five": ("Counting to five", ("point", "two", "three", "four", "open"), 2.0, 0.3, 0.15),
    "wave": ("Waving", ("wave-radial", "wave-ulnar", "wave-radial", "wave-ulnar", "wave-radial"), 0.5, 0.05, 1.0),
    "opposition": (
        "The thumb meets each finger",
        ("opposition-index", "opposition-middle", "opposition-ring", "opposition-little"),
        1.2,
        0.4,
        0.0,
    ),
} | {
    f"opposition-{name}": (f"The thumb meets the {name} finger", (f"opposition-{name}",), *SINGLE)
    for name in ("index", "middle", "ring", "little")
}
