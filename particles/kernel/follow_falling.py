"""The event loop in a uniform field along x: on parabolas among disks, and without scatterers.

The velocity is kept as it is, because the path of a tracer in a field depends on its speed. As in
`particles.kernel.follow`, several tracers advance in turns.
"""

from math import copysign, log, sqrt
from typing import Any

import numpy as np

from particles.cells import Cells
from particles.compiled import called, inlined, kernel
from particles.events import is_collapsing
from particles.kernel import columns, falling
from particles.kernel.lane import AT_REST, RUNNING, Start, collide_at_random, launch
from particles.kernel.parabola import (
    ACROSS2,
    ALONG,
    GOOD,
    LASTS,
    PATH,
    ROWS,
    SPEED2,
    length_of,
    time_of,
    time_to_reach,
    times_of,
)
from particles.kernel.records import (
    QUEUE,
    Records,
    count_flight,
    enter_queue,
    finish,
    note_trap,
    queue_falling,
)
from particles.kernel.sliding import FALLS, RESTS, SLIDES, is_sliding, settle, slide, touched
from particles.kernel.steps import SHORT
from particles.streams import uniform


@inlined
def note_passage(
    lane: Any, along: float, x: float, lasts: float, field: float, records: Records
) -> None:
    """Note when x first has the value depth, if it comes to it on this piece of the parabola.

    along, x: velocity along the field, and x from the start, where the piece begins.
    """
    if records.passages[lane.tracer] == np.inf:
        left = copysign(1.0, field) * (records.depth - x)
        reaches = time_to_reach(left, along, abs(field)) if left > 0.0 else 0.0
        if reaches <= lasts:
            records.passages[lane.tracer] = lane.time + reaches


@called
def _after_short_flight(
    lane: Any, before: tuple[float, float], cells: Cells, law: tuple[float, float], field: float
) -> int:
    """Bring a lane to rest in a corner from which, without the field, it would never come out.

    before: normal of the disk struck before. Return FALLS, SLIDES or RESTS (`kernel.sliding`).
    """
    square = lane.vx * lane.vx + lane.vy * lane.vy
    if square <= abs(field) * 1e3 * SHORT:
        return FALLS  # where the field bends flights that are so short, they are followed
    per = 1.0 / sqrt(square)
    direction = lane.vx * per, lane.vy * per
    if not is_collapsing(before, (lane.normal_x, lane.normal_y), direction, law[0], law[1]):
        return FALLS
    found, cx, cy = touched(lane, cells)
    if not found:
        return FALLS
    lane.vx = lane.vy = 0.0
    return settle(lane, cx, cy, law, field)


@inlined
def _move_freely(lane: Any, lasts: float, field: float) -> None:
    """Move a lane without scatterers along its parabola for so long."""
    lane.time += lasts
    lane.flight_x += (lane.vx + 0.5 * field * lasts) * lasts
    lane.flight_y += lane.vy * lasts
    lane.flight_z += lane.vz * lasts
    lane.vx += field * lasts


@inlined
def _collide_freely(lane: Any, start: Start) -> None:
    """Collide without scatterers, with an impact parameter at random."""
    speed = sqrt(lane.vx * lane.vx + lane.vy * lane.vy + lane.vz * lane.vz)
    lane.ux, lane.uy, lane.uz = lane.vx / speed, lane.vy / speed, lane.vz / speed
    speed *= collide_at_random(lane, 2 * lane.collisions + 1, start, None)
    lane.vx, lane.vy, lane.vz = speed * lane.ux, speed * lane.uy, speed * lane.uz
    lane.collisions += 1


