"""Key frames in files: CSV (``time,FDP2,...``) and JSON."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from handlab.simulation.keyframes import KeyFrames, muscle_name, muscle_terms
from handlab.simulation.writing import write_text


def read_text(path: Path) -> str:
    """Content of a file of key frames, or an error that says why it cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise FileNotFoundError(f"no file {path}; give the path of a .csv or .json file with key frames") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path} is not a text file (UTF-8); key frames are text") from None
    except OSError as error:
        raise type(error)(f"cannot read {path}: {error.strerror}") from error


def lines(text: str) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of every line that holds something; ``#`` begins a comment line."""
    reader = csv.reader(text.splitlines())
    for raw in reader:
        cells = [cell.strip() for cell in raw]
        if any(cells) and not cells[0].startswith("#"):
            yield reader.line_num, cells


def read_csv(path: Path) -> KeyFrames:
    """Key frames of a CSV file; a broken line is named by its number (the heading is a line too)."""
    rows = lines(read_text(path))
    number, heading = next(rows, (0, []))
    if not heading or heading[0].lower() not in ("time", "time_s"):
        raise ValueError(f"{path}, line {max(number, 1)}: a table of key frames begins with a heading such as time,FDP2,EDC2")
    if len(heading) < 2:
        raise ValueError(f"{path}, line {number}: no muscle after 'time' in the heading")
    for name in heading[1:]:
        try:
            muscle_name(name)
        except KeyError as error:
            raise type(error)(f"{path}, line {number}: {error}") from None
    time: list[float] = []
    values: list[list[float | None]] = []
    for number, cells in rows:
        where = f"{path}, line {number}"
        if len(cells) != len(heading):
            raise ValueError(f"{where}: {len(cells)} cells, but the heading has {len(heading)}")
        row = [cell_value(cell, name, where) for cell, name in zip(cells, heading, strict=True)]
        now = row[0]
        if now is None or not np.isfinite(now):
            raise ValueError(f"{where}: the time is {cells[0]!r}; give a number of seconds")
        if time and now <= time[-1]:
            how = f"{now:g} s stands there twice" if now == time[-1] else f"{now:g} s comes after {time[-1]:g} s"
            raise ValueError(f"{where}: {how}; give every time once, sorted")
        time.append(now)
        values.append(row[1:])
    if not time:
        raise ValueError(f"{path}: no key frames below the heading")
    return named(path, {"time": time, **dict_of(heading[1:], values, path)}, name=path.stem, title="")


def cell_value(cell: str, name: str, where: str) -> float | None:
    """The number in a cell; ``None`` where it is empty, which is no key."""
    if not cell:
        return None
    try:
        value = float(cell)
    except ValueError:
        raise ValueError(f"{where}: {cell!r} under {name!r} is not a number") from None
    if name.lower() not in ("time", "time_s") and not 0.0 <= value <= 1.0:
        raise ValueError(f"{where}: contraction of {name!r} is {value:g}; contraction values lie between 0 and 1")
    return value


def dict_of(names: list[str], rows: list[list[float | None]], path: Path) -> dict[str, Any]:
    """Columns by name; of two with the same name the first would silently be lost."""
    for k, name in enumerate(names):
        if name in names[:k]:
            raise ValueError(f"{path}: the muscle {name!r} has two columns; keep one")
    return {name: [row[k] for row in rows] for k, name in enumerate(names)}


class NotANumberError(ValueError):
    """NaN or infinity, which Python's JSON reader would let pass."""


def refused(word: str) -> float:
    """Raise for NaN and infinity."""
    raise NotANumberError(word)


def read_json(path: Path) -> KeyFrames:
    """Key frames of a JSON file."""
    try:
        content = json.loads(read_text(path), parse_constant=refused)
    except json.JSONDecodeError as error:
        raise ValueError(f"{path}, line {error.lineno}: not readable as JSON ({error.msg})") from None
    except NotANumberError as error:
        raise ValueError(f"{path} holds {error}, which is no number; contraction values lie between 0 and 1") from None
    if not isinstance(content, dict) or not isinstance(content.get("contraction"), dict) or "time" not in content:
        raise ValueError(f'{path} holds no key frames; it needs "time": [...] and "contraction": {{"FDP2": [...]}}')
    if "time" in content["contraction"]:
        raise ValueError(f'{path}: "time" stands beside "contraction", not in it')
    return named(
        path,
        {"time": content["time"], **content["contraction"]},
        name=str(content.get("name", path.stem)),
        title=str(content.get("title", "")),
    )


def named(path: Path, tracks: dict[str, Any], *, name: str, title: str) -> KeyFrames:
    """Key frames whose errors begin with the name of the file."""
    try:
        return KeyFrames.from_mapping(tracks, name=name, title=title)
    except (KeyError, ValueError) as error:
        raise type(error)(f"{path}: {error}") from None


def write_csv(keys: KeyFrames, path: str | os.PathLike[str]) -> None:
    """Write key frames as CSV with the muscles' abbreviations; cells that are no key stay empty."""
    terms = muscle_terms()
    columns = [keys.muscle_names.index(name) for name in keys.keyed]
    rows: list[Iterable[str]] = [["time", *(terms[name] for name in keys.keyed)]]
    for k, time in enumerate(keys.time):
        rows.append([shortest(time), *(shortest(keys.contraction[k, c]) if keys.is_key[k, c] else "" for c in columns)])
    write_text(path, "".join(",".join(row) + "\n" for row in rows))


def write_json(keys: KeyFrames, path: str | os.PathLike[str]) -> None:
    """Write key frames as JSON with the muscles' full names, one muscle a line; ``null`` where there is no key."""
    columns = {name: keys.muscle_names.index(name) for name in keys.keyed}
    frames = range(len(keys.time))
    tracks = {name: [float(keys.contraction[k, c]) if keys.is_key[k, c] else None for k in frames] for name, c in columns.items()}
    listed = ",\n".join(f"    {json.dumps(name)}: {json.dumps(values)}" for name, values in tracks.items())
    head = "".join(
        f"  {json.dumps(key)}: {json.dumps(value)},\n"
        for key, value in {"name": keys.name, "title": keys.title, "time": [float(t) for t in keys.time]}.items()
    )
    write_text(path, f'{{\n{head}  "contraction": {{\n{listed}\n  }}\n}}\n')


def shortest(value: float) -> str:
    """The shortest decimal that reads back as the same number."""
    return repr(float(value))
