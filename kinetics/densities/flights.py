r"""Free flights completed by a time T: how many last longer than s, or are longer than x.

Units are l, the mean free path, and U, the unit of speeds v; times are in l/U. So v is also the
rate of collisions of a tracer of this speed. f(v, t) is the density of the speed.

A flight counts if a collision ends it at a time up to T; the first one begins at time 0, between
two collisions. A collision at time t ends a flight that lasts longer than s if the tracer did not
collide between t - s and t. So there are, for each tracer,

    N(s) = int dv v e^(-v s) F(v, T - s)   longer than s in time,  F(v, t) = int_0^t f(v, t') dt',
    L(x) = e^-x int dv v F(v, T - x/v)     longer than x in length,

and N(0) = L(0) is the mean number of collisions. Lengths are exponential but for those which T cuts
off. Among moving, or dense, scatterers this does not hold.

f is a plain sum over speeds: :class:`SpeedShares` has the share of all tracers near each speed (the
density times dv), and apart from them the sharp tracers, in delta peaks of the speed, in closed
form. At e < 1 these are the tracers of a start of sharp speeds that have not collided yet; at e = 1
all tracers of such a start, as collisions keep the speed. Begin with :meth:`Flights.of`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from kinetics.collision import CollisionLaw
from kinetics.densities.harmonic import Profile
from kinetics.densities.log_panels import LogPanels
from kinetics.densities.sharp_tracers import SharpTracers
from kinetics.densities.speed_shares import SpeedShares
from kinetics.numerics import FloatArray
from kinetics.states.state import State

#: Least number of Chebyshev points of the time. Chosen: at half and at twice shares of flights move
#: by 3e-10 (e = 0.4 and 1, four starts, T up to 100 l/U).
MIN_POINTS = 32
#: More of them for each e-fold of 1 + t. Chosen: at half and at twice they move by 3e-10.
POINTS_PER_FOLD = 4.0


@dataclass(frozen=True)
class Flights:
    """Flights that are completed up to each of some times, in units of l and U.

    Parameters
    ----------
    times : T in l/U, rising, shape (n_times,), the last above 0
    speeds : of the tracers without the sharp ones in U, all above 0, shape (n_v,)
    integral : F dv of these: the share of all tracers near each speed, integrated from 0 to t. They
        are the coefficients of Chebyshev polynomials in y, where y from -1 to 1 is ln(1 + t) from
        t = 0 to the last time; shape (n_points + 1, n_v)
    sharp : tracers in delta peaks of the speed, see the module
    panels : of which the speeds are the nodes; None where they carry masses, or there are none
    """

    times: FloatArray
    speeds: FloatArray
    integral: FloatArray
    sharp: SharpTracers
    panels: LogPanels | None

    @classmethod
    def of(
        cls,
        solve: Callable[[FloatArray], Profile],
        law: CollisionLaw,
        state: State,
        times: FloatArray,
        mean_free_path: float,
    ) -> Flights:
        """Follow all flights up to the times.

        Parameters
        ----------
        solve : maps times in d/U, d the contact distance, to the density of the speed then
        law : collision law of the tracer
        state : initial state, of which the sharp tracers are found
        times : up to which flights are completed, in d/U, rising, the last above 0
        mean_free_path : l in d
        """
        last = float(times[-1]) / mean_free_path
        folds = math.log1p(last)
        n_points = MIN_POINTS + int(POINTS_PER_FOLD * folds)
        # y = -1 ... 1 is ln(1 + t) from 0 up to the last time
        y = -np.cos(np.pi * np.arange(n_points) / (n_points - 1))
        t = np.expm1(0.5 * folds * (y + 1.0))
        t[0] = 0.0
        t[-1] = last
        distribution = SpeedShares.of(solve, law, state, t, mean_free_path)
        time_per_y = 0.5 * folds * (1.0 + t)
        integrand = distribution.shares * time_per_y[:, None]
        coefficients = np.linalg.solve(chebyshev.chebvander(y, n_points - 1), integrand)
        integral = np.asarray(chebyshev.chebint(coefficients, lbnd=-1, axis=0), float)
        return cls(
            times=times / mean_free_path,
            speeds=distribution.speeds,
            integral=integral,
            sharp=distribution.sharp,
            panels=distribution.panels,
        )

    def longer_in_time(self, s: FloatArray) -> FloatArray:
        """Return N(s), the number of flights for each tracer that last longer than s.

        s is in l/U, shape (n_s,). Shape (n_times, n_s); 0 where s is above the time T.
        """
        t = self.times[:, None] - s
        table = chebyshev.chebvander(self._y_of(t), len(self.integral) - 1)
        rate = self.speeds[:, None] * np.exp(-np.outer(self.speeds, s))
        number = np.einsum("ksj,jv,vs->ks", table, self.integral, rate, optimize=True)
        of_sharp = [self._longer_in_time_of_sharp(time, s) for time in self.times]
        return number + np.array(of_sharp)

    def longer_in_length(self, x: FloatArray) -> FloatArray:
        """Return L(x), the number of flights for each tracer that are longer than x.

        x is in l, shape (n_x,). Shape (n_times, n_x).
        """
        numbers = []
        for time in self.times:
            begun_by = time - x / self.speeds[:, None]
            coefficients = self.integral[:, :, None]
            shares = np.asarray(
                chebyshev.chebval(self._y_of(begun_by), coefficients, tensor=False), float
            )
            number = self.speeds @ shares + self._longer_in_length_of_sharp(time, x)
            if self.panels is not None:
                number += self._change_by_cut_panels(time, x, shares)
            numbers.append(number * np.exp(-x))
        return np.array(numbers)

    def _change_by_cut_panels(self, time: float, x: FloatArray, shares: FloatArray) -> FloatArray:
        """Return by how much L(x) e^x changes where the panel around v = x/T is cut there, (n_x,).

        Slower tracers have flown no such length, so that v F(v, T - x/v) has a kink.

        shares : F at all speeds, of which the sum over whole panels was taken, (n_v, n_x)
        """
        assert self.panels is not None
        with np.errstate(divide="ignore", invalid="ignore"):  # at x = 0, and at time 0
            log_slowest = np.log(x / time)
        panel = self.panels.panel_of(log_slowest)
        is_cut = (panel >= 0) & (panel < self.panels.log_edges.size - 1)
        cut = np.flatnonzero(is_cut)
        pieces = self.panels.pieces_above(log_slowest[cut])
        of_whole_panels = (self.speeds[pieces.nodes] * shares[pieces.nodes, cut[:, None]]).sum(
            axis=1
        )
        at_nodes = self.integral[:, pieces.nodes]
        coefficients = np.einsum("njk,tnk->tnj", pieces.rows, at_nodes)
        y = self._y_of(time - x[cut, None] / pieces.speeds)
        share_at_points = chebyshev.chebval(y, coefficients, tensor=False)
        change = np.zeros(x.shape)
        change[cut] = (pieces.speeds * share_at_points).sum(axis=1) - of_whole_panels
        return change

    def _y_of(self, t: FloatArray) -> FloatArray:
        """Return y, the argument of the polynomials, at times t in l/U of any shape.

        Times below 0 count as 0, where F is 0.
        """
        return np.asarray(2.0 * np.log1p(np.maximum(t, 0.0)) / np.log1p(self.times[-1]) - 1.0)

    def _longer_in_time_of_sharp(self, time: float, s: FloatArray) -> FloatArray:
        """Return what sharp tracers add to N(s) up to a time, shape (n_s,).

        `integrated_shares` is F of each sharp speed, and takes times below 0 as 0.
        """
        speeds = self.sharp.speeds
        with np.errstate(under="ignore"):
            rates = speeds[:, None] * np.exp(-np.outer(speeds, s))
            return np.asarray((rates * self.sharp.integrated_shares(time - s)).sum(axis=0))

    def _longer_in_length_of_sharp(self, time: float, x: FloatArray) -> FloatArray:
        """Return what sharp tracers add to e^x L(x) up to a time, shape (n_x,)."""
        speeds = self.sharp.speeds
        with np.errstate(under="ignore"):
            shares = self.sharp.integrated_shares(time - x / speeds[:, None])
        return np.asarray(speeds @ shares)
