"""Attachments of the intrinsic muscles, as places on the bones of the reference hand.

Origins and insertions as in any atlas of anatomy; widths and thicknesses (mm) are what the room between skin and bone of this
small hand allows. A bone's side is given as (palmar, radial) of its own finger; the thumb's palmar side faces the little finger.
"""

from __future__ import annotations

import numpy as np

from tools.muscle_grids import BACK, PALM, RADIAL, ULNAR, Plan, Row, across, between, resampled
from tools.muscle_places import Places

THUMB_PALM = (0.0, 0.8, -0.1)
THENAR = (-0.3, 0.85, 0.4)
HYPO = (0.0, 0.75, -0.65)


def _row(a, b, thick, bones, view):  # type: ignore[no-untyped-def]
    return Row(np.asarray(a), np.asarray(b), thick, bones, view)


def thenar(at: Places) -> list[Plan]:
    """Abductor, flexor, opponens, and the two heads of the adductor."""
    m1, p1, m3 = "metacarpal_1", "proximal_phalanx_1", "metacarpal_3"
    abductor = [
        _row(
            at.carpal("trapezium", (-0.3, 1, 0.5), 2.5),
            at.carpal("scaphoid", (0.2, 1, 0.0), 3.0),
            1.8,
            {"trapezium": 0.5, "scaphoid": 0.5},
            THENAR,
        ),
        _row(at.on(m1, 0.22, 0.35, 1, 4.0), at.on(m1, 0.16, 1, 0.45, 7.0), 3.6, {"trapezium": 0.5, m1: 0.5}, THENAR),
        _row(at.on(m1, 0.55, 0.25, 1, 3.6), at.on(m1, 0.52, 1, 0.75, 6.0), 3.8, m1, THENAR),
        _row(at.on(m1, 0.86, 0.2, 1, 2.0), at.on(m1, 0.86, 1, 1, 3.0), 2.2, m1, THENAR),
        _row(at.on(p1, 0.08, 0.05, 1, 0.8), at.on(p1, 0.08, 0.6, 1, 0.8), 1.3, p1, THENAR),
    ]
    flexor = [
        _row(at.carpal("trapezium", (0.3, 1, 0.0), 3.0), at.carpal("trapezoid", (0.3, 1, 0.0), 6.0), 2.0, "trapezium", THENAR),
        _row(at.on(m1, 0.25, 1, 0.1, 5.5), at.on(m1, 0.25, 1, -0.9, 7.0), 4.6, {"trapezium": 0.5, m1: 0.5}, THUMB_PALM),
        _row(at.on(m1, 0.58, 1, 0.35, 4.2), at.on(m1, 0.58, 1, -0.45, 5.0), 4.8, m1, THUMB_PALM),
        _row(at.on(m1, 0.88, 1, 0.75, 2.4), at.on(m1, 0.88, 1, 0.1, 2.8), 2.6, m1, THUMB_PALM),
        _row(at.on(p1, 0.08, 1, 0.9, 0.8), at.on(p1, 0.08, 1, 0.3, 0.8), 1.3, p1, THUMB_PALM),
    ]
    opponens = [
        _row(at.carpal("trapezium", (-0.2, 1, 0.3), 1.0), at.carpal("trapezoid", (0.6, 1, -0.2), 4.0), 2.0, "trapezium", THENAR),
        _row(at.on(m1, 0.16, 1, 0.6, 1.8), at.on(m1, 0.5, 1, -0.5, 3.2), 3.6, {m1: 0.7, "trapezium": 0.3}, THENAR),
        _row(at.on(m1, 0.2, 0.8, 1, 1.9), at.on(m1, 0.72, 1, 0.1, 2.4), 3.6, m1, THENAR),
        _row(at.on(m1, 0.25, 0.2, 1, 0.9), at.on(m1, 0.9, 0.6, 1, 0.9), 1.6, m1, THENAR),
    ]
    short = resampled(opponens, 6)
    for k, part in enumerate((0.7, 0.95, 1.0, 1.0, 1.0), start=1):  # it lies on the metacarpal, which turns under anything else
        short[k].bones = {m1: part, "trapezium": 1.0 - part} if part < 1.0 else m1
    oblique = [
        _row(at.on("metacarpal_2", 0.14, 1, -0.2, 1.6), at.on(m3, 0.12, 1, -0.3, 1.6), 2.4, "capitate", PALM),
        _row(at.on("metacarpal_2", 0.2, 1, 0.6, 3.6), at.on(m3, 0.28, 1, 0.6, 3.2), 4.0, {"capitate": 0.75, m1: 0.25}, PALM),
        _row(
            at.on(m1, 0.55, 1, -1, 5.0),
            between(at.on(m1, 0.6, 1, -1, 5.0), at.on(m3, 0.45, 1, 0.6, 3.6), 0.36),
            4.4,
            {m1: 0.7, "capitate": 0.3},
            PALM,
        ),
        _row(at.on(m1, 0.86, 1, -0.3, 2.2), at.on(m1, 0.84, 0.8, -1, 2.4), 3.0, m1, PALM),
        _row(at.under(p1, 0.06, 1, -0.3, 2.8), at.under(p1, 0.07, 0.7, -1, 2.8), 1.5, p1, PALM),
    ]
    start = at.on(m3, 0.36, 1, -0.1, 1.2), at.on(m3, 0.86, 1, -0.1, 1.2)
    ulnar = at.under(p1, 0.02, 0.9, -1, 2.8), at.under(p1, 0.16, 0.4, -1, 2.8)
    middle = between(at.on(m1, 0.66, 1, -1, 5.0), at.on(m3, 0.5, 1, 0.6, 3.6), 0.5), between(ulnar[1], at.on(m3, 0.86, 1, 0.6, 3.6), 0.5)
    transverse = [
        _row(*start, 2.0, m3, PALM),
        _row(at.on(m3, 0.4, 1, 2.0, 4.0), between(at.on(m3, 0.84, 1, 0.6, 2.4), middle[1], 0.35), 3.4, {m3: 0.8, m1: 0.2}, PALM),
        _row(*middle, 3.6, {m1: 0.5, m3: 0.5}, PALM),
        _row(*(between(a, b, 0.6) for a, b in zip(middle, ulnar, strict=True)), 3.0, {m1: 0.9, m3: 0.1}, (0.3, 0.75, -0.15)),
        _row(*ulnar, 1.5, p1, (0.4, 0.6, -0.4)),
    ]
    return [
        Plan("abductor_pollicis_brevis", "abductor_pollicis_brevis", resampled(abductor, 7), 3),
        Plan("flexor_pollicis_brevis", "flexor_pollicis_brevis", resampled(flexor, 7), 3),
        Plan("opponens_pollicis", "opponens_pollicis", short, 5),
        Plan("adductor_pollicis_oblique", "adductor_pollicis", resampled(oblique, 7), 3),
        Plan("adductor_pollicis_transverse", "adductor_pollicis", resampled(transverse, 7), 5),
    ]


