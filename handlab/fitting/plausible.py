"""Can these clicks be a hand? Sizes, labels and single points are questioned before anything is warped."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import FINGERS
from handlab.fitting.alignment import Aligned, fitting_plane, similarity
from handlab.fitting.calibration import Scale
from handlab.fitting.landmarks import NAMES, digit_of, source_points
from handlab.fitting.mistakes import FitError, FitQuestion
from handlab.physics import rbf

if TYPE_CHECKING:
    from handlab.fitting.warp import WarpedHand

# From the wrist to the tip of the middle finger: toddlers to the largest known hands, with room (assumptions).
SHORTEST_MM, LONGEST_MM = 80.0, 250.0
# Labels are doubted where an exchange makes the points fit so much better (assumptions, see tests with people of many shapes).
BETTER, WORSE_THAN = 1.35, 0.045
# A point is doubted so far (over the hand's length) from where the others say it should be (an assumption).
FAR_OFF = 0.30
UNCLEAR = 0.01  # a coin or card is questioned where its size is less certain (relative)

FLAT = "perspective not taken out: right for a scanner; for a camera give its distance, camera_mm=600, or the hand comes out too large"


def flat_source(hand: Hand, view: str, names: tuple[str, ...] = NAMES) -> Array:
    """Feature points (N, 2) mm in the plane that fits all of them, seen from ``view``."""
    frame = fitting_plane(source_points(hand, view), view)
    return 1e3 * frame.flat(source_points(hand, view, names))


def hand_length_mm(hand: Hand) -> float:
    """From the middle between both edges of the wrist to the tip of the middle finger."""
    radial, ulnar, tip = source_points(hand, "palmar", ("wrist_radial", "wrist_ulnar", "tip_middle"))
    return 1e3 * float(np.linalg.norm(tip - 0.5 * (radial + ulnar)))


def require_size(hand: Hand, names: tuple[str, ...], picture: Array) -> None:
    """Ask about a hand that nobody has: ``picture`` (N, 2) mm."""
    sizes = [similarity(flat_source(hand, view, names), picture, mirror=mirror) for view in ("palmar",) for mirror in (False, True)]
    best = min(sizes, key=lambda found: found.scatter)
    length = best.scale * hand_length_mm(hand)
    if not SHORTEST_MM <= length <= LONGEST_MM:
        raise FitQuestion(
            f"this hand would be {length:.0f} mm long from wrist to finger tip (adults: 150 to 220 mm); check the scale: the "
            "clicks on the ruler and the distance between them, centimetres or inches, or the coin; or say sure=True if it is right",
            choices=({"sure": True},),
        )


def require_scale(scale: Scale) -> None:
    """Ask about a coin or card whose outline is not clear enough."""
    if scale.how.startswith(("coin", "card")) and scale.uncertainty > UNCLEAR:
        raise FitQuestion(
            f"the outline of the {scale.how[:4]} is not clear: lengths may be {100 * scale.uncertainty:.1f} % off; click two marks of a "
            "ruler instead, or lay it on a plain ground of another colour, near the hand; or say sure=True if it is good enough",
            choices=({"sure": True},),
        )


def require_inside(clicks: Mapping[str, tuple[float, float]], width: int, height: int) -> None:
    """Refuse points outside the picture."""
    outside = tuple(name for name, (x, y) in clicks.items() if not (0.0 <= x <= width and 0.0 <= y <= height))
    if outside:
        x, y = clicks[outside[0]]
        raise FitError(
            f"{outside[0]} at ({x:.0f}, {y:.0f}) lies outside the picture of {width} x {height} pixels; click it again", clicks, outside
        )


def require_labels(hand: Hand, names: tuple[str, ...], picture: Array) -> None:
    """Refuse exchanged labels, whichever hand it is: ``picture`` (N, 2) mm, y upwards."""
    source = flat_source(hand, "palmar", names)
    given = min((similarity(source, picture, mirror=mirror) for mirror in (False, True)), key=lambda found: found.scatter)
    if given.scatter <= WORSE_THAN * given.scale * hand_length_mm(hand):
        return
    swap, better = min((best_exchange(names, source, picture, mirror) for mirror in (False, True)), key=lambda found: found[1])
    if given.scatter > BETTER * better and better < without_one(source, picture):
        raise FitError(
            f"{swap[0]} and {swap[1]} look exchanged: the points fit a hand much better the other way round "
            f"({better:.0f} instead of {given.scatter:.0f} mm off on average); swap them, or say sure=True",
            names=swap,
        )


def require_together(hand: Hand, view: str, names: tuple[str, ...], picture: Array) -> None:
    """Refuse a single point far off the hand: ``picture`` (N, 2) mm, y upwards, not mirrored."""
    source = flat_source(hand, view, names)
    off = surprise(source, picture)
    worst = int(off.argmax())
    rest = np.delete(np.arange(len(names)), worst) if len(names) > 5 else np.arange(len(names))
    size = similarity(source[rest], picture[rest]).scale * hand_length_mm(hand)
    if off[worst] > FAR_OFF * size:
        raise FitError(
            f"{names[worst]} lies {off[worst]:.0f} mm away from where the other points say it should be; "
            "click it again or leave it out, or say sure=True",
            names=(names[worst],),
        )


def best_exchange(names: tuple[str, ...], source: Array, picture: Array, mirror: bool) -> tuple[tuple[str, str], float]:
    """The two labels, or two fingers, whose exchange makes the points fit best, and the scatter (mm) then."""
    order = list(range(len(names)))
    where = {name: k for k, name in enumerate(names)}
    trials: list[tuple[tuple[str, str], list[tuple[int, int]]]] = [((names[i], names[j]), [(i, j)]) for i, j in combinations(order, 2)]
    for a, b in combinations(FINGERS, 2):
        pairs = [(where[name], where[other]) for name in names if digit_of(name) == a and (other := _same_joint(name, b)) in where]
        if len(pairs) > 1:
            trials.append(((a, b), pairs))
    tried = np.tile(np.arange(len(names)), (len(trials), 1))
    for row, (_, pairs) in zip(tried, trials, strict=True):
        for i, j in pairs:
            row[i], row[j] = row[j], row[i]
    scatter = _scatters(source, picture[tried], mirror)
    best = int(scatter.argmin())
    return trials[best][0], float(scatter[best])


def without_one(source: Array, picture: Array) -> float:
    """The scatter (mm) that is left when the one point is left out without which the others fit best."""
    kept = np.array([np.delete(np.arange(len(source)), k) for k in range(len(source))])
    return float(min(_scatters(source[kept], picture[kept], mirror).min() for mirror in (False, True)))


def _scatters(plane: Array, picture: Array, mirror: bool) -> Array:
    """``similarity(...).scatter`` (T,) of many sets at once, (T, N, 2) or (N, 2) for all."""
    a, b = plane - plane.mean(axis=-2, keepdims=True), picture - picture.mean(axis=-2, keepdims=True)
    across = np.swapaxes(b, -1, -2) @ a
    size = np.linalg.svd(across, compute_uv=False)
    sign = np.sign(np.linalg.det(across)) * (-1.0 if mirror else 1.0)
    same, other = (np.sum(x**2, axis=(-2, -1)) for x in (a, b))
    left = other - (size[..., 0] + sign * size[..., 1]) ** 2 / np.maximum(same, 1e-300)
    return np.asarray(np.sqrt(np.maximum(left, 0.0) / plane.shape[-2]))


def _same_joint(name: str, finger: str) -> str:
    return f"{name.partition('_')[0]}_{finger}"


def surprise(source: Array, picture: Array) -> Array:
    """How far (mm) every point lies from where a smooth warp of all others takes it."""
    flat = np.column_stack([source, np.zeros(len(source))])
    goal = np.column_stack([picture, np.zeros(len(source))])
    off = np.zeros(len(source))
    if len(source) < 5:
        return off
    for k in range(len(source)):
        rest = np.delete(np.arange(len(source)), k)
        off[k] = np.linalg.norm(rbf.warped_numpy(rbf.fitted(flat[rest], goal[rest]), flat[k : k + 1])[0] - goal[k])
    return off


def suspects(hand: Hand, view: str, names: tuple[str, ...], picture: Array, most: int = 3) -> tuple[str, ...]:
    """The points that surprise most."""
    off = surprise(flat_source(hand, view, names), picture)
    return tuple(names[k] for k in np.argsort(-off)[:most])


def remarks(hand: Hand, made: WarpedHand, names: tuple[str, ...], found: Aligned, camera_mm: float | None) -> tuple[str, ...]:
    """What the user should know about a fit that went well."""
    said = []
    bare = [finger for finger in FINGERS if not any(digit_of(name) == finger for name in names)]
    if bare:
        said.append(f"no point on {' and '.join(bare)}: shaped like the neighbours")
    if not any(name.startswith(("wrist", "head")) for name in names):
        said.append("no point at the wrist: wrist and forearm follow the palm")
    if made.bones.repaired:
        said.append(
            f"{', '.join(made.bones.repaired)}: too thin after the warp, rebuilt with the thickness that the size of the hand asks for"
        )
    tilt = np.degrees(np.arccos(np.clip(found.frame.towards @ found.start, -1.0, 1.0)))
    if tilt > 12.0:
        said.append(f"the hand seems tilted by {tilt:.0f} degrees against the picture: heights are less certain")
    if camera_mm is None:
        said.append(FLAT)
    return tuple(said)


def with_camera(said: tuple[str, ...], camera_mm: float | None, how: str) -> tuple[str, ...]:
    """Remarks with what is to be known about the camera, ``how`` as in ``lens.Camera``."""
    if how == "assumed" and camera_mm is not None:
        return (
            *said,
            f"taken by a camera {camera_mm:.0f} mm above the table, as is assumed; give camera_mm= its distance, or None for a scanner",
        )
    if how == "likely by the points" and camera_mm is not None:
        return (*said, f"taken by a camera about {camera_mm:.0f} mm above the table, as the points suggest; give camera_mm= if you know it")
    return tuple(remark for remark in said if remark != FLAT) if how.startswith("a scanner") else said
