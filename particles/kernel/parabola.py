"""A flight in a uniform field: a parabola, its length, and the time that a length takes.

The component of the velocity along the field is u + g t, the one across keeps its size w. With
s = sqrt(u^2 + w^2) the speed, at the ends 0 and 1 of a piece of the parabola that takes the time t,

    length = t [(s0 + s1)^2 + (u0 + u1)^2 + 4 w^2 artanh(r)/r] / (4 (s0 + s1)),
    r = (u1 - u0)/(s0 + s1).

No term is negative, so nothing cancels, however weak or strong the field is. The time that a length
takes is found by Halley's method, in units of the length and of V = sqrt(s0^2 + g length), in which
no number is large: `times_of` makes three steps for many tracers at once, in the processor's vector
registers, and leaves the few that need more to `time_of`.
"""

from math import copysign, log, sqrt
from typing import Any

import numpy as np
from numba import njit

from particles.compiled import inlined
from particles.events import MOST_STEPS
from particles.kernel.lane import Start, collide_at_random
from particles.kernel.records import Records

SERIES = 0.03  # artanh(r)/r by nine terms of its series where r^2 is smaller: to 1e-16
# A Halley step of h leaves an error of about (g h / s)^2 h in the time; rounding is 1e-16 of it.
LEFT = 1e-16
SMALLEST_STEP = 4.0 * LEFT  # of the time, in proportion, is rounding
# For many tracers at once: artanh(r) = 8 artanh(y) with y of three halvings, and seventeen terms of
# the series, to 1e-16 where y^2 is smaller than this.
STEPS = 3
SERIES_AT_ONCE = 0.12
# Rows of the work array of `times_of`: what is given, then the solution, then working memory.
PATH, SPEED2, ALONG, ACROSS2, LASTS, GOOD, _S0, _U0, _W2, _G, _LOW, _HIGH, ROWS = range(13)


@inlined
def length_of(
    lasts: float, s0: float, u0: float, w2: float, field: float
) -> tuple[float, float, float]:
    """Return the length of a piece of a parabola, then u and the speed at its end.

    lasts: the time it takes. s0, u0, w2: as above. field: not negative. NaN at rest without one.
    """
    u1 = u0 + field * lasts
    s1 = sqrt(u1 * u1 + w2)
    both = s0 + s1
    r = field * lasts / both
    x = r * r
    if x < SERIES:
        bend = 1 / 11 + x * (1 / 13 + x * (1 / 15 + x * (1 / 17 + x / 19)))
        bend = 1 / 3 + x * (1 / 5 + x * (1 / 7 + x * (1 / 9 + x * bend)))
        bend = 1.0 + x * bend
    else:
        bend = 0.5 * log((1.0 + r) / max(1.0 - r, LEFT)) / r
    ahead = u0 + u1
    return lasts * (both * both + ahead * ahead + 4.0 * w2 * bend) / (4.0 * both), u1, s1


@inlined
def length_flown(vx: float, vy: float, vz: float, lasts: float, field: float) -> float:
    """Return the length of a piece of a parabola, from its first velocity and the time it takes."""
    if not lasts > 0.0:
        return 0.0
    along, across2 = copysign(1.0, field) * vx, vy * vy + vz * vz
    return length_of(lasts, sqrt(vx * vx + across2), along, across2, abs(field))[0]


@inlined
def time_to_reach(distance: float, along: float, field: float) -> float:
    """Return the time until a tracer first is so far along the field; distance: above 0."""
    root = sqrt(along * along + 2.0 * field * distance)
    return 2.0 * distance / (along + root) if along >= 0.0 else (root - along) / field


@inlined
def _bounds(s0: float, u0: float, g: float) -> tuple[float, float]:
    """Return the times that a length of 1 takes at least (u the speed) and at most (w = 0)."""
    size = abs(u0)
    square = u0 * u0 + (2.0 * g if u0 >= 0.0 else -2.0 * g)
    root = sqrt(abs(square))
    above = size + root if square < 0.0 else 2.0
    below = g if square < 0.0 else size + root
    return 2.0 / (s0 + sqrt(s0 * s0 + 2.0 * g)), above / below


@inlined
def _first_guess(s0: float, u0: float, g: float, low: float, high: float) -> float:
    """Return a time within its bounds, with the root mean square of the speed as its mean."""
    t = 1.0 / sqrt(s0 * s0 + u0 * g * high + g * g * high * high * (1 / 3))
    t = t if t > low else low
    # A mean of speed^2 that is between that over the time and that of the mean velocity: 1/3, 1/4.
    t = 1.0 / sqrt(s0 * s0 + u0 * g * t + g * g * t * t * 0.29)
    t = t if t > low else low
    return t if t < high else high


