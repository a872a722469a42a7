"""What the cases of the solvers share: restitutions, times, and comparison with known limits."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kinetics.crosscheck.stress import exact

FloatArray = NDArray[np.float64]

RESTITUTIONS = (
    0.0, 1e-10, 1e-8, 1e-4, 0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.99, 0.999,
    1.0 - 1e-6, 1.0 - 1e-10, 1.0,
)  # fmt: skip
FEWER = (0.0, 1e-10, 1e-4, 0.2, 0.7, 0.99, 1.0 - 1e-6, 1.0 - 1e-10, 1.0)
TIMES = np.array([0.0, 1e-300, 1e-3, 1.0, 1e3, 1e8, 1e30, 1e300])
ROUNDING = 1e-14  # that a reference in doubles, and the average over a start, may add
GROWTH = 1e-13  # of a thermal speed that must not grow, relative


def label_of(e: float) -> str:
    """A restitution as the name of a case has it."""
    return f"e = {e:g}" if e < 0.9995 or e == 1.0 else f"e = 1 - {1.0 - e:.0e}"


def growth(speed: FloatArray) -> float:
    """Largest relative growth from one time to the next."""
    with np.errstate(invalid="ignore", divide="ignore"):
        change = speed[1:] / speed[:-1] - 1.0
    return max(0.0, float(np.max(change, initial=0.0)))


def fall(values: FloatArray) -> float:
    """Largest fall from one time to the next, relative to the largest finite value."""
    finite = values[np.isfinite(values)]
    if finite.size < 2 or not finite.max() > 0.0:
        return 0.0
    return max(0.0, float(-np.min(np.diff(finite / finite.max()))))


def below_half(a2: FloatArray) -> float:
    """How far a2 is below -1/2, where no distribution is: <v^4> >= <v^2>^2."""
    return max(0.0, -0.5 - float(np.min(a2)))


def difference(
    speed: FloatArray, a2: FloatArray, expected: FloatArray, expected_a2: FloatArray
) -> float:
    """Largest relative difference of the thermal speeds, and of 1 + a2."""
    with np.errstate(all="ignore"):
        errors = [speed / expected - 1.0, (1.0 + a2) / (1.0 + expected_a2) - 1.0]
    found = float(np.max(np.abs(errors)))
    return found if math.isfinite(found) else math.inf


def compare_limits(
    e: float,
    speed: FloatArray,
    a2: FloatArray,
    times: FloatArray,
    path: float,
    first: tuple[float, float],
    rtol: float,
) -> float:
    """Error at the times that are early or late enough for the limits; NaN if none is.

    first : v0 and a2 of the start
    """
    errors = []
    for t, v0, a in zip(times, speed, a2, strict=True):
        # in logarithms: v t may overflow
        logarithm = -math.inf if t == 0.0 else math.log(first[0]) + math.log(t) - math.log(path)
        reduced = math.exp(max(min(logarithm, 700.0), -700.0))
        early, late = exact.early_and_late(e, reduced, rtol)
        if early or e == 1.0:
            errors += [abs(v0 / first[0] - 1.0), abs((1.0 + a) / (1.0 + first[1]) - 1.0)]
        elif late:
            expected = exact.late_thermal_speed(e, path, float(t))
            if expected < 1e-290:  # at the end of the doubles
                continue
            errors += [abs(v0 / expected - 1.0), abs((1.0 + a) / exact.scaling(e)[1] - 1.0)]
    return max(errors, default=math.nan)
