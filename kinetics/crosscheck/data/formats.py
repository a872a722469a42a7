"""Files of particle data: a format is one function and one row of `FORMATS`, at the end.

A function is given the path, its name for messages and what was asked (`tracks.Asked`); it returns
`Tracks`, or the columns that `tracks.from_columns` makes of it. Nothing in a file is executed,
links into other files are not followed, and sizes are checked before memory is asked for.
"""

import csv
import gzip
import re
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.data.tracks import (
    AXES,
    LABELS,
    MOST_TIMES,
    SPEEDS,
    Asked,
    Averages,
    Table,
    Tracks,
    checked,
    find_columns,
    from_columns,
    name_of,
    require_memory,
)
from kinetics.crosscheck.data.units import split_unit, stated
from kinetics.errors import InputError, short

Read = Tracks | Averages
FRAMES = ("times", "positions", "velocities")
"""The names of arrays of frames, (n_times,) and twice (n_times, n_tracers, dimension)."""
_BLOCK = 8 << 20
"""Bytes of a CSV file that are parsed at once, so that memory stays small."""
_LONGEST_LINE = 1 << 20


def read(source: Path | Table, asked: Asked) -> Read:
    """Tracks, or a table of averages, from a file or from columns in memory.

    InputError in one line for a file that is missing, damaged or of another format, without a
    column, or with a value that is not a finite number.
    """
    where = name_of(source)
    if isinstance(source, Table):
        found = _arrays(where, source.columns, asked)
    else:
        reader = _reader(source, where)
        try:
            found = reader(source, where, asked)
        except InputError:
            raise
        except Exception as error:  # the libraries raise errors of nearly any class
            why = getattr(error, "strerror", None)
            bad = f"is damaged, or not an {source.suffix} file ({type(error).__name__})"
            raise InputError(f"{where}: {f'cannot be read ({why})' if why else bad}") from None
    return checked(where, found, asked) if isinstance(found, Tracks) else found


def _reader(path: Path, where: str) -> Callable[[Path, str, Asked], Read]:
    ending = path.suffix.lower()
    if ending == ".gz" and path.stem.lower().endswith((".csv", ".tsv")):
        ending = ".csv"
    if ending not in FORMATS:
        raise InputError(f"{where}: must be a file {', '.join(FORMATS)} or .csv.gz")
    try:
        there, why = path.is_file(), "not a file" if path.exists() else "no such file"
    except (OSError, ValueError) as error:  # a name that no file can have
        there, why = False, getattr(error, "strerror", None) or str(error)
    if not there:
        raise InputError(f"{where}: {why}")
    return FORMATS[ending]


# -- columns ---------------------------------------------------------------------------------------


def _arrays(where: str, arrays: Mapping[str, Any], asked: Asked) -> Read:
    """Columns of one length, or arrays of frames, by the names of the file."""
    if {*FRAMES} <= {*arrays}:
        shapes = [np.shape(arrays[name]) for name in FRAMES]
        if len(shapes[1]) != 3 or shapes[0] != shapes[1][:1] or shapes[0][0] > MOST_TIMES:
            raise InputError(
                f"{where}: times, positions, velocities have shapes {shapes[0]}, {shapes[1]}, "
                f"{shapes[2]}; they must be (n_times,), at most {MOST_TIMES}, and twice "
                "(n_times, n_tracers, 2 or 3)"
            )
        times, place, velocity = (_numbers(where, name, arrays[name]) for name in FRAMES)
        return Tracks(times, place, velocity, np.arange(shapes[1][1]))
    names = list(arrays)
    found = find_columns(where, names, asked)
    columns = {ours: np.asarray(arrays[names[k]]) for ours, k in found.items()}
    units = {ours: split_unit(names[k])[1] for ours, k in found.items()}
    return from_columns(where, columns, asked, units)


def _numbers(where: str, name: str, values: Any) -> Any:
    array = np.asarray(values)
    if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
        raise InputError(f"{where}: array {name!r} is of type {array.dtype}; needed are numbers")
    return array.astype(float)


