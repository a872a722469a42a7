"""Files of arrays: NumPy, MATLAB, Parquet and HDF5. Nothing in them is executed."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kinetics.crosscheck.data.arrays import Column, NamedArrays
from kinetics.crosscheck.data.columns import LABELS, find_columns, present
from kinetics.crosscheck.data.memory import (
    MAX_COMPRESSION,
    MemoryBudget,
    bytes_of_numbers,
    require_memory,
)
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.crosscheck.data.table import (
    Table,
    needed_columns,
    table_of_arrays,
    table_of_columns,
)

if TYPE_CHECKING:
    import h5py
    import pyarrow
    from pyarrow import parquet

#: Name of the array of the times of frames, shape (T,).
TIMES = "times"
#: Name of the array of positions, shape (T, n, d).
POSITIONS = "positions"
#: Name of the array of velocities, shape (T, n, d), if there are any.
VELOCITIES = "velocities"
#: Classes of arrays of MATLAB whose size their shape says.
MATLAB_NUMBERS = frozenset(
    [
        "double",
        "single",
        "logical",
        "char",
        "int8",
        "int16",
        "int32",
        "int64",
        "uint8",
        "uint16",
        "uint32",
        "uint64",
    ]
)
#: Rows of a Parquet file that are read at once, so that memory can be checked meanwhile.
ROWS_AT_ONCE = 100_000


def table_of_mapping(where: str, arrays: NamedArrays, options: DataOptions) -> Table:
    """Return the table of columns of one length, or of arrays of frames, by their names."""
    if not {TIMES, POSITIONS} <= set(arrays):
        return table_of_columns(where, arrays, options)
    labels = {name: arrays[name] for name in present(LABELS, arrays)}
    velocities = arrays.get(VELOCITIES)
    return table_of_arrays(where, options, arrays[TIMES], arrays[POSITIONS], velocities, labels)


def _names_read(where: str, names: Sequence[str], options: DataOptions) -> list[str]:
    """Return the names of those arrays that are read."""
    if {TIMES, POSITIONS} <= set(names):
        return present((TIMES, POSITIONS, VELOCITIES, *LABELS), names)
    columns = find_columns(where, names, options.columns, needed_columns(options))
    return [column.original for column in columns.values()]


def read_npz(path: Path, where: str, options: DataOptions) -> Table:
    """Read arrays of numbers; Python objects are pickles, which can run code: none is loaded."""
    with zipfile.ZipFile(path) as archive:
        entries: dict[str, zipfile.ZipInfo] = {}
        for entry in archive.infolist():
            entries[entry.filename.removesuffix(".npy")] = entry
    chosen = _names_read(where, list(entries), options)
    budget = MemoryBudget(where)
    for name in chosen:
        entry = entries[name]
        require_memory(where, float(entry.file_size), float(entry.compress_size))
        budget.take(_bytes_of_entry(path, where, entry))
    if TIMES in chosen and entries[POSITIONS].file_size < entries[TIMES].file_size:
        refuse_data(where, "more times than positions", "times (T,), positions (T, n, d)")
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in chosen}
    return table_of_mapping(where, arrays, options)


def _bytes_of_entry(path: Path, where: str, entry: zipfile.ZipInfo) -> float:
    """Return the bytes of memory that an array needs; InputError if its head declares too many."""
    with zipfile.ZipFile(path) as archive, archive.open(entry) as file:
        version = np.lib.format.read_magic(file)
        read_head = np.lib.format.read_array_header_1_0
        if version != (1, 0):
            read_head = np.lib.format.read_array_header_2_0
        shape, _, dtype = read_head(file)
    count = math.prod(shape)
    if count * dtype.itemsize > entry.file_size:
        declared = count * dtype.itemsize
        found = f"{entry.file_size} bytes that declare {declared:.2g}"
        refuse_data(where, found, "a whole file")
    return bytes_of_numbers(count, dtype.itemsize)


def read_matlab(path: Path, where: str, options: DataOptions) -> Table:
    """Read the arrays of a MATLAB file; those of version 7.3 are HDF5."""
    import h5py
    from scipy.io import loadmat, whosmat

    if h5py.is_hdf5(path):
        return _read_matlab_hdf5(path, where, options)
    bytes_of_array: dict[str, float] = {}
    for name, shape, kind in whosmat(path):
        bytes_of_array[name] = bytes_of_numbers(math.prod(shape), 8.0)
        if kind not in MATLAB_NUMBERS:  # cells and structures hold anything
            bytes_of_array[name] = MAX_COMPRESSION * path.stat().st_size
    chosen = _names_read(where, list(bytes_of_array), options)
    budget = MemoryBudget(where)
    for name in chosen:
        budget.take(bytes_of_array[name])
    arrays = loadmat(path, variable_names=chosen)
    return table_of_mapping(where, {name: _vector(arrays[name]) for name in chosen}, options)


def _vector(array: Column) -> Column:
    """Return a row or a column of MATLAB, where all arrays are matrices, as a vector."""
    is_vector = array.ndim == 2 and 1 in array.shape
    if is_vector:
        return array.ravel()
    return array


def _read_matlab_hdf5(path: Path, where: str, options: DataOptions) -> Table:
    """Read a MATLAB file of version 7.3, whose arrays are transposed."""
    import h5py

    with h5py.File(path, "r") as file:
        chosen = _names_read(where, dataset_names(file), options)
        budget = MemoryBudget(where)
        arrays: dict[str, Column] = {}
        for name in chosen:
            transposed = numbers_of(where, file, name, budget)
            arrays[name] = _vector(transposed.T)
    return table_of_mapping(where, arrays, options)


def read_parquet(path: Path, where: str, options: DataOptions) -> Table:
    """Read columns of a Parquet file, with the package pyarrow."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        refuse_data(where, "a file of another package", "installed: pip install pyarrow")
    with parquet.ParquetFile(path) as file:
        schema = file.schema_arrow
        chosen = _names_read(where, schema.names, options)
        texts = [name for name in chosen if _is_text(schema.field(name).type)]
        n_rows = file.metadata.num_rows
        n_bytes = _unpacked_bytes(file.metadata, chosen)
    # a text that is there often is kept once
    with parquet.ParquetFile(path, read_dictionary=texts) as file:
        budget = MemoryBudget(where)
        budget.take(max(n_bytes, bytes_of_numbers(n_rows * len(chosen), 8.0)))
        for name in chosen:
            _require_flat(where, name, schema.field(name).type)
        batches = []
        for batch in file.iter_batches(ROWS_AT_ONCE, columns=chosen):
            budget.take(max(0.0, batch.nbytes - bytes_of_numbers(batch.num_rows * len(chosen), 8)))
            batches.append(batch)
    if batches:
        table = pyarrow.Table.from_batches(batches)  # in the order of the columns that were chosen
    else:
        table = schema.empty_table()
    columns = {name: np.asarray(table.column(name).to_pandas()) for name in chosen}
    return table_of_mapping(where, columns, options)


