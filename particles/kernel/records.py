"""What a kernel records: sums, histograms and raw states at the output times."""

from math import floor, log, log2, sqrt
from typing import Any, NamedTuple

import numpy as np

from particles import outputs
from particles.compiled import called, inlined
from particles.events import NEVER
from particles.kernel.lane import AT_REST, record_type

_LN_SHIFT = 64.0 * log(2.0)  # of the slowness and the time of a lane (particles.kernel.lane)
# States at output times wait in a queue and are entered in the sums when it is full: the kernels'
# loop then writes to one array instead of to all of them. Velocities are times Records.scales.
OUTPUT = record_type(
    {
        np.float64: (
            "x", "y", "z", "vx", "vy", "vz", "start_vx", "start_vy", "start_vz", "caught",
        ),
        np.int64: ("output", "tracer", "collisions"),
    }
)  # fmt: skip
QUEUE = 1024


class Records(NamedTuple):
    """Arrays that a kernel adds to; those not asked for are empty. Columns: `outputs`.

    times, scales (n_times,): output times in d/U, and the power of 2 that velocities are multiplied
    by in the sums there. grids (5, 2): log2 of the lowest edge and bins per octave of each
    histogram. counts: of each, (n_times or 1, bins + 2), the first and the last of what lies
    outside. positions, velocities (n_times, n, dimension) and finals: raw, in d and U. passages
    (n,), inf, receives the times at which x first has the value depth, in d. traps: the trapped and
    captured tracers. queue (QUEUE,): states that wait. filled (2,): how many wait, and how many
    rows of traps are filled.
    """

    times: np.ndarray
    scales: np.ndarray
    moments: np.ndarray
    totals: np.ndarray
    statuses: np.ndarray
    field_sums: np.ndarray
    grids: np.ndarray
    counts: tuple[np.ndarray, ...]
    positions: np.ndarray
    velocities: np.ndarray
    finals: np.ndarray
    passages: np.ndarray
    depth: float
    traps: np.ndarray
    queue: np.ndarray
    filled: np.ndarray


WAITING, CAUGHT = range(2)


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
def count_flight(
    paths: np.ndarray, durations: np.ndarray, grids: np.ndarray, path: float, lasts: float,
    shifts: int,
) -> None:  # fmt: skip
    """Enter a completed flight; without `Records`, references to which would be counted."""
    if paths.size:
        _count(paths, 0, _log2(path), grids[outputs.PATH])
    if durations.size:
        _count(durations, 0, _log2(lasts) + 64.0 * shifts, grids[outputs.DURATION])


@called
def _next_row(lane: Any, caught: float, records: Records) -> Any:
    """Return the next row of the queue, with what does not change in a flight; count the output."""
    if records.filled[WAITING] == QUEUE:
        enter_queue(records)
    row = records.queue[records.filled[WAITING]]
    records.filled[WAITING] += 1
    row.output, row.tracer, row.collisions = lane.output, lane.tracer, lane.collisions
    row.start_vx, row.start_vy, row.start_vz = lane.start_vx, lane.start_vy, lane.start_vz
    row.caught = caught
    lane.output += 1
    return row


@called
def queue_output(lane: Any, records: Records) -> None:
    """Queue the state of a lane at its next output time, in its flight."""
    scale, times = records.scales[lane.output], records.times
    row = _next_row(lane, 0.0, records)
    # Negative only for output times that `unit` has rounded to 0; they pass within 1e-8 d.
    done = max((lane.next_output - lane.time) / lane.slowness, 0.0)
    speed = scale * lane.unit / lane.slowness
    row.x, row.y = lane.flight_x + done * lane.ux, lane.flight_y + done * lane.uy
    row.z = lane.flight_z + done * lane.uz
    row.vx, row.vy, row.vz = speed * lane.ux, speed * lane.uy, speed * lane.uz
    lane.next_output = times[lane.output] * lane.unit if lane.output < times.size else np.inf


@called
def queue_falling(lane: Any, records: Records, field: float) -> None:
    """As `queue_output`, of a lane on its parabola in a field."""
    row, times = _next_row(lane, 0.0, records), records.times
    done = max(lane.next_output - lane.time, 0.0)
    row.x = lane.flight_x + (lane.vx + 0.5 * field * done) * done
    row.y, row.z = lane.flight_y + lane.vy * done, lane.flight_z + lane.vz * done
    row.vx, row.vy, row.vz = lane.vx + field * done, lane.vy, lane.vz
    lane.next_output = times[lane.output] if lane.output < times.size else np.inf


