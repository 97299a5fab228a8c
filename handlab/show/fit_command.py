"""``handlab fit me.jpg``: the live hand's page, opened where a photograph becomes a hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from handlab.show.app.place import PORT, checked_port
from handlab.show.outfits import SOFT

if TYPE_CHECKING:
    from handlab.show.session import Session


def fit(picture: Path, /, *, port: int = PORT, host: str = "127.0.0.1", browser: bool = True) -> None:
    """Make a hand from a photograph by clicking, in the browser: handlab fit me.jpg

    Parameters
    ----------
    picture
        A photograph of a palm or a back, with a ruler, a coin or a bank card: JPEG, PNG, HEIC and a few more.
    port
        Where the page is served; the next free one if it is taken, any free one for 0.
    host
        Who can reach it: this computer only (127.0.0.1), or others too (0.0.0.0), with a warning.
    browser
        Open the page in the browser.
    """
    from handlab.show.app.server import start

    def tell(text: str) -> None:
        print(text, flush=True)  # noqa: T201 (the command's own words)

    start(live(), host=host, port=checked_port(port), browser=browser, say=tell, picture=picture)


def live(path: Path | None = None, side: str = "right", reading: str = "sound") -> Callable[[], Session]:
    """What makes the session of a live hand: the reference hand, or one that was saved, which is read at once.

    Raises what ``open_hand`` raises.
    """
    from handlab.anatomy.load import load_hand
    from handlab.show.fit_keepsakes import open_hand

    saved = None if path is None else open_hand(path)

    def session() -> Session:
        from handlab.show.session import Session

        return Session(load_hand(side=side, reading=reading) if saved is None else saved, wear=SOFT)

    return session
