"""From rows to a sample: sums over groups, made while the pieces of a file pass by."""

from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import Rows
from kinetics.crosscheck.comparison.data.labels import Repeats
from kinetics.crosscheck.comparison.result import said
from kinetics.crosscheck.comparison.sample import Binned, Flights, Sample, StartBins
from kinetics.crosscheck.comparison.units import straight_flights
from kinetics.errors import InputError

MOST_GROUPS = 251
"""Groups that tracers or configurations are gathered in, at most: a prime, so that labels with a
regular pattern spread over all of them. The relative error of a standard error from G groups is
1/sqrt(2 G), here 4.5 %: more groups would hardly make it better known."""
HISTOGRAM_GROUPS = 83
"""The same for the counts in bins, which take most of the memory: 8 %, and still four groups for
each of 20 bins (statistics.GROUPS_PER_FREEDOM)."""
MOST_TIMES = 400
"""Different times that data may have: bounds the memory, by 50 MB for the counts in bins."""
SAME_TIME = 1e-9
"""Relative difference below which two times are one: far above the rounding of times that are
written with 12 digits or more."""

LOWEST, PER_OCTAVE, BINS = -10, 12, 192
"""Bins of speeds and displacements: log2 of the lowest edge over the root mean square, bins per
octave, their number: edges 6 % apart, from a thousandth of the root mean square to 64 times it."""
_ROUNDING = 1e-9
_START_PER_OCTAVE, _START_LOWEST, _START_BINS = 64, -30, 64 * 40


def _bins(values: Any, lowest: float, per_octave: float, bins: int) -> Any:
    """The bin of each value: 0 below the bins (or zero), bins + 1 above them."""
    with np.errstate(divide="ignore"):
        place = np.floor((np.log2(values) - lowest) * per_octave)
    return np.clip(place, -1, bins).astype(np.int64) + 1


