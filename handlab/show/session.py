"""The live hand behind a viewer, in a notebook or an app: messages in, frames out. No drawing, no threads, no clock.

A host owns the loop::

    session = Session(hand)
    send(session.scene())                  # bytes, once per client (layout: wire.py)
    session.message({"kind": "set", ...})  # as they arrive; never raises
    frame = session.tick(dt)               # bytes, or None while nothing moves; dt is real time in seconds
    for reply in session.replies(): ...    # dicts for the client; bytes, if any, stand under "data"
    for wish in session.wishes(): ...      # slow work (films): ``exports.fulfilled(wish)`` is a reply; call it on any thread
    session.refresh()                      # the next tick gives a frame though nothing moves (a client has joined)

Messages, client to host (``n``, a number that the next frame echoes, may stand in each):

==========  ==========================================================================================================
``set``     ``contraction: {name: 0..1}``: muscles by name or abbreviation; a clip that plays is left
``hold``    ``joints: [...]``: all joints (or degrees of freedom) that are held from now on
``play``    ``clip`` (optional: go on with the one that is loaded), ``speed``, ``loop`` (both optional)
``pause``   nothing else
``seek``    ``t``: seconds in the clip that is loaded
``speed``   ``speed``: 0.05 to 4, for clips and for the live hand
``live``    leave the clip; the hand stays where it is
``reset``   relaxed hand, no contraction, nothing held, no clip
``record``  ``on``: the motion from ``true`` to ``false`` becomes the clip ``my clip``
``save``    ``what: "pose" | "clip"``: answered by a ``file``
``load``    ``text`` (a pose or a clip that was saved, or a painted muscle), ``name`` of the file
``export``  ``format: "mp4" | "gif" | "glb" | "html" | "csv" | "png"``, ``look: {view, skin, bones, layers}``; becomes a wish
``wear``    ``skin: "blend" | "springs" | "springs and muscles"``, ``muscles: "both" | "pseudo" | "geometric"`` (both optional)
``layers``  from now on frames tell where the geometric muscles are; answered by ``layers``
==========  ==========================================================================================================

Replies, host to client: ``status`` (after every change: ``clip``, ``title``, ``seconds``, ``playing``, ``speed``, ``loop``,
``hold``, ``recording``, ``wear``, ``muscles``, ``soft``: whether springs can be worn yet), ``clips``
(``clips``: name, title, seconds), ``answer`` (``good``, ``text``: one sentence),
``file`` (``name``, ``mime``, and ``text`` or ``data``), ``track`` (``clip``, ``seconds``, ``data``: the curves of a clip that was
opened, see ``keepsakes.track``), ``layers`` (``data``: what stays of muscles and tendons, see ``flesh``).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from math import isfinite
from typing import Any

from handlab.anatomy.records import Hand
from handlab.anatomy.terms import find
from handlab.show import keepsakes, wire
from handlab.show.keeping import FORMATS as FORMATS
from handlab.show.keeping import MINE as MINE
from handlab.show.keeping import KeepingHand
from handlab.show.keeping import Wish as Wish
from handlab.show.moving_hand import AWAKE, speed_of
from handlab.show.outfits import BLEND
from handlab.simulation.clip import Clip
from handlab.simulation.keyframes import clips
from handlab.simulation.skeleton import contraction_of, number
from handlab.simulation.state import State

MOST_REPLIES = 32


class Session(KeepingHand):
    """One hand that any number of clients look at and move.

    ``start`` is a state or a recorded clip; ``hold`` joints that are held; ``wear``, ``muscles``: as in ``simulate``, once the host
    has called ``prepare``; a blended skin is left to the viewer (1.6 kB a frame), unless ``skin_points`` asks for its points too
    (10.6 kB, as a soft skin; 16 kB with muscles); ``exports``: the formats that this host writes.
    """

    def __init__(
        self,
        hand: Hand,
        start: State | Clip | None = None,
        *,
        contraction: Mapping[str, float] | Any = (),
        hold: Iterable[str] = (),
        wear: str = BLEND,
        muscles: str = "both",
        skin_points: bool = False,
        exports: Iterable[str] = FORMATS,
    ) -> None:
        self.exports = tuple(exports)
        self._replies: deque[dict[str, Any]] = deque(maxlen=MOST_REPLIES)
        self._wishes: deque[Wish] = deque(maxlen=4)
        super().__init__(hand, wear=wear, muscles=muscles, skin_points=skin_points)
        self.hold = keepsakes.held(hand, hold)
        if contraction is not None and len(contraction):
            self.contraction = contraction_of(hand, contraction)
            self._awake = AWAKE
        if isinstance(start, Clip):
            name = start.name or "clip"
            self.own[name] = start
            self._open(name)
        elif start is not None:
            self.state = start

    def scene(self) -> bytes:
        """What stays, for a new client; a ``refresh`` and a ``status`` go with it."""
        self.refresh()
        self._status()
        if self.clip is not None:
            self._tell_track()
        return wire.scene(self.hand, shown_clips=self.clips(), exports=self.exports)

    def replies(self) -> list[dict[str, Any]]:
        """What is to be told to the clients since the last call."""
        told = list(self._replies)
        self._replies.clear()
        return told

    def wishes(self) -> list[Wish]:
        """Files asked for since the last call."""
        asked = list(self._wishes)
        self._wishes.clear()
        return asked

    def replies_kept(self) -> list[dict[str, Any]]:
        """What ``replies`` will give, which stays there."""
        return list(self._replies)

    def message(self, message: Any) -> None:
        """Do what a client asks. Whatever is wrong with it is answered by one sentence."""
        try:
            if not isinstance(message, Mapping):
                raise TypeError(f"a message is a mapping with a kind, not a {type(message).__name__}")
            act = ACTS[find(str(message.get("kind")), ACTS, kind="message")]
            act(self, message)
            if "n" in message:
                self._echo = int(number(message["n"], "n"))
        except (ValueError, LookupError, TypeError, OSError, ArithmeticError, RecursionError) as error:
            self._answer(" ".join(str(error).split()) or type(error).__name__, good=False)

    def _answer(self, text: str, *, good: bool = True) -> None:
        reply = {"kind": "answer", "good": good, "text": text[:600]}
        if reply not in self._replies:
            self._replies.append(reply)

    def _status(self) -> None:
        status = {
            "kind": "status",
            "clip": self.clip_name,
            "seconds": self._seconds,
            "playing": self.playing,
            "speed": self.speed,
            "loop": self.loop,
            "hold": list(self.hold),
            "recording": self._recording is not None,
            "wear": self.wardrobe.wear,
            "muscles": self.wardrobe.muscles,
            "soft": self.wardrobe.network is not None,
        }
        for old in [reply for reply in self._replies if reply["kind"] == "status"]:
            self._replies.remove(old)  # the latest one wins
        self._replies.append(status)
        self._stale = True

    def _set(self, message: Mapping[str, Any]) -> None:
        wanted = message.get("contraction")
        if not isinstance(wanted, Mapping):
            raise TypeError("contraction is missing; give muscles with values, like {'FDP2': 0.4}")
        new = contraction_of(self.hand, wanted)
        rows = [self.hand.muscle_names.index(self.hand.muscles[name].name) for name in wanted]
        if self.clip is not None:
            self._leave()
        self.contraction = self.contraction.copy()
        self.contraction[rows] = new[rows]
        self._awake = AWAKE

    def _hold(self, message: Mapping[str, Any]) -> None:
        joints = message.get("joints")
        if not isinstance(joints, list | tuple):
            raise TypeError("joints is missing; give a list of names, like ['wrist']")
        self.hold = keepsakes.held(self.hand, joints)
        self._awake = AWAKE
        if self.clip is not None:
            self._again()
        self._status()

    def _play(self, message: Mapping[str, Any]) -> None:
        if "speed" in message:
            self.speed = speed_of(message["speed"])
        self.loop = bool(message.get("loop", self.loop))
        if message.get("clip"):
            self._open(str(message["clip"]))
        if self.clip is None:
            raise ValueError("no clip is loaded; choose one of " + ", ".join([*clips(), *self.own]))
        if self.clip_time >= self._seconds:
            self.clip_time = 0.0
        self.playing = self._seconds > 0.0
        self._status()

    def _tell_track(self) -> None:
        for old in [reply for reply in self._replies if reply["kind"] == "track"]:
            self._replies.remove(old)
        if self.clip is not None:
            self._replies.append({"kind": "track", "clip": self.clip_name, "seconds": self._seconds, "data": keepsakes.track(self.clip)})

    def _layers(self, message: Mapping[str, Any]) -> None:
        self.segments = True
        self._tell_layers()

    def _tell_layers(self) -> None:
        from handlab.show.flesh import packed_layers

        self._replies.append({"kind": "layers", "data": packed_layers(self.hand)})
        self._stale = True

    def _pause(self, message: Mapping[str, Any]) -> None:
        self.playing = False
        self._status()

    def _seek(self, message: Mapping[str, Any]) -> None:
        t = number(message.get("t"), "t")
        if not isfinite(t):
            raise ValueError(f"t is {t:g}; give a time in seconds")
        if self.clip is None:
            raise ValueError("no clip is loaded; play one first")
        self.clip_time = min(max(t, 0.0), self._seconds)
        self._stale = True

    def _speed(self, message: Mapping[str, Any]) -> None:
        self.speed = speed_of(message.get("speed"))
        self._status()

    def _live(self, message: Mapping[str, Any]) -> None:
        self._leave()
        self._status()

    def _reset(self, message: Mapping[str, Any]) -> None:
        self._start_over()
        self._status()


ACTS = {
    "set": Session._set,
    "hold": Session._hold,
    "play": Session._play,
    "pause": Session._pause,
    "seek": Session._seek,
    "speed": Session._speed,
    "live": Session._live,
    "reset": Session._reset,
    "record": Session._record,
    "save": Session._save,
    "load": Session._load,
    "export": Session._export,
    "wear": Session._wear,
    "layers": Session._layers,
}
