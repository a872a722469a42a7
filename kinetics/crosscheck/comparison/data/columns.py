"""The columns of particle data, the formats of their files, and the checks that all share.

A row is one tracer at one time: `time,x,y,vx,vy`, and where known `tracer` and `medium` (the
configuration of scatterers). Other columns may stand between them; they are not read. Columns may
have the other names of the table ALIASES, or those that the user says. A file is never held as a
whole: it comes as a sequence of `Rows`.
"""

import difflib
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.errors import InputError, short

Array = NDArray[np.float64]
Ids = NDArray[np.int64]

NUMBERS = ("time", "x", "y", "vx", "vy")
"""The columns that must be there."""
LABELS = ("tracer", "medium")
"""The columns that may be there: whole numbers, in a CSV file any text."""
ALIASES = {
    "time": ("t", "times"),
    "x": ("xu", "r_x", "rx", "pos_x", "dx"),
    "y": ("yu", "r_y", "ry", "pos_y", "dy"),
    "vx": ("v_x", "vel_x", "velo_x"),
    "vy": ("v_y", "vel_y", "velo_y"),
    "tracer": ("id", "particle", "atom", "tracer_id", "particle_id"),
    "medium": ("configuration", "config", "replica", "realisation", "realization", "sample"),
}
"""Other names of columns, in lower case, which are looked for where the first is missing."""
_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, KeyError)


@dataclass(frozen=True)
class Asked:
    """What the user says about files.

    columns: names of columns in them by ours, {"time": "t_sim"}; timestep: the time of one step,
    for frames that give steps.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    timestep: float | None = None


def parsed_columns(text: str) -> dict[str, str]:
    """The names of `time=t_sim,tracer=id`; InputError for another form or an unknown column."""
    found = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equal, theirs = (piece.strip() for piece in part.partition("="))
        if not equal or not theirs:
            raise InputError(f"columns: got {short(part)}; it must be like time=t,tracer=id")
        found[name] = theirs
    return checked_columns(found)


def checked_columns(columns: Mapping[str, str]) -> dict[str, str]:
    """Names of columns by ours, with our names spelt out; InputError for unknown or double ones."""
    found: dict[str, str] = {}
    known = (*NUMBERS, *LABELS)
    for name, theirs in columns.items():
        plain = str(name).strip().lower()
        ours = next((one for one in known if plain == one or plain in ALIASES[one]), None)
        if ours is None or ours in found:
            why = "stands twice" if ours else "is not known"
            raise InputError(f"columns: {short(name)} {why}; allowed are {', '.join(known)}")
        found[ours] = str(theirs)
    return found


@dataclass(frozen=True)
class Table:
    """Columns in memory, of one length, that take the place of a file."""

    columns: Mapping[str, Any]
    name: str = "data"


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
    ".parquet": "parquet_files",
    ".h5md": "hdf5_files",
    ".dump": "lammps_files",
    ".lammpstrj": "lammps_files",
    ".xyz": "xyz_files",
    ".extxyz": "xyz_files",
}
"""The formats that can be read: the ending of a file's name, and the module beside this one.

A new format is a row here and a module with a function `read(path, asked)`, which yields `Rows` in
the order of the file, and raises InputError in one line for what cannot be used.
"""


def read_rows(path: Path | Table, asked: Asked | None = None) -> Iterator[Rows]:
    """The rows of a file, or of columns in memory, in pieces, in the order of the file.

    InputError in one line for a file that is missing, damaged, of another format, without a column
    or with a value that is not a finite number.
    """
    asked = asked or Asked()
    if isinstance(path, Table):
        yield from import_module(f"{__package__}.arrays").read_table(path, asked)
        return
    module = FORMATS.get(path.suffix.lower())
    if module is None:
        raise InputError(f"{shown(path)}: must be a file .csv, .npz or .h5 (or {_others()})")
    try:
        there = path.is_file()
        why = "not a file" if path.exists() else "no such file"
    except (OSError, ValueError) as error:  # a name that no file can have
        there, why = False, getattr(error, "strerror", None) or str(error)
    if not there:
        raise InputError(f"{shown(path)}: {why}")
    try:
        yield from import_module(f"{__package__}.{module}").read(path, asked)
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


def _others() -> str:
    return ", ".join(one for one in FORMATS if one not in (".csv", ".npz", ".h5"))


def find_columns(path: Path | str, names: Sequence[str], asked: Asked) -> dict[str, int]:
    """The place of each known column; InputError where one is missing or stands twice."""
    plain = [name.strip().strip("\"'").strip().lower() for name in names]
    found = {}
    for name in (*NUMBERS, *LABELS):
        wanted = asked.columns.get(name)
        if wanted is not None:
            here = [wanted.strip().lower()]
        else:
            here = [name] if name in plain else [one for one in ALIASES[name] if one in plain]
        if len(here) > 1 or (here and plain.count(here[0]) > 1):
            count = sum(plain.count(one) for one in here)
            also = f" (as {' and '.join(here)})" if len(here) > 1 else ""
            raise InputError(f"{shown(path)}: column {name!r} stands {count} times{also}")
        if here and here[0] in plain:
            found[name] = plain.index(here[0])
        elif name in NUMBERS or wanted is not None:
            near = difflib.get_close_matches(here[0] if here else name, plain, n=1, cutoff=0.5)
            hint = f"; is {short(near[0])} meant? Say so by --columns" if near else ""
            raise InputError(
                f"{shown(path)}: column {(here[0] if here else name)!r} is missing; needed are "
                f"{', '.join(NUMBERS)}, found are {short(', '.join(plain), 80)}{hint}"
            )
    return found


def first_not_finite(rows: Rows) -> tuple[int, str] | None:
    """The row and the column of a NaN or an infinite number; None if every number is finite."""
    for name in NUMBERS:
        bad = np.flatnonzero(~np.isfinite(getattr(rows, name)))
        if bad.size:
            return int(bad[0]), name
    return None
