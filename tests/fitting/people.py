"""The known people of ``tests/data/people.npz`` (made by ``tools.people.build``): skin, joint centres and feature points.

Nothing here has been warped: the skin is the shape data's own, and so are PIP, DIP and tips.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

import handlab as hl
from tools.people.cage import fine_from_cage

FILE = Path(__file__).parents[1] / "data" / "people.npz"
STEP = 1e-5
CENTRES = (
    "wrist",
    *(f"cmc{k}" for k in range(1, 6)),
    *(f"mcp{k}" for k in range(1, 6)),
    "ip1",
    *(f"{joint}{k}" for joint in ("pip", "dip") for k in range(2, 6)),
    *(f"tip{k}" for k in range(1, 6)),
)
CHAINS = {1: ("cmc1", "mcp1", "ip1", "tip1")} | {k: (f"cmc{k}", f"mcp{k}", f"pip{k}", f"dip{k}", f"tip{k}") for k in range(2, 6)}
BONES = tuple((near, far) for chain in CHAINS.values() for near, far in pairwise(chain))


@dataclass(frozen=True, eq=False)
class Person:
    """Metres. ``skin`` (6854, 3) with the triangles of the reference hand's fine skin; ``marks[view][name]`` (3,)."""

    name: str
    size: float
    skin: np.ndarray
    faces: np.ndarray
    centres: dict[str, np.ndarray]
    marks: dict[str, dict[str, np.ndarray]]

    @property
    def lengths_mm(self):
        return {bone: 1e3 * float(np.linalg.norm(self.centres[bone[0]] - self.centres[bone[1]])) for bone in BONES}


@cache
def hand():
    return hl.load_hand()


@cache
def everyone():
    """All people by name."""
    reference = hand()
    faces = reference.skin_fine.faces
    smooth = fine_from_cage(faces)
    base = reference.skin_fine.points[: smooth.shape[1]]
    stored = np.load(FILE)
    people = {}
    for i, name in enumerate(stored["name"].tolist()):
        cage = stored["size"][i] * base + STEP * stored["delta"][i]
        centres = dict(zip(CENTRES, STEP * stored["centre"][i], strict=True))
        marks = {
            view: dict(zip(reference.feature_points, STEP * stored["mark"][i, v], strict=True))
            for v, view in enumerate(("palmar", "dorsal"))
        }
        people[name] = Person(name, float(stored["size"][i]), np.asarray(smooth @ cage), faces, centres, marks)
    return people


def reference_person():
    """The reference hand itself in the same form: its joint centres as they lie in the bind posture."""
    reference = hand()
    return Person(
        "reference",
        1.0,
        reference.skin_fine.points,
        reference.skin_fine.faces,
        bound_centres(reference),
        {view: {name: reference.skin.points[row[view]] for name, row in reference.feature_points.items()} for view in ("palmar", "dorsal")},
    )


def bound_centres(hand):
    """Joint centres and tips of a hand in its bind posture; a tip is the last point of the skin along the distal phalanx."""
    from handlab.simulation.kinematics import body_transforms, rotation

    bodies = dict(zip(hand.body_names, body_transforms(hand, hand.bind), strict=True))
    centres = {}
    for name, joint in hand.joints.items():
        body = bodies[joint.parent]
        if name == "cmc1":  # it lies distal of the thumb's first axis and turns about it
            body = body @ rotation(joint.dofs[0].axis, joint.dofs[0].anchor, hand.bind[hand.dof_names.index(joint.dofs[0].name)])
        centres[name] = body[:3, :3] @ joint.centre + body[:3, 3]
    for k, digit in enumerate(("thumb", "index", "middle", "ring", "little"), start=1):
        centres[f"tip{k}"] = hand.skin.points[hand.feature_points[f"tip_{digit}"]["palmar"]]
    return centres
