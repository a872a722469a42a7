"""The event loop: tracers among the scatterers of one configuration, in units of d.

Several tracers, one in each lane, advance in turns by one cell each. First the next contact of
every lane in its cell is found; then every lane either collides or goes on to the next cell. So the
processor can compute the square roots and divisions of several tracers at the same time.
"""

from math import copysign
from typing import Any

import numpy as np

from particles.compiled.decorators import inlined, kernel
from particles.compiled.search import SLOTS, strike
from particles.events import contact, is_collapsing, scatter, touch
from particles.grid.blocks import is_missing, is_plane, place, supply
from particles.grid.cells import Cells
from particles.kernel import columns
from particles.kernel.lane import RUNNING, Start, fly, is_due, launch, shift_clock
from particles.kernel.records import (
    QUEUE,
    Records,
    count_path,
    enter_queue,
    finish,
    queue_output,
    queue_rest,
)

# Flights shorter than this, in d, occur in corners between two scatterers only, whose walls are
# straight on this scale; whether a tracer ever leaves is then decided by `is_collapsing`.
TRAP_LENGTH = 1e-9


@inlined
def _begin(lane: Any, start: Start, records: Records, tracer: int, cells: Cells) -> None:
    """Put a tracer at the centre of the middle cell, where its path starts."""
    launch(lane, start, records, tracer)
    middle = cells.n // 2
    lane.stored_i = lane.stored_j = middle
    lane.cell = place(0, 0) if is_plane(cells.keys) else middle * cells.n + middle
    _aim(lane, cells.side)


@inlined
def _aim(lane: Any, side: float) -> None:
    """Find the cell walls ahead of a lane that begins a flight."""
    half = 0.5 * side
    sign_x, sign_y = copysign(1.0, lane.ux), copysign(1.0, lane.uy)
    pace_x, pace_y = 1.0 / max(abs(lane.ux), 1e-300), 1.0 / max(abs(lane.uy), 1e-300)
    lane.wall_x = max((half - sign_x * lane.x) * pace_x, 0.0)
    lane.wall_y = max((half - sign_y * lane.y) * pace_y, 0.0)
    lane.between_x, lane.between_y = side * pace_x, side * pace_y
    lane.move_x, lane.move_y = sign_x * side, sign_y * side
    lane.step_i, lane.step_j = int(sign_x), int(sign_y)


@inlined
def _next_contact(
    lane: Any, slots: np.ndarray, head: np.ndarray, links: np.ndarray, nodes: np.ndarray
) -> None:
    """Find the first scatterer that a lane meets in its cell, if there is one."""
    x, y, ux, uy, cell = lane.x, lane.y, lane.ux, lane.uy, lane.cell
    path, slot = strike(slots, cell, x, y, ux, uy)
    cx, cy = slots[cell, slot], slots[cell, SLOTS + slot]
    node = head[cell]
    while node >= 0:
        s, _ = contact(nodes[node, 0] - x, nodes[node, 1] - y, ux, uy)
        if s < path:
            path, cx, cy = s, nodes[node, 0], nodes[node, 1]
        node = links[node]
    lane.contact, lane.struck_x, lane.struck_y = path, cx, cy


@inlined
def _cross_cell(lane: Any, keys: np.ndarray, n: int) -> None:
    """Move a lane into the next cell, through the wall that it reaches first."""
    # Factors 0 and 1 instead of a branch: the processor cannot predict which wall comes first.
    across = int(lane.wall_x <= lane.wall_y)
    along = 1 - across
    lane.x -= across * lane.move_x
    lane.y -= along * lane.move_y
    lane.wall_x += across * lane.between_x
    lane.wall_y += along * lane.between_y
    di, dj = across * lane.step_i, along * lane.step_j
    lane.i += di
    lane.j += dj
    if is_plane(keys):
        lane.cell = place(lane.i, lane.j)
    else:
        i, j = lane.stored_i + di, lane.stored_j + dj
        i = n - 1 if i < 0 else 0 if i == n else i
        j = n - 1 if j < 0 else 0 if j == n else j
        lane.stored_i, lane.stored_j = i, j
        lane.cell = i * n + j


@inlined
def _collide(
    lane: Any, path: float, side: float, restitution: float, tangential: float
) -> tuple[float, bool]:
    """Bounce off the scatterer met after this path; the next flight begins there.

    Return the ratio of the speeds after and before, and whether the tracer is trapped from now on.
    """
    ux, uy, cx, cy = lane.ux, lane.uy, lane.struck_x, lane.struck_y
    impact = (cx - lane.x) * uy - (cy - lane.y) * ux
    x, y = touch(cx, cy, ux, uy, impact)
    ux, uy, ratio = scatter(ux, uy, impact, restitution, tangential)
    nx, ny = x - cx, y - cy
    trapped = ratio == 0.0
    if path < TRAP_LENGTH and not trapped:
        before = lane.normal_x, lane.normal_y
        trapped = is_collapsing(before, (nx, ny), (ux, uy), restitution, tangential)
    lane.x, lane.y, lane.ux, lane.uy, lane.normal_x, lane.normal_y = x, y, ux, uy, nx, ny
    lane.flight_x, lane.flight_y = lane.i * side + x, lane.j * side + y
    lane.collisions += 1
    _aim(lane, side)
    return ratio, trapped


@inlined
def _note_trap(lane: Any, trap: np.ndarray, start: Start, records: Records) -> None:
    """Record where and when a tracer was caught; it rests there at all later outputs."""
    queue_rest(lane, records)
    trap[columns.TRAP_TRACER] = start.first + lane.tracer
    trap[columns.TRAP_TIME] = lane.time / lane.unit
    trap[columns.TRAP_X] = lane.flight_x
    trap[columns.TRAP_Y] = lane.flight_y


@kernel
def follow(
    start: Start, cells: Cells, limit: float, traps: np.ndarray, lanes: np.ndarray, records: Records
) -> int:
    """Follow tracers through the scatterers of one configuration, adding to the records.

    limit: longest flight in d before a tracer counts as escaped. traps (n, TRAPS): receives the
    trapped tracers; their number is returned.
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
        _begin(lanes[a], start, records, a, cells)
    while active:
        for a in range(active):
            lane = lanes[a]
            if is_missing(keys, lane.cell, lane.i, lane.j):
                # Not made yet, or lost since to another lane that needed its place.
                supply(keys, cells, lane.cell, lane.i, lane.j)
            _next_contact(lane, slots, head, links, nodes)
        a = 0
        while a < active:
            lane = lanes[a]
            wall = min(lane.wall_x, lane.wall_y)
            if lane.contact > wall and wall <= limit:
                _cross_cell(lane, keys, n)
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
                lane.flight_x += path * lane.ux
                lane.flight_y += path * lane.uy
            else:
                if paths.size:
                    count_path(paths, grids, path)
                ratio, trapped = _collide(lane, path, side, restitution, tangential)
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
                _begin(lane, start, records, launched, cells)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
    enter_queue(records)
    return caught
