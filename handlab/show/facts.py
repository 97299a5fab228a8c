"""What ``handlab info`` and ``handlab doctor`` print: plain text tables."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from handlab.anatomy.records import Hand
from handlab.show.doctor import Finding, check_drawing

PACKAGES = ("numpy", "scipy", "numba", "pyvista", "vtk", "matplotlib", "imageio-ffmpeg", "pillow")


def table(headings: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Columns as wide as their widest entry; numbers to the right."""
    cells = [[str(cell) for cell in row] for row in rows]
    right = [all(row[k].lstrip("+-").replace(".", "", 1).isdigit() for row in cells if row[k]) for k in range(len(headings))]
    width = [max([len(heading), *(len(row[k]) for row in cells)]) for k, heading in enumerate(headings)]

    def line(row: Sequence[str]) -> str:
        return "  ".join(f"{cell:>{w}}" if r else f"{cell:<{w}}" for cell, w, r in zip(row, width, right, strict=True)).rstrip()

    return "\n".join([line(headings), line(["-" * w for w in width]), *(line(row) for row in cells)])


def meshes(hand: Hand) -> str:
    """Points, triangles and volume of the meshes."""
    parts = (
        ("skin (even, for physics)", [hand.skin]),
        ("skin (fine, for the eye)", [hand.skin_fine]),
        (f"{len(hand.bones)} bones", list(hand.bones.values())),
    )
    rows = [
        (name, sum(len(mesh.points) for mesh in own), sum(len(mesh.faces) for mesh in own), f"{1e6 * sum(mesh.volume for mesh in own):.1f}")
        for name, own in parts
    ]
    return table(("mesh", "points", "triangles", "volume cm3"), rows)


def muscles(hand: Hand) -> str:
    """Groups of muscles with their number and force."""
    groups: dict[str, list[int]] = {}
    for row, muscle in enumerate(hand.muscles.values()):
        groups.setdefault(muscle.region, []).append(row)
    names = [muscle.abbreviation for muscle in hand.muscles.values()]
    rows = [(name, len(own), f"{hand.max_force[own].sum():.0f}", " ".join(names[k] for k in own)) for name, own in groups.items()]
    rows.append(("all", len(names), f"{hand.max_force.sum():.0f}", ""))
    return table(("muscles", "number", "F_max N", "abbreviations"), rows)


def joints(hand: Hand) -> str:
    """Degrees of freedom with limits and relaxed angle in degrees."""
    limits, rest = np.rad2deg(hand.limits), np.rad2deg(hand.fibre_rest)
    rows = [
        (name, f"{low:.0f}", f"{high:.0f}", f"{angle:.1f}", "" if dof.driver is None else f"follows {dof.driver}")
        for (name, dof), (low, high), angle in zip(hand.dofs.items(), limits, rest, strict=True)
    ]
    return table(("degree of freedom", "from deg", "to deg", "relaxed deg", ""), rows)


def assumptions(hand: Hand) -> str:
    """Numbers that nobody measured for this hand, each settable."""
    added = sum(arm.assumption for muscle in hand.muscles.values() for arm in muscle.lever_arms)
    rows = [
        ("newton_per_percent", f"{hand.newton_per_percent:g}", "N per % of tension fraction: the sources give relative forces only"),
        ("friction", f"{np.mean(hand.friction):g}", "N m s/rad: the paper's 0.015 without unit, read as viscous"),
        ("added lever arms", added, "thumb rows that Table 1 lacks, from origin and insertion on these bones"),
    ]
    return table(("assumption", "value", "meaning"), rows)


def quality(hand: Hand) -> str:
    """Geometry measured against what a good hand must reach."""
    from handlab.studies.quality import quality as measure

    rows = [(what, measured, wanted, "yes" if ok else "NO") for what, measured, wanted, ok in measure(hand)]
    return table(("quality", "measured", "wanted", "ok"), rows)


def opposition(hand: Hand) -> str:
    """The Kapandji score: how far round the hand the thumb's pulp reaches."""
    from tqdm.auto import tqdm

    from handlab.studies.kapandji import kapandji

    with tqdm(total=100, desc="Kapandji score", unit="%", delay=1.0, leave=False, disable=None) as bar:
        found = kapandji(hand, progress=lambda done: bar.update(round(100 * done) - bar.n) and None)
    rows = [(stage.number, stage.target, f"{1e3 * stage.distance:.1f}", "yes" if stage.reached else "no") for stage in found.stages]
    summary = f"Kapandji score {found.score} of {len(rows)}: reach of the thumb's pulp with every joint inside its limits, muscles left out"
    return table(("stage", "the thumb's pulp to", "left mm", "reached"), rows) + "\n" + summary


def info(hand: Hand) -> str:
    """Everything above, one table after the other."""
    return "\n\n".join([repr(hand), meshes(hand), quality(hand), muscles(hand), joints(hand), opposition(hand), assumptions(hand)])


def findings() -> list[Finding]:
    """What doctor looks at, one after the other."""
    return [system(), packages(), data(), film(), check_drawing()]


def system() -> Finding:
    """Python and platform."""
    return Finding(True, f"Python {platform.python_version()}, {platform.system()} {platform.machine()}")


def packages() -> Finding:
    """Versions of what handlab stands on."""
    found, missing = [], []
    for name in PACKAGES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            missing.append(name)
    if missing:
        return Finding(False, f"not installed: {', '.join(missing)}", "install handlab again: python -m pip install handlab")
    return Finding(True, ", ".join(found))


def data() -> Finding:
    """Whether the hand loads."""
    from handlab.anatomy.load import load_hand

    try:
        return Finding(True, repr(load_hand()))
    except (OSError, ValueError, KeyError) as error:
        return Finding(False, f"the hand does not load: {error}", "install handlab again, or clone the whole repository")


def film() -> Finding:
    """Whether films can be written."""
    try:
        import imageio_ffmpeg

        return Finding(True, f"ffmpeg {imageio_ffmpeg.get_ffmpeg_version()}")
    except (ImportError, RuntimeError) as error:
        return Finding(False, f"no ffmpeg: {error}", "python -m pip install --force-reinstall imageio-ffmpeg; .gif and .png work without")
