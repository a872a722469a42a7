"""The flight of a tracer with a velocity, along a parabola in a field along x."""

from math import copysign, sqrt

import numpy as np

from particles.compiled import inlined
from particles.kernel.parabola import time_to_reach
from particles.kernel.records import Records
from particles.kernel.tracer import AT_REST, Batch, VelocityTracer, start_tracer


@inlined
def start_with_velocity(
    tracer: VelocityTracer, batch: Batch, times: np.ndarray, number: int
) -> None:
    """Set a lane to the start of a tracer."""
    tracer.vx, tracer.vy, tracer.vz = start_tracer(tracer, batch, times, number)


@inlined
def record_passage(
    tracer: VelocityTracer, x: float, duration: float, field: float, records: Records
) -> None:
    """Record when x first has the value depth on a piece of the parabola that begins at x."""
    if records.passages[tracer.number] == np.inf:
        towards = copysign(1.0, field)
        distance = towards * (records.depth - x)
        reaches = 0.0
        if distance > 0.0:
            reaches = time_to_reach(distance, towards * tracer.vx, abs(field))
        if reaches <= duration:
            records.passages[tracer.number] = tracer.time + reaches


@inlined
def move_in_field(tracer: VelocityTracer, duration: float, field: float) -> None:
    """Move a tracer without scatterers along its parabola."""
    tracer.time += duration
    tracer.flight_x += (tracer.vx + 0.5 * field * duration) * duration
    tracer.flight_y += tracer.vy * duration
    tracer.flight_z += tracer.vz * duration
    tracer.vx += field * duration


@inlined
def find_slowness(tracer: VelocityTracer) -> None:
    """Give a tracer with a velocity its slowness."""
    speed2 = tracer.vx * tracer.vx + (tracer.vy * tracer.vy + tracer.vz * tracer.vz)
    tracer.slowness = 1.0 / max(sqrt(speed2), AT_REST)
