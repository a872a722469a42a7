"""The straight flight of a tracer without a field, and its clock.

The path does not depend on the speed (`particles.events`): a tracer has a place, a unit direction
and, apart from them, its slowness 1/speed, which each collision divides by the ratio of the speeds
after and before. For e < 1 slowness and time grow exponentially with the number of collisions and
would overflow: they are kept times `Tracer.unit`, and `shift_clock` changes this unit.
"""

from math import sqrt

import numpy as np

from particles.compiled import inlined
from particles.events import Varying, restitution_at
from particles.kernel.tracer import AT_REST, Batch, Tracer, start_tracer

#: Factor between two units of slowness and time. Chosen: a power of 2, so that no digit is lost.
#: The origin of the exponent is not recorded.
SHIFT = 2.0**64


class StraightTracer(Tracer):
    """A tracer on a straight flight."""

    ux: float  # unit direction
    uy: float
    uz: float
    contact: float  # path to the next contact
    impact: float  # normal speed at the last collision, where e depends on it


@inlined
def start_straight(tracer: StraightTracer, batch: Batch, times: np.ndarray, number: int) -> None:
    """Set a lane to the start of a tracer."""
    vx, vy, vz = start_tracer(tracer, batch, times, number)
    speed = max(sqrt(vx * vx + vy * vy + vz * vz), AT_REST)
    tracer.ux = vx / speed
    tracer.uy = vy / speed
    tracer.uz = vz / speed


@inlined
def path_until(tracer: StraightTracer, time: float) -> float:
    """Return the path that a tracer flies until a time in d/U."""
    return max((time * tracer.unit - tracer.time) / tracer.slowness, 0.0)


@inlined
def advance_clock(tracer: StraightTracer, path: float) -> None:
    """Let a tracer fly a path, except for its place."""
    tracer.travelled += path
    tracer.time += path * tracer.slowness


@inlined
def move_straight(tracer: StraightTracer, path: float) -> None:
    """Move the place where the flight of a tracer began by a path along its direction."""
    tracer.flight_x += path * tracer.ux
    tracer.flight_y += path * tracer.uy
    tracer.flight_z += path * tracer.uz


@inlined
def law_at_impact(
    tracer: StraightTracer, law: tuple[float, float], varying: Varying | None, cosine: float
) -> tuple[float, float]:
    """Return (e, et) of a collision; note the impact speed, if the law depends on it.

    cosine: of the angle between the velocity and the line of centres.
    """
    if varying is None:
        return law
    tracer.impact = cosine * tracer.unit / tracer.slowness
    return restitution_at(varying, tracer.impact), law[1]


@inlined
def stop(tracer: StraightTracer) -> None:
    """Bring a tracer to rest."""
    tracer.slowness = 1.0 / AT_REST


@inlined
def shift_clock(tracer: StraightTracer, times: np.ndarray) -> None:
    """Keep the slowness and the time of a tracer that has become slow from overflowing."""
    while tracer.slowness > SHIFT:
        tracer.slowness /= SHIFT
        tracer.time /= SHIFT
        tracer.unit /= SHIFT
        tracer.shifts += 1
        if tracer.output < times.size:
            tracer.next_output = times[tracer.output] * tracer.unit
