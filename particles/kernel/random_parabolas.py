"""Kernel: tracers without scatterers in a field along x (BoltzmannGrad).

A free path is an exponential length along the parabola, impact parameters are random, both drawn as
by `random_flights`. The times that the lengths take are found for all lanes at once (`parabola`).
d is the diameter of a scatterer and of the tracer, U the standard deviation of one component of the
initial velocity.
"""

from math import copysign, sqrt

import numpy as np

from particles import outputs
from particles.compiled import inlined, kernel
from particles.kernel.parabola import (
    ROWS,
    length_flown,
    request_time,
    requested_time,
    times_of_lengths,
)
from particles.kernel.parabolic_flight import (
    find_slowness,
    move_in_field,
    record_passage,
    start_with_velocity,
)
from particles.kernel.random_flights import (
    RandomTracer,
    collide_at_random,
    draw_path,
    open_flights,
)
from particles.kernel.records import (
    Records,
    count_flight,
    enter_queue,
    finish,
    flight_histograms,
    queue_in_field,
)
from particles.kernel.tracer import Batch, VelocityTracer, record_type


class RandomParabolaTracer(VelocityTracer, RandomTracer):
    """A tracer on parabolas of random lengths; its velocity is that where the flight began."""


#: Data type of a lane: the `RandomParabolaTracer` that a kernel moves beside others.
LANE = record_type(RandomParabolaTracer)


@inlined
def _start(tracer: RandomParabolaTracer, batch: Batch, times: np.ndarray, number: int) -> None:
    """Give a tracer its initial velocity, and open the stream of its random flights."""
    start_with_velocity(tracer, batch, times, number)
    open_flights(tracer, batch)


@inlined
def _collide(tracer: RandomParabolaTracer, batch: Batch) -> None:
    """Collide with a random impact parameter, and count the collision.

    `collide_at_random` turns the direction u and gives the ratio of the speeds. The restitution is
    constant (None): with one that depends on the impact speed, `driven` follows the tracers.
    """
    speed = sqrt(tracer.vx * tracer.vx + tracer.vy * tracer.vy + tracer.vz * tracer.vz)
    tracer.ux = tracer.vx / speed
    tracer.uy = tracer.vy / speed
    tracer.uz = tracer.vz / speed
    speed *= collide_at_random(tracer, batch, None)
    tracer.vx = speed * tracer.ux
    tracer.vy = speed * tracer.uy
    tracer.vz = speed * tracer.uz


@kernel
def follow_random_parabolas(
    batch: Batch, field: float, mean_path: float, lanes: np.ndarray, records: Records
) -> None:
    """Follow a batch of tracers, adding to the records.

    Parameters
    ----------
    batch : the tracers
    field : acceleration along x in U^2/d, not 0
    mean_path : mean free path in d
    lanes : records of RandomParabolaTracer, as many as are to be under way at the same time
    records : what the run keeps
    """
    # Taken out of the tuple once: in the loop, numba would count references to them each time.
    times = records.times
    passages = records.passages
    histograms = flight_histograms(records)
    last_time = times[times.size - 1] if times.size else np.inf
    strength = abs(field)
    towards = copysign(1.0, field)
    active = min(lanes.size, batch.size)
    work = np.empty((ROWS, active))
    for a in range(active):
        _start(lanes[a], batch, times, a)
    launched = active
    while active:
        for a in range(active):
            tracer = lanes[a]
            draw_path(tracer, mean_path)
            request_time(work, a, tracer.contact, towards * tracer.vx, tracer.vy, tracer.vz)
        times_of_lengths(work, active, strength)
        a = 0
        while a < active:
            tracer = lanes[a]
            path = tracer.contact
            duration = requested_time(work, a, strength)
            while tracer.time + duration >= tracer.next_output and tracer.output < times.size:
                queue_in_field(tracer, records, field)
            status = outputs.RUNNING
            if tracer.output == times.size and times.size > 0:
                status = outputs.FINISHED
                duration = max(last_time - tracer.time, 0.0)
                path = length_flown(tracer.vx, tracer.vy, tracer.vz, duration, field)
            if passages.size:  # flight_x: the depth where the flight began
                record_passage(tracer, tracer.flight_x, duration, field, records)
            tracer.travelled += path
            move_in_field(tracer, duration, field)
            if status == outputs.RUNNING:
                count_flight(histograms, path, duration, 0)  # 0: in a field time has one unit
                _collide(tracer, batch)
                if tracer.collisions >= batch.max_collisions > 0:
                    status = outputs.COLLISION_CAP
            if status != outputs.RUNNING:
                find_slowness(tracer)  # 1/v, by which `finish` records the final speed
                finish(tracer, status, batch.first, records)
                if launched == batch.size:
                    # The last lane, which has not had its turn, takes this one's place.
                    active -= 1
                    lanes[a] = lanes[active]
                    for row in range(ROWS):  # numba compiles a copy of slices for seconds
                        work[row, a] = work[row, active]
                    continue
                _start(tracer, batch, times, launched)
                launched += 1
            a += 1
    enter_queue(records)