_REMARK = re.compile(rb"^[ \t\r]*(#.*)?$", re.MULTILINE)


def _csv(path: Path, where: str, asked: Asked, texts: bool = False) -> Read:
    """Commas, semicolons or tabs, as the first line has them; blank lines and # are passed over."""
    with gzip.open(path, "rb") if path.suffix.lower() == ".gz" else open(path, "rb") as file:
        header, line = "", 1
        while not header:
            raw = file.readline(_LONGEST_LINE)
            if not raw:
                raise InputError(f"{where}: is empty; its first line must name the columns")
            # numpy.savetxt writes the names behind a #
            text = raw.decode("utf-8-sig").strip()
            bare = text.lstrip("#").strip()
            words = re.split(r"[\s,;\"']+", bare.lower())
            names_columns = "time" in words or ("t" in words and len(words) > 4)
            header, line = "" if text.startswith("#") and not names_columns else bare, line + 1
        separator = max(",;\t", key=header.count)
        names = header.split(separator)
        if all(_is_number(name) for name in names):
            raise InputError(f"{where}: has no header; its first line must name the columns")
        found = find_columns(where, names, asked)
        require_memory(where, 0.3 * path.stat().st_size)  # 17 digits and a comma are 8 bytes
        parts: list[list[Any]] = []
        while block := file.read(_BLOCK):
            block += file.readline(_LONGEST_LINE)  # only whole lines are parsed
            columns = _block(block, names, separator, found, texts)
            if columns is None and not texts and any(name in LABELS for name in found):
                return _csv(path, where, asked, True)
            if columns is None:
                raise _fault_of(where, block, line, names, separator, found)
            parts.append(columns)
            line += block.count(b"\n")
            if not block.endswith(b"\n"):
                raise InputError(f"{where}: line {line} has no end; the file may be cut off there")
            if path.suffix == ".gz":
                require_memory(where, 8.0 * sum(len(x) for part in parts for x in part))
    joined = [np.concatenate(column) for column in zip(*parts, strict=True)] or [np.empty(0)] * 99
    units = {ours: split_unit(names[k])[1] for ours, k in found.items()}
    return from_columns(where, dict(zip(found, joined, strict=False)), asked, units)


def _block(
    text: bytes, names: Sequence[str], separator: str, found: Mapping[str, int], texts: bool
) -> list[Any] | None:
    """The columns of whole lines; None where a line or a number cannot be read."""
    import pyarrow as pa
    from pyarrow import csv

    known = {place: ours for ours, place in found.items()}
    label = pa.string() if texts else pa.int64()
    kinds = {ours: label if ours in LABELS else pa.float64() for ours in found}
    bare = text if b"#" not in text else _REMARK.sub(b"", text)
    if bare.isspace() or not bare:
        return [np.empty(0)] * len(found)
    try:
        table = csv.read_csv(
            pa.BufferReader(bare),
            csv.ReadOptions(column_names=[known.get(k, str(k)) for k in range(len(names))]),
            csv.ParseOptions(delimiter=separator),
            csv.ConvertOptions(column_types=kinds, include_columns=list(kinds), null_values=[]),
        ).combine_chunks()
    except pa.ArrowInvalid:
        return None
    columns = [
        np.array(table.column(ours).to_pylist(), str)
        if texts and ours in LABELS
        else np.from_dlpack(table.column(ours).chunk(0))
        for ours in found
    ]
    real = (c for c, ours in zip(columns, found, strict=True) if ours not in LABELS)
    return columns if "x" not in found or all(np.all(np.isfinite(c)) for c in real) else None


def _is_number(cell: str) -> bool:
    try:
        return bool(np.isfinite(float("" if "_" in cell else cell)))
    except ValueError:
        return False


