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

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from kinetics.collision import CollisionLaw
from kinetics.densities.harmonic import Profile
from kinetics.densities.node_masses import NodeMasses, deposit
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.states.state import LogMeasure, State

#: Panels for each octave of the speed, for smooth densities. Origin not recorded.
SMOOTH_PANELS = 6
#: The same for densities with steps. Origin not recorded.
ROUGH_PANELS = 60
#: Gauss points of a panel. Origin not recorded.
PANEL_POINTS = 3
#: Speeds over the fastest, times the number of mean free paths that it has, below which tracers
#: hardly collide: 1e-7 of their flights. Chosen.
SLOWEST = 1e-7
#: How far above the fastest point of the start, in ln v, it may go on; origin not recorded.
ABOVE_FASTEST = 0.05
#: Least spacing in ln v of the speeds that carry the masses of a start of sharp speeds: that of the
#: points of rough densities. The rates of collisions are right to its square over 8, 2e-6.
MASS_SPACING = math.log(2.0) / (ROUGH_PANELS * PANEL_POINTS)


@dataclass(frozen=True)
class SharpTracers:
    """Tracers of a start of sharp speeds that have not collided, in units of l and U.

    speeds, shares : of the start, shape (n_speeds,); none for a start that has a density
    is_elastic : whether collisions keep the speed, so that it does not matter if they have collided
    """

    speeds: FloatArray
    shares: FloatArray
    is_elastic: bool

    @classmethod
    def of(cls, state: State, is_elastic: bool) -> SharpTracers:
        """Those of a state."""
        if state.peaks is None:
            return cls(np.zeros(0), np.zeros(0), is_elastic)
        speeds, repeats = np.unique(state.peaks[0], return_inverse=True)
        shares = np.bincount(repeats, weights=state.peaks[1]).astype(float)
        return cls(speeds, shares, is_elastic)

    def left(self, times: FloatArray) -> FloatArray:
        """Share of all tracers, at times in l/U, shape of times."""
        if self.is_elastic:
            return np.full(times.shape, float(self.shares.sum()))
        with np.errstate(under="ignore"):
            return np.asarray(np.exp(-np.outer(times, self.speeds)) @ self.shares)

    def _integral(self, t: FloatArray) -> FloatArray:
        """Shares left, integrated from 0 to t, (n_speeds, n_t); t of that shape or (n_t,)."""
        time = np.maximum(t, 0.0)
        if self.is_elastic:
            return self.shares[:, None] * time
        rates = self.speeds[:, None]
        return np.asarray(self.shares[:, None] * -np.expm1(-rates * time) / rates)

    def longer_in_time(self, time: float, s: FloatArray) -> FloatArray:
        """Flights for each tracer up to a time that last longer than s, shape (n_s,)."""
        with np.errstate(under="ignore"):
            rates = self.speeds[:, None] * np.exp(-np.outer(self.speeds, s))
            return np.asarray((rates * self._integral(time - s)).sum(axis=0))

    def longer_in_length(self, time: float, x: FloatArray) -> FloatArray:
        """The same of flights longer than x, without the factor e^-x, shape (n_x,)."""
        with np.errstate(under="ignore"):
            integral = self._integral(time - x / self.speeds[:, None])
        return np.asarray(self.speeds @ integral)


