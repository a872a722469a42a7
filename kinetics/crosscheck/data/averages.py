"""Tables of averages: what a paper has, a digitised curve, or the table of another program.

One row for each time, with columns such as `t, v0, v0_error, msd, msd_error`. Nothing is known of
how the averages of different times vary together: their errors are taken for independent.
`reading.read_data` reads them; begin with `table_of_averages`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from kinetics.crosscheck.data.arrays import Floats, NamedArrays
from kinetics.crosscheck.data.columns import AXES, ColumnName, find_columns
from kinetics.crosscheck.data.missing import without_mask
from kinetics.crosscheck.data.options import DataOptions, Units, refuse_data

#: Output of a Scene -> names of its column, in lower case.
AVERAGE_NAMES: dict[str, tuple[str, ...]] = {
    "thermal_speed": ("v0", "v_0", "v0(t)", "thermal_speed"),
    "mean_square_speed": ("v2", "<v2>", "<v^2>", "msv", "mean_square_speed"),
    "mean_speed": ("mean_speed", "<v>", "<|v|>"),
    "msd": ("msd", "r2", "<r2>", "<r^2>", "mean_square_displacement"),
    "kurtosis": ("kurtosis",),
    "a2": ("a2", "a_2"),
}
#: What stands beside the name of an average in the name of its standard error.
ERROR_SUFFIXES = ("_error", "_err", "_se", "_sem", "_sigma", "_std_error", " error")
ERROR_PREFIXES = ("error_", "err_", "sigma_", "d_")
#: Power of the unit of length, and of that of speed, in each average.
POWERS: dict[str, tuple[int, int]] = {
    "thermal_speed": (0, 1),
    "mean_square_speed": (0, 2),
    "mean_speed": (0, 1),
    "msd": (2, 0),
    "kurtosis": (0, 0),
    "a2": (0, 0),
}


@dataclass(frozen=True, eq=False)
class AveragesTable:
    """Averages at times, in d, U and d/U.

    Parameters
    ----------
    times : rising, shape (n_times,)
    names : of the averages, as outputs of a Scene: thermal_speed, mean_speed, msd, kurtosis, a2
    values : NaN where there is none, shape (n_names, n_times)
    errors : standard errors; NaN where none is stated, the same shape
    source : names where they came from
    remarks : what a reader should know of how they were read
    units : "speed", "length" and "time": U, d and d/U in the data's unit, where they were told
    """

    times: Floats
    names: tuple[str, ...]
    values: Floats
    errors: Floats
    source: str
    remarks: tuple[str, ...] = ()
    units: Mapping[str, float] | None = None

    @property
    def has_errors(self) -> bool:
        """Whether some standard error is stated."""
        return bool(np.any(self.errors > 0))


def are_averages(names: Iterable[str], options: DataOptions) -> bool:
    """Return whether columns of these names are averages at times, and not tracks."""
    columns = [ColumnName.of(name) for name in names]
    place_names = {AXES[0], options.columns.get(AXES[0], AXES[0])}
    has_places = any(column.bare in place_names for column in columns)
    has_averages = any(_column_of(columns, names) for names in AVERAGE_NAMES.values())
    return has_averages and not has_places


def table_of_averages(where: str, columns: NamedArrays, options: DataOptions) -> AveragesTable:
    """Return the averages in columns by the names of a file; InputError if they cannot be used."""
    found = find_columns(where, columns, options.columns, ())
    if "time" not in found and "frame" not in found:
        find_columns(where, columns, options.columns, ("time",))  # says what is missing
    if "time" in found:
        times = _numbers(where, columns, found["time"])
    else:
        times = options.times_of_steps(where, _numbers(where, columns, found["frame"]))
    _check_times(where, times)
    order = np.argsort(times)
    named = [ColumnName.of(name) for name in columns]
    values: dict[str, Floats] = {}
    errors: dict[str, Floats] = {}
    for name, aliases in AVERAGE_NAMES.items():
        column = _column_of(named, aliases)
        if column is None:
            continue
        unit = _unit_of(name, options.units)
        values[name] = _numbers(where, columns, column)[order] / unit
        errors[name] = np.full(times.size, np.nan)
        error_column = _column_of(named, _names_of_errors(aliases))
        if error_column is not None:
            errors[name] = _numbers(where, columns, error_column)[order] / unit
        _check_values(where, name, values[name], errors[name])
    _use_thermal_speed(values, errors)
    return AveragesTable(
        times=times[order] / options.units.time,
        names=tuple(values),
        values=np.stack(list(values.values())),
        errors=np.stack(list(errors.values())),
        source=where,
        remarks=_remarks_on(errors),
        units=options.units.by_name(),
    )


def _column_of(columns: Iterable[ColumnName], names: Iterable[str]) -> ColumnName | None:
    """Return the first column that has one of some names; None without any."""
    wanted = tuple(names)
    for column in columns:
        if column.bare in wanted or column.plain in wanted:
            return column
    return None


def _names_of_errors(names: Iterable[str]) -> list[str]:
    """Return what the standard error of an average may be called."""
    of_errors: list[str] = []
    for name in names:
        of_errors += [name + suffix for suffix in ERROR_SUFFIXES]
        of_errors += [prefix + name for prefix in ERROR_PREFIXES]
    return of_errors


def _numbers(where: str, columns: NamedArrays, column: ColumnName) -> Floats:
    """Return a column of numbers; InputError for what is none."""
    values = without_mask(columns[column.original])
    if values.ndim != 1 or values.dtype.kind not in "iuf":
        refuse_data(f"{where}: column {column.plain!r}", f"type {values.dtype}", "numbers")
    return values.astype(float)


def _check_times(where: str, times: Floats) -> None:
    """Raise InputError unless each row has a time of its own."""
    if times.size == 0:
        refuse_data(where, "no rows", "one for each time")
    is_refused = ~np.isfinite(times) | (times < 0)
    if np.any(is_refused):
        row = int(np.argmax(is_refused))
        refuse_data(f"{where}: row {row}", f"time = {times[row]}", "a number, not negative")
    if np.unique(times).size < times.size:
        refuse_data(f"{where}: time", "one that is there twice", "one row of averages for each")


def _check_values(where: str, name: str, values: Floats, errors: Floats) -> None:
    """Raise InputError for averages that are infinite, or errors that are negative."""
    is_refused = np.isinf(values) | np.isinf(errors) | (errors < 0)
    if np.any(is_refused):
        row = int(np.argmax(is_refused))
        number = f"{name} = {values[row]:g} +- {errors[row]:g}"
        refuse_data(f"{where}: row {row} by time", number, "finite, with an error above 0")
    negative = values < 0
    if name != "a2" and np.any(negative):
        row = int(np.argmax(negative))
        refuse_data(f"{where}: row {row} by time", f"{name} = {values[row]:g}", "not negative")


def _unit_of(name: str, units: Units) -> float:
    """Return the unit of an average in the data's units."""
    length_power, speed_power = POWERS[name]
    return float(units.length**length_power * units.speed**speed_power)


def _use_thermal_speed(values: dict[str, Floats], errors: dict[str, Floats]) -> None:
    """Put v0 = <v^2>^(1/2) in the place of <v^2>, with its error."""
    if "mean_square_speed" not in values:
        return
    square = values.pop("mean_square_speed")
    error_of_square = errors.pop("mean_square_speed")
    if "thermal_speed" in values:
        return
    speed = np.sqrt(square)
    values["thermal_speed"] = speed
    errors["thermal_speed"] = error_of_square / (2.0 * np.where(speed > 0, speed, np.nan))


def _remarks_on(errors: Mapping[str, Floats]) -> tuple[str, ...]:
    """Return what is to be said of averages without standard errors."""
    names_without = [name for name, values in errors.items() if not np.any(values > 0)]
    if not names_without:
        return ()
    names = ", ".join(names_without)
    return (f"No standard errors of {names}: give columns such as {names_without[0]}_error.",)
