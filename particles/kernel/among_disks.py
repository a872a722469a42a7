"""Kernel: tracers among the disks of one configuration, in a field along x.

Tracers advance in turns, as in `among_scatterers`. One that the field holds on a disk slides along
it (`sliding`) before its turn ends.
"""

import numpy as np

from particles import outputs
from particles.cells import Cells
from particles.compiled import inlined, kernel
from particles.kernel.cell_walk import SHORT
from particles.kernel.corner import FALLS, RESTS, SLIDES, after_short_flight, is_sliding
from particles.kernel.falling import (
    FallingTracer,
    begin_flight,
    bounce_off_disk,
    fall_into_next_cell,
    find_contact_in_field,
    find_walls_in_field,
    flight_length,
    move_in_cell,
    place_from_start,
    start_falling,
    x_from_start,
)
from particles.kernel.parabolic_flight import find_slowness, record_passage
from particles.kernel.records import (
    Records,
    count_flight,
    enter_queue,
    finish,
    flight_histograms,
    queue_in_field,
)
from particles.kernel.sliding import slide
from particles.kernel.tracer import Batch


@inlined
def _finish_at_node(
    tracer: FallingTracer, status: int, side: float, first_number: int, records: Records
) -> None:
    """Enter the end of a tracer, which is at the last node of its path."""
    place_from_start(tracer, side)
    if status == outputs.TRAPPED:
        tracer.vx = tracer.vy = 0.0
    find_slowness(tracer)
    finish(tracer, status, first_number, records)


@inlined
def _bounce(
    tracer: FallingTracer, law: tuple[float, float], field: float
) -> bool:  # fmt: skip
    """Bounce off the disk that has been met; tell whether the field holds the tracer there."""
    leaving = bounce_off_disk(tracer, law)
    normal = tracer.normal_x, tracer.normal_y
    return is_sliding(normal, (tracer.vx, tracer.vy), leaving, field)


@kernel
def follow_among_disks(
    batch: Batch, cells: Cells, field: float, longest_flight: float, lanes: np.ndarray,
    records: Records,
) -> None:  # fmt: skip
    """Follow a batch of tracers, adding to the records.

    Parameters
    ----------
    batch : the tracers
    cells : the disks
    field : acceleration along x in U^2/d, not 0
    longest_flight : distance in d, in cells crossed, after which a tracer counts as escaped
    lanes : records of FallingTracer, as many as are to be under way at the same time
    records : what the run keeps
    """
    # Taken out of their tuples once: in the loop, numba would count references to them each time.
    times = records.times
    passages = records.passages
    histograms = flight_histograms(records)
    side = cells.side
    n = cells.shape[0]
    last_time = times[times.size - 1] if times.size else np.inf
    law = batch.law
    active = min(lanes.size, batch.size)
    for a in range(active):
        start_falling(lanes[a], batch, cells, times, a)
    launched = active
    while active:
        for a in range(active):
            find_walls_in_field(lanes[a], 0.5 * side, field)
            find_contact_in_field(lanes[a], cells, field)
        a = 0
        while a < active:
            tracer = lanes[a]
            status = outputs.RUNNING
            wall = min(tracer.wall_x, tracer.wall_y)
            meets_disk = tracer.contact <= wall
            duration = tracer.contact if meets_disk else wall
            while tracer.time + duration >= tracer.next_output and tracer.output < times.size:
                place_from_start(tracer, side)
                queue_in_field(tracer, records, field)
            if tracer.output == times.size and times.size > 0:
                status = outputs.FINISHED
                duration = max(last_time - tracer.time, 0.0)
            if passages.size:
                x = x_from_start(tracer, tracer.x, side)
                record_passage(tracer, x, duration, field, records)
            if status == outputs.FINISHED:
                move_in_cell(tracer, duration, field)
                tracer.travelled += flight_length(tracer, field)
            elif not meets_disk:
                fall_into_next_cell(tracer, n, side, field)
                if tracer.walls_crossed * side < longest_flight:
                    a += 1
                    continue
                status = outputs.ESCAPED
                tracer.travelled += flight_length(tracer, field)
            else:
                move_in_cell(tracer, duration, field)
                path = flight_length(tracer, field)
                tracer.travelled += path
                count_flight(histograms, path, tracer.duration, 0)
                # Not in a function: it would count references to `cells` each time.
                previous_normal = tracer.normal_x, tracer.normal_y
                motion = SLIDES if _bounce(tracer, law, field) else FALLS
                if motion == FALLS and path < SHORT:
                    motion = after_short_flight(tracer, previous_normal, cells, law, field)
                if motion == SLIDES:
                    status = slide(tracer, cells, law, field, records)
                elif motion == RESTS:
                    status = outputs.TRAPPED
                begin_flight(tracer)
                if status == outputs.RUNNING and tracer.collisions >= batch.max_collisions > 0:
                    status = outputs.COLLISION_CAP
            if status != outputs.RUNNING:
                _finish_at_node(tracer, status, side, batch.first, records)
                if launched == batch.size:
                    # The last lane, which has not had its turn, takes this one's place.
                    active -= 1
                    lanes[a] = lanes[active]
                    continue
                start_falling(tracer, batch, cells, times, launched)
                launched += 1
            a += 1
    enter_queue(records)
