"""A flight in a uniform field: a parabola, its length, and the time that a length takes.

The component of the velocity along the field is u + g t, the one across keeps its size w. With
s = sqrt(u^2 + w^2) the speed, at the ends 0 and 1 of a piece of the parabola that takes the time t,

    length = t [(s0 + s1)^2 + (u0 + u1)^2 + 4 w^2 artanh(r)/r] / (4 (s0 + s1)),
    r = (u1 - u0)/(s0 + s1).

No term is negative, so nothing cancels, however weak or strong the field is. The time that a length
takes is found by Halley's method, in units of the length and of V = sqrt(s0^2 + g length), in which
no number is large: `times_of_lengths` makes three steps for many tracers at once, in the
processor's vector registers, and leaves the few that need more to `time_of_length`.
"""

from math import copysign, log, sqrt

import numpy as np
from numba import njit

from particles.compiled import inlined
from particles.events import MOST_STEPS

#: r^2 below which artanh(r)/r is taken from nine terms of its series. Derived: the term left out is
#: 0.03^9 / 19 = 1e-15 at most, in a sum of 1 and more terms; measured to 1e-16 of the length.
SERIES_BELOW = 0.03
#: Rounding of a time, in proportion: about that of a double, 1.1e-16. A Halley step of h leaves an
#: error of about (g h / s)^2 h, and iteration ends where that is smaller.
ROUNDING = 1e-16
#: A Halley step that is smaller than this, in proportion to the time, is rounding. The origin of
#: the factor is not recorded.
SMALLEST_STEP = 4.0 * ROUNDING
#: Halley steps that are made for many tracers at once; those that have not converged by then are
#: solved one by one. The origin of the number is not recorded.
STEPS_AT_ONCE = 3
#: For many tracers at once: y^2 below which seventeen terms of the series give artanh(y), where
#: artanh(r) = 8 artanh(y), with y of three halvings, to 1e-16.
SERIES_AT_ONCE_BELOW = 0.12
#: Weight of the change of the velocity in the mean square of the speed, for the second guess of a
#: time. Chosen: between 1/3 (mean over the time) and 1/4 (of the mean velocity).
MEAN_SQUARE_WEIGHT = 0.29

# Rows of the work array of `times_of_lengths`, one column for each tracer.
LENGTH = 0  # requested: the length
SPEED2 = 1  # the square of the speed
ALONG = 2  # the velocity along the field
ACROSS2 = 3  # the square of that across
DURATION = 4  # the answer: the time
QUALITY = 5  # whether it is good enough (0 or more)
# Working memory, in units in which the length and speed^2 + field length are 1.
_S0 = 6  # speed where the length begins
_U0 = 7  # velocity along the field there
_W2 = 8  # square of the velocity across
_G = 9  # field
_LOW = 10  # lower bound of the time
_HIGH = 11  # upper bound of the time
ROWS = 12  # number of rows


@inlined
def length_of(
    duration: float, s0: float, u0: float, w2: float, field: float
) -> tuple[float, float, float]:
    """Return the length of a piece of a parabola, then u and the speed at its end.

    Parameters
    ----------
    duration : the time that it takes
    s0, u0 : speed and velocity along the field where it begins
    w2 : square of the velocity across
    field : not negative. NaN at rest without one
    """
    u1 = u0 + field * duration
    s1 = sqrt(u1 * u1 + w2)
    speed_sum = s0 + s1
    r = field * duration / speed_sum
    x = r * r
    if x < SERIES_BELOW:
        bend = 1 / 11 + x * (1 / 13 + x * (1 / 15 + x * (1 / 17 + x / 19)))
        bend = 1 / 3 + x * (1 / 5 + x * (1 / 7 + x * (1 / 9 + x * bend)))
        bend = 1.0 + x * bend
    else:
        bend = 0.5 * log((1.0 + r) / max(1.0 - r, ROUNDING)) / r
    u_sum = u0 + u1
    square = speed_sum * speed_sum + u_sum * u_sum + 4.0 * w2 * bend
    return duration * square / (4.0 * speed_sum), u1, s1


@inlined
def length_flown(vx: float, vy: float, vz: float, duration: float, field: float) -> float:
    """Return the length of a piece of a parabola, from the velocity where it begins."""
    if not duration > 0.0:
        return 0.0
    along = copysign(1.0, field) * vx
    across2 = vy * vy + vz * vz
    speed = sqrt(vx * vx + across2)
    return length_of(duration, speed, along, across2, abs(field))[0]


@inlined
def time_to_reach(distance: float, along: float, field: float) -> float:
    """Return the time until a tracer is first so far along the field, a distance above 0."""
    root = sqrt(along * along + 2.0 * field * distance)
    return 2.0 * distance / (along + root) if along >= 0.0 else (root - along) / field


@inlined
def _time_bounds(s0: float, u0: float, g: float) -> tuple[float, float]:
    """Return the times that a length of 1 takes at least (u the speed) and at most (w = 0)."""
    size = abs(u0)
    square = u0 * u0 + (2.0 * g if u0 >= 0.0 else -2.0 * g)
    root = sqrt(abs(square))
    numerator = size + root if square < 0.0 else 2.0
    denominator = g if square < 0.0 else size + root
    return 2.0 / (s0 + sqrt(s0 * s0 + 2.0 * g)), numerator / denominator


