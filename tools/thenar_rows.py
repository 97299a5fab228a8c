"""Lever arms of three thenar muscles at the thumb's MCP joint, from straight lines on the reference hand's bones.

``python -m tools.thenar_rows`` writes ``assets/anatomy/thenar_rows.json``. Table 1 gives abductor pollicis brevis, flexor
pollicis brevis and adductor pollicis no MCP row, though they cross that joint. Here each is a bundle of straight lines from
points of its origin to one point that moves with proximal phalanx 1; lever arm = -dL/dangle about the flexion axis of mcp1 in
the relaxed posture, the mean of the lines. Wrapping is ignored: an assumption, and marked as one.

Where a line ends decides the size. On the tubercles of the phalanx's base the lines would pass 3 to 5 mm palmar of the axis,
through the metacarpal's head, which reaches 5 mm: right for the abductor, which passes beside the head to the radial
tubercle, impossible for the short flexor and the adductor. Their tendons hold the radial and the ulnar sesamoid, which ride
on the palmar face of the head and move with the phalanx. The bone set has no sesamoids; here each lies at the level of the
axis on its half of the head, its middle half of its own thickness palmar of the bone.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import handlab as hl
from handlab.simulation.kinematics import posed_axes, posed_bone, relative_transforms

FILE = Path(__file__).resolve().parents[1] / "assets" / "anatomy" / "thenar_rows.json"
DOF = "mcp1.flexion_extension"
PHALANX = "proximal_phalanx_1"
OUTERMOST = 0.1  # share of a bone's points that count as its edge, tubercle or face (assumption)
BASE = 0.2  # share of a long bone's length that counts as its base (assumption)
SESAMOID_LEVEL = 0.003  # this far proximal and distal of the axis (assumption: a sesamoid is about 6 mm long)
SESAMOID_MIDDLE = 0.002  # palmar of the metacarpal's head (assumption: a sesamoid is about 4 mm thick)
TRANSVERSE = (0.35, 0.55, 0.75)  # the transverse head arises from the distal two thirds of metacarpal 3, short of its head
STEP = 1e-4  # radians
DECIMALS = 1  # of a millimetre

# directions of the hand's frame: x distal, y palmar, z radial
PALMAR, DISTAL_PALMAR = (0.0, 1.0, 0.0), (1.0, 1.0, 0.0)


Part = Callable[[np.ndarray], np.ndarray]  # points of a bone -> which of them


class Bones:
    """The bones of one hand in its relaxed posture, and points on them in anatomy's words."""

    def __init__(self, hand: hl.Hand) -> None:
        self.hand = hand
        self.angle = np.array(hand.fibre_rest)
        axis, anchor = posed_axes(hand, self.angle)
        self.axis, self.joint = (array[hand.dof_names.index(DOF)] for array in (axis, anchor))
        along = anchor[hand.dof_names.index("ip1.flexion_extension")] - self.joint
        along -= self.axis * (along @ self.axis)
        self.distal = along / np.linalg.norm(along)  # of the thumb
        self.palmar = np.cross(self.axis, self.distal)  # flexion turns distal towards palmar
        self.radial = np.cross(self.distal, self.palmar) if hand.side == "right" else np.cross(self.palmar, self.distal)

    def edge(self, bone: str, direction: ArrayLike, part: Part | None = None) -> np.ndarray:
        """Mean of the points of a bone, or a part of it, that lie outermost in a direction."""
        points = posed_bone(self.hand, bone, self.angle)
        if part is not None:
            points = points[part(points)]
        far = points @ np.asarray(direction, dtype=float)
        return points[far >= np.quantile(far, 1.0 - OUTERMOST)].mean(axis=0)

    def slice(self, low: float, high: float, direction: ArrayLike = (1.0, 0.0, 0.0)) -> Part:
        """Between two shares of a bone's length along a direction, 0 its base."""

        def within(points: np.ndarray) -> np.ndarray:
            along = points @ np.asarray(direction, dtype=float)
            share = (along - along.min()) / np.ptp(along)
            return (share >= low) & (share <= high)

        return within

    def radial_tubercle_of_the_base(self) -> np.ndarray:
        """Palmar-radial edge of the base of proximal phalanx 1."""
        return self.edge(PHALANX, self.palmar + self.radial, self.slice(0.0, BASE, self.distal))

    def sesamoid(self, side: float) -> np.ndarray:
        """Middle of the radial (``side`` 1) or ulnar (-1) sesamoid, on the palmar face of its half of metacarpal 1's head."""

        def half_of_head(points: np.ndarray) -> np.ndarray:
            beyond = points - self.joint
            return (np.abs(beyond @ self.distal) < SESAMOID_LEVEL) & (side * beyond @ self.radial > 0.0)

        return self.edge("metacarpal_1", self.palmar, half_of_head) + SESAMOID_MIDDLE * self.palmar

    def lever_arm(self, origins: list[np.ndarray], insertion: np.ndarray) -> float:
        """Mean over the lines of -dL/dangle; the insertion moves with proximal phalanx 1."""
        column, body = self.hand.dof_names.index(DOF), self.hand.body_names.index(PHALANX)
        back = np.linalg.inv(relative_transforms(self.hand, self.angle)[body])
        length = []
        for change in (STEP, -STEP):
            angle = self.angle.copy()
            angle[column] += change
            moved = relative_transforms(self.hand, angle)[body] @ back @ np.append(insertion, 1.0)
            length.append(np.linalg.norm(np.array(origins) - moved[:3], axis=1).mean())
        return float((length[1] - length[0]) / (2.0 * STEP))


