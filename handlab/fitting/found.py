"""A first guess of the feature points, from the outline of a hand with spread fingers on a plain ground; a person corrects it.

What sticks out of the palm is a finger: where it ends is a tip, where the outline turns back between two fingers is a web. The other
points follow from where they lie on the reference hand between these, and joints are put in the middle of their finger.
"""

from __future__ import annotations

import os
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Array
from handlab.anatomy.terms import FINGERS
from handlab.fitting.alignment import Similarity, fitting_plane, similarity
from handlab.fitting.landmarks import NAMES, source_points
from handlab.fitting.outline import COARSE, Mask, contour, reduced, small_mask, threshold
from handlab.physics import rbf

# Shares of the palm's half width: discs of this size do not go into fingers, and no finger is shorter (assumptions).
NO_FINGER, SHORTEST = 0.52, 0.55
FAINT = 20.0  # levels of 255: a picture without larger differences shows nothing (an assumption)
TIPS = tuple(f"tip_{finger}" for finger in FINGERS)
WEBS = tuple(f"web_{a}_{b}" for a, b in pairwise(FINGERS))
SPREAD = "spread the fingers, on a plain ground of another colour, with the whole hand in the picture; or click the points yourself"


def find_landmarks(
    picture: str | os.PathLike[str] | bytes | NDArray[Any], *, view: str = "palmar", by: str | None = None
) -> dict[str, tuple[float, float]]:
    """Guesses of all 26 feature points, name -> (x, y) px, of the one hand in ``picture`` (a file, its bytes, or pixels).

    ``view`` "palmar" or "dorsal"; left or right, turned in any way. ``by``: "outline", which needs fingers spread on a plain ground (tips
    and webs good to 2 to 3 mm, joints to some 8); "mediapipe", which also looks for joints (3 mm) and works on any ground, if that is
    installed (see ``found_joints``); the better one at hand if not given. Raises ``ValueError`` where no hand is found.
    """
    from handlab.fitting import found_joints
    from handlab.fitting.pictures import load_picture

    if by not in (None, "outline", "mediapipe"):
        raise ValueError(f"by is {by!r}; it must be 'outline' or 'mediapipe'")
    pixels = load_picture(picture)
    step = max(1, round(max(pixels.shape[:2]) / COARSE))
    learned = by == "mediapipe" or (by is None and found_joints.installed())
    joints = {name: place / step for name, place in found_joints.joints(pixels).items()} if learned else {}
    source = _source(view)
    try:
        guess = _by_outline(_seen(pixels, step), source, joints)
    except ValueError:
        if not joints:
            raise
        guess = _completed(source, joints)
    rows, columns = pixels.shape[:2]
    return {name: (float(np.clip(x * step, 0.0, columns)), float(np.clip(y * step, 0.0, rows))) for name, (x, y) in guess.items()}


def _source(view: str) -> Array:
    """All feature points (26, 2) mm of the reference hand in its plane, y downwards."""
    points = source_points(load_hand(), view, marks="exact")
    source: Array = 1e3 * fitting_plane(points, view).flat(points) * np.array([1.0, -1.0])
    return source


def _by_outline(mask: Mask, source: Array, joints: dict[str, Array]) -> dict[str, Array]:
    tips, webs, bases = _tips_and_webs(mask)
    given, fit, way = _named(tips, webs, source, joints)
    given |= {name: place for name, place in joints.items() if not name.startswith(("tip", "wrist"))}
    given |= _wrist(mask, fit, source, joints.get("wrist"))
    guess = _completed(source, given)
    for k, (finger, base) in enumerate(zip(FINGERS, bases[::way], strict=True)):
        along = guess[TIPS[k]] - base
        for name in (f"{joint}_{finger}" for joint in (("ip",) if k == 0 else ("dip", "pip"))):
            if name not in joints:
                onto = base + along * float((guess[name] - base) @ along) / float(along @ along)
                guess[name] = _middle(mask, onto, along)
    return guess


def _completed(source: Array, given: dict[str, Array]) -> dict[str, Array]:
    """All 26 points: those given, and the others where a smooth warp of the reference hand's takes them."""
    given = {name: place for name, place in given.items() if name in NAMES}
    flat = np.column_stack([source, np.zeros(len(source))])
    at = np.array(list(given.values()))
    warp = rbf.fitted(flat[[NAMES.index(name) for name in given]], np.column_stack([at, np.zeros(len(at))]))
    return {name: given.get(name, place[:2]) for name, place in zip(NAMES, warp(flat), strict=True)}


