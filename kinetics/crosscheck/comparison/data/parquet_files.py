"""Parquet: a table with the columns of `columns`, read in batches of rows by pyarrow."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from kinetics.crosscheck.comparison.data.arrays import PIECE, read_pieces
from kinetics.crosscheck.comparison.data.columns import (
    LABELS,
    Asked,
    Averages,
    Rows,
    find_columns,
    shown,
    split_unit,
)
from kinetics.errors import InputError


def read(path: Path, asked: Asked) -> Iterator[Rows | Averages]:
    """The rows of a file; labels must be whole numbers."""
    try:
        file = parquet.ParquetFile(path)
    except pa.ArrowInvalid as error:
        raise InputError(f"{shown(path)}: is damaged, or not a .parquet file") from error
    with file:
        names = file.schema_arrow.names
        found = find_columns(path, names, asked)
        kinds = {name: file.schema_arrow.field(k).type for name, k in found.items()}
        for name, kind in kinds.items():
            if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
                wanted = "whole numbers" if name in LABELS else "real numbers"
                raise InputError(f"{shown(path)}: column {name!r} is {kind}; it must be {wanted}")
        units = {name: split_unit(names[k])[1] for name, k in found.items()}
        mine = [names[k] for k in found.values()]
        for batch in file.iter_batches(PIECE, columns=mine):
            if any(batch.column(names[k]).null_count for k in found.values()):
                raise InputError(f"{shown(path)}: has empty cells; every value must be a number")
            columns = {name: np.from_dlpack(batch.column(names[k])) for name, k in found.items()}
            yield from read_pieces(path, columns, units)
