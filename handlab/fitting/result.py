"""A finished fit: the hand, what was concluded on the way, and where everything lies in the picture."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy.records import Array, Hand
from handlab.fitting.alignment import Aligned
from handlab.fitting.calibration import Scale
from handlab.fitting.lifting import lowest, seen_by
from handlab.fitting.plausible import with_camera
from handlab.fitting.warp import Edge, Mechanics, WarpedHand

if TYPE_CHECKING:
    from handlab.fitting.report import Report

MOST_PIXELS_OF_OUTLINE = 4_000_000
WRIST = ("wrist_radial", "wrist_ulnar", "mcp_middle")  # a line, and a point on the hand's side of it


@dataclass(frozen=True, eq=False)
class Fit:
    """A hand from clicks. ``hand``: ready to move. ``reference``: the hand it was warped from, of the same side.

    ``view`` "palmar" or "dorsal"; ``names`` and ``clicks`` (N, 2) px; ``scale``; ``target`` (N, 3) m the lifted points in the frame of the
    reference; ``aligned`` how the clicks lay on it; ``edge`` the points that came from the outline, if any; ``camera`` tells how its
    distance ``camera_mm`` is known; ``warnings`` what to know; ``pixels`` and ``size`` (width, height) of the picture.
    """

    hand: Hand
    reference: Hand = field(repr=False)
    view: str
    names: tuple[str, ...] = field(repr=False)
    clicks: Array = field(repr=False)
    scale: Scale
    rule: str
    mechanics: Mechanics
    aligned: Aligned = field(repr=False)
    target: Array = field(repr=False)
    warped: WarpedHand = field(repr=False)
    edge: Edge | None = field(default=None, repr=False)
    camera_mm: float | None = None
    camera: str = "given"
    centre_px: Array | None = None
    mirror: bool = False
    warnings: tuple[str, ...] = ()
    pixels: NDArray[Any] | None = field(default=None, repr=False)
    size: tuple[int, int] | None = None

    @property
    def side(self) -> str:
        """Which hand the picture shows: "right" or "left"."""
        return self.hand.side

    @property
    def growth(self) -> float:
        """L: how many times as large as the reference hand."""
        return self.aligned.fit.scale

    @property
    def landmarks(self) -> dict[str, tuple[float, float]]:
        """The clicks, as they were given."""
        return {name: (float(x), float(y)) for name, (x, y) in zip(self.names, self.clicks, strict=True)}

    def report(self) -> Report:
        """Segment lengths beside the reference hand, how strength grows, side, scale and warnings; prints as a table."""
        from handlab.fitting.report import report

        return report(self)

    def with_picture(self, pixels: NDArray[Any] | None, size: tuple[int, int], camera: str = "given") -> Fit:
        """The same fit with the picture at hand; ``camera``: how its distance is known."""
        return replace(self, pixels=pixels, size=size, camera=camera, warnings=with_camera(self.warnings, self.camera_mm, camera))

    def lying(self, points: ArrayLike) -> Array:
        """Points (N, 3) m of the new hand, as it is stored, in the frame of the reference hand, where the clicks were lifted."""
        result: Array = np.asarray(points, dtype=np.float64) @ self.warped.rotation + self.warped.origin
        return result

    def to_picture(self, points: ArrayLike) -> Array:
        """Pixels (N, 2) where points (N, 3) m of the new hand, as it is stored, lie in the picture."""
        return self.seen(self.lying(points))

    def seen(self, world: Array) -> Array:
        """Pixels (N, 2) where points (N, 3) m in the frame of the reference hand lie in the picture."""
        px: Array = self._flat_mm(world) * self._upright / self.scale.mm_per_px
        return px

    def beside(self, world: Array, px: Array) -> Array:
        """Points (N, 3) m moved across the line of sight by ``px`` (N, 2) pixels."""
        frame, near = self.aligned.frame, np.ones(len(world))
        if self.camera_mm is not None:
            near = 1.0 - 1e3 * (frame.height(world) - lowest(self.aligned)) / self.camera_mm
        flat = 1e-3 * self.scale.mm_per_px * near[:, None] * (px * self._upright) @ self.aligned.fit.matrix
        moved: Array = world + flat @ np.stack([frame.across, frame.up])
        return moved

    @property
    def _upright(self) -> Array:
        """From pixels, y downwards, to a picture that is not mirrored, y upwards, and back."""
        return np.array([-1.0 if self.mirror else 1.0, -1.0])

    def _flat_mm(self, world: Array) -> Array:
        """Places (N, 2) mm, y upwards, in a picture that is not mirrored."""
        frame, fit = self.aligned.frame, self.aligned.fit
        middle = frame.flat(self.aligned.source).mean(axis=0)
        clicked = self.clicks * self._upright * self.scale.mm_per_px
        if self.camera_mm is None:
            flat: Array = clicked.mean(axis=0) + 1e3 * (frame.flat(world) - middle) @ fit.matrix.T
            return flat
        centre = self._camera_centre()
        lifted = frame.flat(self.target)
        far = np.linalg.lstsq(np.ones((len(lifted), 1)), self._seen_from_far(clicked) - 1e3 * (lifted - middle) @ fit.matrix.T, rcond=None)[
            0
        ][0]
        flat = far + 1e3 * (frame.flat(world) - middle) @ fit.matrix.T
        table = lowest(self.aligned)
        return seen_by(flat, 1e3 * (frame.height(world) - table), centre, self.camera_mm)

    def _camera_centre(self) -> Array:
        centre = self.clicks.mean(axis=0) if self.centre_px is None else self.centre_px
        place: Array = centre * self._upright * self.scale.mm_per_px
        return place

    def _seen_from_far(self, clicked: Array) -> Array:
        from handlab.fitting.lifting import from_far

        assert self.camera_mm is not None
        return from_far(self.aligned, clicked, self._camera_centre(), self.camera_mm)

    def coloured(self) -> Hand:
        """The hand in the colours of the photograph: views, films and ``hl.save(hand, "me.glb")`` show them, and its files keep them.

        Raises ``ValueError`` without pixels, or where the hand cannot be told from the background.
        """
        from handlab.fitting.texture import texture_of

        return self.hand.with_(picture=texture_of(self).pixels)

    @cached_property
    def outline(self) -> Array:
        """The outline (K, 2) px of the new hand over the picture, closed."""
        from handlab.fitting.outline import contour

        mask, step, corner = self._covered()
        return contour(mask) * step + corner

    @cached_property
    def iou(self) -> float:
        """Overlap of the new hand and the hand in the picture beyond the wrist: intersection over union, 0 to 1.

        Raises ``ValueError`` without pixels, or where the hand cannot be told from the background.
        """
        from handlab.fitting.outline import small_mask

        if self.pixels is None:
            raise ValueError("the overlap needs the picture itself: give fit_photo a file or pixels, not only a size")
        return self.overlap(*small_mask(self.pixels, self.clicks))

    def overlap(self, shown: NDArray[np.bool_], step: float) -> float:
        """The same with the squares ``shown`` of ``step`` pixels that show the hand in the picture."""
        from handlab.fitting.outline import overlap, silhouette

        drawn = silhouette(self.to_picture(self.hand.skin_fine.points) / step, self.hand.skin_fine.faces, (shown.shape[0], shown.shape[1]))
        return overlap(drawn, shown, self.beyond_wrist(shown, step))

    def beyond_wrist(self, shown: NDArray[np.bool_], step: float) -> NDArray[np.bool_]:
        """Squares of ``step`` pixels that lie on the hand's side of the wrist."""
        from handlab.fitting.outline import distal_of

        index = [self.hand.feature_points[name][self.view] for name in WRIST]
        edge = self.to_picture(self.hand.skin.points[index]) / step
        return distal_of(edge[:2], edge[2], (shown.shape[0], shown.shape[1]))

    def _covered(self) -> tuple[NDArray[np.bool_], float, Array]:
        """Mask of the new hand, the pixels per cell, and the place of its first corner."""
        from handlab.fitting.outline import silhouette

        px = self.to_picture(self.hand.skin_fine.points)
        low, high = px.min(axis=0) - 2.0, px.max(axis=0) + 2.0
        step = max(1.0, float(np.sqrt(np.prod(high - low) / MOST_PIXELS_OF_OUTLINE)))
        shape = tuple(int(n) for n in np.ceil((high - low) / step)[::-1])
        return silhouette((px - low) / step, self.hand.skin_fine.faces, (shape[0], shape[1])), step, low


__all__ = ["Fit"]
