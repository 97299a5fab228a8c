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
    from handlab.show.curves import curves
    from handlab.show.panels import MusclePanel
    from handlab.show.plots import force_length, lever_arm_map
    from handlab.show.save import save
    from handlab.show.sheet import sheet
    from handlab.show.view import view
    from handlab.simulation.clip import Clip
    from handlab.simulation.keyframes import KeyFrames, clips, keyframes
    from handlab.simulation.laws import Laws
    from handlab.simulation.play import simulate
    from handlab.simulation.settle import settle
    from handlab.simulation.skeleton import pose, rest, step
    from handlab.simulation.state import State

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
    "force_length": "handlab.show.plots",
    "save": "handlab.show.save",
    "sheet": "handlab.show.sheet",
    "view": "handlab.show.view",
    "MusclePanel": "handlab.show.panels",
}

__all__ = [
    "Clip",
    "Hand",
    "KeyFrames",
    "Laws",
    "Muscle",
    "MusclePanel",
    "State",
    "__version__",
    "clips",
    "curves",
    "force_length",
    "keyframes",
    "lever_arm_map",
    "load_hand",
    "pose",
    "rest",
    "save",
    "settle",
    "sheet",
    "simulate",
    "step",
    "view",
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
