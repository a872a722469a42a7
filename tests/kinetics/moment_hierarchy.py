"""Harmonics of directed states as sums in many digits; l = 1.

With l = 1 (rho_0 = 1/2) harmonic m of v^p obeys d<v^p e^-im phi>/dt = -nu_m(p) <v^(p+1) e^-im phi>,
nu_m(p) = 1 - E[s^p cos(m chi)]: an alternating series in t, summed here in mpmath.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import mpmath as mp
from collision import decay_rates

from kinetics import Scene

TIMES = [0.0, 1e-6, 0.01, 0.3, 1.0, 4.0, 15.0, 50.0, 120.0]
DIGITS = 110  # the terms of the series grow to e^(v t) before they cancel


@lru_cache(maxsize=32)
def rates(e: float, m: int, first: float = 0) -> tuple[Any, ...]:
    """nu_m(p), p = first, first + 1, ..."""
    with mp.workdps(DIGITS):
        return tuple(decay_rates(e, m, first, 700))


def series(
    e: float, m: int, p: float, t: float, moment: Callable[[float], Any] = lambda q: 1
) -> float:
    """<v^p e^-im phi> at t for a start with the moments moment(q)."""
    with mp.workdps(DIGITS):
        total, factor = mp.mpf(0), mp.mpf(1)
        for k, rate in enumerate(rates(e, m, p)):
            term = factor * moment(p + k)
            total += term
            if abs(term) < mp.mpf(10) ** -30 and k > 20:
                return float(total)
            factor *= -mp.mpf(t) * rate / (k + 1)
    raise ArithmeticError("the series needs more terms")


def chance_of_bounces(rates: list[Any], t: Any) -> Any:
    """Of so many bounces as there are rates but one: the flight after n bounces ends at rates[n].

    A sum of exponentials with alternating signs (Cox, Renewal Theory, section 2.2).
    """
    return mp.fprod(rates[:-1]) * mp.fsum(
        mp.exp(-one * t) / mp.fprod(other - one for k, other in enumerate(rates) if k != j)
        for j, one in enumerate(rates)
    )


def scene(e: float, initial: Any, times: Any = TIMES, **more: Any) -> Scene:
    return Scene(restitution=e, number_density=0.5, initial=initial, times=times, **more)