class Reduction:
    """Sums that rows are added to, piece by piece; memory depends on the number of times alone.

    (Besides the labels of tracers, see `data.labels.Repeats`.) Rows may come in any order.

    grouping : what a group is made of: "medium", "tracer", or "row": then the k-th row of each time
        is taken for the same tracer
    same_time : relative difference below which two times are one, which is then at their mean
    with_field : whether to keep the sums of a field
    """

    def __init__(
        self, grouping: str, same_time: float = SAME_TIME, with_field: bool = False
    ) -> None:
        self.grouping, self._same_time, self._with_field = grouping, same_time, with_field
        self._times = np.empty(0)  # in the order in which they came, as everything by time
        self._time_sums, self._latest = np.zeros((2, MOST_TIMES))
        self._earliest = np.full(MOST_TIMES, np.inf)
        self._sums = np.zeros((MOST_TIMES, MOST_GROUPS, 8 if with_field else 5))
        self._speeds = self._displacements = np.zeros((0, HISTOGRAM_GROUPS, BINS + 2), np.int32)
        self._at_rest, self._rows_at = np.zeros((2, MOST_TIMES), np.int64)
        self._speed_scale, self._length_scale = np.ones((2, MOST_TIMES))
        self._start_counts = np.zeros((MOST_GROUPS, _START_BINS + 2), np.int64)
        self._start_powers = np.zeros((2, _START_BINS + 2))
        self._repeats = Repeats()
        self._flights: Flights | None = None

    def add(self, rows: Rows, file: int = 0) -> None:
        """Add a piece; labels of different files are different tracers and configurations.

        InputError for a negative time or too many times.
        """
        if rows.time.size == 0:
            return
        if rows.time.min() < 0:
            raise InputError(f"time: got {rows.time.min():g}; times must not be negative")
        at = self._time_indices(rows)
        if rows.tracer is not None:
            self._repeats.add(rows, at, file)
        group = self._groups(rows, at, file)
        with np.errstate(over="ignore", under="ignore"):
            v = _length(rows.velocity) / self._speed_scale[at]
            r = _length(rows.position) / self._length_scale[at]
            v2, r2 = v * v, r * r
            powers = [None, v2, v2 * v2, r2, r2 * r2]
            if self._with_field:
                x = rows.x / self._length_scale[at]
                powers += [rows.vx / self._speed_scale[at], x, x * x]
        place, cells = at * MOST_GROUPS + group, MOST_TIMES * MOST_GROUPS
        for k, power in enumerate(powers):
            self._sums[:, :, k] += np.bincount(place, power, cells).reshape(-1, MOST_GROUPS)
        if self._same_time > SAME_TIME:
            self._time_sums += np.bincount(at, rows.time, MOST_TIMES)
            np.minimum.at(self._earliest, at, rows.time)
            np.maximum.at(self._latest, at, rows.time)
        self._at_rest += np.bincount(at[v == 0], minlength=MOST_TIMES)
        row = (at * HISTOGRAM_GROUPS + group % HISTOGRAM_GROUPS) * (BINS + 2)
        for counts, values in ((self._speeds, v), (self._displacements, r)):
            np.add.at(
                counts.reshape(-1), row + _bins(values, LOWEST, PER_OCTAVE, BINS), np.int32(1)
            )
        if self._times.min() == 0:
            first = at == np.argmin(self._times)
            self._add_start(v[first], group[first])

    def _add_start(self, v: Any, group: Any) -> None:
        """Speeds at time 0 in units of their scale, and their groups, (n,)."""
        place = _bins(v, _START_LOWEST, _START_PER_OCTAVE, _START_BINS)
        np.add.at(self._start_counts, (group, place), 1)
        for k, power in enumerate((2, 4)):
            with np.errstate(over="ignore", under="ignore"):
                self._start_powers[k] += np.bincount(place, v**power, _START_BINS + 2)

    @property
    def moved_at_zero(self) -> bool:
        """Whether positions at time 0 are not the origin, rounding apart."""
        squares, rows = self._sums[:, :, 3].sum(axis=1), self._sums[:, :, 0].sum(axis=1)
        size = (np.sqrt(squares / np.maximum(rows, 1)) * self._length_scale)[: self._times.size]
        return bool(np.any(size[self._times == 0] > _ROUNDING * size.max(initial=0.0)))

    def _time_indices(self, rows: Rows) -> Any:
        """The index of the time of each row among the known times, (n,); new times are entered."""
        while np.any(unknown := (at := self._located(rows.time)) < 0):
            new = np.unique(rows.time[unknown])
            self._enter(_apart(new, self._same_time), rows)
        return at

    def _located(self, time: Any) -> Any:
        """The index of the known time that is nearest to each, -1 where none is the same."""
        if not self._times.size:
            return np.full(time.size, -1)
        order = np.argsort(self._times)
        known = self._times[order]
        k = np.searchsorted(known[:-1] / 2 + known[1:] / 2, time)
        return np.where(np.abs(known[k] - time) <= self._same_time * time, order[k], -1)

    def _enter(self, new: Any, rows: Rows) -> None:
        """Enter new times; the first rows of a time give the scale of its bins."""
        if self._times.size + new.size > MOST_TIMES:
            raise InputError(
                f"time: more than {MOST_TIMES} different times; every tracer must be given at the "
                "same few times"
            )
        for k, t in enumerate(new, self._times.size):
            first = np.flatnonzero(np.abs(rows.time - t) <= self._same_time * t)[:10_000]
            position, velocity = (
                tuple(axis[first] for axis in parts) for parts in (rows.position, rows.velocity)
            )
            self._speed_scale[k] = _root_mean_square(velocity)
            self._length_scale[k] = _root_mean_square(position)
            found = straight_flights(rows.time[first], _length(position), _length(velocity))
            # The time at which most tracers still fly straight.
            if found and (self._flights is None or found.share > self._flights.share):
                self._flights = found
        self._times = np.concatenate([self._times, new])
        room = np.zeros((new.size, HISTOGRAM_GROUPS, BINS + 2), np.int32)
        self._speeds = np.concatenate([self._speeds, room])
        self._displacements = np.concatenate([self._displacements, room])

    def _groups(self, rows: Rows, at: Any, file: int) -> Any:
        label = rows.medium if self.grouping == "medium" else rows.tracer
        if self.grouping == "row" or label is None:
            label = _ranks(at, self._rows_at)
        # Another file's labels begin elsewhere, so that small runs do not fall on each other.
        return (label % MOST_GROUPS + 97 * file) % MOST_GROUPS

    def sample(self, names: tuple[str, ...]) -> Sample:
        """What was added, in the units of the data.

        InputError if nothing was, or if a tracer has two rows at one time.
        """
        if self._times.size == 0:
            raise InputError(f"{', '.join(names)}: has no rows; at least two tracers are needed")
        self._repeats.check(self._times)
        count = self._times.size
        times, warnings = self._times, tuple[str, ...]()
        if self._same_time > SAME_TIME:
            times = self._time_sums[:count] / self._sums[:count, :, 0].sum(axis=1)
            span = self._latest[:count] - self._earliest[:count]
            k = int(np.argmax(span / np.where(times > 0, times, 1.0)))
            warnings = (
                said("binned", within=self._same_time, count=count, low=self._earliest[k],
                     high=self._latest[k], mean=times[k]),
            )  # fmt: skip
        used = self._sums[:, :, 0].sum(axis=0) > 0
        speed_scale, length_scale = self._speed_scale[:count], self._length_scale[:count]

        def binned(counts: Any, scale: Any) -> Binned:
            by_group = counts[:, counts.sum(axis=(0, 2)) > 0].swapaxes(0, 1)
            edges = scale[:, None] * 2.0 ** (LOWEST + np.arange(BINS + 1) / PER_OCTAVE)
            return Binned(edges, by_group.sum(axis=0, dtype=np.int64), by_group)

        start = None
        if self._times.min() == 0:
            moving = self._start_powers[0] > 0
            counts = self._start_counts[:, moving]
            squares, quartics = self._start_powers[:, moving] / counts.sum(axis=0)
            unit = speed_scale[np.argmin(self._times)]
            start = StartBins(squares * unit**2, quartics / squares**2, counts[used])
        return Sample(
            names=names,
            times=times,
            sums=self._sums[:count, used].swapaxes(0, 1),
            speed_scale=speed_scale,
            length_scale=length_scale,
            speeds=binned(self._speeds, speed_scale),
            displacements=binned(self._displacements, length_scale),
            start=start,
            at_rest=self._at_rest[:count],
            grouping=self.grouping,
            flights=self._flights,
            warnings=warnings,
        ).at(np.argsort(times))