def hypothenar(at: Places) -> list[Plan]:
    """Abductor over flexor and opponens of the little finger (Figure 2, right)."""
    m5, p5 = "metacarpal_5", "proximal_phalanx_5"
    abductor = [
        _row(at.carpal("pisiform", (1, 0.7, 0.3), 1.0), at.carpal("pisiform", (1, 0.3, -0.8), 1.0), 2.0, "pisiform", HYPO),
        _row(at.under(m5, 0.2, 1, -1, 4.4), at.under(m5, 0.2, -0.25, -1, 4.4), 4.8, {"pisiform": 0.5, m5: 0.5}, HYPO),
        _row(at.under(m5, 0.5, 1, -1, 4.2), at.under(m5, 0.5, -0.2, -1, 4.2), 4.8, m5, HYPO),
        _row(at.under(m5, 0.86, 0.5, -1, 2.6), at.under(m5, 0.86, -0.2, -1, 2.6), 2.0, m5, HYPO),
        _row(at.under(p5, 0.1, 0.5, -1, 2.2), at.under(p5, 0.1, -0.3, -1, 2.2), 1.3, p5, HYPO),
    ]
    hook = at.carpal("hamate", (0.5, 1, -0.2), 1.0)
    flexor = [
        _row(*across(hook, np.array([-0.2, 0.0, -1.0]), 4.0), 1.8, "hamate", PALM),
        _row(at.on(m5, 0.25, 1, 0.65, 4.6), at.on(m5, 0.25, 1, -0.6, 4.6), 4.6, {"hamate": 0.5, m5: 0.5}, PALM),
        _row(at.on(m5, 0.55, 1, 0.3, 4.0), at.on(m5, 0.55, 1, -0.9, 3.8), 4.4, m5, PALM),
        _row(at.on(m5, 0.88, 1, -0.3, 2.4), at.on(m5, 0.88, 1, -1, 2.2), 2.2, m5, PALM),
        _row(at.on(p5, 0.08, 1, -0.5, 0.8), at.on(p5, 0.08, 0.8, -1, 0.8), 1.3, p5, PALM),
    ]
    opponens = [
        _row(at.carpal("hamate", (0.3, 1, -0.5), 0.6), at.carpal("hamate", (0.8, 0.8, 0.0), 0.6), 1.8, "hamate", PALM),
        _row(at.on(m5, 0.14, 1, -0.6, 1.9), at.on(m5, 0.5, 1, 0.5, 1.9), 2.8, {m5: 0.8, "hamate": 0.2}, PALM),
        _row(at.on(m5, 0.2, 0.7, -1, 1.4), at.on(m5, 0.72, 1, -0.4, 1.5), 2.8, m5, HYPO),
        _row(at.on(m5, 0.25, 0.1, -1, 0.7), at.on(m5, 0.88, 0.5, -1, 0.7), 1.4, m5, HYPO),
    ]
    return [
        Plan("abductor_digiti_minimi", "abductor_digiti_minimi", resampled(abductor, 7), 3),
        Plan("flexor_digiti_minimi_brevis", "flexor_digiti_minimi_brevis", resampled(flexor, 7), 3),
        Plan("opponens_digiti_minimi", "opponens_digiti_minimi", resampled(opponens, 6), 5),
    ]


