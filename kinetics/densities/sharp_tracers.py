"""Tracers of a start of sharp speeds that have not collided yet: a share exp(-v t/l) of each speed.

v is the speed in U, l the mean free path. They are delta peaks of the speed, which no density has.
At e = 1 collisions keep the speed, and all tracers of such a start stay in the peaks. Begin with
:class:`SharpTracers`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinetics.numerics import FloatArray
from kinetics.states.state import State


@dataclass(frozen=True)
class SharpTracers:
    """Tracers of sharp speeds that have not collided; at e = 1 all, which keep their speeds.

    Times are in l/U, l the mean free path.

    Parameters
    ----------
    speeds : those of the start in U, rising, shape (n_speeds,); none if the start has a density
    shares : share of all tracers that each has at t = 0, shape (n_speeds,)
    is_elastic : whether collisions keep the speed, so that it does not matter if they have collided
    """

    speeds: FloatArray
    shares: FloatArray
    is_elastic: bool

    @classmethod
    def of(cls, state: State, is_elastic: bool) -> SharpTracers:
        """Return those of an initial state."""
        if state.peaks is None:
            return cls(np.zeros(0), np.zeros(0), is_elastic)
        peak_speeds, peak_shares = state.peaks
        speeds, indices = np.unique(peak_speeds, return_inverse=True)
        shares = np.bincount(indices, weights=peak_shares).astype(float)
        return cls(speeds, shares, is_elastic)

    def sum_over(
        self, function: Callable[[FloatArray], FloatArray], times: FloatArray
    ) -> FloatArray:
        """Return the sum of a function of the speed over them, for each tracer of all.

        Parameters
        ----------
        function : maps speeds in U, (n,), to numbers, (n,)
        times : t in l/U, shape (n_times,)

        Returns
        -------
        The sum, shape (n_times,).
        """
        weighted = self.shares * function(self.speeds)
        if self.is_elastic:
            return np.full(times.shape, float(weighted.sum()))
        with np.errstate(under="ignore"):
            return np.asarray(np.exp(-np.outer(times, self.speeds)) @ weighted)

    def remaining(self, times: FloatArray) -> FloatArray:
        """Return their share of all tracers at times in l/U, shape (n_times,)."""
        return self.sum_over(np.ones_like, times)

    def integrated_shares(self, t: FloatArray) -> FloatArray:
        """Return the share of each speed, integrated from 0 to t in l/U, (n_speeds, n_t).

        t : of that shape, or (n_t,); times below 0 count as 0
        """
        time = np.maximum(t, 0.0)
        if self.is_elastic:
            return self.shares[:, None] * time
        rates = self.speeds[:, None]
        return np.asarray(self.shares[:, None] * -np.expm1(-rates * time) / rates)
