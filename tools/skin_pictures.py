"""Pictures of the soft skin in every named clip and in the postures that strain it most: ``python -m tools.skin_pictures FOLDER``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import handlab as hl
from handlab.anatomy.records import Array, Hand
from handlab.show.lettering import write
from handlab.show.moments import Moment
from handlab.show.scene import Scene
from handlab.simulation.clip import Clip
from handlab.simulation.mechanics import coupled
from handlab.simulation.tendon_ridges import ridge_heights
from handlab.simulation.worn import worn
from tools.clips.targets import POSTURES

FPS = 60
SECONDS = 0.8  # on the way to a posture
HELD = 0.4
SOFT = "springs and muscles"
VIEWS = ("palm", "back", "radial", "oblique")
FINGERS = (2, 3, 4, 5)
# Degrees. A claw as after a lesion of ulnar and median nerve; counted numbers as they are aimed at; a flat hand that hangs down.
CLAW = {"mcp": -20.0, "pip": 75.0, "dip": 45.0}
FLAT = {f"{joint}{k}.flexion_extension": 0.0 for joint in ("mcp", "pip", "dip") for k in FINGERS}
STRAINED: dict[str, dict[str, float]] = {
    "claw": {f"{joint}{k}.flexion_extension": value for joint, value in CLAW.items() for k in FINGERS},
    "flat, wrist flexed": {**FLAT, "wrist.flexion_extension": 70.0},
    "flat, wrist extended": {**FLAT, "wrist.flexion_extension": -60.0},
}


def counted(name: str) -> dict[str, float]:
    """The middles of the windows that a posture of the clips is aimed at, and its wishes."""
    found = {}
    for dof, value in {**POSTURES[name].wish, **POSTURES[name].window}.items():
        found[dof] = float(np.mean(value))
    return found


def postures() -> dict[str, dict[str, float]]:
    """Angles in degrees by degree of freedom; what is not named stays relaxed."""
    return {**STRAINED, "three": counted("three"), "four": counted("four")}


def path(hand: Hand, degrees: dict[str, float], fps: int) -> Array:
    """Angles (T, dof) from the relaxed hand into a posture, evenly begun and ended, and held there."""
    start = np.array(hl.rest(hand).angle)
    goal = start.copy()
    for dof, value in degrees.items():
        goal[hand.dof_names.index(dof)] = np.deg2rad(value)
    moving = [hand.dof_names.index(name) for name in hand.moving_names]
    share = np.clip(np.arange(round((SECONDS + HELD) * fps)) / (SECONDS * fps), 0.0, 1.0)
    ease = share**2 * (3.0 - 2.0 * share)
    result: Array = np.stack([coupled(hand, (start + part * (goal - start))[moving]) for part in ease])
    return result


def motions(hand: Hand, fps: int = FPS) -> Iterator[tuple[str, Array, Array, Array]]:
    """Name, time (T,), angle (T, dof), contraction (T, muscle) of every clip, then of every strained posture."""
    for name in hl.clips():
        clip: Clip = hl.simulate(hand, name, fps=fps)
        yield name, clip.time, clip.angle, clip.contraction
    for name, degrees in postures().items():
        angle = path(hand, degrees, fps)
        yield name, np.arange(len(angle)) / fps, angle, np.zeros((len(angle), len(hand.muscles)))


def main() -> None:
    """Draw a row of pictures for the end of every motion."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--size", type=int, default=900)
    parser.add_argument("--only", nargs="*", default=None)
    chosen = parser.parse_args()
    chosen.folder.mkdir(parents=True, exist_ok=True)
    hand, size = hl.load_hand(), chosen.size
    with Scene(hand, size=(size, size), quality="still") as scene:
        for name, time, angle, contraction in motions(hand):
            if chosen.only is not None and name not in chosen.only:
                continue
            skin = worn(hand, time, angle, contraction, SOFT).points(-1)
            scene.pose(Moment(float(time[-1]), skin, angle[-1], raised=ridge_heights(hand, angle[-1], contraction[-1])))
            row = Image.new("RGB", (size * len(VIEWS), size))
            for k, view in enumerate(VIEWS):
                scene.set(view=view)
                scene.frame([skin])
                row.paste(Image.fromarray(scene.picture()), (k * size, 0))
            write(ImageDraw.Draw(row), (0.02 * size, 0.05 * size), name, 0.04 * size, colour="#1F2933", bold=True)
            row.save(chosen.folder / f"{name.replace(', ', '-').replace(' ', '-')}.png")


if __name__ == "__main__":
    main()
