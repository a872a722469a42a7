"""The columns of particle data, the formats of their files, and the checks that all share.

A row is one tracer at one time: `time,x,y,vx,vy` (in space also `z,vz`), and where known `tracer`
and `medium` (the configuration of scatterers). Or a row is one time, with averages and their
standard errors: `time,v0,v0_error,msd,msd_error`. Other columns may stand between them; they are
not read. Columns may have the other names of the tables, or those that the user says, and a unit
behind the name: `t [s]`. A file is never held as a whole: it comes as a sequence of `Rows` (or of
`Averages`).
"""

import difflib
import re
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.errors import InputError, short
from kinetics.validation import one_of, real_number, refuse

Array = NDArray[np.float64]
Ids = NDArray[np.int64]

NUMBERS = ("time", "x", "y", "vx", "vy")
"""The columns that must be there."""
IN_SPACE = ("z", "vz")
"""Those that must be there in three dimensions. In the plane vz is read too, if it is there: a
velocity along z is refused, not left out."""
LABELS = ("tracer", "medium")
"""The columns that may be there: whole numbers, in a CSV file any text."""
ALIASES = {
    "time": ("t", "times"),
    "x": ("xu", "r_x", "rx", "pos_x", "dx"),
    "y": ("yu", "r_y", "ry", "pos_y", "dy"),
    "vx": ("v_x", "vel_x", "velo_x"),
    "vy": ("v_y", "vel_y", "velo_y"),
    "z": ("zu", "r_z", "rz", "pos_z", "dz"),
    "vz": ("v_z", "vel_z", "velo_z"),
    "tracer": ("id", "particle", "atom", "tracer_id", "particle_id"),
    "medium": ("configuration", "config", "replica", "realisation", "realization", "sample"),
}
"""Other names of columns, in lower case, which are looked for where the first is missing."""
KINDS = {
    "time": "time", "x": "length", "y": "length", "z": "length", "vx": "speed", "vy": "speed",
    "vz": "speed", "thermal_speed": "speed",
}  # fmt: skip
"""What each column of numbers is a number of."""
SQUARES = {"msd": "length", "mean_square_speed": "speed"}
"""What other columns are squares of."""
AVERAGES = {
    "thermal_speed": ("v0", "v_0", "v0(t)"),
    "mean_square_speed": ("v2", "<v2>", "<v^2>", "msv"),
    "a2": ("a_2",),
    "msd": ("r2", "<r2>", "<r^2>", "mean_square_displacement"),
    "kurtosis": (),
}
"""Averages that a table of averages may have, and other names of them."""
_ERRORS = ("_error", "_err", "_se", "_sem", "_stderr", "_sigma")
"""Endings of the name of an average's standard error."""
_UNIT = re.compile(r"(.*\S)(?:\s*\[\s*([^]]*?)\s*\]|\s+\(\s*([^)]*?)\s*\))")
POSITIONS = ("auto", "displacement", "absolute")
_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, KeyError)


@dataclass(frozen=True)
class Asked:
    """What the user says about data.

    positions : "displacement": x, y are relative to the tracer's place at time 0. "absolute":
        they are places, from which the tracer's own place at time 0 is subtracted; needs a column
        `tracer` and rows at time 0. "auto": absolute if a position at time 0 is not the origin.
    speed_unit : U in the data's unit of speed; "data": from <v^2> at time 0, as a Gaussian has it
    diameter : d in the data's unit of length
    time_unit : d/U in the data's unit of time; None: diameter/speed_unit, in the units that the
        file states, if it does
    columns : names of columns in the files by ours, {"time": "t_sim"}
    timestep : the time of one step, for formats whose frames give steps
    dimension : 2 or 3; None: that of an Ensemble, or 2
    bin_times : times that differ by less than this fraction are one time, at their mean
    with_field : whether the sums are needed that averages in a field are made of
    """

    positions: str = "auto"
    speed_unit: float | str = 1.0
    diameter: float = 1.0
    time_unit: float | None = None
    columns: Mapping[str, str] = field(default_factory=dict)
    timestep: float | None = None
    dimension: int | None = None
    bin_times: float | None = None
    with_field: bool = False

    def __post_init__(self) -> None:
        one_of("positions", self.positions, POSITIONS)
        if not (isinstance(self.speed_unit, str) and self.speed_unit == "data"):
            self._check_unit("speed_unit")
        self._check_unit("diameter")
        for name in ("time_unit", "timestep"):
            if getattr(self, name) is not None:
                self._check_unit(name)
        if self.dimension not in (None, 2, 3):
            refuse("dimension", self.dimension, "it must be 2 or 3")
        if self.bin_times is not None:
            allowed = "it must be a number from 0 to 0.2, a fraction of the time"
            real_number("bin_times", self.bin_times, 0.0, 0.2, allowed)
        object.__setattr__(self, "columns", checked_columns(self.columns or {}))

    def _check_unit(self, name: str) -> None:
        # a unit enters as its square and its cube, which must be finite
        object.__setattr__(self, name, real_number(name, getattr(self, name), 1e-100, 1e100))

    @property
    def numbers(self) -> tuple[str, ...]:
        """The columns of numbers that must be there."""
        return (*NUMBERS, *IN_SPACE) if self.dimension == 3 else NUMBERS


