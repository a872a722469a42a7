"""What a kernel records besides in a uniform field: averages of vectors and tensors."""

from typing import Any, NamedTuple

import numpy as np

from particles.compiled.decorators import by_dimension, called, inlined
from particles.kernel.records import Records, enter_queue


class Kept(NamedTuple):
    """What a run in a field keeps besides its records.

    sums (n_times, FIELD_SUMS[dimension]). passages (n,), inf, receives the times at which x first
    has the value depth, in d; or (0,).
    """

    sums: np.ndarray
    passages: np.ndarray
    depth: float


@inlined
def _fill_plane(lane: Any, row: Any, times: np.ndarray, field: float) -> float:
    """Return the time since the flight began."""
    k = lane.output
    row.output, row.tracer, row.collisions = k, lane.tracer, lane.collisions
    row.start_vx, row.start_vy = lane.start_vx, lane.start_vy
    row.caught = 0.0
    done = max(lane.next_output - lane.time, 0.0)
    row.x = lane.flight_x + (lane.vx + 0.5 * field * done) * done
    row.y = lane.flight_y + lane.vy * done
    row.vx, row.vy = lane.vx + field * done, lane.vy
    lane.output = k + 1
    lane.next_output = times[k + 1] if k + 1 < times.size else np.inf
    return done


@inlined
def _fill_space(lane: Any, row: Any, times: np.ndarray, field: float) -> float:
    done = _fill_plane(lane, row, times, field)
    row.z, row.vz, row.start_vz = lane.flight_z + lane.vz * done, lane.vz, lane.start_vz
    return done


# Fill a row of the queue with the state of a lane at its next output time, on its parabola.
queue_output_in_field = by_dimension(_fill_plane, _fill_space)


@inlined
def _add_plane(row: Any, sums: np.ndarray) -> float:
    x, y, vx, vy = row.x, row.y, row.vx, row.vy
    parts = (vx, vy, vx * vx, vx * vy, vy * vy, x, y, x * x, x * y, y * y)
    for n in range(10):
        sums[row.output, n] += parts[n]
    return 0.0


@inlined
def _add_space(row: Any, sums: np.ndarray) -> float:
    x, y, z, vx, vy, vz = row.x, row.y, row.z, row.vx, row.vy, row.vz
    parts = (
        vx, vy, vz, vx * vx, vx * vy, vx * vz, vy * vy, vy * vz, vz * vz,
        x, y, z, x * x, x * y, x * z, y * y, y * z, z * z,
    )  # fmt: skip
    for n in range(18):
        sums[row.output, n] += parts[n]
    return 0.0


_add = by_dimension(_add_plane, _add_space)


@called
def enter_queue_in_field(records: Records, sums: np.ndarray) -> None:
    """Enter the states that wait in all sums; empty the queue.

    sums (n_times, FIELD_SUMS[dimension]): columns as in `particles.kernel.columns`.
    """
    for m in range(records.queued[0]):
        _add(records.queue[m], sums)
    enter_queue(records)
