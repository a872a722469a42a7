"""Files of particle data: a format is one function and one row of `FORMATS`, at the end.

It is given the path, its name for messages and what was asked (`tracks.Asked`), and returns `Rows`,
or an Ensemble. Nothing in a file is executed, links into other files are not
followed, and sizes are checked before memory is asked for.
"""

import gzip
import re
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.data import tracks
from kinetics.crosscheck.data.tracks import AXES, SPEEDS, Asked, Rows, bad, require_memory
from kinetics.errors import InputError, short

FRAMES = ("times", "positions", "velocities")  # (n_times,) and twice (n_times, n, dimension)
# bytes of a CSV file that are parsed at once, and of a line at most: memory stays small
_BLOCK, _LONGEST = 8 << 20, 1 << 20


def read(source: Path | Mapping[str, Any], asked: Asked) -> Any:
    """Rows or an Ensemble, from a file or from columns; or InputError."""
    where = tracks.name_of(source)
    try:
        if not isinstance(source, Path):
            return _arrays(where, source, asked)
        ending = source.suffix.lower()
        if source.name.lower().endswith((".csv.gz", ".tsv.gz")):
            ending = ".csv"
        if ending not in FORMATS:
            bad(where, f"ending {ending!r}", f"a file {', '.join(FORMATS)} or .csv.gz")
        if not source.is_file():
            bad(where, "not a file" if source.exists() else "no such file", "a file")
        return FORMATS[ending](source, where, asked)
    except InputError:
        raise
    except Exception as error:  # the libraries raise errors of nearly any class
        why = getattr(error, "strerror", None) or short(str(error), 200)
        raise InputError(f"{where}: is damaged, or not of this format ({why})") from None


def _arrays(where: str, arrays: Mapping[str, Any], asked: Asked) -> Rows:
    """Columns of one length, or arrays of frames, by the names of the file."""
    if {*FRAMES} <= {*arrays}:
        labels = {name: arrays[name] for name in tracks.LABELS if name in arrays}
        return tracks.rows_of_arrays(where, asked, *(arrays[name] for name in FRAMES), **labels)
    return tracks.rows_of(where, arrays, asked)


def _chosen(where: str, names: Sequence[str], asked: Asked) -> list[str]:
    """The names of those arrays that are read."""
    if {*FRAMES} <= {*names}:
        return [name for name in (*FRAMES, *tracks.LABELS) if name in names]
    return [*tracks.find_columns(where, names, asked).values()]


def _csv(path: Path, where: str, asked: Asked) -> Rows:
    """Commas, semicolons or tabs, as the first line has them; blank lines and # are passed over."""
    import pyarrow as pa
    from pyarrow import csv as arrow

    packed, lines = path.suffix.lower() == ".gz", 0
    with gzip.open(path) if packed else open(path, "rb") as file:
        for raw in iter(lambda: file.readline(_LONGEST), b""):
            lines += 1
            text = raw.decode("utf-8-sig").strip()
            header = text.lstrip("#").strip()
            words = re.split(r"[\s,;\"']+", header.lower())
            # numpy.savetxt writes the names behind a #
            if header and (text[0] != "#" or "time" in words or ("t" in words and len(words) > 4)):
                break
        else:
            bad(where, "an empty file", "a first line that names the columns, and rows")
    names = header.split(separator := max(",;\t", key=header.count))
    found = tracks.find_columns(where, names, asked)
    require_memory(where, 0.3 * path.stat().st_size)  # 17 digits and a comma are 8 bytes
    read = arrow.ReadOptions(column_names=names, block_size=_BLOCK, skip_rows=lines)

    def blank(row: Any) -> str:
        return "skip" if row.text.strip()[:1] in ("", "#") else "error"

    parse = arrow.ParseOptions(delimiter=separator, invalid_row_handler=blank)
    kinds = {x: pa.float64() for name, x in found.items() if name not in tracks.LABELS}
    told = {"column_types": kinds, "include_columns": list(found.values()), "null_values": []}
    # not Python's file: a thread of pyarrow that still reads one may abort a process that ends
    source = pa.CompressedInputStream(pa.OSFile(str(path)), "gzip") if packed else str(path)
    try:
        batches, convert = [], arrow.ConvertOptions(**told)
        with arrow.open_csv(source, read, parse, convert) as reader:
            for batch in reader:
                batches.append(batch)
                require_memory(where, float(batch.nbytes * len(batches)))
            table = pa.Table.from_batches(batches, reader.schema)
    except pa.ArrowInvalid as error:
        why = " ".join(str(error).split())
        bad(where, short(why, 150), "rows of numbers with a decimal point, one for each column")
    columns = {x: table.column(x).to_numpy() for x in found.values()}
    return tracks.rows_of(where, columns, asked)


