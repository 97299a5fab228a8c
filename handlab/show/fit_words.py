"""The fitting page's words: in which order points are asked for, what each is called, and what a mistake is called without code."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from handlab.anatomy.terms import FINGERS
from handlab.fitting.landmarks import LANDMARKS, SIXTEEN
from handlab.fitting.mistakes import FitError, FitQuestion

# Each point lies near the one before, so that the hand travels little; the first seven show side, size and turn already.
ORDER = (
    *(f"tip_{finger}" for finger in FINGERS),
    "wrist_ulnar",
    "wrist_radial",
    *(f"mcp_{finger}" for finger in FINGERS),
    "web_ring_little",
    "web_middle_ring",
    "web_index_middle",
    "web_thumb_index",
    "ip_thumb",
    *(f"pip_{finger}" for finger in FINGERS[1:]),
    *(f"dip_{finger}" for finger in reversed(FINGERS[1:])),
    "head_of_ulna",
)

_FINGER = {"thumb": "thumb", **{finger: f"{finger} finger" for finger in FINGERS[1:]}}
_KINDS = {
    "tip": ("Tip of the {}", "the very end of the finger"),
    "dip": ("Last joint of the {}", "the joint next to the nail"),
    "ip": ("Joint of the {}", "the middle of the thumb's bend"),
    "pip": ("Middle joint of the {}", "half-way along the finger"),
    "mcp": ("Knuckle of the {}", "where the finger turns in the hand"),
}
_OTHERS = {
    "web_thumb_index": ("Fold of skin, thumb to index finger", "the deepest place between the two"),
    "web_index_middle": ("Fold of skin, index to middle finger", "the deepest place between the two"),
    "web_middle_ring": ("Fold of skin, middle to ring finger", "the deepest place between the two"),
    "web_ring_little": ("Fold of skin, ring to little finger", "the deepest place between the two"),
    "wrist_ulnar": ("Edge of the wrist, little finger's side", "at the crease where the hand bends"),
    "wrist_radial": ("Edge of the wrist, thumb's side", "at the crease where the hand bends"),
    "head_of_ulna": ("Bump of the wrist, little finger's side", "the end of the ulna, just before the wrist"),
}
_IN_PALM = {"mcp": "in the palm: below the finger, at the palm's upper crease"}
_ANSWERS = {
    ("sure", True): "Yes, it is right",
    ("view", "palmar"): "It is the palm",
    ("view", "dorsal"): "It is the back",
    ("side", "right"): "of the right hand",
    ("side", "left"): "of the left hand",
    ("mirror", True): "The picture is mirrored",
}
# What code would write, and what a reader of the page needs instead.
_PLAIN = (
    (r"[;,] or say sure=True( if it is right)?", ""),
    (r"; swap them\b", ""),
    (r", or mirror=True if the picture itself is mirrored", ""),
    (r"; give side='\w+' or view='\w+'", "; which is wrong?"),
    (r"; say view='palmar' or view='dorsal' \(or side='right' or side='left'\)", "; which is it?"),
    (r"say both view='palmar' or 'dorsal' and side='right' or 'left', or add", "say which it is, or add"),
    (r"click them? again or leave it out", "click it again"),
)
_NAME = re.compile(r"\b(" + "|".join(sorted(LANDMARKS, key=len, reverse=True)) + r")\b")
_CODE = re.compile(r"[;,]? ?(or )?\b(say|give) \w+='?\w+'?( or \w+='?\w+'?)*")


def points() -> list[dict[str, Any]]:
    """Every point in the order in which it is asked for: name, what it is called, how to find it, whether it belongs to the sixteen."""
    found = []
    for name in ORDER:
        kind, _, finger = name.partition("_")
        if name in _OTHERS:
            text, hint = _OTHERS[name]
        else:
            text, hint = _KINDS[kind][0].format(_FINGER[finger]), _KINDS[kind][1]
        found.append({"name": name, "text": text, "hint": hint, "palm": _IN_PALM.get(kind, hint), "main": name in SIXTEEN})
    return found


CALLED: Mapping[str, str] = {row["name"]: row["text"] for row in points()}


def plain(text: str) -> str:
    """A message without names that only code has."""
    for pattern, instead in _PLAIN:
        text = re.sub(pattern, instead, text)
    text = _CODE.sub("", text)
    text = _NAME.sub(lambda found: f"“{CALLED[found.group(1)]}”", text)
    return text if "." in text.split(" ")[0] else text[:1].upper() + text[1:]  # the name of a file stays as it is


def trouble(error: Exception) -> dict[str, Any]:
    """A refusal or a question as the page shows it: ``text``, ``names`` of points to look at, ``choices``: label and answer.

    An answer sets ``view``, ``side``, ``sure`` or ``mirror``, takes points back (``redo``) or exchanges labels (``swap``).
    """
    names = tuple(error.names) if isinstance(error, FitError) else ()
    text = str(error)
    return {
        "text": plain(text),
        "names": [name for name in names if name in LANDMARKS],
        "question": isinstance(error, FitQuestion),
        "choices": [{"label": label, "answer": answer} for label, answer in _choices(error, names, text)],
    }


def _choices(error: Exception, names: tuple[str, ...], text: str) -> list[tuple[str, dict[str, Any]]]:
    if isinstance(error, FitQuestion):
        return [(" ".join(_ANSWERS[item] for item in choice.items()), dict(choice)) for choice in error.choices]
    found: list[tuple[str, dict[str, Any]]] = []
    if "exchanged" in text and len(names) == 2:
        found.append(("Exchange them", {"swap": list(names)}))
        found += [(f"Click “{CALLED[name]}” again", {"redo": [name]}) for name in names if name in CALLED]
    elif "mirror=True" in text:
        found += [("I took palm and back for each other", {"view": None, "side": None}), (_ANSWERS["mirror", True], {"mirror": True})]
    else:
        found += [(f"Click “{CALLED[name]}” again", {"redo": [name]}) for name in names if name in CALLED]
    return found + ([("They are right", {"sure": True})] if "sure=True" in text else [])
