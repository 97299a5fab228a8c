"""What a user keeps of a moving hand: recordings, files with poses and clips, exports."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from handlab.anatomy.grids import MuscleGrid
from handlab.anatomy.records import Hand
from handlab.anatomy.terms import find
from handlab.show import keepsakes, wire
from handlab.show.moments import Story
from handlab.show.moving_hand import AWAKE, MovingHand
from handlab.simulation.keyframes import KeyFrames

MINE = "my clip"
FORMATS = ("png", "mp4", "gif", "glb", "html", "csv")


@dataclass(frozen=True, eq=False)
class Wish:
    """A file that a client asked for: ``format``, what it shows, and the client's ``look`` (``view``, ``skin``, ``bones``)."""

    format: str
    story: Story
    look: Mapping[str, Any]
    name: str


class KeepingHand(MovingHand):
    """A moving hand that records, saves, loads and exports. ``exports``: the formats that its host writes."""

    exports: tuple[str, ...]
    _replies: deque[dict[str, Any]]
    _wishes: deque[Wish]

    def _answer(self, text: str, *, good: bool = True) -> None:
        """Tell the user a sentence."""

    def clips(self) -> list[dict[str, Any]]:
        """Clips that can be played: the package's, then the user's."""
        own = [{"name": name, "title": name, "seconds": float(clip.time[-1] - clip.time[0])} for name, clip in self.own.items()]
        return [*(clip for clip in wire.named_clips() if clip["name"] not in self.own), *own]

    def _record(self, message: Mapping[str, Any]) -> None:
        if message.get("on"):
            self._leave()
            self._history.clear()
            self._recording, self._awake = self.state.time, AWAKE
            self._status()
            return
        if self._recording is None:
            raise ValueError("nothing is being recorded; press record, move muscles, press it again")
        self._recording = None
        self.own[MINE] = keepsakes.recorded(self.hand, self._history, MINE, **self._worn)
        self._replies.append({"kind": "clips", "clips": self.clips()})
        self._open(MINE)
        self._status()
        self._answer(f"recorded {self._seconds:.1f} s as {MINE!r}; save it to keep it")

    def _save(self, message: Mapping[str, Any]) -> None:
        what = find(str(message.get("what")), ("pose", "clip"), kind="thing to save")
        if what == "pose":
            contraction, angle, _, _, _ = self._now()
            name, text = "pose.json", keepsakes.pose_text(self.hand, contraction, angle, self.hold)
        else:
            name, text = keepsakes.clip_file(self._shown_clip())
        self._replies.append({"kind": "file", "name": name, "mime": "application/json", "text": text})

    def _load(self, message: Mapping[str, Any]) -> None:
        file = str(message.get("name") or "this file")[:120]
        found = keepsakes.read(self.hand, message.get("text"), file)
        if isinstance(found, KeyFrames):
            self.own[found.name] = found
            self._replies.append({"kind": "clips", "clips": self.clips()})
            self._open(found.name)
            self._answer(f"loaded the clip {found.name!r}: {self._seconds:.1f} s")
        elif isinstance(found, MuscleGrid):
            from handlab.simulation.painted import with_painted

            self.paint(with_painted(self.hand, found), found)
        else:
            self._leave()
            self.state, self.contraction, self.hold, self._awake = found.state, found.contraction, found.hold, AWAKE
            self._history.clear()
            self.wardrobe.drop()
            self._answer(f"loaded the pose {file!r}")
        self._status()

    def paint(self, hand: Hand, grid: MuscleGrid) -> None:
        """Go on with ``hand``, which is this one with a painted muscle."""
        self.adopt(hand)
        if self.segments:
            self._tell_layers()
        drives = " and ".join(self.hand.muscles[name].abbreviation for name in grid.drives)
        self._answer(f"the muscle {grid.name!r} is in; {drives} makes it swell")
        self._status()

    def _tell_layers(self) -> None:
        """Tell what stays of muscles and tendons."""

    def _export(self, message: Mapping[str, Any]) -> None:
        kind = find(str(message.get("format")), FORMATS, kind="format")
        if kind not in self.exports:
            raise ValueError(f"this viewer does not write .{kind}; it writes {', '.join('.' + one for one in self.exports)}")
        look = message.get("look")
        asked = dict(look) if isinstance(look, Mapping) else {}
        self._wishes.append(Wish(kind, self._shown(still=kind == "png"), asked, self._file_name()))
        if kind in ("mp4", "gif"):
            self._answer(f"drawing the .{kind}; the file comes when it is ready")

    def _file_name(self) -> str:
        return "".join(c if c.isalnum() or c in "-_" else "-" for c in self.clip_name) or "hand"