def _fault_of(
    where: str, text: bytes, line: int, names: Sequence[str], separator: str,
    found: Mapping[str, int],
) -> InputError:  # fmt: skip
    """The first line of a block that cannot be read, and its column."""
    for number, content in enumerate(text.decode("utf-8", "replace").split("\n"), line):
        if not content.strip() or content.lstrip().startswith("#"):
            continue
        cells = next(csv.reader([content], delimiter=separator))
        if len(cells) != len(names):
            what = f"has {len(cells)} columns; {len(names)} are named in the first line"
            return InputError(f"{where}: line {number} {what}")
        for ours, k in found.items():
            if ours not in LABELS and not _is_number(cells[k]):
                why = "is not a finite number with a decimal point"
                return InputError(
                    f"{where}: line {number}, column {ours!r}: {short(cells[k])} {why}"
                )
    return InputError(f"{where}: is not readable from line {line} on (quotes, or not UTF-8)")


def _parquet(path: Path, where: str, asked: Asked) -> Read:
    from pyarrow import parquet, types

    with parquet.ParquetFile(path) as file:
        names = file.schema_arrow.names
        found = find_columns(where, names, asked)
        require_memory(where, 8.0 * file.metadata.num_rows * len(found))
        table = file.read([names[k] for k in found.values()])
    columns: dict[str, Any] = {}
    for ours, k in found.items():
        column = table.column(names[k])
        if column.null_count:
            raise InputError(f"{where}: column {ours!r} has empty cells")
        if types.is_integer(column.type) or types.is_floating(column.type):
            parts = [np.from_dlpack(chunk) for chunk in column.chunks]
            columns[ours] = np.concatenate(parts) if parts else np.empty(0)
        elif ours in LABELS:
            columns[ours] = np.array(column.to_pylist(), str)
        else:
            raise InputError(f"{where}: column {ours!r} is {column.type}; it must be real numbers")
    units = {ours: split_unit(names[k])[1] for ours, k in found.items()}
    return from_columns(where, columns, asked, units)


def _npz(path: Path, where: str, asked: Asked) -> Read:
    """Arrays of numbers; Python objects are pickles, which can run code, and are never loaded."""
    with zipfile.ZipFile(path) as archive:
        sizes = {one.filename: one for one in archive.infolist()}
    names = [name.removesuffix(".npy") for name in sizes if name.endswith(".npy")]
    used = set(FRAMES)
    if not used <= {*names}:
        used = {names[k] for k in find_columns(where, names, asked).values()}
    for name in used:
        info = sizes[f"{name}.npy"]
        require_memory(where, float(info.file_size), float(info.compress_size))
        if name == "times" and info.file_size > 100 * MOST_TIMES:
            raise InputError(f"{where}: times: more than {MOST_TIMES} different times")
    require_memory(where, float(sum(sizes[f"{name}.npy"].file_size for name in used)))
    with np.load(path, allow_pickle=False) as file:
        return _arrays(where, {name: file[name] for name in names if name in used}, asked)


# -- HDF5 ------------------------------------------------------------------------------------------


def _hdf5(path: Path, where: str, asked: Asked) -> Read:
    import h5py

    with h5py.File(path, "r") as file:
        if _own(file, "h5md") and _own(file, "particles"):
            return _h5md(where, file["particles"], asked)
        names = [name for name in file if _own(file, name, h5py.Dataset)]
        if not {*FRAMES} <= {*names}:
            names = [names[k] for k in find_columns(where, names, asked).values()]
        arrays = {name: _dataset(where, file, name) for name in names}
        require_memory(where, sum(float(a.size) * a.dtype.itemsize for a in arrays.values()))
        stated = {name: _unit_of(one) for name, one in arrays.items()}
        named = {f"{k} [{stated[k]}]" if stated[k] else k: one for k, one in arrays.items()}
        return _arrays(where, named, asked)


def _own(parent: Any, name: str, kind: Any = None) -> bool:
    """Whether a group has this member in its own file; links into other files are not followed."""
    import h5py

    own = isinstance(parent.get(name, getlink=True), h5py.HardLink)
    return own and isinstance(parent[name], kind or h5py.Group)


