"""Our hand and a picture of the hand it was made from, side by side in three poses: ``python -m tools.figure7``.

In the manner of the paper's figure 7: one camera, no texture, joint angles compared. A person who was never used to choose anything
(``tools.people.fresh``) is photographed lying flat, and the hand is fitted to 26 clicks. The person then strikes a pose by rotations
about its own joints; our hand strikes it by contracting muscles. Needs what the tests need.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import handlab as hl
from handlab.anatomy.records import Array, Hand
from handlab.fitting.fit import fit_photo
from handlab.fitting.marks import bound_centres
from handlab.simulation.balance import contraction_for
from handlab.simulation.skin import blend, fine_points
from tools.people.rig import moved

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "docs" / "pictures" / "figure_7.png"
PERSON, SEED = "woman_3", 7
WRIST = ("wrist.flexion_extension", "wrist.deviation")  # lies on the table

BENT = np.deg2rad(35.0)


def _flexed(*fingers: str, mcp: float, pip: float, dip: float) -> dict[str, float]:
    return {f"{joint}{k}.flexion_extension": turn for k in fingers for joint, turn in (("mcp", mcp), ("pip", pip), ("dip", dip))}


THUMB = {"cmc1.flexion_opposition": 14.0, "cmc1.abduction_adduction": 8.0, "mcp1.flexion_extension": 25.0, "ip1.flexion_extension": 25.0}
# Rotations in degrees from the pose in which the hand was photographed.
POSES: dict[str, dict[str, float]] = {
    "hand on a mouse": {
        **_flexed("3", "4", "5", mcp=22, pip=26, dip=10),
        **_flexed("2", mcp=4, pip=14, dip=4),
        "mcp1.flexion_extension": 6,
    },
    "pointing": {**_flexed("3", "4", "5", mcp=52, pip=68, dip=26), **THUMB},
    "victory": {**_flexed("4", "5", mcp=58, pip=70, dip=28), **THUMB, "mcp2.deviation": 7.0, "mcp3.deviation": -7.0},
}
CHAINS = {1: ("cmc1", "mcp1", "ip1", "tip1"), **{k: (f"cmc{k}", f"mcp{k}", f"pip{k}", f"dip{k}", f"tip{k}") for k in range(2, 6)}}
JOINTS = tuple(joint for chain in CHAINS.values() for joint in chain[1:-1])


@dataclass(frozen=True, eq=False)
class Pose:
    """One column of the sheet. ``person``, ``ours``: angles in degrees by joint; skins (N, 3) m; ``contraction`` that was found."""

    title: str
    person: dict[str, float]
    ours: dict[str, float]
    person_skin: Array
    our_skin: Array
    contraction: Array

    @property
    def off(self) -> dict[str, float]:
        """Our angle less the person's, degrees."""
        return {joint: self.ours[joint] - self.person[joint] for joint in self.person}


def someone() -> tuple[Any, Hand]:
    """The person and the hand fitted to its photograph."""
    sys.path.insert(0, str(ROOT / "tests" / "fitting"))  # people and pictures are those of the tests
    import people
    import photograph

    person = people.everyone(people.FRESH)[PERSON]
    picture = photograph.photograph(person, camera="pinhole", view="dorsal", seed=SEED)
    rng = np.random.default_rng(SEED)
    scale = {"ruler": picture.ruler_clicks(rng), "mm": photograph.RULER_MM}
    fit = fit_photo(picture.pixels, landmarks=picture.clicks(rng), scale=scale, view="dorsal", camera_mm=1e3 * photograph.DISTANCE)
    return person, fit.hand


def compared() -> list[Pose]:
    """The three poses struck by both."""
    person, hand = someone()
    return [_pose(title, turn, person, hand) for title, turn in POSES.items()]


def _pose(title: str, turn: dict[str, float], person: Any, hand: Hand) -> Pose:
    skin, centres = moved(person, hl.load_hand(), turn)
    wanted = bends(centres)
    aim = np.array(hand.bind)
    for name, degrees in turn.items():
        aim[hand.dof_names.index(name)] += np.deg2rad(degrees)
    for _ in range(3):  # what an animator does by eye: each joint as bent as in the picture
        have = bends(our_centres(hand, aim))
        for joint in JOINTS:
            aim[hand.dof_names.index(f"{joint}.flexion_extension")] += np.deg2rad(wanted[joint] - have[joint])
        for k in "2345":  # the collateral ligaments hold bent fingers side by side
            if aim[hand.dof_names.index(f"mcp{k}.flexion_extension")] > BENT:
                aim[hand.dof_names.index(f"mcp{k}.deviation")] = 0.0
        aim = np.clip(aim, *hand.limits.T)
        start = hl.pose(hand, {name: aim[hand.dof_names.index(name)] for name in hand.moving_names})
        aim = np.array(start.angle)  # with what follows other joints
    found = contraction_for(hand, aim, hold=WRIST)
    rest = hl.settle(hand, found.contraction, start, hold=WRIST, look_for_others=False).state
    have = bends(our_centres(hand, rest.angle))
    return Pose(title, wanted, have, skin, fine_points(hand, blend(hand, rest.angle)), found.contraction)