def _apart(times: Any, same_time: float) -> Any:
    """Those of the rising times that are no nearer to the one before than this fraction."""
    found, last = [], -1.0
    if same_time <= SAME_TIME:
        return times[np.diff(times, prepend=-1.0) > same_time * times]
    for time in times.tolist():
        if time - last > same_time * time:
            found.append(time)
            last = time
    return np.array(found)


def _length(vector: Any) -> Any:
    """The length of vectors from their components, (n,) each."""
    plane = np.hypot(*vector[:2])
    return plane if len(vector) == 2 else np.hypot(plane, vector[2])


def _ranks(at: Any, rows_at: Any) -> Any:
    """The number of each row among those of its time; rows_at counts on from piece to piece."""
    order = np.argsort(at, kind="stable")
    counts = np.bincount(at, minlength=rows_at.size)
    first = np.cumsum(counts) - counts
    out = np.empty(at.size, np.int64)
    out[order] = np.arange(at.size) - first[at[order]] + rows_at[at[order]]
    rows_at += counts
    return out


def _root_mean_square(vector: Any) -> float:
    """Rounded to a power of 2, so that it hardly depends on which rows come first."""
    largest = max(float(np.abs(part).max()) for part in vector)
    if largest == 0.0:
        return 1.0
    with np.errstate(under="ignore"):
        squares = sum((part / largest) ** 2 for part in vector)
        size = np.log2(np.mean(squares)) / 2 + np.log2(largest)
    return float(2.0 ** np.clip(np.round(size), -1000, 1000))
