"""The biharmonic warp of 30,000 points by 26 centres against scipy and VTK, interleaved: rows for ``benchmarks/run.py``."""

from __future__ import annotations

import json
import time

import numpy as np

POINTS, CENTRES, ROUNDS = 30_000, 26, 15


def measured() -> dict[str, float]:
    """Milliseconds, medians of the rounds: ours, scipy, VTK, and a whole fit of the reference hand from 26 clicks; and how many times
    ours scipy and VTK took, each round against itself."""
    from scipy.interpolate import RBFInterpolator
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonTransforms import vtkThinPlateSplineTransform

    import handlab as hl
    from handlab.fitting.fit import fit_points
    from handlab.fitting.landmarks import NAMES
    from handlab.physics import rbf

    rng = np.random.default_rng(0)
    source = rng.normal(size=(CENTRES, 3)) * [0.05, 0.04, 0.008]
    target = 1.1 * source + 0.004 * rng.normal(size=source.shape)
    query = 0.1 * rng.normal(size=(POINTS, 3))

    warp, scipy = rbf.fitted(source, target), RBFInterpolator(source, target, kernel="linear", degree=1)
    spline = vtkThinPlateSplineTransform()
    spline.SetBasisToR()
    spline.SetSigma(1.0)
    kept = [numpy_to_vtk(values, deep=True) for values in (source, target, query)]
    marks = [vtkPoints() for _ in kept]
    for points, values in zip(marks, kept, strict=True):
        points.SetDataTypeToDouble()
        points.SetData(values)
    spline.SetSourceLandmarks(marks[0])
    spline.SetTargetLandmarks(marks[1])
    spline.Update()

    def vtk() -> None:
        out = vtkPoints()
        out.SetDataTypeToDouble()
        spline.TransformPoints(marks[2], out)

    hand = hl.load_hand()
    clicks = {name: (-1e4 * p[2], -1e4 * p[0]) for name in NAMES for p in [hand.skin.points[hand.feature_points[name]["palmar"]]]}
    query.setflags(write=False)
    works = {
        "ours": lambda: warp(query),
        "scipy": lambda: scipy(query),
        "vtk": vtk,
        "fit": lambda: fit_points(hand, clicks, 0.1, view="palmar", side="left"),
    }
    for work in works.values():
        work()
    took: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(ROUNDS):
        for name, work in works.items():
            start = time.perf_counter()
            work()
            took[name].append(1e3 * (time.perf_counter() - start))
    ratio = {f"{peer}/ours": np.divide(took[peer], took["ours"]) for peer in ("scipy", "vtk")}
    return {name: float(np.median(values)) for name, values in {**took, **ratio}.items()}


if __name__ == "__main__":
    print(json.dumps(measured()))