def our_centres(hand: Hand, angle: Array) -> dict[str, Array]:
    """Joint centres and tips of a hand in a posture."""
    centres = bound_centres(hand.with_(bind=angle))
    skin = blend(hand, angle)
    for k, finger in enumerate(("thumb", "index", "middle", "ring", "little"), start=1):
        centres[f"tip{k}"] = skin[hand.feature_points[f"tip_{finger}"]["dorsal"]]
    return centres


def bends(centres: dict[str, Array]) -> dict[str, float]:
    """Angles in degrees between neighbouring bones, from the joints' centres in space alone."""
    found = {}
    for chain in CHAINS.values():
        way = [(centres[b] - centres[a]) / np.linalg.norm(centres[b] - centres[a]) for a, b in pairwise(chain)]
        for joint, one, other in zip(chain[1:-1], way[:-1], way[1:], strict=True):
            found[joint] = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other)))
    return found


def draw(poses: list[Pose], path: Path = FILE) -> Path:
    """The sheet: ours above, the person below, angles of both."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    faces = hl.load_hand().skin_fine.faces
    figure, axes = plt.subplots(3, len(poses), figsize=(15, 16), height_ratios=(1, 1, 0.6), layout="constrained")
    for column, pose in enumerate(poses):
        camera = _camera(pose.person_skin)
        for row, (skin, who) in enumerate(
            ((pose.our_skin, "fitted hand, moved by its muscles"), (pose.person_skin, "the person, same camera"))
        ):
            axes[row, column].imshow(_picture(_over(skin, pose.person_skin), faces, camera))
            axes[row, column].set_axis_off()
            axes[row, column].set_title(f"{pose.title}\n{who}" if row == 0 else who, fontsize=17)
        _bars(axes[2, column], pose, column == 0)
    figure.savefig(path, dpi=80)
    plt.close(figure)
    return path


def _over(skin: Array, person: Array) -> Array:
    """``skin`` laid over the person by what does not move, the forearm and the back of the hand (same triangles, same points)."""
    rest = hl.load_hand().skin_fine.points
    still = (rest[:, 0] < 0.03) & (rest[:, 2] < 0.015)
    a, b = skin[still], person[still]
    left, _, right = np.linalg.svd((b - b.mean(axis=0)).T @ (a - a.mean(axis=0)))
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    result: Array = (skin - a.mean(axis=0)) @ turn.T + b.mean(axis=0)
    return result


def _camera(skin: Array) -> list[tuple[float, ...]]:
    """From the back of the hand, the thumb's side and beyond the finger tips."""
    middle = (skin.min(axis=0) + skin.max(axis=0)) / 2
    way = np.array([0.55, -0.75, 0.62])
    return [tuple(middle + 0.62 * way / np.linalg.norm(way)), tuple(middle), (1.0, 0.35, 0.0)]


def _picture(points: Array, faces: Array, camera: list[tuple[float, ...]]) -> Array:
    import pyvista as pv

    mesh = pv.PolyData.from_regular_faces(points, faces)
    canvas = pv.Plotter(off_screen=True, window_size=(800, 1000), lighting="none")
    canvas.set_background("white")
    canvas.add_mesh(mesh.compute_normals(split_vertices=False), color="#e3c3b0", smooth_shading=True, ambient=0.25, diffuse=0.75)
    canvas.camera_position = camera
    canvas.camera.view_angle = 19.5
    eye, middle, up = (np.array(v) for v in camera)
    across = np.cross(middle - eye, up) / np.linalg.norm(np.cross(middle - eye, up))
    for light, strength in ((eye - 0.5 * across + 0.4 * up, 0.75), (eye + 0.8 * across - 0.2 * up, 0.35)):
        canvas.add_light(pv.Light(position=tuple(light), focal_point=tuple(middle), intensity=strength))
    canvas.enable_anti_aliasing("ssaa")
    picture: Array = canvas.screenshot(return_img=True)
    canvas.close()
    return picture


def _bars(axes: Any, pose: Pose, first: bool) -> None:
    """Angles of both as pairs of marks, joint by joint."""
    y = np.arange(len(JOINTS))[::-1]
    for joint, height in zip(JOINTS, y, strict=True):
        axes.plot([pose.person[joint], pose.ours[joint]], [height, height], color="0.6", zorder=1)
    axes.scatter([pose.person[j] for j in JOINTS], y, s=80, marker="o", facecolor="white", edgecolor="#0072b2", linewidth=2, label="person")
    axes.scatter([pose.ours[j] for j in JOINTS], y, s=55, marker="x", color="#d55e00", linewidth=2, label="fitted hand")
    axes.set_yticks(y, [f"{joint[:-1].upper()} {joint[-1]}" for joint in JOINTS], fontsize=12)
    axes.tick_params(axis="x", labelsize=12)
    axes.set_xlabel("angle between the bones, degrees", fontsize=14)
    axes.set_title(f"mean difference {np.mean(np.abs(list(pose.off.values()))):.1f} degrees", fontsize=15)
    axes.set_xlim(0, 100)
    axes.grid(axis="x", color="0.9")
    if first:
        axes.legend(fontsize=13, loc="upper right", framealpha=1.0)


if __name__ == "__main__":
    found = compared()
    for one in found:
        print(one.title, {joint: f"{one.person[joint]:.0f}/{one.ours[joint]:.0f}" for joint in JOINTS})
    print(draw(found, Path(sys.argv[1]) if len(sys.argv) > 1 else FILE))
