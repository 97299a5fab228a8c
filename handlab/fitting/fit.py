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
from handlab.fitting.alignment import Aligned, aligned, aligned_printed, conclude
from handlab.fitting.bones import FoldedWarp
from handlab.fitting.calibration import Scale, as_scale
from handlab.fitting.landmarks import checked, source_points
from handlab.fitting.lifting import from_far, lift
from handlab.fitting.mistakes import FitError, FitQuestion
from handlab.fitting.posing import reposed
from handlab.fitting.result import Fit
from handlab.fitting.warp import MECHANICS, Mechanics, WarpedHand, landmark_warp, overall, warp_hand

Rule = Literal["least squares", "printed"]
RULES = ("least squares", "printed")


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
    camera_mm: float | None = None,
    centre_px: ArrayLike | None = None,
    sure: bool = False,
    name: str = "",
) -> Fit:
    """A hand like ``hand`` (the reference hand) with its feature points where they were clicked (section 5).

    ``points_px``: name -> (x, y) in pixels, y downwards (see ``landmarks.LANDMARKS``), or a file of them; any subset that determines the
    warp, at least four. ``mm_per_px``: a number or what ``calibration.as_scale`` takes. ``view`` "palmar" or "dorsal", ``side`` "right" or
    "left": one of the two; the other one is concluded. ``mirror``: the picture is mirrored. ``rule``: "least squares", or "printed" as in the
    paper. ``mechanics``: "scaled" or "kept" (see ``warp_hand``). ``camera_mm``: distance of the camera from the table, if known: takes out
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
            plausible.require_size(hand, names, picture)
        own, concluded = conclude(hand, names, picture, view=view, side=side, mirror=mirror)
        flip = np.array([-1.0, 1.0]) if mirror else np.ones(2)
        picture = picture * flip
        if not sure:
            plausible.require_labels(own, concluded, names, picture)
        found = _aligned(own, concluded, names, picture, rule)
        if camera_mm is not None:
            if not np.isfinite(camera_mm) or camera_mm < 150.0:
                raise ValueError(f"camera_mm is {camera_mm!r}; give the distance from camera to table in millimetres, such as 600")
            middle = px.mean(axis=0) if centre_px is None else np.asarray(centre_px, dtype=np.float64)
            middle = picture_mm(middle, scale.mm_per_px) * flip
            for _ in range(3):
                far = from_far(found, picture, middle, camera_mm)
                found = _aligned(own, concluded, names, far, rule)
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
        again = FitQuestion(str(error), clicks, error.names, choices) if isinstance(error, FitQuestion) else FitError(str(error), clicks, error.names)
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
        warnings=plausible.remarks(own, made, names, found),
    )


def fit_photo(
    picture: str | os.PathLike[str] | bytes | NDArray[Any] | tuple[int, int],
    *,
    landmarks: Mapping[str, Any] | str | os.PathLike[str],
    scale: Any,
    hand: Hand | None = None,
    centre_px: ArrayLike | None = None,
    sure: bool = False,
    **options: Any,
) -> Fit:
    """A hand from a photograph: ``hl.fit_photo("me.jpg", landmarks="me.csv", scale={"ruler": [(x, y), (x, y)], "mm": 200}, view="palmar")``.

    ``picture``: a file, its bytes, its pixels, or only its size (width, height). ``landmarks``: clicks or a file of them. ``scale``: a number of
    millimetres per pixel, two clicks on a ruler, one on a coin or a card (see ``calibration.as_scale``). ``hand``: what is warped, the
    reference hand if not given. All other arguments as for ``fit_points``. The result has ``hand``, ``report()``, ``side``, and with pixels
    ``outline`` and ``iou``. Nothing is written anywhere.
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
        found_scale = as_scale(scale, pixels)
    except ValueError as error:
        raise FitError(str(error), clicks) from error
    if not sure:
        plausible.require_inside(clicks, width, height)
    middle = np.array([width, height]) / 2.0 if centre_px is None else centre_px
    fit = fit_points(load_hand() if hand is None else hand, clicks, found_scale, centre_px=middle, sure=sure, **options)
    return fit.with_picture(pixels, (width, height))


def warp_to(
    hand: Hand,
    target: Mapping[str, ArrayLike],
    *,
    view: str,
    rule: Rule = "least squares",
    mechanics: Mechanics = "scaled",
    name: str = "",
) -> WarpedHand:
    """The same warp for feature points known in space: name -> (3,) m, in any frame of the same handedness."""
    names = tuple(target)
    source = source_points(hand, view, names)
    goal = np.array([np.asarray(target[name], dtype=np.float64) for name in names])
    from handlab.fitting.alignment import fitting_plane

    towards = fitting_plane(source_points(hand, view), view).towards
    return warp_hand(hand, landmark_warp(source, goal, towards, rule=rule), overall(source, goal, towards)[0], name=name, mechanics=mechanics)


def picture_mm(px: Array, mm_per_px: float) -> Array:
    """Places (..., 2) in millimetres, y upwards, from pixels, y downwards."""
    result: Array = px * np.array([mm_per_px, -mm_per_px])
    return result


def _aligned(hand: Hand, view: str, names: tuple[str, ...], picture: Array, rule: Rule) -> Aligned:
    if rule == "printed":
        return aligned_printed(hand, view, names, picture)
    return reposed(aligned(hand, view, names, picture), names, picture)


def _origin(names: tuple[str, ...], view: str, side: str, scale: Scale, rule: str, mechanics: str) -> str:
    return (
        f"warped from the reference hand to {len(names)} points of a picture of a {side} hand ({view}), {scale.mm_per_px:.6g} mm per pixel "
        f"({scale.how}); rule {rule}, mechanics {mechanics}"
    )


__all__ = ["MECHANICS", "RULES", "FitError", "FitQuestion", "Scale", "fit_photo", "fit_points", "picture_mm", "warp_to"]
