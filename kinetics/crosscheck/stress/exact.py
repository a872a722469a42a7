"""Closed forms for the sweep, in high precision, so that no e is near a limit of doubles."""

from __future__ import annotations

import math
from functools import lru_cache

from kinetics.crosscheck.bench.references import speed_ratio_powers


@lru_cache(maxsize=256)
def scaling(e: float) -> tuple[float, float, float]:
    """h, 1 + a2 and kappa of the scaling state, 0 <= e < 1: paper's labels compare2, sonine5.

    h = 2 sqrt(kappa lambda(1)), 1 + a2 = 3 kappa lambda(1)/(lambda(2) lambda(3)), kappa =
    1 - e arccos(e)/sqrt(1 - e^2).
    """
    import mpmath as mp

    with mp.workdps(60):
        e_ = mp.mpf(e)
        kappa = 1 - e_ * mp.acos(e_) / mp.sqrt(1 - e_**2)
        one, two, three = (1 - f for f in speed_ratio_powers(e, mp.mpf(1), 3))
        return (
            float(2 * mp.sqrt(kappa * one)),
            float(3 * kappa * one / (two * three)),
            float(kappa),
        )


def late_thermal_speed(e: float, mean_free_path: float, time: float) -> float:
    """v0 = 2 l/(h t), the limit of late times."""
    return 2.0 * (mean_free_path / time) / scaling(e)[0]


def early_and_late(e: float, reduced_time: float, rtol: float) -> tuple[bool, bool]:
    """Whether v t/l is so small, or so large, that v0 and a2 are their limits within rtol/10.

    v0 changes by less than v t/l at first, and is that of the scaling state up to a few
    l/(kappa v t).
    """
    late = False
    if e < 1.0:
        late = math.log(reduced_time) > math.log(1e3 / rtol) - math.log(scaling(e)[2])
    return reduced_time < 0.01 * rtol, late
