"""Kernel: tracers that something drives: a bath of moving scatterers, noise and drag.

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

Begin reading with `follow_driven`.
"""

from math import exp, expm1, log, pi, sqrt
from typing import NamedTuple

import numpy as np

from particles import outputs
from particles.compiled import inlined, kernel
from particles.events import Varying, restitution_at, turned
from particles.kernel.parabola import length_flown
from particles.kernel.parabolic_flight import (
    find_slowness,
    move_in_field,
    record_passage,
    start_with_velocity,
)
from particles.kernel.random_flights import RandomStream, open_flights
from particles.kernel.records import (
    Records,
    count_flight,
    enter_queue,
    finish,
    flight_histograms,
    queue_in_field,
)
from particles.kernel.tracer import Batch, VelocityTracer, record_type
from particles.streams import bits, in_disk, to_unit

#: Rate of the second kind of candidates over w/l, in the plane. Derived (see above).
BATH_RATE_IN_PLANE = sqrt(pi / 2.0)
#: The same in space.
BATH_RATE_IN_SPACE = 2.0 * sqrt(2.0 / pi)
#: Share of a step h that the kick at its end, less that at its beginning, moves the place. Derived:
#: of (h/2)(K1 + K2) + (h/sqrt(12))(K1 - K2), the flight has moved it by h K1 already.
LATE_KICK_SHARE = 0.5 - 1.0 / sqrt(12.0)


class DrivenTracer(VelocityTracer, RandomStream):
    """A tracer that is driven."""

    normal_x: float  # of a collision
    normal_y: float
    normal_z: float
    clock: float  # what is left of an exponential variable, until the next candidate
    travelled_before: float  # path and time at the last collision
    time_before: float
    step: float  # duration of this step of the noise, 0 between two steps
    rest_of_step: float
    kick_x: float  # noise at the beginning of the step
    kick_y: float
    kick_z: float
    draws: int  # random numbers used


#: The record of a lane.
LANE = record_type(DrivenTracer)


class Driving(NamedTuple):
    """What drives tracers, in d and U.

    Parameters
    ----------
    mean_path : mean free path l among fixed scatterers
    field : acceleration along x
    bath_speed : w, standard deviation of each component of the velocity of a scatterer
    heating : D of the noise
    drag : gamma
    longest_step : of noise and drag; infinite without them
    """

    mean_path: float
    field: float
    bath_speed: float
    heating: float
    drag: float
    longest_step: float


# -- random numbers --------------------------------------------------------------------------------


@inlined
def _draw_bits(tracer: DrivenTracer) -> np.uint64:
    tracer.draws += 1
    return bits(tracer.stream, tracer.gamma, tracer.draws)


@inlined
def _draw_uniform(tracer: DrivenTracer) -> float:
    return to_unit(_draw_bits(tracer))


@inlined
def _draw_normal_pair(tracer: DrivenTracer) -> tuple[float, float]:
    """Return two independent standard normal numbers (Marsaglia's polar method)."""
    x, y = in_disk(_draw_bits(tracer))
    square = x * x + y * y
    size = sqrt(-2.0 * log(square) / square)
    return x * size, y * size


# -- noise and drag --------------------------------------------------------------------------------


@inlined
def _kick(
    tracer: DrivenTracer, driving: Driving, is_solid: bool
) -> tuple[float, float, float]:  # fmt: skip
    """Apply noise and drag for half a step; return the noise."""
    half = 0.5 * tracer.step
    keep = 1.0
    size = sqrt(2.0 * driving.heating * half)
    if driving.drag > 0.0:
        keep = exp(-driving.drag * half)
        size = sqrt(-driving.heating * expm1(-2.0 * driving.drag * half) / driving.drag)
    normal_x, normal_y = _draw_normal_pair(tracer)
    x = size * normal_x
    y = size * normal_y
    z = 0.0
    if is_solid:
        normal_z, _unused = _draw_normal_pair(tracer)
        z = size * normal_z
    tracer.vx = keep * tracer.vx + x
    tracer.vy = keep * tracer.vy + y
    tracer.vz = keep * tracer.vz + z
    return x, y, z


@inlined
def _begin_step(tracer: DrivenTracer, driving: Driving, longest: float, is_solid: bool) -> None:
    """Begin a step of noise and drag, no longer than until the next output."""
    tracer.step = tracer.rest_of_step = min(driving.longest_step, longest)
    tracer.kick_x, tracer.kick_y, tracer.kick_z = _kick(tracer, driving, is_solid)


