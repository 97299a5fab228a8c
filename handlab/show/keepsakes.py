"""Poses and clips that a user keeps: recorded, written as JSON text, and read back. Nothing in such a text is ever executed."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from handlab.anatomy.grids import MuscleGrid, grid_of
from handlab.anatomy.records import Array, Hand, frozen
from handlab.physics.muscle import muscle_force
from handlab.show.outfits import BLEND, SOFT
from handlab.show.wardrobe import between_skins
from handlab.simulation.clip import Clip
from handlab.simulation.keyframe_files import refused
from handlab.simulation.keyframes import KeyFrames
from handlab.simulation.mechanics import fibre_lengths
from handlab.simulation.play import simulate
from handlab.simulation.skeleton import contraction_of, held_coordinates, pose
from handlab.simulation.skin import blend
from handlab.simulation.state import State

MOST_TEXT = 5_000_000  # characters of a file that is loaded; a minute of all muscles needs less than one
KEYS_PER_SECOND = 20
MOST_TRACK_ROWS = 240
LONGEST_CLIP = 600.0  # seconds: what is loaded must not stop the hand for long

Moments = Iterable[tuple[float, Array, Array, Array, Any]]


@dataclass(frozen=True, eq=False)
class Pose:
    """A pose that was kept."""

    state: State
    contraction: Array
    hold: tuple[str, ...]


def held(hand: Hand, names: Iterable[str]) -> tuple[str, ...]:
    """The names, once each, if a hand has them all."""
    listed = tuple(dict.fromkeys([names] if isinstance(names, str) else [str(name) for name in names]))
    held_coordinates(hand, listed)
    return listed


def between(clip: Clip, time: float, *, skin: bool = False) -> tuple[Array, Array, Array, Array, Array | None]:
    """Contraction, angle, fibre length, force, and skin if asked for, ``time`` seconds after the clip's beginning."""
    wanted = float(clip.time[0]) + time
    right = int(np.clip(np.searchsorted(clip.time, wanted), 1, max(len(clip.time) - 1, 1)))
    right = min(right, len(clip.time) - 1)
    left = max(right - 1, 0)
    span = float(clip.time[right] - clip.time[left])
    share = 0.0 if span <= 0.0 else float(np.clip((wanted - clip.time[left]) / span, 0.0, 1.0))
    mixed: list[Array] = [
        (1.0 - share) * values[left] + share * values[right] for values in (clip.contraction, clip.angle, clip.fibre_length, clip.force)
    ]
    if clip.worn is not None and skin:
        return mixed[0], mixed[1], mixed[2], mixed[3], between_skins(clip, left, right, share)
    return mixed[0], mixed[1], mixed[2], mixed[3], blend(clip.hand, mixed[1]) if skin else None


def track(clip: Clip, most: int = MOST_TRACK_ROWS) -> bytes:
    """The curves of a clip: float32 rows of time, fibre lengths (muscle,) and angles (dof,), at most ``most`` of them."""
    rows = np.unique(np.linspace(0, len(clip.time) - 1, min(len(clip.time), most)).round().astype(int))
    table = np.column_stack([clip.time[rows] - clip.time[0], clip.fibre_length[rows], clip.angle[rows]])
    return table.astype("<f4").tobytes()


def keys_of(time: Array, contraction: Array, hand: Hand, name: str) -> KeyFrames:
    """Key frames through recorded contractions (T, muscle) at ``time`` (T,) from 0."""
    all_keys = np.ones(contraction.shape, dtype=bool)
    return KeyFrames(frozen(time), frozen(np.clip(contraction, 0.0, 1.0)), frozen(all_keys, bool), hand.muscle_names, name, name)


def again(clip: Clip, hold: Iterable[str], muscles: str = "both") -> Clip:
    """The motion that the contractions of a clip give while joints are held, or with other ``muscles``."""
    if len(clip.time) < 2:
        return clip
    keys = keys_of(clip.time - clip.time[0], clip.contraction, clip.hand, clip.name)
    return simulate(clip.hand, keys, hold=hold, start=clip.states[0], muscles=muscles)


def single(hand: Hand, time: float, contraction: Array, angle: Array, skin: Array | None = None, **how: str) -> Clip:
    """A clip of one frame; ``skin`` (N, 3): its soft skin."""
    return history_clip(hand, [(time, contraction, angle, np.zeros_like(angle), skin)], "", **how)


def history_clip(hand: Hand, moments: Moments, name: str, *, wear: str = SOFT, muscles: str = "both") -> Clip:
    """A clip of live moments: (time, contraction, angle, speed, points of the soft skin or None).

    The clip has a soft skin, worn as ``wear`` says, if all moments have it.
    """
    *columns, skins = list(zip(*moments, strict=True))
    time, contraction, angle, speed = (np.array(column, dtype=np.float64) for column in columns)
    length = fibre_lengths(hand, angle)
    force = muscle_force(contraction, length / hand.rest_length, hand.max_force)
    gaps = np.diff(time)
    return Clip(
        hand=hand,
        time=frozen(time - time[0]),
        contraction=frozen(contraction),
        angle=frozen(angle),
        speed=frozen(speed),
        fibre_length=frozen(length),
        force=frozen(force),
        torque=frozen(force @ hand.lever_arm),
        fps=float(1.0 / np.median(gaps)) if len(gaps) else 60.0,
        name=name,
        worn=None if wear == BLEND or any(skin is None for skin in skins) else kept_skin(wear, np.array(skins, dtype=np.float32)),
        muscles=muscles,
    )


