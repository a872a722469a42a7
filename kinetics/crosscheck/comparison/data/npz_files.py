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

from kinetics.crosscheck.comparison.data.arrays import read_pieces
from kinetics.crosscheck.comparison.data.columns import Asked, Rows, find_columns, shown
from kinetics.errors import InputError


def read(path: Path, asked: Asked) -> Iterator[Rows]:
    """The rows of an .npz file."""
    with ExitStack() as stack:
        archive = stack.enter_context(zipfile.ZipFile(path))
        members = [n for n in archive.namelist() if n.endswith(".npy")]
        found = find_columns(path, [m.removesuffix(".npy") for m in members], asked)
        columns = {
            name: _Array(
                f"{shown(path)}: array {name!r}", stack.enter_context(archive.open(members[place]))
            )
            for name, place in found.items()
        }
        yield from read_pieces(path, columns)


class _Array:
    """An array in the archive, whose parts are read one after another."""

    def __init__(self, where: str, stream: Any) -> None:
        self._where, self._stream = where, stream
        try:
            first = np.lib.format.read_magic(stream) == (1, 0)
            header = np.lib.format.read_array_header_1_0
            read_header = header if first else np.lib.format.read_array_header_2_0
            self.shape, _, self.dtype = read_header(stream)
        except Exception:  # NumPy's parser of headers raises nearly any error on a crafted one
            raise InputError(f"{where} is damaged") from None

    def __getitem__(self, part: slice) -> Any:
        wanted = (min(part.stop, self.shape[0]) - part.start) * self.dtype.itemsize
        data = self._stream.read(wanted)
        if len(data) != wanted:
            raise InputError(f"{self._where} is cut off")
        return np.frombuffer(data, self.dtype)
