"""Which tracers have been seen at which time: a tracer may have one row at one time."""

from typing import Any

import numpy as np
from numba import njit

from kinetics.crosscheck.comparison.data.columns import Rows
from kinetics.errors import InputError

_FIRST_SIZE, _LARGEST_SIZE = 1 << 16, 1 << 23
_LOAD = 0.6
_SAMPLING = np.uint64(0xFFFF)  # bits of a key that depend on the tracer alone


@njit(cache=True, nogil=True)
def mixed(value: Any) -> Any:
    """A 64-bit number scrambled one to one (the finaliser of splitmix64)."""
    z = np.uint64(value) + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit(cache=True, nogil=True)
def tracer_keys(tracer: Any, medium: Any, file: int) -> Any:
    """One number for each tracer of each configuration of each file."""
    out = np.empty(tracer.size, np.uint64)
    for i in range(tracer.size):
        own = mixed(medium[i]) if medium.size else np.uint64(0)
        out[i] = mixed(mixed(np.uint64(tracer[i])) + own + mixed(np.uint64(file) << np.uint64(32)))
    return out


@njit(cache=True, nogil=True)
def _enter(table: Any, keys: Any, at: Any, first: int, mask: Any, used: Any, most: int) -> int:
    """Enter rows from `first` on; returns the row that is there already, or ~row at a full table.

    All rows entered: keys.size.
    """
    size = np.uint64(table.size - 1)
    for i in range(first, keys.size):
        if keys[i] & mask:
            continue
        if used[0] >= most:
            return ~i
        key = (mixed(keys[i] + mixed(np.uint64(at[i]))) & ~_SAMPLING) | (keys[i] & _SAMPLING)
        if key == 0:
            key = _SAMPLING + np.uint64(1)
        place = mixed(key) & size
        while table[place] != 0 and table[place] != key:
            place = (place + np.uint64(1)) & size
        if table[place] == key:
            return i
        table[place] = key
        used[0] += 1
    return keys.size


@njit(cache=True, nogil=True)
def _reenter(old: Any, table: Any, mask: Any, used: Any) -> None:
    size = np.uint64(table.size - 1)
    for key in old:
        if key == 0 or key & mask:
            continue
        place = mixed(key) & size
        while table[place] != 0:
            place = (place + np.uint64(1)) & size
        table[place] = key
        used[0] += 1


class Seen:
    """A set of (tracer, time), of 64 MB at most: beyond 5 million, of a sample of the tracers."""

    def __init__(self) -> None:
        self._table = np.zeros(_FIRST_SIZE, np.uint64)
        self._used = np.zeros(1, np.int64)
        self._mask = np.uint64(0)

    def add(self, rows: Rows, at: Any, times: Any, file: int) -> None:
        """InputError for a tracer that has a row at its time already."""
        assert rows.tracer is not None
        medium = np.empty(0, np.int64) if rows.medium is None else rows.medium
        keys = tracer_keys(rows.tracer, medium, file)
        row = 0
        while row < keys.size:
            most = int(_LOAD * self._table.size)
            row = _enter(self._table, keys, at, row, self._mask, self._used, most)
            if row < 0:
                row = ~row
                self._make_room()
            elif row < keys.size:
                who = f"tracer {rows.tracer[row]}"
                who += "" if rows.medium is None else f" of medium {rows.medium[row]}"
                raise InputError(
                    f"{who} has more than one row at time {times[at[row]]:g}; "
                    "each tracer may have one row at each time"
                )

    def _make_room(self) -> None:
        """A larger table, or where it is the largest, half of the tracers."""
        old, size = self._table, self._table.size
        if size < _LARGEST_SIZE:
            size *= 4
        else:
            self._mask = np.uint64(2) * self._mask + np.uint64(1)
        self._table = np.zeros(min(size, _LARGEST_SIZE), np.uint64)
        self._used[0] = 0
        _reenter(old, self._table, self._mask, self._used)
