"""The known people of ``tests/data/people*.npz`` (made by ``tools.people``): skin, joint centres and feature points.

Nothing here has been warped: the skin is the shape data's own, and so are PIP, DIP and tips.
"""

from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

import handlab as hl
from handlab.fitting import marks
from tools.people.cage import fine_from_cage

DATA = Path(__file__).parents[1] / "data"
SEEN, FRESH = "people.npz", "people_fresh.npz"  # looked at while the fit was made; never
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
def everyone(file=SEEN):
    """All people of a file by name."""
    reference = hand()
    faces = reference.skin_fine.faces
    smooth = fine_from_cage(faces)
    base = reference.skin_fine.points[: smooth.shape[1]]
    stored = np.load(DATA / file)
    people = {}
    for i, name in enumerate(stored["name"].tolist()):
        cage = stored["size"][i] * base + STEP * stored["delta"][i]
        centres = dict(zip(CENTRES, STEP * stored["centre"][i], strict=True))
        places = {
            view: dict(zip(reference.feature_points, STEP * stored["mark"][i, v], strict=True))
            for v, view in enumerate(("palmar", "dorsal"))
        }
        people[name] = Person(name, float(stored["size"][i]), np.asarray(smooth @ cage), faces, centres, places)
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
    centres = marks.bound_centres(hand)
    for k, digit in enumerate(("thumb", "index", "middle", "ring", "little"), start=1):
        centres[f"tip{k}"] = hand.skin.points[hand.feature_points[f"tip_{digit}"]["palmar"]]
    return centres


def hand_lengths_mm(hand):
    """Bone lengths of a hand, as ``Person.lengths_mm``."""
    centres = bound_centres(hand)
    return {bone: 1e3 * float(np.linalg.norm(centres[bone[0]] - centres[bone[1]])) for bone in BONES}


def rigidly(points, onto):
    """``points`` turned and shifted (not scaled) onto corresponding points (Kabsch 1976)."""
    a, b = points - points.mean(axis=0), onto - onto.mean(axis=0)
    left, _, right = np.linalg.svd(b.T @ a)
    turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    return a @ turn.T + onto.mean(axis=0)


def skin_error_mm(skin, person):
    """Mean distance of a hand's fine skin from the person's skin, after rigid alignment."""
    return 1e3 * float(_near(person).query(rigidly(skin, person.skin))[0].mean())


@cache
def _near(person):
    """The person's skin as a dense set of points."""
    corner = person.skin[person.faces]
    return cKDTree(np.vstack([person.skin, corner.mean(axis=1), ((corner + np.roll(corner, 1, axis=1)) / 2).reshape(-1, 3)]))


@contextmanager
def only_shapes():
    """Fits without masses, a fifth of their time, for tests that look at shapes only."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("handlab.fitting.warp.weighed", lambda hand, size=1.0: hand.bodies)
        yield
