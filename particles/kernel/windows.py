"""Integrals along the path: what the windows of a tracer add up, flight by flight.

The path of a tracer is cut into windows of equal length. In each of them the integrals of
(v/v0)^p cos(m (phi - phi0)) over the path are added up, v0 and phi0 being the speed and the
direction where the window begins; in space the Legendre polynomial P_m of the angle between the two
directions takes the place of the cosine. Along a flight the integrand is constant.

Here `travelled` of a lane is the path since its window began, `output` the number of windows that
it has completed (-1 in the path before the first one), `start_vx`, `start_vy`, `start_vz` the
direction where the window began, and `slowness` v0/v.
"""

from typing import Any, NamedTuple

import numpy as np

from particles.compiled.decorators import by_dimension, inlined
from particles.kernel.lane import Start, launch

# Columns of the totals: windows begun, path in d, collisions, trapped tracers.
WINDOWS, PATH, HITS, CAUGHT = range(4)
TOTALS = 4


class Windows(NamedTuple):
    """What is integrated, and the sums of one configuration.

    times (0,): no output times, which the launch of a lane asks for. orders (n_powers,): m.
    powers (n_powers,): p. paths (n_paths,): where integrals end, increasing, in d; the last one is
    the length of a window. settling: path before the first window, in d. each: windows of a tracer.
    sums (n_paths, n_powers): integrals from one of the paths to the next, over all windows, in d.
    totals (TOTALS,).
    """

    times: np.ndarray
    orders: np.ndarray
    powers: np.ndarray
    paths: np.ndarray
    settling: float
    each: int
    sums: np.ndarray
    totals: np.ndarray


@inlined
def _aim(lane: Any) -> None:
    lane.start_vx, lane.start_vy = lane.ux, lane.uy


@inlined
def _aim_in_space(lane: Any) -> None:
    lane.start_vx, lane.start_vy, lane.start_vz = lane.ux, lane.uy, lane.uz


# Take the present direction as that in which the window begins.
_note_direction = by_dimension(_aim, _aim_in_space)


@inlined
def _chebyshev(lane: Any, m: int) -> float:
    cosine = lane.ux * lane.start_vx + lane.uy * lane.start_vy
    before, value = cosine, 1.0
    for _ in range(m):
        before, value = value, 2.0 * cosine * value - before
    return value


@inlined
def _legendre(lane: Any, m: int) -> float:
    cosine = lane.ux * lane.start_vx + lane.uy * lane.start_vy + lane.uz * lane.start_vz
    before, value = 0.0, 1.0
    for k in range(m):
        before, value = value, ((2 * k + 1) * cosine * value - k * before) / (k + 1)
    return value


# Return the harmonic of order m of the angle to the direction where the window began.
_harmonic = by_dimension(_chebyshev, _legendre)


@inlined
def begin_windows(lane: Any, start: Start, windows: Windows, tracer: int) -> None:
    """Launch a tracer; its first window begins at once or after the settling path."""
    launch(lane, start, windows, tracer)
    lane.output = -1
    if windows.settling == 0.0:
        _begin_window(lane, windows)


@inlined
def _begin_window(lane: Any, windows: Windows) -> None:
    lane.output += 1
    lane.travelled = 0.0
    lane.slowness = 1.0
    _note_direction(lane)
    if lane.output < windows.each:
        windows.totals[WINDOWS] += 1.0


@inlined
def _add(lane: Any, path: float, windows: Windows) -> None:
    """Add a part of a flight that is within one window."""
    orders, powers, paths, sums = windows.orders, windows.powers, windows.paths, windows.sums
    begin, end = lane.travelled, lane.travelled + path
    first = 0
    while paths[first] <= begin and first < paths.size - 1:
        first += 1
    for j in range(orders.size):
        value = _harmonic(lane, orders[j])
        if powers[j] != 0.0:
            value *= lane.slowness ** -powers[j]
        at = begin
        for k in range(first, paths.size):
            to = min(end, paths[k])
            sums[k, j] += value * (to - at)
            at = to
            if at == end:
                break


@inlined
def add_flight(lane: Any, path: float, windows: Windows) -> bool:
    """Add a flight of this length; return whether the last window of the tracer is complete."""
    left = path
    while lane.output < windows.each:
        counted = lane.output >= 0
        length = windows.paths[windows.paths.size - 1] if counted else windows.settling
        room = max(length - lane.travelled, 0.0)
        part = min(left, room)
        if counted:
            _add(lane, part, windows)
        windows.totals[PATH] += part
        lane.travelled += part
        left -= part
        if part < room:
            return False
        _begin_window(lane, windows)
    return True
