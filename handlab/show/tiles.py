"""Pictures made of tiles: one hand from several sides and in several ways, with captions and the muscles beside it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from handlab.anatomy.terms import find
from handlab.show.colours import FAINT, PAPER
from handlab.show.lettering import write
from handlab.show.moments import Moment, Story
from handlab.show.muscle_panel import active, panel
from handlab.show.scene import Picture, Quality, Scene, skin_name
from handlab.show.views import Camera, same_scale, view_name

LAYERS = ("muscles", "tendons")
PANEL_SHARE = 0.30  # of the width of the picture
FRAMING_SAMPLES = 13


@dataclass(frozen=True)
class Layout:
    """Columns are ``views``, rows are ``skins``; ``size`` is the whole picture in pixels, ``muscles`` adds the panel.

    ``layers``: of ``LAYERS``, drawn under a skin that is not solid; ``camera`` replaces what the named views would frame.
    """

    views: tuple[str, ...] = ("palm",)
    skins: tuple[str, ...] = ("solid",)
    bones: bool = True
    size: tuple[int, int] = (800, 600)
    muscles: bool = True
    camera: Camera | None = None
    layers: tuple[str, ...] = ()

    @property
    def panel_width(self) -> int:
        """Width of the muscle panel in pixels."""
        return min(round(PANEL_SHARE * self.size[0]), 360) if self.muscles else 0

    @property
    def tile(self) -> tuple[int, int]:
        """Width and height of one tile."""
        return (self.size[0] - self.panel_width) // len(self.views), self.size[1] // len(self.skins)


def layout(
    view: str | Sequence[str] = "palm",
    skin: str | Sequence[str] = "solid",
    bones: bool = True,
    size: tuple[int, int] = (800, 600),
    muscles: bool = True,
    layers: Sequence[str] = (),
) -> Layout:
    """A layout from what a caller writes: one name or several. Every name and number is checked here, before anything is drawn."""
    views = tuple(view_name(name) for name in ([view] if isinstance(view, str) else view))
    skins = tuple(skin_name(name) for name in ([skin] if isinstance(skin, str) else skin))
    if not views or not skins:
        raise ValueError("name at least one view and one way to draw the skin")
    width, height = (int(number) for number in size)
    if not (64 <= width <= 8192 and 64 <= height <= 8192):
        raise ValueError(f"size is {width} x {height}; both must lie between 64 and 8192 pixels")
    # H.264 halves the resolution of colour: odd sizes do not exist for it.
    under = tuple(find(name, LAYERS, kind="layer") for name in ([layers] if isinstance(layers, str) else layers))
    return Layout(views, skins, bool(bones), (width - width % 2, height - height % 2), bool(muscles), layers=under)


class Tiles:
    """Draws the moments of a story in one layout, on one canvas that turns."""

    def __init__(self, story: Story, plan: Layout, *, quality: Quality = "film", framing: Iterable[Moment] | None = None) -> None:
        self.story = story
        self.rows = active(story) if plan.muscles else []
        self.plan = plan if self.rows else replace(plan, muscles=False)
        width, height = self.plan.tile
        self.scene = Scene(story.hand, size=(width, height), bones=plan.bones, layers=plan.layers, quality=quality)
        seen = list(framing) if framing is not None else story.sample(FRAMING_SAMPLES)
        self.cameras: dict[str, Camera] = same_scale(story.hand, plan.views, [moment.skin for moment in seen], width / height)
        if plan.camera is not None:
            self.cameras = dict.fromkeys(plan.views, plan.camera)

    def picture(self, moment: Moment, *, title: str = "") -> Picture:
        """The whole picture at one moment (height, width, 3)."""
        from PIL import Image, ImageDraw

        plan = self.plan
        width, height = plan.tile
        image = Image.new("RGB", plan.size, PAPER)
        self.scene.pose(moment)
        for row, skin in enumerate(plan.skins):
            for column, view in enumerate(plan.views):
                self.scene.set(skin=skin, view=self.cameras[view])
                image.paste(Image.fromarray(self.scene.picture()), (column * width, row * height))
        if len(plan.views) * len(plan.skins) > 1 or title:
            caption(ImageDraw.Draw(image), plan, title)
        if plan.muscles:
            image.paste(panel(self.story.hand, self.rows, moment, (plan.panel_width, plan.size[1])), (plan.size[0] - plan.panel_width, 0))
        return np.asarray(image)

    def close(self) -> None:
        """Give back the canvas."""
        self.scene.close()


def caption(draw: Any, plan: Layout, title: str) -> None:
    """Every tile says what it shows, once per row and column."""
    width, height = plan.tile
    size = max(13, min(width, height) * 0.048)
    for column, view in enumerate(plan.views):
        for row, skin in enumerate(plan.skins):
            words = (
                title if row == column == 0 else "",
                view if len(plan.views) > 1 and row == 0 else "",
                f"skin {skin}" if len(plan.skins) > 1 and column == 0 else "",
            )
            text = ", ".join(word for word in words if word)
            write(draw, (column * width + size, row * height + 1.8 * size), text, size, colour=FAINT)
