"""Positions that were wrapped at the edges of a periodic box, made continuous again.

Speeds never rise without a field, so that between two frames a tracer moves by |v| dt at most, v
its velocity in the first of them. Where that is less than half the box, its way is known without
doubt: the shortest one. Positions that were not wrapped stay as they are.
"""

from typing import Any

import numpy as np

from kinetics.crosscheck.comparison.data.columns import Rows


class TooLong(Exception):
    """A tracer may have moved by half the box or more between two frames."""


class Unwrapping:
    """Follows each tracer of one file from frame to frame, in the order of time."""

    def __init__(self) -> None:
        self.crossed = False  # whether a tracer has gone through an edge
        self._file = -1

    def of(self, rows: Rows, file: int) -> Rows:
        """The rows at continuous positions, if their box is known. TooLong where that is in doubt.

        All rows have one time, or are parts of a frame.
        """
        if rows.box is None or rows.tracer is None or not rows.tracer.size:
            return rows
        if file != self._file:
            self._file, self._ids = file, np.empty(0, np.int64)
            # Of each known tracer: position in the file, what was added to it, speed and time.
            self._place, self._added = np.empty((2, len(rows.position), 0))
            self._speed, self._time = np.empty((2, 0))
        place, length = np.stack(rows.position), np.array(rows.box)[: len(rows.position), None]
        added = np.zeros(place.shape)
        k, known = self._found(rows.tracer)
        k = k[known]
        if k.size:
            elapsed = rows.time[known] - self._time[k]
            if np.any(elapsed < 0) or np.any(self._speed[k] * elapsed >= length.min() / 2):
                raise TooLong
            edges = np.round((self._place[:, k] - place[:, known]) / length)
            added[:, known] = self._added[:, k] + edges * length
            self.crossed = self.crossed or bool(np.any(edges))
        self._remember(rows, place, added)
        return rows.at(place + added)

    def _found(self, tracers: Any) -> tuple[Any, Any]:
        """The place of each tracer among the known ones, and whether it is one of them."""
        k = np.minimum(np.searchsorted(self._ids, tracers), max(self._ids.size - 1, 0))
        return k, (self._ids[k] == tracers if self._ids.size else np.zeros(k.size, bool))

    def _remember(self, rows: Rows, place: Any, added: Any) -> None:
        assert rows.tracer is not None
        k, known = self._found(rows.tracer)
        if not np.all(known):
            new = rows.tracer[~known]
            ids = np.concatenate([self._ids, new])
            order = np.argsort(ids, kind="stable")
            room = np.zeros((len(place), new.size))
            self._ids = ids[order]
            self._place, self._added = (
                np.concatenate([old, room], axis=1)[:, order] for old in (self._place, self._added)
            )
            self._speed, self._time = (
                np.concatenate([old, room[0]])[order] for old in (self._speed, self._time)
            )
            k, _ = self._found(rows.tracer)
        self._place[:, k], self._added[:, k], self._time[k] = place, added, rows.time
        self._speed[k] = np.linalg.norm(np.stack(rows.velocity), axis=0)
