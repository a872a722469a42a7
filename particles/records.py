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


@njit(error_model="numpy", forceinline=True)
def _log2(value: float) -> float:
    return log2(value) if value > 0.0 else -NEVER


@njit(error_model="numpy", forceinline=True)
def _count(histogram: np.ndarray, row: int, log2_value: float, grid: np.ndarray) -> None:
    """Add one to the bin of a value; the first and last bins hold what is below and above."""
    last = histogram.shape[1] - 1
    place = floor((log2_value - grid[0]) * grid[1]) + 1.0
    if place < 1.0:
        histogram[row, 0] += 1
    elif place >= last:
        histogram[row, last] += 1
    else:
        histogram[row, int(place)] += 1


@njit(error_model="numpy", forceinline=True)
def count_path(records: Records, path: float) -> None:
    """Enter a completed flight in the free-path histogram."""
    _count(records.paths, 0, _log2(path), records.grids[PATH])


@njit(error_model="numpy", forceinline=True)
def _record(
    records: Records, k: int, tracer: int, x: float, y: float, vx: float, vy: float,
    ox: float, oy: float, collisions: int, caught: int,
) -> None:  # fmt: skip
    """Enter one tracer at output time k. Velocities come times scales[k]; (ox, oy) is v(0)."""
    r2 = x * x + y * y
    v2 = vx * vx + vy * vy
    row = records.moments[k]
    row[SAMPLES] += 1.0
    row[SPEED2] += v2
    row[SPEED4] += v2 * v2
    row[R2] += r2
    row[R4] += r2 * r2
    row[COLLISIONS] += collisions
    row[CORRELATION] += vx * ox + vy * oy
    row[CAUGHT] += caught
    scale = records.scales[k]
    if records.speeds.size:
        _count(records.speeds, k, 0.5 * _log2(v2) - log2(scale), records.grids[SPEED])
    if records.components.size:
        _count(records.components, k, _log2(abs(vx)) - log2(scale), records.grids[COMPONENT])
    if records.distances.size:
        _count(records.distances, k, 0.5 * _log2(r2), records.grids[DISTANCE])
    if records.positions.size:
        records.positions[k, tracer, 0] = x
        records.positions[k, tracer, 1] = y
    if records.velocities.size:
        records.velocities[k, tracer, 0] = vx / scale
        records.velocities[k, tracer, 1] = vy / scale


@njit(error_model="numpy", forceinline=True)
def fly(
    records: Records, k: int, tracer: int, end: float, time: float, slowness: float, unit: float,
    x: float, y: float, ux: float, uy: float, ox: float, oy: float, collisions: int,
) -> int:  # fmt: skip
    """Enter the output times up to `end` that fall in a flight; return the next output's index.

    (x, y) is the displacement at its beginning; time, end and slowness (1/speed) are times `unit`.
    """
    while k < records.times.size and records.times[k] * unit <= end:
        # Not negative but for outputs that `unit` has rounded to 0: passed within 1e-8 d.
        done = max((records.times[k] * unit - time) / slowness, 0.0)
        speed = records.scales[k] * unit / slowness
        _record(
            records, k, tracer, x + done * ux, y + done * uy, speed * ux, speed * uy, ox, oy,
            collisions, 0,
        )  # fmt: skip
        k += 1
    return k


@njit(error_model="numpy", forceinline=True)
def rest(
    records: Records, k: int, tracer: int, x: float, y: float, ox: float, oy: float, collisions: int
) -> None:
    """Enter a trapped tracer, at rest in its corner, at every output time that is left."""
    while k < records.times.size:
        _record(records, k, tracer, x, y, 0.0, 0.0, ox, oy, collisions, 1)
        k += 1


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
