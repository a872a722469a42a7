"""The event loop without a field: tracers among scatterers, and without any.

Several tracers, one in each lane, advance in turns. Among scatterers first the next contact of
every lane in its cell is found; then every lane either collides or goes on to the next cell. So the
processor can compute the square roots and divisions of several tracers at the same time. Without
scatterers the flights are random: the particle method of the kinetic equation itself.
"""

from math import log

import numpy as np

from particles.cells import Cells
from particles.compiled import kernel
from particles.events import Varying
from particles.kernel import columns, steps
from particles.kernel.lane import (
    AT_REST,
    RUNNING,
    Start,
    advance,
    collide_at_random,
    fly,
    is_due,
    launch,
    open_flights,
    shift_clock,
)
from particles.kernel.records import (
    QUEUE,
    Records,
    count_flight,
    enter_queue,
    finish,
    note_trap,
    queue_output,
)
from particles.streams import uniform


@kernel
def follow(
    start: Start, cells: Cells | None, varying: Varying | None, mean_path: float, limit: float,
    traps: np.ndarray, lanes: np.ndarray, records: Records,
) -> int:  # fmt: skip
    """Follow tracers through the scatterers of one configuration, adding to the records.

    cells: None for free paths that are exponential, of this mean in d, and impact parameters that
    are random; the compiler knows that, and leaves out what is said of the other kind. varying:
    None where the law of the start holds at every speed, and nothing sticks. limit: the longest
    flight in d among scatterers before a tracer counts as escaped. traps (n, TRAPS[dimension]):
    receives the trapped and captured tracers; their number is returned. lanes: of LANE, as many as
    shall be under way at the same time.
    """
    # Taken out of their tuples once: in the loop, numba would count references to them each time.
    times, scales, paths, grids = records.times, records.scales, records.paths, records.grids
    durations = records.durations
    queue, queued = records.queue, records.queued
    last_time = times[times.size - 1] if times.size else np.inf
    law = endless = start.law
    if varying is not None:
        endless = varying.slowest, law[1]
    if cells is not None:
        slots, head, links, nodes = cells.slots, cells.head, cells.links, cells.nodes
        side, shape = cells.side, cells.shape
    active = min(lanes.size, start.n)
    launched = caught = 0
    for a in range(active):
        launch(lanes[a], start, times, launched)
        launched += 1
        if cells is None:
            open_flights(lanes[a], start)
        else:
            steps.begin(lanes[a], cells)
    while active:
        for a in range(active):
            if cells is None:
                lane = lanes[a]
                u = uniform(lane.stream, lane.gamma, 2 * lane.collisions)
                lane.contact = -mean_path * log(u)
            else:
                steps.next_contact(lanes[a], slots, head, links, nodes, shape)
        a = 0
        while a < active:
            lane = lanes[a]
            path, escaped = lane.contact, False
            if cells is not None:
                wall = steps.next_wall(lane, shape)
                escaped = path > wall
                if escaped and wall <= limit:
                    steps.cross_cell(lane, shape)
                    a += 1
                    continue
                # By rounding, a tracer in a corner may touch the next scatterer already.
                path = limit if escaped else max(path, 0.0)
            while is_due(lane, path, times.size):
                if queued[0] == QUEUE:
                    enter_queue(records)
                queue_output(lane, queue[queued[0]], times, scales)
                queued[0] += 1
            path, finished = fly(lane, path, times.size, last_time)
            status = RUNNING
            if finished or escaped:
                status = columns.FINISHED if finished else columns.ESCAPED
                advance(lane, path)
            else:
                if paths.size or durations.size:
                    lasts = path * lane.slowness
                    count_flight(paths, durations, grids, path, lasts, lane.shifts)
                trapped = False
                if cells is None:
                    advance(lane, path)
                    lane.slowness /= collide_at_random(
                        lane, 2 * lane.collisions + 1, start, varying
                    )
                    lane.collisions += 1
                else:
                    ratio, trapped = steps.collide(lane, path, side, shape, law, varying, endless)
                    lane.slowness /= ratio
                    if path < steps.SHORT and not trapped:
                        ratio, trapped = steps.end_bounces(lane, path, cells, endless)
                        lane.slowness /= ratio
                captured = False
                if varying is not None:
                    captured = lane.impact < varying.capture
                if trapped or captured:
                    status = columns.TRAPPED
                    if captured:
                        status, lane.slowness = columns.CAPTURED, 1.0 / AT_REST
                    note_trap(lane, traps[caught], start.first, records)
                    caught += 1
                else:
                    shift_clock(lane, times)
                    if lane.collisions == start.most:
                        status = columns.COLLISION_CAP
            if status == RUNNING:
                a += 1
                continue
            finish(lane, status, records)
            if launched < start.n:
                launch(lane, start, times, launched)
                if cells is None:
                    open_flights(lane, start)
                else:
                    steps.begin(lane, cells)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
    enter_queue(records)
    return caught
