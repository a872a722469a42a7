"""What the cases of the solvers share: restitutions, times, and limits known in closed form."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

RESTITUTIONS = (
    0.0, 1e-10, 1e-8, 1e-4, 0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.99, 0.999,
    1.0 - 1e-6, 1.0 - 1e-10, 1.0,
)  # fmt: skip
FEWER = (0.0, 1e-10, 1e-4, 0.2, 0.7, 0.99, 1.0 - 1e-6, 1.0 - 1e-10, 1.0)
TIMES = np.array([0.0, 1e-300, 1e-3, 1.0, 1e3, 1e8, 1e30, 1e300])
PATH = 12.5  # l at the default density, in d
ROUNDING = 1e-14  # that a reference in doubles, and the average over a start, may add
GROWTH = 1e-13  # of a thermal speed that must not grow, relative


def label_of(e: float) -> str:
    """A restitution as the name of a case has it."""
    return f"e = {e:g}" if e < 0.9995 or e == 1.0 else f"e = 1 - {1.0 - e:.0e}"


# -- closed forms in high precision, so that no e is near a limit of doubles ----------------------


@lru_cache(maxsize=256)
def scaling(e: float) -> tuple[float, float, float, float]:
    """h, 1 + a2, kappa and d<r^2>/d ln t in l^2 of the scaling state, 0 <= e < 1.

    With the speed ratio s(y) = sqrt(e^2 + (1-e^2) y^2), y uniform on [0, 1], and
    lambda(p) = 1 - E[s^p]: h = 2 sqrt(kappa lambda(1)), 1 + a2 = 3 kappa lambda(1)/(lambda(2)
    lambda(3)) (paper's labels compare2, sonine5), and the slope is 2/(kappa (1 - <cos chi>)), where
    cos(chi) = (s^2 - e)/((1 - e) s).
    """
    import mpmath as mp

    with mp.workdps(60):
        x = mp.mpf(e)
        root = mp.sqrt(1 - x * x)
        inverse = x * mp.acosh(1 / x) / root if e > 0.0 else mp.mpf(0)  # e E[1/s]
        first = (1 + x * inverse) / 2  # E[s], and E[s^3] = (1 + 3 e^2 E[s])/4
        one, two, three = 1 - first, 2 * root**2 / 3, 1 - (1 + 3 * x * x * first) / 4
        turn = 1 - (first - inverse) / (1 - x)
        kappa = 1 - x * mp.acos(x) / root
        return (
            float(2 * mp.sqrt(kappa * one)),
            float(3 * kappa * one / (two * three)),
            float(kappa),
            float(2 / (kappa * turn)),
        )


def late_thermal_speed(e: float, mean_free_path: float, time: float) -> float:
    """v0 = 2 l/(h t), the limit of late times."""
    return 2.0 * (mean_free_path / time) / scaling(e)[0]


def early_and_late(e: float, reduced_time: float, rtol: float) -> tuple[bool, bool]:
    """Whether v t/l is so small, or so large, that v0 and a2 are their limits within rtol/10.

    v0 changes by less than v t/l at first, and is that of the scaling state up to a few
    l/(kappa v t).
    """
    late = e < 1.0 and math.log(reduced_time) > math.log(1e3 / rtol) - math.log(scaling(e)[2])
    return reduced_time < 0.01 * rtol, late


def limit_errors(
    solution: Any, first: tuple[float, float], rtol: float, places: slice = slice(None)
) -> float:
    """Error of v0 and a2 at the times that are early or late enough for the limits; NaN if none is.

    first : v0 and a2 of the start; places : of the times that are looked at
    """
    e, path = solution.scene.restitution, solution.scene.mean_free_path
    averages = (solution.times, solution.thermal_speed, solution.a2)
    errors = []
    for t, v0, a in zip(*(values[places] for values in averages), strict=True):
        # in logarithms: v t may overflow
        logarithm = -math.inf if t == 0.0 else math.log(first[0]) + math.log(t) - math.log(path)
        reduced = math.exp(max(min(logarithm, 700.0), -700.0))
        early, late = early_and_late(e, reduced, rtol)
        if early or e == 1.0:
            errors += [abs(v0 / first[0] - 1.0), abs((1.0 + a) / (1.0 + first[1]) - 1.0)]
        elif late:
            expected = late_thermal_speed(e, path, float(t))
            if expected < 1e-290:  # at the end of the doubles
                continue
            errors += [abs(v0 / expected - 1.0), abs((1.0 + a) / scaling(e)[1] - 1.0)]
    return max(errors, default=math.nan)


# -- violations of what holds at all times ---------------------------------------------------------


def growth(speed: FloatArray) -> float:
    """Largest relative growth from one time to the next."""
    with np.errstate(invalid="ignore", divide="ignore"):
        change = speed[1:] / speed[:-1] - 1.0
    return max(0.0, float(np.max(change, initial=0.0)))


def below(values: Any, least: float = 0.0) -> float:
    """How far the smallest value is below the least that is allowed; 0 if it is not."""
    return max(0.0, least - float(np.min(values)))


def above(values: Any, most: float = 1.0) -> float:
    """How far the largest value is above the most that is allowed; 0 if it is not."""
    return max(0.0, float(np.max(values)) - most)


def finite(*values: Any) -> bool:
    """Whether all numbers of all arrays are finite."""
    return all(bool(np.all(np.isfinite(value))) for value in values)


def difference(
    speed: FloatArray, a2: FloatArray, expected: FloatArray, expected_a2: FloatArray
) -> float:
    """Largest relative difference of the thermal speeds, and of 1 + a2."""
    with np.errstate(all="ignore"):
        errors = [speed / expected - 1.0, (1.0 + a2) / (1.0 + expected_a2) - 1.0]
    found = float(np.max(np.abs(errors)))
    return found if math.isfinite(found) else math.inf