def lever_arms(hand: hl.Hand) -> dict[str, float]:
    """Muscle -> lever arm in metres, flexion positive."""
    bones = Bones(hand)
    base_of_3 = bones.edge("metacarpal_3", PALMAR, bones.slice(0.0, BASE))
    base_of_2 = bones.edge("metacarpal_2", PALMAR, bones.slice(0.0, BASE))
    tubercles = [bones.edge("scaphoid", DISTAL_PALMAR), bones.edge("trapezium", PALMAR)]
    distal_palmar_edge_of_trapezium = bones.edge("trapezium", DISTAL_PALMAR)
    face_of_trapezoid, face_of_capitate = bones.edge("trapezoid", PALMAR), bones.edge("capitate", DISTAL_PALMAR)
    shaft_of_3 = [bones.edge("metacarpal_3", PALMAR, bones.slice(at - BASE / 2, at + BASE / 2)) for at in TRANSVERSE]
    radial_sesamoid, ulnar_sesamoid = bones.sesamoid(1.0), bones.sesamoid(-1.0)
    short_flexor = [distal_palmar_edge_of_trapezium, face_of_trapezoid, face_of_capitate]
    oblique = bones.lever_arm([face_of_capitate, base_of_2, base_of_3], ulnar_sesamoid)
    transverse = bones.lever_arm(shaft_of_3, ulnar_sesamoid)
    return {
        "abductor_pollicis_brevis": bones.lever_arm(tubercles, bones.radial_tubercle_of_the_base()),
        "flexor_pollicis_brevis": bones.lever_arm(short_flexor, radial_sesamoid),
        "adductor_pollicis": (oblique + transverse) / 2.0,
    }


REASONS = {
    "abductor_pollicis_brevis": "straight lines from the tubercles of scaphoid and trapezium to the radial tubercle of the base of "
    "proximal phalanx 1, beside the metacarpal's head; mean of -dL/dangle in the relaxed posture",
    "flexor_pollicis_brevis": "straight lines from the distal palmar edge of the trapezium and the palmar faces of trapezoid and capitate "
    "to the radial sesamoid, taken to ride on the palmar face of the head of metacarpal 1; mean of -dL/dangle in the relaxed posture",
    "adductor_pollicis": "straight lines to the ulnar sesamoid, taken to ride on the palmar face of the head of metacarpal 1, from "
    "capitate and bases of metacarpals 2 and 3 (oblique head) and from the shaft of metacarpal 3 (transverse head); mean of the two heads' "
    "-dL/dangle in the relaxed posture",
}


def table(hand: hl.Hand) -> dict[str, Any]:
    """What ``thenar_rows.json`` holds."""
    meta = {
        "title": "Thumb MCP rows of the thenar muscles that Table 1 lacks",
        "status": "computed on the bones of the reference hand by tools/thenar_rows.py",
        "remark": "Table 1 gives the three muscles CMC rows only, though they cross the MCP joint; without them the long flexor alone "
        "would flex it",
        "method": "lever arm = -dL/dangle of straight lines from origin to insertion about the flexion axis of mcp1; wrapping is ignored, "
        "and the bone set has no sesamoids: an assumption",
    }
    rows = [
        {
            "muscle": muscle,
            "dof": DOF,
            "used_mm": round(1000.0 * arm, DECIMALS),
            "status": "added",
            "assumption": True,
            "sources": ["ANAT", "LINES"],
            "reason": REASONS[muscle],
        }
        for muscle, arm in lever_arms(hand).items()
    ]
    return {"meta": meta, "rows": rows}


def main() -> None:
    """Write the table, and say what stands in it."""
    content = table(hl.load_hand())
    FILE.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    for row in content["rows"]:
        print(f"{row['muscle']:26} {row['used_mm']:+.1f} mm")


if __name__ == "__main__":
    main()
