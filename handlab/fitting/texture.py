"""The photograph as the skin's colour: projected into the texture of the fine skin, and what the camera did not see filled in.

The texture coordinates of the fine skin are an atlas without overlaps, so every texel belongs to one place of the skin. A texel that the
camera sees squarely takes the colour of its pixel; towards the outline trust fades. Everywhere else the colour is the smoothest
continuation over the skin, drawn to the hand's own mean, with the seen skin's fine grain laid on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from handlab.anatomy.meshes import Array, FineSkin, Index
from handlab.fitting.outline import Mask, hand_mask
from handlab.fitting.pictures import Picture
from handlab.fitting.raster import foremost, pixels

if TYPE_CHECKING:
    from handlab.fitting.result import Fit

SIZE = 1024  # texels on each side of the atlas
SQUARE, GRAZING = 0.45, 0.15  # cosine to the camera above which a texel is trusted fully, below which not at all
IN_FRONT = 0.002  # metres: a surface this far behind what covers its pixel is hidden
HIDING = 1000.0  # what hides what is decided in a picture of about so many pixels on its longer side
RIM_PX, RIM_SHARE = 3.0, 0.006  # so many pixels inside the outline, or this part of the hand's size, show shadow and background
PULL = 0.004  # of the continuation towards the mean colour, per edge: it fades within some 15 edges (25 mm)
GRAIN_PX = 2.5  # structure finer than this many texels is grain
MOST_GRAIN = 6.0  # of 255 levels: stripes and shadows in the picture are no grain
BLEED = 8  # texels around each chart that repeat its edge, so that filtering does not show the seams


@dataclass(frozen=True, eq=False)
class Texture:
    """``pixels`` (size, size, 3) uint8, first row at texture coordinate v = 0 (as glTF has it); ``seen`` (size, size): how far each texel
    comes from the photograph, 0 to 1; ``covered`` (size, size): texels that belong to the skin."""

    pixels: Picture
    seen: NDArray[np.float32]
    covered: Mask

    @property
    def share_seen(self) -> float:
        """The part of the skin's texels that the photograph shows."""
        return float(self.seen[self.covered].mean()) if self.covered.any() else 0.0


def texture_of(fit: Fit, *, size: int = SIZE) -> Texture:
    """The photograph of a finished fit as the texture of its new hand's fine skin.

    Raises ``ValueError`` without pixels, or where hand and background cannot be told apart.
    """
    if fit.pixels is None:
        raise ValueError("the texture needs the picture itself: give fit_photo a file or pixels, not only a size")
    fine = fit.hand.skin_fine
    height = fit.aligned.frame.height(fit.lying(fine.points))
    return project_texture(fine, fit.to_picture(fine.points), height, fit.pixels, hand=hand_mask(fit.pixels, fit.clicks), size=size)


def project_texture(
    skin: FineSkin, points_px: Array, height: Array, picture: Picture, *, hand: Mask | None = None, size: int = SIZE
) -> Texture:
    """The texture of ``skin`` from a photograph.

    ``points_px`` (N, 2): where each point of the skin lies in the picture, (x, y) px; ``height`` (N,) m: how near to the camera, larger is
    nearer; ``picture`` (rows, columns, 3); ``hand``: pixels that show the hand (see ``hand_mask``), so that no background
    is taken for skin. Raises ``ValueError`` where no part of the skin is seen.
    """
    shape = picture.shape[:2]
    if len(points_px) != len(skin.points) or len(height) != len(skin.points):
        raise ValueError(
            f"there are {len(skin.points)} points of skin, but {len(points_px)} places in the picture and {len(height)} heights"
        )
    row, column, triangle, share = pixels(skin.texture * size, skin.faces, (size, size))
    corners = skin.faces[triangle]
    place = (share[:, :, None] * points_px[corners]).sum(axis=1)
    level = (share * height[corners]).sum(axis=1)
    trust = _facing(skin, height)[triangle]
    inside = (place[:, 0] >= 0) & (place[:, 0] < shape[1]) & (place[:, 1] >= 0) & (place[:, 1] < shape[0])
    at = np.clip(place[:, ::-1].astype(np.int64), 0, np.array(shape) - 1)
    step = max(1.0, max(shape) / HIDING)
    _, front = foremost(points_px / step, height, skin.faces, (int(shape[0] / step) + 1, int(shape[1] / step) + 1))
    cell = (at / step).astype(np.int64)
    trust = trust * inside * (level > front[cell[:, 0], cell[:, 1]] - IN_FRONT)
    if hand is not None:
        trust = trust * _well_inside(hand)[at[:, 0], at[:, 1]]
    colour = _bilinear(picture, place)
    if trust.max(initial=0.0) <= 0.0:
        raise ValueError("the picture shows no part of this skin; check that picture and hand belong together")
    skin_colour, mean = _continued(skin, corners, share, trust, colour)
    guess = (share[:, :, None] * skin_colour[corners]).sum(axis=1)
    sheet, seen, covered = np.zeros((size, size, 3)), np.zeros((size, size), np.float32), np.zeros((size, size), bool)
    sheet[row, column] = trust[:, None] * colour + (1 - trust[:, None]) * guess
    seen[row, column], covered[row, column] = trust, True
    sheet = _with_grain(sheet, seen, covered)
    return Texture(_bled(sheet, covered, mean), seen, covered)


