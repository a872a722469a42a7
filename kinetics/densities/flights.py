r"""Free flights completed by a time T, and fronts of speed densities.

Of free flights: how many last longer than s, or are longer than x.

A flight counts if a collision ends it at a time up to T; the first one begins at time 0. At time t
those tracers end one that lasts longer than s which did not collide between t - s and t. So with
the speed density f and lengths in l there are, for each tracer,

    N(s) = int dv v e^(-v s) F(v, T - s)   longer than s in time,  F(v, t) = int_0^t f(v, t') dt',
    L(x) = e^-x int dv v F(v, T - x/v)     longer than x in length,

and N(0) = L(0) is the mean number of collisions. Lengths are exponential but for those which T cuts
off. Among moving, or dense, scatterers this does not hold.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.states.state import LogMeasure

# panels for each octave of the speed, for smooth densities and for those with steps
_PANELS = {True: 6, False: 60}


@dataclass(frozen=True)
class Flights:
    """Flights in units of l and U; times (n_times,) are those up to which they are completed.

    speeds (n_v,), weight: for the speed v the quadrature weight. integral (n_nodes + 1, n_v): of F
    in Chebyshev polynomials of ln(1 + t), which goes from -1 to 1 up to the last time. peak: the
    speed of tracers of a start of one speed, of which share e^(-loss peak t) is left; 0: none.
    """

    times: FloatArray
    speeds: FloatArray
    integral: FloatArray
    peak: float
    loss: float

    @classmethod
    def of(cls, solve: Callable[[FloatArray], Any], times: FloatArray, path: float) -> "Flights":
        """From a solver of scenes with speed densities at the times that it is given, in d/U."""
        last = float(times[-1]) / path
        end = np.log1p(last)
        count = 32 + int(4.0 * end)
        x = -np.cos(np.pi * np.arange(count) / (count - 1))
        at = np.expm1(0.5 * end * (x + 1.0))
        at[[0, -1]] = 0.0, last
        solution = solve(at * path)
        state = solution.scene.state
        first = float(np.exp(state.harmonic(0, 1e-8).x.max()))
        octaves = np.log2(1e7 * first * max(last, 1.0))  # slower ones hardly collide
        edges = np.linspace(0.0, np.log(2.0) * octaves, int(octaves * _PANELS[state.smooth]) + 1)
        logs, weight = panels_between(np.log(first) + np.append(-edges[::-1], 0.05), 3)
        speeds = np.exp(logs)
        density = np.maximum(solution.speed_density(speeds), 0.0) * (weight * speeds)
        left = solution.uncollided
        # the quadrature misses a little at steps, but the number of tracers is known
        sums = density.sum(axis=1)
        density *= ((1.0 - left) / np.where(sums > 0.0, sums, np.inf))[:, None]
        rate = density * (0.5 * end * (1.0 + at))[:, None]
        coefficients = np.linalg.solve(chebyshev.chebvander(x, count - 1), rate)
        integral = np.asarray(chebyshev.chebint(coefficients, lbnd=-1, axis=0), float)
        peak = float(getattr(state, "speed", 1.0)) if left[0] > 0.0 else 0.0
        return cls(times / path, speeds, integral, peak, float(left[-1] < 1.0))

    def _place(self, t: FloatArray) -> FloatArray:
        """Where a time is in the polynomials; before time 0 as at 0."""
        return 2.0 * np.log1p(np.maximum(t, 0.0)) / np.log1p(self.times[-1]) - 1.0

    def _peak(self, t: FloatArray) -> FloatArray:
        """F of the tracers of one speed that have not collided, or never lose speed."""
        t, rate = np.maximum(t, 0.0), self.loss * self.peak
        return -np.expm1(-rate * t) / rate if rate else t

    def longer_in_time(self, s: FloatArray) -> FloatArray:
        """N(s), flights for each tracer, (n_times, n_s)."""
        t = self.times[:, None] - s
        table = chebyshev.chebvander(self._place(t), len(self.integral) - 1)
        rate = self.speeds[:, None] * np.exp(-np.outer(self.speeds, s))
        found = np.einsum("ksj,jv,vs->ks", table, self.integral, rate, optimize=True)
        return found + self.peak * np.exp(-self.peak * s) * self._peak(t) * (t > 0.0)

    def longer_in_length(self, x: FloatArray) -> FloatArray:
        """L(x), flights for each tracer, (n_times, n_x)."""
        found = []
        for time in self.times:
            late = time - x / self.speeds[:, None]
            total = chebyshev.chebval(self._place(late), self.integral[:, :, None], tensor=False)
            number = self.speeds @ total
            if self.peak:
                number += self.peak * self._peak(time - x / self.peak)
            found.append(number * np.exp(-x))
        return np.array(found)


def speed_fronts(law: CollisionLaw, start: LogMeasure) -> FloatArray:
    """Speeds in U, rising, at which f may step or be infinite, from a start of sharp speeds.

    Those of the start and, of tracers that have collided once or twice, the ends of the range that
    they come to.
    """
    if law.is_elastic:
        return np.zeros(0)
    ends = [-loss for loss in law.loss_ends]
    moved = [0.0, *ends, *(a + b for a in ends for b in ends)]
    found = np.exp(np.add.outer(np.unique(start.x), np.unique(moved)).ravel())
    return np.unique(found[found > 0.0])
