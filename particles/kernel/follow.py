"""Loops over tracers and their events. Floats and arrays only, in units of d.

LANES tracers advance in turns, one cell each. First every lane looks for what it strikes in its
cell, then every lane collides or goes on to the next cell: the square roots and divisions of one
do not wait for those of another, and no branch waits for them either.
"""

from math import copysign, cos, log, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from particles.events import contact, is_collapsing, scatter, touch
from particles.grid.blocks import is_missing, is_plane, place, supply
from particles.grid.cells import Cells
from particles.grid.vectors import SLOTS, strike
from particles.kernel.records import (
    Q_CAUGHT,
    Q_COLLISIONS,
    Q_OUTPUT,
    Q_OX,
    Q_OY,
    Q_TRACER,
    Q_VX,
    Q_VY,
    Q_X,
    Q_Y,
    QUEUE,
    SHIFT,
    Records,
    count_path,
    enter,
    finish,
)
from particles.streams import FLIGHTS, START, open_stream, uniform

LANES = 16

# How a tracer ended. The numbers are indices into Records.statuses and are stored in files.
FINISHED, COLLISION_CAP, TRAPPED, ESCAPED = range(4)
RUNNING = -1

# Flights shorter than this, in d, occur in corners between two scatterers only, whose walls are
# straight on this scale; whether a tracer ever leaves is then decided by `is_collapsing`.
TRAP_LENGTH = 1e-9

# Columns of a lane's state. X, Y: place from the centre of the cell (CI, CJ), which counts as if a
# periodic plane were not wrapped; W, V: the cell as stored. SLOW: 1/speed. OX, OY: v(0).
# NX, NY: normal at the last contact. FROM: where the flight began, from the start: X and Y lose
# digits in a flight across many cells.
X, Y, UX, UY, SLOW, TIME, UNIT, DUE, OX, OY, PATHS, NX, NY = range(13)
NEXT_X, NEXT_Y, GAIN_X, GAIN_Y, MOVE_X, MOVE_Y, FROM_X, FROM_Y = range(13, 21)
CI, CJ, W, V, N_COLLISIONS, OUTPUT, TRACER, SHIFTS, CELL, STEP_X, STEP_Y = range(11)


class Start(NamedTuple):
    """Which tracers to follow, and how.

    first: number of the first one. given (n, 2): initial velocities, or (0, 2) to draw n of them.
    most: collision cap, 0 for none.
    """

    first: int
    n: int
    given: np.ndarray
    monoenergetic: bool
    seed: Any
    configuration: int
    restitution: float
    most: int


@njit(error_model="numpy", forceinline=True)
def _launch(
    start: Start, records: Records, tracer: int, lane: np.ndarray, whole: np.ndarray
) -> None:
    """Set a lane to the beginning of a tracer's path."""
    if start.given.shape[0]:
        ox, oy = start.given[tracer, 0], start.given[tracer, 1]
    else:
        state, gamma = open_stream(start.seed, START, start.configuration, start.first + tracer)
        angle = 2.0 * pi * uniform(state, gamma, 0)
        speed = 1.0 if start.monoenergetic else sqrt(-2.0 * log(uniform(state, gamma, 1)))
        ox, oy = speed * cos(angle), speed * sin(angle)
    speed = sqrt(ox * ox + oy * oy)
    lane[:] = 0.0
    whole[:] = 0
    lane[UX], lane[UY] = ox / speed, oy / speed
    lane[SLOW], lane[UNIT] = 1.0 / speed, 1.0
    lane[DUE] = records.times[0] if records.times.size else np.inf
    lane[OX], lane[OY] = ox, oy
    whole[TRACER] = tracer


@njit(error_model="numpy", inline="always")
def _aim(
    lane: np.ndarray, whole: np.ndarray, x: float, y: float, ux: float, uy: float, side: float
) -> None:
    """Begin a flight at (x, y) of the lane's cell.

    NEXT: path to the next wall of each kind. GAIN: what it grows by from one such wall to the next.
    MOVE and STEP: the way to the next cell, as a length and as a count.
    """
    half = 0.5 * side
    sign_x, sign_y = copysign(1.0, ux), copysign(1.0, uy)
    pace_x, pace_y = 1.0 / max(abs(ux), 1e-300), 1.0 / max(abs(uy), 1e-300)
    lane[X], lane[Y], lane[UX], lane[UY] = x, y, ux, uy
    lane[NEXT_X] = max((half - sign_x * x) * pace_x, 0.0)
    lane[NEXT_Y] = max((half - sign_y * y) * pace_y, 0.0)
    lane[GAIN_X], lane[GAIN_Y] = side * pace_x, side * pace_y
    lane[MOVE_X], lane[MOVE_Y] = sign_x * side, sign_y * side
    whole[STEP_X], whole[STEP_Y] = int(sign_x), int(sign_y)


