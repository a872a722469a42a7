"""The event loop in a uniform field: tracers on parabolas among disks in the plane, in units of d.

As in `particles.kernel.follow`, several tracers advance in turns by one cell each.
"""

from math import copysign, sqrt
from typing import Any

import numpy as np

from particles.compiled.decorators import called, inlined, kernel
from particles.events import is_collapsing
from particles.grid.blocks import is_missing, supply
from particles.grid.cells import Cells
from particles.kernel import columns, in_field
from particles.kernel.in_plane import SHORT
from particles.kernel.lane import AT_REST, RUNNING, Start, launch
from particles.kernel.parabola import time_to_reach
from particles.kernel.records import QUEUE, Records, count_path, finish, queue_rest
from particles.kernel.records_in_field import Kept, enter_queue_in_field, queue_output_in_field
from particles.kernel.slide import slide
from particles.kernel.sliding import FALLS, RESTS, SLIDES, is_sliding, settle, touched


@inlined
def _note_passage(lane: Any, lasts: float, field: float, side: float, kept: Kept) -> None:
    """Note when x first has the value depth, if it comes to it on this piece of the parabola."""
    if kept.passages[lane.tracer] == np.inf:
        towards = copysign(1.0, field)
        left = towards * (kept.depth - in_field.come_along(lane, lane.x, side))
        reaches = time_to_reach(left, towards * lane.vx, abs(field)) if left > 0.0 else 0.0
        if reaches <= lasts:
            kept.passages[lane.tracer] = lane.time + reaches


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


@kernel
def follow_in_field(
    start: Start, cells: Cells, limits: tuple[float, float], traps: np.ndarray, lanes: np.ndarray,
    records: Records, kept: Kept,
) -> int:  # fmt: skip
    """Follow tracers through the disks of one configuration in a field, adding to the records.

    limits: the field in U^2/d along x, not 0, and the longest flight in d before a tracer counts as
    escaped. traps (n, TRAPS[2]): receives the trapped tracers; their number is returned. lanes: of
    LANE_AMONG_DISKS_IN_FIELD, as many as shall be under way at the same time.
    """
    # Taken out of their tuples once, as in `follow`.
    keys, slots, head, links, nodes = cells.keys, cells.slots, cells.head, cells.links, cells.nodes
    times, paths, grids = records.times, records.paths, records.grids
    queue, queued, passages = records.queue, records.queued, kept.passages
    last_time = times[times.size - 1] if times.size else np.inf
    side, n = cells.side, cells.n
    field, limit = limits
    law = (start.restitution, start.tangential)
    active = launched = min(lanes.size, start.n)
    caught = 0
    for a in range(active):
        launch(lanes[a], start, records, a)
        in_field.begin(lanes[a], keys, n, start.places)
    while active:
        for a in range(active):
            lane = lanes[a]
            if is_missing(keys, lane.cell, lane.i, lane.j):
                supply(keys, cells, lane.cell, lane.i, lane.j)
            in_field.aim(lane, 0.5 * side, field)
            in_field.next_contact(lane, slots, head, links, nodes, field)
        a = 0
        while a < active:
            lane = lanes[a]
            meets = lane.contact <= min(lane.wall_x, lane.wall_y)
            lasts = lane.contact if meets else min(lane.wall_x, lane.wall_y)
            status = RUNNING
            while lane.time + lasts >= lane.next_output and lane.output < times.size:
                if queued[0] == QUEUE:
                    enter_queue_in_field(records, kept.sums)
                in_field.note_place(lane, side)
                queue_output_in_field(lane, queue[queued[0]], times, field)
                queued[0] += 1
            if lane.output == times.size and times.size > 0:
                status = columns.FINISHED
                lasts = max(last_time - lane.time, 0.0)
            if passages.size:
                _note_passage(lane, lasts, field, side, kept)
            if status == RUNNING and not meets:
                in_field.cross_cell(lane, keys, n, side, field)
                if lane.crossed * side < limit:
                    a += 1
                    continue
                status = columns.ESCAPED
                lane.travelled += in_field.flown(lane, field)
            elif status == RUNNING:
                in_field.move(lane, lasts, field)
                path = in_field.flown(lane, field)
                lane.travelled += path
                if paths.size:
                    count_path(paths, grids, path)
                before = lane.normal_x, lane.normal_y
                leaving = in_field.collide(lane, law)
                next_to = FALLS
                normal = lane.normal_x, lane.normal_y
                if is_sliding(normal, (lane.vx, lane.vy), leaving, field):
                    next_to = SLIDES
                elif path < SHORT:
                    next_to = _after_short_flight(lane, before, cells, law, field)
                if next_to == SLIDES:
                    status = slide(lane, cells, law, field, records, kept)
                elif next_to == RESTS:
                    status = columns.TRAPPED
                in_field.begin_flight(lane)
                if status == RUNNING and lane.collisions >= start.most > 0:
                    status = columns.COLLISION_CAP
            else:
                in_field.move(lane, lasts, field)
                lane.travelled += in_field.flown(lane, field)
            if status == RUNNING:
                a += 1
                continue
            in_field.note_place(lane, side)
            if status == columns.TRAPPED:
                lane.vx = lane.vy = 0.0
                queue_rest(lane, records)
                traps[caught, columns.TRAP_TRACER] = start.first + lane.tracer
                traps[caught, columns.TRAP_TIME] = lane.time
                traps[caught, columns.TRAP_X] = lane.flight_x
                traps[caught, columns.TRAP_Y] = lane.flight_y
                caught += 1
            lane.slowness = 1.0 / max(sqrt(lane.vx * lane.vx + lane.vy * lane.vy), AT_REST)
            finish(lane, status, records)
            if launched < start.n:
                launch(lane, start, records, launched)
                in_field.begin(lane, keys, n, start.places)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
    enter_queue_in_field(records, kept.sums)
    return caught
