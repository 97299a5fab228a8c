"""``fit_points``: from clicks to a hand. ``fit_photo``: the same with a picture at hand."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Array, Hand
from handlab.fitting import plausible
from handlab.fitting.alignment import Aligned, aligned, aligned_printed, conclude, likely_view
from handlab.fitting.bones import FoldedWarp
from handlab.fitting.calibration import Scale, as_scale, confirmed
from handlab.fitting.landmarks import MARKS, checked, source_points
from handlab.fitting.lens import Camera, camera
from handlab.fitting.lifting import from_far, lift
from handlab.fitting.mistakes import FitError, FitQuestion
from handlab.fitting.posing import reposed
from handlab.fitting.result import Fit
from handlab.fitting.warp import MECHANICS, Mechanics, WarpedHand, landmark_warp, overall, warp_hand

Rule = Literal["least squares", "printed"]
RULES = ("least squares", "printed")
# Stored points are what was clicked where they scatter less than this share of the exact ones (an assumption).
FAR_BETTER = 0.5


def fit_points(
    hand: Hand,
    points_px: Mapping[str, Any] | str | os.PathLike[str],
    mm_per_px: Any,
    *,
    view: str | None = None,
    side: str | None = None,
    mirror: bool = False,
    rule: Rule = "least squares",
    mechanics: Mechanics = "scaled",
    marks: str | None = None,
    camera_mm: float | None = None,
    centre_px: ArrayLike | None = None,
    sure: bool = False,
    name: str = "",
) -> Fit:
    """A hand like ``hand`` (the reference hand) with its feature points where they were clicked (section 5).

    ``points_px``: name -> (x, y) in pixels, y downwards (see ``landmarks.LANDMARKS``), or a file of them; any subset that determines the
    warp, at least four. ``mm_per_px``: a number or what ``calibration.as_scale`` takes. ``view`` "palmar" or "dorsal", ``side`` "right" or
    "left": one of the two, the other is concluded. ``mirror``: the picture is mirrored. ``rule``: "least squares", or "printed" as in the
    paper. ``mechanics``: "scaled" or "kept" (see ``warp_hand``). ``marks``: "exact" (joints right above their centres), "stored" (points of
    the even skin, up to 3 mm beside), or whichever fits. ``camera_mm``: distance of the camera from the table, if known: takes out
    perspective, about ``centre_px`` (the middle of the picture). ``sure``: neither sizes nor labels are questioned.

    Raises ``FitError`` (a ``ValueError`` that carries the clicks) for points that cannot be right, and says what to do; ``FitQuestion``
    where an answer is needed first; ``UnknownName`` for a name that is no feature point.
    """
    if rule not in RULES:
        raise ValueError(f"rule is {rule!r}; it must be 'least squares' or 'printed'")
    if mechanics not in MECHANICS:
        raise ValueError(f"mechanics is {mechanics!r}; it must be 'scaled' or 'kept'")
    scale = as_scale(mm_per_px)
    clicks = checked(points_px)
    names = tuple(clicks)
    px = np.array(list(clicks.values()))
    try:
        picture = picture_mm(px, scale.mm_per_px)
        if not sure:
            plausible.require_scale(scale)
            plausible.require_size(hand, names, picture)
            plausible.require_labels(hand, names, picture)
        own, concluded = conclude(hand, names, picture, view=view, side=side, mirror=mirror)
        flip = np.array([-1.0, 1.0]) if mirror else np.ones(2)
        picture = picture * flip
        if not sure:
            plausible.require_together(own, concluded, names, picture)
        found = aligned_marks(own, concluded, names, picture, rule, marks)
        if camera_mm is not None:
            if not np.isfinite(camera_mm) or camera_mm < 150.0:
                raise ValueError(f"camera_mm is {camera_mm!r}; give the distance from camera to table in millimetres, such as 600")
            middle = px.mean(axis=0) if centre_px is None else np.asarray(centre_px, dtype=np.float64)
            middle = picture_mm(middle, scale.mm_per_px) * flip
            for _ in range(4):
                far = from_far(found, picture, middle, camera_mm)
                found = aligned_marks(own, concluded, names, far, rule, marks)
            picture = far
        lifted = lift(found, picture)
        warp = landmark_warp(found.source, lifted.target, found.frame.towards, rule=rule)
        made = warp_hand(found.hand, warp, found.fit.scale, name=name or "from a photograph", mechanics=mechanics)
    except FoldedWarp as error:
        raise FitError(str(error), clicks, plausible.suspects(own, concluded, names, picture)) from error
    except FitError as error:
        if error.landmarks:
            raise
        choices = error.choices if isinstance(error, FitQuestion) else ()
        again = (
            FitQuestion(str(error), clicks, error.names, choices)
            if isinstance(error, FitQuestion)
            else FitError(str(error), clicks, error.names)
        )
        raise again from None
    made_hand = made.hand.with_(sources={**hand.sources, "shape": _origin(names, concluded, own.side, scale, rule, mechanics)})
    return Fit(
        hand=made_hand,
        reference=own,
        view=concluded,
        names=names,
        clicks=px,
        scale=scale,
        rule=rule,
        mechanics=mechanics,
        aligned=found,
        target=lifted.target,
        warped=made,
        camera_mm=camera_mm,
        centre_px=None if centre_px is None else np.asarray(centre_px, dtype=np.float64),
        mirror=mirror,
        warnings=plausible.remarks(own, made, names, found, camera_mm),
    )


def fit_photo(
    picture: str | os.PathLike[str] | bytes | NDArray[Any] | tuple[int, int],
    *,
    landmarks: Mapping[str, Any] | str | os.PathLike[str],
    scale: Any,
    hand: Hand | None = None,
    camera_mm: float | Literal["auto"] | None = "auto",
    centre_px: ArrayLike | None = None,
    sure: bool = False,
    outline: bool = True,
    **options: Any,
) -> Fit:
    """A hand from a photograph.

    ``hl.fit_photo("me.jpg", landmarks="me.csv", scale={"ruler": [(x, y), (x, y)], "mm": 200}, view="palmar")``

    ``picture``: a file, its bytes, its pixels, or only its size (width, height). ``landmarks``: clicks or a file of them. ``scale``:
    a number of millimetres per pixel, two clicks on a ruler, one on a coin or a card (see ``calibration.as_scale``). ``hand``: what is
    warped, the reference hand if not given. ``camera_mm``: distance of the camera from the table, None for a scanner; "auto": by the focal
    length in the file, none for a file whose dots per inch are those of a scanner, else 600 mm (see ``lens.camera``; a remark says so), for
    the back of a hand also by its points (see ``distance``). ``outline``: where there are pixels, and hand and background differ, the skin
    is brought to the outline in the picture too (see ``outlined``); False, or the rule "printed": the points alone shape the hand.
    All other arguments as for ``fit_points``. The result has ``hand``, ``report()``, ``side``, and with pixels ``outline`` and ``iou``.
    Nothing is written anywhere.
    """
    pixels: NDArray[Any] | None = None
    if isinstance(picture, tuple):
        width, height = (int(value) for value in picture)
    else:
        from handlab.fitting.pictures import load_picture

        pixels = load_picture(picture)
        height, width = pixels.shape[:2]
    clicks = checked(landmarks)
    try:
        found_scale = confirmed(as_scale(scale, pixels), picture, camera_mm)
    except ValueError as error:
        raise FitError(str(error), clicks) from error
    if not sure:
        plausible.require_inside(clicks, width, height)
    middle = np.array([width, height]) / 2.0 if centre_px is None else centre_px
    seen = camera(picture, found_scale.mm_per_px, (width, height)) if camera_mm == "auto" else Camera(camera_mm, "given")
    own = load_hand() if hand is None else hand
    if seen.how == "assumed":
        from handlab.fitting.distance import camera_by_points

        seen = camera_by_points(own, clicks, found_scale.mm_per_px, middle, **options) or seen
    fit = fit_points(own, clicks, found_scale, camera_mm=seen.distance_mm, centre_px=middle, sure=sure, **options)
    fit = fit.with_picture(pixels, (width, height), seen.how)
    if pixels is None or not outline or fit.rule == "printed":
        return fit
    from handlab.fitting.outlined import outlined

    return outlined(fit)


def warp_to(
    hand: Hand,
    target: Mapping[str, ArrayLike],
    *,
    view: str,
    rule: Rule = "least squares",
    mechanics: Mechanics = "scaled",
    marks: str = "exact",
    name: str = "",
) -> WarpedHand:
    """The same warp for feature points known in space: name -> (3,) m, in any frame of the same handedness; ``marks`` as above."""
    names = tuple(target)
    source = source_points(hand, view, names, marks)
    goal = np.array([np.asarray(target[name], dtype=np.float64) for name in names])
    towards = likely_view(hand, view)
    towards = towards / np.linalg.norm(towards)
    return warp_hand(
        hand, landmark_warp(source, goal, towards, rule=rule), overall(source, goal, towards)[0], name=name, mechanics=mechanics
    )


def picture_mm(px: Array, mm_per_px: float) -> Array:
    """Places (..., 2) in millimetres, y upwards, from pixels, y downwards."""
    result: Array = px * np.array([mm_per_px, -mm_per_px])
    return result


def aligned_marks(hand: Hand, view: str, names: tuple[str, ...], picture: Array, rule: str, marks: str | None) -> Aligned:
    """Aligned by ``rule``. Without ``marks``: people click above the joints, so those marks count unless the stored ones fit far better."""
    if rule == "printed":
        return aligned_printed(hand, view, names, picture, marks or "stored")
    if marks is not None:
        return reposed(aligned(hand, view, names, picture, marks), names, picture)
    exact, stored = (aligned(hand, view, names, picture, kind) for kind in MARKS)
    return reposed(stored if stored.fit.scatter < FAR_BETTER * exact.fit.scatter else exact, names, picture)


def _origin(names: tuple[str, ...], view: str, side: str, scale: Scale, rule: str, mechanics: str) -> str:
    return (
        f"warped from the reference hand to {len(names)} points of a picture of a {side} hand ({view}), {scale.mm_per_px:.6g} mm per pixel "
        f"({scale.how}); rule {rule}, mechanics {mechanics}"
    )


__all__ = ["MECHANICS", "RULES", "FitError", "FitQuestion", "Scale", "fit_photo", "fit_points", "picture_mm", "warp_to"]
