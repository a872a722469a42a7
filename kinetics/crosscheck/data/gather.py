"""Tracers at common times, gathered from the rows of tables.

Several files are several runs of the same system, unless each holds one time of the same tracers.
Rows are put together, those without a number are left out, times are thinned, and each tracer
becomes a column of arrays. Begin with `gather_tracks`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from kinetics.crosscheck.data.arrays import (
    Column,
    Columns,
    Flags,
    Floats,
    Integers,
    floats_of,
    label_text,
    select_rows,
)
from kinetics.crosscheck.data.columns import AXES, SPEEDS, present
from kinetics.crosscheck.data.differences import quotient_of_velocities
from kinetics.crosscheck.data.frames import Frame, common_box, unwrap_frames
from kinetics.crosscheck.data.memory import require_memory
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.crosscheck.data.table import Table
from kinetics.crosscheck.data.tracks import MAX_SIZE, Tracks

#: Times that are kept at most: of more, this many are chosen evenly in the logarithm of the time.
MAX_TIMES = 400
#: Successive frames that are kept together where there are positions alone: a straight flight is
#: seen in three.
FRAMES_TOGETHER = 3
#: Tracks that all begin at different times from which each has its own clock: of a gas that is seen
#: from its start, more than one tracer is there at the first frame. Chosen: fewer may be one gas.
MIN_CLOCKS = 10
#: Times that differ by less than this fraction are one time: single precision rounds by 6e-8.
SAME_TIME = 1e-6
#: The same as a fraction of the mean step, for times that are long after 0. Origin not recorded.
SAME_TIME_OF_STEP = 1e-3
#: Times that differ by less than this fraction may be one time in single precision, whose rounding
#: it is. (Two that are rounded differ by 1.2e-7 or not at all.)
SINGLE_PRECISION = 6e-8
#: They are one then if that is below this fraction of the mean step. Chosen: steps that vary by
#: less than five times are kept.
SINGLE_OF_STEP = 0.2
#: Share of the times that are numbers of single precision from which they come from such a program.
#: Chosen: of times that are stated in single precision by one file of two it is a half.
MIN_SINGLE_SHARE = 0.25
#: Times at which velocities are needed to be of use: at one, positions alone tell more.
MIN_TIMES_WITH_VELOCITIES = 2
#: Rows from which it is told whether velocities are differences of positions, about.
ROWS_SAMPLED = 100_000
#: Labels that say which tracer a row is of.
IDENTITY_LABELS = ("tracer", "medium")
#: The place of a row among those of its time: what tells tracers apart that have no label.
RANK = "rank"
#: Bytes of a number of the two arrays of vectors, and of what is made of them meanwhile.
BYTES_OF_NUMBER = 16.0


def gather_tracks(tables: Sequence[Table], options: DataOptions) -> Tracks:
    """Return the tracers of all tables side by side, at the times of any of them."""
    where = ", ".join(table.where for table in tables)
    rows = _Rows.of(tables, where)
    rows = _without_useless_velocities(rows, options)
    rows = _without_gaps(rows)
    rows = _thinned(rows)
    return _dense(rows, options)


@dataclass(frozen=True)
class _Rows:
    """The rows of all tables.

    Parameters
    ----------
    where : names the sources in messages
    columns : by our names, shape (n_rows,) each
    file : the number of the run of each row
    time_index : the index of the time of each row
    times : rising, shape (n_times,)
    remarks : so far
    """

    where: str
    columns: Columns
    file: Integers
    time_index: Integers
    times: Floats
    remarks: tuple[str, ...]

    @classmethod
    def of(cls, tables: Sequence[Table], where: str) -> _Rows:
        """Put the rows of tables together."""
        has_one_time_each = _hold_one_time_each(tables)
        if has_one_time_each:
            tables = _unwrapped(tables, where)
        _check_same_columns(tables)
        columns = _joined_columns(tables)
        sizes = [table.n_rows for table in tables]
        file = np.repeat(np.arange(len(tables)), sizes)
        remarks = _all_remarks(tables)
        if has_one_time_each:
            if "tracer" not in columns:
                refuse_data(where, "files of one time each", "with a column tracer, to join them")
            file = np.zeros_like(file)
            remarks.append(
                f"{len(tables)} files of one time each: joined by the labels of tracers."
            )
        elif len(tables) > 1 and "tracer" not in columns and _hold_one_track_each(columns, file):
            columns["tracer"] = file
            remarks.append(f"{len(tables)} files, each of one track.")
        if _have_own_clocks(columns, file):
            columns["time"] = floats_of(columns, "time") - _first_times(columns, file)
            remarks.append(
                "Each track begins at a time of its own, and none with another: each has its own "
                "clock, and begins at time 0."
            )
        times, time_index = _common_times(floats_of(columns, "time"), where)
        if "tracer" not in columns:
            columns[RANK] = _rank_at_time(columns, file, time_index)
        return cls(where, columns, file, time_index, times, tuple(remarks))

    def select(self, chosen: Flags, remark: str) -> _Rows:
        """Return some of the rows, and say so."""
        used = np.unique(self.time_index[chosen])
        return _Rows(
            where=self.where,
            columns=select_rows(self.columns, chosen),
            file=self.file[chosen],
            time_index=np.searchsorted(used, self.time_index[chosen]),
            times=self.times[used],
            remarks=(*self.remarks, remark),
        )


def _check_same_columns(tables: Sequence[Table]) -> None:
    """Raise InputError where some tables have a column of tracers that others lack."""
    for table in tables:
        for label in (*IDENTITY_LABELS, *AXES, *SPEEDS):
            if table.has(label) != tables[0].has(label):
                found = f"another column {label} than before"
                refuse_data(table.where, found, "in all files or in none")


def _joined_columns(tables: Sequence[Table]) -> dict[str, Column]:
    """Return the columns that all tables have, with the rows of one table below another."""
    columns: dict[str, Column] = {}
    for name in tables[0].columns:
        if all(table.has(name) for table in tables):
            columns[name] = np.concatenate([table.columns[name] for table in tables])
    return columns


def _all_remarks(tables: Sequence[Table]) -> list[str]:
    """Return the remarks of all tables."""
    remarks: list[str] = []
    for table in tables:
        remarks += table.remarks
    return remarks


def _rank_at_time(columns: Columns, file: Integers, time_index: Integers) -> Integers:
    """Return the place of each row among those of its time, in its run and medium."""
    keys: dict[str, Column] = {"time": time_index, "file": file}
    if "medium" in columns:
        keys["medium"] = columns["medium"]
    frame = pd.DataFrame(keys)
    return np.asarray(frame.groupby(list(frame)).cumcount())


def _hold_one_time_each(tables: Sequence[Table]) -> bool:
    """Return whether each table holds one time, another than the others."""
    if len(tables) < 2:
        return False
    times = []
    for table in tables:
        times_of_table = np.unique(floats_of(table.columns, "time"))
        if times_of_table.size != 1:
            return False
        times.append(times_of_table[0])
    rising = np.sort(times)
    return bool(np.all(np.diff(rising) > SAME_TIME * rising[1:]))


def _hold_one_track_each(columns: Columns, file: Integers) -> bool:
    """Return whether no file has two rows at one time."""
    rows = pd.DataFrame({"file": file, "time": columns["time"]})
    return not rows.duplicated().any()


def _unwrapped(tables: Sequence[Table], where: str) -> Sequence[Table]:
    """Return tables of one time each, with positions that are unwrapped from one to the next."""
    box = common_box(where, [table.box for table in tables])
    if box is None:
        return tables
    frames = []
    for table in tables:
        time = float(floats_of(table.columns, "time")[0])
        frames.append(Frame(time, dict(table.columns)))
    frames.sort(key=lambda frame: frame.time)
    axes = present(AXES, tables[0].columns)
    unwrapped = unwrap_frames(where, frames, box, axes)
    remarks = tuple(_all_remarks(tables))
    return [Table(where, frame.columns, remarks) for frame in unwrapped]


def _first_times(columns: Columns, file: Integers) -> Floats:
    """Return for each row the first time of its tracer."""
    labels = present(IDENTITY_LABELS, columns)
    frame = pd.DataFrame({name: columns[name] for name in (*labels, "time")})
    frame["file"] = file
    keys = [*labels, "file"]
    return np.asarray(frame.groupby(keys)["time"].transform("min"))


def _have_own_clocks(columns: Columns, file: Integers) -> bool:
    """Return whether each of many tracks begins at a time of its own, none with another.

    Of many tracks of one clock, some begin in the same frame.
    """
    times = floats_of(columns, "time")
    if "tracer" not in columns or np.count_nonzero(times == np.nanmin(times)) > 1:
        return False
    first_times = _first_times(columns, file)
    begins = times == first_times
    n_tracks = np.count_nonzero(begins)
    has_more_rows = times.size > n_tracks
    are_different = np.unique(first_times).size == n_tracks
    return bool(has_more_rows and are_different and n_tracks >= MIN_CLOCKS)


def _common_times(times: Floats, where: str) -> tuple[Floats, Integers]:
    """Return the different times, rising, and the index of each row's; NaN is refused."""
    missing = np.isnan(times)
    if np.any(missing):
        refuse_data(f"{where}: row {int(np.argmax(missing))}", "no time", "there, in every row")
    index, different = pd.factorize(times, sort=True)
    different = np.asarray(different, float)
    if different[0] < 0:
        refuse_data(f"{where}: time", f"{different[0]:g}", "not negative")
    mean_step = (different[-1] - different[0]) / max(different.size - 1, 1)
    margin = np.minimum(SAME_TIME * different[1:], SAME_TIME_OF_STEP * mean_step)
    if _has_single_precision(different):
        of_single = np.minimum(SINGLE_PRECISION * different[1:], SINGLE_OF_STEP * mean_step)
        margin = np.maximum(margin, of_single)
    is_new = np.append(True, np.diff(different) > margin)
    return different[is_new], (np.cumsum(is_new) - 1)[index]


