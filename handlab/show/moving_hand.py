"""A hand in motion: live under its contractions, or in a clip. What a session shows, without anyone to show it to."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import find
from handlab.physics.muscle import muscle_force
from handlab.show import keepsakes, wire
from handlab.show.moments import Story, story
from handlab.show.outfits import BLEND, SOFT
from handlab.show.wardrobe import Wardrobe
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import KeyFrames, clips, keyframes
from handlab.simulation.play import simulate
from handlab.simulation.skeleton import contraction_of, number, rest, step
from handlab.simulation.state import State

LONGEST_TICK = 0.1  # seconds: a host that slept does not make the hand jump
STILL = 2e-3  # rad/s: slower than a tenth of a degree a second nobody sees
AWAKE = 0.3  # seconds after a change in which a hand counts as moving: it starts from rest
LONGEST_SETTLING = 1.0  # seconds after the bones in which the skin must have come to rest, or is left where it is
SLOWEST, FASTEST = 0.05, 4.0
MOST_HISTORY = 3600  # live frames kept for export: a minute at 60 a second


class MovingHand:
    """A hand, the clip that it plays if any, and what its user holds. ``own``: the user's clips by name.

    ``wear``, ``muscles``: as in ``simulate``. A soft skin shows as soon as ``prepare`` has run, and the blend until then.
    """

    def __init__(self, hand: Hand, *, wear: str = BLEND, muscles: str = "both", skin_points: bool = False) -> None:
        self.hand = hand
        self.wardrobe = Wardrobe(hand, wear, muscles)
        self.skin_points = skin_points
        self.segments = False
        self.own: dict[str, KeyFrames | Clip] = {}
        self._history: deque[tuple[float, Array, Array, Array, Any]] = deque(maxlen=MOST_HISTORY)
        self._echo = 0
        self._start_over()

    def _status(self) -> None:
        """Something changed that a client should know."""

    def _tell_track(self) -> None:
        """A clip was opened."""

    def _start_over(self) -> None:
        self.state = rest(self.hand)
        self.contraction = np.zeros(len(self.hand.muscle_names))
        self.hold: tuple[str, ...] = ()
        self.clip: Clip | None = None
        self.clip_name = ""
        self.clip_time = 0.0
        self.playing, self.loop, self.speed = False, False, 1.0
        self._recording: float | None = None
        self._settling = 0.0
        self._awake = 0.0
        self._stale = True
        self._history.clear()
        self.wardrobe.drop()

    def adopt(self, hand: Hand) -> None:
        """Go on with another hand of the same size, relaxed. Its soft skin must be prepared anew."""
        self.hand = hand
        self.wardrobe = Wardrobe(hand, self.wardrobe.wear, self.wardrobe.muscles)
        self._start_over()

    def refresh(self) -> None:
        """Let the next tick give a frame, though nothing moves."""
        self._stale = True

    def ready(self) -> None:
        """``prepare`` has run: show the soft skin."""
        self._status()
        self.refresh()

    def prepare(self) -> None:
        """Make the soft skin ready, and compile what will move the hand: some seconds, the very first time half a minute, on any thread.

        Call ``ready`` afterwards, where ``tick`` is called.
        """
        from handlab.show.flesh import packed_layers
        from handlab.simulation.tendon_ridges import ridge_points

        step(self.hand, rest(self.hand), {}, 1.0 / 60.0)
        ridge_points(self.hand)  # first, for every frame asks for them as soon as the wardrobe is ready
        self.wardrobe.prepare()
        packed_layers(self.hand)

    def put(self, state: State, contraction: Mapping[str, float] | Any = None) -> None:
        """Show a state. With ``contraction`` the hand moves on from it; without, it stays until a client asks for something."""
        self._leave()
        self.state, self._awake = state, 0.0
        self._history.clear()
        self.wardrobe.drop()
        self._stale = True
        if contraction is not None:
            self.contraction, self._awake = contraction_of(self.hand, contraction), AWAKE

    def present(self) -> State:
        """The hand as it stands."""
        if self.clip is None:
            return self.state
        _, angle, length, _, skin = keepsakes.between(self.clip, self.clip_time, skin=True)
        assert skin is not None
        return State(self.clip_time, angle, np.zeros_like(angle), length, skin)

    @property
    def moving(self) -> bool:
        """Whether the next tick will show something new."""
        return self._stale or self.playing or (self.clip is None and self._awake > 0.0)

    def tick(self, dt: float) -> bytes | None:
        """``dt`` seconds of real time pass: the new frame, or None if nothing changed."""
        if not self.moving:
            return None
        passed = min(max(float(dt), 0.0), LONGEST_TICK) * self.speed if isfinite(dt) else 0.0
        if self.playing:
            self._play_on(passed)
        elif self.clip is None and self._awake > 0.0 and passed > 0.0:
            self._live_on(passed)
        self._stale = False
        return self.frame()

    def frame(self) -> bytes:
        """The present moment as a frame."""
        contraction, angle, length, force, skin = self._now()
        flags = wire.MOVING * self.moving | wire.PLAYING * self.playing | wire.CLIP * (self.clip is not None)
        return wire.frame(
            self.hand,
            angle,
            time=self.state.time if self.clip is None else self.clip_time,
            contraction=contraction,
            fibre_length=length,
            force=force,
            flags=flags,
            echo=self._echo,
            seconds=0.0 if self.clip is None else self._seconds,
            skin=skin,
            segments=self._segments(angle, contraction) if self.segments else None,
            ridges=self._ridges(angle, contraction) if self._worn["wear"] == SOFT else None,
        )

    def _segments(self, angle: Array, contraction: Array) -> Any:
        from handlab.simulation.geometric_muscle import ellipsoids

        return ellipsoids(self.hand, angle, self.wardrobe.heard(contraction))

    def _ridges(self, angle: Array, contraction: Array) -> tuple[Any, Array]:
        from handlab.simulation.tendon_ridges import ridge_heights, ridge_points

        points = ridge_points(self.hand)
        return points, ridge_heights(self.hand, angle, self.wardrobe.heard(contraction))[points]

    @property
    def _seconds(self) -> float:
        return 0.0 if self.clip is None else float(self.clip.time[-1] - self.clip.time[0])

    def _now(self) -> tuple[Array, Array, Array, Array, Array | None]:
        """Contraction, angle, fibre length, force; points of the skin if they travel."""
        if self.clip is not None:
            self.clip = self.wardrobe.dressed(self.clip)
            return keepsakes.between(self.clip, self.clip_time, skin=self.skin_points or self.clip.worn is not None)
        state = self.state
        if self.wardrobe.soft:
            state = self.state = replace(state, skin=self.wardrobe.points(state.angle, self.contraction))
        force = muscle_force(self.contraction, state.fibre_length / self.hand.rest_length, self.hand.max_force)
        return self.contraction, state.angle, state.fibre_length, force, state.skin if self.skin_points or self.wardrobe.soft else None

    def _play_on(self, passed: float) -> None:
        self.clip_time += passed
        if self.clip_time >= self._seconds:
            if self.loop and self._seconds > 0.0:
                self.clip_time %= self._seconds
            else:
                self.clip_time, self.playing = self._seconds, False
                self._status()

    def _live_on(self, passed: float) -> None:
        wardrobe, held = self.wardrobe, self.hand.joints if self.wardrobe.muscles == "geometric" else self.hold
        if wardrobe.soft:
            wardrobe.points(self.state.angle, self.contraction)  # where the skin begins, if the hand has jumped
        self.state = step(self.hand, self.state, self.contraction, passed, hold=held)
        points = wardrobe.points(self.state.angle, self.contraction, passed) if wardrobe.soft else None
        if points is not None:
            self.state = replace(self.state, skin=points)
        kept = None if points is None else points.astype(np.float32)
        self._history.append((self.state.time, self.contraction.copy(), self.state.angle, self.state.speed, kept))
        bones_still = float(np.abs(self.state.speed).max()) <= STILL
        self._settling = self._settling + passed if bones_still else 0.0
        still = bones_still and (not wardrobe.moving or self._settling > LONGEST_SETTLING)
        self._awake = self._awake - passed if still else AWAKE
        if self._recording is not None:
            self._awake = AWAKE  # standing still belongs to a recording

    def _leave(self) -> None:
        """The live hand takes over where the clip is."""
        if self.clip is None:
            return
        contraction, angle, length, _, skin = keepsakes.between(self.clip, self.clip_time, skin=True)
        assert skin is not None
        row = min(int(np.searchsorted(self.clip.time - self.clip.time[0], self.clip_time)), len(self.clip.time) - 1)
        speed = self.clip.speed[row] if self.playing else np.zeros_like(angle)
        self.wardrobe.take_over(self.clip, row, skin, angle, contraction)
        self.state, self.contraction = State(self.state.time, angle, speed, length, skin), contraction.copy()
        self.clip, self.clip_name, self.playing = None, "", False
        self._history.clear()
        self._awake = AWAKE
        self._status()

    def _open(self, name: str) -> None:
        name = find(name, [*clips(), *self.own], kind="clip")
        source = self.own.get(name)
        if isinstance(source, Clip):
            used = self.wardrobe.muscles
            self.clip = keepsakes.again(source, self.hold, used) if self.hold or used != source.muscles else source
        else:
            keys = keyframes(name) if source is None else source
            self.clip = simulate(self.hand, keys, hold=self.hold, muscles=self.wardrobe.muscles)
        self.clip_name, self.clip_time, self.playing, self._recording = name, 0.0, False, None
        self._tell_track()
        self._stale = True

    def _shown(self, *, still: bool) -> Story:
        if still or (self.clip is None and len(self._history) < 2):
            contraction, angle, _, _, skin = self._now()
            time = self.state.time if self.clip is None else self.clip_time
            return story(keepsakes.single(self.hand, time, contraction, angle, skin, **self._worn))
        return story(self._shown_clip())

    def _shown_clip(self) -> Clip:
        if self.clip is not None:
            return self.clip
        if len(self._history) < 2:
            raise ValueError("there is no motion yet; play a clip or move a muscle first")
        return keepsakes.history_clip(self.hand, self._history, "live", **self._worn)

    @property
    def _worn(self) -> dict[str, str]:
        """How what is kept of the live hand is worn."""
        return {"wear": self.wardrobe.wear if self.wardrobe.soft else BLEND, "muscles": self.wardrobe.muscles}

    def _wear(self, message: Mapping[str, Any]) -> None:
        wardrobe = self.wardrobe
        muscles = wardrobe.muscles
        wardrobe.choose(str(message.get("skin", wardrobe.wear)), str(message.get("muscles", muscles)))
        self._awake = AWAKE
        self._stale = True
        if self.clip is not None and muscles != wardrobe.muscles:
            self._again()
        self._status()

    def _again(self) -> None:
        """Open the clip that is open once more, at the same moment."""
        time, playing = self.clip_time, self.playing
        self._open(self.clip_name)
        self.clip_time, self.playing = min(time, self._seconds), playing


def speed_of(value: Any) -> float:
    """A speed that a hand can be watched at."""
    speed = number(value, "speed")
    if not SLOWEST <= speed <= FASTEST:
        raise ValueError(f"speed is {speed:g}; it lies between {SLOWEST:g} and {FASTEST:g} (1 is real time)")
    return speed
