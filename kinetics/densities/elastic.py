"""Harmonics of elastic tracers (e = 1), exactly: f_m(v, t) = f_m(v, 0) exp(-lambda_m(0) v t/l).

v is the speed, l the mean free path, and lambda_m(0) = 1 - E[cos(m chi)] the part of harmonic m
that one collision, which turns the velocity by chi, takes away (`kinetics.densities.harmonic`).
Collisions keep the speed and turn the velocity, so that each speed relaxes by itself. Begin with
:func:`elastic_profile`.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np

from kinetics.densities.harmonic import HarmonicArray, HarmonicProblem, Profile
from kinetics.errors import InputError
from kinetics.numerics import FloatArray
from kinetics.results.value import Value
from kinetics.states.state import State

#: Tolerance of the points that represent a start of one speed, which any tolerance gives exactly.
#: Chosen.
RTOL_OF_SHARP_SPEED = 1.0


@dataclass(frozen=True, eq=False, repr=False)
class ElasticDensity(Value):
    """The density of the start, damped at each speed.

    Parameters
    ----------
    state : initial state; the density is zero where it has none, as all speeds are equal
    m : number of the harmonic
    rate : lambda_m(0)/l in 1/d, at which the harmonic decays with the path v t
    times : t in d/U, shape (n_times,)
    """

    state: State
    m: int
    rate: float
    times: FloatArray

    def at(self, i: int, v: FloatArray) -> HarmonicArray:
        """Evaluate f_m in 1/U at the i-th time and speeds v in U, shape (n_v,)."""
        start_density = self.state.profile(self.m)
        if start_density is None:
            return np.zeros(v.shape)
        with np.errstate(under="ignore"):
            damping = np.exp(-self.rate * self.times[i] * v)
            return np.asarray(start_density(v) * damping)


def elastic_profile(problem: HarmonicProblem) -> Profile:
    """Return the harmonic of elastic tracers at the times.

    Raises
    ------
    InputError
        For samples of several speeds, which have no density.
    """
    state = problem.state
    m = problem.m
    times = problem.times
    rate = float(problem.law.harmonic_decay_rate(0.0, m)) / problem.mean_free_path
    density = ElasticDensity(state, m, rate, times)
    peak_speed = None
    peak_weight = None
    if state.profile(m) is None:
        points = state.harmonic(m, RTOL_OF_SHARP_SPEED)
        if points is None or points.x.size != 1:
            raise InputError(
                "initial: samples have no density of their own, and elastic tracers keep their "
                "speeds; ask for averages, or give a SpeedTable"
            )
        # all tracers have one speed, and the whole harmonic stays in that peak
        peak_speed = float(np.exp(points.x[0]))
        peak_weight = points.weight[0] * np.exp(-rate * peak_speed * times)
    return Profile(
        density=density,
        count=times.size,
        method="exact",
        nodes=0,
        error_estimate=sys.float_info.epsilon,
        peak_speed=peak_speed,
        peak_weight=peak_weight,
    )
