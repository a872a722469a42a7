"""HDF5: datasets `time`, `x`, ... of shape (n,) in the root of the file."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py

from kinetics.crosscheck.comparison.data.arrays import ArrayColumn, read_pieces
from kinetics.crosscheck.comparison.data.columns import Progress, Rows, find_columns, shown
from kinetics.errors import InputError


def read(path: Path, progress: Progress) -> Iterator[Rows]:
    """The rows of an HDF5 file; data that lie in other files are not followed."""
    try:
        with h5py.File(path, "r") as file:
            names = [name for name in file if _is_own_dataset(file, name)]
            found = find_columns(path, names)
            columns = {name: _column(file[names[place]]) for name, place in found.items()}
            yield from read_pieces(path, columns, progress)
    except InputError:
        raise
    except (OSError, RuntimeError, KeyError) as error:
        # h5py's own words are long and name its internals.
        raise InputError(
            f"{shown(path)}: is damaged, or not an HDF5 file ({type(error).__name__})"
        ) from None


def _is_own_dataset(file: Any, name: str) -> bool:
    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        return False
    dataset = file[name]
    return isinstance(dataset, h5py.Dataset) and not dataset.is_virtual and not dataset.external


def _column(dataset: Any) -> ArrayColumn:
    return ArrayColumn(
        dataset.dtype, dataset.shape, lambda start, count: dataset[start : start + count]
    )