def _unpacked_bytes(metadata: parquet.FileMetaData, names: Sequence[str]) -> float:
    """Return the bytes that columns are said to have before they were compressed."""
    total = 0.0
    for group in range(metadata.num_row_groups):
        row_group = metadata.row_group(group)
        for index in range(row_group.num_columns):
            column = row_group.column(index)
            if column.path_in_schema.split(".")[0] in names:
                total += column.total_uncompressed_size
    return total


def _is_text(kind: pyarrow.DataType) -> bool:
    """Return whether a type of Arrow is one of texts."""
    import pyarrow

    return bool(pyarrow.types.is_string(kind) or pyarrow.types.is_large_string(kind))


def _require_flat(where: str, name: str, kind: pyarrow.DataType) -> None:
    """Raise InputError for a column whose elements are lists or tables: they may be of any size."""
    import pyarrow

    if pyarrow.types.is_nested(kind):
        refuse_data(f"{where}: column {name!r}", f"type {kind}", "numbers or texts")


# -- HDF5 ------------------------------------------------------------------------------------------


def read_hdf5_arrays(file: h5py.File, where: str, options: DataOptions) -> Table:
    """Read the arrays of an open HDF5 file, netCDF-4 among them."""
    chosen = _names_read(where, dataset_names(file), options)
    budget = MemoryBudget(where)
    arrays = {name: numbers_of(where, file, name, budget) for name in chosen}
    return table_of_mapping(where, arrays, options)


def dataset_names(parent: h5py.Group) -> list[str]:
    """Return the names of the datasets that lie in a group of the same file."""
    import h5py

    return [name for name in parent if isinstance(member_of(parent, name), h5py.Dataset)]


def member_of(parent: h5py.Group, name: str) -> h5py.Group | h5py.Dataset | None:
    """Return a member of a group that lies in the same file; None for other links, or none."""
    import h5py

    if not isinstance(parent.get(name, getlink=True), h5py.HardLink):
        return None
    return parent[name]


def dataset_of(parent: h5py.Group, name: str) -> h5py.Group | h5py.Dataset | None:
    """Return a member of a group, or the `value` of an element of H5MD; None for neither."""
    import h5py

    member = member_of(parent, name)
    if isinstance(member, h5py.Group):
        return member_of(member, "value")
    return member


def take_dataset(budget: MemoryBudget, where: str, dataset: h5py.Dataset) -> None:
    """Take the numbers of a dataset from a budget; InputError if more are declared than stored."""
    count = float(dataset.size or 0)
    require_memory(where, count * dataset.dtype.itemsize, dataset.id.get_storage_size())
    budget.take(bytes_of_numbers(count, dataset.dtype.itemsize))


def numbers_of(
    where: str, parent: h5py.Group, name: str, budget: MemoryBudget | None = None
) -> Column:
    """Return the numbers of a dataset, or of the `value` of an element of H5MD; or InputError.

    What netCDF says is missing is masked. Sizes are checked before memory is asked for, and taken
    from a budget.
    """
    import h5py

    dataset = dataset_of(parent, name)
    is_here = isinstance(dataset, h5py.Dataset) and not (dataset.is_virtual or dataset.external)
    if dataset is None or not is_here or dataset.dtype.kind not in "iuf":
        refuse_data(f"{where}: {name} value", "something else", "numbers in this file")
    take_dataset(budget or MemoryBudget(where), where, dataset)
    values = dataset[()]
    missing = np.zeros(np.shape(values), bool)
    for attribute in ("_FillValue", "missing_value"):
        for marker in np.ravel(dataset.attrs.get(attribute, ())):
            missing |= values == marker
    if dataset.fillvalue:  # that of HDF5 itself is 0, and netCDF's own is 1e37
        missing |= values == dataset.fillvalue
    if np.any(missing):
        return np.ma.array(values, mask=missing)
    return values