def lumbricals(at: Places) -> list[Plan]:
    """From the tendons of the deep flexor, palmar of the joint, to the radial side of the extensor hood."""
    found = []
    for k in range(2, 6):
        m, p = f"metacarpal_{k}", f"proximal_phalanx_{k}"
        f, g = at.frame(m), at.frame(p)
        rows = []
        for bone, along, side, lift, width, thick, carried, view in (
            (m, 0.22, (1, 0.4), 7.6, 2.6, 1.4, m, PALM),
            (m, 0.45, (1, 0.5), 7.2, 4.0, 2.8, m, PALM),
            (m, 0.66, (1, 0.6), 6.0, 4.0, 2.8, m, PALM),
            (m, 0.9, (0.9, 1), 2.8, 2.6, 1.8, m, PALM),
            (p, 0.1, (0.6, 1), 1.2, 2.0, 1.2, p, PALM),
            (p, 0.22, (0.5, 1), 1.0, 3.4, 1.2, p, PALM),
        ):
            frame = f if bone == m else g
            if k == 2:  # the first lies at the radial edge of the palm, and is seen more and more from there
                view = (0.0, 1.0, 1.4 * along if bone == m else 2.5)
            rows.append(Row(*across(at.on(bone, along, *side, lift), np.cross(frame.distal, view), width), thick, carried, view))
        found.append(Plan(f"lumbrical_{k - 1}", f"lumbrical_{k - 1}", resampled(rows, 9), 2, on_bone=(False, True)))
    return found


