"""Photographs of coins whose true scale is known: rays of a camera meet a round plate with rounded edges on a table.

Nothing of ``handlab`` takes part. Metal mirrors what is above and beside it: lamps, the room, the ground; the coin throws shadows on the
ground. Lengths in mm; the coin's middle is the origin, z upwards, the table at z = 0.
"""

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

GROUNDS = {"dark": (0.02, 0.02, 0.03), "grey": (0.30, 0.31, 0.30), "light": (0.85, 0.85, 0.82), "wood": (0.33, 0.20, 0.11)}
METALS = {"gold": (0.75, 0.60, 0.33), "silver": (0.66, 0.65, 0.62), "copper": (0.62, 0.36, 0.25)}
OTHER = {"gold": "silver", "silver": "gold", "copper": "copper"}


@dataclass(frozen=True)
class Coin:
    """``round`` is the radius of the edge's rounding; ``core`` the share of the radius of an inner part of another metal, 0 without."""

    diameter: float = 23.25
    thickness: float = 2.33
    round: float = 0.3
    metal: str = "gold"
    core: float = 0.0
    dull: float = 0.5  # share of light that is scattered evenly, the rest is mirrored with a lobe
    lobe: float = 12.0  # sharpness of that lobe


@dataclass(frozen=True)
class Shot:
    """``px_per_mm`` on the table below the coin; ``off`` (2,) mm from the foot of the camera's axis; ``tilt`` rad towards ``tilt_way``."""

    px_per_mm: float = 6.0
    distance: float = 600.0
    off: tuple[float, float] = (0.0, 0.0)
    tilt: float = 0.0
    tilt_way: float = 0.0
    blur: float = 0.8
    noise: float = 0.01
    jpeg: int = 88
    ground: str = "dark"
    texture: float = 0.1
    lamps: tuple[tuple[float, float, float], ...] = ((0.8, 0.6, 1.2),)  # azimuth, elevation (rad), strength
    room: float = 0.35


def any_coin(rng):
    diameter, thickness, metal, core = [
        (23.25, 2.33, "gold", 0.70), (25.75, 2.20, "silver", 0.71), (24.25, 2.38, "gold", 0.0), (19.75, 1.93, "gold", 0.0),
        (21.25, 1.67, "copper", 0.0), (24.26, 1.75, "silver", 0.0),
    ][rng.integers(6)]  # fmt: skip
    return Coin(diameter, thickness, rng.uniform(0.2, 0.4), metal, core, rng.uniform(0.3, 0.8), rng.uniform(5.0, 40.0))


def any_shot(rng, ground):
    """As people take them: 35 to 80 cm away, up to 8 cm beside the middle, nearly from above, one to three lamps."""
    at, far = rng.uniform(0, 2 * np.pi), rng.uniform(0.0, 80.0)
    lamps = tuple((rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.4), rng.uniform(0.5, 1.5)) for _ in range(rng.integers(1, 4)))
    return Shot(
        rng.uniform(3.0, 8.0), rng.uniform(350.0, 800.0), (far * np.cos(at), far * np.sin(at)),
        np.deg2rad(rng.uniform(0.0, 6.0)), rng.uniform(0, 2 * np.pi), rng.uniform(0.6, 1.5), rng.uniform(0.004, 0.02),
        int(rng.integers(75, 96)), ground, rng.uniform(0.0, 0.25), lamps, rng.uniform(0.2, 0.6),
    )  # fmt: skip


def photograph(coin, shot, rng):
    """Pixels (rows, columns, 3) uint8 around the coin, and the place (2,) px of the coin's middle in them."""
    forward, right, down, eye = _camera(shot)
    focal = shot.px_per_mm * float(-eye @ forward)
    foot = focal * np.array([-eye @ right, -eye @ down]) / (-eye @ forward)  # of the coin's middle, from the camera's axis
    low = np.floor(foot).astype(int) - int(coin.diameter * shot.px_per_mm)
    side, fine = 2 * int(coin.diameter * shot.px_per_mm), 3 if shot.px_per_mm < 5.0 else 2
    at = (np.arange(side * fine) + 0.5) / fine
    uu, vv = np.meshgrid((low[0] + at) / focal, (low[1] + at) / focal)
    way = uu[..., None] * right + vv[..., None] * down + forward
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    light = _seen(coin, shot, eye, way.reshape(-1, 3), rng).reshape(side, fine, side, fine, 3).mean(axis=(1, 3))
    light = gaussian_filter(light * (0.8 / np.quantile(light, 0.97)), (shot.blur, shot.blur, 0))  # well exposed
    picture = np.clip(light, 0, 1) ** (1 / 2.2) + shot.noise * rng.standard_normal(light.shape)
    return _jpeg(np.clip(255 * picture + 0.5, 0, 255).astype(np.uint8), shot.jpeg), foot - low


