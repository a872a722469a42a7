"""Harmonics of directed states as sums in many digits; l = 1.

With l = 1 (rho_0 = 1/2) harmonic m of v^p obeys d<v^p e^-im phi>/dt = -nu_m(p) <v^(p+1) e^-im phi>,
nu_m(p) = 1 - E[s^p cos(m chi)]: an alternating series in t, summed here in mpmath.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import mpmath as mp
import numpy as np

from kinetics import Scene

TIMES = [0.0, 1e-6, 0.01, 0.3, 1.0, 4.0, 15.0, 50.0, 120.0]
DIGITS = 110  # the terms of the series grow to e^(v t) before they cancel


@lru_cache(maxsize=32)
def rates(e: float, m: int) -> tuple[Any, ...]:
    """nu_m(0), nu_m(1), ...: powers of cos(chi) = (s - e/s)/(1-e), then E[s^q].

    E[s^q] in closed form for small q, and (q+1) E[s^q] = 1 + q e^2 E[s^(q-2)] upwards.
    """
    count = 700
    with mp.workdps(DIGITS):
        e_ = mp.mpf(e)
        if e == 1.0:  # E[cos(m chi)] with cos(chi) = 2 y^2 - 1
            nu = 1 - mp.quad(lambda y: mp.cos(m * mp.acos(2 * y * y - 1)), [0, 1])
            return (nu,) * count
        phi = {}
        for q in range(-m, m + count + 1):
            if q < 2:
                z = -(1 - e_**2) / e_**2
                phi[q] = e_**q * mp.hyp2f1(-mp.mpf(q) / 2, mp.mpf("0.5"), mp.mpf("1.5"), z)
            else:
                phi[q] = (1 + q * e_**2 * phi[q - 2]) / (q + 1)
        below, here = {0: mp.mpf(1)}, {1: 1 / (1 - e_), -1: -e_ / (1 - e_)}
        for _ in range(m - 1):  # Chebyshev polynomials of cos(chi), as powers of s
            above = {i: -c for i, c in below.items()}
            for i, c in here.items():
                above[i + 1] = above.get(i + 1, 0) + 2 * c / (1 - e_)
                above[i - 1] = above.get(i - 1, 0) - 2 * c * e_ / (1 - e_)
            below, here = here, above
        terms = here if m else below
        return tuple(1 - sum(c * phi[k + i] for i, c in terms.items()) for k in range(count))


def series(e: float, m: int, p: int, t: float, moment: Callable[[int], Any] = lambda q: 1) -> float:
    """<v^p e^-im phi> at t for a start with the moments moment(q)."""
    nu = rates(e, m)
    with mp.workdps(DIGITS):
        total, factor = mp.mpf(0), mp.mpf(1)
        for k in range(len(nu) - p):
            term = factor * moment(p + k)
            total += term
            if abs(term) < mp.mpf(10) ** -30 and k > 20:
                return float(total)
            factor *= -mp.mpf(t) * nu[p + k] / (k + 1)
    raise ArithmeticError("the series needs more terms")


def scene(e: float, initial: Any, times: Any = TIMES, **more: Any) -> Scene:
    return Scene(restitution=e, number_density=0.5, initial=initial, times=times, **more)


def gaussian_speed_moment(q: int) -> Any:
    """<v^q> for the speed density v exp(-v^2/2)."""
    return mp.mpf(2) ** (mp.mpf(q) / 2) * mp.gamma(mp.mpf(q) / 2 + 1)


def velocities(n: int) -> Any:
    return np.random.default_rng(5).normal([0.7, -0.2], [1.0, 0.5], (n, 2))