@inlined
def _end_step(tracer: DrivenTracer, driving: Driving, is_solid: bool) -> None:
    """End a step; the place receives what the noise within it would have made of the flight."""
    x, y, z = _kick(tracer, driving, is_solid)
    share = LATE_KICK_SHARE * tracer.step
    growth = 1.0 + 0.5 * driving.drag * tracer.step
    tracer.flight_x += share * (x - growth * tracer.kick_x)
    tracer.flight_y += share * (y - growth * tracer.kick_y)
    tracer.flight_z += share * (z - growth * tracer.kick_z)
    tracer.step = 0.0


# -- collisions ------------------------------------------------------------------------------------


@inlined
def _draw_impact_normal(tracer: DrivenTracer, speed: float, is_solid: bool) -> float:
    """Draw the normal of a collision with a fixed scatterer; return the component of v along it."""
    ux = tracer.vx / speed
    uy = tracer.vy / speed
    uz = tracer.vz / speed
    if is_solid:
        a, b = in_disk(_draw_bits(tracer))
        cosine = sqrt(1.0 - (a * a + b * b))
        normal = turned((ux, uy, uz), cosine, a, b)
    else:
        a = 2.0 * _draw_uniform(tracer) - 1.0
        cosine = sqrt((1.0 - a) * (1.0 + a))
        normal = cosine * ux - a * uy, cosine * uy + a * ux, 0.0
    tracer.normal_x, tracer.normal_y, tracer.normal_z = normal
    return cosine * speed


@inlined
def _draw_any_normal(tracer: DrivenTracer, is_solid: bool) -> float:
    """Draw a normal of any direction; return the component of the velocity along it."""
    x, y = in_disk(_draw_bits(tracer))
    square = x * x + y * y
    if is_solid:  # the third coordinate of a place on the sphere is uniform
        size = 2.0 * sqrt(1.0 - square)
        tracer.normal_z = 1.0 - 2.0 * square
    else:
        size = 1.0 / sqrt(square)
        tracer.normal_z = 0.0
    tracer.normal_x = x * size
    tracer.normal_y = y * size
    along = tracer.vx * tracer.normal_x + tracer.vy * tracer.normal_y
    return along + tracer.vz * tracer.normal_z


@inlined
def _draw_impact_speed(
    tracer: DrivenTracer, speed: float, kind: float, bath_speed: float, is_solid: bool
) -> float:
    """Draw a candidate; return its impact speed, negative if it is no collision.

    kind: uniform between 0 and the bound of the rates of all candidates, times l.
    """
    bath_rate = bath_speed * (BATH_RATE_IN_SPACE if is_solid else BATH_RATE_IN_PLANE)
    if kind < speed:
        towards = _draw_impact_normal(tracer, speed, is_solid)
        if bath_speed == 0.0:
            return towards
        s, _unused = _draw_normal_pair(tracer)
    elif kind < speed + bath_rate:
        towards = _draw_any_normal(tracer, is_solid)
        s = sqrt(-2.0 * log(_draw_uniform(tracer)))
    else:
        return -1.0
    impact_speed = towards + bath_speed * s
    if s > 0.0 and towards > 0.0:
        return impact_speed
    bound = max(towards, 0.0) + bath_speed * max(s, 0.0)
    return impact_speed if _draw_uniform(tracer) * bound < impact_speed else -1.0


@inlined
def _collide(
    tracer: DrivenTracer, impact_speed: float, restitution: float, tangential: float
) -> None:
    """Collide with the normal that has been drawn."""
    tracer.collisions += 1
    tracer.travelled_before = tracer.travelled
    tracer.time_before = tracer.time
    change = (tangential + restitution) * impact_speed
    tracer.vx = tangential * tracer.vx - change * tracer.normal_x
    tracer.vy = tangential * tracer.vy - change * tracer.normal_y
    tracer.vz = tangential * tracer.vz - change * tracer.normal_z


# -- the kernel ------------------------------------------------------------------------------------


@inlined
def _start(tracer: DrivenTracer, batch: Batch, times: np.ndarray, number: int) -> None:
    start_with_velocity(tracer, batch, times, number)
    open_flights(tracer, batch)
    tracer.step = tracer.rest_of_step = 0.0
    tracer.travelled_before = tracer.time_before = 0.0
    tracer.draws = 0
    tracer.clock = -log(_draw_uniform(tracer))


@inlined
def _speed(tracer: DrivenTracer) -> float:
    across2 = tracer.vy * tracer.vy + tracer.vz * tracer.vz
    return sqrt(tracer.vx * tracer.vx + across2)


