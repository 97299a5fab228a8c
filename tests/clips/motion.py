"""A named clip played once, and what is measured on it: every test of a clip looks at the same frames."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

import handlab
from handlab.studies import measures

FPS = 10  # samples along the motion: one every 0.1 s
STAYS = 0.2  # seconds of constant contraction that count as holding
FINGERS = (2, 3, 4, 5)


@cache
def hand():
    """The reference hand."""
    return handlab.load_hand()


@cache
def motion(name):
    """The clip of this name, wrist free, from the relaxed hand."""
    return Motion(name)


@dataclass(frozen=True)
class Motion:
    """One clip; angles in degrees, lengths in millimetres."""

    name: str

    @cached_property
    def keys(self):
        return handlab.keyframes(self.name)

    @cached_property
    def clip(self):
        return handlab.simulate(hand(), self.keys, fps=FPS)

    @cached_property
    def held(self):
        """Frames at the end of every stretch of constant contraction, or the last one if the hand never rests."""
        keys = self.keys
        still = (np.abs(np.diff(keys.contraction, axis=0)).max(axis=1) < 1e-9) & (keys.contraction[1:].max(axis=1) > 0)
        long = np.diff(keys.time) >= STAYS
        return [int(np.floor(time * FPS + 1e-6)) for time in keys.time[1:][still & long]] or [len(self.clip) - 1]

    @cached_property
    def flesh(self):
        """Depth of skin in skin (T, N)."""
        return np.array([1e3 * measures.flesh_depth(hand(), self.clip.skin(k)) for k in range(len(self.clip))])

    @cached_property
    def bones(self):
        """By frame: pair of bones -> depth of one in the other."""
        return [{pair: 1e3 * d for pair, d in measures.bone_depths(hand(), angle).items()} for angle in self.clip.angle]

    @cached_property
    def volume(self):
        """Volume (T,) of the blended skin over that of the relaxed hand."""
        return np.array([volume(self.clip.skin(k)) for k in range(len(self.clip))]) / volume(handlab.rest(hand()).skin)

    def where(self, frame):
        """Body whose skin lies deepest in other skin."""
        return hand().body_names[hand().skin.weights[self.flesh[frame].argmax()].argmax()]

    def angle(self, dof, frame):
        return float(np.rad2deg(self.clip.angle[frame, hand().dof_names.index(dof)]))

    def flexion(self, joint, frame, which=FINGERS):
        """Flexion of one kind of joint in some fingers."""
        return np.array([self.angle(f"{joint}{k}.flexion_extension", frame) for k in which])

    def contraction(self, muscle, frame):
        return float(self.clip.contraction[frame, hand().muscle_names.index(hand().muscles[muscle].name)])

    def gap(self, finger, frame):
        return 1e3 * measures.pulp_gap(hand(), self.clip.skin(frame), 1, finger)

    def facing(self, finger, frame):
        """Angle between the thumb's pulp and the way to the finger's, and between the finger's pulp and the way back."""
        skin = self.clip.skin(frame)
        return tuple(float(np.rad2deg(measures.facing(hand(), skin, *pair))) for pair in ((1, finger), (finger, 1)))

    def to_palm(self, digit, frame):
        return 1e3 * measures.pulp_to_palm(hand(), self.clip.skin(frame), digit)

    def thumb_to(self, bodies, frame):
        """From the thumb's pulp to the skin of these bodies; whether it lies inside is asked of ``flesh``."""
        return abs(1e3 * measures.pulp_to_bodies(hand(), self.clip.skin(frame), 1, bodies))


def volume(skin):
    """By the divergence theorem."""
    a, b, c = (skin[hand().skin.faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)
