"""What the checks of lesson 06 let a fresh hand do: grips with the wrist held or free, silent muscles, postures at rest."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from handlab.anatomy.records import Array
from handlab.check.answers import reference
from handlab.physics.muscle import active_force_length, muscle_force
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import KeyFrames, keyframes
from handlab.simulation.play import simulate
from handlab.simulation.settle import settle
from handlab.simulation.skeleton import contraction_of, pose
from handlab.simulation.state import State
from handlab.studies import measures

MIDDLE = ("FDP3", "FDS3", "EDC3", "LUM2", "DI2", "DI3")  # muscles that reach the middle finger
FLEXORS = tuple(f"{muscle}{digit}" for muscle in ("FDP", "FDS") for digit in (2, 3, 4, 5))
GRIP = dict.fromkeys(FLEXORS, 0.5)
GRIP_SECONDS = 3.0
CLOSED_AT, OPEN_AGAIN = 2.0, 4.0  # s
CLOSING = {name: [(0.0, 0.0), (1.5, 0.3), (CLOSED_AT, 0.3), (3.5, 0.0)] for name in FLEXORS}
WRIST = (0, 1)  # columns of the wrist: its two rotations come first in every hand
EXTENSORS = ("ECRB", "ECU")
PULP = ("middle_phalanx_2", "middle_phalanx_3")  # where the thumb of a fist lies


def row(muscle: str) -> int:
    """Of a muscle by name or abbreviation."""
    hand = reference()
    return hand.muscle_names.index(hand.muscles[muscle].name)


def column(dof: str) -> int:
    """Of a degree of freedom."""
    return reference().dof_names.index(dof)


def motion(source: KeyFrames | Mapping[str, Any], seconds: float, *, hold: tuple[str, ...] = ()) -> Clip:
    """The motion that key frames or constant contractions give on a fresh hand."""
    return simulate(reference(), source, seconds=seconds, hold=hold)


@cache
def held_clip(name: str) -> Clip:
    """A named clip with the wrist held."""
    return simulate(reference(), name, hold=("wrist",))


def gap_without(name: str, silent: str) -> float:
    """Gap in metres between the pulps of thumb and little finger at the end of a clip, wrist held, with one muscle at 0."""
    hand, keys = reference(), keyframes(name)
    tracks: dict[str, Any] = {"time": keys.time}
    for muscle in keys.keyed:
        tracks[muscle] = keys.contraction[:, keys.muscle_names.index(muscle)] * (0.0 if muscle == silent else 1.0)
    clip = simulate(hand, tracks, hold=("wrist",))
    return measures.pulp_gap(hand, clip.skin(-1), 1, 5)


def settled(wrist_deg: float | None, contraction: Mapping[str, float]) -> State:
    """The hand at rest with the wrist held at a flexion (``None``: as in the relaxed hand)."""
    hand = reference()
    start = None if wrist_deg is None else pose(hand, {"wrist.flexion_extension": np.deg2rad(wrist_deg)})
    return settle(hand, contraction, start, hold=("wrist",), look_for_others=False).state


def shift(rotation: str) -> Array:
    """How far (3,) the pulp of the thumb goes when a rotation of the relaxed hand grows by 10 degrees, metres."""
    hand = reference()
    start = pose(hand, {})
    pulp = measures.pulps(hand)[1]
    moved = pose(hand, {rotation: start.angle[column(rotation)] + np.deg2rad(10.0)})
    by: Array = (moved.skin[pulp] - start.skin[pulp]).mean(axis=0)
    return by


def finger_sums(state: State) -> Array:
    """MCP, PIP and DIP flexion (4,) of index to little finger, added up, degrees."""
    columns = [[column(f"{joint}{digit}.flexion_extension") for joint in ("mcp", "pip", "dip")] for digit in (2, 3, 4, 5)]
    return np.asarray(np.rad2deg(state.angle[columns]).sum(axis=1), dtype=np.float64)


def pulls(state: State, contraction: Mapping[str, float]) -> Array:
    """Forces (muscle,) in newtons at a state."""
    hand = reference()
    return muscle_force(contraction_of(hand, contraction), state.fibre_length / hand.rest_length, hand.max_force)


def balancing(clip: Clip, frame: int) -> Array:
    """Contractions of ECRB and ECU that take up the torque of a clip at the wrist in a frame."""
    hand = reference()
    rows = [row(muscle) for muscle in EXTENSORS]
    full = hand.max_force[rows] * active_force_length(clip.fibre_length[frame, rows] / hand.rest_length[rows])
    matrix = hand.lever_arm[np.ix_(rows, WRIST)].T * full
    return np.asarray(np.linalg.solve(matrix, -clip.torque[frame, list(WRIST)]), dtype=np.float64)


def deflection(clip: Clip) -> Array:
    """How far (T, 2) the wrist is from where it began, flexion and deviation in degrees."""
    off: Array = np.rad2deg(clip.angle[:, list(WRIST)] - clip.angle[0, list(WRIST)])
    return off
