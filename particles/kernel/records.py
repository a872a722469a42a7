"""What a kernel records: sums, histograms and raw states at the output times."""

from collections.abc import Mapping
from math import floor, log, log2
from typing import Any, NamedTuple

import numpy as np

from particles.compiled.decorators import by_dimension, called, inlined
from particles.events import NEVER
from particles.kernel import columns

_LN_SHIFT = 64.0 * log(2.0)  # of the slowness and the time of a lane (particles.kernel.lane)


def record_type(*groups: Mapping[Any, tuple[str, ...]]) -> np.dtype:
    """Return the type of a record with these fields, kind of number -> names.

    Of type np.record, so that `lane.x` is read in the same way compiled and interpreted. A record
    for space must not begin with the fields of the one for the plane: numba would take the one for
    a kind of the other.
    """
    fields = [(n, kind) for group in groups for kind, names in group.items() for n in names]
    return np.dtype((np.record, np.dtype(fields, align=True)))


# States at output times wait in a queue and are entered in the sums when it is full: the kernels'
# loop then writes to one array instead of to all of them. Velocities are times Records.scales.
_FIELDS = {
    np.float64: ("x", "y", "vx", "vy", "start_vx", "start_vy", "caught"),
    np.int64: ("output", "tracer", "collisions"),
}
OUTPUT_OF = {
    2: record_type(_FIELDS),
    3: record_type({np.float64: ("z", "vz", "start_vz")}, _FIELDS),
}
QUEUE = 1024


class Records(NamedTuple):
    """Arrays that a kernel adds to; those not asked for are empty. Columns: kernel.columns.

    times, scales (n_times,): output times in d/U, and the power of 2 that velocities are multiplied
    by in the sums there. moments (n_times, MOMENTS), totals (TOTALS,), statuses (STATUSES,).
    grids (4, 2): log2 of the lowest edge and bins per octave of each histogram. speeds, components,
    distances (n_times, bins + 2) and paths (1, bins + 2): counts, the first and the last of what
    lies outside. positions, velocities (n_times, n, dimension) and finals
    (n, FINALS[dimension]): raw, in d and U. queue (QUEUE,) of OUTPUT_OF[dimension] and queued (1,):
    states that wait, and their number.
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
    queue: np.ndarray
    queued: np.ndarray


@inlined
def _log2(value: float) -> float:
    return log2(value) if value > 0.0 else -NEVER


@inlined
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


@inlined
def count_path(paths: np.ndarray, grids: np.ndarray, path: float) -> None:
    """Enter a completed flight in the histogram of free paths."""
    _count(paths, 0, _log2(path), grids[columns.PATH])


@inlined
def _fill_constants(lane: Any, row: Any) -> None:
    """Fill in what of a lane's state does not change in a flight."""
    row.output, row.tracer, row.collisions = lane.output, lane.tracer, lane.collisions
    row.start_vx, row.start_vy = lane.start_vx, lane.start_vy


@inlined
def _queue_output(
    lane: Any, row: Any, times: np.ndarray, scales: np.ndarray
) -> tuple[float, float]:
    """Return the path since the flight began, and the speed times the scale of this time."""
    k = lane.output
    _fill_constants(lane, row)
    # Negative only for output times that `unit` has rounded to 0; they pass within 1e-8 d.
    done = max((lane.next_output - lane.time) / lane.slowness, 0.0)
    speed = scales[k] * lane.unit / lane.slowness
    row.x, row.y = lane.flight_x + done * lane.ux, lane.flight_y + done * lane.uy
    row.vx, row.vy = speed * lane.ux, speed * lane.uy
    row.caught = 0.0
    lane.output = k + 1
    lane.next_output = times[k + 1] * lane.unit if k + 1 < times.size else np.inf
    return done, speed


@inlined
def _queue_output_in_space(
    lane: Any, row: Any, times: np.ndarray, scales: np.ndarray
) -> tuple[float, float]:
    done, speed = _queue_output(lane, row, times, scales)
    row.z, row.vz, row.start_vz = lane.flight_z + done * lane.uz, speed * lane.uz, lane.start_vz
    return done, speed


# Fill a row of the queue with the state of a lane at its next output time, in its flight.
queue_output = by_dimension(_queue_output, _queue_output_in_space)