def interossei(at: Places) -> list[Plan]:
    """Four dorsal ones between the metacarpals, three palmar ones on the side of their own finger."""
    m1, m2, p2 = "metacarpal_1", "metacarpal_2", "proximal_phalanx_2"
    first = (0.1, -0.75, 0.65)
    deep = [
        _row(at.on(m2, 0.1, -0.3, 1, 1.6), at.on(m2, 0.14, 0.6, 1, 3.6), 3.0, m2, first),
        _row(at.on(m2, 0.3, -0.35, 1, 1.8), at.on(m2, 0.3, 0.6, 1, 5.6), 5.0, m2, first),
        _row(at.on(m2, 0.55, -0.35, 1, 1.8), at.on(m2, 0.55, 0.6, 1, 5.2), 5.0, m2, first),
        _row(at.on(m2, 0.85, -0.25, 1, 1.2), at.on(m2, 0.85, 0.5, 1, 2.2), 2.4, m2, first),
        _row(at.on(p2, 0.1, -0.2, 1, 0.7), at.on(p2, 0.1, 0.4, 1, 0.9), 1.3, p2, first),
    ]
    head = [
        _row(at.on(m1, 0.16, 0.3, -1, 1.8), at.on(m1, 0.62, -0.1, -1, 1.8), 3.0, m1, first),
        _row(
            between(at.on(m1, 0.16, 0.3, -1, 1.8), at.on(m2, 0.3, 0.2, 1, 6.0), 0.5),
            between(at.on(m1, 0.62, -0.1, -1, 1.8), at.on(m2, 0.55, 0.4, 1, 7.0), 0.5),
            7.6,
            {m1: 0.5, m2: 0.5},
            first,
        ),
        _row(at.on(m2, 0.5, -0.15, 1, 5.5), at.on(m2, 0.62, 0.8, 1, 11.0), 8.0, {m2: 0.9, m1: 0.1}, first),
        _row(at.on(m2, 0.85, -0.2, 1, 2.4), at.on(m2, 0.86, 0.7, 1, 4.0), 3.2, m2, first),
        _row(at.on(p2, 0.12, -0.1, 1, 0.9), at.on(p2, 0.12, 0.6, 1, 1.0), 1.3, p2, first),
    ]
    found = [
        Plan("dorsal_interosseus_1_index_head", "dorsal_interosseus_1", resampled(deep, 7), 3, confined=True),
        Plan("dorsal_interosseus_1_thumb_head", "dorsal_interosseus_1", resampled(head, 7), 4, confined=True),
    ]
    for number, (a, b, finger, way) in enumerate(((2, 3, 3, 1.0), (3, 4, 3, -1.0), (4, 5, 4, -1.0)), start=2):
        one, other, p = f"metacarpal_{a}", f"metacarpal_{b}", f"proximal_phalanx_{finger}"
        own = f"metacarpal_{finger}"
        both = {one: 0.5, other: 0.5}
        rows = []
        for along, thick, trim in ((0.22, 3.0, 0.4), (0.4, 6.0, 0.7), (0.58, 6.0, 1.0)):
            rows.append(_row(at.on(one, along, 0.1, -1, trim), at.on(other, along, 0.1, 1, trim), thick, both, BACK))
        side = at.frame(own).radial
        rows.append(_row(*across(at.on(own, 0.76, 0.15, way, 2.4), -side, 3.6), 4.0, own, BACK))
        for bone, along, side, lift, thick in ((own, 0.95, (0.0, way), 1.6, 2.0), (p, 0.12, (0.0, way), 0.7, 1.3)):
            frame = at.frame(bone)
            mid = at.on(bone, along, *side, lift)
            rows.append(_row(*across(mid, -(frame.radial + 0.8 * way * frame.palmar), 2.0), thick, bone, BACK))
        found.append(Plan(f"dorsal_interosseus_{number}", f"dorsal_interosseus_{number}", resampled(rows, 8), 3, confined=True))
    for number, (finger, way) in enumerate(((2, -1.0), (4, 1.0), (5, 1.0)), start=1):
        m, p = f"metacarpal_{finger}", f"proximal_phalanx_{finger}"
        rows = []
        for bone, along, side, lift, width, thick in (
            (m, 0.16, (1.0, 0.7 * way), 1.1, 3.0, 1.8),
            (m, 0.4, (1.0, 0.8 * way), 2.3, 4.4, 3.6),
            (m, 0.64, (1.0, 0.9 * way), 2.3, 4.4, 3.6),
            (m, 0.92, (0.3, 1.0 * way), 1.6, 2.4, 2.0),
            (p, 0.1, (0.1, 1.0 * way), 0.7, 2.0, 1.3),
        ):
            frame = at.frame(bone)
            rows.append(
                _row(
                    *across(
                        at.on(bone, along, *side, lift),
                        -frame.radial + (0.5 * way * frame.palmar if side[0] > 0.5 else way * frame.palmar),
                        width,
                    ),
                    thick,
                    bone,
                    PALM,
                )
            )
        found.append(Plan(f"palmar_interosseus_{number}", f"palmar_interosseus_{number}", resampled(rows, 7), 3, confined=True))
    return found


__all__ = ["RADIAL", "ULNAR", "hypothenar", "interossei", "lumbricals", "thenar"]
