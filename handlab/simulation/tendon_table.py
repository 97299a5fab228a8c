"""Courses of the tendons that come from the forearm, from proximal to distal. General anatomy; heights chosen by eye."""

from __future__ import annotations

from typing import NamedTuple


class Ring(NamedTuple):
    """A place around a long bone: ``along`` it (0 base joint, 1 head joint), towards (palmar, radial), above its surface.

    ``over``: joint beneath, over whose head the tendon is laid when it bends.
    """

    bone: str
    along: float
    palmar: float
    radial: float
    lift_mm: float
    over: str = ""


class Flat(NamedTuple):
    """A place above the bones of forearm or wrist: ``distal``, ``radial`` from the wrist in lengths wrist to third knuckle."""

    body: str
    distal: float
    radial: float
    palmar: bool
    lift_mm: float


Row = tuple[str, str, float, tuple[Ring | Flat, ...]]
LENGTHS = {2: 0.16, 3: 0.05, 4: -0.06, 5: -0.16}  # where the tendon of each finger passes the wrist


def _flexors(k: int) -> list[Row]:
    m, p, n, d = (f"{name}_{k}" for name in ("metacarpal", "proximal_phalanx", "middle_phalanx", "distal_phalanx"))
    finger, z = {2: "index", 3: "middle", 4: "ring", 5: "little"}[k], LENGTHS[k]
    deep = (
        Flat("forearm", -0.6, 0.9 * z - 0.05, True, 4.0),
        Flat("forearm", -0.15, 0.6 * z - 0.02, True, 3.0),
        Flat("carpus", 0.15, 0.5 * z - 0.02, True, 3.0),
        Ring(m, 0.45, 1, -0.05, 6.2),
        Ring(m, 0.94, 1, 0, 1.6),
        Ring(p, 0.3, 1, 0, 0.3),
        Ring(p, 0.75, 1, 0, 0.4),
        Ring(n, 0.1, 1, 0, 0.9),
        Ring(n, 0.55, 1, 0, 0.5),
        Ring(d, 0.08, 1, 0, 1.2),
        Ring(d, 0.32, 1, 0, -0.6),
    )
    shallow = (
        Flat("forearm", -0.6, 0.9 * z - 0.05, True, 7.0),
        Flat("forearm", -0.15, 0.6 * z - 0.02, True, 5.6),
        Flat("carpus", 0.15, 0.5 * z - 0.02, True, 5.8),
        Ring(m, 0.45, 1, 0, 8.6),
        Ring(m, 0.94, 1, 0, 3.7),
        Ring(p, 0.22, 1, 0, 2.4),
    )
    rows: list[Row] = [
        (f"deep flexor, {finger}", f"flexor_digitorum_profundus_{finger}", 1.1, deep),
        (f"superficial flexor, {finger}", f"flexor_digitorum_superficialis_{finger}", 1.0, shallow),
    ]
    for side, name in ((1, "radial"), (-1, "ulnar")):
        slip = (
            Ring(p, 0.22, 1, 0.1 * side, 2.4),
            Ring(p, 0.5, 1, 0.9 * side, 0.6),
            Ring(p, 0.85, 1, 0.8 * side, 0.2),
            Ring(n, 0.4, 1, 0.6 * side, -0.4),
        )
        rows.append((f"superficial flexor, {finger}, {name} slip", f"flexor_digitorum_superficialis_{finger}", 0.6, slip))
    return rows


def _extensors(k: int) -> list[Row]:
    m, p, n, d = (f"{name}_{k}" for name in ("metacarpal", "proximal_phalanx", "middle_phalanx", "distal_phalanx"))
    finger, z = {2: "index", 3: "middle", 4: "ring", 5: "little"}[k], LENGTHS[k]
    common = (
        Flat("forearm", -0.6, 0.3 * z, False, 3.0),
        Flat("forearm", -0.36, 0.3 * z, False, 2.0),
        Flat("forearm", -0.15, 0.45 * z + 0.02, False, 0.6),
        Flat("carpus", 0.12, 0.6 * z, False, 0.8),
        Ring(m, 0.1, -1, 0, 0.8),
        Ring(m, 0.4, -1, 0, 0.7),
        Ring(m, 0.8, -1, 0, 0.7),
        Ring(m, 0.98, -1, 0, 0.6, f"mcp{k}"),
        Ring(p, 0.3, -1, 0, 0.7),
        Ring(p, 0.7, -1, 0, 0.1),
        Ring(p, 0.96, -1, 0, 0.1, f"pip{k}"),
        Ring(n, 0.25, -1, 0, 0.1),
        Ring(n, 0.96, -1, 0, 0.1, f"dip{k}"),
        Ring(d, 0.22, -1, 0, -0.4),
    )
    rows: list[Row] = [(f"common extensor, {finger}", f"extensor_digitorum_{finger}", 0.8, common)]
    own = {2: ("extensor of the index", "extensor_indicis"), 5: ("extensor of the little finger", "extensor_digiti_minimi")}
    if k in own:
        beside = (
            Flat("forearm", -0.6, 0.3 * z - 0.1, False, 3.0),
            Flat("forearm", -0.36, 0.3 * z - 0.1, False, 2.0),
            Flat("forearm", -0.15, 0.45 * z - 0.06, False, 0.6),
            Flat("carpus", 0.12, 0.6 * z - 0.06, False, 0.8),
            Ring(m, 0.1, -1, -0.4, 0.6),
            Ring(m, 0.45, -1, -0.5, 0.6),
            Ring(m, 0.8, -1, -0.4, 0.7),
            Ring(m, 0.98, -1, -0.3, 0.7, f"mcp{k}"),
            Ring(p, 0.28, -1, -0.15, 0.5),
        )
        rows.append((*own[k], 0.7, beside))
    return rows


