"""A hand, a state or a recorded clip as moments to draw: posed skin, angles, and what every muscle does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.show.outfits import SOFT


@dataclass(frozen=True, eq=False)
class Moment:
    """``time`` s, ``skin`` (N, 3) m, ``angle`` (dof,) rad; ``contraction`` and ``force`` (muscle,) where muscles are known.

    ``raised`` (Nf,) m: how far tendons lift the fine skin, if they do.
    """

    time: float
    skin: Array
    angle: Array
    contraction: Array | None = None
    force: Array | None = None
    raised: Array | None = None


@dataclass(frozen=True, eq=False)
class Story:
    """Moments of one hand in order; ``clip`` is the recording they come from, or None for a single state."""

    hand: Hand
    clip: Any = None
    state: Any = None

    @property
    def seconds(self) -> float:
        """Length in seconds; 0 for a single state."""
        return 0.0 if self.clip is None else float(self.clip.time[-1] - self.clip.time[0])

    def at(self, time: float) -> Moment:
        """The moment ``time`` seconds after the beginning. Between recorded states it lies on the straight line."""
        if self.clip is None:
            return Moment(float(self.state.time), self.state.skin, self.state.angle)
        clip = self.clip
        wanted = float(np.clip(clip.time[0] + time, clip.time[0], clip.time[-1]))
        right = int(np.clip(np.searchsorted(clip.time, wanted), 1, len(clip.time) - 1)) if len(clip.time) > 1 else 0
        left = max(right - 1, 0)
        span = clip.time[right] - clip.time[left]
        share = 0.0 if span == 0 else (wanted - clip.time[left]) / span

        def between(a: Any, b: Any) -> Array:
            mixed: Array = (1.0 - share) * np.asarray(a) + share * np.asarray(b)
            return mixed

        skin = clip.skin(right) if share == 1.0 else clip.skin(left) if share == 0.0 else between(clip.skin(left), clip.skin(right))
        angle, contraction, force = (between(rows[left], rows[right]) for rows in (clip.angle, clip.contraction, clip.force))
        return Moment(wanted, skin, angle, contraction, force, raised_of(clip, angle, contraction))

    def sample(self, count: int) -> list[Moment]:
        """``count`` moments, evenly spaced from the first to the last; one for a single state."""
        return [self.at(time) for time in (np.linspace(0.0, self.seconds, count) if self.clip is not None else [0.0])]


def raised_of(clip: Any, angle: Array, contraction: Array) -> Array | None:
    """How far tendons lift the fine skin (Nf,), m, in a clip whose skin is worn on springs and muscles."""
    if clip.wear != SOFT:
        return None
    from handlab.simulation.tendon_ridges import ridge_heights
    from handlab.simulation.worn import swelling_contraction

    return ridge_heights(clip.hand, angle, swelling_contraction(contraction, clip.muscles))


def story(what: Any, hand: Hand | None = None) -> Story:
    """The story of a clip, of a hand (relaxed), or of a state with its ``hand``.

    Raises ``TypeError`` for anything else, and for a state without a hand.
    """
    from handlab.simulation.state import State

    if isinstance(what, Hand):
        from handlab.simulation.skeleton import rest

        return Story(what, state=rest(what))
    if isinstance(what, State):
        if hand is None:
            raise TypeError("a state does not know its hand; say whose it is: save(state, path, hand=hand)")
        return Story(hand, state=what)
    if isinstance(getattr(what, "hand", None), Hand) and hasattr(what, "contraction"):
        return Story(what.hand, clip=what)
    raise TypeError(f"cannot draw a {type(what).__name__}; give a clip, a hand, or a state with hand=")
