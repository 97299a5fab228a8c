"""What comes out of the fitting page: the report as rows, an archive with the hand in it, the outline over the photograph."""

from __future__ import annotations

import io
import json
import os
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from handlab.anatomy.load import PEOPLE, load_hand
from handlab.anatomy.picture import PICTURE
from handlab.anatomy.records import Hand
from handlab.anatomy.store import FILES as HAND_FILES
from handlab.anatomy.store import save_hand
from handlab.fitting.preview import outline_of
from handlab.fitting.result import Fit
from handlab.show.fit_clicks import Clicks
from handlab.show.fit_picture import Photo, overlaid
from handlab.show.fit_words import plain

FILES = ("hand", "picture", "report")
MOST_BYTES = 100_000_000  # of a file in an archive


def rows(fit: Fit, photo: Photo) -> dict[str, Any]:
    """The result as a page shows it: lengths in mm beside the reference hand, outline (px), overlap, what to know."""
    report, shown = fit.report(), photo.mask(fit.clicks)
    skin = fit.to_picture(fit.hand.skin_fine.points)
    return {
        "lengths": [[name, round(new, 1), round(old, 1)] for name, (new, old) in report.lengths_mm.items()],
        "hand_mm": [round(value, 1) for value in report.hand_length_mm],
        "growth": round(report.growth, 4),
        "laws": [[name, law.power, round(law.found, 3)] for name, law in report.laws.items()],
        "side": fit.side,
        "view": fit.view,
        "points": report.points,
        "outlined": report.outline,
        "scale": report.scale,
        "notes": [plain(warning) for warning in fit.warnings if "camera_mm" not in warning],  # the page has a field for it
        "camera_mm": None if fit.camera_mm is None else round(fit.camera_mm),
        "camera": fit.camera,
        "outline": np.round(outline_of(skin, fit.hand.skin_fine.faces, 400_000), 1).tolist(),
        "iou": None if shown is None else round(fit.overlap(shown, photo.step), 4),  # in the small picture: in whole ones it takes long
    }


def keepsake(what: str, fit: Fit, photo: Photo, clicks: Clicks) -> tuple[str, str, bytes]:
    """Name, kind and content of a file: "hand", "picture" or "report"."""
    stem = "".join(c if c.isalnum() or c in "-_" else "-" for c in Path(photo.name).stem) or "hand"
    picture = overlaid(photo, outline_of(fit.to_picture(fit.hand.skin_fine.points), fit.hand.skin_fine.faces, 400_000))
    if what == "picture":
        return f"{stem}-outline.jpg", "image/jpeg", picture
    if what == "report":
        return f"{stem}-report.txt", "text/plain", f"{fit.report()}\n".encode()
    return f"{stem}-hand.zip", "application/zip", archive(fit, photo, clicks, picture)


def archive(fit: Fit, photo: Photo, clicks: Clicks, picture: bytes) -> bytes:
    """The hand (hand.glb, hand.json), its colours, report, clicks and picture in one archive."""
    stream = io.BytesIO()
    with TemporaryDirectory(prefix="handlab-") as folder, zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as out:
        place = save_hand(fit.hand, Path(folder) / "hand")
        for file in sorted(place.iterdir()):
            out.write(file, file.name)
        out.writestr("report.txt", f"{fit.report()}\n")
        out.writestr("points.json", json.dumps(clicks.to_json(), indent=1) + "\n")
        out.writestr("outline.jpg", picture)
    return stream.getvalue()


def open_hand(path: str | os.PathLike[str]) -> Hand:
    """A hand: "man" or "child", a folder, or an archive as ``archive`` writes it.

    Raises ``FileNotFoundError``, or ``ValueError`` for an archive that holds no hand.
    """
    file = Path(path)
    if str(path) in PEOPLE:
        return load_hand(str(path))
    if not file.exists() or file.is_dir():
        return load_hand(file)
    try:
        with zipfile.ZipFile(file) as box, TemporaryDirectory(prefix="handlab-") as folder:
            sizes = {entry.filename: entry.file_size for entry in box.infolist()}
            if not set(HAND_FILES) <= set(sizes):
                raise ValueError(f"{file.name} holds no hand: a hand is hand.json and hand.glb, in a folder or an archive")
            for name in {*HAND_FILES, PICTURE} & set(sizes):  # these names and no others: an archive may hold any path
                if sizes[name] > MOST_BYTES:
                    raise ValueError(f"{file.name}: {name} claims {sizes[name]} bytes; no hand is so large")
                (Path(folder) / name).write_bytes(box.read(name))
            return load_hand(folder)
    except zipfile.BadZipFile as error:
        raise ValueError(f"{file.name} is no archive with a hand; save it again from the page") from error
