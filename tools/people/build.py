"""Write ``tests/data/people.npz``, the known people that the photo path is tried on: ``python -m tools.people.build``.

Needs what ``tools.reference_hand.build`` needs. Each person is stored as the difference to the reference hand's fine skin, scaled to
the person's size, in hundredths of a millimetre.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from tqdm import tqdm

import handlab as hl
from tools.people import cage, shapes, truth
from tools.reference_hand import build, rays, skeleton, skin, sources

FILE = Path(__file__).resolve().parents[2] / "tests" / "data" / "people.npz"
STEP = 1e-5  # metres: stored numbers are whole hundredths of a millimetre


def main(path: Path = FILE) -> None:
    written(shapes.PEOPLE, path)


def written(people: Mapping[str, Mapping[str, float]], path: Path) -> None:
    """People given by their shapes, as a file of ``path``."""
    hand = hl.load_hand()
    woman, bones = sources.person(), sources.bone_set()
    quads, index, turn = frame(woman, bones)
    reach = _reach(woman)
    base = hand.skin_fine.points[: len(index)]
    names = list(people)
    sizes, deltas, centres, marks = [], [], [], []
    for name in tqdm(names, desc="people", file=sys.stderr):
        person = sources.person(people[name])
        size = _reach(person) / reach
        found = truth.truth(person, bones, quads, index, turn, hand, size)
        sizes.append(size)
        deltas.append(_whole(found.cage - size * base))
        centres.append(_whole(found.centres))
        marks.append(_whole(found.marks))
    np.savez_compressed(path, name=names, size=sizes, delta=deltas, centre=centres, mark=marks)


def frame(woman: sources.Person, bones: sources.BoneSet) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quads of arm and hand, the body points that make the cage (in its order), and the turn from palm to hand frame."""
    origin, rotation = rays.palm_frame(woman)
    placed = (woman.points - origin) @ rotation.T
    near = (placed[:, 0] > build.NEAR_HAND) & (woman.arm > 0.01)
    near[sources.BODY_POINTS :] = False
    quads = woman.quads[near[woman.quads].all(axis=1)]
    found = rays.find_rays(woman, bones, quads)
    turn = skeleton.forearm_frame(found.surface)
    return quads, cage_index(found.points @ turn.T, quads), turn


def cage_index(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """The points that ``skin.fine_skin`` keeps, in its order."""
    keep = (points[quads][:, :, 0] > skin.FOREARM_END - 0.004).all(axis=1)
    used, faces = np.unique(np.vstack([quads[keep][:, [0, 1, 2]], quads[keep][:, [0, 2, 3]]]), return_inverse=True)
    faces, _ = skin._largest_part(faces.reshape(-1, 3), np.zeros((faces.size // 3, 3, 2)))
    index = used[np.unique(faces)]
    if len(index) != cage.cage_faces(hl.load_hand().skin_fine.faces).max() + 1:
        raise RuntimeError("the cage has other points than the reference hand's: build the reference hand first")
    return index


def _reach(person: sources.Person) -> float:
    return float(np.linalg.norm(person.joints["joint-r-finger-3-4"] - person.joints["joint-r-hand"]))


def _whole(metres: np.ndarray) -> np.ndarray:
    whole = np.round(metres / STEP)
    if np.abs(whole).max() > np.iinfo(np.int16).max:
        raise RuntimeError("a person lies too far from the reference hand for 16 bits")
    return whole.astype(np.int16)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FILE)
