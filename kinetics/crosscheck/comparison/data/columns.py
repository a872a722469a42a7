"""The columns of particle data, the formats of their files, and the checks that all share.

A row is one tracer at one time: `time,x,y,vx,vy`, and where known `tracer` and `medium` (the
configuration of scatterers). Other columns may stand between them; they are not read. A file is
never held as a whole: it comes as a sequence of `Rows`.
"""

import difflib
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinetics.errors import InputError, short

Array = NDArray[np.float64]
Ids = NDArray[np.int64]

NUMBERS = ("time", "x", "y", "vx", "vy")
"""The columns that must be there."""
LABELS = ("tracer", "medium")
"""The columns that may be there: whole numbers, in a CSV file any text."""
_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, KeyError)


@dataclass(frozen=True)
class Rows:
    """A piece of a file: one entry per row in each array, (n,); labels are None where unknown.

    Lengths, speeds and times are in the units of the file.
    """

    time: Array
    x: Array
    y: Array
    vx: Array
    vy: Array
    tracer: Ids | None = None
    medium: Ids | None = None


FORMATS = {
    ".csv": "csv_files",
    ".npz": "npz_files",
    ".h5": "hdf5_files",
    ".hdf5": "hdf5_files",
}
"""The formats that can be read: the ending of a file's name, and the module beside this one.

A new format is a row here and a module with a function `read(path)`, which yields `Rows` in the
order of the file, and raises InputError in one line for what cannot be used.
"""


def read_rows(path: Path) -> Iterator[Rows]:
    """The rows of a file in pieces, in the order of the file.

    InputError in one line for a file that is missing, damaged, of another format, without a column
    or with a value that is not a finite number.
    """
    module = FORMATS.get(path.suffix.lower())
    if module is None:
        raise InputError(f"{shown(path)}: must be a file .csv, .npz or .h5")
    try:
        there = path.is_file()
        why = "not a file" if path.exists() else "no such file"
    except (OSError, ValueError) as error:  # a name that no file can have
        there, why = False, getattr(error, "strerror", None) or str(error)
    if not there:
        raise InputError(f"{shown(path)}: {why}")
    try:
        yield from import_module(f"{__package__}.{module}").read(path)
    except (OSError, *_DAMAGE) as error:
        if reason := getattr(error, "strerror", None):
            raise InputError(f"{shown(path)}: cannot be read ({reason})") from None
        # The libraries' own words are long and name their internals.
        raise InputError(
            f"{shown(path)}: is damaged, or not an {path.suffix} file ({type(error).__name__})"
        ) from None


def shown(path: Path | str) -> str:
    """A file's path, or its name, on one line of text that can be written: it may be any bytes."""
    text = " ".join(str(path).encode("utf-8", "replace").decode("utf-8").split()) or "''"
    return text if len(text) <= 200 else f"{text[:90]}...{text[-100:]}"


def find_columns(path: Path, names: Sequence[str]) -> dict[str, int]:
    """The place of each known column; InputError where one is missing or stands twice."""
    plain = [name.strip().strip("\"'").strip().lower() for name in names]
    for name in (*NUMBERS, *LABELS):
        if plain.count(name) > 1:
            raise InputError(f"{shown(path)}: column {name!r} stands {plain.count(name)} times")
        if name in NUMBERS and name not in plain:
            near = difflib.get_close_matches(name, plain, n=1, cutoff=0.5)
            hint = f"; is {short(near[0])} meant?" if near else ""
            raise InputError(
                f"{shown(path)}: column {name!r} is missing; needed are {', '.join(NUMBERS)}, "
                f"found are {short(', '.join(plain), 80)}{hint}"
            )
    return {name: plain.index(name) for name in (*NUMBERS, *LABELS) if name in plain}


def first_not_finite(rows: Rows) -> tuple[int, str] | None:
    """The row and the column of a NaN or an infinite number; None if every number is finite."""
    for name in NUMBERS:
        bad = np.flatnonzero(~np.isfinite(getattr(rows, name)))
        if bad.size:
            return int(bad[0]), name
    return None