def _dataset(where: str, parent: Any, name: str) -> Any:
    """A dataset of numbers that lie in this file, or the `value` of an element; or InputError."""
    import h5py

    if _own(parent, name):
        parent, name = parent[name], "value"
    found = parent[name] if _own(parent, name, h5py.Dataset) else None
    if found is None or found.is_virtual or found.external or found.dtype.kind not in "iuf":
        raise InputError(f"{where}: {parent.name}/{name} must be numbers in this file")
    require_memory(
        where, float(found.size or 0) * found.dtype.itemsize, found.id.get_storage_size()
    )
    return found


def _unit_of(dataset: Any) -> str:
    unit = dataset.attrs.get("unit", dataset.attrs.get("units", ""))
    return unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)


def _h5md(where: str, particles: Any, asked: Asked) -> Read:
    """The only group of particles with positions and velocities; the layout is at nongnu.org.

    Times stand as a dataset (n_times,), or as a step between frames with an offset. Positions are
    unwrapped by the element `image` where it stands. An element `medium` (n_tracers,), which this
    package writes, says the configuration of each tracer.
    """
    both = ("position", "velocity")
    groups = [particles[name] for name in particles if _own(particles, name)]
    groups = [group for group in groups if all(_own(group, part) for part in both)]
    if len(groups) != 1:
        raise InputError(f"{where}: has {len(groups)} groups with position and velocity, not 1")
    (group,) = groups
    place, velocity = (_dataset(where, group, name) for name in both)
    shape = place.shape
    if len(shape) != 3 or shape[:2] != velocity.shape[:2] or shape[0] > MOST_TIMES:
        raise InputError(
            f"{where}: position and velocity have shapes {shape} and {velocity.shape}; they must "
            f"be (T, n, 2 or 3), T at most {MOST_TIMES}"
        )
    times, same = (_times(where, group[name], shape[0], asked) for name in both)
    if not np.array_equal(times, same):
        raise InputError(f"{where}: position and velocity are given at different times")
    require_memory(where, 8.0 * (float(place.size) + float(velocity.size)))
    r, v, box = np.asarray(place, float), np.asarray(velocity, float), _box(where, group)
    if "image" in group:
        image = np.asarray(_dataset(where, group, "image"), float)
        if box is None or image.shape != shape or box.size < shape[2]:
            raise InputError(f"{where}: image flags need a rectangular box that is always the same")
        r, box = r + image * box[: shape[2]], None
    elif box is not None:
        edges = np.asarray(group["box"].attrs.get("boundary", ("none",))).astype(str)
        box = box if np.all(edges == "periodic") else None
    labels = {name: _labels(where, group, name, shape) for name in ("id", "medium", "species")}
    chosen = np.ones(shape[1], bool)
    if asked.type is not None:
        if labels["species"] is None:
            raise InputError(f"{where}: type: got {short(asked.type)}; there is no species")
        chosen = labels["species"].reshape(-1, shape[1])[0].astype(str) == str(asked.type)
    tracer = np.arange(shape[1]) if labels["id"] is None else labels["id"]
    if tracer.ndim == 2:  # particles may change places from frame to frame
        order = np.argsort(tracer, axis=1, kind="stable")
        r, v = (np.take_along_axis(a, order[..., None], 1) for a in (r, v))
        every = np.take_along_axis(tracer, order, 1)
        tracer = every[0]
        if np.any(every != tracer):
            raise InputError(f"{where}: id must hold the same labels at all times")
    units = {"x": _unit_of(place), "vx": _unit_of(velocity)}
    if "time" in group["position"]:
        units["time"] = _unit_of(group["position"]["time"])
    medium = labels["medium"][chosen] if labels["medium"] is not None else None
    said = stated(where, units)
    return Tracks(times, r[:, chosen], v[:, chosen], tracer[chosen], medium, box, said)