@inlined
def _guess_time(s0: float, u0: float, g: float, low: float, high: float) -> float:
    """Return a time within its bounds, with the root mean square of the speed as its mean."""
    t = 1.0 / sqrt(s0 * s0 + u0 * g * high + g * g * high * high * (1 / 3))
    t = t if t > low else low
    t = 1.0 / sqrt(s0 * s0 + u0 * g * t + g * g * t * t * MEAN_SQUARE_WEIGHT)
    t = t if t > low else low
    return t if t < high else high


@njit(error_model="numpy")
def time_of_length(
    length: float, speed: float, along: float, across2: float, field: float
) -> float:
    """Return the time that a tracer takes for a length of its parabola: Halley's method in bounds.

    Parameters
    ----------
    length : above 0
    speed, along : speed and velocity along the field where it begins
    across2 : square of the velocity across
    field : above 0
    """
    unit = sqrt(speed * speed + field * length)
    s0 = speed / unit
    u0 = along / unit
    w2 = across2 / (unit * unit)
    g = field * length / (unit * unit)
    low, high = _time_bounds(s0, u0, g)
    t = _guess_time(s0, u0, g, low, high)
    for _ in range(MOST_STEPS):
        reached, u1, s1 = length_of(t, s0, u0, w2, g)
        excess = reached - 1.0
        if excess > 0.0:
            high = t
        else:
            low = t
        h = excess / s1
        if abs(h) <= SMALLEST_STEP * t:
            break
        bent = g * h / s1
        improved = t - h / (1.0 - 0.5 * bent * u1 / s1)
        if not low <= improved <= high:
            t = 0.5 * (low + high)
            continue
        t = improved
        if bent * bent * abs(h) < ROUNDING * t:
            break
    return t * length / unit


# -- many tracers at once --------------------------------------------------------------------------


@inlined
def request_time(
    work: np.ndarray, a: int, length: float, along: float, vy: float, vz: float
) -> None:
    """Enter a length, and the velocity where it begins, in column a of the work array."""
    across2 = vy * vy + vz * vz
    work[LENGTH, a] = length
    work[ALONG, a] = along
    work[ACROSS2, a] = across2
    work[SPEED2, a] = along * along + across2


@inlined
def requested_time(work: np.ndarray, a: int, field: float) -> float:
    """Return the time that the length in column a takes, after `times_of_lengths`."""
    if work[QUALITY, a] >= 0.0:
        return float(work[DURATION, a])
    speed = sqrt(work[SPEED2, a])
    return time_of_length(work[LENGTH, a], speed, work[ALONG, a], work[ACROSS2, a], field)


@inlined
def _halve_argument(y: float) -> float:
    """Return tanh(x/2) for y = tanh(x)."""
    return y / (1.0 + sqrt(1.0 - y * y))


@njit(error_model="numpy")
def times_of_lengths(work: np.ndarray, n: int, field: float) -> None:
    """Find the times that n lengths take, in vectors: loops without branches.

    Row DURATION receives them, where row QUALITY becomes 0 or more; elsewhere `time_of_length` is
    to be asked. The rest of the work array is that of `request_time`. field: above 0.
    """
    length = work[LENGTH]
    speed2 = work[SPEED2]
    along = work[ALONG]
    across2 = work[ACROSS2]
    times = work[DURATION]
    quality = work[QUALITY]
    low = work[_LOW]
    high = work[_HIGH]
    s = work[_S0]
    u = work[_U0]
    w = work[_W2]
    g = work[_G]
    for a in range(n):
        per = 1.0 / (speed2[a] + field * length[a])
        unit = sqrt(per)
        s[a] = sqrt(speed2[a]) * unit
        u[a] = along[a] * unit
        w[a] = across2[a] * per
        g[a] = field * length[a] * per
        low[a], high[a] = _time_bounds(s[a], u[a], g[a])
        times[a] = _guess_time(s[a], u[a], g[a], low[a], high[a])
    for _ in range(STEPS_AT_ONCE):
        for a in range(n):
            t, error = _halley_step(times[a], s[a], u[a], w[a], g[a])
            t = t if t > low[a] else low[a]
            t = t if t < high[a] else high[a]
            times[a] = t
            quality[a] = ROUNDING * t - error
    for a in range(n):
        times[a] *= length[a] / sqrt(speed2[a] + field * length[a])


@inlined
def _halley_step(t: float, s0: float, u0: float, w2: float, g: float) -> tuple[float, float]:
    """Return a better time that a length of 1 takes, and about how large its error is.

    The error is infinite where the series is not good enough.
    """
    u1 = u0 + g * t
    s1 = sqrt(u1 * u1 + w2)
    speed_sum = s0 + s1
    u_sum = u0 + u1
    inverse = 1.0 / speed_sum
    y = g * t * inverse
    y = y if y < 1.0 else 1.0  # by rounding it may be above
    y = _halve_argument(_halve_argument(_halve_argument(y)))
    x = y * y
    bend = 1 / 33
    for k in range(16):
        bend = 1.0 / (31 - 2 * k) + x * bend
    bend *= 8.0 * y * speed_sum / (g * t)
    square = speed_sum * speed_sum + u_sum * u_sum + 4.0 * w2 * bend
    length = t * square * (0.25 * inverse)
    slowness = 1.0 / s1
    h = (length - 1.0) * slowness
    bent = g * h * slowness
    improved = t - h / (1.0 - 0.5 * bent * u1 * slowness)
    error = bent * bent * abs(h) if x < SERIES_AT_ONCE_BELOW else np.inf
    return improved, error
