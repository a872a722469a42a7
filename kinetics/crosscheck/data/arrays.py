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


def lengths_of(vectors: Floats) -> Floats:
    """Return the length of vectors (..., d)."""
    square = vectors[..., 0] ** 2
    for axis in range(1, vectors.shape[-1]):  # summing over a short last axis takes longer
        square = square + vectors[..., axis] ** 2
    return np.asarray(np.sqrt(square))


def is_there_or_later(is_there: Flags) -> Flags:
    """Return whether a tracer is there at a time or at any later one, shape (n_times, n)."""
    return np.maximum.accumulate(is_there[::-1], axis=0)[::-1]


def label_text(label: object) -> str:
    """Return a label as a message shows it: whole numbers, which files have as floats, as such."""
    if isinstance(label, float | np.floating) and float(label).is_integer():
        return str(int(label))
    return str(label)


def select_rows(columns: Columns, rows: Flags) -> dict[str, Column]:
    """Return some of the rows of all columns."""
    return {name: values[rows] for name, values in columns.items()}


def floats_of(columns: Columns, name: str) -> Floats:
    """Return a column of numbers as floats, without a copy where it has floats."""
    return np.asarray(columns[name], float)