def _has_single_precision(times: Floats) -> bool:
    """Return whether so many times are numbers of single precision that these are no accident."""
    with np.errstate(over="ignore"):
        single = times.astype(np.float32)
    return bool(np.mean(times == single) > MIN_SINGLE_SHARE)


def _without_useless_velocities(rows: _Rows, options: DataOptions) -> _Rows:
    """Return rows without velocities that are differences of positions, or are at few times."""
    if SPEEDS[0] not in rows.columns:
        return rows
    is_stated = ~np.isnan(floats_of(rows.columns, SPEEDS[0]))
    n_times = np.count_nonzero(np.bincount(rows.time_index[is_stated]))
    if n_times < min(MIN_TIMES_WITH_VELOCITIES, rows.times.size):
        reason = f"Velocities are stated at {n_times} of {rows.times.size} times"
    else:
        quotient = _quotient_of_sample(rows, options)
        if quotient is None:
            return rows
        reason = f"Velocities are {quotient} differences of the positions, row by row"
    columns = dict(rows.columns)
    for name in SPEEDS:
        columns.pop(name, None)
    remark = f"{reason}: positions alone are used."
    return replace(rows, columns=columns, remarks=(*rows.remarks, remark))


def _quotient_of_sample(rows: _Rows, options: DataOptions) -> str | None:
    """Return which difference quotient the velocities of some tracers are; None for measured."""
    label_name = present(("tracer", RANK), rows.columns)[0]
    labels = rows.columns[label_name]
    n_tracers = ROWS_SAMPLED // rows.times.size + 1
    sampled_labels = labels[:: labels.size // n_tracers + 1]
    is_sampled = np.asarray(pd.Series(labels).isin(sampled_labels))
    tracks = _dense(rows.select(is_sampled, ""), options)
    return quotient_of_velocities(tracks, options.units, options.with_axes)


def _without_gaps(rows: _Rows) -> _Rows:
    """Return the rows in which no number is missing; those that are left out are counted."""
    missing: dict[str, Flags] = {}
    for name in present((*AXES, *SPEEDS), rows.columns):
        missing[name] = np.isnan(floats_of(rows.columns, name))
    has_gap = np.any(list(missing.values()), axis=0)
    n_gaps = int(np.count_nonzero(has_gap))
    if n_gaps == 0:
        return rows
    if n_gaps == has_gap.size:
        refuse_data(rows.where, _what_is_missing(missing), "rows with all numbers")
    share = n_gaps / has_gap.size
    remark = f"{n_gaps} rows ({share:.2g} of all) in which a number is missing are left out."
    return rows.select(~has_gap, remark)


def _what_is_missing(missing: Mapping[str, Flags]) -> str:
    """Return the first column that has no number at all, as a message names it."""
    for name, is_missing in missing.items():
        if np.all(is_missing):
            return f"no number of {name!r}"
    return "a number that is missing in every row"


def _thinned(rows: _Rows) -> _Rows:
    """Return the rows of at most `MAX_TIMES` times, even in the logarithm, with first and last.

    Where there are positions alone, each of these has the frames that follow it beside it.
    """
    count = rows.times.size
    if count <= MAX_TIMES:
        return rows
    n_together = 1 if SPEEDS[0] in rows.columns else FRAMES_TOGETHER
    n_wanted = MAX_TIMES // n_together - 1
    since_first = rows.times - rows.times[0]
    wanted = np.geomspace(since_first[1], since_first[-1], n_wanted)
    nearest = np.searchsorted(since_first, wanted * (1.0 - SAME_TIME))
    chosen = np.concatenate([[0], nearest, [count - n_together]])
    with_following = np.add.outer(chosen, np.arange(n_together)).ravel()
    is_chosen = np.zeros(count, bool)
    is_chosen[with_following[with_following < count]] = True
    n_chosen = np.count_nonzero(is_chosen)
    remark = f"Of {count} times {n_chosen} are used, even in the logarithm of the time."
    return rows.select(is_chosen[rows.time_index], remark)


def _dense(rows: _Rows, options: DataOptions) -> Tracks:
    """Return rows as arrays of times and tracers; InputError for two rows of one tracer."""
    number, n_tracers = _tracer_numbers(rows)
    n_times = rows.times.size
    n_axes = len(present(AXES, rows.columns))
    require_memory(rows.where, BYTES_OF_NUMBER * n_axes * n_tracers * n_times)
    cell = rows.time_index * n_tracers + number
    _check_one_row_each(rows, cell)
    place = _vectors(rows, AXES, cell, (n_times, n_tracers)) / options.units.length
    velocity = None
    if SPEEDS[0] in rows.columns:
        velocity = _vectors(rows, SPEEDS, cell, (n_times, n_tracers)) / options.units.speed
    _check_sizes(rows.where, place, velocity)
    row_of_tracer = np.empty(n_tracers, np.int64)
    row_of_tracer[number] = np.arange(number.size)
    labels: dict[str, Column] = {}
    for name in present(IDENTITY_LABELS, rows.columns):
        labels[name] = rows.columns[name][row_of_tracer]
    return Tracks(
        times=rows.times / options.units.time,
        place=place,
        velocity=velocity,
        tracer=labels.get("tracer"),
        medium=labels.get("medium"),
        file=rows.file[row_of_tracer],
        remarks=rows.remarks,
    )


def _tracer_numbers(rows: _Rows) -> tuple[Integers, int]:
    """Return a number for the tracer of each row, and how many there are.

    Labels of one file, or medium, are not those of another. Without labels the k-th row of each
    time is taken for the same tracer.
    """
    labels = [rows.columns[name] for name in present((*IDENTITY_LABELS, RANK), rows.columns)]
    number = np.zeros(rows.time_index.size, np.int64)
    for values in (*labels, rows.file):
        code, different = pd.factorize(values, sort=True)
        number = number * len(different) + code
    number, different = pd.factorize(number, sort=True)
    n_tracers = len(different)
    if "tracer" in rows.columns and n_tracers == number.size and rows.times.size > 1:
        allowed = "labels that stay with a tracer (--columns tracer=...), or none"
        refuse_data(f"{rows.where}: tracer", "another label in every row", allowed)
    return number, n_tracers


def _check_one_row_each(rows: _Rows, cell: Integers) -> None:
    """Raise InputError where a tracer has two rows at one time."""
    filled = np.bincount(cell)
    if filled.max() <= 1:
        return
    row = int(np.argmax(filled[cell] > 1))
    names = present(IDENTITY_LABELS, rows.columns)
    tracer = " of ".join(f"{name} {label_text(rows.columns[name][row])}" for name in names)
    time = floats_of(rows.columns, "time")[row]
    refuse_data(rows.where, f"more than one row of {tracer} at time {time:g}", "one for each time")


def _vectors(rows: _Rows, names: Sequence[str], cell: Integers, shape: tuple[int, int]) -> Floats:
    """Return vectors of shape (n_times, n, d), NaN where there is no row."""
    components = [floats_of(rows.columns, name) for name in present(names, rows.columns)]
    vectors = np.full((shape[0] * shape[1], len(components)), np.nan)
    vectors[cell] = np.stack(components, axis=-1)
    return vectors.reshape(*shape, -1)


def _check_sizes(where: str, place: Floats, velocity: Floats | None) -> None:
    """Raise InputError for numbers whose fourth powers are out of range."""
    far = float(np.nanmax(np.abs(place), initial=0.0))
    fast = 0.0
    if velocity is not None:
        fast = float(np.nanmax(np.abs(velocity), initial=0.0))
    if max(far, fast) > MAX_SIZE:
        got = f"speeds of {fast:.3g} U and displacements of {far:.3g} d"
        refuse_data(where, got, f"below {MAX_SIZE:g}; give --speed-unit and --diameter")
