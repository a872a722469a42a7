"""What a density solver gives: one harmonic of the velocity density at the output times.

The ``density`` of a :class:`Profile` has a method ``at(i, v)``, in 1/U for the i-th time and speeds
v in U, shape (n_v,): a `spectral.GridDensity`, `conservative.NodeMasses` or `ElasticDensity`.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.errors import InputError
from kinetics.numerics import FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.results.value import Value
from kinetics.states.state import State


@dataclass(frozen=True)
class HarmonicProblem:
    """One angular harmonic of the velocity density, as every solver here is asked for it."""

    law: CollisionLaw
    mean_free_path: float  # in d
    state: State
    m: int
    times: FloatArray  # in d/U, rising, shape (n_times,)
    rtol: float
    nodes: int | None = None  # of the speed axis; None where the solver chooses them


def angular_function(m: int, angle: FloatArray, dimension: int) -> NDArray[Any]:
    """What harmonic m is multiplied by in the sum that gives f: shape of angle, (n,).

    The sum is over m >= 0, and has to be divided by 2 pi v, in space by 4 pi v^2.
    angle : to the x axis, in radians
    """
    if dimension == 2:
        return np.asarray(np.exp(1j * m * angle) * (1.0 if m == 0 else 2.0))
    coefficients = np.zeros(m + 1)
    coefficients[m] = 2.0 * m + 1.0
    return np.asarray(np.polynomial.legendre.legval(np.cos(angle), coefficients))


@dataclass(frozen=True, eq=False, repr=False)
class Profile(Value):
    """Harmonic m of the velocity distribution: exp(-i m phi) v f(v, phi) integrated over phi.

    In space it is P_m(cos theta) v^2 f integrated over all directions.

    density : the harmonic without delta peaks, at ``count`` times
    method : "spectral", "conservative" or "exact"
    error_estimate : of f relative to its maximum ("spectral"), or of its integral from 0 to v,
        the largest for any v ("conservative")
    peak_speed, peak_weight : tracers of a start of one speed that have not collided, speed in U
        and share of all tracers (times exp(-i m phi_0)), shape (n_times,); None without them
    """

    density: Any
    count: int
    method: str
    nodes: int
    error_estimate: float
    peak_speed: float | None = None
    peak_weight: NDArray[Any] | None = None

    def at(self, i: int, v: FloatArray) -> NDArray[Any]:
        """Without delta peaks, in 1/U, at the i-th time and speeds v in U, shape (n_v,)."""
        return self.density.at(i, v)

    def continuous(self, v: FloatArray) -> NDArray[Any]:
        """The same at all times, shape (n_times, n_v)."""
        return np.array([self.at(i, v) for i in range(self.count)])


@dataclass(frozen=True, eq=False, repr=False)
class ElasticDensity(Value):
    """Speeds are kept: the density of the start times exp(-rate v t), rate in 1/d."""

    state: State  # its density is zero if all speeds are equal
    m: int
    rate: float
    times: FloatArray

    def at(self, i: int, v: FloatArray) -> NDArray[Any]:
        """In 1/U at the i-th time and speeds v in U, shape (n_v,)."""
        start = self.state.profile(self.m)
        if start is None:
            return np.zeros(v.shape)
        with np.errstate(under="ignore"):
            return np.asarray(start(v) * np.exp(-self.rate * self.times[i] * v))


def elastic_profile(asked: HarmonicProblem) -> Profile:
    """The harmonic at the times, exactly; InputError for samples, which have no density."""
    state, m, times = asked.state, asked.m, asked.times
    rate = float(asked.law.harmonic_decay_rate(0.0, m)) / asked.mean_free_path
    density = ElasticDensity(state, m, rate, times)
    speed, weight = None, None
    if state.profile(m) is None:
        points = state.harmonic(m, 1.0)
        if points is None or points.x.size != 1:
            raise InputError(
                "initial: samples have no density of their own, and elastic tracers keep their "
                "speeds; ask for averages, or give a SpeedTable"
            )
        # all tracers have one speed, and the whole harmonic stays in that peak
        speed = float(np.exp(points.x[0]))
        weight = points.weight[0] * np.exp(-rate * speed * times)
    return Profile(density, times.size, "exact", 0, sys.float_info.epsilon, speed, weight)


# One Cartesian component, by an integral over the other one, or in space over the speed: panels in
# ln of the other component, in units of a typical speed. Below the first, where the density is
# constant, the other component is taken in one piece. The error is 1e-8 for smooth densities.
_EDGES = np.arange(-20.0, 4.75, 0.5)


def component_densities(
    profile: Profile, x: FloatArray, unit: FloatArray, dimension: int
) -> FloatArray:
    """Density of one velocity component at |v_x| = x (n,) in U, shape (n_times, n), in 1/U.

    profile : harmonic 0 of the velocity density
    unit : speeds of the order of the thermal one, shape (n_times,)
    """
    # with v^2 = x^2 + w^2, of the density g of the speed: g/(pi v) dw, in space g w/(2 v^2) dw
    y, weight = panels_between(_EDGES, 10)
    out = np.empty((unit.size, x.size))
    for i, one in enumerate(unit.tolist()):
        other = one * np.exp(y)
        speed = np.hypot(np.minimum(x, 1e100 * one)[:, None], other)
        g = profile.at(i, speed.ravel()).real.reshape(speed.shape)
        if dimension == 3:
            out[i] = (g * (0.5 * (other / speed) ** 2)) @ weight
            continue
        g = g * (other / speed) / np.pi
        # below the first panel the density is that of its first point
        out[i] = g @ weight + g[:, 0] * math.exp(_EDGES[0]) * one / other[0]
    if profile.peak_speed is not None and profile.peak_weight is not None:
        peak = profile.peak_speed  # one speed and any direction
        shape = np.where(x < peak, 0.5 / peak, 0.0)
        if dimension == 2:
            room = peak**2 - np.minimum(x, 2.0 * peak) ** 2
            shape = np.where(room > 0.0, 1.0 / (np.pi * np.sqrt(np.maximum(room, 1e-300))), 0.0)
        out += profile.peak_weight.real[:, None] * shape
    return out
