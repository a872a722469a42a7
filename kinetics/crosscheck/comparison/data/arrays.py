"""Columns that are arrays: one one-dimensional array per column, all of one length.

Or arrays of frames: times (n_times,), positions and velocities (n_times, n_tracers, 2), in space
(n_times, n_tracers, 3).
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import (
    LABELS,
    Asked,
    Averages,
    Rows,
    Table,
    find_columns,
    first_not_finite,
    piece_of,
    shown,
    split_unit,
    stated_units,
)
from kinetics.crosscheck.comparison.data.frames import rows_of
from kinetics.errors import InputError

FRAMES = ("times", "positions", "velocities")
"""The names of arrays of frames."""
PIECE = 500_000
"""Rows that are in memory at once: 28 MB of seven columns."""


def read_table(table: Table, asked: Asked) -> Iterator[Rows | Averages]:
    """The rows of columns in memory: of a dictionary of arrays, or a DataFrame's."""
    names = list(table.columns)
    if set(FRAMES) <= set(names):
        parts = {name: np.asarray(table.columns[name]) for name in FRAMES}
        yield from read_frames(table.name, parts)
        return
    found = find_columns(table.name, [str(name) for name in names], asked)
    columns = {name: np.asarray(table.columns[names[k]]) for name, k in found.items()}
    for name in LABELS:
        if name in columns and columns[name].dtype.kind not in "iuf":  # texts
            columns[name] = np.unique(columns[name].astype(str), return_inverse=True)[1]
    units = {name: split_unit(str(names[k]))[1] for name, k in found.items()}
    yield from read_pieces(table.name, columns, units)


def read_frames(path: Path | str, parts: Mapping[str, Any]) -> Iterator[Rows]:
    """The rows of arrays of frames; the k-th of each frame is the same tracer.

    Each array has a dtype, a shape, and parts array[k, start:stop], which are asked for one after
    another.
    """
    where = shown(path)
    for name, array in parts.items():
        if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
            raise InputError(
                f"{where}: array {name!r} is of type {array.dtype}; needed are numbers"
            )
    times, positions, velocities = (parts[name] for name in FRAMES)
    shape = positions.shape
    if (
        len(shape) != 3
        or shape[2] not in (2, 3)
        or velocities.shape != shape
        or times.shape != shape[:1]
    ):
        raise InputError(
            f"{where}: times, positions, velocities have shapes {times.shape}, {shape}, "
            f"{velocities.shape}; they must be (n_times,) and twice (n_times, n_tracers, 2), "
            "or 3 in space"
        )
    for k, time in enumerate(np.asarray(times[:], float).tolist()):
        if not np.isfinite(time):
            raise InputError(f"{where}: times holds {time}; every value must be a finite number")
        for start in range(0, shape[1], PIECE):
            part = slice(start, min(start + PIECE, shape[1]))
            place, velocity = (np.asarray(a[k, part], float) for a in (positions, velocities))
            yield rows_of(where, time, place, velocity, np.arange(part.start, part.stop))


def read_pieces(
    path: Path | str, columns: Mapping[str, Any], units: Mapping[str, str] | None = None
) -> Iterator[Rows | Averages]:
    """The rows of columns in pieces; InputError for arrays that are no columns of numbers.

    Each column has a dtype, a shape, and parts column[start:stop], which are asked for one after
    another. units: of the columns that state one.
    """
    where, stated = shown(path), stated_units(path, units or {})
    for name, column in columns.items():
        _check_kind(f"{where}: array {name!r}", column, name in LABELS)
    sizes = {name: column.shape[0] for name, column in columns.items()}
    if len(set(sizes.values())) != 1:
        text = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise InputError(f"{where}: columns differ in length ({text})")
    for start in range(0, sizes["time"], PIECE):
        piece = {name: column[start : start + PIECE] for name, column in columns.items()}
        for name, values in piece.items():
            label = name in LABELS
            piece[name] = _labels(where, name, values) if label else np.asarray(values, float)
        if (bad := first_not_finite(piece)) is not None:
            k, name = bad
            raise InputError(
                f"{where}: row {start + k} has {name} = {piece[name][k]}; "
                "every value must be a finite number"
            )
        yield piece_of(piece, stated)


def _check_kind(where: str, column: Any, is_label: bool) -> None:
    dtype = column.dtype
    if dtype.hasobject:
        raise InputError(
            f"{where} holds Python objects, which are never loaded; save it as plain numbers"
        )
    # Whole numbers as floats, as np.loadtxt gives them, are labels too.
    if dtype.kind not in "iuf" or dtype.itemsize > 8:
        raise InputError(
            f"{where} is of type {dtype}; it must hold "
            f"{'whole numbers' if is_label else 'real numbers'} of at most 64 bits"
        )
    if column.shape is None or len(column.shape) != 1:
        raise InputError(f"{where} has shape {column.shape}; it must be (n,)")


def _labels(where: str, name: str, values: Any) -> Any:
    if values.dtype.kind == "f":
        whole = (np.abs(values) < 2.0**63) & (values == np.rint(values))  # not so for NaN
        if not np.all(whole):
            raise InputError(f"{where}: {name!r} must be whole numbers below 2^63, without NaN")
    with np.errstate(over="ignore"):
        return values.astype(np.int64)
