"""``view``: look at a hand, a state or a clip in the best way that works here, and say which one that is."""

from __future__ import annotations

import io
import sys
from base64 import b64encode
from html import escape
from importlib.util import find_spec
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, Literal

from handlab.anatomy.records import Hand
from handlab.anatomy.terms import find
from handlab.show.moments import Story, story
from handlab.simulation.clip import Clip
from handlab.simulation.state import State

Kind = Literal["widget", "trame", "picture", "page", "still"]
KINDS: tuple[Kind, ...] = ("widget", "trame", "picture", "page", "still")
SAYS = {
    "widget": "live hand: a click gives it the keyboard; the muscles have sliders beside it, or below it in a slim cell",
    "trame": "pyvista in trame: the camera is live, set(state) moves the hand",
    "picture": "a picture that set(state) or the slider draws anew",
    "page": "a page that plays by itself: no kernel moves this hand",
    "still": "a still picture",
}
STILL_SIZE = (900, 600)


class View:
    """A hand being looked at: ``kind`` and ``why`` say how, ``set(...)`` changes it, ``inner`` is what does the work."""

    def __init__(self, kind: str, why: str, inner: Any) -> None:
        self.kind, self.why, self.inner = kind, why, inner

    def __repr__(self) -> str:
        """One line."""
        return f"View {self.kind!r}: {self.why}"

    def set(self, state: State | None = None, **changes: Any) -> None:
        """Show a state; a live hand also takes contractions by muscle, such as ``set(FDP2=0.4)``."""
        if state is not None:
            self.inner.show(state)
        if changes:
            if not hasattr(self.inner, "set"):
                raise TypeError(f"this view ({self.kind}: {self.why}) has no muscles to move; give it a state: set(state)")
            self.inner.set(**changes)

    def _repr_mimebundle_(self, **how: Any) -> Any:
        shown = self.inner._repr_mimebundle_(**how)
        bundle = dict(shown[0] if isinstance(shown, tuple) else shown)
        bundle["text/plain"] = repr(self)
        return (bundle, *shown[1:]) if isinstance(shown, tuple) else bundle


def view(
    hand: Hand,
    what: State | Clip | None = None,
    kind: str | None = None,
    *,
    view: str = "palm",
    skin: str = "solid",
    height: int = 680,
    painted: Any = None,
    **more: Any,
) -> View:
    """Look at ``hand`` relaxed, at a state of it, or at a recorded clip.

    ``kind``: ``"widget"`` (live, in notebooks: sliders, clips, curves), ``"trame"`` (pyvista in an iframe), ``"picture"`` (an image
    widget), ``"page"`` (plays without a kernel; outside notebooks it opens in the browser), ``"still"``. Not given, the first of
    widget, picture and page that works here is taken. Which one, and why, is printed and stands in ``.kind`` and ``.why``.

    ``view``, ``skin``, ``bones``, ``layers`` as in ``save``; ``height`` in pixels. For the widget: ``hold`` joints that are held; ``wear``,
    ``muscles`` as in ``simulate``, with a soft skin by default. Other kinds show the skin that the clip or state has. ``painted`` muscles,
    as in ``simulate``, swell and are seen in a hand or state; a clip already has those of its hand.

    Raises ``UnknownName`` for an unknown kind or view, and says what is missing if a kind that was asked for cannot work here.
    """
    from handlab.show.scene import skin_name
    from handlab.show.views import view_name

    if painted is not None:
        from handlab.simulation.painted import with_painted

        hand = with_painted(hand, painted)
    look = {"view": view_name(view), "skin": skin_name(skin), **more}
    if kind is not None:
        chosen = find(kind, KINDS, kind="kind of view")
        shown = View(chosen, SAYS[chosen], BUILD[chosen](hand, what, height, look))
    else:
        shown = best(hand, what, height, look)
    print(f"{shown.kind} view ({shown.why})")  # noqa: T201 (a view says which one it is)
    return shown


def best(hand: Hand, what: State | Clip | None, height: int, look: dict[str, Any]) -> View:
    """The first kind that works here."""
    reasons = []
    kinds: tuple[Kind, ...] = ("widget", "picture", "page") if in_notebook() else ("page",)
    for kind in kinds:
        try:
            inner = BUILD[kind](hand, what, height, look)
        except (ImportError, RuntimeError) as error:
            reasons.append(f"no {kind}: {error}")
            continue
        return View(kind, "; ".join([SAYS[kind], *reasons]), inner)
    return View("still", "; ".join([SAYS["still"], *reasons]), still(hand, what, height, look))


def in_notebook() -> bool:
    """Whether a kernel runs this, whose front end can show widgets."""
    if "IPython" not in sys.modules:
        return False
    from IPython.core.getipython import get_ipython

    return getattr(get_ipython(), "kernel", None) is not None


