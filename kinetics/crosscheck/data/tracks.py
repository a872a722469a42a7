"""Tracks: tracers at common times, from the tables of one file or several.

Several files are several runs of the same system, unless each holds one time of the same tracers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from kinetics.crosscheck.data.columns import AXES, SPEEDS
from kinetics.crosscheck.data.memory import require_memory
from kinetics.crosscheck.data.options import DataOptions, refuse_data
from kinetics.crosscheck.data.table import Table

#: Times that are kept at most: of more, this many are chosen evenly in the logarithm of the time.
MAX_TIMES = 400
#: Largest time, speed and displacement, in d/U, U and d: fourth powers of these are doubles.
MAX_SIZE = 1e70
#: Successive frames that are kept together where there are positions alone: a straight flight is
#: seen in three.
FRAMES_TOGETHER = 3
#: Times that differ by less than this fraction, and of the mean step than the next, are one time:
#: single precision rounds by 6e-8.
SAME_TIME = 1e-6
SAME_TIME_OF_STEP = 1e-3
#: Labels that say which tracer a row is of.
IDENTITY_LABELS = ("tracer", "medium")
#: The place of a row among those of its time: what tells tracers apart that have no label.
RANK = "rank"
#: Bytes of a number of the two arrays of vectors, and of what is made of them meanwhile.
BYTES_OF_NUMBER = 16.0
#: Mean squares of displacements at time 0, over the largest, that are rounding.
ROUNDING_OF_PLACE = 1e-18
#: Places at a first time t0 above 0 count as absolute if the median distance from the origin is
#: more than this times the largest speed at t0 times t0. The speed was higher before, but a tracer
#: that cools as 1/t has gone less than v t0 times the root of ln t0: a displacement is below.
FURTHER_THAN_SPEED = 2.0
#: A first time of more than so many times the duration is a time stamp: tracers start there.
TIME_STAMP_OVER_DURATION = 1e3
#: Wrapped positions are looked for where so many tracers would leave the region of the start.
MIN_LEAVING = 20
#: So many tracers, of all, may lie beyond half the region: it is drawn by the tracers themselves.
EDGE_TRACERS = 10


@dataclass(frozen=True)
class Tracks:
    """Tracers at common times, in d, U and d/U; NaN where a number is missing.

    Parameters
    ----------
    times : rising, shape (n_times,)
    place : shape (n_times, n, d)
    velocity : the same shape; None where there are no velocities
    tracer, medium : labels, shape (n,); None where they are unknown
    file : the number of the run of each tracer, shape (n,)
    remarks : what a reader should know of how they were made
    """

    times: NDArray[Any]
    place: NDArray[Any]
    velocity: NDArray[Any] | None
    tracer: NDArray[Any] | None = None
    medium: NDArray[Any] | None = None
    file: NDArray[Any] | int = 0
    remarks: tuple[str, ...] = ()

    @property
    def n_tracers(self) -> int:
        """The number of tracers."""
        return int(self.place.shape[1])

    def select_tracers(self, chosen: NDArray[np.bool_]) -> Tracks:
        """Return some of the tracers."""
        file = self.file if isinstance(self.file, int) else self.file[chosen]
        return replace(
            self,
            place=self.place[:, chosen],
            velocity=None if self.velocity is None else self.velocity[:, chosen],
            tracer=None if self.tracer is None else self.tracer[chosen],
            medium=None if self.medium is None else self.medium[chosen],
            file=file,
        )


def gather_tracks(tables: Sequence[Table], options: DataOptions) -> Tracks:
    """Return the tracers of all tables side by side, at the times of any of them."""
    where = ", ".join(table.where for table in tables)
    rows = _Rows.of(tables, where)
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
    columns: dict[str, NDArray[Any]]
    file: NDArray[Any]
    time_index: NDArray[Any]
    times: NDArray[Any]
    remarks: tuple[str, ...]

    @classmethod
    def of(cls, tables: Sequence[Table], where: str) -> _Rows:
        """Put the rows of tables together."""
        for table in tables:
            for label in (*IDENTITY_LABELS, *AXES, *SPEEDS):
                if table.has(label) != tables[0].has(label):
                    found = f"another column {label} than before"
                    refuse_data(table.where, found, "in all files or in none")
        names = [name for name in tables[0].columns if all(table.has(name) for table in tables)]
        columns = {
            name: np.concatenate([table.columns[name] for table in tables]) for name in names
        }
        sizes = [table.n_rows for table in tables]
        file = np.repeat(np.arange(len(tables)), sizes)
        remarks = [remark for table in tables for remark in table.remarks]
        if _are_times_of_one_run(tables):
            file = np.zeros_like(file)
            remarks.append(
                f"{len(tables)} files of one time each: joined by the labels of tracers."
            )
        times, time_index = _common_times(columns["time"], where)
        if "tracer" not in columns:
            columns[RANK] = _rank_at_time(columns, file, time_index)
        return cls(where, columns, file, time_index, times, tuple(remarks))

    def select(self, chosen: NDArray[np.bool_], remark: str) -> _Rows:
        """Return some of the rows, and say so."""
        columns = {name: values[chosen] for name, values in self.columns.items()}
        used = np.unique(self.time_index[chosen])
        return _Rows(
            where=self.where,
            columns=columns,
            file=self.file[chosen],
            time_index=np.searchsorted(used, self.time_index[chosen]),
            times=self.times[used],
            remarks=(*self.remarks, remark),
        )


def _rank_at_time(
    columns: dict[str, NDArray[Any]], file: NDArray[Any], time_index: NDArray[Any]
) -> NDArray[Any]:
    """Return the place of each row among those of its time, in its run and medium."""
    keys = {"time": time_index, "file": file}
    if "medium" in columns:
        keys["medium"] = columns["medium"]
    frame = pd.DataFrame(keys)
    return np.asarray(frame.groupby(list(frame)).cumcount())


def _are_times_of_one_run(tables: Sequence[Table]) -> bool:
    """Return whether each table holds one time, another than the others, of labelled tracers."""
    if len(tables) < 2 or not tables[0].has("tracer"):
        return False
    times = [np.unique(table.columns["time"]) for table in tables]
    if any(time.size != 1 for time in times):
        return False
    rising = np.sort([float(time[0]) for time in times])
    return bool(np.all(np.diff(rising) > SAME_TIME * rising[1:]))


def _common_times(times: NDArray[Any], where: str) -> tuple[NDArray[Any], NDArray[Any]]:
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
    is_new = np.append(True, np.diff(different) > margin)
    return different[is_new], (np.cumsum(is_new) - 1)[index]


def _without_gaps(rows: _Rows) -> _Rows:
    """Return the rows in which no number is missing; those that are left out are counted."""
    numbers = [name for name in (*AXES, *SPEEDS) if name in rows.columns]
    is_whole = ~np.any([np.isnan(rows.columns[name]) for name in numbers], axis=0)
    n_gaps = int(np.count_nonzero(~is_whole))
    if n_gaps == 0:
        return rows
    if not np.any(is_whole):
        empty = [name for name in numbers if np.all(np.isnan(rows.columns[name]))]
        found = f"no number of {empty[0]!r}" if empty else "a number that is missing in every row"
        refuse_data(rows.where, found, "rows with all numbers")
    share = n_gaps / is_whole.size
    remark = f"{n_gaps} rows ({share:.2g} of all) in which a number is missing are left out."
    return rows.select(is_whole, remark)


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
    n_axes = sum(name in rows.columns for name in AXES)
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
    labels: dict[str, Any] = {}
    for name in IDENTITY_LABELS:
        if name in rows.columns:
            labels[name] = rows.columns[name][row_of_tracer]
    return Tracks(
        times=rows.times / options.units.time,
        place=place,
        velocity=velocity,
        file=rows.file[row_of_tracer],
        remarks=rows.remarks,
        **labels,
    )


def _tracer_numbers(rows: _Rows) -> tuple[NDArray[Any], int]:
    """Return a number for the tracer of each row, and how many there are.

    Labels of one file, or medium, are not those of another. Without labels the k-th row of each
    time is taken for the same tracer.
    """
    names = (*IDENTITY_LABELS, RANK)
    labels = {name: rows.columns[name] for name in names if name in rows.columns}
    labels["file"] = rows.file
    number = np.zeros(rows.time_index.size, np.int64)
    for values in labels.values():
        code, different = pd.factorize(values, sort=True)
        number = number * len(different) + code
    number, different = pd.factorize(number, sort=True)
    n_tracers = len(different)
    if "tracer" in rows.columns and n_tracers == number.size and rows.times.size > 1:
        allowed = "labels that stay with a tracer (--columns tracer=...), or none"
        refuse_data(f"{rows.where}: tracer", "another label in every row", allowed)
    return number, n_tracers


def _check_one_row_each(rows: _Rows, cell: NDArray[Any]) -> None:
    """Raise InputError where a tracer has two rows at one time."""
    filled = np.bincount(cell)
    if filled.max() <= 1:
        return
    row = int(np.argmax(filled[cell] > 1))
    names = [name for name in IDENTITY_LABELS if name in rows.columns]
    tracer = " of ".join(f"{name} {rows.columns[name][row]}" for name in names)
    time = rows.columns["time"][row]
    refuse_data(rows.where, f"more than one row of {tracer} at time {time:g}", "one for each time")


def _vectors(
    rows: _Rows, names: Sequence[str], cell: NDArray[Any], shape: tuple[int, int]
) -> NDArray[Any]:
    """Return vectors of shape (n_times, n, d), NaN where there is no row."""
    components = [rows.columns[name] for name in names if name in rows.columns]
    vectors = np.full((shape[0] * shape[1], len(components)), np.nan)
    vectors[cell] = np.stack(components, axis=-1)
    return vectors.reshape(*shape, -1)


def _check_sizes(where: str, place: NDArray[Any], velocity: NDArray[Any] | None) -> None:
    """Raise InputError for numbers whose fourth powers are out of range."""
    far = float(np.nanmax(np.abs(place), initial=0.0))
    fast = 0.0 if velocity is None else float(np.nanmax(np.abs(velocity), initial=0.0))
    if max(far, fast) > MAX_SIZE:
        got = f"speeds of {fast:.3g} U and displacements of {far:.3g} d"
        refuse_data(where, got, f"below {MAX_SIZE:g}; give --speed-unit and --diameter")


# -- places relative to the start ------------------------------------------------------------------


def displacements(tracks: Tracks, where: str, options: DataOptions) -> Tracks:
    """Return tracks whose places are displacements from time 0.

    Places that are so already are returned as they are; of others the first time is time 0.
    InputError for positions that are wrapped in a box.
    """
    if tracks.velocity is None:
        return _from_own_start(tracks, where, options)
    if not _are_absolute(tracks, options):
        return tracks
    if tracks.tracer is None:
        refuse_data(f"{where}: positions", "absolute", "with a column tracer")
    remarks = list(tracks.remarks)
    times = tracks.times
    if times[0] != 0:
        times = times - times[0]
        remarks.append(
            f"The first time is {tracks.times[0]:.4g} d/U: it is taken for the start, time 0."
        )
    has_start = np.isfinite(tracks.place[0, :, 0])
    n_late = int(np.count_nonzero(~has_start))
    if n_late == tracks.n_tracers:
        refuse_data(f"{where}: positions", "no tracer at the first time", "some")
    started = tracks.select_tracers(has_start)
    if n_late:
        remarks.append(f"{n_late} tracers that are not there at the first time are left out.")
    place = started.place - started.place[0]
    _check_not_wrapped(started, place, where)
    if options.positions == "auto":
        remarks.append("Each tracer's own place at time 0, not the origin, was subtracted.")
    has_tracers = np.any(np.isfinite(place[:, :, 0]), axis=1)
    assert started.velocity is not None
    return replace(
        started,
        times=times[has_tracers],
        place=place[has_tracers],
        velocity=started.velocity[has_tracers],
        remarks=tuple(remarks),
    )


def _from_own_start(tracks: Tracks, where: str, options: DataOptions) -> Tracks:
    """Return tracks without velocities: times from the first frame, places from each one's first.

    Displacements that are said to begin at time 0, where no frame is, get that frame.
    """
    if tracks.tracer is None:
        refuse_data(f"{where}: positions alone", "no column tracer", "with one")
    remarks = list(tracks.remarks)
    times = tracks.times
    place = tracks.place
    if options.positions == "displacement" and times[0] > 0:
        times = np.append(0.0, times)
        place = np.concatenate([np.zeros_like(place[:1]), place])
    if times.size < 2:
        refuse_data(f"{where}: positions alone", "one frame", "at two times at least")
    if times[0] != 0:
        remarks.append(f"The first frame is at {times[0]:.4g} d/U: it is taken for time 0.")
        times = times - times[0]
    is_there = np.isfinite(place[:, :, 0])
    n_late = int(np.count_nonzero(~is_there[0]))
    if n_late:
        remarks.append(
            f"{n_late} tracks begin after the first frame. One clock is taken for all: time 0 is "
            "the first frame."
        )
    first_frame = np.argmax(is_there, axis=0)
    first_place = place[first_frame, np.arange(tracks.n_tracers)]
    _check_not_wrapped(tracks, place - first_place, where)
    return replace(tracks, times=times, place=place - first_place, remarks=tuple(remarks))


def _are_absolute(tracks: Tracks, options: DataOptions) -> bool:
    """Return whether places are absolute, as is said, or as the first of them show."""
    if options.positions != "auto":
        return options.positions == "absolute"
    mean_square = np.nanmean(np.sum(tracks.place**2, axis=2), axis=1)
    if tracks.times[0] == 0 or tracks.velocity is None:
        return bool(mean_square[0] > ROUNDING_OF_PLACE * mean_square.max())
    if tracks.times[0] > TIME_STAMP_OVER_DURATION * (tracks.times[-1] - tracks.times[0]):
        return True
    speeds = np.sqrt(np.sum(tracks.velocity[0] ** 2, axis=1))
    farthest = FURTHER_THAN_SPEED * float(np.nanmax(speeds)) * tracks.times[0]
    median_distance = float(np.nanmedian(np.sqrt(np.sum(tracks.place[0] ** 2, axis=1))))
    return median_distance > farthest


def _check_not_wrapped(tracks: Tracks, place: NDArray[Any], where: str) -> None:
    """Raise InputError where no tracer leaves the region of time 0, though many would.

    Of n tracers, about n times their root mean square displacement over the side would leave it.
    Where as many tracks end, the region is a picture, and those that leave it are not seen.
    """
    n = tracks.n_tracers
    n_ended = np.count_nonzero(np.isnan(tracks.place[-1, :, 0]))
    if n_ended >= MIN_LEAVING:
        return
    low = np.nanmin(tracks.place[0], axis=0)
    high = np.nanmax(tracks.place[0], axis=0)
    smallest_side = float((high - low).min())
    mean_square = np.nanmean(np.sum(place**2, axis=2), axis=1)
    distance = float(np.sqrt(np.nanmax(mean_square)))
    # the farthest tracer is not quite at the edge of the region that they come from
    from_middle = np.nanmax(np.abs(tracks.place - (low + high) / 2), axis=(0, 1))
    all_stay = np.all(from_middle <= (high - low) * (0.5 + EDGE_TRACERS / n))
    if all_stay and n * distance >= MIN_LEAVING * smallest_side > 0:
        region = f"within {low} to {high} d, moved by {distance:.4g} d"
        got = f"some that look wrapped in a box, {region}"
        refuse_data(f"{where}: positions", got, "unwrapped")