@njit(error_model="numpy", forceinline=True)
def _shift(times: np.ndarray, lanes: np.ndarray, wholes: np.ndarray, a: int) -> None:
    """Shift the clock of a lane that has become slow, before it can overflow."""
    while lanes[a, SLOW] > SHIFT:
        lanes[a, SLOW] /= SHIFT
        lanes[a, TIME] /= SHIFT
        lanes[a, UNIT] /= SHIFT
        wholes[a, SHIFTS] += 1
        if wholes[a, OUTPUT] < times.size:
            lanes[a, DUE] = times[wholes[a, OUTPUT]] * lanes[a, UNIT]


@njit(error_model="numpy", forceinline=True)
def _output(
    times: np.ndarray, scales: np.ndarray, queue: np.ndarray, m: int,
    lanes: np.ndarray, wholes: np.ndarray, a: int, x: float, y: float,
) -> None:  # fmt: skip
    """Queue a lane's state at its next output time, in a flight begun at (x, y)."""
    k = wholes[a, OUTPUT]
    # Not negative but for outputs that UNIT has rounded to 0: passed within 1e-8 d.
    done = max((lanes[a, DUE] - lanes[a, TIME]) / lanes[a, SLOW], 0.0)
    speed = scales[k] * lanes[a, UNIT] / lanes[a, SLOW]
    queue[m, Q_OUTPUT], queue[m, Q_TRACER] = k, wholes[a, TRACER]
    queue[m, Q_X], queue[m, Q_Y] = x + done * lanes[a, UX], y + done * lanes[a, UY]
    queue[m, Q_VX], queue[m, Q_VY] = speed * lanes[a, UX], speed * lanes[a, UY]
    queue[m, Q_OX], queue[m, Q_OY] = lanes[a, OX], lanes[a, OY]
    queue[m, Q_COLLISIONS], queue[m, Q_CAUGHT] = wholes[a, N_COLLISIONS], 0.0
    wholes[a, OUTPUT] = k + 1
    lanes[a, DUE] = times[k + 1] * lanes[a, UNIT] if k + 1 < times.size else np.inf


@njit(error_model="numpy", forceinline=True)
def _rest(
    queue: np.ndarray, m: int, lanes: np.ndarray, wholes: np.ndarray, a: int, x: float, y: float
) -> None:
    """Queue a trapped tracer, at rest at (x, y), at its next output time."""
    queue[m, Q_OUTPUT], queue[m, Q_TRACER] = wholes[a, OUTPUT], wholes[a, TRACER]
    queue[m, Q_X], queue[m, Q_Y], queue[m, Q_VX], queue[m, Q_VY] = x, y, 0.0, 0.0
    queue[m, Q_OX], queue[m, Q_OY] = lanes[a, OX], lanes[a, OY]
    queue[m, Q_COLLISIONS], queue[m, Q_CAUGHT] = wholes[a, N_COLLISIONS], 1.0
    wholes[a, OUTPUT] += 1