def parsed_columns(text: str) -> dict[str, str]:
    """The names of `time=t_sim,tracer=id`; InputError for another form or an unknown column."""
    found = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equal, theirs = (piece.strip() for piece in part.partition("="))
        if not equal or not theirs:
            raise InputError(f"columns: got {short(part)}; it must be like time=t,tracer=id")
        if name in found:
            raise InputError(f"columns: {short(name)} stands twice")
        found[name] = theirs
    return checked_columns(found)


def checked_columns(columns: Mapping[str, str]) -> dict[str, str]:
    """Names of columns by ours, with our names spelt out; InputError for unknown or double ones."""
    found: dict[str, str] = {}
    known = (*NUMBERS, *IN_SPACE, *LABELS)
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

    Lengths, speeds and times are in the units of the file. z and vz are None in the plane. units:
    those that the file states, by "length", "speed" and "time". box: lengths of a periodic box in
    which positions may be wrapped, (dimension,), None if there is none or it is unknown.
    """

    time: Array
    x: Array
    y: Array
    vx: Array
    vy: Array
    tracer: Ids | None = None
    medium: Ids | None = None
    z: Array | None = None
    vz: Array | None = None
    units: Mapping[str, str] | None = None
    box: tuple[float, ...] | None = None

    @property
    def position(self) -> tuple[Array, ...]:
        """x, y and, in space, z."""
        return (self.x, self.y) if self.z is None else (self.x, self.y, self.z)

    @property
    def velocity(self) -> tuple[Array, ...]:
        """vx, vy and, in space, vz."""
        return (self.vx, self.vy) if self.vz is None else (self.vx, self.vy, self.vz)

    def part(self, chosen: Any) -> "Rows":
        """The rows that an index or a mask says."""
        arrays: dict[str, Any] = {
            k: v[chosen] for k, v in vars(self).items() if isinstance(v, np.ndarray)
        }
        return replace(self, **arrays)

    def at(self, position: Any) -> "Rows":
        """The rows at other positions, (dimension, n)."""
        places: dict[str, Any] = dict(zip("xyz", position, strict=False))
        return replace(self, **places)


@dataclass(frozen=True)
class Averages:
    """A piece of a table of averages: "time", averages by their names in AVERAGES and, behind
    "error of ", their standard errors, (n,) each.
    """

    columns: Mapping[str, Array]
    units: Mapping[str, str] | None = None

    @property
    def time(self) -> Array:
        """The times, (n,)."""
        return self.columns["time"]


def piece_of(values: dict[str, Any], units: Mapping[str, str] | None = None) -> "Rows | Averages":
    """The rows, or the averages, of columns by name."""
    return Rows(**values, units=units) if "x" in values else Averages(values, units)


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
    ".gsd": "gsd_files",
}
"""The formats that can be read: the ending of a file's name, and the module beside this one.

A new format is a row here and a module with a function `read(path, asked)`, which yields `Rows` in
the order of the file, and raises InputError in one line for what cannot be used.
"""


def read_rows(path: Path | Table, asked: Asked | None = None) -> "Iterator[Rows | Averages]":
    """The rows of a file, or of columns in memory, in pieces, in the order of the file.

    InputError in one line for a file that is missing, damaged, of another format, without a column
    or with a value that is not a finite number, and for motion along z where dimension is not 3.
    """
    asked = asked or Asked()
    for piece in _read(path, asked):
        if isinstance(piece, Rows) and asked.dimension == 3:
            if piece.z is None or piece.vz is None:
                raise InputError(f"{named(path)}: has no z components; dimension 3 needs them")
        elif isinstance(piece, Rows):
            if piece.vz is not None and np.any(piece.vz != 0):
                raise InputError(
                    f"{named(path)}: velocities have a z component; say dimension 3 for motion in "
                    "space"
                )
            piece = replace(piece, z=None, vz=None)
        yield piece


def _read(path: Path | Table, asked: Asked) -> "Iterator[Rows | Averages]":
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


def named(path: Path | Table) -> str:
    """A file's path, or the name of a table, on one line."""
    return path.name if isinstance(path, Table) else shown(path)


