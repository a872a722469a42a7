"""What a kernel writes: sums, histograms and raw states at the output times."""

from math import floor, log, log2
from typing import NamedTuple

import numpy as np
from numba import njit

from particles.events import NEVER

# Columns of the moments, each a sum over tracers at one output time.
SAMPLES, SPEED2, SPEED4, R2, R4, COLLISIONS, CORRELATION, CAUGHT = range(8)
MOMENTS = 8

# Rows of the histograms' grids.
SPEED, COMPONENT, DISTANCE, PATH = range(4)

# Inverse speed and time are kept times 2**-64k; k grows as the tracer slows, so neither overflows.
SHIFT = 2.0**64
_LN_SHIFT = log(SHIFT)


class Records(NamedTuple):
    """Arrays that a kernel adds to; those not asked for are empty.

    times, scales (n_times,): output times and the power of 2 that velocities are multiplied by in
    the sums there. moments (n_times, MOMENTS). totals (2,): path and collisions. statuses (4,).
    grids (4, 2): log2 of the lowest edge and bins per octave. speeds, components, distances
    (n_times, bins + 2) and paths (1, bins + 2): counts, the first and last of what is outside.
    positions, velocities (n_times, n, 2) and finals (n, 5) ln v, ln t, x, y, collisions: raw.
    """

    times: np.ndarray
    scales: np.ndarray
    moments: np.ndarray
    totals: np.ndarray
    statuses: np.ndarray
    grids: np.ndarray
    speeds: np.ndarray
    components: np.ndarray
    distances: np.ndarray
    paths: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    finals: np.ndarray


# A queue holds what is to be entered, one row each, and is entered when full: a kernel writes to
# one array in its loop, instead of to all of them. Columns; velocities come times scales[k].
Q_OUTPUT, Q_TRACER, Q_X, Q_Y, Q_VX, Q_VY, Q_OX, Q_OY, Q_COLLISIONS, Q_CAUGHT = range(10)
QUEUE = 1024


@njit(error_model="numpy", forceinline=True)
def _log2(value: float) -> float:
    return log2(value) if value > 0.0 else -NEVER


@njit(error_model="numpy", forceinline=True)
def _count(
    histogram: np.ndarray, row: int, log2_value: float, low: float, per_octave: float
) -> None:
    """Add one to the bin of a value; the first and last bins hold what is below and above."""
    last = histogram.shape[1] - 1
    place = floor((log2_value - low) * per_octave) + 1.0
    if place < 1.0:
        histogram[row, 0] += 1
    elif place >= last:
        histogram[row, last] += 1
    else:
        histogram[row, int(place)] += 1


@njit(error_model="numpy", forceinline=True)
def count_path(paths: np.ndarray, grids: np.ndarray, path: float) -> None:
    """Enter a completed flight in the free-path histogram."""
    _count(paths, 0, _log2(path), grids[PATH, 0], grids[PATH, 1])


@njit(error_model="numpy")
def enter(records: Records, queue: np.ndarray, n: int) -> None:
    """Enter the first n rows of a queue in the sums, histograms and raw arrays."""
    moments, scales, grids = records.moments, records.scales, records.grids
    speeds, components, distances = records.speeds, records.components, records.distances
    positions, velocities = records.positions, records.velocities
    for m in range(n):
        k, tracer = int(queue[m, Q_OUTPUT]), int(queue[m, Q_TRACER])
        x, y, vx, vy = queue[m, Q_X], queue[m, Q_Y], queue[m, Q_VX], queue[m, Q_VY]
        r2 = x * x + y * y
        v2 = vx * vx + vy * vy
        moments[k, SAMPLES] += 1.0
        moments[k, SPEED2] += v2
        moments[k, SPEED4] += v2 * v2
        moments[k, R2] += r2
        moments[k, R4] += r2 * r2
        moments[k, COLLISIONS] += queue[m, Q_COLLISIONS]
        moments[k, CORRELATION] += vx * queue[m, Q_OX] + vy * queue[m, Q_OY]
        moments[k, CAUGHT] += queue[m, Q_CAUGHT]
        if speeds.size:
            value = 0.5 * _log2(v2) - log2(scales[k])
            _count(speeds, k, value, grids[SPEED, 0], grids[SPEED, 1])
        if components.size:
            value = _log2(abs(vx)) - log2(scales[k])
            _count(components, k, value, grids[COMPONENT, 0], grids[COMPONENT, 1])
        if distances.size:
            _count(distances, k, 0.5 * _log2(r2), grids[DISTANCE, 0], grids[DISTANCE, 1])
        if positions.size:
            positions[k, tracer, 0] = x
            positions[k, tracer, 1] = y
        if velocities.size:
            velocities[k, tracer, 0] = vx / scales[k]
            velocities[k, tracer, 1] = vy / scales[k]


@njit(error_model="numpy", forceinline=True)
def finish(
    records: Records, tracer: int, status: int, travelled: float, collisions: int,
    x: float, y: float, slowness: float, time: float, shifts: int,
) -> None:  # fmt: skip
    """Enter the end of a tracer."""
    records.totals[0] += travelled
    records.totals[1] += collisions
    records.statuses[status] += 1
    if records.finals.size:
        records.finals[tracer, 0] = -log(slowness) - shifts * _LN_SHIFT
        records.finals[tracer, 1] = (log(time) if time > 0.0 else -NEVER) + shifts * _LN_SHIFT
        records.finals[tracer, 2] = x
        records.finals[tracer, 3] = y
        records.finals[tracer, 4] = collisions