def _times(where: str, element: Any, count: int, asked: Asked) -> Any:
    """The times of an element, (count,): as they stand, or steps times the timestep."""
    found: dict[str, Any] = {}
    for name in (name for name in ("time", "step") if name in element):
        one = _dataset(where, element, name)
        if one.shape not in ((), (count,)):
            raise InputError(f"{where}: {one.name} must be {count} numbers")
        found[name] = np.asarray(one, float)
        if one.shape == ():  # a fixed step, from an offset on
            offset = float(np.asarray(one.attrs.get("offset", 0.0), float))
            found[name] = offset + np.arange(count) * float(one[()])
    return asked.times_of(where, found.get("time"), found.get("step"))


def _box(where: str, group: Any) -> Any:
    """The lengths of a rectangular box that is always the same; None for any other."""
    if not _own(group, "box") or "edges" not in group["box"]:
        return None
    edges = np.asarray(_dataset(where, group["box"], "edges"), float)
    if edges.ndim == 2 and edges.size and np.all(edges == edges[0]):
        edges = edges[0]
    return edges if edges.ndim == 1 and edges.size > 1 and np.all(edges > 0) else None


def _labels(where: str, group: Any, name: str, shape: Any) -> Any:
    """Labels (n,), or (T, n) of an element in time; None where there are none."""
    if name not in group:
        return None
    found = np.asarray(_dataset(where, group, name))
    if found.shape not in (shape[:2], shape[1:2]) or np.any(found % 1 != 0):
        raise InputError(f"{where}: {name} must be a whole number for each of {shape[1]} tracers")
    return found.astype(np.int64)


# -- frames of text --------------------------------------------------------------------------------


class _Lines:
    """The lines of a text file, one after another, and the number of the last."""

    def __init__(self, file: Any, where: str) -> None:
        self._file, self.where, self.number = file, where, 0

    def next(self) -> str | None:
        """The next line; None at the end of the file."""
        line = self._file.readline(_LONGEST_LINE)
        self.number += bool(line)
        return line or None

    def items(self) -> Iterator[str]:
        """The lines from here on that are not blank, to the end of the file."""
        while (line := self.next()) is not None:
            if line.strip():
                yield line.strip()

    def bad(self, why: str) -> InputError:
        """The error at the last line."""
        return InputError(f"{self.where}: line {self.number}: {why}")

    def whole(self, what: str, text: str | None) -> int:
        """A whole number that is not negative."""
        plain = (text or "").strip()
        if not plain.isdecimal() or len(plain) > 18:
            raise self.bad(f"{what} is not a whole number: {plain[:40]!r}")
        return int(plain)

    def real(self, what: str, text: str | None) -> float:
        """A finite number."""
        try:
            value = float((text or "")[:1000])
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise self.bad(f"{what} is not a finite number: {short(text)}")
        return value

    def table(self, count: int, names: Sequence[str], used: Mapping[str, int]) -> dict[str, Any]:
        """Columns of the next `count` lines: (count,) each, numbers except the type.

        InputError for a line that is missing, blank, joined with another, or of other columns.
        """
        parts: dict[str, list[Any]] = {name: [] for name in used}
        while count:
            lines = [*islice(self._file, min(count, 50_000))]
            self.number += len(lines)
            if not lines or not lines[-1].endswith("\n"):
                raise self.bad("the file is cut off here")
            try:  # numpy checks all but blank lines, which it passes over
                found: Any = np.loadtxt(lines, comments=None, ndmin=2)
            except ValueError:
                found = np.empty((0, 0))
            if found.shape != (len(lines), len(names)):
                found = self._cells(lines, names, used)
            for name, k in used.items():
                parts[name].append(found[:, k].astype(object if name == "type" else float))
            count -= len(lines)
        return {name: np.concatenate(part) if part else np.empty(0) for name, part in parts.items()}

    def _cells(self, lines: Sequence[str], names: Sequence[str], used: Mapping[str, int]) -> Any:
        """The cells of lines that hold texts too, or the error of the first that is wrong."""
        rows = [line.split() for line in lines]
        last = self.number
        for self.number, row in enumerate(rows, last - len(rows) + 1):
            if len(row) != len(names):
                raise self.bad(f"has {len(row)} columns; {len(names)} are named")
            for name, k in used.items():
                if name != "type" and not _is_number(row[k]) and row[k].lower() != "nan":
                    raise self.bad(f"column {name!r}: {short(row[k])} is not a number")
        return np.array(rows, object)


