r"""Averages after N collisions: closed forms, for those who record by collision and not by time.

v is the speed, phi the direction, r the displacement and t the time; < >_0 is an average over the
initial state, E one over a collision. Before each collision a tracer flies freely over an
exponential length of mean l, and each collision multiplies its speed by s and turns it by chi, both
independent. With c = E[cos(chi)] (in space P_m(cos(chi)) stands for cos(m chi)), after N collisions
and at the place of the last one,

    <v^p exp(i m phi)> = <v^p exp(i m phi)>_0 E[s^p cos(m chi)]^N
    <r^2> = 2 l^2 [N/(1-c) - c (1-c^N)/(1-c)^2]        for every initial state
    <t>   = l <1/v>_0 (1 + E[1/s] + ... + E[1/s]^(N-1))
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError, warn_missed
from kinetics.moments.averages import check_moment
from kinetics.moments.outputs import vector_of_harmonic
from kinetics.numerics import ROUNDING, FloatArray, NumberArray
from kinetics.results.record import stored_class
from kinetics.results.result import Storable
from kinetics.states.state import State

#: 1 - c below which powers c^n come from log1p(c - 1), which keeps the digits of 1 - c. Chosen: any
#: value between rounding and 1 does.
SMALL_GAP = 0.5


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class ByCollision(Storable):
    """What tracers are like right after their N-th collision; N = 0 is the initial state.

    Arrays have the collision number as their first axis. Made by ``Solution.by_collision``. Only
    averages over the initial state are approximate, to rtol.

    Parameters
    ----------
    law : the collision law of the scene
    mean_free_path : l in d
    state : the initial state
    collision_numbers : N, shape (n_collisions,)
    rtol : relative accuracy of averages over the initial state
    """

    law: CollisionLaw
    mean_free_path: float
    state: State
    collision_numbers: FloatArray
    rtol: float

    def moment(self, p: float) -> FloatArray:
        """Return <v^p> in U^p for real p, shape (n_collisions,).

        Raises
        ------
        InputError : it does not exist, or overflows
        """
        return np.asarray(self.harmonic(p, 0).real)

    def harmonic(self, p: float, m: int) -> NumberArray:
        """Return <v^p exp(-i m phi)> in U^p, in space <v^p P_m(cos theta)>, (n_collisions,).

        Raises
        ------
        InputError : it does not exist, or overflows
        """
        p, m = check_moment(self.law, self.state, p, m)
        gap = float(self.law.harmonic_decay_rate(p, m))
        moments = self._initial_moment(p, m) * _power(gap, self.collision_numbers)
        _check_range(f"<v^{p:g}>", moments)
        return moments

    @property
    def thermal_speed(self) -> FloatArray:
        """v0 = sqrt(<v^2>) in U, shape (n_collisions,)."""
        return np.sqrt(self.moment(2.0))

    @property
    def a2(self) -> FloatArray:
        """<v^4> d/((d+2) <v^2>^2) - 1, shape (n_collisions,)."""
        d = self.law.dimension
        loss_of_second = self.law.decay_rate(2.0)
        loss_of_fourth = self.law.decay_rate(4.0)
        log_ratio = math.log1p(-loss_of_fourth) - 2.0 * math.log1p(-loss_of_second)
        log_growth = self.collision_numbers * log_ratio
        second = self._initial_moment(2.0, 0).real
        fourth = self._initial_moment(4.0, 0).real
        with np.errstate(over="ignore"):
            a2 = d / (d + 2.0) * (fourth / second**2) * np.exp(log_growth) - 1.0
        _check_range("a2", a2)
        return a2

    @property
    def msd(self) -> FloatArray:
        """<r^2> in d^2 at the place of the collision, shape (n_collisions,)."""
        gap = float(self.law.harmonic_decay_rate(0.0, 1))
        pairs = _sum_over_pairs(self.collision_numbers, gap)
        return np.asarray(2.0 * self.mean_free_path**2 * pairs)

    @property
    def mean_displacement(self) -> FloatArray:
        """<r> in d at the place of the collision, shape (n_collisions, d)."""
        gap = float(self.law.harmonic_decay_rate(0.0, 1))
        along = self.mean_free_path * _sum_of_powers(self.collision_numbers, gap)
        return vector_of_harmonic(self.law, along * self._initial_moment(0.0, 1))

    @property
    def mean_time(self) -> FloatArray:
        """Mean time of the N-th collision in d/U, (n_collisions,); InputError if it is infinite."""
        lowest = max(self.state.lowest_moment, self.law.lowest_power)
        if lowest >= -1.0:
            raise InputError("collision_numbers: <1/v> does not exist, and so no mean time")
        first_flight = self._initial_moment(-1.0, 0).real * self.mean_free_path
        gap = float(self.law.decay_rate(-1.0))
        with np.errstate(over="ignore"):
            times = first_flight * _sum_of_powers(self.collision_numbers, gap)
        _check_range("the mean time", times)
        return times

    def _initial_moment(self, p: float, m: int) -> complex:
        """Return <v^p exp(-i m phi)> at N = 0; warn where it misses rtol."""
        points = self.state.harmonic(m, self.rtol, min(p, 0.0), max(p, 2.0))
        if points is None:
            return 0.0j
        if points.error > self.rtol:
            warn_missed(f"<v^{p:g}> of the start", points.error, self.rtol)
        return complex(points.weight @ np.exp(p * points.x))


def _check_range(name: str, values: NumberArray) -> None:
    """Raise InputError where a value is beyond the largest number of double precision."""
    if not np.all(np.isfinite(values)):
        raise InputError(f"collision_numbers: {name} overflows double precision there")


def _power(gap: float, n: FloatArray) -> FloatArray:
    """Return (1 - gap)^n, accurate for small gaps; shape of n."""
    with np.errstate(under="ignore", over="ignore"):
        if gap < SMALL_GAP:
            return np.asarray(np.exp(n * math.log1p(-gap)))
        return np.asarray((1.0 - gap) ** n)


def _sum_of_powers(n: FloatArray, gap: float) -> FloatArray:
    """Return 1 + (1 - gap) + ... + (1 - gap)^(n-1), shape of n."""
    if gap == 0.0:
        return n
    if gap < SMALL_GAP:
        lost = -np.expm1(n * math.log1p(-gap))
    else:
        lost = 1.0 - _power(gap, n)
    return np.asarray(lost / gap)


def _sum_over_pairs(n: FloatArray, gap: float) -> FloatArray:
    """Return n/(1-c) - c (1-c^n)/(1-c)^2 with c = 1 - gap: the sum of (n-k) c^k, k < n.

    The closed form loses digits where (n + 1) gap is below 1; there the series of binomial
    coefficients of n + 1 over k + 2, times (-gap)^k, is summed. Shape of n.
    """
    needs_series = (n + 1.0) * gap < 1.0
    closed = np.zeros(n.shape)
    if not needs_series.all():
        closed = (n - (1.0 - gap) * _sum_of_powers(n, gap)) / gap
    term = np.where(needs_series, 0.5 * n * (n + 1.0), 0.0)
    series = term
    k = 0
    while np.any(np.abs(term) > ROUNDING * series):
        term = term * -gap * (n - 1.0 - k) / (k + 3.0)
        series = series + term
        k += 1
    return np.where(needs_series, series, closed)
