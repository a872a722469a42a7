"""The columns of particle data, and the pieces in which a file of them is read.

A row is one tracer at one time: `time,x,y,vx,vy`, and where known `tracer` and `medium` (the
configuration of scatterers). Other columns may stand between them and are not looked at. A file
is only read, and never as a whole: it comes as a sequence of `Rows`.
"""

import difflib
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinetics.errors import InputError, short

Array = NDArray[np.float64]
Ids = NDArray[np.int64]

NUMBERS = ("time", "x", "y", "vx", "vy")
"""The columns that must be there."""
LABELS = ("tracer", "medium")
"""The columns that may be there; whole numbers, in a CSV file any text."""
PIECE = 500_000
"""Rows that are in memory at once."""

Progress = Callable[[float], None]
"""Called with the share of a file that has been read, 0 to 1."""


@dataclass(frozen=True)
class Rows:
    """A piece of a file: one entry per row in each array, (n,); labels are None where unknown."""

    time: Array
    x: Array
    y: Array
    vx: Array
    vy: Array
    tracer: Ids | None = None
    medium: Ids | None = None


def read_rows(path: Path, progress: Progress | None = None) -> Generator[Rows, None, None]:
    """The rows of a .csv, .npz or .h5 file in pieces, in the order of the file.

    InputError in one line for a file that is missing, damaged, of another kind, without a column
    or with a value that is not a finite number.
    """
    from kinetics.crosscheck.compare import binary_files, csv_file

    readers = {
        ".csv": csv_file.read,
        ".npz": binary_files.read_npz,
        ".h5": binary_files.read_h5,
        ".hdf5": binary_files.read_h5,
    }
    suffix = path.suffix.lower()
    if suffix not in readers:
        raise InputError(f"{shown(path)}: must be a file .csv, .npz or .h5")
    if not path.is_file():
        raise InputError(f"{shown(path)}: {'not a file' if path.exists() else 'no such file'}")
    try:
        yield from readers[suffix](path, progress or (lambda share: None))
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise InputError(f"{shown(path)}: cannot be read ({reason})") from None


def shown(path: Path) -> str:
    """A file's path on one line of a message."""
    return " ".join(_readable(str(path)).split()) or "''"


def plain_name(path: Path) -> str:
    """A file's name as text that can be written: names may be any bytes."""
    return _readable(path.name)


def _readable(text: str) -> str:
    return text.encode("utf-8", "replace").decode("utf-8")


def find_columns(path: Path, names: Sequence[str]) -> dict[str, int]:
    """Where each known column stands; InputError where one is missing or stands twice."""
    plain = [name.strip().strip("\"'").strip().lower() for name in names]
    found: dict[str, int] = {}
    for name in (*NUMBERS, *LABELS):
        places = [i for i, other in enumerate(plain) if other == name]
        if len(places) > 1:
            raise InputError(f"{shown(path)}: column {name!r} stands {len(places)} times")
        if places:
            found[name] = places[0]
    for name in NUMBERS:
        if name not in found:
            near = difflib.get_close_matches(name, plain, n=1, cutoff=0.5)
            hint = f"; is {short(near[0])} meant?" if near else ""
            raise InputError(
                f"{shown(path)}: column {name!r} is missing; needed are {', '.join(NUMBERS)}, "
                f"found are {short(', '.join(plain), 80)}{hint}"
            )
    return found


def check_finite(path: Path, rows: Rows, first_row: int) -> None:
    """InputError that names the first row, counted from 0, with a NaN or an infinite number."""
    for name in NUMBERS:
        values = getattr(rows, name)
        # One sum is cheaper than a mask, and is finite where every value is (short of overflow).
        with np.errstate(over="ignore", invalid="ignore"):
            if np.isfinite(values.sum()):
                continue
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            k = int(bad[0])
            raise InputError(
                f"{shown(path)}: row {first_row + k} has {name} = {values[k]}; "
                "every value must be a finite number"
            )
