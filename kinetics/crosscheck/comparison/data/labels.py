"""Labels of tracers and configurations, compared column by column: exactly, without hashes.

A tracer is named by three whole numbers: the file, the configuration (0 where unknown), its label.
"""

from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import Rows
from kinetics.errors import InputError

MOST_REMEMBERED = 10_000_000
"""Rows whose labels are remembered to find a tracer that comes twice at one time. Where there are
more, a part of the tracers is remembered, at all times: labels of 1e7 rows take 0.3 GB at most."""
MOST_ORIGINS = 4_000_000
"""Tracers whose place at time 0 is remembered, at most: some 0.2 GB."""


def columns_of(rows: Rows, file: int) -> tuple[Any, Any, Any]:
    """File, configuration and label of the tracer of each row, (n,) each."""
    assert rows.tracer is not None
    medium = np.zeros(rows.tracer.size, np.int64) if rows.medium is None else rows.medium
    return np.full(rows.tracer.size, file, np.int32), medium, rows.tracer


class Repeats:
    """Finds a tracer that has two rows at one time."""

    def __init__(self) -> None:
        self._kept: list[tuple[Any, ...]] = []
        self._count, self._every, self._media_known = 0, 1, False

    def add(self, rows: Rows, at: Any, file: int) -> None:
        """Remember rows, of which `at` is the index of the time, (n,)."""
        self._media_known = rows.medium is not None
        self._kept.append(self._chosen((*columns_of(rows, file), at.astype(np.int16))))
        self._count += self._kept[-1][0].size
        while self._count > MOST_REMEMBERED:
            self._every *= 2
            self._kept = [self._chosen(columns) for columns in self._kept]
            self._count = sum(columns[0].size for columns in self._kept)

    def _chosen(self, columns: tuple[Any, ...]) -> tuple[Any, ...]:
        """The rows of one tracer in `_every`; labels by 4 bytes where that is enough."""
        if self._every > 1:
            # Bits that depend on all of the label: labels may all be even.
            mixed = columns[2].astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15) >> np.uint64(40)
            mine = mixed % np.uint64(self._every) == 0
            columns = tuple(column[mine] for column in columns)
        return tuple(_narrow(column) for column in columns)

    def check(self, times: Any) -> None:
        """InputError if a tracer has two rows at one time."""
        if not self._count:
            return
        columns = [np.concatenate(parts) for parts in zip(*self._kept, strict=True)]
        keys = _combined(columns)
        ordered = np.sort(keys)
        twice = ordered[1:][ordered[1:] == ordered[:-1]]
        if twice.size:
            row = int(np.flatnonzero(keys == twice[0])[-1])
            _, medium, tracer, at = (int(column[row]) for column in columns)
            who = f"tracer {tracer}" + (f" of medium {medium}" if self._media_known else "")
            raise InputError(
                f"{who} has more than one row at time {times[at]:g}; "
                "each tracer may have one row at each time"
            )


def _narrow(column: Any) -> Any:
    if column.itemsize <= 4 or not column.size:
        return column
    fits = column.min() >= -(2**31) and column.max() < 2**31
    return column.astype(np.int32) if fits else column


def _combined(columns: list[Any]) -> Any:
    """One whole number per row, (n,): the same for two rows only if all columns are the same."""
    keys, size = np.zeros(columns[0].size, np.int64), 1
    for column in columns:
        low, high = int(column.min()), int(column.max())
        if high - low >= 2**32:
            column = np.unique(column, return_inverse=True)[1]
            low, high = 0, int(column.max())
        span = high - low + 1
        if size * span >= 2**63:
            keys = np.unique(keys, return_inverse=True)[1]
            size = int(keys.max()) + 1
        keys *= span
        keys += column
        keys -= low
        size *= span
    return keys


_WIDELY = 20.0
"""Tracers that must have left the region of time 0, were positions not wrapped: then that none
has is no chance."""


class Origins:
    """Where each tracer was at time 0, and whether all of them stay in that region."""

    def __init__(self, pieces: list[tuple[Rows, int]]) -> None:
        """From the rows at time 0 and the number of their file, piece by piece."""
        labels = zip(*(columns_of(rows, file) for rows, file in pieces), strict=True)
        self._labels = [np.concatenate(parts) for parts in labels]
        axes = zip(*(rows.position for rows, _ in pieces), strict=True)
        self._places = places = np.stack([np.concatenate(parts) for parts in axes])
        self._low, self._high = places.min(axis=1), places.max(axis=1)
        self.begin()

    def begin(self) -> None:
        """Begin to watch again, before the first of all rows."""
        self._left, self._largest = False, 0.0

    def of(self, rows: Rows, file: int) -> Any:
        """Where the tracer of each row was at time 0, (dimension, n); InputError if unknown."""
        both = zip(self._labels, columns_of(rows, file), strict=True)
        keys = _combined([np.concatenate(parts) for parts in both])
        known, wanted = np.split(keys, [self._places.shape[1]])
        order = np.argsort(known, kind="stable")  # quick, as most files are in order
        k = order[np.minimum(np.searchsorted(known, wanted, sorter=order), order.size - 1)]
        lost = np.flatnonzero(known[k] != wanted)
        if lost.size:
            assert rows.tracer is not None
            raise InputError(
                f"tracer {rows.tracer[lost[0]]} has no row at time 0; absolute positions need one"
            )
        self._watch(np.stack(rows.position), self._places[:, k])
        return self._places[:, k]

    def _watch(self, places: Any, origins: Any) -> None:
        """Whether any place is out of the region of time 0; mean squares of displacements."""
        if not places.size:
            return
        # The farthest tracer is not quite at the edge of the region that they come from.
        margin = 5 * (self._high - self._low) / self._places.shape[1]
        away = np.abs(places.T - (self._low + self._high) / 2)
        self._left = self._left or bool(np.any(away > (self._high - self._low) / 2 + margin))
        mean_square = np.mean(np.sum((places - origins) ** 2, axis=0))
        self._largest = max(self._largest, float(np.sqrt(mean_square)))

    def check_not_wrapped(self) -> None:
        """InputError where tracers move far, and yet none leaves the region of time 0."""
        size = float((self._high - self._low).min())
        if self._left or size <= 0 or self._places.shape[1] * self._largest < _WIDELY * size:
            return
        (x0, y0), (x1, y1) = self._low[:2], self._high[:2]
        raise InputError(
            "positions look wrapped at the edges of a box: they stay within "
            f"x = {x0:.4g} to {x1:.4g} and y = {y0:.4g} to {y1:.4g} at all times, though tracers "
            f"move by {self._largest:.4g}; write unwrapped positions or displacements, or (in a "
            "file that has the box) frames so often that no tracer moves by half of it in between"
        )
