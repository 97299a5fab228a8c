"""The command ``handlab``. Every mistake is answered with one sentence and exit code 2; HANDLAB_DEBUG=1 shows the traceback."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

import handlab
from handlab.mistakes import INTERRUPTED, TROUBLE, USAGE_ERROR, answered
from handlab.show.app.place import PORT, checked_port
from handlab.show.outfits import BLEND, SOFT

if TYPE_CHECKING:
    from handlab.anatomy.records import Hand
    from handlab.simulation.clip import Clip

PICTURES_SIZE = (1280, 720)
PICTURES_FPS = 30.0

Many = Annotated[list[str], Parameter(consume_multiple=True, negative="")]
Out = Annotated[Path | None, Parameter(name=["--output", "-o"])]
Side = Literal["right", "left"]
Reading = Literal["sound", "printed"]

app = App(
    name="handlab",
    help="An anatomical human hand whose muscles move its bones.",
    version=handlab.__version__,
    help_format="plaintext",
    print_error=False,
    exit_on_error=False,
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)


@app.default
@app.command
def run(
    *,
    side: Side = "right",
    reading: Reading = "sound",
    port: int = PORT,
    host: str = "127.0.0.1",
    browser: bool = True,
    hand: Path | None = None,
) -> None:
    """Open the live hand in the browser: move its muscles, play clips, save and export. Without a command this is what happens.

    Parameters
    ----------
    side
        Which hand.
    reading
        The laws as they should be (sound) or as the paper prints them.
    port
        Where the page is served; the next free one if it is taken, any free one for 0.
    host
        Who can reach it: this computer only (127.0.0.1), or others too (0.0.0.0), with a warning.
    browser
        Open the page in the browser.
    hand
        Another hand: man, child, a folder, or an archive that the page "your own hand" saved. Its side and reading count.
    """
    from handlab.show.app.server import start
    from handlab.show.fit_command import live

    tell = lambda text: print(text, flush=True)  # noqa: E731
    start(live(hand, side, reading), host=host, port=checked_port(port), browser=browser, say=tell)


@app.command
def pictures(*, folder: Path = Path("handlab-pictures"), show: bool = True) -> None:
    """Draw the fist from four sides, solid and translucent, as a film and as a picture, and open the film.

    Parameters
    ----------
    folder
        Where the files go; made if it is not there.
    show
        Open the film where a program can.
    """
    from handlab.show.opening import open_file
    from handlab.show.pictures import draw

    film, picture = draw(simulated(load("right", "sound"), "fist", wear=SOFT), folder, size=PICTURES_SIZE, fps=PICTURES_FPS)
    say(f"film     {film}", f"picture  {picture}")
    if not (show and open_file(film)):
        say("Open them with any player and viewer.")


@app.command
def render(
    what: str,
    /,
    *,
    output: Out = None,
    view: Many = ["palm"],  # noqa: B006 (cyclopts reads defaults, nothing writes to them)
    skin: Many = ["solid"],  # noqa: B006
    wear: str = SOFT,
    bones: bool = True,
    layers: Many = [],  # noqa: B006
    muscles: bool = True,
    fps: float = 30.0,
    size: str = "800x600",
    seconds: float | None = None,
    hold: Many = [],  # noqa: B006
    side: Side = "right",
    reading: Reading = "sound",
) -> None:
    """Make a film, a picture or a table of a clip: handlab render fist -o fist.mp4

    Parameters
    ----------
    what
        A named clip (see: handlab clips), or key frames in a .csv or .json file; "rest" is the relaxed hand.
    output
        .mp4, .gif, .png or .csv; the name of the clip with .mp4 if not given.
    view
        One or more of palm, back, radial, ulnar, front, oblique, "oblique back".
    skin
        One or more of solid, translucent, hidden.
    wear
        How the skin follows: "blend" (bones alone), springs, "springs and muscles" (muscles below it swell).
    bones
        Draw the bones.
    layers
        Of muscles and tendons, under a skin that is not solid.
    muscles
        List the contracting muscles beside the hand.
    fps
        Frames per second.
    size
        Width x height of the picture in pixels.
    seconds
        How long; to the last key frame if not given.
    hold
        Joints that are held, such as wrist.
    side
        Which hand.
    reading
        The laws as they should be (sound) or as the paper prints them.
    """
    from handlab.show.outputs import checked, pair
    from handlab.show.save import FORMATS, save
    from handlab.show.tiles import layout

    out = checked(output or Path(f"{Path(what).stem}.{'png' if what == 'rest' else 'mp4'}"), FORMATS)
    pixels = pair(size)
    layout(view, skin, bones, pixels, muscles, layers)  # a mistake shows before the simulation, not after
    hand = load(side, reading)
    shown: Any = hand if what == "rest" else simulated(hand, what, seconds=seconds, hold=hold, wear=wear)
    say(str(save(shown, out, view=view, skin=skin, bones=bones, layers=layers, muscles=muscles, size=pixels, fps=fps)))


@app.command
def curves(
    what: str,
    /,
    *,
    muscles: Many = [],  # noqa: B006
    joints: Many = [],  # noqa: B006
    output: Out = None,
    seconds: float | None = None,
    hold: Many = [],  # noqa: B006
) -> None:
    """Plot muscle lengths and joint angles of a clip: handlab curves fist --muscles FDP2 EDC2 --joints mcp2 pip2

    Parameters
    ----------
    what
        A named clip or a key frame file.
    muscles
        By name or abbreviation.
    joints
        By joint or degree of freedom.
    output
        .png, .svg or .pdf.
    seconds
        How long; to the last key frame if not given.
    hold
        Joints that are held, such as wrist.
    """
    from handlab.show.curves import curves as draw
    from handlab.show.outputs import checked
    from handlab.show.save import FIGURE_FORMATS, save_figure

    out = checked(output or Path(f"{Path(what).stem}_curves.png"), FIGURE_FORMATS)
    say(str(save_figure(draw(simulated(load("right", "sound"), what, seconds=seconds, hold=hold), muscles, joints), out)))


@app.command
def plot(what: Literal["lever-arms", "force-length"], /, *, output: Out = None, reading: Reading = "sound") -> None:
    """Plot all 42 muscles: their lever arms, or where the relaxed hand stands on the force-length curve.

    Parameters
    ----------
    what
        Which plot.
    output
        .png, .svg or .pdf.
    reading
        The laws as they should be (sound) or as the paper prints them.
    """
    from handlab.show import plots
    from handlab.show.outputs import checked
    from handlab.show.save import FIGURE_FORMATS, save_figure

    out = checked(output or Path(f"{what}.png"), FIGURE_FORMATS)
    draw = {"lever-arms": plots.lever_arm_map, "force-length": plots.force_length}[what]
    say(str(save_figure(draw(load("right", reading)), out)))


@app.command
def clips() -> None:
    """List the named clips."""
    from handlab.show.facts import table
    from handlab.simulation.keyframes import clips as names
    from handlab.simulation.keyframes import keyframes

    say(table(("clip", "seconds", "what"), [(name, f"{keys.time[-1]:.1f}", keys.title) for name in names() for keys in [keyframes(name)]]))


@app.command
def info(muscle: str | None = None, /, *, side: Side = "right", reading: Reading = "sound") -> None:
    """Print what this hand is: meshes, quality, muscles, joints, assumptions; or one muscle with its sources.

    Parameters
    ----------
    muscle
        Name or abbreviation, such as FDP2.
    side
        Which hand.
    reading
        The laws as they should be (sound) or as the paper prints them.
    """
    from handlab.show.facts import info as text

    hand = load(side, reading)
    say(text(hand) if muscle is None else repr(hand.muscles[muscle]))


app.command("handlab.show.lab:lab", name="lab")  # imported when it is asked for
app.command("handlab.show.fit_command:fit", name="fit")


@app.command
def doctor() -> int:
    """Check that this machine can simulate, draw and write films, and say what to install where it cannot."""
    from handlab.show.facts import findings

    found = findings()
    for finding in found:
        say(f"{'ok ' if finding.ok else 'NO '} {finding.what}", *([f"    {finding.remedy}"] if not finding.ok else []))
    return 0 if all(finding.ok for finding in found) else TROUBLE


def load(side: Side, reading: Reading) -> Hand:
    """The reference hand."""
    from handlab.anatomy.load import load_hand

    return load_hand(side=side, reading=reading)


def simulated(hand: Hand, what: str, *, seconds: float | None = None, hold: Sequence[str] = (), wear: str = BLEND) -> Clip:
    """A clip, with progress if it takes longer than a second."""
    from tqdm.auto import tqdm

    from handlab.simulation.play import simulate

    with tqdm(total=100, desc=f"simulating {what}", unit="%", delay=1.0, leave=False) as bar:
        tell = lambda done: bar.update(round(100 * done) - bar.n) and None  # noqa: E731
        return simulate(hand, what, seconds=seconds, hold=hold, skin=wear, progress=tell)


def say(*lines: str) -> None:
    """Print lines."""
    print("\n".join(lines))


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point: runs a command and ends the process with its exit code."""
    sys.exit(answer(sys.argv[1:] if arguments is None else arguments))


def answer(arguments: Sequence[str]) -> int:
    """The exit code of a command line: 0, 1 (doctor found trouble), 2 (a mistake, in one sentence), 130 (interrupted)."""
    return answered(app, arguments)


__all__ = ["INTERRUPTED", "TROUBLE", "USAGE_ERROR", "answer", "app", "main"]

if __name__ == "__main__":
    main()
