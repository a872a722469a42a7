"""The event loop: tracers among scatterers and without any, straight ahead or in a field along x.

Several tracers, one in each lane, advance in turns. Among scatterers first the next contact of
every lane in its cell is found; then every lane either collides or goes on to the next cell. So the
processor can compute the square roots and divisions of several tracers at the same time.
"""

from math import copysign, log
from typing import Any

import numpy as np

from particles import outputs
from particles.cells import Cells
from particles.compiled import inlined, kernel
from particles.events import Varying
from particles.kernel import falling, parabola, steps
from particles.kernel.lane import (
    AT_REST,
    Start,
    advance,
    collide_at_random,
    fly,
    launch,
    open_flights,
    shift_clock,
)
from particles.kernel.records import (
    Records,
    count_flight,
    enter_queue,
    finish,
    note_slowness,
    queue_falling,
    queue_output,
)
from particles.kernel.sliding import FALLS, RESTS, SLIDES, after_short_flight, is_sliding, slide
from particles.streams import uniform


@inlined
def _begin(
    lane: Any, cells: Cells | None, start: Start, field: float | None, times: np.ndarray,
    tracer: int,
) -> None:  # fmt: skip
    launch(lane, start, times, tracer)
    if cells is None:
        open_flights(lane, start)
    elif field is None:
        steps.begin(lane, cells)
    else:
        falling.begin(lane, cells, start)


