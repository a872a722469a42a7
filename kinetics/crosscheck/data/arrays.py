"""Types of the arrays that hold data, and of what a user may hand over as data."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Integers = NDArray[np.int64]
#: One value for each row: numbers, or labels, which may be texts.
Column = NDArray[np.generic]
#: Columns by name, all with the same rows.
Columns = Mapping[str, Column]
#: Columns or arrays in memory (lists, NumPy, pandas) by the names that their user gives them.
NamedArrays = Mapping[str, ArrayLike]
#: Where data come from: a file, or arrays in memory.
Source = Path | NamedArrays


def select_rows(columns: Columns, rows: Flags) -> dict[str, Column]:
    """Return some of the rows of all columns."""
    return {name: values[rows] for name, values in columns.items()}


def floats_of(columns: Columns, name: str) -> Floats:
    """Return a column of numbers as floats, without a copy where it has floats."""
    return np.asarray(columns[name], float)
