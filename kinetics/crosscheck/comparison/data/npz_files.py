"""NumPy's .npz: arrays `time`, `x`, ... of shape (n,), compressed or not.

The arrays are unpacked piece by piece (np.load would hold each as a whole, also where a memory map
is asked for). Python objects are pickles, which can run code when they are loaded. They are never
loaded here, whatever the name of the array: only NumPy's headers of plain numbers are accepted.
"""

import zipfile
import zlib
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.arrays import ArrayColumn, read_pieces
from kinetics.crosscheck.comparison.data.columns import Progress, Rows, find_columns, shown
from kinetics.errors import InputError


def read(path: Path, progress: Progress) -> Iterator[Rows]:
    """The rows of an .npz file."""
    try:
        with ExitStack() as stack:
            archive = stack.enter_context(zipfile.ZipFile(path))
            members = [n for n in archive.namelist() if n.endswith(".npy")]
            found = find_columns(path, [m.removesuffix(".npy") for m in members])
            columns = {
                name: _column(path, name, stack.enter_context(archive.open(members[place])))
                for name, place in found.items()
            }
            yield from read_pieces(path, columns, progress)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise InputError(
            f"{shown(path)}: is damaged, or not an .npz file ({type(error).__name__})"
        ) from None


def _column(path: Path, name: str, stream: Any) -> ArrayColumn:
    try:
        version = np.lib.format.read_magic(stream)
        read_header = np.lib.format.read_array_header_1_0
        if version != (1, 0):
            read_header = np.lib.format.read_array_header_2_0
        shape, _, dtype = read_header(stream)
    except Exception:  # NumPy's parser of headers raises nearly any error on a crafted one
        raise InputError(f"{shown(path)}: array {name!r} is damaged") from None

    def part(start: int, count: int) -> Any:
        wanted = count * dtype.itemsize
        data = stream.read(wanted)
        if len(data) != wanted:
            raise InputError(f"{shown(path)}: is cut off within {name!r}")
        return np.frombuffer(data, dtype)

    return ArrayColumn(dtype, shape, part)
