"""The event loop without scatterers: the particle method of the kinetic equation itself."""

from math import log
from typing import Any

import numpy as np

from particles.compiled.decorators import by_dimension, inlined, kernel
from particles.events import scatter, scatter_in_space
from particles.kernel import columns
from particles.kernel.lane import RUNNING, Start, advance, fly, is_due, launch, shift_clock
from particles.kernel.records import QUEUE, Records, count_path, enter_queue, finish, queue_output
from particles.streams import FLIGHTS, bits, in_disk, open_stream, uniform


@inlined
def _begin(lane: Any, start: Start, records: Records, tracer: int) -> None:
    """Launch a tracer and open the stream of its random flights."""
    launch(lane, start, records, tracer)
    lane.stream, lane.gamma = open_stream(
        start.seed, FLIGHTS, start.configuration, start.first + tracer
    )


@inlined
def _scatter(lane: Any, draw: int, restitution: float, tangential: float) -> float:
    # Odd multiples of 2**-53 less 1: never 0, so the speed ratio is never 0 either.
    impact = 2.0 * uniform(lane.stream, lane.gamma, draw) - 1.0
    lane.ux, lane.uy, ratio = scatter(lane.ux, lane.uy, impact, restitution, tangential)
    return ratio


@inlined
def _scatter_in_space(lane: Any, draw: int, restitution: float, tangential: float) -> float:
    # The impact parameter is never 0, so the speed ratio is never 0 either.
    impact = in_disk(bits(lane.stream, lane.gamma, draw))
    before = lane.ux, lane.uy, lane.uz
    (lane.ux, lane.uy, lane.uz), ratio = scatter_in_space(before, impact, restitution, tangential)
    return ratio


# Collide with an impact parameter from this draw: uniform on the line, or in the disk, across the
# direction. Return the ratio of the speeds after and before.
_collide = by_dimension(_scatter, _scatter_in_space)


@kernel
def follow_free_paths(start: Start, mean_path: float, lanes: np.ndarray, records: Records) -> None:
    """Follow tracers whose free paths are exponential and whose impact parameters are random.

    mean_path: the mean free path in d. lanes: of LANE_OF[dimension], as many as shall be under way
    at the same time.
    """
    # Taken out of their tuples once, as in `follow`.
    times, scales, paths, grids = records.times, records.scales, records.paths, records.grids
    queue, queued = records.queue, records.queued
    restitution, tangential = start.restitution, start.tangential
    last_time = times[times.size - 1] if times.size else np.inf
    active = launched = min(lanes.size, start.n)
    for a in range(active):
        _begin(lanes[a], start, records, a)
    a = 0
    while active:
        if a >= active:
            a = 0
        lane = lanes[a]
        draw = 2 * lane.collisions
        path = -mean_path * log(uniform(lane.stream, lane.gamma, draw))
        while is_due(lane, path, times.size):
            if queued[0] == QUEUE:
                enter_queue(records)
            queue_output(lane, queue[queued[0]], times, scales)
            queued[0] += 1
        path, finished = fly(lane, path, times.size, last_time)
        advance(lane, path)
        status = columns.FINISHED if finished else RUNNING
        if not finished:
            if paths.size:
                count_path(paths, grids, path)
            ratio = _collide(lane, draw + 1, restitution, tangential)
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
