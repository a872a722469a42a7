"""The event loop of `free_paths` in three dimensions.

A loop of its own, and third coordinates that are not in the lanes: one loop for both was measured,
and the plane was 5 % slower in it.
"""

from math import log
from typing import Any

import numpy as np

from particles.compiled.decorators import inlined, kernel
from particles.events import scatter_in_space
from particles.kernel import columns
from particles.kernel.lane import (
    LANE,
    LANES,
    RUNNING,
    Start,
    fly,
    is_due,
    launch_in_space,
    shift_clock,
)
from particles.kernel.records import (
    QUEUE,
    START_VZ,
    VZ,
    Records,
    Z,
    count_path,
    enter_queue,
    finish,
    queue_output,
)
from particles.streams import FLIGHTS, bits, in_disk, open_stream, uniform

# The third coordinates of a lane: of the unit direction, of the place where this flight began, and
# of the velocity at time 0.
DIRECTION_Z, FLIGHT_Z, LANE_START_VZ = range(3)


@inlined
def _begin(lane: Any, start: Start, records: Records, tracer: int) -> tuple[float, float]:
    """Launch a tracer and open the stream of its random flights.

    Return the third components of its direction and of its velocity.
    """
    lane.stream, lane.gamma = open_stream(
        start.seed, FLIGHTS, start.configuration, start.first + tracer
    )
    return launch_in_space(lane, start, records, tracer)


@kernel
def follow_free_paths_in_space(start: Start, mean_path: float, records: Records) -> None:
    """As `follow_free_paths`, but impact parameters are uniform in the disk across the direction.

    mean_path: the mean free path in d.
    """
    # Taken out of their tuples once, as in `follow`. For the same reason `third` is indexed to the
    # end in the loop: numba would count references to its rows.
    times, scales, paths, grids = records.times, records.scales, records.paths, records.grids
    queue, queued, queue_z = records.queue, records.queued, records.third
    finals, restitution, tangential = records.finals, start.restitution, start.tangential
    last_time = times[times.size - 1] if times.size else np.inf
    lanes, third = np.empty(LANES, LANE), np.zeros((LANES, 3))
    active = launched = min(LANES, start.n)
    for a in range(active):
        uz, vz = _begin(lanes[a], start, records, a)
        third[a, DIRECTION_Z], third[a, LANE_START_VZ] = uz, vz
    a = 0
    while active:
        if a >= active:
            a = 0
        lane = lanes[a]
        ux, uy, uz, draw = lane.ux, lane.uy, third[a, DIRECTION_Z], 2 * lane.collisions
        path = -mean_path * log(uniform(lane.stream, lane.gamma, draw))
        while is_due(lane, path, times.size):
            if queued[0] == QUEUE:
                enter_queue(records)
            row = queued[0]
            done, speed = queue_output(lane, queue[row], times, scales)
            queue_z[row, Z], queue_z[row, VZ] = third[a, FLIGHT_Z] + done * uz, speed * uz
            queue_z[row, START_VZ] = third[a, LANE_START_VZ]
            queued[0] += 1
        path, finished = fly(lane, path, times.size, last_time)
        lane.flight_x += path * ux
        lane.flight_y += path * uy
        third[a, FLIGHT_Z] += path * uz
        status = columns.FINISHED if finished else RUNNING
        if not finished:
            if paths.size:
                count_path(paths, grids, path)
            # The impact parameter is never 0, so the speed ratio is never 0 either.
            impact = in_disk(bits(lane.stream, lane.gamma, draw + 1))
            new, ratio = scatter_in_space((ux, uy, uz), impact, restitution, tangential)
            lane.ux, lane.uy, third[a, DIRECTION_Z] = new
            lane.collisions += 1
            lane.slowness /= ratio
            shift_clock(lane, times)
            if lane.collisions == start.most:
                status = columns.COLLISION_CAP
        if status == RUNNING:
            a += 1
            continue
        finish(lane, status, records)
        if finals.size:
            finals[lane.tracer, columns.FINAL_Z] = third[a, FLIGHT_Z]
        if launched < start.n:
            uz, vz = _begin(lane, start, records, launched)
            third[a, DIRECTION_Z], third[a, FLIGHT_Z], third[a, LANE_START_VZ] = uz, 0.0, vz
            launched += 1
            a += 1
        else:
            active -= 1
            lanes[a] = lanes[active]
            third[a] = third[active]
    enter_queue(records)