@inlined
def _bound_rate(
    tracer: DrivenTracer, driving: Driving, bath_rate: float, longest: float
) -> tuple[float, float, float]:
    """Return (speed, bound of the rate of candidates, how long it holds).

    bath_rate: rate of the second kind of candidates, times l. longest: time until something else.
    """
    mean_path = driving.mean_path
    strength = abs(driving.field)
    speed = _speed(tracer)
    rate = (speed + bath_rate) / mean_path
    duration = longest
    if strength > 0.0:
        short = mean_path / (speed + bath_rate + sqrt(strength * mean_path))
        duration = min(duration, short)
        rate += strength * short / mean_path
    return speed, rate, duration


@inlined
def _fly(tracer: DrivenTracer, speed: float, duration: float, field: float) -> None:
    """Let a tracer fly, no longer than until its next output."""
    if field == 0.0:
        tracer.travelled += speed * duration
    else:
        tracer.travelled += length_flown(tracer.vx, tracer.vy, tracer.vz, duration, field)
    began = tracer.time
    move_in_field(tracer, duration, field)
    tracer.time = min(began + duration, tracer.next_output)


@kernel
def follow_driven(
    batch: Batch, driving: Driving, varying: Varying, lanes: np.ndarray, records: Records
) -> None:
    """Follow a batch of tracers, adding to the records.

    Parameters
    ----------
    batch : the tracers
    driving : what drives them
    varying : the restitution, with scatterers of finite mass that of the tracer's own change of
        velocity (`Plan.law`); and sticking
    lanes : records of DrivenTracer
    records : what the run keeps
    """
    # Taken out of the tuple once: in the loop, numba would count references to them each time.
    times = records.times
    passages = records.passages
    histograms = flight_histograms(records)
    field = driving.field
    mean_path = driving.mean_path
    tangential = batch.law[1]
    is_solid = batch.dimension == 3
    is_noisy = driving.longest_step < np.inf
    bath_rate = driving.bath_speed * (BATH_RATE_IN_SPACE if is_solid else BATH_RATE_IN_PLANE)
    active = min(lanes.size, batch.size)
    for a in range(active):
        _start(lanes[a], batch, times, a)
    launched = active
    while active:
        a = 0
        while a < active:
            tracer = lanes[a]
            status = outputs.RUNNING
            is_due = tracer.time >= tracer.next_output
            if tracer.step > 0.0 and (tracer.rest_of_step <= 0.0 or is_due):
                _end_step(tracer, driving, is_solid)
            while tracer.output < times.size and tracer.time >= tracer.next_output:
                queue_in_field(tracer, records, field)
            if tracer.output == times.size and times.size > 0:
                status = outputs.FINISHED
            else:
                duration = tracer.next_output - tracer.time
                if is_noisy:
                    if tracer.step == 0.0:
                        _begin_step(tracer, driving, duration, is_solid)
                    duration = min(duration, tracer.rest_of_step)
                speed, rate, duration = _bound_rate(tracer, driving, bath_rate, duration)
                is_candidate = rate > 0.0 and tracer.clock <= rate * duration
                if is_candidate:
                    duration = tracer.clock / rate
                if passages.size:
                    record_passage(tracer, tracer.flight_x, duration, field, records)
                _fly(tracer, speed, duration, field)
                if is_noisy:
                    tracer.rest_of_step -= duration
                if is_candidate:
                    speed = _speed(tracer)
                    tracer.clock = -log(_draw_uniform(tracer))
                    kind = _draw_uniform(tracer) * rate * mean_path
                    impact_speed = _draw_impact_speed(
                        tracer, speed, kind, driving.bath_speed, is_solid
                    )
                    if impact_speed >= 0.0:
                        path = tracer.travelled - tracer.travelled_before
                        count_flight(histograms, path, tracer.time - tracer.time_before, 0)
                        restitution = restitution_at(varying, impact_speed)
                        _collide(tracer, impact_speed, restitution, tangential)
                        if impact_speed < varying.capture:
                            status = outputs.CAPTURED
                            tracer.vx = tracer.vy = tracer.vz = 0.0
                        elif tracer.collisions == batch.max_collisions:
                            status = outputs.COLLISION_CAP
                else:
                    tracer.clock -= rate * duration
            if status != outputs.RUNNING:
                find_slowness(tracer)
                finish(tracer, status, batch.first, records)
                if launched == batch.size:
                    # The last lane, which has not had its turn, takes this one's place.
                    active -= 1
                    lanes[a] = lanes[active]
                    continue
                _start(tracer, batch, times, launched)
                launched += 1
            a += 1
    enter_queue(records)
