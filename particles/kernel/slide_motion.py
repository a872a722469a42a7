"""The motion of a tracer that slides along a disk without friction, as a Taylor series in time.

With phi the angle of the normal from the direction of x, phi'' = -g sin(phi). In units of d and
sqrt(d/g) the field is 1 or -1. A work array of shape (3, ORDER + 1) holds the coefficients of phi,
sin(phi) and cos(phi).
"""

from math import cos, sin

import numpy as np

from particles.compiled import called
from particles.events import MOST_STEPS

#: Highest power of the time in the series. Derived: the terms fall as (STEP / 1.5)^k or faster, as
#: a slide is slower than sqrt(g d), so that of this order is 1e-14 of the angle or less.
ORDER = 18
#: Longest time for which one series is used, in sqrt(d/g). Chosen: short enough for rounding, with
#: ORDER.
STEP = 0.25
# What the time is sought of in `time_at`.
ANGLE = 0  # of the normal
DERIVATIVE = 1  # of the angle
COSINE = 2  # of the angle


@called
def expand(angle: float, along: float, field: float, series: np.ndarray) -> None:
    """Expand the motion in powers of the time.

    Parameters
    ----------
    angle, along : of the normal, and its derivative, at the time 0
    field : 1 or -1
    series : work array of shape (3, ORDER + 1), which is overwritten
    """
    phi = series[0]
    sine = series[1]
    cosine = series[2]
    phi[0] = angle
    phi[1] = along
    sine[0] = sin(angle)
    cosine[0] = cos(angle)
    for k in range(ORDER - 1):
        phi[k + 2] = -field * sine[k] / ((k + 1) * (k + 2))
        s = 0.0
        c = 0.0
        for j in range(k + 1):
            s += cosine[k - j] * (j + 1) * phi[j + 1]
            c -= sine[k - j] * (j + 1) * phi[j + 1]
        sine[k + 1] = s / (k + 1)
        cosine[k + 1] = c / (k + 1)


@called
def motion_at(series: np.ndarray, t: float) -> tuple[float, float]:
    """Return the angle and its derivative after a time t."""
    angle = series[0, ORDER]
    along = 0.0
    for k in range(ORDER - 1, -1, -1):
        along = along * t + angle
        angle = angle * t + series[0, k]
    return angle, along


@called
def time_at(series: np.ndarray, longest: float, target: float, quantity: int) -> float:
    """Return when the ANGLE, its DERIVATIVE or its COSINE has a value, once before `longest`.

    Regula falsi between bounds, every third step bisection.
    """
    low = 0.0
    high = longest
    low_excess = _excess(series, low, target, quantity)
    high_excess = _excess(series, high, target, quantity)
    for k in range(MOST_STEPS):
        t = low - low_excess * (high - low) / (high_excess - low_excess)
        if k % 3 == 2 or not low < t < high:
            t = 0.5 * (low + high)
        if t in (low, high):
            break
        excess = _excess(series, t, target, quantity)
        if excess == 0.0:
            return t
        if (excess < 0.0) == (low_excess < 0.0):
            low = t
            low_excess = excess
        else:
            high = t
            high_excess = excess
    return high


@called
def _excess(series: np.ndarray, t: float, target: float, quantity: int) -> float:
    """Return by how much a quantity exceeds its target at a time."""
    angle, along = motion_at(series, t)
    if quantity == DERIVATIVE:
        return along - target
    return (cos(angle) if quantity == COSINE else angle) - target
