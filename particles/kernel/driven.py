"""The event loop of tracers that something drives: a bath of moving scatterers, noise and drag.

Without positions of scatterers; also in a field along x, and there for a restitution of the impact
speed and for sticking. Three things happen to the velocity v:

- Collisions. The normal n is that of the approach, q = (v - V).n > 0, and V.n = -w s with s a
  standard normal number. They come at the rate (1/2) dn q/l, in space (1/pi) dn q/l, and are some
  of two kinds of candidates: of rate v/l, with an impact parameter at random as among fixed
  scatterers and s normal; and of rate w sqrt(pi/2)/l, in space 2 w sqrt(2/pi)/l, with any normal
  and s > 0 of density s exp(-s^2/2). A candidate of either kind is a collision with the probability
  q/(max(v.n, 0) + w max(s, 0)), 67 % or more in the mean. This is exact.
- The field. Until v can have grown by the field times a short time, the candidates of a bound of
  the rate are drawn, and kept with the probability (rate at that time)/bound: exact too.
- Noise and drag: the exact Ornstein-Uhlenbeck process over half a step, flight and collisions over
  a step, the process over half a step. Of the kicks K1 and K2 of the halves the place at the end
  receives (h/2)(K1 + K2) + (h/sqrt(12))(K1 - K2), not h K1, to first order in gamma h: the moments
  that it has without a collision. A step ends at every output.
"""

from math import exp, expm1, log, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from particles import outputs
from particles.compiled import inlined, kernel
from particles.events import Varying, restitution_at, turned
from particles.kernel.lane import Start, launch, open_flights
from particles.kernel.parabola import length_flown, move_freely, note_passage
from particles.kernel.records import (
    Records,
    count_flight,
    enter_queue,
    finish,
    note_slowness,
    queue_falling,
)
from particles.streams import bits, in_disk, to_unit

_OF_BATH = sqrt(pi / 2.0), 2.0 * sqrt(2.0 / pi)  # rates of the second kind, over w/l
_LATE = 0.5 - 1.0 / sqrt(12.0)


class Drive(NamedTuple):
    """What drives the tracers, in d and U: w, D, gamma; step: of noise and drag, or inf."""

    mean_path: float
    field: float
    bath: float
    heating: float
    drag: float
    step: float


@inlined
def _word(lane: Any) -> Any:
    lane.draws += 1
    return bits(lane.stream, lane.gamma, lane.draws)


@inlined
def _unit(lane: Any) -> float:
    return to_unit(_word(lane))


@inlined
def _normal_pair(lane: Any) -> tuple[float, float]:
    """Return two independent standard normal numbers (Marsaglia's polar method)."""
    x, y = in_disk(_word(lane))
    square = x * x + y * y
    size = sqrt(-2.0 * log(square) / square)
    return x * size, y * size


@inlined
def _kick(lane: Any, drive: Drive, solid: bool) -> tuple[float, float, float]:
    """Apply noise and drag for half a step; return the noise."""
    half, keep = 0.5 * lane.span, 1.0
    size = sqrt(2.0 * drive.heating * half)
    if drive.drag > 0.0:
        keep = exp(-drive.drag * half)
        size = sqrt(-drive.heating * expm1(-2.0 * drive.drag * half) / drive.drag)
    a, b = _normal_pair(lane)
    x, y, z = size * a, size * b, 0.0
    if solid:
        a, b = _normal_pair(lane)
        z = size * a
    lane.vx, lane.vy, lane.vz = keep * lane.vx + x, keep * lane.vy + y, keep * lane.vz + z
    return x, y, z


@inlined
def _end_step(lane: Any, drive: Drive, solid: bool) -> None:
    """End a step; the place receives what the noise within it would have made of the flight."""
    x, y, z = _kick(lane, drive, solid)
    size, before = _LATE * lane.span, 1.0 + 0.5 * drive.drag * lane.span
    lane.flight_x += size * (x - before * lane.kick_x)
    lane.flight_y += size * (y - before * lane.kick_y)
    lane.flight_z += size * (z - before * lane.kick_z)
    lane.span = 0.0


@inlined
def _draw_normal(lane: Any, speed: float, solid: bool) -> float:
    """Draw the normal of a collision with a fixed scatterer; return the component of v along it."""
    ux, uy, uz = lane.vx / speed, lane.vy / speed, lane.vz / speed
    if solid:
        a, b = in_disk(_word(lane))
        ahead = sqrt(1.0 - (a * a + b * b))
        lane.normal_x, lane.normal_y, lane.normal_z = turned((ux, uy, uz), ahead, a, b)
    else:
        a = 2.0 * _unit(lane) - 1.0
        ahead = sqrt((1.0 - a) * (1.0 + a))
        lane.normal_x, lane.normal_y, lane.normal_z = ahead * ux - a * uy, ahead * uy + a * ux, 0.0
    return ahead * speed


@inlined
def _draw_any_normal(lane: Any, solid: bool) -> float:
    """Draw a normal of any direction; return the component of the velocity along it."""
    x, y = in_disk(_word(lane))
    square = x * x + y * y
    if solid:  # the third coordinate of a place on the sphere is uniform
        size = 2.0 * sqrt(1.0 - square)
        lane.normal_x, lane.normal_y, lane.normal_z = x * size, y * size, 1.0 - 2.0 * square
    else:
        per = 1.0 / sqrt(square)
        lane.normal_x, lane.normal_y, lane.normal_z = x * per, y * per, 0.0
    return lane.vx * lane.normal_x + lane.vy * lane.normal_y + lane.vz * lane.normal_z