def _parquet(path: Path, where: str, asked: Asked) -> Rows:
    from pyarrow import parquet

    with parquet.ParquetFile(path) as file:
        names = file.schema_arrow.names
        chosen = _chosen(where, names, asked)
        require_memory(where, 8.0 * file.metadata.num_rows * len(chosen))
        table = file.read(chosen)
    return _arrays(where, {name: table.column(name).to_numpy() for name in chosen}, asked)


def _npz(path: Path, where: str, asked: Asked) -> Rows:
    """Arrays of numbers; Python objects are pickles, which can run code, and are never loaded."""
    with zipfile.ZipFile(path) as archive:
        sizes = {one.filename.removesuffix(".npy"): one for one in archive.infolist()}
    chosen = _chosen(where, list(sizes), asked)
    for name in chosen:
        require_memory(where, float(sizes[name].file_size), float(sizes[name].compress_size))
    if "times" in chosen and sizes["positions"].file_size < sizes["times"].file_size:
        bad(where, "more times than positions", "times (T,), positions (T, n, d)")
    with np.load(path, allow_pickle=False) as file:
        return _arrays(where, {name: file[name] for name in sizes if name in chosen}, asked)


# -- HDF5 ------------------------------------------------------------------------------------------
def _hdf5(path: Path, where: str, asked: Asked) -> Any:
    import h5py

    with h5py.File(path, "r") as file:
        if "plan" in file and "done" in file.attrs:
            from particles import Ensemble

            return Ensemble.load(path)
        if _own(file, "h5md") and (particles := _own(file, "particles")):
            return _h5md(where, particles, asked)
        chosen = _chosen(where, [name for name in file if _own(file, name, "Dataset")], asked)
        return _arrays(where, {k: _values(_dataset(where, file, k)) for k in chosen}, asked)


def _own(parent: Any, name: str, kind: str = "Group") -> Any:
    """A member of this kind that lies in the same file, or None: other links are not followed."""
    import h5py

    found = parent[name] if isinstance(parent.get(name, getlink=True), h5py.HardLink) else None
    return found if isinstance(found, getattr(h5py, kind)) else None


def _dataset(where: str, parent: Any, name: str) -> Any:
    """A dataset of numbers that lie in this file, or the `value` of an element; or InputError."""
    element = _own(parent, name)
    found = _own(element, "value", "Dataset") if element else _own(parent, name, "Dataset")
    if found is None or found.is_virtual or found.external or found.dtype.kind not in "iuf":
        bad(f"{where}: {name} value", "something else", "numbers in this file")
    size = float(found.size or 0) * found.dtype.itemsize
    require_memory(where, size, found.id.get_storage_size())
    return found


def _values(dataset: Any) -> Any:
    """Return the numbers of a dataset, masked where netCDF says that they are missing."""
    values = dataset[()]
    missing = np.zeros(values.shape, bool)
    for name in ("_FillValue", "missing_value"):
        for marker in np.ravel(dataset.attrs.get(name, ())):
            missing |= values == marker
    if dataset.fillvalue:  # that of HDF5 itself is 0, and netCDF's own is 1e37
        missing |= values == dataset.fillvalue
    return np.ma.array(values, mask=missing) if np.any(missing) else values


def _h5md(where: str, particles: Any, asked: Asked) -> Rows:
    """The only group of particles with positions, unwrapped by `image` where it stands, and
    velocities (nongnu.org/h5md); this package also writes `medium`, each tracer's configuration.
    """
    both = ("position", "velocity")
    groups = [group for name in particles if (group := _own(particles, name))]
    groups = [group for group in groups if all(_own(group, part) for part in both)]
    if len(groups) != 1:
        bad(where, f"{len(groups)} groups with position and velocity", "one")
    (group,) = groups
    place, velocity = (_dataset(where, group, name) for name in both)
    times, others = (
        asked.times_of(where, *(
            np.asarray(_dataset(where, group[name], part), float) if part in group[name] else None
            for part in ("time", "step")
        )) for name in both
    )  # fmt: skip
    if not np.array_equal(times, others):
        bad(where, "positions and velocities at different times", "at the same times")
    r = tracks.without_mask(_values(place)).astype(float)
    box, side = _own(group, "box"), np.zeros(1)
    if box and "edges" in box:  # rectangular, and always the same
        edges = np.atleast_2d(np.asarray(_dataset(where, box, "edges"), float))
        side = edges[0] if edges.size and np.all(edges == edges[0]) else side
    if "image" in group:
        image, axes = _dataset(where, group, "image"), r.shape[-1]
        if image.shape != r.shape or side.size < axes or not np.all(side > 0):
            bad(f"{where}: image", image.shape, f"{r.shape}, with a box that is always the same")
        r = r + image * side[:axes]
    elif box and "periodic" in str(box.attrs.get("boundary", "")):
        bad(f"{where}: positions", "those in a periodic box", "unwrapped, or with image")
    ours = {"id": "tracer", "medium": "medium", "species": "type"}
    labels = {ours[name]: _values(_dataset(where, group, name)) for name in ours if name in group}
    return tracks.rows_of_arrays(where, asked, times, r, _values(velocity), **labels)


