"""Joints of a hand in a picture, found by MediaPipe's hand model, if it is installed; it works offline, the model is in the package.

MediaPipe (Apache-2.0) is no dependency of handlab: its last release with the model inside asks for an older numpy than it needs, so it is
installed by itself: ``pip install "handlab[points]"``, then ``pip install --no-deps mediapipe==0.10.21`` (Python up to 3.12).
"""

from __future__ import annotations

import importlib.util
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.records import Array
from handlab.anatomy.terms import FINGERS

HOW_TO = 'pip install "handlab[points]", then pip install --no-deps mediapipe==0.10.21'
LONGEST = 1200  # pixels: the model looks at 224 x 224 anyway
LEAST_SURE = 0.3
# The model's tips lie in the pulp of the finger: the finger ends this share of its last part beyond them (an assumption).
BEYOND = 0.35
# The model's points after the wrist (0): four for each finger, from its base to its tip; the thumb's first is its CMC joint.
JOINTS = {
    "thumb": ("", "mcp", "ip", "tip"),
    **dict.fromkeys(FINGERS[1:], ("mcp", "pip", "dip", "tip")),
}


def installed() -> bool:
    """Whether the package is there."""
    return importlib.util.find_spec("mediapipe") is not None


def joints(pixels: NDArray[np.uint8]) -> dict[str, Array]:
    """Places (2,) px of the joints and tips of the one hand in ``pixels`` (rows, columns, 3), by name, and "wrist", its middle.

    Raises ``ValueError`` where the package is missing or no hand is seen.
    """
    if not installed():
        raise ValueError(f"the joints of a hand are looked for by one more package: {HOW_TO}")
    os.environ.setdefault("GLOG_minloglevel", "2")  # it would write about itself
    from mediapipe.python.solutions.hands import Hands  # type: ignore[import-not-found, unused-ignore]

    step = max(1, round(max(pixels.shape[:2]) / LONGEST))
    small = np.ascontiguousarray(pixels[::step, ::step])
    with Hands(static_image_mode=True, max_num_hands=1, model_complexity=1, min_detection_confidence=LEAST_SURE) as hands:
        seen: Any = hands.process(small).multi_hand_landmarks
    if not seen:
        raise ValueError("no hand was found in this picture; click the points yourself")
    at = np.array([[point.x * small.shape[1], point.y * small.shape[0]] for point in seen[0].landmark]) * step
    found = {"wrist": at[0]}
    for k, (finger, names) in enumerate(JOINTS.items()):
        chain = at[1 + 4 * k : 5 + 4 * k]
        chain[3] += BEYOND * (chain[3] - chain[2])
        found |= {f"{name}_{finger}": place for name, place in zip(names, chain, strict=True) if name}
    return found
