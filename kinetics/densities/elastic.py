"""The elastic scene: speeds are kept, angular harmonics relax at their own rates.

d f_m/dt = -(1 - E[cos(m chi)]) (v/l) f_m for each speed apart; nothing is left to discretise.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.densities.harmonic import HarmonicProblem, Profile
from kinetics.errors import InputError
from kinetics.numerics import FloatArray
from kinetics.results import Value
from kinetics.states.state import State


@dataclass(frozen=True)
class ElasticDensity(Value):
    """The density of the start times exp(-rate v t).

    Attributes
    ----------
    state : the start; its density is zero if all speeds are equal
    m : the angular harmonic
    rate : (1 - E[cos(m chi)])/l, in 1/d
    times : in d/U, shape (n_times,)
    """

    state: State
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
