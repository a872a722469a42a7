"""Kernel: tracers without scatterers and without a field (BoltzmannGrad).

Free paths are exponential, impact parameters random: in the plane uniform in (-1, 1), in space
uniform in the unit disk. Collision number n of a tracer takes the draws 2n (its path) and 2n + 1
(its impact parameter) from the stream of this tracer. Begin reading with `follow_random_flights`.
"""

from math import log, sqrt

import numpy as np

from particles import outputs
from particles.compiled import inlined, kernel
from particles.events import Varying, scatter, scatter_in_space
from particles.kernel.records import (
    Records,
    count_flight,
    enter_queue,
    finish,
    flight_histograms,
    queue_output,
)
from particles.kernel.straight_flight import (
    StraightTracer,
    advance_clock,
    law_at_impact,
    move_straight,
    path_until,
    shift_clock,
    start_straight,
    stop,
)
from particles.kernel.tracer import Batch, Tracer, record_type
from particles.streams import FLIGHTS, bits, in_disk, open_stream, uniform


class RandomStream(Tracer):
    """A tracer whose flights and collisions are drawn."""

    stream: np.uint64  # state and gamma of its random stream
    gamma: np.uint64


class RandomTracer(StraightTracer, RandomStream):
    """A tracer on straight flights of random lengths."""


@inlined
def open_flights(tracer: RandomStream, batch: Batch) -> None:
    """Open the stream of the random flights of a tracer."""
    number = batch.first + tracer.number
    tracer.stream, tracer.gamma = open_stream(batch.seed, FLIGHTS, batch.configuration, number)


@inlined
def draw_path(tracer: RandomTracer, mean_path: float) -> None:
    """Draw the path to the next collision."""
    tracer.contact = -mean_path * log(uniform(tracer.stream, tracer.gamma, 2 * tracer.collisions))


@inlined
def collide_at_random(tracer: RandomTracer, batch: Batch, varying: Varying | None) -> float:
    """Collide with a random impact parameter, never 0; return the ratio of the speeds."""
    draw = 2 * tracer.collisions + 1
    if batch.dimension == 2:
        impact = 2.0 * uniform(tracer.stream, tracer.gamma, draw) - 1.0
        cosine = sqrt((1.0 - impact) * (1.0 + impact))
        restitution, tangential = law_at_impact(tracer, batch.law, varying, cosine)
        tracer.ux, tracer.uy, ratio = scatter(tracer.ux, tracer.uy, impact, restitution, tangential)
    else:
        a, b = in_disk(bits(tracer.stream, tracer.gamma, draw))
        cosine = sqrt(1.0 - (a * a + b * b))
        restitution, tangential = law_at_impact(tracer, batch.law, varying, cosine)
        direction = tracer.ux, tracer.uy, tracer.uz
        direction, ratio = scatter_in_space(direction, (a, b), restitution, tangential)
        tracer.ux, tracer.uy, tracer.uz = direction
    tracer.collisions += 1
    return ratio


@inlined
def _start(tracer: RandomTracer, batch: Batch, times: np.ndarray, number: int) -> None:
    start_straight(tracer, batch, times, number)
    open_flights(tracer, batch)


@kernel
def follow_random_flights(
    batch: Batch, varying: Varying | None, mean_path: float, lanes: np.ndarray, records: Records
) -> None:
    """Follow a batch of tracers, adding to the records.

    Parameters
    ----------
    batch : the tracers
    varying : restitution that depends on the impact speed, and sticking; None for the batch's law
    mean_path : mean free path in d
    lanes : records of RandomTracer, as many as are to be under way at the same time
    records : what the run keeps
    """
    # Taken out of the tuple once: in the loop, numba would count references to them each time.
    times = records.times
    histograms = flight_histograms(records)
    last_time = times[times.size - 1] if times.size else np.inf
    active = min(lanes.size, batch.size)
    for a in range(active):
        _start(lanes[a], batch, times, a)
    launched = active
    while active:
        for a in range(active):
            draw_path(lanes[a], mean_path)
        a = 0
        while a < active:
            tracer = lanes[a]
            path = tracer.contact
            arrival = tracer.time + path * tracer.slowness
            while arrival >= tracer.next_output and tracer.output < times.size:
                queue_output(tracer, records)
            status = outputs.RUNNING
            if tracer.output == times.size and times.size > 0:
                status = outputs.FINISHED
                path = path_until(tracer, last_time)
            advance_clock(tracer, path)
            if status == outputs.RUNNING:
                count_flight(histograms, path, path * tracer.slowness, tracer.shifts)
                move_straight(tracer, path)
                tracer.slowness /= collide_at_random(tracer, batch, varying)
                if varying is not None and tracer.impact < varying.capture:
                    status = outputs.CAPTURED
                    stop(tracer)
                else:
                    shift_clock(tracer, times)
                    if tracer.collisions == batch.max_collisions:
                        status = outputs.COLLISION_CAP
            else:
                move_straight(tracer, path)
            if status != outputs.RUNNING:
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


#: The record of a lane.
LANE = record_type(RandomTracer)
