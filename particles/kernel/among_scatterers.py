"""Kernel: tracers among the scatterers of one configuration, without a field.

Tracers advance in turns. First the next contact in its cell is found for the tracer of every lane;
then each of them either collides or goes on to the next cell. So the processor can compute the
square roots and divisions of several tracers at the same time.
"""

import numpy as np

from particles import outputs
from particles.cells import Cells
from particles.compiled import kernel
from particles.events import Varying
from particles.kernel.cell_walk import (
    SHORT,
    bounce_off,
    cross_cell,
    end_bounces,
    find_contact,
    nearest_wall,
    start_in_cell,
)
from particles.kernel.records import (
    Records,
    count_flight,
    enter_queue,
    finish,
    flight_histograms,
    queue_output,
)
from particles.kernel.straight_flight import (
    advance_clock,
    move_straight,
    path_until,
    shift_clock,
    stop,
)
from particles.kernel.tracer import Batch


@kernel
def follow_among_scatterers(
    batch: Batch, cells: Cells, varying: Varying | None, longest_flight: float,
    lanes: np.ndarray, records: Records,
) -> None:  # fmt: skip
    """Follow a batch of tracers, adding to the records.

    Parameters
    ----------
    batch : the tracers
    cells : the scatterers
    varying : restitution that depends on the impact speed, and sticking; None for the batch's law
    longest_flight : flight in d after which a tracer counts as escaped
    lanes : records of CellTracer, as many as are to be under way at the same time
    records : what the run keeps
    """
    # Taken out of their tuples once: in the loop, numba would count references to them each time.
    times = records.times
    histograms = flight_histograms(records)
    side = cells.side
    shape = cells.shape
    last_time = times[times.size - 1] if times.size else np.inf
    law = batch.law
    endless = law
    if varying is not None:
        endless = varying.slowest, law[1]
    active = min(lanes.size, batch.size)
    for a in range(active):
        start_in_cell(lanes[a], batch, cells, times, a)
    launched = active
    while active:
        for a in range(active):
            find_contact(lanes[a], cells)
        a = 0
        while a < active:
            tracer = lanes[a]
            path = tracer.contact
            wall = nearest_wall(tracer, shape)
            escapes = path > wall
            if escapes and wall <= longest_flight:
                cross_cell(tracer, side, shape)
                a += 1
                continue
            # By rounding, a tracer in a corner may touch the next scatterer already.
            path = longest_flight if escapes else max(path, 0.0)
            arrival = tracer.time + path * tracer.slowness
            while arrival >= tracer.next_output and tracer.output < times.size:
                queue_output(tracer, records)
            status = outputs.ESCAPED if escapes else outputs.RUNNING
            if tracer.output == times.size and times.size > 0:
                status = outputs.FINISHED
                path = path_until(tracer, last_time)
            advance_clock(tracer, path)
            if status == outputs.RUNNING:
                count_flight(histograms, path, path * tracer.slowness, tracer.shifts)
                trapped = bounce_off(tracer, path, side, shape, law, varying, endless)
                if path < SHORT and not trapped:
                    trapped = end_bounces(tracer, path, cells, endless)
                status = outputs.TRAPPED if trapped else outputs.RUNNING
                if varying is not None and tracer.impact < varying.capture:
                    status = outputs.CAPTURED
                    stop(tracer)
                if status == outputs.RUNNING:
                    shift_clock(tracer, times)
                    if tracer.collisions == batch.max_collisions:
                        status = outputs.COLLISION_CAP
            else:
                move_straight(tracer, path)
            if status != outputs.RUNNING:
                finish(tracer, status, batch.first, records)
                if launched == batch.size:
                    # The last lane, which has not had its turn, takes this one's place.
                    active -= 1
                    lanes[a] = lanes[active]
                    continue
                start_in_cell(tracer, batch, cells, times, launched)
                launched += 1
            a += 1
    enter_queue(records)
