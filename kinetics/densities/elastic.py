"""The elastic scene: speeds are kept, angular harmonics relax at their own rates.

d f_m/dt = -(1 - E[cos(m chi)]) (v/l) f_m for each speed apart; nothing is left to discretise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinetics.collision import CollisionLaw
from kinetics.densities.harmonic import Profile
from kinetics.errors import InputError
from kinetics.states.state import State

FloatArray = NDArray[np.float64]


def elastic_profile(
    law: CollisionLaw, mean_free_path: float, state: State, m: int, times: FloatArray
) -> Profile:
    """Harmonic m at the times, exactly; InputError for samples, which have no density."""
    rate = float(law.harmonic_decay_rate(0.0, m)) / mean_free_path
    profile = state.profile(m)
    measure = state.harmonic(m, 1e-12)
    if profile is None and (measure is None or measure.x.size != 1):
        raise InputError(
            "initial: samples have no density of their own, and elastic tracers keep their "
            "speeds; ask for averages, or give a SpeedTable"
        )
    relaxing = RelaxingHarmonic(state, m, rate, times)
    if profile is None:
        assert measure is not None
        # all of one speed: nothing is continuous, the whole harmonic stays in the peak
        speed = float(np.exp(measure.x[0]))
        weight = measure.weight[0] * np.exp(-rate * speed * times)

        return Profile(relaxing, times.size, "exact", 0, 1e-16, speed, weight)
    return Profile(relaxing, times.size, "exact", 0, 1e-16)


@dataclass(frozen=True, eq=False)
class RelaxingHarmonic:
    """Harmonic m of an elastic gas, without delta peaks: f_m(v) exp(-rate t v).

    Attributes
    ----------
    state : the initial state
    m : the angular harmonic
    rate : at which it relaxes, over the speed, in 1/d
    times : in d/U, shape (n_times,)
    """

    state: State
    m: int
    rate: float
    times: FloatArray

    def __call__(self, i: int, v: FloatArray) -> NDArray[Any]:
        """Density in 1/U at the i-th time and speeds v in U, shape (n_v,)."""
        profile = self.state.profile(self.m)
        if profile is None:
            return np.zeros(v.shape)
        with np.errstate(under="ignore"):
            return np.asarray(profile(v) * np.exp(-self.rate * self.times[i] * v))
