"""Contraction values at arbitrary times, and the smooth curve between them (section 3.1)."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from handlab.anatomy import data, tables
from handlab.anatomy.records import Array, Hand, frozen
from handlab.anatomy.terms import find, match
from handlab.simulation import pchip

Source: TypeAlias = "KeyFrames | str | os.PathLike[str] | Mapping[str, Any]"


@cache
def muscle_terms() -> Mapping[str, str]:
    """Muscle name -> abbreviation, in the order of every array."""
    return MappingProxyType({name: muscle.abbreviation for name, muscle in tables.muscles().items()})


def muscle_name(name: str) -> str:
    """Full name of a muscle from its name or abbreviation; an unknown one is answered with the nearest three."""
    return find(name, muscle_terms(), kind="muscle", aliases=tables.aliases())


@dataclass(frozen=True, eq=False)
class KeyFrames:
    """Contraction values of muscles at key times.

    ``time`` (K,) seconds, rising; ``contraction`` (K, muscle) in [0, 1], columns as in ``muscle_names``; ``is_key``
    (K, muscle): where a value was given, the others lie on the curve. A muscle without any key stays at 0.
    """

    time: Array
    contraction: Array
    is_key: NDArray[np.bool_]
    muscle_names: tuple[str, ...] = field(repr=False)
    name: str = ""
    title: str = ""

    def __post_init__(self) -> None:
        """Refuse what is no curve of contractions."""
        shape = len(self.time), len(self.muscle_names)
        if self.contraction.shape != shape or self.is_key.shape != shape:
            raise ValueError(f"contraction {self.contraction.shape} and is_key {self.is_key.shape} must both be {shape}: times, muscles")
        for column, muscle in enumerate(self.muscle_names):
            check(muscle, self.time, self.contraction[:, column])

    def __repr__(self) -> str:
        """One line."""
        label = f" {self.name!r}" if self.name else ""
        return f"KeyFrames{label}: {len(self.keyed)} muscles, {len(self.time)} times from {self.time[0]:g} to {self.time[-1]:g} s"

    @property
    def keyed(self) -> tuple[str, ...]:
        """Names of the muscles that have keys."""
        return tuple(self.muscle_names[k] for k in np.flatnonzero(self.is_key.any(axis=0)))

    @classmethod
    def from_mapping(cls, tracks: Mapping[str, Any], *, name: str = "", title: str = "") -> KeyFrames:
        """Key frames from code.

        ``{"FDP2": [(0, 0), (1, 0.8)], "EDC2": [...]}``: pairs of time and value, every muscle with times of its own; or
        ``{"time": [0, 1], "FDP2": [0, 0.8]}``: one list of times (``None``: no key at this time); or
        ``{"FDP2": 0.4}``: constant.
        """
        if not isinstance(tracks, Mapping):
            raise TypeError(f"key frames come as a mapping by muscle, not as {type(tracks).__name__}")
        if "time" in tracks:
            shared = numbers(tracks["time"], "times of the key frames")
            tracks = {muscle: gathered(muscle, shared, values) for muscle, values in tracks.items() if muscle != "time"}
        given: dict[str, str] = {}
        keys: dict[str, tuple[Array, Array]] = {}
        for muscle, track in tracks.items():
            full = muscle_name(muscle)
            if full in given:
                raise ValueError(f"{given[full]!r} and {muscle!r} are the same muscle, {full!r}; give its keys once")
            given[full] = muscle
            pairs = as_pairs(full, track)
            check(full, pairs[:, 0], pairs[:, 1])
            keys[full] = pairs[:, 0], pairs[:, 1]
        return assembled(keys, name, title)

    @classmethod
    def from_csv(cls, path: str | os.PathLike[str]) -> KeyFrames:
        """Key frames from a table ``time,FDP2,...``: seconds and values, one line a time; an empty cell is no key."""
        from handlab.simulation.keyframe_files import read_csv

        return read_csv(Path(path))

    @classmethod
    def from_json(cls, path: str | os.PathLike[str]) -> KeyFrames:
        """Key frames from ``{"name", "title", "time": [...], "contraction": {"FDP2": [...]}}``.

        ``null`` is no key; entries with other names are left alone.
        """
        from handlab.simulation.keyframe_files import read_json

        return read_json(Path(path))

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write what ``from_csv`` reads, whole or not at all."""
        from handlab.simulation.keyframe_files import write_csv

        write_csv(self, path)

    def to_json(self, path: str | os.PathLike[str]) -> None:
        """Write what ``from_json`` reads, whole or not at all."""
        from handlab.simulation.keyframe_files import write_json

        write_json(self, path)

    @cached_property
    def curves(self) -> tuple[tuple[NDArray[np.int64], Array, Array, Array], ...]:
        """Columns, knots, values and slopes of muscles that share their key times."""
        patterns: dict[bytes, list[int]] = {}
        for column in np.flatnonzero(self.is_key.any(axis=0)):
            patterns.setdefault(self.is_key[:, column].tobytes(), []).append(int(column))
        groups = []
        for columns in patterns.values():
            at = self.is_key[:, columns[0]]
            knots, values = self.time[at], self.contraction[at][:, columns]
            groups.append((np.array(columns), knots, values, pchip.slopes(knots, values)))
        return tuple(groups)

    def at(self, time: ArrayLike) -> Array:
        """Contractions (muscle,) at a time, or (T, muscle) at times (T,): a monotone cubic through the keys, never outside [0, 1].

        Before its first and after its last key a muscle holds that value.
        """
        times = np.asarray(time, dtype=np.float64)
        out = np.zeros((times.size, len(self.muscle_names)))
        for columns, knots, values, slope in self.curves:
            out[:, columns] = pchip.curve(knots, values, slope, times.ravel())
        np.clip(out, 0.0, 1.0, out=out)  # rounding
        return out.reshape(*times.shape, len(self.muscle_names))

    def for_hand(self, hand: Hand) -> KeyFrames:
        """The same key frames with columns in the order of a hand's muscles."""
        if hand.muscle_names == self.muscle_names:
            return self
        order = [self.muscle_names.index(find(name, self.muscle_names, kind="muscle")) for name in hand.muscle_names]
        contraction, is_key = frozen(self.contraction[:, order]), frozen(self.is_key[:, order], bool)
        return KeyFrames(self.time, contraction, is_key, hand.muscle_names, self.name, self.title)


