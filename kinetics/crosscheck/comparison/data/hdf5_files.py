"""HDF5: datasets `time`, `x`, ... of shape (n,) in the root of the file, or H5MD."""

from collections.abc import Iterator
from pathlib import Path

import h5py

from kinetics.crosscheck.comparison.data.arrays import FRAMES, read_frames, read_pieces
from kinetics.crosscheck.comparison.data.columns import Asked, Averages, Rows, find_columns
from kinetics.crosscheck.comparison.data.h5md_files import (
    is_h5md,
    is_own_array,
    read_file,
    unit_of,
)


def read(path: Path, asked: Asked) -> Iterator[Rows | Averages]:
    """The rows of an HDF5 file; data that lie in other files are not followed."""
    with h5py.File(path, "r") as file:
        if is_h5md(file):
            yield from read_file(path, file, asked)
            return
        names = [name for name in file if is_own_array(file, name)]
        if set(FRAMES) <= set(names):
            yield from read_frames(path, {name: file[name] for name in FRAMES})
            return
        found = find_columns(path, names, asked)
        columns = {name: file[names[place]] for name, place in found.items()}
        units = {name: unit_of(column) for name, column in columns.items()}
        yield from read_pieces(path, columns, units)
