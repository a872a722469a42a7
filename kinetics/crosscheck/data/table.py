"""A table: one row for each particle at each time, in columns by our names, checked.

A format makes a `Table` of what a file holds (:func:`table_of_columns`, :func:`table_of_frames`,
:func:`table_of_arrays`); `tracks` makes tracks of those of all files. Numbers that are missing are
NaN.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from kinetics.crosscheck.data.arrays import (
    Column,
    Columns,
    Flags,
    Floats,
    NamedArrays,
    floats_of,
    select_rows,
)
from kinetics.crosscheck.data.columns import (
    AXES,
    LABELS,
    SPEEDS,
    ColumnName,
    find_columns,
    present,
)
from kinetics.crosscheck.data.frames import Box, Frame, unwrap_frames
from kinetics.crosscheck.data.missing import without_mask
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.errors import short

#: Types of numbers in a message at most.
MAX_TYPES_SHOWN = 9


@dataclass(frozen=True)
class Table:
    """Rows of particles at times.

    Parameters
    ----------
    where : names the source in messages
    columns : by our names, shape (n_rows,) each; times, places and velocities are floats
    remarks : what a reader should know of how it was read
    box : in which positions may be wrapped, where the source has one time alone: they can be
        unwrapped only with those of other times
    unit_names : "length", "speed" and "time": the units that the names of columns say
    """

    where: str
    columns: Columns
    remarks: tuple[str, ...] = ()
    box: Box | None = None
    unit_names: Mapping[str, str] = field(default_factory=dict)

    @property
    def n_rows(self) -> int:
        """The number of rows."""
        return int(self.columns["time"].size)

    def select(self, rows: Flags) -> Table:
        """Return some of the rows."""
        return replace(self, columns=select_rows(self.columns, rows))

    def has(self, name: str) -> bool:
        """Return whether there is a column of this name."""
        return name in self.columns


def needed_columns(options: DataOptions) -> tuple[str, ...]:
    """Return the columns that a table must have, by our names."""
    if options.type is None:
        return options.axes
    return (*options.axes, "type")


def table_of_columns(where: str, columns: NamedArrays, options: DataOptions) -> Table:
    """Return a table of columns by the names of a file; InputError for what cannot be used."""
    needed = needed_columns(options)
    found = find_columns(where, columns, options.columns, needed)
    if "time" not in found and "frame" not in found:
        find_columns(where, columns, options.columns, ("time", *needed))  # says what is missing
    arrays: dict[str, Column] = {}
    for name, column in found.items():
        arrays[name] = without_mask(columns[column.original])
    _check_shapes(where, arrays)
    if "time" not in arrays:
        arrays["time"] = options.times_of_steps(where, arrays["frame"])
    arrays.pop("frame", None)
    _check_units(where, found, options)
    table = _checked(where, arrays, options)
    return replace(table, unit_names=_unit_names(found))


def _check_shapes(where: str, arrays: Columns) -> None:
    """Raise InputError unless the columns have one length."""
    shapes = {values.shape for values in arrays.values()}
    first = next(iter(arrays.values()))
    if len(shapes) > 1 or first.ndim != 1:
        refuse_data(where, f"columns that differ in length or shape, {shapes}", "one length (n,)")
    if not first.size:
        refuse_data(where, "no rows", "two at least")


def _check_units(where: str, found: Mapping[str, ColumnName], options: DataOptions) -> None:
    """Raise InputError where the units in the names of columns do not belong together."""
    if options.has_time_unit or not {"x", "vx", "time"} <= set(found):
        return
    length = found["x"].unit
    speed = found["vx"].unit
    time = found["time"].unit
    parts_of_speed = re.findall(r"[^\W\d]+", speed)
    if length and time and len(parts_of_speed) == 2 and parts_of_speed != [length, time]:
        got = f"lengths in {length}, speeds in {speed}, times in {time}"
        refuse_data(where, got, "units that belong together, or say --time-unit")


def _unit_names(found: Mapping[str, ColumnName]) -> dict[str, str]:
    """Return the units of length, speed and time that the names of columns say."""
    unit_names = {}
    for quantity, name in (("length", "x"), ("speed", "vx"), ("time", "time")):
        if name in found and found[name].unit:
            unit_names[quantity] = found[name].unit
    return unit_names


def _checked(where: str, arrays: Columns, options: DataOptions) -> Table:
    """Return a table of arrays by our names: types, the type of the tracers, and the plane."""
    _check_shapes(where, arrays)
    columns: dict[str, Column] = {}
    for name, values in arrays.items():
        if name in LABELS:
            columns[name] = _as_labels(where, name, values)
        else:
            columns[name] = _as_numbers(where, name, values)
    table = Table(where, columns)
    if options.type is not None:
        table = _of_type(table, options.type)
    return _in_dimension(table, options)


def _as_labels(where: str, name: str, values: Column) -> Column:
    """Return labels as whole numbers or texts; InputError where one is missing."""
    if values.dtype.kind in "OUST":
        missing = pd.isna(values)
        if np.any(missing):
            refuse_data(
                f"{where}: row {int(np.argmax(missing))}", f"no {name}", "there, in every row"
            )
        return values.astype(str)
    if values.dtype.kind not in "iuf":
        refuse_data(f"{where}: column {name!r}", f"type {values.dtype}", "numbers or texts")
    if values.dtype.kind == "f" and not np.all(np.isfinite(values)):
        row = int(np.argmin(np.isfinite(values)))
        refuse_data(f"{where}: row {row}", f"{name} = {values[row]}", "a finite number")
    return values


def _as_numbers(where: str, name: str, values: Column) -> Floats:
    """Return numbers as floats; InputError for texts, and where one is infinite."""
    if values.dtype.kind not in "iuf" or values.dtype.itemsize > 8:
        refuse_data(f"{where}: column {name!r}", f"type {values.dtype}", "numbers")
    numbers = values.astype(float, copy=False)
    infinite = np.isinf(numbers)
    if np.any(infinite):
        row = int(np.argmax(infinite))
        refuse_data(f"{where}: row {row}", f"{name} = {numbers[row]}", "a finite number")
    return numbers


def _of_type(table: Table, type_name: str) -> Table:
    """Return the rows of one type of particle, without that column."""
    columns = dict(table.columns)
    types = columns.pop("type").astype(str)
    is_chosen = types == type_name
    if not np.any(is_chosen):
        known = ", ".join(np.unique(types)[:MAX_TYPES_SHOWN])
        refuse_data(f"{table.where}: type", short(type_name), f"one of {known}")
    return replace(table, columns=columns).select(is_chosen)


def _in_dimension(table: Table, options: DataOptions) -> Table:
    """Return a table without what the plane does not have; InputError for velocities across it."""
    columns = dict(table.columns)
    if options.dimension != 3:
        if "vz" in columns and np.any(np.nan_to_num(floats_of(columns, "vz"))):
            refuse_data(table.where, "velocities with z components", "none, or say dimension 3")
        columns.pop("vz", None)
        columns.pop("z", None)
    components = SPEEDS[: len(options.axes)]
    velocities = present(components, columns)
    if velocities and len(velocities) < len(components):
        missing = next(name for name in components if name not in columns)
        allowed = f"all of {', '.join(components)}, or none of them"
        refuse_data(table.where, f"no column {missing!r} beside {velocities[0]!r}", allowed)
    return replace(table, columns=columns)


def table_of_frames(
    where: str, frames: Sequence[Frame], options: DataOptions, box: Box | None = None
) -> Table:
    """Return the table of frames; what only some of them state is missing in the others.

    Parameters
    ----------
    where, options : see the module
    frames : in the order of time
    box : in which positions may be wrapped
    """
    if not frames:
        refuse_data(where, "no frames", "a file of this format")
    frames = unwrap_frames(where, frames, box, options.axes)
    times = [frame.time for frame in frames]
    repeats = [frame.n_rows for frame in frames]
    columns: dict[str, Column] = {}
    for frame in frames:
        for name in frame.columns:
            if name not in columns:
                columns[name] = np.concatenate([_column_of_frame(each, name) for each in frames])
    columns["time"] = np.repeat(times, repeats)
    table = _checked(where, _without_empty_rows(columns), options)
    if len(frames) > 1:
        return table
    return replace(table, box=box)


def _without_empty_rows(columns: Columns) -> Columns:
    """Return the rows with some number of a place or a velocity: others are of ended tracers."""
    numbers = [floats_of(columns, name) for name in present((*AXES, *SPEEDS), columns)]
    has_any = ~np.all(np.isnan(numbers), axis=0)
    if np.all(has_any):
        return columns
    return select_rows(columns, has_any)


def _column_of_frame(frame: Frame, name: str) -> Column:
    """Return a column of a frame; of missing numbers where the frame does not state it."""
    if name in frame.columns:
        return frame.columns[name]
    return np.full(frame.n_rows, np.nan)


def table_of_arrays(
    where: str,
    options: DataOptions,
    times: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike | None,
    labels: NamedArrays,
) -> Table:
    """Return the table of arrays of frames.

    Parameters
    ----------
    where, options : see the module
    times : shape (n_times,)
    positions : shape (n_times, n, d)
    velocities : the same shape; None where there are none
    labels : tracer, medium and type, shape (n,) or (n_times, n); without `tracer`, the k-th of each
        frame is the same tracer
    """
    times = without_mask(times)
    vectors = [without_mask(positions)]
    if velocities is not None:
        vectors.append(without_mask(velocities))
    frame_shape = vectors[0].shape[:2]
    n = 0
    if vectors[0].ndim == 3:
        n = vectors[0].shape[1]
    arrays: dict[str, Column] = {"tracer": np.arange(n)}
    for name, values in labels.items():
        arrays[name] = without_mask(values)
    _check_array_shapes(where, times, vectors, list(arrays.values()))
    columns: dict[str, Column] = {"time": np.repeat(times, n)}
    for names, array in zip((AXES, SPEEDS), vectors, strict=False):
        components = array.reshape(-1, array.shape[2]).T
        columns |= dict(zip(names, components, strict=False))
    for name, label in arrays.items():
        columns[name] = np.broadcast_to(label, frame_shape).ravel()
    needed = needed_columns(options)
    for name in needed:
        if name not in columns:
            refuse_data(where, f"no {name}", f"with {', '.join(needed)}")
    return _checked(where, _without_empty_rows(columns), options)


def _check_array_shapes(
    where: str,
    times: Column,
    vectors: Sequence[Column],
    labels: Sequence[Column],
) -> None:
    """Raise InputError unless arrays of frames have shapes that belong together.

    Parameters
    ----------
    where : names the source in messages
    times : must have the shape (T,)
    vectors : positions, and velocities if there are any; must have one shape (T, n, d)
    labels : must have the shape (n,) or (T, n)
    """
    shape = vectors[0].shape
    frame_shape = shape[:2]
    is_right = len(shape) == 3 and times.shape == frame_shape[:1]
    for array in vectors:
        is_right &= array.shape == shape
    for array in labels:
        is_right &= array.shape in (frame_shape, frame_shape[1:])
    if not is_right:
        shown = ", ".join(str(array.shape) for array in (times, *vectors, *labels))
        allowed = "(T,), (T, n, d), (T, n, d) and (n,) for each label"
        refuse_data(f"{where}: shapes", shown, allowed)
