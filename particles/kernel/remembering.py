"""The event loop of tracers that remember their last collisions, with output times and records."""

import numpy as np

from particles.compiled.decorators import kernel
from particles.kernel import columns, in_plane, last_collisions
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


@kernel
def follow_remembering(
    start: Start, mean_path: float, known: np.ndarray, traps: np.ndarray, lanes: np.ndarray,
    records: Records,
) -> int:  # fmt: skip
    """Follow tracers that remember their last collisions, adding to the records, in the plane.

    mean_path: the mean free path in d without memory. known (k, 4): working memory of the steps in
    `last_collisions`. traps (n, TRAPS[2]): receives the trapped tracers; their number is returned.
    lanes: one, of LANE_OF[2].
    """
    # Taken out of their tuples once, as in `follow`.
    times, scales, paths, grids = records.times, records.scales, records.paths, records.grids
    queue, queued = records.queue, records.queued
    last_time = times[times.size - 1] if times.size else np.inf
    law = (start.restitution, start.tangential)
    lane = lanes[0]
    caught = 0
    for tracer in range(start.n):
        launch(lane, start, records, tracer)
        last_collisions.open_flights(lane, start, tracer)
        status = RUNNING
        while status == RUNNING:
            last_collisions.next_contact(lane, known, mean_path)
            while is_due(lane, lane.contact, times.size):
                if queued[0] == QUEUE:
                    enter_queue(records)
                queue_output(lane, queue[queued[0]], times, scales)
                queued[0] += 1
            path, finished = fly(lane, lane.contact, times.size, last_time)
            if finished:
                advance(lane, path)
                status = columns.FINISHED
                continue
            if paths.size:
                count_path(paths, grids, path)
            ratio, trapped = last_collisions.collide(lane, known, law)
            lane.slowness /= ratio
            if trapped:
                status = columns.TRAPPED
                queue_rest(lane, records)
                traps[caught, columns.TRAP_TRACER] = start.first + tracer
                traps[caught, columns.TRAP_TIME] = lane.time / lane.unit
                in_plane.note_place(lane, traps[caught])
                caught += 1
                continue
            shift_clock(lane, times)
            if lane.collisions == start.most:
                status = columns.COLLISION_CAP
        finish(lane, status, records)
    enter_queue(records)
    return caught
