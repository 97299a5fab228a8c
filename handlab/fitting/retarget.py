"""A motion of one hand told to another: contractions adapted so that what the fingertips do keeps its meaning (section 6).

The same contractions turn another hand's joints by other angles. Wanted is the same posture, except where thumb and finger meet: there
they shall meet on the new hand too. From the wanted postures follow contractions by static balance, as a change of the old ones;
then the motion is simulated and what it misses is aimed at further on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.simulation.balance import contraction_for
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import KeyFrames
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.play import simulate
from handlab.simulation.pulps import pulp_centres

EVERY = 0.1  # seconds between two key frames of the new motion
MOST = 60  # key frames
# Thumb and finger are together below this distance (m) of their pulps and apart well beyond it; how near they come again (m); how far a
# joint may leave the old posture for it (rad). Assumptions.
TOGETHER, EXACT, LEEWAY = 0.030, 0.001, np.deg2rad(15.0)
ROUNDS = 3
AIM = 0.8  # of what was missed


def retarget(clip: Clip, hand: Hand, *, hold: Iterable[str] = ()) -> KeyFrames:
    """Key frames for ``hand`` that do what ``clip`` does: ``hl.simulate(hand, hl.retarget(clip, hand), hold=...)``.

    ``hold``: joints that were held in ``clip`` and are again. Told to the very hand of the clip, they are those
    of the clip. Raises ``ValueError`` for a hand with other muscles or joints.
    """
    if hand.muscle_names != clip.hand.muscle_names or hand.dof_names != clip.hand.dof_names:
        raise ValueError("the two hands have different muscles or joints; retarget between hands made from the reference hand")
    hold = (hold,) if isinstance(hold, str) else tuple(hold)
    frames = _frames(clip)
    time, old = clip.time[frames], clip.contraction[frames]
    wanted = wanted_angles(clip.hand, hand, clip.angle[frames])
    meetings = [_meeting(clip.hand, hand, a) for a in clip.angle[frames]]
    aim, contraction = wanted.copy(), old.copy()
    before = np.array([contraction_for(clip.hand, a, near=c, hold=hold).contraction for a, c in zip(clip.angle[frames], old, strict=True)])
    low, high = hand.limits.T
    best, least = old, np.inf
    for _ in range(ROUNDS + 1):
        made = simulate(
            hand, _keys(hand, time, contraction, clip.name), seconds=float(clip.time[-1]), fps=clip.fps, hold=hold, laws=clip.laws
        )
        missed = wanted - made.angle[frames]
        apart = np.array([_apart(hand, a, meeting) for a, meeting in zip(made.angle[frames], meetings, strict=True)])
        late = slice(len(frames) // 3, None)
        total = float(np.sum((missed[late] / LEEWAY) ** 2) + np.sum(apart[late] ** 2))
        if total < least:
            best, least = contraction, total
        aim = np.clip(aim + AIM * missed if contraction is not old else aim, low, high)
        after = np.array([contraction_for(hand, a, near=c, hold=hold).contraction for a, c in zip(aim, old, strict=True)])
        contraction = np.clip(old + after - before, 0.0, 1.0)
    return _keys(hand, time, best, clip.name)


def wanted_angles(old: Hand, new: Hand, angle: Array) -> Array:
    """Angles (T, dof) on ``new`` that mean what ``angle`` (T, dof) means on ``old``: equal, but thumb and finger meet where they met."""
    from scipy.optimize import least_squares

    m = mechanics(new)
    digits = [i for i, name in enumerate(new.moving_names) if name.startswith(("cmc1", "mcp", "pip", "dip", "ip1"))]
    low, high = new.limits[m.moving].T
    result = np.array(angle)
    for t, now in enumerate(angle):
        meeting = _meeting(old, new, now)
        if old is new or meeting.weight.max() < 0.05:
            continue
        y = np.array(now[m.moving])

        def moved(change: Array, y: Array = y) -> Array:
            free = y.copy()
            free[digits] += change
            whole: Array = coupled(new, np.clip(free, low, high))
            return whole

        def off(change: Array, moved: Callable[[Array], Array] = moved, meeting: Meeting = meeting) -> Array:
            return np.concatenate([_apart(new, moved(change), meeting), change / LEEWAY])

        result[t] = moved(least_squares(off, np.zeros(len(digits)), method="lm").x)
    return result


class Meeting(NamedTuple):
    """``gap`` (4, 3) m from the thumb's pulp to those of the fingers, ``weight`` (4,) how much each counts as meeting it."""

    gap: Array
    weight: Array


def _meeting(old: Hand, new: Hand, angle: Array) -> Meeting:
    """What ``angle`` (dof,) on ``old`` means on ``new``: gaps as much larger as the hand is."""
    gap = _gaps(old, angle)
    return Meeting(gap * _reach(new) / _reach(old), np.exp(-((np.linalg.norm(gap, axis=1) / TOGETHER) ** 2)))


def _apart(hand: Hand, angle: Array, meeting: Meeting) -> Array:
    """How far (12,) thumb and fingers in a posture are from a meeting, over ``EXACT``."""
    result: Array = (meeting.weight[:, None] * (_gaps(hand, angle) - meeting.gap) / EXACT).reshape(-1)
    return result


def _gaps(hand: Hand, angle: Array) -> Array:
    middle = pulp_centres(hand, angle)
    result: Array = middle[1:] - middle[0]
    return result


def _reach(hand: Hand) -> float:
    return float(np.linalg.norm(hand.skin.points[hand.feature_points["tip_middle"]["palmar"]] - hand.joints["wrist"].centre))


def _frames(clip: Clip) -> Array:
    count = int(np.clip(round(float(clip.time[-1]) / EVERY) + 1, 2, MOST))
    chosen: Array = np.unique(np.linspace(0, len(clip.time) - 1, count).round().astype(np.int64))
    return chosen


def _keys(hand: Hand, time: Array, contraction: Array, name: str) -> KeyFrames:
    used = np.flatnonzero(contraction.max(axis=0) > 1e-6)
    used = used if len(used) else np.array([0])
    tracks = {"time": time.tolist()} | {hand.muscle_names[i]: contraction[:, i].tolist() for i in used}
    return KeyFrames.from_mapping(tracks, name=name)