@inlined
def _rest(lane: Any, row: Any) -> None:
    row.x, row.y, row.vx, row.vy = lane.flight_x, lane.flight_y, 0.0, 0.0
    row.caught = 1.0


@inlined
def _rest_in_space(lane: Any, row: Any) -> None:
    _rest(lane, row)
    row.z, row.vz, row.start_vz = lane.flight_z, 0.0, lane.start_vz


_fill_rest = by_dimension(_rest, _rest_in_space)


@inlined
def queue_rest(lane: Any, records: Records) -> None:
    """Queue a trapped tracer for all output times that are left: at rest where the flight began."""
    while lane.output < records.times.size:
        if records.queued[0] == QUEUE:
            enter_queue(records)
        row = records.queue[records.queued[0]]
        records.queued[0] += 1
        _fill_constants(lane, row)
        _fill_rest(lane, row)
        lane.output += 1


@inlined
def _third(row: Any) -> tuple[float, float, float]:
    return 0.0, 0.0, 0.0


@inlined
def _third_in_space(row: Any) -> tuple[float, float, float]:
    return row.z, row.vz, row.start_vz


# Return the third coordinates of the place, the velocity and the velocity at time 0.
_third_coordinates = by_dimension(_third, _third_in_space)


@called
def enter_queue(records: Records) -> None:
    """Enter the states that wait in the sums, histograms and raw arrays; empty the queue."""
    moments, scales, grids, queue = records.moments, records.scales, records.grids, records.queue
    speeds, components, distances = records.speeds, records.components, records.distances
    positions, velocities = records.positions, records.velocities
    for m in range(records.queued[0]):
        row = queue[m]
        k, x, y, vx, vy = row.output, row.x, row.y, row.vx, row.vy
        z, vz, start_vz = _third_coordinates(row)
        r2 = x * x + y * y + z * z
        v2 = vx * vx + vy * vy + vz * vz
        correlation = vx * row.start_vx + vy * row.start_vy + vz * start_vz
        moments[k, columns.SAMPLES] += 1.0
        moments[k, columns.SPEED2] += v2
        moments[k, columns.SPEED4] += v2 * v2
        moments[k, columns.R2] += r2
        moments[k, columns.R4] += r2 * r2
        moments[k, columns.COLLISIONS] += row.collisions
        moments[k, columns.CORRELATION] += correlation
        moments[k, columns.CAUGHT] += row.caught
        if speeds.size:
            _count(speeds, k, 0.5 * _log2(v2) - log2(scales[k]), grids[columns.SPEED])
        if components.size:
            _count(components, k, _log2(abs(vx)) - log2(scales[k]), grids[columns.COMPONENT])
        if distances.size:
            _count(distances, k, 0.5 * _log2(r2), grids[columns.DISTANCE])
        if positions.size:
            positions[k, row.tracer, 0] = x
            positions[k, row.tracer, 1] = y
            if positions.shape[2] > 2:
                positions[k, row.tracer, 2] = z
        if velocities.size:
            velocities[k, row.tracer, 0] = vx / scales[k]
            velocities[k, row.tracer, 1] = vy / scales[k]
            if velocities.shape[2] > 2:
                velocities[k, row.tracer, 2] = vz / scales[k]
    records.queued[0] = 0


@inlined
def _finish(lane: Any, status: int, records: Records) -> None:
    records.totals[columns.TRAVELLED] += lane.travelled
    records.totals[columns.ALL_COLLISIONS] += lane.collisions
    records.statuses[status] += 1
    if records.finals.size:
        end, shift = records.finals[lane.tracer], lane.shifts * _LN_SHIFT
        end[columns.LN_SPEED] = -log(lane.slowness) - shift
        end[columns.LN_TIME] = (log(lane.time) if lane.time > 0.0 else -NEVER) + shift
        end[columns.FINAL_X] = lane.flight_x
        end[columns.FINAL_Y] = lane.flight_y
        end[columns.FINAL_COLLISIONS] = lane.collisions


@inlined
def _finish_in_space(lane: Any, status: int, records: Records) -> None:
    _finish(lane, status, records)
    if records.finals.size:
        records.finals[lane.tracer, columns.FINAL_Z] = lane.flight_z


# Enter the end of a tracer, at the place where its flight began.
finish = by_dimension(_finish, _finish_in_space)
