"""The elastic scene: speeds are kept, angular harmonics relax at their own rates.

d f_m/dt = -(1 - E[cos(m chi)]) (v/l) f_m for each speed apart; nothing is left to discretise.
"""

from __future__ import annotations

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
    rate = law.harmonic_decay_rate(0.0, m) / mean_free_path
    profile = state.profile(m)
    measure = state.harmonic(m, 1e-12)
    if profile is None and (measure is None or measure.x.size != 1):
        raise InputError(
            "initial: samples have no density of their own, and elastic tracers keep their "
            "speeds; ask for averages, or give a SpeedTable"
        )
    if profile is None:
        assert measure is not None
        # all of one speed: nothing is continuous, the whole harmonic stays in the peak
        speed = float(np.exp(measure.x[0]))
        weight = measure.weight[0] * np.exp(-rate * speed * times)

        def nothing(i: int, v: FloatArray) -> NDArray[Any]:
            return np.zeros(v.shape)

        return Profile(nothing, times.size, "exact", 0, 1e-16, speed, weight)
    kept = profile

    def relaxed(i: int, v: FloatArray) -> NDArray[Any]:
        with np.errstate(under="ignore"):
            return np.asarray(kept(v) * np.exp(-rate * times[i] * v))

    return Profile(relaxed, times.size, "exact", 0, 1e-16)