@inlined
def _impact_speed(lane: Any, speed: float, kind: float, drive: Drive, solid: bool) -> float:
    """Draw a candidate; return its impact speed, negative if none. kind: l times a rate."""
    if kind < speed:
        towards = _draw_normal(lane, speed, solid)
        if drive.bath == 0.0:
            return towards
        s, _ = _normal_pair(lane)
    elif kind < speed + drive.bath * _OF_BATH[int(solid)]:
        towards = _draw_any_normal(lane, solid)
        s = sqrt(-2.0 * log(_unit(lane)))
    else:
        return -1.0
    impact = towards + drive.bath * s
    if s > 0.0 and towards > 0.0:
        return impact
    bound = max(towards, 0.0) + drive.bath * max(s, 0.0)
    return impact if _unit(lane) * bound < impact else -1.0


@inlined
def _start(lane: Any, start: Start, times: np.ndarray, tracer: int) -> None:
    launch(lane, start, times, tracer)
    open_flights(lane, start)
    lane.left = lane.span = lane.since = lane.began = 0.0
    lane.draws = 0
    lane.clock = -log(_unit(lane))


@kernel
def follow_driven(
    start: Start, drive: Drive, varying: Varying, lanes: np.ndarray, records: Records
) -> None:
    """Follow tracers that are driven, adding to the records; arguments as of `follow`.

    varying: with scatterers of finite mass of the tracer's own change of velocity (Plan.law).
    """
    # Taken out of their tuples once, as in `follow`.
    times, passages, grids = records.times, records.passages, records.grids
    paths, durations = records.counts[outputs.PATH], records.counts[outputs.DURATION]
    field, mean_path, tangential = drive.field, drive.mean_path, start.law[1]
    strength = abs(field)
    solid, noisy = start.dimension == 3, drive.step < np.inf
    from_bath = drive.bath * _OF_BATH[int(solid)]
    active = min(lanes.size, start.n)
    for a in range(active):
        _start(lanes[a], start, times, a)
    launched = active
    while active:
        a = 0
        while a < active:
            lane = lanes[a]
            status = outputs.RUNNING
            if lane.span > 0.0 and (lane.left <= 0.0 or lane.time >= lane.next_output):
                _end_step(lane, drive, solid)
            while lane.output < times.size and lane.time >= lane.next_output:
                queue_falling(lane, records, field)
            if lane.output == times.size and times.size > 0:
                status = outputs.FINISHED
            lasts = lane.next_output - lane.time
            if noisy:
                if lane.span == 0.0 and status == outputs.RUNNING:
                    lane.span = lane.left = min(drive.step, lasts)
                    lane.kick_x, lane.kick_y, lane.kick_z = _kick(lane, drive, solid)
                lasts = min(lasts, lane.left)
            across2 = lane.vy * lane.vy + lane.vz * lane.vz
            speed = sqrt(lane.vx * lane.vx + across2)
            rate = (speed + from_bath) / mean_path
            if strength > 0.0:
                short = mean_path / (speed + from_bath + sqrt(strength * mean_path))
                lasts = min(lasts, short)
                rate += strength * short / mean_path
            meets = rate > 0.0 and lane.clock <= rate * lasts and status == outputs.RUNNING
            if meets:
                lasts = lane.clock / rate
            if status == outputs.RUNNING:
                if passages.size:
                    note_passage(lane, lane.flight_x, lasts, field, records)
                if strength == 0.0:
                    lane.travelled += speed * lasts
                else:
                    lane.travelled += length_flown(lane.vx, lane.vy, lane.vz, lasts, field)
                began = lane.time
                move_freely(lane, lasts, field)
                lane.time = min(began + lasts, lane.next_output)
                if noisy:
                    lane.left -= lasts
                if not meets:
                    lane.clock -= rate * lasts
            if meets:
                if strength > 0.0:
                    speed = sqrt(lane.vx * lane.vx + across2)
                lane.clock = -log(_unit(lane))
                kind = _unit(lane) * rate * mean_path
                impact = _impact_speed(lane, speed, kind, drive, solid)
                if impact >= 0.0:
                    lane.collisions += 1
                    path, flown = lane.travelled - lane.since, lane.time - lane.began
                    count_flight(paths, durations, grids, path, flown, 0)
                    lane.since, lane.began = lane.travelled, lane.time
                    change = (tangential + restitution_at(varying, impact)) * impact
                    lane.vx = tangential * lane.vx - change * lane.normal_x
                    lane.vy = tangential * lane.vy - change * lane.normal_y
                    lane.vz = tangential * lane.vz - change * lane.normal_z
                    if impact < varying.capture:
                        status = outputs.CAPTURED
                        lane.vx = lane.vy = lane.vz = 0.0
                    elif lane.collisions == start.most:
                        status = outputs.COLLISION_CAP
            if status == outputs.RUNNING:
                a += 1
                continue
            note_slowness(lane)
            finish(lane, status, start.first, records)
            if launched < start.n:
                _start(lane, start, times, launched)
                launched += 1
                a += 1
            else:
                # The last lane, which has not had its turn, takes this one's place.
                active -= 1
                lanes[a] = lanes[active]
    enter_queue(records)
