"""Files of arrays: NumPy, MATLAB, Parquet and HDF5. Nothing in them is executed."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.data.columns import LABELS, find_columns
from kinetics.crosscheck.data.memory import require_memory
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.crosscheck.data.table import (
    Table,
    needed_columns,
    table_of_arrays,
    table_of_columns,
)

#: Names of arrays of frames: times (T,), positions and velocities (T, n, d), if there are any.
TIMES = "times"
POSITIONS = "positions"
VELOCITIES = "velocities"


def table_of_mapping(where: str, arrays: Mapping[str, Any], options: DataOptions) -> Table:
    """Return the table of columns of one length, or of arrays of frames, by their names."""
    if not {TIMES, POSITIONS} <= set(arrays):
        return table_of_columns(where, arrays, options)
    labels = {name: arrays[name] for name in LABELS if name in arrays}
    velocities = arrays.get(VELOCITIES)
    return table_of_arrays(where, options, arrays[TIMES], arrays[POSITIONS], velocities, **labels)


def _names_read(where: str, names: Sequence[str], options: DataOptions) -> list[str]:
    """Return the names of those arrays that are read."""
    if {TIMES, POSITIONS} <= set(names):
        return [name for name in (TIMES, POSITIONS, VELOCITIES, *LABELS) if name in names]
    columns = find_columns(where, names, options.columns, needed_columns(options))
    return [column.original for column in columns.values()]


def read_npz(path: Path, where: str, options: DataOptions) -> Table:
    """Read arrays of numbers; Python objects are pickles, which can run code: none is loaded."""
    with zipfile.ZipFile(path) as archive:
        entries = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}
    chosen = _names_read(where, list(entries), options)
    for name in chosen:
        entry = entries[name]
        require_memory(where, float(entry.file_size), float(entry.compress_size))
    if TIMES in chosen and entries[POSITIONS].file_size < entries[TIMES].file_size:
        refuse_data(where, "more times than positions", "times (T,), positions (T, n, d)")
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in chosen}
    return table_of_mapping(where, arrays, options)


def read_matlab(path: Path, where: str, options: DataOptions) -> Table:
    """Read the arrays of a MATLAB file; those of version 7.3 are HDF5."""
    import h5py
    from scipy.io import loadmat, whosmat

    if h5py.is_hdf5(path):
        return _read_matlab_hdf5(path, where, options)
    shapes = {name: shape for name, shape, _ in whosmat(path)}
    chosen = _names_read(where, list(shapes), options)
    for name in chosen:
        require_memory(where, 8.0 * float(np.prod(shapes[name])))
    arrays = loadmat(path, variable_names=chosen)
    return table_of_mapping(where, {name: _vector(arrays[name]) for name in chosen}, options)


def _vector(array: NDArray[Any]) -> NDArray[Any]:
    """Return a row or a column of MATLAB, where all arrays are matrices, as a vector."""
    return array.ravel() if array.ndim == 2 and 1 in array.shape else array


def _read_matlab_hdf5(path: Path, where: str, options: DataOptions) -> Table:
    """Read a MATLAB file of version 7.3, whose arrays are transposed."""
    import h5py

    with h5py.File(path, "r") as file:
        chosen = _names_read(where, dataset_names(file), options)
        arrays = {name: _vector(numbers_of(where, file, name).T) for name in chosen}
    return table_of_mapping(where, arrays, options)


def read_parquet(path: Path, where: str, options: DataOptions) -> Table:
    """Read columns of a Parquet file, with the package pyarrow."""
    try:
        from pyarrow import parquet
    except ImportError:
        refuse_data(where, "a file of another package", "installed: pip install pyarrow")
    with parquet.ParquetFile(path) as file:
        chosen = _names_read(where, file.schema_arrow.names, options)
        require_memory(where, 8.0 * file.metadata.num_rows * len(chosen))
        table = file.read(chosen)
    columns = {name: table.column(name).to_pandas() for name in chosen}
    return table_of_mapping(where, columns, options)


# -- HDF5 ------------------------------------------------------------------------------------------


def read_hdf5_arrays(file: Any, where: str, options: DataOptions) -> Table:
    """Read the arrays of an open HDF5 file, netCDF-4 among them."""
    chosen = _names_read(where, dataset_names(file), options)
    arrays = {name: numbers_of(where, file, name) for name in chosen}
    return table_of_mapping(where, arrays, options)


def dataset_names(parent: Any) -> list[str]:
    """Return the names of the datasets that lie in a group of the same file."""
    import h5py

    return [name for name in parent if isinstance(member_of(parent, name), h5py.Dataset)]


def member_of(parent: Any, name: str) -> Any:
    """Return a member of a group that lies in the same file; None for other links, or none."""
    import h5py

    if not isinstance(parent.get(name, getlink=True), h5py.HardLink):
        return None
    return parent[name]


def numbers_of(where: str, parent: Any, name: str) -> NDArray[Any]:
    """Return the numbers of a dataset, or of the `value` of an element of H5MD; or InputError.

    What netCDF says is missing is masked. Sizes are checked before memory is asked for.
    """
    import h5py

    member = member_of(parent, name)
    dataset = member_of(member, "value") if isinstance(member, h5py.Group) else member
    is_here = isinstance(dataset, h5py.Dataset) and not (dataset.is_virtual or dataset.external)
    if not is_here or dataset.dtype.kind not in "iuf":
        refuse_data(f"{where}: {name} value", "something else", "numbers in this file")
    size = float(dataset.size or 0) * dataset.dtype.itemsize
    require_memory(where, size, dataset.id.get_storage_size())
    values = dataset[()]
    missing = np.zeros(np.shape(values), bool)
    for attribute in ("_FillValue", "missing_value"):
        for marker in np.ravel(dataset.attrs.get(attribute, ())):
            missing |= values == marker
    if dataset.fillvalue:  # that of HDF5 itself is 0, and netCDF's own is 1e37
        missing |= values == dataset.fillvalue
    return np.ma.array(values, mask=missing) if np.any(missing) else values