def _camera(shot):
    """Directions of the camera's axis, picture's x and y (down), and the eye (3,); the coin's middle on the table is the origin."""
    eye = np.array([-shot.off[0], -shot.off[1], shot.distance])
    axis = np.array([np.cos(shot.tilt_way), np.sin(shot.tilt_way), 0.0])
    forward = -np.cos(shot.tilt) * np.array([0.0, 0.0, 1.0]) + np.sin(shot.tilt) * axis
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    return forward, right, np.cross(forward, right), eye


def _seen(coin, shot, eye, way, rng):
    """Light (N, 3) along the rays from ``eye``."""
    table = eye + way * (-eye[2] / way[:, 2])[:, None]
    light = _ground(coin, shot, table, rng)
    near = np.flatnonzero(np.hypot(table[:, 0], table[:, 1]) < 0.5 * coin.diameter + 0.5 * coin.thickness + 1.0)
    along = (coin.thickness + 0.05 - eye[2]) / way[near, 2]
    for _ in range(40):
        along += _apart(coin, eye + way[near] * along[:, None])
    place = eye + way[near] * along[:, None]
    met = (np.abs(_apart(coin, place)) < 0.01) & (place[:, 2] > 0.0)
    light[near[met]] = _metal(coin, shot, place[met], way[near[met]], rng)
    return light


def _apart(coin, place):
    """Distance (N,) of places from the coin: a cylinder with rounded edges."""
    q = np.stack([np.hypot(place[:, 0], place[:, 1]) - coin.diameter / 2, np.abs(place[:, 2] - coin.thickness / 2) - coin.thickness / 2])
    q += coin.round
    return np.hypot(*np.maximum(q, 0.0)) + np.minimum(q.max(axis=0), 0.0) - coin.round


def _metal(coin, shot, place, way, rng):
    far = np.hypot(place[:, 0], place[:, 1])
    out = place[:, :2] / far[:, None]
    q = np.stack([far - coin.diameter / 2, place[:, 2] - coin.thickness / 2 - coin.thickness / 2]) + coin.round
    q = np.where(q.max(axis=0) > 0, np.maximum(q, 0.0), [[0.0], [1.0]] * np.ones_like(q))
    # the face: a groove inside the raised border, and strokes of a pattern
    face = far < coin.diameter / 2 - coin.round
    slope = np.where(face, -0.5 * np.exp(-(((far - coin.diameter / 2 + 1.3) / 0.15) ** 2)), 0.0)
    relief = 0.12 * _field(rng, 5)[tuple((place[:, k] * 6).astype(int) % 256 for k in (0, 1))] * (far < coin.diameter / 2 - 1.6)
    normal = np.column_stack([out * (q[0] - slope)[:, None] + relief[:, None] * [0.7, 0.7], q[1]])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    mirrored = way - 2 * np.sum(way * normal, axis=1, keepdims=True) * normal
    colour = np.where((far < coin.core * coin.diameter / 2)[:, None], METALS[OTHER[coin.metal]], METALS[coin.metal])
    ground = np.array(GROUNDS[shot.ground])
    lamps = _lamps(shot)
    up, glance = 0.5 * (1 + normal[:, 2:]), 0.5 * (1 + np.tanh(4 * mirrored[:, 2:]))
    even = shot.room * (up + (1 - up) * 0.6 * ground)
    gloss = shot.room * (glance + (1 - glance) * 0.6 * ground)
    for to, strength in lamps:
        even = even + strength * np.maximum(normal @ to, 0.0)[:, None]
        gloss = gloss + strength * 0.5 * coin.lobe**0.5 * np.exp(coin.lobe * (mirrored @ to - 1.0))[:, None]
    return colour * (coin.dull * even + (1 - coin.dull) * gloss)


def _ground(coin, shot, place, rng):
    """Ground with its texture; it sees less of the room and of the lamps next to the coin."""
    far = np.maximum(np.hypot(place[:, 0], place[:, 1]) - coin.diameter / 2, 0.0)
    light = shot.room * (1.0 - 0.5 * np.exp(-far / (0.4 * coin.thickness)))
    for to, strength in _lamps(shot):
        # halfway up the edge on the way to the lamp; lamps are wide, so shadows are soft
        reach = place[:, :2] + to[:2] / to[2] * 0.6 * coin.thickness
        light = light + strength * to[2] / (1 + np.exp(-(np.hypot(reach[:, 0], reach[:, 1]) - coin.diameter / 2) / 0.25))
    texture = _field(rng, 2)[tuple((place[:, k] * 5).astype(int) % 256 for k in (0, 1))]
    return np.array(GROUNDS[shot.ground]) * (light * np.exp(shot.texture * texture))[:, None]


def _lamps(shot):
    return [(np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)]), strength) for a, e, strength in shot.lamps]


def _field(rng, size):
    """A random pattern (256, 256) that repeats itself, mean 0, scatter 1."""
    field = gaussian_filter(np.random.default_rng(rng.integers(2**31)).standard_normal((256, 256)), size, mode="wrap")
    return field / field.std()


def _jpeg(pixels, quality):
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, format="JPEG", quality=quality)
    return np.asarray(Image.open(stream).convert("RGB"))
