"""Films: H.264 in .mp4 through the ffmpeg that imageio-ffmpeg brings, and .gif through Pillow."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from handlab.show.moments import Moment, Story
from handlab.show.outputs import progress
from handlab.show.scene import Picture
from handlab.show.tiles import Layout, Tiles
from handlab.simulation.writing import whole_file

GIF_MOST = 25  # viewers slow a .gif down that wants to be faster
QUALITY = 8  # imageio's scale to 10


def times(story: Story, fps: float) -> list[float]:
    """Seconds of every frame, the last one at or just before the end; one frame for a single state."""
    return [k / fps for k in range(int(story.seconds * fps + 1e-9) + 1)]


def frames(story: Story, plan: Layout, fps: float, what: str) -> Iterator[Picture]:
    """Every frame as a picture."""
    tiles = Tiles(story, plan)
    try:
        moments: list[float] = times(story, fps)
        for time in progress(moments, what, len(moments)):
            moment: Moment = story.at(time)
            yield tiles.picture(moment)
    finally:
        tiles.close()


def write_mp4(story: Story, out: Path, plan: Layout, fps: float) -> None:
    """A film that every player shows (H.264, yuv420p)."""
    import imageio_ffmpeg

    with whole_file(out) as temporary:
        writer: Any = imageio_ffmpeg.write_frames(
            str(temporary), plan.size, fps=fps, codec="libx264", quality=QUALITY, macro_block_size=2, ffmpeg_log_level="error",
            output_params=["-movflags", "+faststart"],
        )  # fmt: skip
        writer.send(None)
        try:
            for frame in frames(story, plan, fps, out.name):
                writer.send(frame)
        finally:
            writer.close()


def write_gif(story: Story, out: Path, plan: Layout, fps: float) -> None:
    """A moving picture without a player; it repeats for ever."""
    from PIL import Image

    fps = min(fps, GIF_MOST)
    # One palette for all frames, from the middle of the film, keeps the background from flickering.
    pictures = [Image.fromarray(frame) for frame in frames(story, plan, fps, out.name)]
    palette = pictures[len(pictures) // 2].quantize(255, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    reduced = [picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG) for picture in pictures]
    with whole_file(out) as temporary:
        reduced[0].save(temporary, format="GIF", save_all=True, append_images=reduced[1:], duration=1000 / fps, loop=0, optimize=False)