def split_unit(name: str) -> tuple[str, str]:
    """The name of a column without its unit, in lower case, and the unit: "t [s]", "t (s)"."""
    found = _UNIT.fullmatch(name.strip())
    bare, unit = (found[1], found[2] or found[3] or "") if found else (name, "")
    return bare.strip().lower(), unit


def find_columns(path: Path | str, names: Sequence[str], asked: Asked) -> dict[str, int]:
    """The place of each known column; InputError where one is missing or stands twice."""
    plain = [name.strip().strip("\"'").strip().lower() for name in names]
    bare = [split_unit(name)[0] for name in plain]
    if averages := _find_averages(bare, asked):
        return averages
    found: dict[str, int] = {}
    for name in (*NUMBERS, *IN_SPACE, *LABELS):
        needed = name in asked.numbers or name in asked.columns
        if name == "z" and not needed:
            continue
        wanted = asked.columns.get(name)
        if wanted is not None:
            here = [wanted.strip().lower()]
        else:
            here = [name] if name in bare else [one for one in ALIASES[name] if one in bare]
        known = plain if here and here[0] in plain else bare
        if len(here) > 1 or (here and known.count(here[0]) > 1):
            count = sum(known.count(one) for one in here)
            also = f" (as {' and '.join(here)})" if len(here) > 1 else ""
            raise InputError(f"{shown(path)}: column {name!r} stands {count} times{also}")
        if here and here[0] in known:
            place = known.index(here[0])
            if place in found.values():
                other = next(one for one, taken in found.items() if taken == place)
                raise InputError(f"{shown(path)}: column {here[0]!r} cannot be {other} and {name}")
            found[name] = place
        elif needed:
            raise _missing(path, here[0] if here else name, plain, asked)
    return found


def _missing(path: Path | str, name: str, plain: Sequence[str], asked: Asked) -> InputError:
    near = difflib.get_close_matches(name, plain, n=1, cutoff=0.5)
    hint = f"; is {short(near[0])} meant? Say so by --columns" if near else ""
    return InputError(
        f"{shown(path)}: column {name!r} is missing; needed are "
        f"{', '.join(asked.numbers)}, found are {short(', '.join(plain), 80)}{hint}"
    )


def _find_averages(bare: Sequence[str], asked: Asked) -> dict[str, int]:
    """The places of the columns of a table of averages; empty where it is none."""
    if any(name in bare or name in asked.columns for name in ("x", "vx", *ALIASES["x"])):
        return {}
    time = asked.columns.get("time", "").strip().lower()
    times = [k for k, one in enumerate(bare) if one in (time, "time", *ALIASES["time"])]
    found: dict[str, int] = {}
    for name, others in AVERAGES.items():
        for one in (name, *others):
            error = next((f"{one}{end}" for end in _ERRORS if f"{one}{end}" in bare), None)
            if one in bare and error is not None:
                found |= {name: bare.index(one), f"error of {name}": bare.index(error)}
    return {"time": times[0]} | found if found and times else {}


def stated_units(path: Path | str, units: Mapping[str, str]) -> dict[str, str]:
    """Units by "length", "speed" and "time", from those of columns; InputError if x and y differ.

    units: by column; those without one are left out.
    """
    found: dict[str, str] = {}
    for name, unit in units.items():
        kind = KINDS.get(name)
        if name in SQUARES:
            kind, unit = SQUARES[name], re.sub(r"(\^?2|²)$", "", unit).strip("()")
        if kind and unit and found.setdefault(kind, unit) != unit:
            raise InputError(f"{shown(path)}: has {kind}s in {found[kind]} and in {short(unit)}")
    return found


def first_not_finite(values: Mapping[str, Any]) -> tuple[int, str] | None:
    """The row and the column of a NaN or an infinite number; None if every number is finite.

    Averages may be NaN where they are not known.
    """
    for name in ("time",) if "x" not in values else (*NUMBERS, *IN_SPACE):
        if values.get(name) is not None:
            bad = np.flatnonzero(~np.isfinite(values[name]))
            if bad.size:
                return int(bad[0]), name
    return None
