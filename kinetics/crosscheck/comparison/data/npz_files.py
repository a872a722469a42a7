"""NumPy's .npz and HDF5, in pieces: one one-dimensional array per column, all of one length.

Python objects in an .npz file are pickles, which can run code when they are loaded. They are never
loaded here, whatever the name of the array: only headers of plain numbers are accepted.
"""

import zipfile
import zlib
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import (
    LABELS,
    NUMBERS,
    PIECE,
    Progress,
    Rows,
    check_finite,
    find_columns,
    shown,
)
from kinetics.errors import InputError


def read_npz(path: Path, progress: Progress) -> Iterator[Rows]:
    """The rows of an .npz file of arrays `time`, `x`, ... of shape (n,)."""
    try:
        with ExitStack() as stack:
            archive = stack.enter_context(zipfile.ZipFile(path))
            members = [n for n in archive.namelist() if n.endswith(".npy")]
            found = find_columns(path, [m.removesuffix(".npy") for m in members])
            streams = {
                name: stack.enter_context(archive.open(members[place]))
                for name, place in found.items()
            }
            kinds, sizes = {}, {}
            for name, stream in streams.items():
                shape, kinds[name] = _npy_header(path, name, stream)
                sizes[name] = _length(path, name, shape)
            total = _common(path, sizes)

            def piece(name: str, count: int) -> Any:
                wanted = count * kinds[name].itemsize
                data = streams[name].read(wanted)
                if len(data) != wanted:
                    raise InputError(f"{shown(path)}: is cut off within {name!r}")
                return np.frombuffer(data, kinds[name])

            yield from _pieces(path, found, total, piece, progress)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise InputError(
            f"{shown(path)}: is damaged, or not an .npz file ({type(error).__name__})"
        ) from None


def _npy_header(path: Path, name: str, stream: Any) -> tuple[tuple[int, ...], np.dtype[Any]]:
    try:
        version = np.lib.format.read_magic(stream)
        read = np.lib.format.read_array_header_1_0
        if version != (1, 0):
            read = np.lib.format.read_array_header_2_0
        shape, _, dtype = read(stream)
    except ValueError:
        raise InputError(f"{shown(path)}: array {name!r} is damaged") from None
    if dtype.hasobject:
        raise InputError(
            f"{shown(path)}: array {name!r} holds Python objects, which are never loaded; "
            "save it as plain numbers"
        )
    _check_kind(path, name, dtype)
    return shape, dtype


def read_h5(path: Path, progress: Progress) -> Iterator[Rows]:
    """The rows of an HDF5 file of datasets `time`, `x`, ... of shape (n,) in its root."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            names = [n for n in file if isinstance(file.get(n, getlink=False), h5py.Dataset)]
            found = find_columns(path, names)
            sets = {name: file[names[place]] for name, place in found.items()}
            for name, dataset in sets.items():
                _check_kind(path, name, dataset.dtype)
            total = _common(path, {k: _length(path, k, d.shape) for k, d in sets.items()})
            done = dict.fromkeys(sets, 0)

            def piece(name: str, count: int) -> Any:
                start = done[name]
                done[name] += count
                return sets[name][start : start + count]

            yield from _pieces(path, found, total, piece, progress)
    except InputError:
        raise
    except (OSError, RuntimeError, KeyError) as error:
        # h5py's own words are long and name its internals.
        raise InputError(
            f"{shown(path)}: is damaged, or not an HDF5 file ({type(error).__name__})"
        ) from None


def _check_kind(path: Path, name: str, dtype: np.dtype[Any]) -> None:
    allowed = "iu" if name in LABELS else "iuf"
    # Whole numbers as floats, as np.loadtxt gives them, are labels too.
    if dtype.kind not in (allowed + "f" if name in LABELS else allowed) or dtype.itemsize > 8:
        raise InputError(
            f"{shown(path)}: array {name!r} is of type {dtype}; it must hold "
            f"{'whole numbers' if name in LABELS else 'real numbers'} of at most 64 bits"
        )


def _length(path: Path, name: str, shape: tuple[int, ...] | None) -> int:
    if shape is None or len(shape) != 1:
        raise InputError(f"{shown(path)}: array {name!r} has shape {shape}; it must be (n,)")
    return shape[0]


def _common(path: Path, sizes: dict[str, int]) -> int:
    if len(set(sizes.values())) != 1:
        text = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise InputError(f"{shown(path)}: columns differ in length ({text})")
    return sizes["time"]


def _pieces(
    path: Path, found: dict[str, int], total: int, piece: Any, progress: Progress
) -> Iterator[Rows]:
    for start in range(0, total, PIECE):
        count = min(PIECE, total - start)
        numbers = [np.asarray(piece(name, count), float) for name in NUMBERS]
        labels = {name: _labels(path, name, piece(name, count)) for name in LABELS if name in found}
        rows = Rows(*numbers, **labels)
        check_finite(path, rows, start)
        yield rows
        progress((start + count) / total)


def _labels(path: Path, name: str, values: Any) -> Any:
    if values.dtype.kind == "f":
        if not np.all(np.isfinite(values)) or np.any(values != np.rint(values)):
            raise InputError(f"{shown(path)}: {name!r} must be whole numbers, without NaN")
        if np.any(np.abs(values) >= 2.0**63):
            raise InputError(f"{shown(path)}: {name!r} must be below 2^63")
    with np.errstate(over="ignore"):
        return values.astype(np.int64)