@njit(error_model="numpy")
def time_of(path: float, speed: float, along: float, across2: float, field: float) -> float:
    """Return the time that a length of its parabola takes a tracer, by Halley's method in bounds.

    speed, along: where it begins; across2: square of the velocity across. field: above 0.
    """
    unit = sqrt(speed * speed + field * path)
    s0, u0, w2 = speed / unit, along / unit, across2 / (unit * unit)
    g = field * path / (unit * unit)
    low, high = _bounds(s0, u0, g)
    t = _first_guess(s0, u0, g, low, high)
    for _ in range(MOST_STEPS):
        length, u1, s1 = length_of(t, s0, u0, w2, g)
        excess = length - 1.0
        if excess > 0.0:
            high = t
        else:
            low = t
        h = excess / s1
        if abs(h) <= SMALLEST_STEP * t:
            break
        bent = g * h / s1
        after = t - h / (1.0 - 0.5 * bent * u1 / s1)
        if not low <= after <= high:
            t = 0.5 * (low + high)
            continue
        t = after
        if bent * bent * abs(h) < LEFT * t:
            break
    return t * path / unit


@inlined
def _halved(y: float) -> float:  # tanh of half the argument of which y is the tanh
    return y / (1.0 + sqrt(1.0 - y * y))


@njit(error_model="numpy")
def times_of(work: np.ndarray, n: int, field: float) -> None:
    """Find the times that n lengths take, in vectors: loops without branches.

    LASTS receives them where GOOD becomes 0 or more; elsewhere `time_of` is to be asked.
    """
    path, speed2, along, across2 = work[PATH], work[SPEED2], work[ALONG], work[ACROSS2]
    times, good, low, high = work[LASTS], work[GOOD], work[_LOW], work[_HIGH]
    s, u, w, g = work[_S0], work[_U0], work[_W2], work[_G]
    for a in range(n):
        per = 1.0 / (speed2[a] + field * path[a])
        unit = sqrt(per)
        s[a], u[a] = sqrt(speed2[a]) * unit, along[a] * unit
        w[a], g[a] = across2[a] * per, field * path[a] * per
        low[a], high[a] = _bounds(s[a], u[a], g[a])
        times[a] = _first_guess(s[a], u[a], g[a], low[a], high[a])
    for _ in range(STEPS):
        for a in range(n):
            t = times[a]
            u1 = u[a] + g[a] * t
            s1 = sqrt(u1 * u1 + w[a])
            both, ahead = s[a] + s1, u[a] + u1
            inverse = 1.0 / both
            y = g[a] * t * inverse
            y = y if y < 1.0 else 1.0  # by rounding it may be above
            y = _halved(_halved(_halved(y)))
            x = y * y
            bend = 1 / 33
            for k in range(16):
                bend = 1.0 / (31 - 2 * k) + x * bend
            bend *= 8.0 * y * both / (g[a] * t)
            length = t * (both * both + ahead * ahead + 4.0 * w[a] * bend) * (0.25 * inverse)
            slowness = 1.0 / s1
            h = (length - 1.0) * slowness
            bent = g[a] * h * slowness
            t -= h / (1.0 - 0.5 * bent * u1 * slowness)
            t = t if t > low[a] else low[a]
            t = t if t < high[a] else high[a]
            times[a] = t
            good[a] = LEFT * t - bent * bent * abs(h) if x < SERIES_AT_ONCE else -1.0
    for a in range(n):
        times[a] *= path[a] / sqrt(speed2[a] + field * path[a])


@inlined
def ask(work: np.ndarray, a: int, path: float, along: float, vy: float, vz: float) -> None:
    """Enter number a of what `times_of` is asked: a length, and the velocity where it begins."""
    across2 = vy * vy + vz * vz
    work[PATH, a], work[ALONG, a], work[ACROSS2, a] = path, along, across2
    work[SPEED2, a] = along * along + across2


@inlined
def answer(work: np.ndarray, a: int, field: float) -> float:
    """Return the time that number a takes."""
    if work[GOOD, a] >= 0.0:
        return float(work[LASTS, a])
    speed = sqrt(work[SPEED2, a])
    return time_of(work[PATH, a], speed, work[ALONG, a], work[ACROSS2, a], field)


@inlined
def note_passage(lane: Any, x: float, lasts: float, field: float, records: Records) -> None:
    """Note when x first has the value depth on this piece of the parabola, which begins at x."""
    if records.passages[lane.tracer] == np.inf:
        towards = copysign(1.0, field)
        left = towards * (records.depth - x)
        reaches = time_to_reach(left, towards * lane.vx, abs(field)) if left > 0.0 else 0.0
        if reaches <= lasts:
            records.passages[lane.tracer] = lane.time + reaches


@inlined
def move_freely(lane: Any, lasts: float, field: float) -> None:
    """Move a lane without scatterers along its parabola for so long."""
    lane.time += lasts
    lane.flight_x += (lane.vx + 0.5 * field * lasts) * lasts
    lane.flight_y += lane.vy * lasts
    lane.flight_z += lane.vz * lasts
    lane.vx += field * lasts


@inlined
def collide_freely(lane: Any, start: Start) -> None:
    """Collide without scatterers, with an impact parameter at random."""
    speed = sqrt(lane.vx * lane.vx + lane.vy * lane.vy + lane.vz * lane.vz)
    lane.ux, lane.uy, lane.uz = lane.vx / speed, lane.vy / speed, lane.vz / speed
    speed *= collide_at_random(lane, start, None)
    lane.vx, lane.vy, lane.vz = speed * lane.ux, speed * lane.uy, speed * lane.uz