@kernel
def follow_falling(
    start: Start, cells: Cells | None, limits: tuple[float, float, float], traps: np.ndarray,
    lanes: np.ndarray, records: Records,
) -> int:  # fmt: skip
    """Follow tracers through the disks of one configuration in a field, adding to the records.

    cells: None for free paths that are exponential along the parabolas, as in `follow`; then also
    in space. limits: the field in U^2/d along x, not 0, the mean free path, and the longest flight
    in d among disks before a tracer counts as escaped. traps (n, TRAPS[2]): receives the trapped
    tracers; their number is returned. lanes: of FALLING_LANE, as many as shall be under way at the
    same time.
    """
    # Taken out of their tuples once, as in `follow`.
    times, paths, grids = records.times, records.paths, records.grids
    durations = records.durations
    queue, queued = records.queue, records.queued
    last_time = times[times.size - 1] if times.size else np.inf
    field, mean_path, limit = limits
    strength, towards, law = abs(field), copysign(1.0, field), start.law
    active = min(lanes.size, start.n)
    launched = caught = 0
    if cells is None:
        work = np.empty((ROWS, active))
    else:
        slots, head, links, nodes = cells.slots, cells.head, cells.links, cells.nodes
        side, shape = cells.side, cells.shape
    for a in range(active):
        launch(lanes[a], start, times, launched)
        launched += 1
        falling.begin(lanes[a], cells, start)
    while active:
        for a in range(active):
            lane = lanes[a]
            if cells is None:
                word = uniform(lane.stream, lane.gamma, 2 * lane.collisions)
                across2 = lane.vy * lane.vy + lane.vz * lane.vz
                work[PATH, a] = -mean_path * log(word)
                work[ALONG, a] = towards * lane.vx
                work[ACROSS2, a] = across2
                work[SPEED2, a] = lane.vx * lane.vx + across2
            else:
                falling.aim(lane, 0.5 * side, field)
                falling.next_contact(lane, slots, head, links, nodes, field)
        if cells is None:
            times_of(work, active, strength)
        a = 0
        while a < active:
            lane = lanes[a]
            if cells is None:
                path, along, across2 = work[PATH, a], work[ALONG, a], work[ACROSS2, a]
                speed, lasts, x = sqrt(work[SPEED2, a]), work[LASTS, a], lane.flight_x
                if not work[GOOD, a] >= 0.0:
                    lasts = time_of(path, speed, along, across2, strength)
            else:
                meets = lane.contact <= min(lane.wall_x, lane.wall_y)
                lasts = lane.contact if meets else min(lane.wall_x, lane.wall_y)
                along, x = towards * lane.vx, falling.come_along(lane, lane.x, side)
            status = RUNNING
            while lane.time + lasts >= lane.next_output and lane.output < times.size:
                if queued[0] == QUEUE:
                    enter_queue(records)
                if cells is not None:
                    falling.note_place(lane, side)
                queue_falling(lane, queue[queued[0]], times, field)
                queued[0] += 1
            if lane.output == times.size and times.size > 0:
                status = columns.FINISHED
                lasts = max(last_time - lane.time, 0.0)
            if records.passages.size:
                note_passage(lane, along, x, lasts, field, records)
            if cells is None:
                if status == columns.FINISHED:
                    # Of no time at all the length would be 0/0 at rest.
                    path = 0.0
                    if lasts > 0.0:
                        path = length_of(lasts, speed, along, across2, strength)[0]
                lane.travelled += path
                _move_freely(lane, lasts, field)
                if status == RUNNING:
                    count_flight(paths, durations, grids, path, lasts, 0)
                    _collide_freely(lane, start)
            elif status == RUNNING and not meets:
                falling.cross_cell(lane, shape, side, field)
                if lane.crossed * side < limit:
                    a += 1
                    continue
                status = columns.ESCAPED
                lane.travelled += falling.flown(lane, field)
            else:
                falling.move(lane, lasts, field)
                path = falling.flown(lane, field)
                lane.travelled += path
                if status == RUNNING:
                    count_flight(paths, durations, grids, path, lane.lasted, 0)
                    # Not in a function: it would count references to `cells` each time.
                    before = lane.normal_x, lane.normal_y
                    leaving, next_to = falling.collide(lane, law), FALLS
                    normal = lane.normal_x, lane.normal_y
                    if is_sliding(normal, (lane.vx, lane.vy), leaving, field):
                        next_to = SLIDES
                    elif path < SHORT:
                        next_to = _after_short_flight(lane, before, cells, law, field)
                    if next_to == SLIDES:
                        status = slide(lane, cells, law, field, records)
                    elif next_to == RESTS:
                        status = columns.TRAPPED
                    falling.begin_flight(lane)
            if status == RUNNING and lane.collisions >= start.most > 0:
                status = columns.COLLISION_CAP
            if status == RUNNING:
                a += 1
                continue
            if cells is not None:
                falling.note_place(lane, side)
            if status == columns.TRAPPED:
                lane.vx = lane.vy = 0.0
                note_trap(lane, traps[caught], start.first, records)
                caught += 1
            square = lane.vx * lane.vx + (lane.vy * lane.vy + lane.vz * lane.vz)
            lane.slowness = 1.0 / max(sqrt(square), AT_REST)
            finish(lane, status, records)
            if launched < start.n:
                launch(lane, start, times, launched)
                falling.begin(lane, cells, start)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
                if cells is None:
                    for row in range(ROWS):  # numba compiles a copy of slices for seconds
                        work[row, a] = work[row, active]
    enter_queue(records)
    return caught
