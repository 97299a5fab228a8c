"""What a fit will look like, quickly enough for an answer to every click: alignment, lifting and warp of the skin, no new hand yet."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand
from handlab.fitting import plausible
from handlab.fitting.alignment import conclude
from handlab.fitting.calibration import Scale
from handlab.fitting.fit import aligned_marks, picture_mm
from handlab.fitting.landmarks import NAMES, checked, source_points
from handlab.fitting.lifting import from_far, lift
from handlab.fitting.outline import contour, distal_of, overlap, silhouette
from handlab.fitting.result import WRIST, Fit
from handlab.fitting.warp import WarpedHand, landmark_warp

TWICE = 2  # rounds of taking out perspective: within 0.2 mm of the four that a fit takes
CELLS = 100_000  # of the grid in which the outline is looked for
SMOOTH = 5  # corners of the stairs over which an outline is averaged, of which every third is kept


class Sketch(NamedTuple):
    """``outline`` (K, 2) px of the warped skin; ``places``: name -> (x, y) px, where its 26 points lie; which hand it is;
    ``skin`` (N, 2) px and ``faces`` of its fine skin."""

    outline: Array
    places: Mapping[str, tuple[float, float]]
    side: str
    view: str
    skin: Array
    faces: NDArray[np.int64]

    def iou(self, shown: NDArray[np.bool_], step: float) -> float:
        """Overlap beyond the wrist with the pixels ``shown`` of a picture that was reduced by ``step``."""
        drawn = silhouette(self.skin / step, self.faces, (shown.shape[0], shown.shape[1]))
        edge = np.array([self.places[name] for name in WRIST]) / step
        return overlap(drawn, shown, distal_of(edge[:2], edge[2], (shown.shape[0], shown.shape[1])))


def sketch(
    hand: Hand,
    landmarks: Mapping[str, ArrayLike | None],
    scale: Scale,
    *,
    view: str | None = None,
    side: str | None = None,
    mirror: bool = False,
    camera_mm: float | None = None,
    centre_px: ArrayLike | None = None,
    sure: bool = False,
) -> Sketch:
    """The skin of ``hand`` warped to ``landmarks``; arguments and errors as for ``fit_points``, but a bone that folds is not noticed."""
    clicks = checked(landmarks)
    names, px = tuple(clicks), np.array(list(clicks.values()))
    picture = picture_mm(px, scale.mm_per_px)
    if not sure:
        plausible.require_size(hand, names, picture)
        plausible.require_labels(hand, names, picture)
    own, seen = conclude(hand, names, picture, view=view, side=side, mirror=mirror)
    flip = np.array([-1.0 if mirror else 1.0, 1.0])
    picture = picture * flip
    if not sure:
        plausible.require_together(own, seen, names, picture)
    found = aligned_marks(own, seen, names, picture, "least squares", None)
    centre = px.mean(axis=0) if centre_px is None else np.asarray(centre_px, dtype=np.float64)
    if camera_mm is not None:
        far = picture
        for _ in range(TWICE):
            far = from_far(found, picture, picture_mm(centre, scale.mm_per_px) * flip, camera_mm)
            found = aligned_marks(own, seen, names, far, "least squares", found.marks)  # which marks were meant is known by now
        picture = far
    target = lift(found, picture).target
    warp = landmark_warp(found.source, target, found.frame.towards)
    shape = WarpedHand(found.hand, warp, np.eye(3), np.zeros(3), None)  # type: ignore[arg-type]  # no bones were checked
    fit = Fit(
        hand=found.hand, reference=own, view=seen, names=names, clicks=px, scale=scale, rule="least squares", mechanics="kept",
        aligned=found, target=target, warped=shape, camera_mm=camera_mm, centre_px=centre, mirror=mirror,
    )  # fmt: skip
    fine = found.hand.skin_fine
    skin = fit.to_picture(warp(fine.points))
    places = fit.to_picture(warp(source_points(found.hand, seen, NAMES, found.marks)))
    return Sketch(
        outline_of(skin, fine.faces),
        dict(zip(NAMES, ((float(x), float(y)) for x, y in places), strict=True)),
        own.side, seen, skin, fine.faces,
    )  # fmt: skip


def outline_of(skin: Array, faces: NDArray[np.int64], cells: int = CELLS) -> Array:
    """The outer outline (K, 2) px of a skin in the picture's plane, smoothed over the stairs of a grid of so many ``cells``."""
    low, high = skin.min(axis=0), skin.max(axis=0)
    step = max(float(np.sqrt(np.prod(high - low) / cells)), 0.25)
    low, high = low - 2 * step, high + 2 * step
    columns, rows = (int(n) for n in np.ceil((high - low) / step))
    stairs = contour(silhouette((skin - low) / step, faces, (rows, columns)))
    mean = np.mean([np.roll(stairs, k - SMOOTH // 2, axis=0) for k in range(SMOOTH)], axis=0)
    result: Array = mean[::3] * step + low
    return result
