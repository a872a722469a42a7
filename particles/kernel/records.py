"""What a kernel records: sums, histograms and raw states at the output times.

States at output times wait in a queue and are entered in the sums when it is full (`enter_queue`):
the loop of a kernel then writes to one array instead of to all of them.

d is the diameter of a scatterer and of the tracer, U the standard deviation of one component of the
initial velocity. A tracer that is caught is trapped (its bounces in a corner never end, or it has
come to rest) or captured (it sticks to a scatterer): see the statuses in `outputs`.
"""

from math import floor, log, log2
from typing import NamedTuple

import numpy as np

from particles import outputs
from particles.compiled import called, inlined
from particles.events import NEVER
from particles.kernel.straight_flight import SHIFT, StraightTracer
from particles.kernel.tracer import Tracer, VelocityTracer, record_type

#: Logarithm of `SHIFT`, the factor between two units of slowness and time of a tracer: by it ln(v)
#: and ln(t) differ for each change of unit.
LN_SHIFT = log(SHIFT)
#: Logarithm of `SHIFT` to base 2, as the bins of histograms are even in log2.
LOG2_SHIFT = log2(SHIFT)
#: States that the queue has room for: when it is full they are entered in the sums. Chosen: only
#: the speed could depend on it, but with 256 to 4096 a run of 3 million outputs takes the same time
#: within 3 %.
QUEUE = 1024
#: Index into `Records.filled`: states that wait in the queue.
WAITING = 0
#: Index into `Records.filled`: rows of `Records.traps`.
TRAP_ROWS = 1


class OutputState:
    """The state of a tracer at an output time."""

    output: int  # number of the output time
    number: int  # of the tracer
    collisions: int
    caught: float  # 1 for a trapped or captured tracer, else 0
    x: float  # from the start of the tracer, in d
    y: float
    z: float
    vx: float  # velocity times Records.scales
    vy: float
    vz: float
    start_vx: float  # velocity at time 0
    start_vy: float
    start_vz: float


#: Data type of the rows of the queue: one `OutputState` each.
OUTPUT = record_type(OutputState)


