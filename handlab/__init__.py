"""handlab: an anatomical human hand whose muscles move its bones.

>>> import handlab as hl
>>> hand = hl.load_hand()
>>> clip = hl.simulate(hand, hl.keyframes("fist"), hold=["wrist"])

Importing this module loads nothing but itself: every name below brings its module along when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from handlab.anatomy.load import load_hand
    from handlab.anatomy.records import Hand, Muscle
    from handlab.fitting.fit import fit_photo, fit_points
    from handlab.fitting.retarget import retarget
    from handlab.show.balance_plots import torque_balance
    from handlab.show.bulge_figure import bulge_figure
    from handlab.show.curves import curves
    from handlab.show.excursion_plots import excursion_plot
    from handlab.show.fit_panel import FitPanel
    from handlab.show.force_length_plots import force_length
    from handlab.show.inertia_plots import inertia_table_errors, wrist_inertia
    from handlab.show.paint_panel import PaintPanel
    from handlab.show.panels import MusclePanel
    from handlab.show.plots import lever_arm_map
    from handlab.show.save import save
    from handlab.show.sheet import sheet
    from handlab.show.skins_figure import skins_figure
    from handlab.show.step_plots import step_plot
    from handlab.show.strength_plots import brand_plot, pull_map
    from handlab.show.two_hands import two_hands
    from handlab.show.view import view
    from handlab.show.wrist_plots import wrist_plot
    from handlab.simulation.clip import Clip
    from handlab.simulation.geometric_muscle import geometric_muscles
    from handlab.simulation.inertia_tables import inertia_tables
    from handlab.simulation.keyframes import KeyFrames, clips, keyframes
    from handlab.simulation.laws import Laws
    from handlab.simulation.play import simulate
    from handlab.simulation.settle import settle
    from handlab.simulation.skeleton import pose, rest, step
    from handlab.simulation.soft_skin import soft_skin
    from handlab.simulation.state import State
    from handlab.simulation.to_mjcf import to_mjcf

__version__ = "0.1.0"

# Public name -> module that defines it (PEP 562).
_HOME = {
    "load_hand": "handlab.anatomy.load",
    "Hand": "handlab.anatomy.records",
    "Muscle": "handlab.anatomy.records",
    "State": "handlab.simulation.state",
    "rest": "handlab.simulation.skeleton",
    "step": "handlab.simulation.skeleton",
    "pose": "handlab.simulation.skeleton",
    "KeyFrames": "handlab.simulation.keyframes",
    "keyframes": "handlab.simulation.keyframes",
    "clips": "handlab.simulation.keyframes",
    "Clip": "handlab.simulation.clip",
    "Laws": "handlab.simulation.laws",
    "simulate": "handlab.simulation.play",
    "settle": "handlab.simulation.settle",
    "curves": "handlab.show.curves",
    "lever_arm_map": "handlab.show.plots",
    "force_length": "handlab.show.force_length_plots",
    "brand_plot": "handlab.show.strength_plots",
    "pull_map": "handlab.show.strength_plots",
    "excursion_plot": "handlab.show.excursion_plots",
    "torque_balance": "handlab.show.balance_plots",
    "wrist_plot": "handlab.show.wrist_plots",
    "step_plot": "handlab.show.step_plots",
    "inertia_tables": "handlab.simulation.inertia_tables",
    "wrist_inertia": "handlab.show.inertia_plots",
    "inertia_table_errors": "handlab.show.inertia_plots",
    "to_mjcf": "handlab.simulation.to_mjcf",
    "save": "handlab.show.save",
    "sheet": "handlab.show.sheet",
    "view": "handlab.show.view",
    "MusclePanel": "handlab.show.panels",
    "bulge_figure": "handlab.show.bulge_figure",
    "skins_figure": "handlab.show.skins_figure",
    "two_hands": "handlab.show.two_hands",
    "retarget": "handlab.fitting.retarget",
    "fit_points": "handlab.fitting.fit",
    "fit_photo": "handlab.fitting.fit",
    "find_landmarks": "handlab.fitting.found",
    "soft_skin": "handlab.simulation.soft_skin",
    "geometric_muscles": "handlab.simulation.geometric_muscle",
    "PaintPanel": "handlab.show.paint_panel",
    "FitPanel": "handlab.show.fit_panel",
}

__all__ = [
    "Clip",
    "FitPanel",
    "Hand",
    "KeyFrames",
    "Laws",
    "Muscle",
    "MusclePanel",
    "PaintPanel",
    "State",
    "__version__",
    "brand_plot",
    "bulge_figure",
    "clips",
    "curves",
    "excursion_plot",
    "fit_photo",
    "fit_points",
    "force_length",
    "geometric_muscles",
    "inertia_table_errors",
    "inertia_tables",
    "keyframes",
    "lever_arm_map",
    "load_hand",
    "pose",
    "pull_map",
    "rest",
    "retarget",
    "save",
    "settle",
    "sheet",
    "simulate",
    "skins_figure",
    "soft_skin",
    "step",
    "step_plot",
    "to_mjcf",
    "torque_balance",
    "two_hands",
    "view",
    "wrist_inertia",
    "wrist_plot",
]


def __getattr__(name: str) -> Any:
    """Import what is asked for, once."""
    if name not in _HOME:
        raise AttributeError(f"module 'handlab' has no attribute {name!r}; it offers {', '.join(sorted(_HOME))}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """What completion offers."""
    return sorted(__all__)
