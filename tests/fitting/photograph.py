"""Photographs of known people: a pinhole camera 60 cm above the table, or a flatbed, with a ruler beside the hand.

A picture is computed from the person's own skin; the clicks are the projections of the person's own marks, with noise. Nothing of
``handlab.fitting`` takes part but the cutting of triangles into pixels.
"""

from dataclasses import dataclass

import numpy as np

from handlab.fitting.raster import foremost

DISTANCE = 0.60  # metres from the camera to the table
PX_PER_MM = 4.0  # on the table: 100 dots per inch, a quarter of what a telephone gives
MARGIN_MM = 18.0
RULER_MM = 150.0
SKIN, PAPER = np.array([0.80, 0.60, 0.50]), np.array([0.96, 0.96, 0.92])
GROUNDS = {"dark": np.array([0.07, 0.08, 0.10]), "light": np.array([0.90, 0.91, 0.93]), "green": np.array([0.25, 0.42, 0.33])}


@dataclass(frozen=True, eq=False)
class Photograph:
    """``pixels`` (rows, columns, 3) uint8; true places of marks, ruler (0 and 150 mm) and skin in pixels; true outline."""

    pixels: np.ndarray
    marks: dict[str, np.ndarray]
    ruler: np.ndarray
    skin: np.ndarray
    outline: np.ndarray
    view: str
    side: str

    def clicks(self, rng, noise=1.0, names=None):
        """What a person clicks: each mark with normal noise (standard deviation in pixels, each way)."""
        return {name: tuple(place + noise * rng.standard_normal(2)) for name, place in self.marks.items() if names is None or name in names}

    def ruler_clicks(self, rng, noise=1.0):
        return tuple(map(tuple, self.ruler + noise * rng.standard_normal((2, 2))))


def photograph(
    person, *, camera="pinhole", view="palmar", turn=0.0, ground="dark", left=False, ruler_height=0.0, seed=0, distance=DISTANCE
):
    """The hand lies on the table (flatbed: on the glass) with the other side down; ``turn`` (rad) in the picture, counter-clockwise."""
    rng = np.random.default_rng(seed)
    mirror = np.array([1.0, 1.0, -1.0 if left else 1.0])
    faces = person.faces[:, [0, 2, 1]] if left else person.faces
    skin, marks = person.skin * mirror, {name: place * mirror for name, place in person.marks[view].items()}
    towards = np.array([0.0, 1.0 if view == "palmar" else -1.0, 0.0])
    up = np.array([1.0, 0.0, 0.0])
    across = np.cross(up, towards)
    across, up = np.cos(turn) * across + np.sin(turn) * up, np.cos(turn) * up - np.sin(turn) * across
    height = skin @ towards
    table = height.max() if camera == "flatbed" else height.min()  # a flatbed looks at what lies on the glass
    flat = np.stack([skin @ across, skin @ up], axis=1)
    beside = flat.min(axis=0) - np.array([0.022, 0.0])  # the ruler stands left of the hand, along it
    ends = np.array([beside, beside + np.array([0.0, 1e-3 * RULER_MM])])
    middle = (flat.min(axis=0) + flat.max(axis=0)) / 2

    def project(plane, level):
        centred = plane - middle
        if camera == "pinhole":
            centred = centred * (distance / (distance - (level - table)))[..., None]
        return centred * 1e3 * PX_PER_MM * [1.0, -1.0]

    seen, ruler = project(flat, height), project(ends, np.full(2, table + ruler_height))
    corner = np.vstack([seen, ruler + np.array([[-40, 30], [-40, -30]])])
    shift = MARGIN_MM * PX_PER_MM - corner.min(axis=0)
    shape = tuple(np.ceil((corner + shift).max(axis=0) + MARGIN_MM * PX_PER_MM).astype(int)[::-1].tolist())
    seen, ruler = seen + shift, ruler + shift
    places = {name: project(np.array([[at @ across, at @ up]]), np.array([at @ towards]))[0] + shift for name, at in marks.items()}
    a, b, c = (seen[faces[:, i]] for i in range(3))
    faces = faces[(b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])]  # those that face the camera
    front, _ = foremost(seen, height, faces, shape)
    picture = np.tile(GROUNDS[ground], (*shape, 1))
    _draw_ruler(picture, ruler)
    picture[front >= 0] = _shaded(skin, faces, towards, up, across)[front[front >= 0]]
    picture += 0.012 * rng.standard_normal((*shape, 1))
    pixels = np.clip(255 * picture, 0, 255).astype(np.uint8)
    return Photograph(pixels, places, ruler, seen, front >= 0, view, "left" if left else "right")


def _shaded(skin, faces, towards, up, across):
    a, b, c = (skin[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    light = 0.86 * towards + 0.4 * up - 0.3 * across
    return SKIN * (0.45 + 0.55 * np.clip(normal @ light, 0, 1))[:, None]


def _draw_ruler(picture, ruler):
    x, bottom, top = int(ruler[0, 0]), int(ruler[0, 1]), int(ruler[1, 1])
    picture[max(0, top - 20) : bottom + 20, max(0, x - 40) : x + 2] = PAPER
    for tick in range(int(RULER_MM) + 1):
        y = int(bottom + (top - bottom) * tick / RULER_MM)
        long = 28 if tick % 10 == 0 else 20 if tick % 5 == 0 else 12
        picture[y : y + 1, x - long : x] = 0.1
