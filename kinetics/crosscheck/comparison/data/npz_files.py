"""NumPy's .npz: arrays `time`, `x`, ... of shape (n,), compressed or not.

The arrays are unpacked piece by piece (np.load would hold each as a whole, also where a memory map
is asked for). Python objects are pickles, which can run code when they are loaded. They are never
loaded here, whatever the name of the array: only NumPy's headers of plain numbers are accepted.
"""

import zipfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.arrays import FRAMES, read_frames, read_pieces
from kinetics.crosscheck.comparison.data.columns import (
    Asked,
    Averages,
    Rows,
    find_columns,
    shown,
    split_unit,
)
from kinetics.errors import InputError


def read(path: Path, asked: Asked) -> Iterator[Rows | Averages]:
    """The rows of an .npz file."""
    with ExitStack() as stack:
        archive = stack.enter_context(zipfile.ZipFile(path))
        members = [n for n in archive.namelist() if n.endswith(".npy")]
        if {f"{name}.npy" for name in FRAMES} <= set(members):
            yield from read_frames(path, {n: _opened(path, archive, stack, n) for n in FRAMES})
            return
        found = find_columns(path, [m.removesuffix(".npy") for m in members], asked)
        names = {name: members[place].removesuffix(".npy") for name, place in found.items()}
        columns = {name: _opened(path, archive, stack, own) for name, own in names.items()}
        units = {name: split_unit(own)[1] for name, own in names.items()}
        yield from read_pieces(path, columns, units)


def _opened(path: Path, archive: zipfile.ZipFile, stack: ExitStack, name: str) -> "_Array":
    stream = stack.enter_context(archive.open(f"{name}.npy"))
    return _Array(f"{shown(path)}: array {name!r}", stream)


class _Array:
    """An array in the archive, whose parts are read one after another."""

    def __init__(self, where: str, stream: Any) -> None:
        self._where, self._stream = where, stream
        try:
            first = np.lib.format.read_magic(stream) == (1, 0)
            header = np.lib.format.read_array_header_1_0
            read_header = header if first else np.lib.format.read_array_header_2_0
            self.shape, by_columns, self.dtype = read_header(stream)
        except Exception:  # NumPy's parser of headers raises nearly any error on a crafted one
            raise InputError(f"{where} is damaged") from None
        if by_columns and len(self.shape) > 1:
            raise InputError(f"{where} is in Fortran's order; save numpy.ascontiguousarray of it")

    def __getitem__(self, part: slice | tuple[int, slice]) -> Any:
        """The next rows, or the next of a frame: `part` only says how many."""
        if isinstance(part, tuple):
            rest = self.shape[2:]
            count = (part[1].stop - part[1].start) * int(np.prod(rest))
            return self._next(count).reshape(-1, *rest)
        start, stop = part.start or 0, self.shape[0] if part.stop is None else part.stop
        return self._next(min(stop, self.shape[0]) - start)

    def _next(self, count: int) -> Any:
        wanted = count * self.dtype.itemsize
        data = self._stream.read(wanted)
        if len(data) != wanted:
            raise InputError(f"{self._where} is cut off")
        return np.frombuffer(data, self.dtype)