_STYLES = {
    "real": ("angstrom", "angstrom/fs", "fs"), "metal": ("angstrom", "angstrom/ps", "ps"),
    "si": ("m", "m/s", "s"), "cgs": ("cm", "cm/s", "s"), "micro": ("um", "um/us", "us"),
    "nano": ("nm", "nm/ns", "ns"), "lj": ("", "", ""),
}  # fmt: skip
"""Units of length, speed and time of the styles of LAMMPS (docs.lammps.org/units.html)."""


def _of_lines(
    parse: Callable[[_Lines, Asked], Read],
) -> Callable[[Path, str, Asked], Read]:
    """The reader of a text file, from a function of its lines."""

    def reader(path: Path, where: str, asked: Asked) -> Read:
        require_memory(where, 0.5 * path.stat().st_size)
        with open(path, encoding="utf-8", errors="replace") as file:
            return parse(_Lines(file, where), asked)

    return reader


def _lammps(lines: _Lines, asked: Asked) -> Read:
    """A text dump with id, vx, vy and xu, yu, or x, y with or without image flags ix, iy."""
    frames, units, boxes, head = [], tuple[str, ...](), [], dict[str, Any]()
    where = lines.where
    for line in lines.items():
        if not line.startswith("ITEM: "):
            raise lines.bad(f"is not of a LAMMPS text dump: {line[:40]!r}")
        item = line[6:].strip()
        if item == "TIMESTEP":
            head = {"step": lines.whole("a step", lines.next())}
        elif item == "TIME":
            head["time"] = lines.real("a time", lines.next())
        elif item.startswith("NUMBER OF ATOMS"):
            head["count"] = lines.whole("the number of atoms", lines.next())
        elif item == "UNITS":
            unit = (lines.next() or "").strip()
            units = _STYLES.get(unit, (unit, unit, unit))
        elif item.startswith("BOX BOUNDS"):
            bounds = [(lines.next() or "").split() for _ in range(3)]
            if any(len(edge) != 2 for edge in bounds):
                raise lines.bad("the box must be rectangular, with two bounds a line")
            edges = np.array([[lines.real("a bound", x) for x in edge] for edge in bounds])
            head["low"], head["length"] = edges[:, 0], edges[:, 1] - edges[:, 0]
            head["periodic"] = [one == "pp" for one in item.split()[2:]]
        elif item.startswith("ATOMS"):
            if not {"step", "count"} <= {*head}:
                raise lines.bad("a frame has no step or no number of atoms")
            frame, wrapped = _lammps_frame(lines, item.split()[1:], head, asked)
            step = head["step"]
            frame["time"] = np.full(head["count"], asked.times_of(where, head.get("time"), step))
            frames.append(frame)
            d = 3 if asked.dimension == 3 else 2
            known = wrapped and head.get("periodic") and all(head["periodic"][:d])
            boxes.append(tuple(head["length"][:d]) if known else None)
            head = {}
    if not frames or head:
        raise InputError(f"{where}: is empty, cut off, or not a LAMMPS text dump")
    named: dict[str, str] = dict(zip(("x", "vx", "time"), units, strict=False))
    box = np.array(boxes[0]) if boxes[0] and len({*boxes}) == 1 else None
    return _of_frames(where, frames, asked, named, box)


