"""From rows to a sample: sums over groups, made while the pieces of a file pass by."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numba import njit

from kinetics.crosscheck.comparison.data.columns import Rows
from kinetics.crosscheck.comparison.data.labels import Seen
from kinetics.crosscheck.comparison.sample import (
    BINS,
    LOWEST,
    PER_OCTAVE,
    Binned,
    Sample,
    StartBins,
    bin_edges,
)
from kinetics.errors import InputError

MOST_GROUPS = 251
"""Groups that tracers or configurations are gathered in, at most: a prime, so that labels with a
regular pattern spread over all of them. More would not make a standard error better known."""
HISTOGRAM_GROUPS = 83
"""The same for the counts in bins, which take most of the memory."""
MOST_TIMES = 400
"""Different times that data may have: bounds the memory."""
SAME_TIME = 1e-9
"""Relative difference below which two times are one."""

_ROUNDING = 1e-9
_START_PER_OCTAVE, _START_LOWEST, _START_BINS = 64, -30, 64 * 40


@njit(cache=True, nogil=True)
def _locate(times: Any, known: Any, order: Any, tolerance: float, out: Any) -> int:
    """The index of each time among the known ones (sorted; order: their indices), -1 if new."""
    last, new = 0, 0
    for i in range(times.size):
        t = times[i]
        if last < known.size and abs(known[last] - t) <= tolerance * t:
            out[i] = order[last]
            continue
        k = np.searchsorted(known, t)
        if k > 0 and (k == known.size or t - known[k - 1] < known[k] - t):
            k -= 1
        if k < known.size and abs(known[k] - t) <= tolerance * t:
            out[i], last = order[k], k
        else:
            out[i] = -1
            new += 1
    return new


@njit(cache=True, nogil=True, error_model="numpy")
def _bin(value: float, lowest: float, per_octave: float, bins: int) -> int:
    """0 for what is below the bins (or zero), bins + 1 for what is above."""
    if not value > 0.0:
        return 0
    return int(min(max(np.floor((np.log2(value) - lowest) * per_octave), -1.0), bins)) + 1


@njit(cache=True, nogil=True, error_model="numpy")
def _accumulate(
    at: Any, group: Any, x: Any, y: Any, vx: Any, vy: Any, speed_scale: Any, length_scale: Any,
    sums: Any, speeds: Any, displacements: Any, at_rest: Any,
) -> None:  # fmt: skip
    for i in range(at.size):
        k, g = at[i], group[i]
        v = np.hypot(vx[i], vy[i]) / speed_scale[k]
        r = np.hypot(x[i], y[i]) / length_scale[k]
        v2, r2 = v * v, r * r
        sums[k, g, 0] += 1.0
        sums[k, g, 1] += v2
        sums[k, g, 2] += v2 * v2
        sums[k, g, 3] += r2
        sums[k, g, 4] += r2 * r2
        at_rest[k] += v == 0.0
        h = g % speeds.shape[1]
        speeds[k, h, _bin(v, LOWEST, PER_OCTAVE, BINS)] += 1
        displacements[k, h, _bin(r, LOWEST, PER_OCTAVE, BINS)] += 1


@njit(cache=True, nogil=True, error_model="numpy")
def _start(
    at: Any, zero: int, scale: float, group: Any, vx: Any, vy: Any, counts: Any, powers: Any
) -> None:
    for i in range(at.size):
        if at[i] == zero:
            v = np.hypot(vx[i], vy[i]) / scale
            k = _bin(v, _START_LOWEST, _START_PER_OCTAVE, _START_BINS)
            counts[group[i], k] += 1
            powers[0, k] += v * v
            powers[1, k] += v * v * v * v


class Reduction:
    """Sums that rows are added to, piece by piece; memory depends on the number of times alone.

    `grouping` says what a group is made of: "medium", "tracer", or "row": then the k-th row of
    each time is taken for the same tracer. Rows may come in any order.
    """

    def __init__(self, grouping: str) -> None:
        self.grouping = grouping
        self._known = np.empty(0)
        self._sums = np.zeros((0, MOST_GROUPS, 5))
        self._speeds = np.zeros((0, HISTOGRAM_GROUPS, BINS + 2), np.int32)
        self._displacements = np.zeros((0, HISTOGRAM_GROUPS, BINS + 2), np.int32)
        self._at_rest = np.zeros(0, np.int64)
        self._speed_scale = np.ones(0)
        self._length_scale = np.ones(0)
        self._rows_at = np.zeros(0, np.int64)
        self._start_counts = np.zeros((MOST_GROUPS, _START_BINS + 2), np.int64)
        self._start_powers = np.zeros((2, _START_BINS + 2))
        self._seen = Seen()

    def add(self, rows: Rows, file: int = 0) -> None:
        """Add a piece; labels of different files are different tracers and configurations.

        InputError for a negative time, too many times, or two rows of a tracer at one time.
        """
        if rows.time.size == 0:
            return
        if rows.time.min() < 0:
            raise InputError(f"time: got {rows.time.min():g}; times must not be negative")
        at = self._indices(rows)
        if rows.tracer is not None:
            self._seen.add(rows, at, self._known, file)
        group = self._groups(rows, at, file)
        x, y, vx, vy = (np.ascontiguousarray(c) for c in (rows.x, rows.y, rows.vx, rows.vy))
        _accumulate(
            at, group, x, y, vx, vy, self._speed_scale, self._length_scale,
            self._sums, self._speeds, self._displacements, self._at_rest,
        )  # fmt: skip
        if self._known.min() == 0:
            zero = int(np.argmin(self._known))
            scale = float(self._speed_scale[zero])
            _start(at, zero, scale, group, vx, vy, self._start_counts, self._start_powers)

    @property
    def moved_at_zero(self) -> bool:
        """Whether positions at time 0 are not the origin, rounding apart."""
        squares, rows = self._sums[:, :, 3].sum(axis=1), self._sums[:, :, 0].sum(axis=1)
        size = np.sqrt(squares / np.maximum(rows, 1)) * self._length_scale
        return bool(np.any(size[self._known == 0] > _ROUNDING * size.max()))

    def _indices(self, rows: Rows) -> Any:
        at = np.empty(rows.time.size, np.int64)
        time = np.ascontiguousarray(rows.time)
        order = np.argsort(self._known)
        if _locate(time, self._known[order], order, SAME_TIME, at):
            self._enlarge(_distinct(np.unique(time[at < 0])), rows)
            order = np.argsort(self._known)
            _locate(time, self._known[order], order, SAME_TIME, at)
        return at

    def _enlarge(self, new: Any, rows: Rows) -> None:
        """Make room for new times; the first rows of a time give the scale of its bins."""
        count = self._known.size + new.size
        if count > MOST_TIMES:
            raise InputError(
                f"time: more than {MOST_TIMES} different times; every tracer must be given at the "
                "same few times"
            )
        self._known = np.concatenate([self._known, new])
        for name in ("sums", "speeds", "displacements", "at_rest", "rows_at"):
            old = getattr(self, f"_{name}")
            room = np.zeros((new.size, *old.shape[1:]), old.dtype)
            setattr(self, f"_{name}", np.concatenate([old, room]))
        speed, length = np.ones(new.size), np.ones(new.size)
        for k, t in enumerate(new):
            first = np.flatnonzero(np.abs(rows.time - t) <= SAME_TIME * t)[:10_000]
            speed[k] = _root_mean_square(rows.vx[first], rows.vy[first])
            length[k] = _root_mean_square(rows.x[first], rows.y[first])
        self._speed_scale = np.concatenate([self._speed_scale, speed])
        self._length_scale = np.concatenate([self._length_scale, length])

    def _groups(self, rows: Rows, at: Any, file: int) -> Any:
        label = rows.medium if self.grouping == "medium" else rows.tracer
        if self.grouping == "row" or label is None:
            label = _ranks(at, self._rows_at)
        # Another file's labels begin elsewhere, so that small runs do not fall on each other.
        return (label % MOST_GROUPS + 97 * file) % MOST_GROUPS

    def sample(self, names: tuple[str, ...], warnings: Iterable[str] = ()) -> Sample:
        """What was added, in the units of the data. InputError if nothing was."""
        if self._known.size == 0:
            raise InputError(f"{', '.join(names)}: has no rows; at least two tracers are needed")
        order = np.argsort(self._known)
        used = self._sums[:, :, 0].sum(axis=0) > 0

        def binned(counts: Any, scale: Any) -> Binned:
            there = np.flatnonzero(counts.sum(axis=(0, 2)) > 0)
            by_group = counts.swapaxes(0, 1)[np.ix_(there, order)]
            return Binned(bin_edges(scale[order]), by_group.sum(axis=0, dtype=np.int64), by_group)

        start = None
        if self._known.min() == 0:
            count = self._start_counts.sum(axis=0)
            moving = self._start_powers[0] > 0
            squares, quartics = self._start_powers[:, moving] / count[moving]
            unit = self._speed_scale[order][0]
            start = StartBins(
                squares * unit**2, quartics / squares**2, self._start_counts[:, moving][used]
            )
        return Sample(
            names=names,
            times=self._known[order],
            sums=self._sums[order][:, used].swapaxes(0, 1),
            speed_scale=self._speed_scale[order],
            length_scale=self._length_scale[order],
            speeds=binned(self._speeds, self._speed_scale),
            displacements=binned(self._displacements, self._length_scale),
            start=start,
            at_rest=self._at_rest[order],
            grouping=self.grouping,
            warnings=tuple(warnings),
        )


@njit(cache=True, nogil=True)
def _ranks(at: Any, rows_at: Any) -> Any:
    """The number of each row among those of its time; rows_at counts on from piece to piece."""
    out = np.empty(at.size, np.int64)
    for i in range(at.size):
        out[i] = rows_at[at[i]]
        rows_at[at[i]] += 1
    return out


def _distinct(times: Any) -> Any:
    """Sorted times without those that are one with the one before."""
    kept = [times[0]]
    for t in times[1:]:
        if t - kept[-1] > SAME_TIME * t:
            kept.append(t)
        if len(kept) > MOST_TIMES + 1:
            break
    return np.array(kept)


def _root_mean_square(x: Any, y: Any) -> float:
    """Rounded to a power of 2, so that it hardly depends on which rows come first."""
    largest = max(float(np.abs(x).max()), float(np.abs(y).max()))
    if largest == 0.0:
        return 1.0
    with np.errstate(under="ignore"):
        size = np.log2(np.mean((x / largest) ** 2 + (y / largest) ** 2)) / 2 + np.log2(largest)
    return float(2.0 ** np.clip(np.round(size), -1000, 1000))