def assembled(keys: Mapping[str, tuple[Array, Array]], name: str, title: str) -> KeyFrames:
    """Key frames from checked times and values by full muscle name."""
    if not keys:
        raise ValueError("no key frames: give at least one muscle, like {'FDP2': [(0, 0), (1, 0.8)]}")
    names = tuple(muscle_terms())
    time = np.unique(np.concatenate([times for times, _ in keys.values()]))
    is_key = np.zeros((len(time), len(names)), dtype=bool)
    contraction = np.zeros((len(time), len(names)))
    for muscle, (times, values) in keys.items():
        column = names.index(muscle)
        is_key[np.searchsorted(time, times), column] = True
        contraction[:, column] = pchip.curve(times, values[:, None], pchip.slopes(times, values[:, None]), time)[:, 0]
        contraction[is_key[:, column], column] = values
    return KeyFrames(frozen(time), frozen(np.clip(contraction, 0.0, 1.0)), frozen(is_key, bool), names, name, title)


def as_pairs(muscle: str, track: Any) -> Array:
    """Times and values (K, 2) of one muscle."""
    if np.ndim(track) == 0 and not isinstance(track, str | bytes | Mapping) and track is not None:
        track = [(0.0, track)]
    try:
        pairs = np.array([(float(time), float(value)) for time, value in track], dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"key frames of {muscle!r} are {track!r}; give pairs of time and value, like [(0, 0), (1, 0.8)]") from None
    if not len(pairs):
        raise ValueError(f"{muscle!r} has no key frames; give at least one pair of time and value, or leave the muscle out")
    return pairs


def gathered(muscle: str, time: Array, values: Any) -> Sequence[tuple[float, float]]:
    """Pairs of a muscle whose values go with shared times; a time without a value is no key."""
    if not isinstance(values, Sequence | np.ndarray) or isinstance(values, str | bytes) or len(values) != len(time):
        raise ValueError(f"{muscle!r} has {np.size(values)} values for {len(time)} times; give one value for every time")
    check_times("key frames", time)
    keyed = [k for k, value in enumerate(values) if value is not None]
    given = numbers([values[k] for k in keyed], f"contractions of {muscle!r}")
    return list(zip(time[keyed], given, strict=True))


def numbers(values: Any, what: str) -> Array:
    """An array (K,) of numbers, or an error that says what was none."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{what} are {values!r}; give a list of numbers") from None
    if array.ndim != 1:
        raise ValueError(f"{what} have {array.ndim} dimensions; give a plain list of numbers")
    return array


def check_times(what: str, time: Array) -> None:
    """Times must be numbers that rise."""
    if not len(time):
        raise ValueError(f"{what} are empty; give at least one time")
    if not np.isfinite(time).all():
        raise ValueError(f"{what} have the time {time[~np.isfinite(time)][0]:g}; times are numbers of seconds")
    gaps = np.diff(time)
    if (gaps == 0.0).any():
        raise ValueError(f"{what} have the time {time[1:][gaps == 0.0][0]:g} s twice; give every time once")
    if (gaps < 0.0).any():
        k = int(np.flatnonzero(gaps < 0.0)[0])
        raise ValueError(f"{what} are not sorted: {time[k + 1]:g} s comes after {time[k]:g} s; sort them by time")


def check(muscle: str, time: Array, values: Array) -> None:
    """Times must rise; values must lie in [0, 1]."""
    check_times(f"key frames of {muscle!r}", time)
    wrong = ~((values >= 0.0) & (values <= 1.0))
    if wrong.any():
        value, when = values[wrong][0], time[wrong][0]
        raise ValueError(f"contraction of {muscle!r} is {value:g} at {when:g} s; contraction values lie between 0 and 1")


def clips() -> tuple[str, ...]:
    """Names of the clips that come with the package."""
    return tuple(sorted(path.stem for path in (data.folder() / "clips").glob("*.json")))


def keyframes(source: Source) -> KeyFrames:
    """Key frames by name of a clip (see ``clips()``), from a mapping, or from a ``.csv`` or ``.json`` file."""
    if isinstance(source, KeyFrames):
        return source
    if isinstance(source, Mapping):
        return KeyFrames.from_mapping(source)
    text = os.fspath(source)
    named = match(text, clips())
    if named is not None and not isinstance(source, os.PathLike):
        return KeyFrames.from_json(data.folder() / "clips" / f"{named}.json")
    suffix = Path(text).suffix.lower()
    if suffix == ".csv":
        return KeyFrames.from_csv(text)
    if suffix == ".json":
        return KeyFrames.from_json(text)
    if suffix or os.sep in text or "/" in text or isinstance(source, os.PathLike):
        raise ValueError(f"cannot tell what {text!r} holds; key frames come from .csv or .json files")
    find(text, clips(), kind="clip")
    raise AssertionError("unreachable: find raises")