def _lammps_frame(
    lines: _Lines, names: list[str], head: Mapping[str, Any], asked: Asked
) -> tuple[dict[str, Any], bool]:
    """The columns of one frame, and whether positions may be wrapped."""
    axes = AXES[: 3 if asked.dimension == 3 else 2]
    kinds = (("{}u",), ("{}su",), ("{}", "i{}"), ("{}s", "i{}"), ("{}",), ("{}s",))
    sets = [tuple(part.format(axis) for part in kind for axis in axes) for kind in kinds]
    found = next((one for one in sets if {*one} <= {*names}), None)
    lost = [name for name in ("id", *(f"v{axis}" for axis in axes)) if name not in names]
    if found is None or lost:
        raise lines.bad(
            f"column {lost[0] if lost else 'xu'!r} is missing; a dump needs id, vx, vy and xu, yu "
            "(or x, y, ix, iy)"
        )
    wanted = ["id", *found, *(v for v in SPEEDS if v in names)]
    used = {name: _once(lines, names, name) for name in wanted}
    if asked.type is not None:
        kind = next((one for one in ("type", "element") if one in names), None)
        if kind is None:
            raise lines.bad("column 'type' is missing")
        mine = [one for one in ("type", "element") if one in names]
        used["type"] = _once(lines, names, mine[0])
    table = lines.table(head["count"], names, used)
    out = {name: table[name] for name in (*SPEEDS, "type") if name in table}
    out["tracer"] = table["id"]
    wrapped = False
    for k, axis in enumerate(axes):
        name = next(one for one in (f"{axis}u", f"{axis}su", axis, f"{axis}s") if one in table)
        values, flag = table[name], table.get(f"i{axis}")
        if ("s" in name or flag is not None) and "length" not in head:
            raise lines.bad("a frame has no box; write xu, yu")
        if "s" in name:  # in units of the box
            values = values * head["length"][k] + head["low"][k]
        out[axis] = values if flag is None else values + flag * head["length"][k]
        wrapped = wrapped or ("u" not in name and flag is None)
    return out, wrapped


def _once(lines: _Lines, names: Sequence[str], name: str) -> int:
    if names.count(name) > 1:
        raise lines.bad(f"column {name!r} stands {names.count(name)} times")
    return names.index(name)


def _of_frames(
    where: str,
    frames: Sequence[Mapping[str, Any]],
    asked: Asked,
    units: Mapping[str, str],
    box: Any,
) -> Read:
    """Tracks of the columns of frames."""
    names = [name for name in frames[0] if all(name in frame for frame in frames)]
    columns = {name: np.concatenate([frame[name] for frame in frames]) for name in names}
    if asked.dimension == 3 and not {"z", "vz"} <= {*names}:
        raise InputError(f"{where}: has no z components; dimension 3 needs them")
    ended = np.all([np.isnan(columns[a]) for a in (*AXES, *SPEEDS) if a in columns], axis=0)
    if np.any(ended):  # tracers without any number have ended
        columns = {name: column[~ended] for name, column in columns.items()}
    found = from_columns(where, columns, asked, units)
    assert isinstance(found, Tracks)
    return replace(found, box=box)


_PAIR = re.compile(r'([A-Za-z_][\w-]*)\s*=\s*("[^"]*"|\S+)')
_XYZ = {
    **dict.fromkeys(("pos", "positions", "position"), AXES),
    **dict.fromkeys(("vel", "velo", "velocity", "velocities", "v"), SPEEDS),
    **dict.fromkeys(("id", "ids", "particle", "tracer"), ("tracer",)),
    **dict.fromkeys(("species", "type"), ("type",)),
}  # fmt: skip
"""Properties that are read, and our names of their columns."""


