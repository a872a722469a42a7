"""Columns that are arrays: one one-dimensional array per column, all of one length."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import (
    LABELS,
    NUMBERS,
    Progress,
    Rows,
    first_not_finite,
    shown,
)
from kinetics.errors import InputError

PIECE = 500_000
"""Rows that are in memory at once: 28 MB of seven columns."""


@dataclass(frozen=True)
class ArrayColumn:
    """An array in a file: its type and shape, and `read(start, count)` for a part of it.

    Parts are asked for one after another, from the beginning to the end.
    """

    dtype: np.dtype[Any]
    shape: tuple[int, ...] | None
    read: Callable[[int, int], Any]


def read_pieces(
    path: Path, columns: Mapping[str, ArrayColumn], progress: Progress
) -> Iterator[Rows]:
    """The rows of columns in pieces; InputError for arrays that are no columns of numbers."""
    for name, column in columns.items():
        _check_kind(path, name, column.dtype)
        if column.shape is None or len(column.shape) != 1:
            raise InputError(
                f"{shown(path)}: array {name!r} has shape {column.shape}; it must be (n,)"
            )
    sizes = {name: column.shape[0] for name, column in columns.items() if column.shape}
    if len(set(sizes.values())) != 1:
        text = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise InputError(f"{shown(path)}: columns differ in length ({text})")
    total = sizes["time"]
    for start in range(0, total, PIECE):
        count = min(PIECE, total - start)
        numbers = [np.asarray(columns[name].read(start, count), float) for name in NUMBERS]
        labels = {
            name: _labels(path, name, columns[name].read(start, count))
            for name in LABELS
            if name in columns
        }
        rows = Rows(*numbers, **labels)
        bad = first_not_finite(rows)
        if bad is not None:
            k, name = bad
            raise InputError(
                f"{shown(path)}: row {start + k} has {name} = {getattr(rows, name)[k]}; "
                "every value must be a finite number"
            )
        yield rows
        progress((start + count) / total)


def _check_kind(path: Path, name: str, dtype: np.dtype[Any]) -> None:
    if dtype.hasobject:
        raise InputError(
            f"{shown(path)}: array {name!r} holds Python objects, which are never loaded; "
            "save it as plain numbers"
        )
    # Whole numbers as floats, as np.loadtxt gives them, are labels too.
    if dtype.kind not in "iuf" or dtype.itemsize > 8:
        raise InputError(
            f"{shown(path)}: array {name!r} is of type {dtype}; it must hold "
            f"{'whole numbers' if name in LABELS else 'real numbers'} of at most 64 bits"
        )


def _labels(path: Path, name: str, values: Any) -> Any:
    if values.dtype.kind == "f":
        if not np.all(np.isfinite(values)) or np.any(values != np.rint(values)):
            raise InputError(f"{shown(path)}: {name!r} must be whole numbers, without NaN")
        if np.any(np.abs(values) >= 2.0**63):
            raise InputError(f"{shown(path)}: {name!r} must be below 2^63")
    with np.errstate(over="ignore"):
        return values.astype(np.int64)
