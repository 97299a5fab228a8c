"""What a good hand must be, measured on this one: the table that ``handlab info`` prints.

Every line is a promise about the geometry in the bind posture, with what was found and what is wanted.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from handlab.anatomy import data
from handlab.anatomy.bone_lengths import BONES, bone_lengths_mm
from handlab.anatomy.load import load_hand
from handlab.anatomy.records import Array, Hand
from handlab.anatomy.terms import FINGERS
from handlab.simulation.skin import fine_points
from handlab.studies import surfaces, tissue

CREASED = ("ip1", *(f"{joint}{k}" for k in range(2, 6) for joint in ("pip", "dip")))
CONDYLAR = ("mcp1", "ip1", *(f"{joint}{k}" for k in range(2, 6) for joint in ("mcp", "pip", "dip")))
CARPOMETACARPAL = tuple(f"cmc{k}" for k in range(1, 6))
CENTRE_REACH_MM = 3.0
SMOOTH_JOINTS = 1  # the source's little finger has no crease at PIP, only a wide hollow
BINDING_MM = 0.001
MEGABYTE = 1e6


class Row(NamedTuple):
    """One promise: what was measured, what came out, what is wanted, and whether it holds."""

    what: str
    measured: str
    wanted: str
    ok: bool


def quality(hand: Hand) -> tuple[Row, ...]:
    """All promises about the geometry of ``hand``, measured now (a few seconds)."""
    return tuple(row for measure in MEASURES for row in measure(hand))


def _skins(hand: Hand) -> Iterator[Row]:
    even, fine = hand.skin, hand.skin_fine
    yield _count("triangles of the even skin", len(even.faces), 2800, 3200)
    yield _count("triangles of the fine skin", len(fine.faces), 10_000, 14_000)
    wrong = [f"{name}: {fault}" for name, mesh in (("even", even), ("fine", fine)) for fault in surfaces.faults(mesh)]
    yield Row("both skins closed, manifold, oriented, one body", "; ".join(wrong) or "yes", "yes", not wrong)
    crossed = surfaces.crossed(even), surfaces.crossed(fine)
    yield Row("triangles that cross their own skin", f"{crossed[0]} even, {crossed[1]} fine", "none", not any(crossed))
    length = surfaces.edge_lengths(even)
    variation = float(length.std() / length.mean())
    yield Row("edges of the even skin", f"{1e3 * length.mean():.1f} mm, variation {variation:.2f}", "variation below 0.20", variation < 0.2)
    off = 1e3 * np.linalg.norm(fine_points(hand, even.points) - fine.points, axis=1).max()
    yield Row("fine skin from its binding", f"within {off:.5f} mm", f"{BINDING_MM} mm", bool(off <= BINDING_MM))


def _texture(hand: Hand) -> Iterator[Row]:
    low, high = float(hand.skin_fine.texture.min()), float(hand.skin_fine.texture.max())
    yield Row("texture coordinates", f"{low:.3f} to {high:.3f}", "0 to 1", low >= 0.0 and high <= 1.0)
    overlaps = surfaces.overlapping_in_texture(hand.skin_fine)
    yield Row("triangles that overlap in the texture", str(overlaps), "none", overlaps == 0)


def _weights(hand: Hand) -> Iterator[Row]:
    weights = hand.skin.weights
    most, error = int((weights > 0).sum(axis=1).max()), float(np.abs(weights.sum(axis=1) - 1.0).max())
    good = bool(most <= 4 and error < 1e-9 and weights.min() >= 0.0)
    yield Row("blend weights", f"at most {most} bodies a point, sums 1 within {error:.0e}", "at most 4, sums 1", good)
    points = len(hand.feature_points)
    yield Row("feature points", str(points), "26", points == 26)


def _bones(hand: Hand) -> Iterator[Row]:
    wrong = {name: found for name, bone in hand.bones.items() if (found := surfaces.faults(bone))}
    closed = len(hand.bones) - len(wrong)
    text = "".join(f"; {name}: {', '.join(found)}" for name, found in wrong.items())
    yield Row("closed bones without tunnels", f"{closed}{text}", "29", closed == 29 and not wrong)
    (even, even_bone), (fine, fine_bone) = tissue.bone_depths_in_skin(hand)
    measured = f"{1e3 * even:.1f} mm ({even_bone}); fine skin {1e3 * fine:.1f} mm ({fine_bone})"
    yield Row("least depth of a bone in the skin", measured, "none outside", even > 0.0 and fine > 0.0)
    ratio, tolerance = _length_ratios(hand)
    scale = np.exp(np.log(list(ratio.values())).mean())
    excess = {name: value / scale - 1.0 for name, value in ratio.items()}
    worst = max(excess, key=lambda name: abs(excess[name]) / tolerance[name])
    good = all(abs(excess[name]) <= tolerance[name] for name in excess)
    yield Row(
        "bone lengths after one scale", f"scale {scale:.3f}, worst {worst} {excess[worst]:+.1%}", "10 %; thumb, little finger 15 %", good
    )


def _length_ratios(hand: Hand) -> tuple[dict[str, float], dict[str, float]]:
    """Length of each metacarpal and phalanx over its natural length, and the tolerance of that."""
    ratio, tolerance = {}, {}
    for k, lengths in bone_lengths_mm().items():
        for name in (name for name in BONES if name in lengths):
            ratio[f"{name}_{k}"] = 1e3 * tissue.bone_length(hand, f"{name}_{k}") / lengths[name]
            tolerance[f"{name}_{k}"] = 0.15 if k in (1, 5) else 0.10
    return ratio, tolerance


def _joints(hand: Hand) -> Iterator[Row]:
    gaps = {name: 1e3 * tissue.joint_gap(hand, name)[0] for name in hand.joints}
    yield _range("joint gaps", gaps, 0.5, 2.0)
    ahead = {name: 1e3 * tissue.gap_ahead(hand, name) for name in CONDYLAR}
    off = {name: 1e3 * tissue.head_centre_error(hand, name) for name in CONDYLAR}
    between = all(0.0 < value < 7.0 for value in ahead.values()) and all(value <= CENTRE_REACH_MM for value in off.values())
    measured = f"{_span(ahead)} proximal of the gap, {_span(off)} from that centre"
    yield Row("finger joints' centres", measured, "in the proximal bone's head, 3 mm from its centre of curvature", between)
    across = {name: abs(1e3 * tissue.gap_ahead(hand, name)) for name in CARPOMETACARPAL}
    yield _range("CMC joints' centres, from the gap", across, 0.0, CENTRE_REACH_MM)
    found = {name: tissue.crease(hand, name) for name in CREASED}
    creases = {name: 1e3 * at for name, at in found.items() if at is not None}
    without = [name for name in found if name not in creases]
    missing = f"; no crease at {', '.join(without)}" if without else ""
    text = _span(creases, signed=True) + _outside(creases, -CENTRE_REACH_MM, CENTRE_REACH_MM) + missing
    good = len(without) <= SMOOTH_JOINTS and all(abs(at) <= CENTRE_REACH_MM for at in creases.values())
    yield Row("palmar creases, distal of the joints' centres", text, "-3 to 3 mm at PIP, DIP and IP", good)


def _tissue(hand: Hand) -> Iterator[Row]:
    over = {FINGERS[k - 1]: tuple(1e3 * depth for depth in tissue.knuckle_tissue(hand, k)) for k in range(2, 6)}
    nearest, crest = {name: least for name, (least, _) in over.items()}, {name: top for name, (_, top) in over.items()}
    bad = _outside(nearest, 1.0, 3.0)
    yield Row("tissue over the knuckles", f"least {_span(nearest)}, on top {_span(crest)}{bad}", "least 1 to 3 mm", not bad)
    yield _range("pulp palmar of the distal phalanx", {FINGERS[k - 1]: 1e3 * tissue.pulp_thickness(hand, k) for k in range(1, 6)}, 3.0, 6.0)


def _mass(hand: Hand) -> Iterator[Row]:
    mass, volume = sum(body.mass for body in hand.bodies.values()), hand.skin.volume
    density = mass / volume
    yield Row(
        "mass of all bodies over the skin's volume",
        f"{1e3 * mass:.0f} g / {1e6 * volume:.0f} cm3",
        "1000 to 1200 kg/m3",
        1000 <= density <= 1200,
    )


def _files(_: Hand) -> Iterator[Row]:
    size = sum(path.stat().st_size for path in data.folder().rglob("*") if path.is_file()) / MEGABYTE
    yield Row("size of assets", f"{size:.2f} MB", "below 6 MB", size < 6.0)
    seconds = min(_seconds(load_hand) for _ in range(3))
    yield Row("a hand loads in", f"{seconds:.2f} s", "below 0.30 s", seconds < 0.3)


def _seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


MEASURES: tuple[Callable[[Hand], Iterator[Row]], ...] = (_skins, _texture, _weights, _bones, _joints, _tissue, _mass, _files)


def _count(what: str, number: int, least: int, most: int) -> Row:
    return Row(what, str(number), f"{least} to {most}", least <= number <= most)


def _range(what: str, values_mm: dict[str, float], least: float, most: float) -> Row:
    """A row of lengths that must all lie between two bounds; names those that do not."""
    ok = all(least <= value <= most for value in values_mm.values())
    return Row(what, f"{_span(values_mm)}{_outside(values_mm, least, most)}", f"{least:g} to {most:g} mm", ok)


def _span(values_mm: dict[str, float], *, signed: bool = False) -> str:
    values: Array = np.array(list(values_mm.values()))
    if not len(values):
        return "nothing"
    return f"{values.min():+.2f} to {values.max():+.2f} mm" if signed else f"{values.min():.2f} to {values.max():.2f} mm"


def _outside(values_mm: dict[str, float], least: float, most: float) -> str:
    bad = [f"{name} {value:.2f}" for name, value in values_mm.items() if not least <= value <= most]
    return f" ({', '.join(bad)})" if bad else ""