def _facing(skin: FineSkin, height: Array) -> Array:
    """How far each triangle (M,) faces the camera squarely enough to be trusted, 0 to 1; ``height`` grows towards the camera."""
    a, b, c = (skin.points[skin.faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    towards = np.linalg.lstsq(np.c_[skin.points, np.ones(len(skin.points))], height, rcond=None)[0][:3]
    cosine = normal @ towards / np.maximum(np.linalg.norm(normal, axis=1) * np.linalg.norm(towards), 1e-30)
    x = np.clip((cosine - GRAZING) / (SQUARE - GRAZING), 0.0, 1.0)
    result: Array = x * x * (3 - 2 * x)
    return result


def _well_inside(hand: Mask) -> Array:
    """0 outside the hand and at its outline, 1 a few pixels inside."""
    from scipy.ndimage import distance_transform_edt

    rows, columns = np.flatnonzero(hand.any(axis=1)), np.flatnonzero(hand.any(axis=0))
    if not len(rows):
        return np.zeros(hand.shape)
    rim = max(RIM_PX, RIM_SHARE * float(max(np.ptp(rows), np.ptp(columns))))
    inside: Array = np.clip(distance_transform_edt(hand) / rim - 1.0, 0.0, 1.0)
    return inside


def _bilinear(picture: Picture, place: Array) -> Array:
    """Colours (K, 3) at places (K, 2) px; beyond the edge that of the edge."""
    rows, columns = picture.shape[:2]
    x, y = np.clip(place[:, 0] - 0.5, 0, columns - 1), np.clip(place[:, 1] - 0.5, 0, rows - 1)
    x0, y0 = np.minimum(x.astype(np.int64), max(columns - 2, 0)), np.minimum(y.astype(np.int64), max(rows - 2, 0))
    u, v = (x - x0)[:, None], (y - y0)[:, None]
    x1, y1 = np.minimum(x0 + 1, columns - 1), np.minimum(y0 + 1, rows - 1)
    upper = (1 - u) * picture[y0, x0] + u * picture[y0, x1]
    result: Array = (1 - v) * upper + v * ((1 - u) * picture[y1, x0] + u * picture[y1, x1])
    return result


def _continued(skin: FineSkin, corners: Index, share: Array, trust: Array, colour: Array) -> tuple[Array, Array]:
    """A colour for every point (N, 3): seen colours where there are any, elsewhere the smoothest continuation; and the mean colour."""
    from scipy.sparse import coo_matrix, diags
    from scipy.sparse.linalg import spsolve

    n = len(skin.points)
    weight, total = np.zeros(n), np.zeros((n, 3))
    for i in range(3):
        np.add.at(weight, corners[:, i], trust * share[:, i])
        np.add.at(total, corners[:, i], (trust * share[:, i])[:, None] * colour)
    mean = total.sum(axis=0) / weight.sum()
    known = np.minimum(weight / max(float(np.median(weight[weight > 0])), 1e-12), 1.0)
    own = total / np.maximum(weight, 1e-12)[:, None]
    a, b = np.vstack([skin.faces[:, [0, 1]], skin.faces[:, [1, 2]], skin.faces[:, [2, 0]]]).T
    joined = coo_matrix((np.ones(len(a)), (a, b)), shape=(n, n)).tocsr()
    joined = (joined + joined.T) / 2
    degree = np.asarray(joined.sum(axis=1)).ravel()
    system: Any = diags(degree + PULL * degree + 10.0 * known) - joined
    solved: Any = spsolve(system.tocsc(), 10.0 * known[:, None] * own + (PULL * degree)[:, None] * mean)
    result: Array = np.clip(np.asarray(solved), 0.0, 255.0)
    return result, mean


def _with_grain(sheet: Array, seen: NDArray[np.float32], covered: Mask) -> Array:
    """Unseen skin with as much fine structure as the seen skin has: without it, it would look like plastic."""
    from scipy.ndimage import gaussian_filter

    good = seen > 0.95
    if good.sum() < 1000:
        return sheet
    tone = sheet.mean(axis=2)
    smooth = gaussian_filter(tone * good, GRAIN_PX) / np.maximum(gaussian_filter(good.astype(np.float64), GRAIN_PX), 1e-6)
    strength = min(float(np.median(np.abs(tone - smooth)[good])) / 0.6745, MOST_GRAIN)
    noise = gaussian_filter(np.random.default_rng(26).standard_normal(tone.shape), 0.8)  # the same each time
    grain = strength * noise / noise.std()
    result: Array = sheet + ((1 - seen) * covered * grain)[:, :, None]
    return result


def _bled(sheet: Array, covered: Mask, mean: Array) -> Picture:
    """Bytes; around each chart its edge is repeated for a few texels, all else has the mean colour."""
    from scipy.ndimage import distance_transform_edt

    away, nearest = distance_transform_edt(~covered, return_indices=True)
    filled = np.where((away <= BLEED)[:, :, None], sheet[nearest[0], nearest[1]], mean)
    return np.clip(np.round(filled), 0, 255).astype(np.uint8)
