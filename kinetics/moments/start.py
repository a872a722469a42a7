"""The initial state as weighted points of ln(v/U): those angular harmonics that averages need."""

from __future__ import annotations

import math
from collections.abc import Collection

from kinetics.numerics.cache import Cache
from kinetics.states.state import LogMeasure, State

#: Number of harmonics that are kept. Chosen: averages need m = 0, 1, 2 and the one of a moment that
#: is asked for.
HARMONICS_KEPT = 8


class StartHarmonics:
    """The harmonics of an initial state; each is computed once.

    Parameters
    ----------
    state : the initial state
    rtol : relative accuracy of averages over it
    lowest, highest : the powers of the speed for which these are accurate
    """

    def __init__(self, state: State, rtol: float, lowest: float, highest: float) -> None:
        self.state = state
        self._rtol = rtol
        self._lowest = lowest
        self._highest = highest
        self._points: Cache[int, LogMeasure | None] = Cache(HARMONICS_KEPT)

    def harmonic(self, m: int) -> LogMeasure | None:
        """Return harmonic m as weighted points; None where it is zero."""
        return self._points.get(m, lambda: self._compute(m))

    def _compute(self, m: int) -> LogMeasure | None:
        """Ask the initial state for a harmonic."""
        return self.state.harmonic(m, self._rtol, self._lowest, self._highest)

    @property
    def speeds(self) -> LogMeasure:
        """The initial speeds: harmonic 0, which is never zero."""
        points = self.harmonic(0)
        assert points is not None
        return points

    def error(self, harmonics: Collection[int]) -> float:
        """Return the relative error estimate of what is not resolved of these harmonics.

        It is infinite where one of them has an error that is not a number.
        """
        largest = 0.0
        for m in harmonics:
            points = self.harmonic(m)
            if points is None:
                continue
            if math.isnan(points.error):
                return math.inf
            largest = max(largest, points.error)
        return largest
