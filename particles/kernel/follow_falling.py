"""The event loops in a uniform field along x: on parabolas among disks, and without scatterers.

The velocity is kept as it is, because the path of a tracer in a field depends on its speed. As in
`particles.kernel.follow`, several tracers advance in turns.
"""

from math import copysign, log, sqrt
from typing import Any

import numpy as np

from particles.cells import Cells
from particles.compiled import called, inlined, kernel
from particles.events import is_collapsing, scatter, scatter_in_space
from particles.kernel import columns, falling
from particles.kernel.lane import AT_REST, RUNNING, Start, launch, open_flights
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
    count_path,
    enter_queue,
    finish,
    note_trap,
    queue_falling,
)
from particles.kernel.slide import slide
from particles.kernel.sliding import FALLS, RESTS, SLIDES, is_sliding, settle, touched
from particles.kernel.steps import SHORT
from particles.streams import bits, in_disk, uniform


@inlined
def _note_passage(
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
def _finish(lane: Any, status: int, records: Records) -> None:
    """As `finish`, which takes the speed from the slowness."""
    square = lane.vx * lane.vx + (lane.vy * lane.vy + lane.vz * lane.vz)
    lane.slowness = 1.0 / max(sqrt(square), AT_REST)
    finish(lane, status, records)


@kernel
def follow_falling(
    start: Start, cells: Cells, limits: tuple[float, float], traps: np.ndarray, lanes: np.ndarray,
    records: Records,
) -> int:  # fmt: skip
    """Follow tracers through the disks of one configuration in a field, adding to the records.

    limits: the field in U^2/d along x, not 0, and the longest flight in d before a tracer counts as
    escaped. traps (n, TRAPS[2]): receives the trapped tracers; their number is returned. lanes: of
    FALLING_LANE, as many as shall be under way at the same time.
    """
    # Taken out of their tuples once, as in `follow`.
    slots, head, links, nodes = cells.slots, cells.head, cells.links, cells.nodes
    times, paths, grids = records.times, records.paths, records.grids
    queue, queued = records.queue, records.queued
    last_time = times[times.size - 1] if times.size else np.inf
    side, shape, law = cells.side, cells.shape, start.law
    field, limit = limits
    towards = copysign(1.0, field)
    active = launched = min(lanes.size, start.n)
    caught = 0
    for a in range(active):
        launch(lanes[a], start, times, a)
        falling.begin(lanes[a], shape, start.places)
    while active:
        for a in range(active):
            falling.aim(lanes[a], 0.5 * side, field)
            falling.next_contact(lanes[a], slots, head, links, nodes, field)
        a = 0
        while a < active:
            lane = lanes[a]
            meets = lane.contact <= min(lane.wall_x, lane.wall_y)
            lasts = lane.contact if meets else min(lane.wall_x, lane.wall_y)
            status = RUNNING
            while lane.time + lasts >= lane.next_output and lane.output < times.size:
                if queued[0] == QUEUE:
                    enter_queue(records)
                falling.note_place(lane, side)
                queue_falling(lane, queue[queued[0]], times, field)
                queued[0] += 1
            if lane.output == times.size and times.size > 0:
                status = columns.FINISHED
                lasts = max(last_time - lane.time, 0.0)
            if records.passages.size:
                x = falling.come_along(lane, lane.x, side)
                _note_passage(lane, towards * lane.vx, x, lasts, field, records)
            if status == RUNNING and not meets:
                falling.cross_cell(lane, shape, side, field)
                if lane.crossed * side < limit:
                    a += 1
                    continue
                status = columns.ESCAPED
                lane.travelled += falling.flown(lane, field)
            elif status == RUNNING:
                falling.move(lane, lasts, field)
                path = falling.flown(lane, field)
                lane.travelled += path
                if paths.size:
                    count_path(paths, grids, path)
                before = lane.normal_x, lane.normal_y
                leaving = falling.collide(lane, law)
                next_to = FALLS
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
            else:
                falling.move(lane, lasts, field)
                lane.travelled += falling.flown(lane, field)
            if status == RUNNING:
                a += 1
                continue
            falling.note_place(lane, side)
            if status == columns.TRAPPED:
                lane.vx = lane.vy = 0.0
                note_trap(lane, traps[caught], start.first, records)
                caught += 1
            _finish(lane, status, records)
            if launched < start.n:
                launch(lane, start, times, launched)
                falling.begin(lane, shape, start.places)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
    enter_queue(records)
    return caught


@inlined
def _begin_free(lane: Any, start: Start, times: np.ndarray, tracer: int) -> None:
    launch(lane, start, times, tracer)
    open_flights(lane, start)
    lane.vx, lane.vy, lane.vz = lane.start_vx, lane.start_vy, lane.start_vz


@inlined
def _collide_at_random(lane: Any, draw: int, start: Start) -> None:
    """Collide with an impact parameter from this draw, as in `particles.kernel.follow`."""
    restitution, tangential = start.law
    speed = sqrt(lane.vx * lane.vx + lane.vy * lane.vy + lane.vz * lane.vz)
    ux, uy, uz = lane.vx / speed, lane.vy / speed, lane.vz / speed
    if start.dimension == 2:
        impact = 2.0 * uniform(lane.stream, lane.gamma, draw) - 1.0
        ux, uy, ratio = scatter(ux, uy, impact, restitution, tangential)
    else:
        place = in_disk(bits(lane.stream, lane.gamma, draw))
        (ux, uy, uz), ratio = scatter_in_space((ux, uy, uz), place, restitution, tangential)
    speed *= ratio
    lane.vx, lane.vy, lane.vz = speed * ux, speed * uy, speed * uz


@kernel
def follow_free_falls(
    start: Start, mean_path: float, field: float, lanes: np.ndarray, records: Records
) -> None:
    """Follow tracers whose free paths are exponential along the parabolas of a uniform field.

    The collision at the end of a free path is the same as without a field. mean_path: the mean free
    path in d. field, lanes: as of `follow_falling`; the field may be negative.
    """
    times, paths, grids = records.times, records.paths, records.grids
    queue, queued = records.queue, records.queued
    last_time = times[times.size - 1] if times.size else np.inf
    strength, towards = abs(field), copysign(1.0, field)
    active = launched = min(lanes.size, start.n)
    work = np.empty((ROWS, active))
    for a in range(active):
        _begin_free(lanes[a], start, times, a)
    while active:
        for a in range(active):
            lane = lanes[a]
            word = uniform(lane.stream, lane.gamma, 2 * lane.collisions)
            across2 = lane.vy * lane.vy + lane.vz * lane.vz
            work[PATH, a] = -mean_path * log(word)
            work[ALONG, a] = towards * lane.vx
            work[ACROSS2, a] = across2
            work[SPEED2, a] = lane.vx * lane.vx + across2
        times_of(work, active, strength)
        a = 0
        while a < active:
            lane = lanes[a]
            path, along, across2 = work[PATH, a], work[ALONG, a], work[ACROSS2, a]
            speed = sqrt(work[SPEED2, a])
            lasts = work[LASTS, a]
            if not work[GOOD, a] >= 0.0:
                lasts = time_of(path, speed, along, across2, strength)
            while lane.time + lasts >= lane.next_output and lane.output < times.size:
                if queued[0] == QUEUE:
                    enter_queue(records)
                queue_falling(lane, queue[queued[0]], times, field)
                queued[0] += 1
            finished = lane.output == times.size and times.size > 0
            if finished:
                lasts = max(last_time - lane.time, 0.0)
                # Of no time at all the length would be 0/0 at rest.
                path = length_of(lasts, speed, along, across2, strength)[0] if lasts > 0.0 else 0.0
            if records.passages.size:
                _note_passage(lane, along, lane.flight_x, lasts, field, records)
            lane.travelled += path
            lane.time += lasts
            lane.flight_x += (lane.vx + 0.5 * field * lasts) * lasts
            lane.flight_y += lane.vy * lasts
            lane.flight_z += lane.vz * lasts
            lane.vx += field * lasts
            status = columns.FINISHED if finished else RUNNING
            if not finished:
                if paths.size:
                    count_path(paths, grids, path)
                _collide_at_random(lane, 2 * lane.collisions + 1, start)
                lane.collisions += 1
                if lane.collisions == start.most:
                    status = columns.COLLISION_CAP
            if status == RUNNING:
                a += 1
                continue
            _finish(lane, status, records)
            if launched < start.n:
                _begin_free(lane, start, times, launched)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
                for row in range(ROWS):  # numba compiles a copy of slices for seconds
                    work[row, a] = work[row, active]
    enter_queue(records)