_THUMB: list[Row] = [
    (
        "long flexor of the thumb",
        "flexor_pollicis_longus",
        1.1,
        (
            Flat("forearm", -0.6, 0.14, True, 3.0),
            Flat("forearm", -0.15, 0.13, True, 3.0),
            Flat("carpus", 0.12, 0.1, True, 4.0),
            Ring("metacarpal_1", 0.35, 1, -0.5, 3.4),
            Ring("metacarpal_1", 0.92, 1, 0, 1.4),
            Ring("proximal_phalanx_1", 0.35, 1, 0, 0.2),
            Ring("proximal_phalanx_1", 0.85, 1, 0, 0.4),
            Ring("distal_phalanx_1", 0.3, 1, 0, -0.6),
        ),
    ),
    (
        "long extensor of the thumb",
        "extensor_pollicis_longus",
        0.9,
        (
            Flat("forearm", -0.6, 0.0, False, 3.0),
            Flat("forearm", -0.36, 0.0, False, 2.0),
            Flat("forearm", -0.2, 0.1, False, 0.6),
            Flat("carpus", 0.08, 0.17, False, 1.6),
            Ring("metacarpal_1", 0.45, -1, -0.5, 0.8),
            Ring("metacarpal_1", 0.95, -1, -0.2, 0.8, "mcp1"),
            Ring("proximal_phalanx_1", 0.4, -1, 0, 0.4),
            Ring("proximal_phalanx_1", 0.96, -1, 0, 0.1, "ip1"),
            Ring("distal_phalanx_1", 0.22, -1, 0, -0.5),
        ),
    ),
    (
        "short extensor of the thumb",
        "extensor_pollicis_brevis",
        0.7,
        (
            Flat("forearm", -0.6, 0.16, False, 3.0),
            Flat("forearm", -0.36, 0.16, False, 2.0),
            Flat("forearm", -0.15, 0.18, False, 0.3),
            Ring("metacarpal_1", 0.08, -0.8, 1, 0.9),
            Ring("metacarpal_1", 0.5, -1, 0.4, 0.6),
            Ring("metacarpal_1", 0.95, -1, 0.2, 0.1, "mcp1"),
            Ring("proximal_phalanx_1", 0.2, -1, 0.1, -0.3),
        ),
    ),
    (
        "long abductor of the thumb",
        "abductor_pollicis_longus",
        1.0,
        (
            Flat("forearm", -0.6, 0.18, False, 3.0),
            Flat("forearm", -0.36, 0.18, False, 2.0),
            Flat("forearm", -0.15, 0.2, False, 0.0),
            Ring("metacarpal_1", 0.04, 0.0, 1, 0.8),
            Ring("metacarpal_1", 0.14, 0.3, 1, -0.6),
        ),
    ),
]
_WRIST: list[Row] = [
    (
        "radial flexor of the wrist",
        "flexor_carpi_radialis",
        1.3,
        (
            Flat("forearm", -0.6, 0.12, True, 6.0),
            Flat("forearm", -0.15, 0.14, True, 4.0),
            Flat("carpus", 0.02, 0.15, True, 0.6),
            Ring("metacarpal_2", 0.05, 1, 0.5, 0.2),
        ),
    ),
    (
        "long palmar muscle",
        "palmaris_longus",
        1.0,
        (
            Flat("forearm", -0.6, 0.02, True, 9.0),
            Flat("forearm", -0.15, 0.03, True, 8.6),
            Flat("carpus", 0.1, 0.03, True, 11.0),
            Ring("metacarpal_3", 0.3, 1, 0, 11.0),
        ),
    ),
    (
        "ulnar flexor of the wrist",
        "flexor_carpi_ulnaris",
        1.4,
        (
            Flat("forearm", -0.6, -0.2, True, 4.0),
            Flat("forearm", -0.15, -0.2, True, 4.0),
            Flat("carpus", 0.02, -0.19, True, 0.0),
        ),
    ),
    (
        "long radial extensor of the wrist",
        "extensor_carpi_radialis_longus",
        1.2,
        (
            Flat("forearm", -0.6, 0.18, False, 3.0),
            Flat("forearm", -0.36, 0.18, False, 2.0),
            Flat("forearm", -0.12, 0.17, False, 0.5),
            Flat("carpus", 0.1, 0.14, False, 0.5),
            Ring("metacarpal_2", 0.04, -1, 0.4, -0.3),
        ),
    ),
    (
        "short radial extensor of the wrist",
        "extensor_carpi_radialis_brevis",
        1.2,
        (
            Flat("forearm", -0.6, 0.13, False, 3.0),
            Flat("forearm", -0.36, 0.13, False, 2.0),
            Flat("forearm", -0.12, 0.12, False, 0.5),
            Flat("carpus", 0.1, 0.08, False, 0.4),
            Ring("metacarpal_3", 0.04, -1, 0.3, -0.3),
        ),
    ),
    (
        "ulnar extensor of the wrist",
        "extensor_carpi_ulnaris",
        1.3,
        (
            Flat("forearm", -0.6, -0.2, False, 3.0),
            Flat("forearm", -0.36, -0.2, False, 2.0),
            Flat("forearm", -0.12, -0.2, False, 0.4),
            Flat("carpus", 0.02, -0.2, False, 0.6),
            Ring("metacarpal_5", 0.06, -0.6, -1, -0.2),
        ),
    ),
]
COURSES: tuple[Row, ...] = tuple(row for k in range(2, 6) for row in (*_flexors(k), *_extensors(k))) + tuple(_THUMB) + tuple(_WRIST)
