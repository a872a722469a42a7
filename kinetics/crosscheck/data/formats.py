"""Formats of particle data: a format is one function and one row of `READERS`.

What users read of formats is `cli.track_options.DATA_HELP` and examples/docs/tutorials/data.md.

A function is given the path, its name for messages and the options, and returns a
:class:`~kinetics.crosscheck.data.table.Table`, or a run of `particles`. Nothing in a file is
executed, links into other files are not followed, and sizes are checked before memory is asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from kinetics.crosscheck.data.arrays import Source
from kinetics.crosscheck.data.averages import AveragesTable, are_averages, table_of_averages
from kinetics.crosscheck.data.containers import (
    member_of,
    read_hdf5_arrays,
    read_matlab,
    read_npz,
    read_parquet,
    table_of_mapping,
)
from kinetics.crosscheck.data.h5md import read_h5md
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.crosscheck.data.table import Table
from kinetics.crosscheck.data.text_table import read_text_table
from kinetics.crosscheck.data.trajectories import read_gsd, read_lammps, read_xyz
from kinetics.errors import InputError, short

if TYPE_CHECKING:
    from particles import Ensemble

#: Characters of a file's name that are shown: its end tells it apart.
MAX_NAME = 200
#: What data in memory are called.
IN_MEMORY = "data"
#: Endings of text that is packed.
PACKED_TEXT = (".csv.gz", ".tsv.gz", ".txt.gz")


def _read_hdf5(path: Path, where: str, options: DataOptions) -> Table | Ensemble:
    """Read a run of `particles`, H5MD, or arrays."""
    import h5py

    with h5py.File(path, "r") as file:
        is_ensemble = "plan" in file and "done" in file.attrs
        if not is_ensemble:
            if member_of(file, "h5md") and member_of(file, "particles"):
                return read_h5md(file, where, options)
            return read_hdf5_arrays(file, where, options)
    from particles import Ensemble

    return Ensemble.load(path)


#: The ending of a file's name, and the function that reads it.
READERS: dict[str, Callable[[Path, str, DataOptions], Table | AveragesTable | Ensemble]] = {
    ".csv": read_text_table,
    ".tsv": read_text_table,
    ".txt": read_text_table,
    ".dat": read_text_table,
    ".npz": read_npz,
    ".mat": read_matlab,
    ".parquet": read_parquet,
    ".h5": _read_hdf5,
    ".hdf5": _read_hdf5,
    ".h5md": _read_hdf5,
    ".nc": _read_hdf5,
    ".dump": read_lammps,
    ".lammpstrj": read_lammps,
    ".xyz": read_xyz,
    ".extxyz": read_xyz,
    ".gsd": read_gsd,
}


def name_of(source: Source) -> str:
    """Return the path of a file on one line that can be printed; "data" for data in memory."""
    if not isinstance(source, Path):
        return IN_MEMORY
    text = str(source).encode("utf-8", "replace").decode()
    printable = "".join(character if character.isprintable() else " " for character in text)
    return " ".join(printable.split())[-MAX_NAME:] or "''"


def read_source(source: Source, options: DataOptions) -> Table | AveragesTable | Ensemble:
    """Return the table, or the run, that a file or a mapping of arrays holds; or InputError."""
    where = name_of(source)
    try:
        if not isinstance(source, Path):
            if are_averages(source, options):
                return table_of_averages(where, source, options)
            return table_of_mapping(where, source, options)
        read = _reader_of(source, where)
        return read(source, where, options)
    except InputError:
        raise
    except Exception as error:  # the libraries raise errors of nearly any class
        reason = getattr(error, "strerror", None) or short(str(error), MAX_NAME)
        raise InputError(f"{where}: is damaged, or not of this format ({reason})") from None


def _reader_of(
    path: Path, where: str
) -> Callable[[Path, str, DataOptions], Table | AveragesTable | Ensemble]:
    """Return the function that reads a file, by its ending; InputError if there is none."""
    ending = path.suffix.lower()
    if path.name.lower().endswith(PACKED_TEXT):
        ending = ".csv"
    if ending not in READERS:
        refuse_data(where, f"ending {ending!r}", f"a file {', '.join(READERS)} or .csv.gz")
    if not path.is_file():
        if path.exists():
            raise InputError(f"{where}: it is no file")
        raise InputError(f"{where}: no such file")
    return READERS[ending]