class Records(NamedTuple):
    """Arrays that a kernel adds to; those that are not requested are empty. Columns: `outputs`.

    Parameters
    ----------
    times, scales : output times in d/U, and the power of 2 that velocities are multiplied by in the
        sums there, shape (n_times,)
    moments, field_sums : sums over tracers at each output time
    totals, statuses : sums over tracers at their ends, and numbers of tracers
    grids : log2 of the lowest edge and bins per octave of each histogram, shape (5, 2)
    counts : of each histogram, shape (n_times or 1, bins + 2); the first bin is of what lies below
        the lowest edge, the last one of what lies above the highest
    positions, velocities, finals : raw data of each tracer in d and U, shape (n_times, n,
        dimension) and (n, columns)
    passages : infinite at first; receives the times at which x first has the value `depth` (in d),
        shape (n,)
    traps : the trapped and captured tracers
    queue : states that wait, shape (QUEUE,)
    filled : how many states wait, and how many rows of traps are filled, shape (2,)
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


# -- histograms ------------------------------------------------------------------------------------


@inlined
def _log2(number: float) -> float:
    """Return the logarithm to base 2; of 0 -NEVER, -1e300, which falls into the first bin."""
    return log2(number) if number > 0.0 else -NEVER


@inlined
def _count(histogram: np.ndarray, row: int, log2_value: float, grid: np.ndarray) -> None:
    """Add one to the bin of a value."""
    above = histogram.shape[1] - 1
    place = floor((log2_value - grid[0]) * grid[1]) + 1.0
    if place < 1.0:
        histogram[row, 0] += 1
    elif place >= above:
        histogram[row, above] += 1
    else:
        histogram[row, int(place)] += 1


class FlightHistograms(NamedTuple):
    """The histograms of completed flights, and their grids, out of `Records`.

    A kernel takes them out of its records once, as it does with all arrays that it needs in its
    loop: there, numba would count references to all of `Records` each time.
    """

    paths: np.ndarray
    durations: np.ndarray
    grids: np.ndarray


@inlined
def flight_histograms(records: Records) -> FlightHistograms:
    """Return the histograms of completed flights."""
    paths = records.counts[outputs.PATH]
    durations = records.counts[outputs.DURATION]
    return FlightHistograms(paths, durations, records.grids)


@inlined
def count_flight(histograms: FlightHistograms, path: float, duration: float, shifts: int) -> None:
    """Enter a completed flight in the histograms.

    duration: in the tracer's unit of time, 2^(64 shifts) of the run's.
    """
    if histograms.paths.size:
        _count(histograms.paths, 0, _log2(path), histograms.grids[outputs.PATH])
    if histograms.durations.size:
        log2_duration = _log2(duration) + LOG2_SHIFT * shifts
        _count(histograms.durations, 0, log2_duration, histograms.grids[outputs.DURATION])


# -- states at output times ------------------------------------------------------------------------

# Inlined: to a function that is called, all arrays of `Records` would be passed on the stack, 158
# words that take eight times as long as the rest of an output.


@inlined
def _next_row(tracer: Tracer, caught: float, records: Records) -> OutputState:
    """Return the next row of the queue, with what does not change in a flight; count the output."""
    if records.filled[WAITING] == QUEUE:
        enter_queue(records)
    row = records.queue[records.filled[WAITING]]
    records.filled[WAITING] += 1
    row.output = tracer.output
    row.number = tracer.number
    row.collisions = tracer.collisions
    row.start_vx = tracer.start_vx
    row.start_vy = tracer.start_vy
    row.start_vz = tracer.start_vz
    row.caught = caught
    tracer.output += 1
    return row


@inlined
def queue_output(tracer: StraightTracer, records: Records) -> None:
    """Queue the state of a tracer at its next output time, in its straight flight."""
    times = records.times
    scale = records.scales[tracer.output]
    row = _next_row(tracer, 0.0, records)
    # Negative only for output times whose product with `unit` is rounded to 0. Until these the
    # tracer moves by less than 2^-64 d: the product is below 2^-1074 and `slowness` above 1, or
    # `unit` itself is 0, where speeds are below 2^-1088 U and times below 2^1024 d/U.
    path = max((tracer.next_output - tracer.time) / tracer.slowness, 0.0)
    speed = scale * tracer.unit / tracer.slowness
    row.x = tracer.flight_x + path * tracer.ux
    row.y = tracer.flight_y + path * tracer.uy
    row.z = tracer.flight_z + path * tracer.uz
    row.vx = speed * tracer.ux
    row.vy = speed * tracer.uy
    row.vz = speed * tracer.uz
    tracer.next_output = np.inf
    if tracer.output < times.size:
        tracer.next_output = times[tracer.output] * tracer.unit


@inlined
def queue_in_field(tracer: VelocityTracer, records: Records, field: float) -> None:
    """Queue the state of a tracer at its next output time, on its parabola.

    In a field, or driven, scales and units of time are 1.
    """
    times = records.times
    row = _next_row(tracer, 0.0, records)
    t = max(tracer.next_output - tracer.time, 0.0)
    row.x = tracer.flight_x + (tracer.vx + 0.5 * field * t) * t
    row.y = tracer.flight_y + tracer.vy * t
    row.z = tracer.flight_z + tracer.vz * t
    row.vx = tracer.vx + field * t
    row.vy = tracer.vy
    row.vz = tracer.vz
    tracer.next_output = times[tracer.output] if tracer.output < times.size else np.inf


@called
def enter_queue(records: Records) -> None:
    """Enter the states that wait in the sums, histograms and raw arrays; empty the queue."""
    # Taken out of the tuple once: in the loop, numba would count references to them each time.
    moments = records.moments
    scales = records.scales
    grids = records.grids
    queue = records.queue
    speeds, components, distances = records.counts[: outputs.PATH]
    positions = records.positions
    velocities = records.velocities
    field_sums = records.field_sums
    for m in range(records.filled[WAITING]):
        state = queue[m]
        k = state.output
        x = state.x
        y = state.y
        z = state.z
        vx = state.vx
        vy = state.vy
        vz = state.vz
        r2 = x * x + y * y + z * z
        v2 = vx * vx + vy * vy + vz * vz
        correlation = vx * state.start_vx + vy * state.start_vy + vz * state.start_vz
        moments[k, outputs.SAMPLES] += 1.0
        moments[k, outputs.SPEED2] += v2
        moments[k, outputs.SPEED4] += v2 * v2
        moments[k, outputs.R2] += r2
        moments[k, outputs.R4] += r2 * r2
        moments[k, outputs.COLLISIONS] += state.collisions
        moments[k, outputs.CORRELATION] += correlation
        moments[k, outputs.CAUGHT] += state.caught
        if field_sums.size:
            half = field_sums.shape[1] // 2
            dimension = 2 if field_sums.shape[1] == outputs.FIELD_SUMS_IN_PLANE else 3
            _add_products(field_sums[k], 0, (vx, vy, vz), dimension)
            _add_products(field_sums[k], half, (x, y, z), dimension)
        if speeds.size:
            _count(speeds, k, 0.5 * _log2(v2) - log2(scales[k]), grids[outputs.SPEED])
        if components.size:
            _count(components, k, _log2(abs(vx)) - log2(scales[k]), grids[outputs.COMPONENT])
        if distances.size:
            _count(distances, k, 0.5 * _log2(r2), grids[outputs.DISTANCE])
        if positions.size:
            _store(positions[k, state.number], x, y, z)
        if velocities.size:
            scale = scales[k]
            _store(velocities[k, state.number], vx / scale, vy / scale, vz / scale)
    records.filled[WAITING] = 0


@inlined
def _add_products(
    sums: np.ndarray, column: int, vector: tuple[float, float, float], dimension: int
) -> None:
    """Add the components of a vector, then the products of each two of them, from a column on."""
    for a in range(dimension):
        sums[column + a] += vector[a]
    product = column + dimension
    for a in range(dimension):
        for b in range(a, dimension):
            sums[product] += vector[a] * vector[b]
            product += 1


@inlined
def _store(vector: np.ndarray, x: float, y: float, z: float) -> None:
    """Store a vector in an array of two or three numbers."""
    vector[0] = x
    vector[1] = y
    if vector.size > 2:
        vector[2] = z


# -- ends of tracers -------------------------------------------------------------------------------


@inlined
def finish(tracer: Tracer, status: int, first_number: int, records: Records) -> None:
    """Enter the end of a tracer, where its kernel has moved it; one that is caught rests there.

    Kernels move the place where the flight began (`flight_x`, ...) to the end of the tracer first.

    first_number: of the tracers of the batch.
    """
    if status in (outputs.TRAPPED, outputs.CAPTURED):
        _record_trap(tracer, first_number, records)
    records.totals[outputs.TRAVELLED] += tracer.travelled
    records.totals[outputs.ALL_COLLISIONS] += tracer.collisions
    records.statuses[status] += 1
    if records.finals.size:
        end = records.finals[tracer.number]
        ln_shifts = tracer.shifts * LN_SHIFT
        end[outputs.LN_SPEED] = -log(tracer.slowness) - ln_shifts
        end[outputs.LN_TIME] = (log(tracer.time) if tracer.time > 0.0 else -NEVER) + ln_shifts
        end[outputs.FINAL_X] = tracer.flight_x
        end[outputs.FINAL_Y] = tracer.flight_y
        end[outputs.FINAL_COLLISIONS] = tracer.collisions
        if end.size > outputs.FINAL_Z:
            end[outputs.FINAL_Z] = tracer.flight_z


@called
def _record_trap(tracer: Tracer, first_number: int, records: Records) -> None:
    """Record where and when a tracer was caught; it rests there at all outputs to come."""
    while tracer.output < records.times.size:
        row = _next_row(tracer, 1.0, records)
        row.x = tracer.flight_x
        row.y = tracer.flight_y
        row.z = tracer.flight_z
        row.vx = row.vy = row.vz = 0.0
    trap = records.traps[records.filled[TRAP_ROWS]]
    records.filled[TRAP_ROWS] += 1
    trap[outputs.TRAP_TRACER] = first_number + tracer.number
    trap[outputs.TRAP_TIME] = tracer.time / tracer.unit
    _store(trap[outputs.TRAP_X :], tracer.flight_x, tracer.flight_y, tracer.flight_z)
