"""A film and a sheet of one clip: what a first look at the hand needs."""

from __future__ import annotations

from pathlib import Path

from handlab.show.save import save
from handlab.show.sheet import sheet
from handlab.show.views import FOUR_SIDES
from handlab.simulation.clip import Clip


def draw(clip: Clip, folder: Path, *, size: tuple[int, int], fps: float) -> tuple[Path, Path]:
    """Write a clip from four sides, solid and translucent, as a film, and three of its moments as a sheet, into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    name = clip.name or "clip"
    film = save(clip, folder / f"{name}.mp4", view=FOUR_SIDES, skin=["solid", "translucent"], size=size, fps=fps)
    picture = folder / f"{name}.png"
    sheet(clip.hand, {f"{clip.time[k]:.1f} s": clip.states[k] for k in (0, len(clip) // 3, len(clip) - 1)}, picture)
    return film, picture
