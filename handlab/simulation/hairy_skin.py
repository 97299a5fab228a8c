"""Two kinds of skin: that of palm and pulps, held by chambers of fibre, and hairy skin, which slides on loose tissue."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from handlab.anatomy.records import Array, Hand, frozen
from handlab.simulation.bone_frames import BoneFrames
from handlab.simulation.per_hand import per_hand
from handlab.simulation.skin import normals

TISSUE = 15e3  # Pa, fat in chambers of fibre below the palm's skin: assumption, between fat (a few kPa) and resting muscle (tens of kPa)
LOOSE = 4.77e3 / TISSUE  # below hairy skin: 4.77 kPa within seconds (rats: Iatridis, Wu, Yandow, Langevin 2003)
EDGE = 0.5  # cosine to the palmar direction at which skin is all of one kind; in between, along the sides, it changes evenly: assumption


@per_hand
def hairy(hand: Hand) -> Array:
    """How much (n,) of every skin point is hairy: 1 on the backs and all around the forearm, 0 in the palm and on the pulps.

    By where skin faces in the bind posture, against the palmar direction of the bones that move it.
    """
    frames = BoneFrames(hand)
    palmar = np.zeros((len(hand.body_names), 3))  # none: the forearm is hairy all around
    for row, body in enumerate(hand.body_names):
        bone = "metacarpal_3" if body == "carpus" else body
        if bone in hand.bones and bone[-1].isdigit():
            palmar[row] = frames.frame(bone)[2]
    towards = np.einsum("ni,nb,bi->n", normals(hand, hand.skin.points), hand.skin.weights, palmar)
    towards -= EDGE * hand.skin.weights[:, hand.body_names.index("forearm")]
    result: Array = frozen(np.clip(0.5 - 0.5 * towards / EDGE, 0.0, 1.0))
    return result


def firmness(hand: Hand, depth: Array, thickness: float) -> Array:
    """Stiffness (n,) of columns of tissue ``depth`` (n,) m, with their skin of ``thickness`` m, over that below the palm."""
    result: Array = 1.0 - hairy(hand) * (1.0 - loose(depth, thickness))
    return result


def loose(depth: ArrayLike, thickness: float) -> Array:
    """The same below hairy skin alone: only what lies below the skin is loose, springs in series; nowhere stiffer than in the palm."""
    whole = np.asarray(depth, dtype=np.float64)
    result: Array = np.minimum(1.0, LOOSE * whole / np.maximum(whole - thickness, 1e-9))
    return result
