r"""Averages after N collisions: closed forms, for those who record by collision and not by time.

Before each collision a tracer flies freely over an exponential length of mean l, and each collision
multiplies its speed by s and turns it by chi, both independent. With c = E[cos(chi)] (in
space P_m(cos(chi)) stands for cos(m chi)), after N collisions and at the place of the last one,

    <v^p exp(i m phi)> = <v^p exp(i m phi)>_0 E[s^p cos(m chi)]^N
    <r^2> = 2 l^2 [N/(1-c) - c (1-c^N)/(1-c)^2]        for every initial state
    <t>   = l <1/v>_0 (1 + E[1/s] + ... + E[1/s]^(N-1))
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError, warn_missed
from kinetics.moments.averages import as_vector, moment_arguments
from kinetics.numerics import ROUNDING, FloatArray
from kinetics.results.record import stored_class
from kinetics.results.result import Storable
from kinetics.states.state import State


@stored_class
@dataclass(frozen=True, eq=False, repr=False)
class ByCollision(Storable):
    """What tracers are like right after their N-th collision; N = 0 is the initial state.

    Arrays have the collision number as their first axis. Made by ``Solution.by_collision``; law,
    mean_free_path in d and state are those of the scene, collision_numbers N (n_collisions,). Only
    averages over the initial state are approximate, to rtol.
    """

    law: CollisionLaw
    mean_free_path: float
    state: State
    collision_numbers: FloatArray
    rtol: float

    def moment(self, p: float) -> FloatArray:
        """<v^p> in U^p for real p, shape (n_collisions,); InputError where it does not exist."""
        return np.asarray(self.harmonic(p, 0).real)

    def harmonic(self, p: float, m: int) -> NDArray[Any]:
        """<v^p exp(-i m phi)> in U^p, in space <v^p P_m(cos theta)>, shape (n_collisions,)."""
        p, m = moment_arguments(self.law, self.state, p, m)
        gap = float(self.law.harmonic_decay_rate(p, m))
        return self._in_range(f"<v^{p:g}>", self._start(p, m) * _power(gap, self.collision_numbers))

    @property
    def thermal_speed(self) -> FloatArray:
        """v0 = sqrt(<v^2>) in U, shape (n_collisions,)."""
        return np.sqrt(self.moment(2.0))

    @property
    def a2(self) -> FloatArray:
        """<v^4> d/((d+2) <v^2>^2) - 1, shape (n_collisions,)."""
        d = self.law.dimension
        second, fourth = self.law.decay_rate(2.0), self.law.decay_rate(4.0)
        grown = self.collision_numbers * (math.log1p(-fourth) - 2.0 * math.log1p(-second))
        start = self._start(4.0, 0).real / self._start(2.0, 0).real ** 2
        with np.errstate(over="ignore"):
            return self._in_range("a2", d / (d + 2.0) * start * np.exp(grown) - 1.0)

    @property
    def msd(self) -> FloatArray:
        """<r^2> in d^2 at the place of the collision, shape (n_collisions,)."""
        n, gap = self.collision_numbers, float(self.law.harmonic_decay_rate(0.0, 1))
        return np.asarray(2.0 * self.mean_free_path**2 * _pairs(n, gap))

    @property
    def mean_displacement(self) -> FloatArray:
        """<r> in d at the place of the collision, shape (n_collisions, d)."""
        gap = float(self.law.harmonic_decay_rate(0.0, 1))
        along = self.mean_free_path * _sum_of_powers(self.collision_numbers, gap)
        return as_vector(self.law, along * self._start(0.0, 1))

    @property
    def mean_time(self) -> FloatArray:
        """Mean time of the N-th collision in d/U, (n_collisions,); InputError if it is infinite."""
        lowest = max(self.state.lowest_moment, self.law.lowest_power)
        if lowest >= -1.0:
            raise InputError("collision_numbers: <1/v> does not exist, and so no mean time")
        slow = self._start(-1.0, 0).real * self.mean_free_path
        gap = float(self.law.decay_rate(-1.0))
        with np.errstate(over="ignore"):
            found = slow * _sum_of_powers(self.collision_numbers, gap)
        return self._in_range("the mean time", found)

    def _start(self, p: float, m: int) -> Any:
        """<v^p exp(-i m phi)> at N = 0."""
        measure = self.state.harmonic(m, self.rtol, min(p, 0.0), max(p, 2.0))
        if measure is None:
            return 0.0j
        if measure.error > self.rtol:
            warn_missed(f"<v^{p:g}> of the start", measure.error, self.rtol)
        return complex(measure.weight @ np.exp(p * measure.x))

    @staticmethod
    def _in_range(name: str, value: NDArray[Any]) -> NDArray[Any]:
        if not np.all(np.isfinite(value)):
            raise InputError(f"collision_numbers: {name} overflows double precision there")
        return value


def _power(gap: float, n: FloatArray) -> FloatArray:
    """(1 - gap)^n, accurate for small gaps; shape of n."""
    with np.errstate(under="ignore", over="ignore"):
        return np.asarray(np.exp(n * math.log1p(-gap)) if gap < 0.5 else (1.0 - gap) ** n)


def _sum_of_powers(n: FloatArray, gap: float) -> FloatArray:
    """1 + (1 - gap) + ... + (1 - gap)^(n-1), shape of n."""
    if gap == 0.0:
        return n
    lost = -np.expm1(n * math.log1p(-gap)) if gap < 0.5 else 1.0 - _power(gap, n)
    return np.asarray(lost / gap)


def _pairs(n: FloatArray, gap: float) -> FloatArray:
    """n/(1-c) - c (1-c^n)/(1-c)^2 with c = 1 - gap: the sum of (n-k) c^k, k < n; shape of n."""
    few = (n + 1.0) * gap < 1.0  # elsewhere the closed form keeps its digits
    closed = np.zeros(n.shape)
    if not few.all():
        closed = (n - (1.0 - gap) * _sum_of_powers(n, gap)) / gap
    term, k = np.where(few, 0.5 * n * (n + 1.0), 0.0), 0
    series = term
    while np.any(np.abs(term) > ROUNDING * series):
        # binomial coefficients of n + 1 over k + 2, times (-gap)^k
        term, k = term * -gap * (n - 1.0 - k) / (k + 3.0), k + 1
        series = series + term
    return np.where(few, series, closed)