@dataclass(frozen=True)
class Flights:
    """Flights in units of l and U; times (n_times,) are those up to which they are completed.

    speeds : of the tracers without the sharp ones, (n_v,)
    integral : of their F, times the quadrature weight of each speed, in Chebyshev polynomials of
        ln(1 + t), which goes from -1 to 1 up to the last time, (n_nodes + 1, n_v)
    sharp : tracers of sharp speeds that have not collided
    """

    times: FloatArray
    speeds: FloatArray
    integral: FloatArray
    sharp: SharpTracers

    @classmethod
    def of(
        cls,
        solve: Callable[[FloatArray], Profile],
        law: CollisionLaw,
        state: State,
        times: FloatArray,
        path: float,
    ) -> Flights:
        """Follow all flights up to the times.

        Parameters
        ----------
        solve : maps times in d/U to the speed density then
        law, state : the collision law, and the start
        times : up to which flights are completed, in d/U, the last above 0
        path : mean free path in d
        """
        sharp = SharpTracers.of(state, law.is_elastic)
        last = float(times[-1]) / path
        if law.is_elastic and sharp.speeds.size:
            return cls(times / path, np.zeros(0), np.zeros((2, 0)), sharp)
        end = math.log1p(last)
        count = 32 + int(4.0 * end)
        x = -np.cos(np.pi * np.arange(count) / (count - 1))
        at = np.expm1(0.5 * end * (x + 1.0))
        at[[0, -1]] = 0.0, last
        profile = solve(at * path)
        if sharp.speeds.size and isinstance(profile.density, NodeMasses):
            speeds, shares = _collided_masses(profile.density)
        else:
            speeds, shares = _by_quadrature(profile, state, last)
        # the quadrature misses a little at steps, but the number of tracers is known
        sums = shares.sum(axis=1)
        shares = shares * ((1.0 - sharp.left(at)) / np.where(sums > 0.0, sums, np.inf))[:, None]
        rate = shares * (0.5 * end * (1.0 + at))[:, None]
        coefficients = np.linalg.solve(chebyshev.chebvander(x, count - 1), rate)
        integral = np.asarray(chebyshev.chebint(coefficients, lbnd=-1, axis=0), float)
        return cls(times / path, speeds, integral, sharp)

    def _place(self, t: FloatArray) -> FloatArray:
        """Where a time is in the polynomials; before time 0 as at 0."""
        return np.asarray(2.0 * np.log1p(np.maximum(t, 0.0)) / np.log1p(self.times[-1]) - 1.0)

    def longer_in_time(self, s: FloatArray) -> FloatArray:
        """N(s), flights for each tracer, (n_times, n_s)."""
        t = self.times[:, None] - s
        table = chebyshev.chebvander(self._place(t), len(self.integral) - 1)
        rate = self.speeds[:, None] * np.exp(-np.outer(self.speeds, s))
        number = np.einsum("ksj,jv,vs->ks", table, self.integral, rate, optimize=True)
        return number + np.array([self.sharp.longer_in_time(time, s) for time in self.times])

    def longer_in_length(self, x: FloatArray) -> FloatArray:
        """L(x), flights for each tracer, (n_times, n_x)."""
        numbers = []
        for time in self.times:
            late = time - x / self.speeds[:, None]
            total = chebyshev.chebval(self._place(late), self.integral[:, :, None], tensor=False)
            number = self.speeds @ total + self.sharp.longer_in_length(time, x)
            numbers.append(number * np.exp(-x))
        return np.array(numbers)


def _collided_masses(masses: NodeMasses) -> tuple[FloatArray, FloatArray]:
    """Speeds in U, and shares of tracers there that have collided, (n_v,) and (n_times, n_v).

    A quadrature over the speed would miss nodes, of which each sharp speed fills two.
    """
    shares = (
        masses.mass
        if masses.uncollided is None
        else np.maximum(masses.mass - masses.uncollided, 0.0)
    )
    if masses.spacing >= MASS_SPACING:
        return np.exp(masses.x), shares
    count = math.ceil((masses.x[-1] - masses.x[0]) / MASS_SPACING) + 2
    x = masses.x[-1] + MASS_SPACING * np.arange(2 - count, 2, dtype=float)
    rows = [deposit(LogMeasure(masses.x, row), x, MASS_SPACING) for row in shares]
    return np.exp(x), np.array(rows)


def _by_quadrature(profile: Profile, state: State, last: float) -> tuple[FloatArray, FloatArray]:
    """Speeds in U, and the density there times the quadrature weight, (n_v,) and (n_times, n_v).

    last : the last time, in l/U
    """
    start = state.harmonic(0, 1e-8)
    assert start is not None  # harmonic 0 is never zero
    fastest = float(np.exp(start.x.max()))
    octaves = math.log2(fastest * max(last, 1.0) / SLOWEST)
    panels = SMOOTH_PANELS if state.smooth else ROUGH_PANELS
    depths = np.linspace(0.0, math.log(2.0) * octaves, int(octaves * panels) + 1)
    edges = math.log(fastest) + np.append(-depths[::-1], ABOVE_FASTEST)
    logs, weight = panels_between(edges, PANEL_POINTS)
    speeds = np.exp(logs)
    density = np.maximum(profile.continuous(speeds).real, 0.0)
    return speeds, density * (weight * speeds)


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
