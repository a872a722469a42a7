"""The event loop: tracers among the scatterers of one configuration, in units of d.

Several tracers, one in each lane, advance in turns by one cell each. First the next contact of
every lane in its cell is found; then every lane either collides or goes on to the next cell. So the
processor can compute the square roots and divisions of several tracers at the same time.

The loop is compiled for the plane and for space, by the type of the lanes; the steps of either are
in `particles.kernel.in_plane` and `particles.kernel.in_space`.
"""

from typing import Any

import numpy as np

from particles.compiled.decorators import inlined, kernel
from particles.grid.cells import Cells
from particles.kernel import columns, steps
from particles.kernel.in_plane import SHORT
from particles.kernel.lane import RUNNING, Start, advance, fly, is_due, launch, shift_clock
from particles.kernel.records import (
    QUEUE,
    Records,
    count_path,
    enter_queue,
    finish,
    queue_output,
    queue_rest,
)


@inlined
def _note_trap(lane: Any, trap: np.ndarray, start: Start, records: Records) -> None:
    """Record where and when a tracer was caught; it rests there at all later outputs."""
    queue_rest(lane, records)
    trap[columns.TRAP_TRACER] = start.first + lane.tracer
    trap[columns.TRAP_TIME] = lane.time / lane.unit
    steps.note_place(lane, trap)


@kernel
def follow(
    start: Start, cells: Cells, limit: float, traps: np.ndarray, lanes: np.ndarray, records: Records
) -> int:
    """Follow tracers through the scatterers of one configuration, adding to the records.

    limit: longest flight in d before a tracer counts as escaped. traps (n, TRAPS[dimension]):
    receives the trapped tracers; their number is returned. lanes: of LANE_OF[dimension], as many as
    shall be under way at the same time.
    """
    # Taken out of their tuples once: in the loop, numba would count references to them each time.
    keys, slots, head, links, nodes = cells.keys, cells.slots, cells.head, cells.links, cells.nodes
    times, scales, paths, grids = records.times, records.scales, records.paths, records.grids
    queue, queued = records.queue, records.queued
    last_time = times[times.size - 1] if times.size else np.inf
    side, n = cells.side, cells.n
    restitution, tangential = start.restitution, start.tangential
    active = launched = min(lanes.size, start.n)
    caught = 0
    for a in range(active):
        launch(lanes[a], start, records, a)
        steps.begin(lanes[a], cells)
    while active:
        for a in range(active):
            lane = lanes[a]
            if steps.lacks_cell(lane, keys):
                steps.make_cell(lane, keys, cells)
            steps.next_contact(lane, slots, head, links, nodes)
        a = 0
        while a < active:
            lane = lanes[a]
            wall = steps.next_wall(lane)
            if lane.contact > wall and wall <= limit:
                steps.cross_cell(lane, keys, n)
                a += 1
                continue
            escaped = lane.contact > wall
            # By rounding, a tracer in a corner may touch the next scatterer already.
            path = limit if escaped else max(lane.contact, 0.0)
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
                if paths.size:
                    count_path(paths, grids, path)
                ratio, trapped = steps.collide(lane, path, side, (restitution, tangential))
                lane.slowness /= ratio
                if path < SHORT and not trapped:
                    ratio, trapped = steps.end_bounces(lane, path, cells, (restitution, tangential))
                    lane.slowness /= ratio
                if trapped:
                    status = columns.TRAPPED
                    _note_trap(lane, traps[caught], start, records)
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
                launch(lane, start, records, launched)
                steps.begin(lane, cells)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
    enter_queue(records)
    return caught
