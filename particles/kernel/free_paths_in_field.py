"""The event loop without scatterers in a uniform field along x: random free paths on parabolas.

A free path is an exponential length along the parabola; the collision at its end is the same as
without a field. Lengths are in d, times in d/U; the velocity is kept as it is, because the path of
a tracer in a field depends on its speed.
"""

from math import copysign, log, sqrt
from typing import Any

import numpy as np

from particles.compiled.decorators import by_dimension, inlined, kernel
from particles.events import scatter, scatter_in_space
from particles.kernel import columns
from particles.kernel.lane import AT_REST, RUNNING, Start, launch
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
from particles.kernel.records import QUEUE, Records, count_path, finish
from particles.kernel.records_in_field import Kept, enter_queue_in_field, queue_output_in_field
from particles.streams import FLIGHTS, bits, in_disk, open_stream, uniform


@inlined
def _set_velocity(lane: Any) -> float:
    lane.vx, lane.vy = lane.start_vx, lane.start_vy
    return 0.0


@inlined
def _set_velocity_in_space(lane: Any) -> float:
    lane.vx, lane.vy, lane.vz = lane.start_vx, lane.start_vy, lane.start_vz
    return 0.0


# Give a lane the velocity that it begins with.
_start_moving = by_dimension(_set_velocity, _set_velocity_in_space)


@inlined
def _begin(lane: Any, start: Start, records: Records, tracer: int) -> None:
    """Launch a tracer and open the stream of its random flights."""
    launch(lane, start, records, tracer)
    _start_moving(lane)
    lane.stream, lane.gamma = open_stream(
        start.seed, FLIGHTS, start.configuration, start.first + tracer
    )


@inlined
def _square_across(lane: Any) -> float:
    return lane.vy * lane.vy


@inlined
def _square_across_in_space(lane: Any) -> float:
    return lane.vy * lane.vy + lane.vz * lane.vz


# Return the square of the velocity across the field.
_across2 = by_dimension(_square_across, _square_across_in_space)


@inlined
def _move_in_plane(lane: Any, lasts: float, field: float) -> None:
    lane.flight_x += (lane.vx + 0.5 * field * lasts) * lasts
    lane.flight_y += lane.vy * lasts
    lane.vx += field * lasts


@inlined
def _move_in_space(lane: Any, lasts: float, field: float) -> None:
    _move_in_plane(lane, lasts, field)
    lane.flight_z += lane.vz * lasts


# Move a lane along its parabola for so long.
_move = by_dimension(_move_in_plane, _move_in_space)


@inlined
def _scatter(lane: Any, draw: int, restitution: float, tangential: float) -> None:
    impact = 2.0 * uniform(lane.stream, lane.gamma, draw) - 1.0
    speed = sqrt(lane.vx * lane.vx + lane.vy * lane.vy)
    ux, uy, ratio = scatter(lane.vx / speed, lane.vy / speed, impact, restitution, tangential)
    speed *= ratio
    lane.vx, lane.vy = speed * ux, speed * uy


@inlined
def _scatter_in_space(lane: Any, draw: int, restitution: float, tangential: float) -> None:
    impact = in_disk(bits(lane.stream, lane.gamma, draw))
    speed = sqrt(lane.vx * lane.vx + lane.vy * lane.vy + lane.vz * lane.vz)
    before = lane.vx / speed, lane.vy / speed, lane.vz / speed
    (ux, uy, uz), ratio = scatter_in_space(before, impact, restitution, tangential)
    speed *= ratio
    lane.vx, lane.vy, lane.vz = speed * ux, speed * uy, speed * uz


# Collide with an impact parameter from this draw, as in `particles.kernel.free_paths`.
_collide = by_dimension(_scatter, _scatter_in_space)


@kernel
def follow_free_paths_in_field(
    start: Start, mean_path: float, field: float, lanes: np.ndarray, records: Records, kept: Kept,
) -> None:  # fmt: skip
    """Follow tracers whose free paths are exponential along the parabolas of a uniform field.

    mean_path: the mean free path in d. field: in U^2/d along x, not 0; negative against x. lanes:
    of LANE_IN_FIELD_OF[dimension].
    """
    sums, passages, depth = kept.sums, kept.passages, kept.depth
    times, paths, grids = records.times, records.paths, records.grids
    queue, queued = records.queue, records.queued
    restitution, tangential = start.restitution, start.tangential
    last_time = times[times.size - 1] if times.size else np.inf
    strength, towards = abs(field), copysign(1.0, field)
    active = launched = min(lanes.size, start.n)
    work = np.empty((ROWS, active))
    for a in range(active):
        _begin(lanes[a], start, records, a)
    while active:
        for a in range(active):
            lane = lanes[a]
            word = uniform(lane.stream, lane.gamma, 2 * lane.collisions)
            across2 = _across2(lane)
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
                    enter_queue_in_field(records, sums)
                queue_output_in_field(lane, queue[queued[0]], times, field)
                queued[0] += 1
            finished = lane.output == times.size and times.size > 0
            if finished:
                lasts = max(last_time - lane.time, 0.0)
                # Of no time at all the length would be 0/0 at rest.
                path = length_of(lasts, speed, along, across2, strength)[0] if lasts > 0.0 else 0.0
            if passages.size and passages[lane.tracer] == np.inf:
                left = towards * (depth - lane.flight_x)
                reaches = time_to_reach(left, along, strength)
                if reaches <= lasts:
                    passages[lane.tracer] = lane.time + reaches
            lane.travelled += path
            lane.time += lasts
            _move(lane, lasts, field)
            status = columns.FINISHED if finished else RUNNING
            if not finished:
                if paths.size:
                    count_path(paths, grids, path)
                _collide(lane, 2 * lane.collisions + 1, restitution, tangential)
                lane.collisions += 1
                if lane.collisions == start.most:
                    status = columns.COLLISION_CAP
            if status == RUNNING:
                a += 1
                continue
            lane.slowness = 1.0 / max(sqrt(lane.vx * lane.vx + _across2(lane)), AT_REST)
            finish(lane, status, records)
            if launched < start.n:
                _begin(lane, start, records, launched)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
                for row in range(ROWS):  # numba compiles a copy of slices for seconds
                    work[row, a] = work[row, active]
    enter_queue_in_field(records, sums)