# -- frames of text --------------------------------------------------------------------------------
class _Lines:
    """The lines of a text file, one after another; `where` names the file and the last line."""

    def __init__(self, path: Path, where: str) -> None:
        require_memory(where, 0.5 * path.stat().st_size)
        self._file, self._name, self._number = open(path, errors="replace"), where, 0  # noqa: SIM115

    @property
    def where(self) -> str:
        return f"{self._name}: line {self._number}"

    def next(self) -> str:
        """The next line; empty at the end of the file."""
        self._number += 1
        return self._file.readline(_LONGEST)

    def __iter__(self) -> Iterator[str]:
        """The lines from here on that are not blank, to the end of the file."""
        with self._file:
            while line := self.next():
                if line.strip():
                    yield line.strip()

    def number(self, text: str, whole: bool = True) -> Any:
        """The finite number that a text is, or the whole one, not negative; or InputError."""
        with suppress(ValueError):
            value = int(text) if whole and text.strip().isdecimal() else float(text)
            if np.isfinite(value) and whole == isinstance(value, int):
                return value
        bad(self.where, short(text.strip()), "a whole number" if whole else "a finite number")

    def table(self, count: int, names: list[str], wanted: Sequence[str]) -> dict[str, Any]:
        """Columns of the next `count` lines, (count,) each, numbers except the type."""
        for name in (name for name in wanted if names.count(name) != 1):
            bad(self.where, f"column {name!r} {names.count(name)} times", "once")
        rows, first = list(islice(self._file, count)), self._number + 1
        self._number += len(rows)
        kinds = [(name, "U64" if name == "type" else float) for name in wanted]
        used, why = [names.index(name) for name in wanted], f"{len(rows)} lines, some blank"
        try:
            found = np.empty(0, kinds)
            if rows:
                found = np.loadtxt(rows, kinds, None, usecols=used, ndmin=1)
            if found.size == count:
                return {name: found[name] for name in wanted}
        except ValueError as error:
            why = short(str(error), 150)
        bad(f"{self._name}: from line {first} on", why, f"{count} rows of numbers")


def _lammps(path: Path, where: str, asked: Asked) -> Rows:
    """A text dump with id, vx, vy and xu, yu, or x, y with or without image flags ix, iy."""
    frames, head, lines = list[Any](), dict[str, Any](), _Lines(path, where)
    axes, kind = AXES[: asked.dimension or 2], [] if asked.type is None else ["type"]
    for line in lines:
        item, *names = line.removeprefix("ITEM: ").split()
        if not line.startswith("ITEM: "):
            bad(lines.where, short(line), "a line `ITEM: ...` of a LAMMPS text dump")
        if item in ("TIMESTEP", "TIME", "NUMBER"):
            head[item] = lines.number(lines.next(), whole=item != "TIME")
        elif item == "UNITS":
            lines.next()
        elif item == "BOX":
            edges = [lines.next().split() for _ in range(3)]
            if any(len(edge) != 2 for edge in edges):
                bad(lines.where, "a slanted box", "rectangular, with two bounds a line")
            head["sides"] = np.diff(np.array(edges, float))[:, 0]
            head["periodic"] = [a for a, b in zip("xyz", names[1:], strict=False) if b == "pp"]
        elif item == "ATOMS":
            wrapped = [a for a in axes if a in names and f"{a}u" not in names]
            flags = {a: f"i{a}" for a in wrapped if f"i{a}" in names}
            if {*wrapped} & {*head.get("periodic", ())} - {*flags}:
                must = "unwrapped, or with image flags ix, iy"
                bad(f"{lines.where}: positions", "those in a periodic box", must)
            speeds = [v for v in SPEEDS if v in names or v[1] in axes]
            places = [a if a in wrapped else f"{a}u" for a in axes]
            wanted = ["id", *speeds, *places, *flags.values(), *kind]
            table = lines.table(head["NUMBER"], names, wanted)
            time = asked.times_of(where, head.get("TIME"), head.get("TIMESTEP"))
            frame = {name: table[name] for name in (*speeds, *kind)} | {"tracer": table["id"]}
            frame["time"] = np.full(head["NUMBER"], time)
            for axis, place, side in zip(axes, places, head.get("sides", AXES), strict=False):
                frame[axis] = table[place]
                if axis in flags:
                    frame[axis] = frame[axis] + side * table[flags[axis]]
            frames.append(frame)
            head = {}
    if head:
        bad(where, "a last frame without atoms", "whole frames")
    return tracks.rows_of_frames(where, frames, asked)


