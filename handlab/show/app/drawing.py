"""Films and pictures, drawn in a process of their own: a crash in the graphics driver must not take the live hand with it.

The process reads a recording (arrays only, nothing that could be code), writes one file and says in one line what went wrong.
"""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from handlab.anatomy.records import Hand, frozen
from handlab.anatomy.store import save_hand
from handlab.show.keepsakes import kept_skin
from handlab.show.outfits import BLEND
from handlab.simulation.clip import Clip

ARRAYS = ("time", "contraction", "angle", "speed", "fibre_length", "force", "torque")
SKIN = "skin"
LONGEST_S = 600.0


class DrawingFailed(RuntimeError):  # noqa: N818 (reads as what it is)
    """No file came out; the message says why in one sentence."""


def pack(clip: Clip, path: Path) -> None:
    """Write the arrays of a clip, and its soft skin if it has one."""
    soft = {} if clip.worn is None else {SKIN: clip.worn.all_points()}
    np.savez(path, **{name: getattr(clip, name) for name in ARRAYS}, **soft)


def unpack(path: Path, hand: Hand, fps: float, name: str, wear: str = BLEND, muscles: str = "both") -> Clip:
    """Read what ``pack`` wrote."""
    with np.load(path, allow_pickle=False) as kept:
        worn = kept_skin(wear, kept[SKIN]) if SKIN in kept else None
        arrays: dict[str, Any] = {name: frozen(kept[name]) for name in ARRAYS}
        return Clip(hand=hand, **arrays, fps=fps, name=name, worn=worn, muscles=muscles)


async def draw(clip: Clip, out: Path, how: Mapping[str, Any], folder: Path) -> None:
    """Write ``out`` (.png, .mp4, .gif) of a clip in another process; ``folder`` takes the recording for as long as it lasts.

    ``how`` holds the plain arguments of ``picture_plan``. Raises ``DrawingFailed``.
    """
    recording, job, own = folder / f"{out.stem}.npz", folder / f"{out.stem}.json", folder / f"{out.stem}.hand"
    hand = clip.hand
    shaped = "shape" in hand.sources  # not the reference hand, which the other process has at hand
    about = {
        "recording": str(recording), "out": str(out), "fps": clip.fps, "name": clip.name,
        "side": hand.side, "reading": hand.reading, "newton_per_percent": hand.newton_per_percent, "how": dict(how),
        "wear": clip.wear, "muscles": clip.muscles, "hand": str(own) if shaped else None,
    }  # fmt: skip
    process = None
    try:
        await asyncio.to_thread(pack, clip, recording)
        if shaped:
            await asyncio.to_thread(save_hand, hand, own)
        job.write_text(json.dumps(about), encoding="utf-8")
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "handlab.show.app.drawing", str(job),
            stdin=asyncio.subprocess.DEVNULL, stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE,
            start_new_session=os.name == "posix",  # Ctrl-C goes to the server, which ends it
        )  # fmt: skip
        _, said = await asyncio.wait_for(process.communicate(), LONGEST_S)
        if process.returncode:
            raise DrawingFailed(why(process.returncode, said.decode(errors="replace")))
    except OSError as error:
        raise DrawingFailed(f"cannot write the recording: {error.strerror or error}") from error
    except TimeoutError:
        raise DrawingFailed(f"drawing took longer than {LONGEST_S:g} s; choose a shorter clip or a smaller picture") from None
    finally:
        if process is not None and process.returncode is None:
            process.kill()
            await process.wait()
        for path in (recording, job):
            path.unlink(missing_ok=True)
        shutil.rmtree(own, ignore_errors=True)


def why(code: int, said: str) -> str:
    """The last line that the process wrote, or what its end means."""
    from handlab.show.doctor import remedy

    if code < 0:
        return f"drawing crashed in the graphics library; {remedy()}"
    lines = [line for line in said.strip().splitlines() if line.strip()]
    return lines[-1] if lines else f"drawing ended with code {code}"


def picture_plan(
    *,
    view: str = "palm",
    camera: Mapping[str, Any] | None = None,
    skin: str = "solid",
    bones: bool = True,
    muscles: bool = True,
    layers: Sequence[str] = (),
    size: tuple[int, int] = (1280, 720),
) -> Any:
    """A layout of one tile, seen from a named view or through the viewer's own ``camera``.

    ``camera``: unit vectors ``eye`` (from the hand to the eye) and ``up`` (3,), ``focus`` (3,) and ``distance`` in metres.
    """
    from dataclasses import replace

    from handlab.show.tiles import layout

    plan = layout(view, skin, bones, size, muscles, layers)
    return plan if camera is None else replace(plan, camera=aimed(camera))


def aimed(camera: Mapping[str, Any]) -> Any:
    """A ``Camera`` from the direction to the eye, what is up, the point looked at, and the distance."""
    from handlab.show.views import Camera

    eye, up, focus = (np.asarray(camera[key], dtype=np.float64) for key in ("eye", "up", "focus"))
    distance = float(camera["distance"])
    if not all(v.shape == (3,) and np.isfinite(v).all() for v in (eye, up, focus)) or not 0.01 < distance < 10.0:
        raise ValueError("the camera must look at the hand from between 1 cm and 10 m")
    right = np.cross(up, eye)
    if not np.linalg.norm(eye) > 1e-6 or not np.linalg.norm(right) > 1e-6:
        raise ValueError("the camera looks along its own up direction")
    eye, right = eye / np.linalg.norm(eye), right / np.linalg.norm(right)
    return Camera(eye, np.cross(eye, right), right, focus, distance)


def main(job: Path) -> None:
    """What the process does."""
    from handlab.anatomy.load import load_hand
    from handlab.show.moments import Story
    from handlab.show.save import WRITERS

    about = json.loads(job.read_text(encoding="utf-8"))
    hand = load_hand(about["hand"], side=about["side"], reading=about["reading"]).with_newton_per_percent(about["newton_per_percent"])
    clip = unpack(Path(about["recording"]), hand, about["fps"], about["name"], about["wear"], about["muscles"])
    how, out = dict(about["how"]), Path(about["out"])
    rate = float(how.pop("fps", 30.0))
    if "size" in how:
        how["size"] = tuple(how["size"])
    told = Story(hand, clip=clip) if len(clip) > 1 else Story(hand, state=clip.states[0])
    WRITERS[out.suffix](told, out, picture_plan(**how), rate)


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]))
    except Exception as error:  # the other side shows this line to the user
        sys.exit(" ".join((str(error) or type(error).__name__).split()))
