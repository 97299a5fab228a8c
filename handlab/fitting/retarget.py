"""A motion of one hand told to another: contractions adapted so that what the fingertips do keeps its meaning (section 6).

The same contractions turn another hand's joints by other angles. Wanted is the same posture, except where thumb and finger meet: there
they shall meet on the new hand too. From the wanted postures follow contractions by static balance, as a change of the old ones;
then the motion is simulated and what it misses is aimed at further on.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import FINGERS
from handlab.simulation.balance import contraction_for
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import KeyFrames
from handlab.simulation.kinematics import relative_transforms
from handlab.simulation.mechanics import coupled, mechanics
from handlab.simulation.play import simulate

EVERY = 0.1  # seconds between two key frames of the new motion
MOST = 60  # key frames
# Thumb and finger are together below this distance (m) of their tips and apart well beyond it; how near they come again (m); how far a
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
    aim, contraction = wanted.copy(), old.copy()
    before = np.array([contraction_for(clip.hand, a, near=c, hold=hold).contraction for a, c in zip(clip.angle[frames], old, strict=True)])
    low, high = hand.limits.T
    best, least = old, np.inf
    for _ in range(ROUNDS + 1):
        made = simulate(
            hand, _keys(hand, time, contraction, clip.name), seconds=float(clip.time[-1]), fps=clip.fps, hold=hold, laws=clip.laws
        )
        missed = wanted - made.angle[frames]
        total = float(np.sum(missed[len(missed) // 3 :] ** 2))
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
    size = _reach(new) / _reach(old)
    digits = [i for i, name in enumerate(new.moving_names) if name.startswith(("cmc1", "mcp", "pip", "dip", "ip1"))]
    low, high = new.limits[m.moving].T
    result = np.array(angle)
    for t, now in enumerate(angle):
        tips = _tips(old, now)
        gap = tips[1:] - tips[0]
        weight = np.exp(-((np.linalg.norm(gap, axis=1) / TOGETHER) ** 2))
        if weight.max() < 0.05 or old is new:
            continue
        y = np.array(now[m.moving])

        def off(change: Array, y: Array = y, gap: Array = gap, weight: Array = weight) -> Array:
            moved = y.copy()
            moved[digits] += change
            tips = _tips(new, coupled(new, np.clip(moved, low, high)))
            return np.concatenate([(weight[:, None] * (tips[1:] - tips[0] - size * gap) / EXACT).reshape(-1), change / LEEWAY])

        y[digits] += least_squares(off, np.zeros(len(digits)), method="lm").x
        result[t] = coupled(new, np.clip(y, low, high))
    return result


def _tips(hand: Hand, angle: Array) -> Array:
    """Tips (5, 3) of thumb to little finger."""
    moved = relative_transforms(hand, angle)
    places = []
    for k, finger in enumerate(FINGERS, start=1):
        frame = moved[hand.body_names.index(f"distal_phalanx_{k}")]
        places.append(frame[:3, :3] @ hand.skin.points[hand.feature_points[f"tip_{finger}"]["palmar"]] + frame[:3, 3])
    return np.array(places)


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