def widget(hand: Hand, what: State | Clip | None, height: int, look: dict[str, Any]) -> Any:
    """The live viewer."""
    from handlab.show.widget import HandView

    if find_spec("anywidget") is None:
        raise ImportError('anywidget is missing; pip install "handlab[lab]"')
    return HandView(hand, what, height=height, **look)


def trame(hand: Hand, what: State | Clip | None, height: int, look: dict[str, Any]) -> Any:
    """pyvista's own notebook view."""
    from handlab.show.trame_view import TrameView

    return TrameView(hand, what, height=height, **look)


def picture(hand: Hand, what: State | Clip | None, height: int, look: dict[str, Any]) -> Any:
    """An image widget, with a slider over time for a clip."""
    return Pictures(hand, what, height, look)


class Pictures:
    """A picture widget; for a clip with a slider over its time."""

    def __init__(self, hand: Hand, what: State | Clip | None, height: int, look: dict[str, Any]) -> None:
        from handlab.show.main_thread import OnMain
        from handlab.show.picture_widget import PictureWidget

        self._told = told(hand, what)
        self._picture = PictureWidget(hand, view=look["view"], skin=look["skin"], size=(height * 5 // 4, height))
        self.widget = self._picture.widget
        self.show(self._state(0.0))
        if self._told.seconds > 0.0:
            import ipywidgets

            time = ipywidgets.FloatSlider(description="time (s)", min=0.0, max=self._told.seconds, step=self._told.seconds / 100)
            time.observe(OnMain(lambda change: self.show(self._state(change["new"]))), names="value")
            self.widget = ipywidgets.VBox([self._picture.widget, time])

    def _state(self, time: float) -> State:
        if self._told.clip is None:
            result: State = self._told.state
            return result
        clip = self._told.clip
        found: State = clip.states[int(abs(clip.time - clip.time[0] - time).argmin())]
        return found

    def show(self, state: State) -> None:
        """Draw a state."""
        self._picture.show(state)

    def _repr_mimebundle_(self, **how: Any) -> Any:
        return self.widget._repr_mimebundle_(**how)


class Page:
    """A page that plays by itself: in a notebook inside the cell, elsewhere a file that the browser opens."""

    def __init__(self, hand: Hand, what: State | Clip | None, height: int, look: dict[str, Any]) -> None:
        from handlab.show.opening import open_file
        from handlab.show.page import page

        self._hand, self._height = hand, height
        self._look = {key: look[key] for key in ("view", "skin", "bones", "panels", "layers") if key in look}
        self.text = page([told(hand, what)], **self._look)
        self.path: Path | None = None
        if not in_notebook():
            self.path = Path(mkdtemp(prefix="handlab-")) / "hand.html"
            self.path.write_text(self.text, encoding="utf-8")
            if not open_file(self.path):
                print(f"open {self.path} in a browser")  # noqa: T201

    def show(self, state: State) -> None:
        """Another state, seen when the page is displayed again."""
        from handlab.show.page import page

        self.text = page([story(state, self._hand)], **self._look)

    def _repr_mimebundle_(self, **_how: Any) -> dict[str, str]:
        # srcdoc, not a file: the cell then stays whole in an exported notebook.
        return {"text/html": f'<iframe srcdoc="{escape(self.text)}" style="width:100%;height:{self._height}px;border:0"></iframe>'}


class Still:
    """A picture that stays as it is."""

    def __init__(self, hand: Hand, what: State | Clip | None, look: dict[str, Any]) -> None:
        self._hand, self._look = hand, look
        self._draw(told(hand, what))

    def _draw(self, shown: Story) -> None:
        from PIL import Image

        from handlab.show.scene import Scene

        with Scene(
            self._hand,
            view=self._look["view"],
            skin=self._look["skin"],
            bones=self._look.get("bones", True),
            layers=self._look.get("layers", ()),
            size=STILL_SIZE,
            quality="still",
        ) as scene:
            scene.pose(shown.at(shown.seconds))
            file = io.BytesIO()
            Image.fromarray(scene.picture()).save(file, format="PNG")
        self.png = file.getvalue()

    def show(self, state: State) -> None:
        """Another state, seen when the picture is displayed again."""
        self._draw(story(state, self._hand))

    def _repr_mimebundle_(self, **_how: Any) -> dict[str, str]:
        return {"image/png": b64encode(self.png).decode()}


def still(hand: Hand, what: State | Clip | None, height: int, look: dict[str, Any]) -> Any:
    """One picture: of a clip, its end."""
    return Still(hand, what, look)


def told(hand: Hand, what: State | Clip | None) -> Story:
    """The story of what is to be seen."""
    return story(hand if what is None else what, hand)


BUILD = {"widget": widget, "trame": trame, "picture": picture, "page": Page, "still": still}
