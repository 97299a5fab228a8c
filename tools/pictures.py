"""Draw every picture of the README: ``python -m tools.pictures``."""

from __future__ import annotations

from pathlib import Path

import handlab as hl

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "pictures"
HELD = {"open": "open", "fist": "fist", "pinch": "pinch", "ok": "OK", "opposition-little": "opposition"}


def main() -> None:
    """Sheets of postures, curves of one clip, the lever arms and the force-length plot."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    hand = hl.load_hand()
    fist = hl.simulate(hand, hl.keyframes("fist"))
    moments = {
        "relaxed": fist.states[0],
        "closing": fist.states[int(0.55 * hl.keyframes("fist").time[2] * fist.fps)],
        "fist": fist.states[-1],
    }
    hl.sheet(hand, moments, FOLDER / "fist.png")
    held = {title: hl.simulate(hand, hl.keyframes(name)).states[-1] for name, title in HELD.items()}
    hl.sheet(hand, held, FOLDER / "postures.png", skin=["solid", "translucent"])
    hl.sheet(hand, {"relaxed": fist.states[0], **{k: held[k] for k in ("open", "fist")}}, FOLDER / "bones.png", skin=["hidden"])
    hl.save(hl.curves(fist, muscles=["FDP2", "FDS2", "EDC2", "LUM1"], joints=["mcp2", "pip2", "dip2"]), FOLDER / "curves.png")
    hl.save(hl.lever_arm_map(hand), FOLDER / "lever_arms.png")
    hl.save(hl.force_length(hand, fist.states[-1]), FOLDER / "force_length.png")


if __name__ == "__main__":
    main()
