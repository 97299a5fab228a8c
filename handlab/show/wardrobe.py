"""The soft skin of a live hand: made ready beside everything else, then carried along tick by tick until it rests."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from handlab.anatomy.records import Array, Hand, frozen
from handlab.show.outfits import BLEND, SOFT
from handlab.simulation.clip import Clip

if TYPE_CHECKING:
    from handlab.simulation.soft_skin import Network, SoftSkin

STILL_SKIN = 3e-4  # m/s: slower than half a step of what travels (0.01 mm) in a frame


class Wardrobe:
    """How a hand wears its skin: ``wear`` and ``muscles`` as in ``simulate``.

    Until ``prepare`` has run (a second or two, on any thread), the skin is blended whatever ``wear`` says.
    """

    def __init__(self, hand: Hand, wear: str = BLEND, muscles: str = "both") -> None:
        self.hand = hand
        self.wear, self.muscles = BLEND, "both"
        self.network: Network | None = None
        self._soft: SoftSkin | None = None
        self._silent: dict[str, tuple[Array, SoftSkin]] = {}
        self.moving = False
        if (wear, muscles) != (BLEND, "both"):
            self.choose(wear, muscles)

    def choose(self, wear: str, muscles: str) -> None:
        """Wear the skin another way. Raises ``UnknownName``."""
        from handlab.simulation.worn import muscles_used, skin_worn

        chosen, used = skin_worn(wear), muscles_used(muscles)
        self.wear, self.muscles = chosen, used
        self.drop()

    def prepare(self) -> None:
        """Build the network and compile what moves it. Nothing of the live hand is touched until it is done."""
        from handlab.simulation.kinematics import relative_transforms
        from handlab.simulation.soft_frame import at_bind, blended, follow
        from handlab.simulation.soft_skin import soft_skin

        network = soft_skin(self.hand)
        follow(self.hand, network, at_bind(network), self.hand.bind, None, 1.0 / 60.0)
        blended(self.hand, network, relative_transforms(self.hand, self.hand.bind))  # its kernels take over from a clip
        self.network = network

    @property
    def soft(self) -> bool:
        """Whether springs move the skin now."""
        return self.wear != BLEND and self.network is not None

    def drop(self) -> None:
        """The hand jumped: the skin begins at rest where it is asked for next."""
        self._soft = None
        self.moving = False

    def points(self, angle: Array, contraction: Array, dt: float = 0.0) -> Array:
        """Skin points (N, 3) ``dt`` seconds later, when the bones have come to ``angle``; at rest after a jump."""
        from handlab.simulation.soft_frame import follow

        assert self.network is not None
        heard = self.heard(contraction)
        if self._soft is None:
            self._soft = self._begun(angle, heard)
        elif dt > 0.0:
            before = self._soft.position
            self._soft = follow(self.hand, self.network, self._soft, angle, heard, dt, skin=self.wear)
            self.moving = float(np.abs(self._soft.position - before).max()) > STILL_SKIN * dt
        points: Array = self._soft.points
        return points

    def _begun(self, angle: Array, heard: Array) -> SoftSkin:
        """The skin at rest. That of the last silent hand is kept: after a reset it is there at once."""
        from handlab.simulation.soft_frame import begin

        silent = not heard.any()
        if silent and self.wear in self._silent and np.array_equal(self._silent[self.wear][0], angle):
            return self._silent[self.wear][1]
        assert self.network is not None
        soft = begin(self.hand, self.network, angle, heard, skin=self.wear)  # type: ignore[arg-type]
        if silent:
            self._silent[self.wear] = (angle, soft)
        return soft

    def heard(self, contraction: Array) -> Array:
        """What geometric muscles hear of ``contraction``."""
        from handlab.simulation.worn import swelling_contraction

        return swelling_contraction(contraction, self.muscles)

    def dressed(self, clip: Clip) -> Clip:
        """The clip with its skin worn as it is worn here; as it is while the springs are not ready."""
        if clip.wear == self.wear:
            return clip
        if self.wear == BLEND:
            return clip.with_skin(BLEND)
        return clip.with_skin(self.wear, network=self.network) if self.soft else clip

    def take_over(self, clip: Clip, frame: int, points: Array, angle: Array, contraction: Array) -> None:
        """The live skin goes on from ``points`` (N, 3) near ``frame`` of a clip."""
        self.drop()
        if not self.soft or clip.worn is None or clip.wear != self.wear:
            return
        from handlab.simulation.geometric_muscle import shape
        from handlab.simulation.kinematics import relative_transforms
        from handlab.simulation.soft_anchors import anchors
        from handlab.simulation.soft_frame import resting

        net: Any = self.network
        assert net is not None
        moved = relative_transforms(self.hand, angle)
        lifting = self.wear == SOFT and net.muscles is not None
        shapes = shape(net.muscles, moved, self.heard(contraction)) if lifting else None
        swelling = clip.worn.swelling(frame)
        tied = anchors(net, moved, shapes)
        tied.swell(net, swelling)
        self._soft = resting(net, points, tied, swelling)
        self.moving = True


def between_skins(clip: Clip, left: int, right: int, share: float) -> Array:
    """Skin points (N, 3) on the straight line between two frames of a clip."""
    if share in (0.0, 1.0) or left == right:
        return clip.skin(right if share == 1.0 else left)
    mixed: Array = frozen((1.0 - share) * clip.skin(left) + share * clip.skin(right))
    return mixed
