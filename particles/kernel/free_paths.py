"""The event loop without scatterers: the particle method of the kinetic equation itself."""

from math import log
from typing import Any

import numpy as np

from particles.compiled.decorators import inlined, kernel
from particles.events import scatter
from particles.kernel import columns
from particles.kernel.lane import LANE, LANES, RUNNING, Start, fly, is_due, launch, shift_clock
from particles.kernel.records import QUEUE, Records, count_path, enter_queue, finish, queue_output
from particles.streams import FLIGHTS, open_stream, uniform


@inlined
def _begin(lane: Any, start: Start, records: Records, tracer: int) -> None:
    """Launch a tracer and open the stream of its random flights."""
    launch(lane, start, records, tracer)
    lane.stream, lane.gamma = open_stream(
        start.seed, FLIGHTS, start.configuration, start.first + tracer
    )


@kernel
def follow_free_paths(start: Start, mean_path: float, records: Records) -> None:
    """Follow tracers whose free paths are exponential and whose impact parameters are uniform.

    mean_path: the mean free path in d.
    """
    # Taken out of their tuples once, as in `follow`.
    times, scales, paths, grids = records.times, records.scales, records.paths, records.grids
    queue, queued = records.queue, records.queued
    restitution, tangential = start.restitution, start.tangential
    last_time = times[times.size - 1] if times.size else np.inf
    lanes = np.empty(LANES, LANE)
    active = launched = min(LANES, start.n)
    for a in range(active):
        _begin(lanes[a], start, records, a)
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
            queue_output(lane, queue[queued[0]], times, scales)
            queued[0] += 1
        path, finished = fly(lane, path, times.size, last_time)
        lane.flight_x += path * ux
        lane.flight_y += path * uy
        status = columns.FINISHED if finished else RUNNING
        if not finished:
            if paths.size:
                count_path(paths, grids, path)
            # Odd multiples of 2**-53 less 1: never 0, so the speed ratio is never 0 either.
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
        if launched < start.n:
            _begin(lane, start, records, launched)
            launched += 1
            a += 1
        else:
            active -= 1
            lanes[a] = lanes[active]
    enter_queue(records)