def _xyz(lines: _Lines, asked: Asked) -> Read:
    """Extended XYZ: frames whose second line says Properties=...:pos:R:3:vel:R:3 and Time=..."""
    frames, where = [], lines.where
    for line in lines.items():
        count = lines.whole("the number of atoms", line)
        said = {k.lower(): v.strip('"') for k, v in _PAIR.findall(lines.next() or "")}
        parts, names = said.get("properties", "").split(":"), []
        if len(parts) % 3:
            raise lines.bad("Properties= must be name:type:columns, repeated")
        for name, width in zip(parts[::3], parts[2::3], strict=True):
            axes, wide = _XYZ.get(name.lower(), ()), lines.whole(f"columns of {name!r}", width)
            if (axes and wide not in ((2, 3) if len(axes) == 3 else (1,))) or wide > 1000:
                raise lines.bad(f"{name} has {wide} columns")
            names += [*axes[:wide]] if axes else [""] * wide
        for axis, wanted in (("x", "pos:R:3"), ("vx", "vel:R:3")):
            if axis not in names:
                raise lines.bad(f"Properties= has no {wanted}; it is needed")
        if asked.type is not None and "type" not in names:
            raise lines.bad("Properties= has no species")
        chosen = [n for n in names if n and not (n == "type" and asked.type is None)]
        step = said.get("step", said.get("timestep"))
        time = said.get("time", said.get("t"))
        time = None if time is None else lines.real("a time", time)
        time = asked.times_of(where, time, None if step is None else lines.whole("a step", step))
        frame = lines.table(count, names, {name: _once(lines, names, name) for name in chosen})
        frame.setdefault("tracer", np.arange(count))
        frames.append(frame | {"time": np.full(count, time)})
    if not frames:
        raise InputError(f"{where}: is empty, or not an extended XYZ file")
    return _of_frames(where, frames, asked, {}, None)


def _gsd(path: Path, where: str, asked: Asked) -> Read:
    """Frames as HOOMD-blue writes them, in single precision, unwrapped by their image flags."""
    try:
        import gsd.hoomd
    except ImportError:
        raise InputError(
            f"{where}: to read it, the package gsd is needed: pip install gsd"
        ) from None
    asked.times_of(where, None, 0)
    with gsd.hoomd.open(str(path), "r") as file:
        frames = list(file[: MOST_TIMES + 1])
    if not frames:
        raise InputError(f"{where}: has no frames")
    d = 3 if frames[0].configuration.dimensions == 3 else 2
    boxes = np.array([frame.configuration.box for frame in frames], float)
    if np.any(boxes[:, 3:] != 0) or len({frame.particles.N for frame in frames}) > 1:
        raise InputError(f"{where}: the box must be rectangular, and each frame have all tracers")
    edges = boxes[:, None, :d]
    image, place, velocity = (
        np.array([getattr(frame.particles, name)[:, :d] for frame in frames], float)
        for name in ("image", "position", "velocity")
    )
    times = asked.times_of(where, None, [frame.configuration.step for frame in frames])
    chosen = np.ones(place.shape[1], bool)
    if asked.type is not None:
        kinds = np.asarray(frames[0].particles.types or ["A"])
        chosen = kinds[frames[0].particles.typeid] == str(asked.type)
    # image flags that are all 0 may be none: then positions may be wrapped
    free = np.any(image) or not np.all(edges > 0) or np.any(boxes != boxes[0])
    return Tracks(
        times, (place + image * edges)[:, chosen], velocity[:, chosen],
        np.flatnonzero(chosen), box=None if free else boxes[0, :d],
    )  # fmt: skip


FORMATS: dict[str, Callable[[Path, str, Asked], Read]] = {
    ".csv": _csv, ".tsv": _csv, ".npz": _npz, ".h5": _hdf5, ".hdf5": _hdf5, ".parquet": _parquet,
    ".h5md": _hdf5, ".dump": _of_lines(_lammps), ".lammpstrj": _of_lines(_lammps),
    ".xyz": _of_lines(_xyz),
    ".extxyz": _of_lines(_xyz),
    ".gsd": _gsd,
}  # fmt: skip
"""The ending of a file's name, and the function that reads it."""