def kept_skin(wear: str, points: Any) -> Any:
    """A soft skin that was recorded: ``points`` (T, N, 3)."""
    from handlab.simulation.worn import Worn, skin_worn

    return Worn(skin_worn(wear), points)


def recorded(hand: Hand, moments: Moments, name: str, **how: str) -> Clip:
    """What the user did, as a clip. Raises ``ValueError`` if that was nothing."""
    listed = list(moments)
    if len(listed) < 2:
        raise ValueError("nothing moved while recording; press record, move a muscle, press it again")
    return history_clip(hand, listed, name, **how)


def pose_text(hand: Hand, contraction: Array, angle: Array, hold: Sequence[str]) -> str:
    """A pose as JSON."""
    moving = {name: round(float(np.rad2deg(angle[hand.dof_names.index(name)])), 4) for name in hand.moving_names}
    active = {name: round(float(value), 5) for name, value in zip(hand.muscle_names, contraction, strict=True) if value > 0.0}
    return json.dumps({"handlab": "pose", "angle_deg": moving, "contraction": active, "hold": list(hold)}, indent=1)


def clip_file(clip: Clip) -> tuple[str, str]:
    """File name and JSON text of a clip: the key frames that ``hl.keyframes(path)`` reads."""
    seconds = float(clip.time[-1] - clip.time[0])
    count = max(int(np.ceil(seconds * KEYS_PER_SECOND)), 1) + 1
    time = np.linspace(0.0, seconds, count)
    used = np.flatnonzero(clip.contraction.max(axis=0) > 0.0)
    tracks = {
        clip.hand.muscle_names[k]: [round(float(v), 5) for v in np.interp(time, clip.time - clip.time[0], clip.contraction[:, k])]
        for k in (used if len(used) else [0])
    }
    name = clip.name or "clip"
    text = json.dumps({"handlab": "clip", "name": name, "title": name, "time": [round(float(t), 6) for t in time], "contraction": tracks})
    return "".join(c if c.isalnum() or c in "-_" else "-" for c in name) + ".json", text


def read(hand: Hand, text: Any, file: str) -> Pose | KeyFrames | MuscleGrid:
    """What ``pose_text`` or ``clip_file`` wrote, or a painted muscle. Raises ``ValueError`` with one sentence for anything else."""
    if not isinstance(text, str):
        raise ValueError(f"{file}: no text arrived; choose a .json file that was saved here")
    if len(text) > MOST_TEXT:
        raise ValueError(f"{file} has {len(text):,} characters; what is saved here has fewer than {MOST_TEXT:,}")
    try:
        content = json.loads(text, parse_constant=refused)
    except json.JSONDecodeError as error:
        raise ValueError(f"{file}, line {error.lineno}: not readable as JSON ({error.msg})") from None
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{file} is not a pose or clip ({error})") from None
    try:
        if isinstance(content, dict) and isinstance(content.get("angle_deg"), dict):
            return read_pose(hand, content)
        if isinstance(content, dict) and isinstance(content.get("contraction"), dict) and isinstance(content.get("time"), list):
            return read_clip(hand, content, file)
        if isinstance(content, dict) and "triangle" in content and "drives" in content:
            return grid_of(content, file)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{file}: {error}") from None
    raise ValueError(f'{file} holds neither a pose ("angle_deg") nor a clip ("time" and "contraction") nor a painted muscle ("triangle")')


def read_pose(hand: Hand, content: dict[str, Any]) -> Pose:
    """A pose of a hand."""
    angles = {name: float(np.deg2rad(float(value))) for name, value in content["angle_deg"].items()}
    # A pose between soft stops may lie a hair outside the limits; the nearest angle inside is meant.
    inside = {name: within(hand, name, angle) for name, angle in angles.items()}
    contraction = content.get("contraction", {})
    if not isinstance(contraction, dict):
        raise ValueError("contraction is not a mapping of muscles to values")
    return Pose(pose(hand, inside), contraction_of(hand, contraction), held(hand, content.get("hold", ())))


def within(hand: Hand, name: str, angle: float) -> float:
    """The angle, moved to what its capsule gives if it is less than two degrees further out."""
    from handlab.simulation.mechanics import mechanics

    if name not in hand.moving_names:
        return angle
    m = mechanics(hand)
    low, high = m.limits[hand.moving_names.index(name)]
    nearest = float(np.clip(angle, low - m.hard_stop, high + m.hard_stop))
    return nearest if abs(nearest - angle) < np.deg2rad(2.0) else angle


def read_clip(hand: Hand, content: dict[str, Any], file: str) -> KeyFrames:
    """Key frames of a clip."""
    if "time" in content["contraction"]:
        raise ValueError('"time" stands beside "contraction", not in it')
    name = str(content.get("name") or file.rpartition(".")[0] or "clip")[:80]
    tracks = {"time": content["time"], **content["contraction"]}
    keys = KeyFrames.from_mapping(tracks, name=name, title=str(content.get("title", name))[:200])
    if keys.time[-1] > LONGEST_CLIP:
        raise ValueError(f"the clip lasts {keys.time[-1]:g} s; the longest that is played is {LONGEST_CLIP:g} s")
    if keys.time[-1] <= 0.0:
        raise ValueError("the clip ends at 0 s; it needs a key after that")
    return keys.for_hand(hand)