@njit(error_model="numpy", forceinline=True)
def _end(
    records: Records, lane: np.ndarray, whole: np.ndarray, status: int, x: float, y: float
) -> None:
    finish(
        records, whole[TRACER], status, lane[PATHS], whole[N_COLLISIONS], x, y,
        lane[SLOW], lane[TIME], whole[SHIFTS],
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def follow(start: Start, cells: Cells, limit: float, traps: np.ndarray, records: Records) -> int:
    """Follow tracers through the scatterers of one configuration, adding to the records.

    limit: longest flight before a tracer counts as escaped. traps (n, 4): receives tracer, time,
    x, y of each trapped one; their number is returned.
    """
    slots, head, links, nodes = cells.slots, cells.head, cells.links, cells.nodes
    side, n, keys = cells.side, cells.n, cells.keys
    middle = n // 2
    first = place(0, 0) if is_plane(keys) else middle * n + middle
    lanes = np.empty((LANES, 21))
    wholes = np.empty((LANES, 11), np.int64)
    struck = np.empty((LANES, 3))
    active = min(LANES, start.n)
    launched = active
    caught = 0
    times, scales = records.times, records.scales
    paths, grids = records.paths, records.grids
    queue = np.empty((QUEUE, 10))
    queued = 0
    for a in range(active):
        _launch(start, records, a, lanes[a], wholes[a])
        wholes[a, W] = wholes[a, V] = middle
        wholes[a, CELL] = first
        _aim(lanes[a], wholes[a], 0.0, 0.0, lanes[a, UX], lanes[a, UY], side)
    while active:
        # What each lane strikes in its cell, if anything. No result is waited for here.
        for a in range(active):
            x, y, ux, uy = lanes[a, X], lanes[a, Y], lanes[a, UX], lanes[a, UY]
            cell = wholes[a, CELL]
            if is_missing(keys, cell, wholes[a, CI], wholes[a, CJ]):
                # Never made, or lost to another lane since.
                supply(keys, cells, cell, wholes[a, CI], wholes[a, CJ])
            path, slot = strike(slots, cell, x, y, ux, uy)
            cx, cy = slots[cell, slot], slots[cell, SLOTS + slot]
            node = head[cell]
            while node >= 0:
                s, _ = contact(nodes[node, 0] - x, nodes[node, 1] - y, ux, uy)
                if s < path:
                    path, cx, cy = s, nodes[node, 0], nodes[node, 1]
                node = links[node]
            struck[a, 0], struck[a, 1], struck[a, 2] = path, cx, cy
        # Then each goes on to its next cell, or collides.
        a = 0
        while a < active:
            path = struck[a, 0]
            next_x, next_y = lanes[a, NEXT_X], lanes[a, NEXT_Y]
            wall = min(next_x, next_y)
            i, j = wholes[a, CI], wholes[a, CJ]
            if path > wall and wall <= limit:
                # Multiplied by 0 or 1, not branched upon: which wall comes first is a coin toss.
                across = int(next_x <= next_y)
                along = 1 - across
                lanes[a, X] -= across * lanes[a, MOVE_X]
                lanes[a, Y] -= along * lanes[a, MOVE_Y]
                lanes[a, NEXT_X] = next_x + across * lanes[a, GAIN_X]
                lanes[a, NEXT_Y] = next_y + along * lanes[a, GAIN_Y]
                di, dj = across * wholes[a, STEP_X], along * wholes[a, STEP_Y]
                i, j = i + di, j + dj
                wholes[a, CI], wholes[a, CJ] = i, j
                if not is_plane(keys):
                    w, v = wholes[a, W] + di, wholes[a, V] + dj
                    w = n - 1 if w < 0 else 0 if w == n else w
                    v = n - 1 if v < 0 else 0 if v == n else v
                    wholes[a, W], wholes[a, V] = w, v
                    wholes[a, CELL] = w * n + v
                else:
                    wholes[a, CELL] = place(i, j)
                a += 1
                continue
            x, y, ux, uy = lanes[a, X], lanes[a, Y], lanes[a, UX], lanes[a, UY]
            # By rounding, a tracer in a corner may touch the next scatterer already.
            path = max(path, 0.0)
            escaped = path > wall
            if escaped:
                path = limit
            end = lanes[a, TIME] + path * lanes[a, SLOW]
            status = RUNNING
            while end >= lanes[a, DUE] and wholes[a, OUTPUT] < times.size:
                if queued == QUEUE:
                    enter(records, queue, queued)
                    queued = 0
                _output(
                    times, scales, queue, queued, lanes, wholes, a,
                    lanes[a, FROM_X], lanes[a, FROM_Y],
                )  # fmt: skip
                queued += 1
            if wholes[a, OUTPUT] == times.size > 0:
                status = FINISHED
                last = times[times.size - 1] * lanes[a, UNIT]
                path = max((last - lanes[a, TIME]) / lanes[a, SLOW], 0.0)
                end = lanes[a, TIME] + path * lanes[a, SLOW]
            elif escaped:
                status = ESCAPED
            lanes[a, PATHS] += path
            lanes[a, TIME] = end
            if status == RUNNING:
                if paths.size:
                    count_path(paths, grids, path)
                cx, cy = struck[a, 1], struck[a, 2]
                impact = (cx - x) * uy - (cy - y) * ux
                x, y = touch(cx, cy, ux, uy, impact)
                px, py = i * side + x, j * side + y
                ux, uy, ratio = scatter(ux, uy, impact, start.restitution)
                wholes[a, N_COLLISIONS] += 1
                nx, ny = x - cx, y - cy
                slow = lanes[a, SLOW] / ratio
                lanes[a, SLOW] = slow
                if ratio == 0.0 or (
                    path < TRAP_LENGTH
                    and is_collapsing(lanes[a, NX], lanes[a, NY], nx, ny, ux, uy, start.restitution)
                ):
                    status = TRAPPED
                    while wholes[a, OUTPUT] < times.size:
                        if queued == QUEUE:
                            enter(records, queue, queued)
                            queued = 0
                        _rest(queue, queued, lanes, wholes, a, px, py)
                        queued += 1
                    traps[caught, 0] = start.first + wholes[a, TRACER]
                    traps[caught, 1] = end / lanes[a, UNIT]
                    traps[caught, 2] = px
                    traps[caught, 3] = py
                    caught += 1
                else:
                    if slow > SHIFT:
                        _shift(times, lanes, wholes, a)
                    if wholes[a, N_COLLISIONS] == start.most:
                        status = COLLISION_CAP
                lanes[a, NX], lanes[a, NY] = nx, ny
            else:
                px, py = lanes[a, FROM_X] + path * ux, lanes[a, FROM_Y] + path * uy
            if status == RUNNING:
                lanes[a, FROM_X], lanes[a, FROM_Y] = px, py
                _aim(lanes[a], wholes[a], x, y, ux, uy, side)
                a += 1
                continue
            _end(records, lanes[a], wholes[a], status, px, py)
            if launched < start.n:
                _launch(start, records, launched, lanes[a], wholes[a])
                wholes[a, W] = wholes[a, V] = middle
                wholes[a, CELL] = first
                _aim(lanes[a], wholes[a], 0.0, 0.0, lanes[a, UX], lanes[a, UY], side)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
                wholes[a] = wholes[active]
                struck[a] = struck[active]
    enter(records, queue, queued)
    return caught


@njit(cache=True, nogil=True, error_model="numpy")
def follow_free_paths(start: Start, mean_path: float, records: Records) -> None:
    """Follow tracers without scatterers: exponential free paths, uniform impact parameters."""
    lanes = np.empty((LANES, 13))
    wholes = np.empty((LANES, 8), np.int64)
    keys = np.empty((LANES, 2), np.uint64)
    active = min(LANES, start.n)
    launched = active
    times, scales = records.times, records.scales
    paths, grids = records.paths, records.grids
    queue = np.empty((QUEUE, 10))
    queued = 0
    for a in range(active):
        _launch(start, records, a, lanes[a], wholes[a])
        keys[a, 0], keys[a, 1] = open_stream(
            start.seed, FLIGHTS, start.configuration, start.first + a
        )
    a = 0
    while active:
        if a >= active:
            a = 0
        x, y, ux, uy = lanes[a, X], lanes[a, Y], lanes[a, UX], lanes[a, UY]
        state, gamma = keys[a, 0], keys[a, 1]
        path = -mean_path * log(uniform(state, gamma, 2 * wholes[a, N_COLLISIONS]))
        end = lanes[a, TIME] + path * lanes[a, SLOW]
        status = RUNNING
        # As in `follow`: one function for both cost 4 % of either.
        while end >= lanes[a, DUE] and wholes[a, OUTPUT] < times.size:
            if queued == QUEUE:
                enter(records, queue, queued)
                queued = 0
            _output(times, scales, queue, queued, lanes, wholes, a, x, y)
            queued += 1
        if wholes[a, OUTPUT] == times.size > 0:
            status = FINISHED
            last = times[times.size - 1] * lanes[a, UNIT]
            path = max((last - lanes[a, TIME]) / lanes[a, SLOW], 0.0)
            end = lanes[a, TIME] + path * lanes[a, SLOW]
        lanes[a, PATHS] += path
        lanes[a, TIME] = end
        x, y = x + path * ux, y + path * uy
        lanes[a, X], lanes[a, Y] = x, y
        if status == RUNNING:
            if paths.size:
                count_path(paths, grids, path)
            # Odd multiples of 2**-53 less 1: never 0, so the speed ratio never is.
            impact = 2.0 * uniform(state, gamma, 2 * wholes[a, N_COLLISIONS] + 1) - 1.0
            lanes[a, UX], lanes[a, UY], ratio = scatter(ux, uy, impact, start.restitution)
            wholes[a, N_COLLISIONS] += 1
            slow = lanes[a, SLOW] / ratio
            lanes[a, SLOW] = slow
            if slow > SHIFT:
                _shift(times, lanes, wholes, a)
            if wholes[a, N_COLLISIONS] == start.most:
                status = COLLISION_CAP
        if status == RUNNING:
            a += 1
            continue
        _end(records, lanes[a], wholes[a], status, x, y)
        if launched < start.n:
            _launch(start, records, launched, lanes[a], wholes[a])
            keys[a, 0], keys[a, 1] = open_stream(
                start.seed, FLIGHTS, start.configuration, start.first + launched
            )
            launched += 1
            a += 1
        else:
            active -= 1
            lanes[a] = lanes[active]
            wholes[a] = wholes[active]
            keys[a] = keys[active]
    enter(records, queue, queued)