@kernel
def follow(
    start: Start, cells: Cells | None, varying: Varying | None, field: float | None,
    mean_path: float, limit: float, lanes: np.ndarray, records: Records,
) -> None:  # fmt: skip
    """Follow tracers through the scatterers of one configuration, adding to the records.

    The compiler leaves out what is said of other kinds where an argument is None. cells: None for
    free paths that are exponential, of this mean in d, along the parabola in a field, and impact
    parameters that are random. varying: None where the law of the start holds at every speed, and
    nothing sticks, as in a field. field: along x in U^2/d, not 0; then among scatterers in the
    plane only. limit: the longest flight in d among scatterers before a tracer counts as escaped.
    lanes: of LANE, as many as shall be under way at the same time.
    """
    # Taken out of their tuples once: in the loop, numba would count references to them each time.
    times, passages, grids = records.times, records.passages, records.grids
    paths, durations = records.counts[outputs.PATH], records.counts[outputs.DURATION]
    last_time = times[times.size - 1] if times.size else np.inf
    law = endless = start.law
    if varying is not None:
        endless = varying.slowest, law[1]
    if cells is not None:
        slots, head, links, nodes = cells.slots, cells.head, cells.links, cells.nodes
        side, shape = cells.side, cells.shape
    active = min(lanes.size, start.n)
    if field is not None:
        strength, towards = abs(field), copysign(1.0, field)
        work = np.empty((parabola.ROWS, active))
    for a in range(active):
        _begin(lanes[a], cells, start, field, times, a)
    launched = active
    while active:
        for a in range(active):
            lane = lanes[a]
            if cells is None:
                word = uniform(lane.stream, lane.gamma, 2 * lane.collisions)
                lane.contact = -mean_path * log(word)
                if field is not None:
                    parabola.ask(work, a, lane.contact, towards * lane.vx, lane.vy, lane.vz)
            elif field is None:
                steps.next_contact(lane, slots, head, links, nodes, shape)
            else:
                falling.aim(lane, 0.5 * side, field)
                falling.next_contact(lane, slots, head, links, nodes, field)
        if cells is None and field is not None:
            parabola.times_of(work, active, strength)
        a = 0
        while a < active:
            lane = lanes[a]
            status = outputs.RUNNING
            if field is None:
                path, escaped = lane.contact, False
                if cells is not None:
                    wall = min(lane.wall_x, lane.wall_y)
                    if len(shape) == 3:
                        wall = min(wall, lane.wall_z)
                    escaped = path > wall
                    if escaped and wall <= limit:
                        steps.cross_cell(lane, shape)
                        a += 1
                        continue
                    # By rounding, a tracer in a corner may touch the next scatterer already.
                    path = limit if escaped else max(path, 0.0)
                reached = lane.time + path * lane.slowness
                while reached >= lane.next_output and lane.output < times.size:
                    queue_output(lane, records)
                path, finished = fly(lane, path, times.size, last_time)
                if finished or escaped:
                    status = outputs.FINISHED if finished else outputs.ESCAPED
                    advance(lane, path)
                else:
                    if paths.size or durations.size:
                        lasts = path * lane.slowness
                        count_flight(paths, durations, grids, path, lasts, lane.shifts)
                    if cells is None:
                        advance(lane, path)
                        lane.slowness /= collide_at_random(lane, start, varying)
                    else:
                        trapped = steps.collide(lane, path, side, shape, law, varying, endless)
                        if path < steps.SHORT and not trapped:
                            trapped = steps.end_bounces(lane, path, cells, endless)
                        status = outputs.TRAPPED if trapped else outputs.RUNNING
                    if varying is not None and lane.impact < varying.capture:
                        status, lane.slowness = outputs.CAPTURED, 1.0 / AT_REST
                    if status == outputs.RUNNING:
                        shift_clock(lane, times)
                        if lane.collisions == start.most:
                            status = outputs.COLLISION_CAP
            else:
                if cells is None:
                    path, lasts = lane.contact, parabola.answer(work, a, strength)
                    x = lane.flight_x
                else:
                    meets = lane.contact <= min(lane.wall_x, lane.wall_y)
                    lasts = lane.contact if meets else min(lane.wall_x, lane.wall_y)
                    x = falling.come_along(lane, lane.x, side)
                while lane.time + lasts >= lane.next_output and lane.output < times.size:
                    if cells is not None:
                        falling.note_place(lane, side)
                    queue_falling(lane, records, field)
                if lane.output == times.size and times.size > 0:
                    status = outputs.FINISHED
                    lasts = max(last_time - lane.time, 0.0)
                if passages.size:
                    parabola.note_passage(lane, x, lasts, field, records)
                if cells is None:
                    if status == outputs.FINISHED:
                        path = parabola.length_flown(lane.vx, lane.vy, lane.vz, lasts, field)
                    lane.travelled += path
                    parabola.move_freely(lane, lasts, field)
                    if status == outputs.RUNNING:
                        count_flight(paths, durations, grids, path, lasts, 0)
                        parabola.collide_freely(lane, start)
                elif status == outputs.RUNNING and not meets:
                    falling.cross_cell(lane, shape, side, field)
                    if lane.crossed * side < limit:
                        a += 1
                        continue
                    status = outputs.ESCAPED
                    lane.travelled += falling.flown(lane, field)
                else:
                    falling.move(lane, lasts, field)
                    path = falling.flown(lane, field)
                    lane.travelled += path
                    if status == outputs.RUNNING:
                        count_flight(paths, durations, grids, path, lane.lasted, 0)
                        # Not in a function: it would count references to `cells` each time.
                        before = lane.normal_x, lane.normal_y
                        leaving, next_to = falling.collide(lane, law), FALLS
                        normal = lane.normal_x, lane.normal_y
                        if is_sliding(normal, (lane.vx, lane.vy), leaving, field):
                            next_to = SLIDES
                        elif path < steps.SHORT:
                            next_to = after_short_flight(lane, before, cells, law, field)
                        if next_to == SLIDES:
                            status = slide(lane, cells, law, field, records)
                        elif next_to == RESTS:
                            status = outputs.TRAPPED
                        falling.begin_flight(lane)
                if status == outputs.RUNNING and lane.collisions >= start.most > 0:
                    status = outputs.COLLISION_CAP
            if status == outputs.RUNNING:
                a += 1
                continue
            if field is not None:
                if cells is not None:
                    falling.note_place(lane, side)
                if status == outputs.TRAPPED:
                    lane.vx = lane.vy = 0.0
                note_slowness(lane)
            finish(lane, status, start.first, records)
            if launched < start.n:
                _begin(lane, cells, start, field, times, launched)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
                if field is not None:
                    for row in range(parabola.ROWS):  # numba compiles a copy of slices for seconds
                        work[row, a] = work[row, active]
    enter_queue(records)
