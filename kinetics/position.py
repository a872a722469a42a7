"""Where the tracers are: moments of the displacement from chains of scalar equations.

In units of the mean free path l, with T = v t/l for a tracer of initial speed v (paper, label
``inelaslorentz`` for the equation with its free-streaming term):

    chi1(T) = <v_hat(0) . r>/l   : driven by 1, harmonic m = 1
    rho(T)  = <r^2>/l^2          : driven by 2 chi1, harmonic m = 0

No profile in space is needed. For e = 1, where a speed is kept, they are elementary.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinetics.backward import SQUARED_DISPLACEMENT
from kinetics.evolve import Averages

FloatArray = NDArray[np.float64]


def mean_square_displacement(averages: Averages) -> FloatArray:
    """<r^2>(t) in d^2, shape (n_times,)."""
    square = averages.mean_free_path**2
    if not averages.elastic:
        return square * averages.average(SQUARED_DISPLACEMENT)
    # <v(0).v(t)> = v^2 exp(-nu v t/l), nu = 1 - <cos chi> = 4/3
    nu = averages.law.harmonic_decay_rate(0.0, 1)
    with np.errstate(over="ignore"):
        x = nu * np.exp(averages.speeds.x + averages.log_stretch[:, None])
    mean = _ballistic_to_diffusive(x) @ averages.speeds.weight
    return np.asarray(2.0 * square / nu**2 * mean)


def _ballistic_to_diffusive(x: FloatArray) -> FloatArray:
    """x - 1 + exp(-x), by its series where that cancels."""
    small = x < 0.3
    near = np.where(small, x, 0.0)
    # x^2/2 (1 - x/3 (1 - x/4 (1 - ...)))
    nested = np.ones_like(x)
    for k in range(14, 2, -1):
        nested = 1.0 - near / k * nested
    with np.errstate(under="ignore"):
        direct = x - 1.0 + np.exp(-x)
    return np.asarray(np.where(small, 0.5 * near**2 * nested, direct))
