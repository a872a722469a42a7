"""Frames: all tracers at one time, as simulators write them, turned into rows."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kinetics.crosscheck.comparison.data.columns import Rows, first_not_finite, shown
from kinetics.errors import InputError

PIECE = 500_000
"""Tracers of a frame that are in memory at once."""
_MOST_DIGITS = 1000


class Box(NamedTuple):
    """The lower edges and the lengths of a box along x, y and z."""

    low: tuple[float, ...]
    length: tuple[float, ...]


def rows_of(
    where: str, time: float, position: Any, velocity: Any, tracer: Any, medium: Any = None
) -> Rows:
    """Rows of a part of a frame: position, velocity (n, 2) or (n, 3); tracer, medium (n,).

    Tracers without any number (NaN: they have ended) are left out. InputError for a number that is
    not finite.
    """
    for what, array in (("positions", position), ("velocities", velocity)):
        if array.ndim != 2 or array.shape[1] not in (2, 3):
            raise InputError(f"{where}: {what} have shape {array.shape}; it must be (n, 2) or 3")
    there = ~np.isnan(np.hstack([position, velocity])).all(axis=1)
    values: dict[str, Any] = {"time": np.full(np.count_nonzero(there), float(time))}
    for names, part in ((("x", "y", "z"), position), (("vx", "vy", "vz"), velocity)):
        values |= dict(zip(names, np.asarray(part[there], float).T, strict=False))
    for name, one in (("tracer", tracer), ("medium", medium)):
        if one is not None and one.shape != there.shape:
            raise InputError(f"{where}: needs one label {name} for each of {there.size} tracers")
        values[name] = None if one is None else _whole_labels(where, one[there])
    if (bad := first_not_finite(values)) is not None:
        k, name = bad
        raise InputError(
            f"{where}: tracer {values['tracer'][k]} at time {time:g} has {name} = "
            f"{values[name][k]}; every value must be a finite number"
        )
    return Rows(**values)


def _whole_labels(where: str, labels: Any) -> Any:
    """Labels (n,) as whole numbers, also where they were read as real ones."""
    if labels.dtype.kind == "f" and not np.all((np.abs(labels) < 2.0**53) & (labels % 1 == 0)):
        raise InputError(f"{where}: labels of tracers must be whole numbers")
    return labels.astype(np.int64)


def read_lines(
    path: Path, lines: Iterable[str], count: int, places: Mapping[str, int], width: int
) -> Iterator[dict[str, Any]]:
    """Columns of the next `count` lines in pieces: name to numbers (n,), from their places.

    width: columns that a line must have. InputError for lines that are missing or no numbers.
    """
    left = count
    while left:
        piece = list(islice(lines, min(left, PIECE)))
        if len(piece) < min(left, PIECE):
            raise InputError(f"{shown(path)}: is cut off in its last frame")
        if len(piece[0].split()) != width:
            raise InputError(
                f"{shown(path)}: a line has {len(piece[0].split())} columns; {width} are named"
            )
        try:
            table = np.loadtxt(piece, usecols=list(places.values()), ndmin=2, comments=None)
        except (ValueError, IndexError):
            raise InputError(
                f"{shown(path)}: has a line that is not {width} columns of numbers"
            ) from None
        yield {name: table[:, k] for k, name in enumerate(places)}
        left -= len(piece)


def whole(path: Path, what: str, text: str) -> int:
    """A whole number that is not negative, from text; InputError for anything else."""
    plain = text.strip()
    if not plain.isdecimal() or len(plain) > 18:
        raise InputError(f"{shown(path)}: {what} is not a whole number: {plain[:40]!r}")
    return int(plain)


def real(path: Path, what: str, text: str) -> float:
    """A finite number from text; InputError for anything else."""
    try:
        value = float(text) if len(text) < _MOST_DIGITS else np.nan
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"{shown(path)}: {what} is not a finite number: {text.strip()[:40]!r}")
    return value
