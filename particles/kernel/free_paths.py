"""The event loop without scatterers: the particle method of the kinetic equation itself.

The plane and three dimensions have one loop, `_follow`. The dimension is a constant of each kernel,
so each is compiled to its own half of what depends on it.
"""

from math import log
from typing import Any

import numpy as np

from particles.compiled.decorators import inlined, kernel
from particles.events import scatter, scatter_in_space
from particles.kernel import columns
from particles.kernel.lane import (
    DIRECTION_Z,
    FLIGHT_Z,
    LANE,
    LANES,
    RUNNING,
    START_VZ,
    Start,
    fly,
    is_due,
    launch,
    launch_in_space,
    shift_clock,
)
from particles.kernel.records import (
    QUEUE,
    QUEUED_START_VZ,
    VZ,
    Records,
    Z,
    count_path,
    enter_queue,
    finish,
    queue_output,
)
from particles.streams import FLIGHTS, bits, in_disk, open_stream, uniform


@inlined
def _begin(
    lane: Any, start: Start, records: Records, tracer: int, dimension: int
) -> tuple[float, float]:
    """Launch a tracer and open the stream of its random flights.

    Return the third components of its direction and of its velocity.
    """
    uz = vz = 0.0
    if dimension == 3:
        uz, vz = launch_in_space(lane, start, records, tracer)
    else:
        launch(lane, start, records, tracer)
    lane.stream, lane.gamma = open_stream(
        start.seed, FLIGHTS, start.configuration, start.first + tracer
    )
    return uz, vz


@inlined
def _follow(start: Start, mean_path: float, records: Records, dimension: int) -> None:
    """Follow tracers through their random flights and collisions, adding to the records."""
    # Taken out of their tuples once, as in `follow`. For the same reason `third` is indexed to the
    # end wherever the loop comes often: numba would count references to its rows.
    times, scales, paths, grids = records.times, records.scales, records.paths, records.grids
    queue, queued, queue_z = records.queue, records.queued, records.third
    finals, restitution, tangential = records.finals, start.restitution, start.tangential
    last_time = times[times.size - 1] if times.size else np.inf
    lanes, third = np.empty(LANES, LANE), np.zeros((LANES, 3))
    active = launched = min(LANES, start.n)
    for a in range(active):
        third[a, DIRECTION_Z], third[a, START_VZ] = _begin(lanes[a], start, records, a, dimension)
    a = 0
    while active:
        if a >= active:
            a = 0
        lane = lanes[a]
        ux, uy, draw = lane.ux, lane.uy, 2 * lane.collisions
        path = -mean_path * log(uniform(lane.stream, lane.gamma, draw))
        while is_due(lane, path, times.size):
            if queued[0] == QUEUE:
                enter_queue(records)
            row = queued[0]
            done, speed = queue_output(lane, queue[row], times, scales)
            if dimension == 3:
                uz = third[a, DIRECTION_Z]
                queue_z[row, Z], queue_z[row, VZ] = third[a, FLIGHT_Z] + done * uz, speed * uz
                queue_z[row, QUEUED_START_VZ] = third[a, START_VZ]
            queued[0] += 1
        path, finished = fly(lane, path, times.size, last_time)
        lane.flight_x += path * ux
        lane.flight_y += path * uy
        if dimension == 3:
            third[a, FLIGHT_Z] += path * third[a, DIRECTION_Z]
        status = columns.FINISHED if finished else RUNNING
        if not finished:
            if paths.size:
                count_path(paths, grids, path)
            # No impact parameter is ever 0, so the speed ratio is never 0 either. In the plane it
            # is an odd multiple of 2**-53, less 1.
            if dimension == 3:
                place = in_disk(bits(lane.stream, lane.gamma, draw + 1))
                old = ux, uy, third[a, DIRECTION_Z]
                new, ratio = scatter_in_space(old, place, restitution, tangential)
                lane.ux, lane.uy, third[a, DIRECTION_Z] = new
            else:
                impact = 2.0 * uniform(lane.stream, lane.gamma, draw + 1) - 1.0
                lane.ux, lane.uy, ratio = scatter(ux, uy, impact, restitution, tangential)
            lane.collisions += 1
            lane.slowness /= ratio
            shift_clock(lane, times)
            if lane.collisions == start.most:
                status = columns.COLLISION_CAP
        if status == RUNNING:
            a += 1
            continue
        finish(lane, status, records)
        if dimension == 3 and finals.size:
            finals[lane.tracer, columns.FINAL_Z] = third[a, FLIGHT_Z]
        if launched < start.n:
            uz, vz = _begin(lane, start, records, launched, dimension)
            third[a, DIRECTION_Z], third[a, FLIGHT_Z], third[a, START_VZ] = uz, 0.0, vz
            launched += 1
            a += 1
        else:
            active -= 1
            lanes[a] = lanes[active]
            if dimension == 3:
                third[a] = third[active]
    enter_queue(records)


@kernel
def follow_free_paths(start: Start, mean_path: float, records: Records) -> None:
    """Follow tracers whose free paths are exponential and whose impact parameters are uniform.

    mean_path: the mean free path in d.
    """
    _follow(start, mean_path, records, 2)


@kernel
def follow_free_paths_in_space(start: Start, mean_path: float, records: Records) -> None:
    """As `follow_free_paths`, in three dimensions: impact parameters are uniform in a disk."""
    _follow(start, mean_path, records, 3)
