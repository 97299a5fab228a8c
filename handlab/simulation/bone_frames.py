"""Places and directions on the bones of one hand in the bind posture: joints, base and head, palmar and radial."""

from __future__ import annotations

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.simulation.kinematics import transforms, tree


class BoneFrames:
    """``centre`` (3,) m of every joint and ``axes`` (3,) of every degree of freedom by name; ``size`` m from wrist to third knuckle."""

    def __init__(self, hand: Hand) -> None:
        self.hand = hand
        self.radial = 1.0 if hand.side == "right" else -1.0
        posed, axes, _ = transforms(tree(hand), hand.bind)
        row = {name: k for k, name in enumerate(hand.body_names)}
        self.centre = {}
        for name, joint in hand.joints.items():
            carrier = row[hand.bones[joint.parent].body if joint.parent in hand.bones else joint.parent]
            self.centre[name] = posed[carrier][:3, :3] @ joint.centre + posed[carrier][:3, 3]
        self.axes = {name: axes[k] for k, name in enumerate(hand.dof_names)}
        self.size = float(np.linalg.norm(self.centre["mcp3"] - self.centre["wrist"]))

    def frame(self, bone: str) -> tuple[Array, Array, Array, Array]:
        """Base and head of a metacarpal or phalanx (joint centres), its palmar and radial direction."""
        digit = bone[-1]
        chain = ["cmc1", "mcp1", "ip1"] if digit == "1" else [f"{joint}{digit}" for joint in ("cmc", "mcp", "pip", "dip")]
        bones = [f"metacarpal_{digit}", f"proximal_phalanx_{digit}", *([] if digit == "1" else [f"middle_phalanx_{digit}"])]
        place = [*bones, f"distal_phalanx_{digit}"].index(bone)
        base = self.centre[chain[place]]
        if place + 1 < len(chain):
            head = self.centre[chain[place + 1]]
        else:
            points = self.hand.bones[bone].points
            head = points[np.linalg.norm(points - base, axis=1).argmax()]
        distal = (head - base) / np.linalg.norm(head - base)
        palmar = np.cross(self.axes[f"{chain[max(place, 1)]}.flexion_extension"], distal)
        palmar /= np.linalg.norm(palmar)
        return base, head, palmar, self.radial * np.cross(distal, palmar)