@called
def _note_trap(lane: Any, first: int, records: Records) -> None:
    """Record where and when a tracer was caught, at rest where its flight began at all outputs."""
    while lane.output < records.times.size:
        row = _next_row(lane, 1.0, records)
        row.x, row.y, row.z = lane.flight_x, lane.flight_y, lane.flight_z
        row.vx = row.vy = row.vz = 0.0
    trap = records.traps[records.filled[CAUGHT]]
    records.filled[CAUGHT] += 1
    trap[outputs.TRAP_TRACER] = first + lane.tracer
    trap[outputs.TRAP_TIME] = lane.time / lane.unit
    _keep(trap[outputs.TRAP_X :], lane.flight_x, lane.flight_y, lane.flight_z)


@called
def enter_queue(records: Records) -> None:
    """Enter the states that wait in the sums, histograms and raw arrays; empty the queue."""
    moments, scales, grids, queue = records.moments, records.scales, records.grids, records.queue
    speeds, components, distances = records.counts[: outputs.PATH]
    positions, velocities, sums = records.positions, records.velocities, records.field_sums
    for m in range(records.filled[WAITING]):
        row = queue[m]
        k, x, y, z = row.output, row.x, row.y, row.z
        vx, vy, vz = row.vx, row.vy, row.vz
        r2 = x * x + y * y + z * z
        v2 = vx * vx + vy * vy + vz * vz
        moments[k, outputs.SAMPLES] += 1.0
        moments[k, outputs.SPEED2] += v2
        moments[k, outputs.SPEED4] += v2 * v2
        moments[k, outputs.R2] += r2
        moments[k, outputs.R4] += r2 * r2
        moments[k, outputs.COLLISIONS] += row.collisions
        moments[k, outputs.CORRELATION] += vx * row.start_vx + vy * row.start_vy + vz * row.start_vz
        moments[k, outputs.CAUGHT] += row.caught
        if sums.size:
            d = 2 if sums.shape[1] == outputs.FIELD_SUMS_IN_PLANE else 3
            _add_products(sums[k], 0, (vx, vy, vz), d)
            _add_products(sums[k], sums.shape[1] // 2, (x, y, z), d)
        if speeds.size:
            _count(speeds, k, 0.5 * _log2(v2) - log2(scales[k]), grids[outputs.SPEED])
        if components.size:
            _count(components, k, _log2(abs(vx)) - log2(scales[k]), grids[outputs.COMPONENT])
        if distances.size:
            _count(distances, k, 0.5 * _log2(r2), grids[outputs.DISTANCE])
        if positions.size:
            _keep(positions[k, row.tracer], x, y, z)
        if velocities.size:
            _keep(velocities[k, row.tracer], vx / scales[k], vy / scales[k], vz / scales[k])
    records.filled[WAITING] = 0


@inlined
def _keep(place: np.ndarray, x: float, y: float, z: float) -> None:
    place[0], place[1] = x, y
    if place.size > 2:
        place[2] = z


@inlined
def _add_products(sums: np.ndarray, first: int, vector: tuple[float, float, float], d: int) -> None:
    """Add the first d components of a vector, then the products of each two, from `first` on."""
    for a in range(d):
        sums[first + a] += vector[a]
    place = first + d
    for a in range(d):
        for b in range(a, d):
            sums[place] += vector[a] * vector[b]
            place += 1


@inlined
def finish(lane: Any, status: int, first: int, records: Records) -> None:
    """Enter the end of a tracer where its flight began; a trapped or captured one rests there."""
    if status in (outputs.TRAPPED, outputs.CAPTURED):
        _note_trap(lane, first, records)
    records.totals[outputs.TRAVELLED] += lane.travelled
    records.totals[outputs.ALL_COLLISIONS] += lane.collisions
    records.statuses[status] += 1
    if records.finals.size:
        end, shift = records.finals[lane.tracer], lane.shifts * _LN_SHIFT
        end[outputs.LN_SPEED] = -log(lane.slowness) - shift
        end[outputs.LN_TIME] = (log(lane.time) if lane.time > 0.0 else -NEVER) + shift
        end[outputs.FINAL_X], end[outputs.FINAL_Y] = lane.flight_x, lane.flight_y
        end[outputs.FINAL_COLLISIONS] = lane.collisions
        if end.size > outputs.FINAL_Z:
            end[outputs.FINAL_Z] = lane.flight_z


@inlined
def note_slowness(lane: Any) -> None:
    """Give a lane with a velocity its slowness."""
    square = lane.vx * lane.vx + (lane.vy * lane.vy + lane.vz * lane.vz)
    lane.slowness = 1.0 / max(sqrt(square), AT_REST)