def _seen(pixels: NDArray[np.uint8], step: int) -> Mask:
    """The hand as a mask of the picture reduced by ``step``; its colours are learnt inside the largest thing that is no background."""
    from scipy.ndimage import distance_transform_edt, gaussian_filter, label

    small = reduced(pixels, step)
    colour = np.stack([gaussian_filter(small[:, :, i], 2.0) for i in range(3)], axis=2)
    edge = np.concatenate([colour[0], colour[-1], colour[:, 0], colour[:, -1]])
    far = np.linalg.norm(colour - np.median(edge, axis=0), axis=2)
    if far.max() < FAINT:
        raise ValueError(f"nothing stands out from the background of this picture; {SPREAD}")
    pieces, _ = label(far > threshold(far))
    depth = distance_transform_edt(pieces == np.bincount(pieces[pieces > 0]).argmax())
    inner = np.argwhere(depth > 0.4 * depth.max())
    chosen = inner[:: max(1, len(inner) // 60)][:, ::-1].astype(np.float64) * step + step / 2.0
    return small_mask(pixels, chosen)[0]


def _tips_and_webs(mask: Mask) -> tuple[Array, Array, Array]:
    """Five tips (5, 2) px in their order along the outline, from one end to the other, the four webs between, and the fingers' bases."""
    from scipy.ndimage import distance_transform_edt, label

    depth = distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
    palm = float(depth.max())
    out = distance_transform_edt(depth <= NO_FINGER * palm) if palm > 0 else depth
    beyond = out - NO_FINGER * palm  # how far from the palm without fingers
    pieces, number = label(mask & (beyond > 1.0))
    reach = {k: float(beyond[pieces == k].max()) for k in range(1, number + 1)}
    best = sorted((k for k in reach if reach[k] > SHORTEST * palm), key=lambda k: -reach[k])[:5]
    if len(best) < 5:
        raise ValueError(f"{len(best)} fingers were found instead of five; {SPREAD}")
    line = contour(mask)
    tips, bases = [], {}
    for k in best:
        at = np.argwhere(pieces == k)[:, ::-1] + 0.5
        base = at[beyond[pieces == k] < 3.0].mean(axis=0)
        end = at[np.argmax(np.linalg.norm(at - base, axis=1))]
        tips.append(int(np.argmin(np.linalg.norm(line - end, axis=1))))
        bases[tips[-1]] = base
    tips.sort()
    ways = [(tips[(k + 1) % 5] - tips[k]) % len(line) for k in range(5)]
    first = int(np.argmax(ways)) + 1  # the longest way from tip to tip goes round the wrist
    order = [tips[(first + k) % 5] for k in range(5)]
    webs = []
    for a, b in pairwise(order):
        part = line[np.arange(a, a + (b - a) % len(line) + 1) % len(line)]
        chord = part[-1] - part[0]
        webs.append(part[np.argmax(np.abs((part - part[0]) @ np.array([-chord[1], chord[0]])))])
    return line[order], np.array(webs), np.array([bases[tip] for tip in order])


def _named(tips: Array, webs: Array, source: Array, joints: dict[str, Array]) -> tuple[dict[str, Array], Similarity, int]:
    """Names of tips and webs, the similarity of the reference hand's points ``source`` (26, 2) to them, and their order (1 or -1).

    Thumb first or last, turned or mirrored: whichever lies most like the reference hand, or near ``joints`` that are known."""
    names = (*TIPS, *WEBS)
    index = [NAMES.index(name) for name in names]
    trials = []
    for way in (1, -1):
        at = np.concatenate([tips[::way], webs[::way]])
        off = sum(float(np.linalg.norm(at[k] - joints[name])) for k, name in enumerate(TIPS) if name in joints)
        fits = [similarity(source[index], at, mirror=mirror) for mirror in (False, True)]
        trials += [(off or fit.scatter, fit.scatter, way, fit, at) for fit in fits]
    _, _, way, fit, at = min(trials, key=lambda trial: trial[:2])
    return dict(zip(names, at, strict=True)), fit, way


def _wrist(mask: Mask, fit: Similarity, source: Array, middle: Array | None) -> dict[str, Array]:
    """Both edges of the wrist: where the outline is cut by the line across its ``middle``, or across the one of the reference hand."""
    radial, ulnar = (fit.scale * fit.matrix @ source[NAMES.index(f"wrist_{side}")] + fit.shift for side in ("radial", "ulnar"))
    across = radial - ulnar
    run = _run(mask, (radial + ulnar) / 2.0 if middle is None else middle, across / np.linalg.norm(across))
    if run is None:
        return {}
    low, high = run
    natural = np.linalg.norm(across)
    if not 0.6 * natural < np.linalg.norm(high - low) < 1.6 * natural:  # a sleeve, a strap
        return {}
    return {"wrist_radial": high, "wrist_ulnar": low}


def _middle(mask: Mask, place: Array, along: Array) -> Array:
    """``place`` moved across ``along`` into the middle of its finger."""
    across = np.array([-along[1], along[0]]) / max(float(np.linalg.norm(along)), 1e-9)
    run = _run(mask, place, across)
    if run is None or np.linalg.norm(run[1] - run[0]) > 0.45 * np.linalg.norm(along):  # it runs into the next finger
        return place
    result: Array = (run[0] + run[1]) / 2.0
    return result


def _run(mask: Mask, place: Array, across: Array) -> tuple[Array, Array] | None:
    """The ends of the stretch of ``mask`` through ``place`` against and along the unit vector ``across``."""
    way = np.arange(0.0, float(max(mask.shape)), 0.5)
    ends = []
    for sign in (-1.0, 1.0):
        at = place + sign * way[:, None] * across
        pixel = np.floor(at).astype(int)
        inside = ((pixel >= 0) & (pixel < np.array(mask.shape)[::-1])).all(axis=1)
        on = inside & mask[np.clip(pixel[:, 1], 0, mask.shape[0] - 1), np.clip(pixel[:, 0], 0, mask.shape[1] - 1)]
        if not on[0]:
            return None
        ends.append(at[int(np.argmin(on)) if not on.all() else -1])
    return ends[0], ends[1]