_PAIR = re.compile(r'([A-Za-z_][\w-]*)\s*=\s*("[^"]*"|\S+)')
_XYZ = {  # properties that are read, and our names of their columns
    **dict.fromkeys(("pos", "positions", "position"), AXES),
    **dict.fromkeys(("vel", "velo", "velocity", "velocities", "v"), SPEEDS),
    **dict.fromkeys(("id", "ids", "particle", "tracer"), ("tracer",)),
    **dict.fromkeys(("species", "type"), ("type",)),
}  # fmt: skip


def _xyz(path: Path, where: str, asked: Asked) -> Rows:
    """Extended XYZ: frames whose second line says Properties=...:pos:R:3:vel:R:3 and Time=..."""
    frames, d, lines = [], asked.dimension or 2, _Lines(path, where)
    needed = [*AXES[:d], *SPEEDS[:d], *(["type"] if asked.type is not None else [])]
    for line in lines:
        count = lines.number(line)
        said = {k.lower(): v.strip('"') for k, v in _PAIR.findall(lines.next())}
        parts, names = said.get("properties", "").split(":"), list[str]()
        for name, width in zip(parts[::3], parts[2::3], strict=False):
            axes, wide = _XYZ.get(name.lower(), ()), lines.number(width)
            if (axes and not min(2, len(axes)) <= wide <= len(axes)) or wide > 1000:
                bad(lines.where, f"{name} has {wide} columns", "pos:R:3:vel:R:3 in Properties=")
            names += axes[:wide] or [""] * wide
        step, time = said.get("step", said.get("timestep")), said.get("time", said.get("t"))
        time = None if time is None else lines.number(time, whole=False)
        time = asked.times_of(where, time, None if step is None else lines.number(step))
        wanted = [*needed, *(v for v in ("tracer", "vz") if v in names and v not in needed)]
        frame = {"tracer": np.arange(count)} | lines.table(count, names, wanted)
        frames.append(frame | {"time": np.full(count, time)})
    return tracks.rows_of_frames(where, frames, asked)


def _gsd(path: Path, where: str, asked: Asked) -> Rows:
    """Frames as HOOMD-blue writes them, in single precision, unwrapped by their image flags."""
    try:
        import gsd.hoomd
    except ImportError:
        bad(where, "a file of another package", "installed: pip install gsd")
    with gsd.hoomd.open(str(path), "r") as file:
        frames = list(file[: tracks.MOST_TIMES + 1])
    d = 3 if frames and frames[0].configuration.dimensions == 3 else 2
    boxes = np.array([frame.configuration.box for frame in frames], float)
    if len({frame.particles.N for frame in frames}) != 1 or np.any(boxes[:, 3:] != 0):
        bad(where, "others", "frames of the same tracers in a rectangular box")
    image, place, velocity = (
        np.array([getattr(frame.particles, name)[:, :d] for frame in frames], float)
        for name in ("image", "position", "velocity")
    )
    place = place + image * boxes[:, None, :d]
    times = asked.times_of(where, None, [frame.configuration.step for frame in frames])
    kinds = np.asarray(frames[0].particles.types or ["A"])[frames[0].particles.typeid]
    return tracks.rows_of_arrays(where, asked, times, place, velocity, type=kinds)


# the ending of a file's name, and the function that reads it
FORMATS: dict[str, Callable[[Path, str, Asked], Any]] = {
    ".csv": _csv, ".tsv": _csv, ".npz": _npz, ".parquet": _parquet,
    **dict.fromkeys((".h5", ".hdf5", ".h5md"), _hdf5),
    **dict.fromkeys((".dump", ".lammpstrj"), _lammps),
    **dict.fromkeys((".xyz", ".extxyz"), _xyz), ".gsd": _gsd,
}  # fmt: skip
