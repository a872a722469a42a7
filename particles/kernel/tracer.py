"""The state of one tracer under way, and how a tracer starts.

A kernel follows several tracers in turns, each in a lane: an element of an array of records. The
classes that derive from `Tracer` declare the fields of these records, one class for each kernel
(`particles.kernel`); `record_type` makes an array type of such a class. Lengths are in d, times in
d/U, speeds in U. In the plane all third coordinates are 0.
"""

from math import cos, log, pi, sin, sqrt
from typing import NamedTuple, get_type_hints

import numpy as np

from particles.compiled import inlined
from particles.events import NEVER
from particles.streams import START, open_stream, uniform

#: Tracers that one thread follows in turns, so that the processor can overlap their divisions and
#: square roots. Only the speed depends on it: 4 to 64 were measured.
LANES = 16
#: A speed in U that stands for 0, with which a tracer begins in a field or driven only. Derived:
#: its inverse is the largest time, NEVER.
AT_REST = 1.0 / NEVER
#: Numbers of a record, for each type that a field is declared with.
NUMBER_TYPES = {float: np.float64, int: np.int64, np.uint64: np.uint64}
#: Places of a batch whose tracers all start at the centre of the middle cell.
AT_THE_CENTRE = np.empty((0, 4))


class Tracer:
    """What every kernel knows of a tracer under way.

    A tracer without a field slows down without end. So time and slowness are kept in units that
    grow with it: multiplied by `unit` = 2^(-64 shifts) (`straight_flight.shift_clock`).
    """

    number: int  # of the tracer, in its batch
    collisions: int  # so far
    output: int  # number of the next output time
    shifts: int
    unit: float
    slowness: float  # 1/speed, times `unit`
    time: float  # since the start, times `unit`
    next_output: float  # time of the next output, times `unit`; infinite after the last one
    travelled: float  # path since the start
    flight_x: float  # where this flight began, from where the tracer started
    flight_y: float
    flight_z: float
    start_vx: float  # velocity at time 0
    start_vy: float
    start_vz: float


class VelocityTracer(Tracer):
    """A tracer with a velocity instead of a speed and a direction: in a field, or driven.

    Its times are never shifted: `unit` is 1.
    """

    vx: float
    vy: float
    vz: float


def record_type(fields_of: type) -> np.dtype:
    """Return the type of a record with the fields that a class declares, also when interpreted."""
    fields = [(name, NUMBER_TYPES[kind]) for name, kind in get_type_hints(fields_of).items()]
    return np.dtype((np.record, np.dtype(fields, align=True)))


class Batch(NamedTuple):
    """Which tracers a kernel follows, and how they start and collide.

    Parameters
    ----------
    first : number of the first tracer in its configuration
    size : how many there are
    dimension : 2 or 3
    velocities : initial velocities in U, shape (count, dimension); (0, dimension) to draw them
    monoenergetic : whether drawn velocities have the size U, in a random direction; else each
        component is Gaussian with standard deviation U
    seed, configuration : keys of the random streams
    law : restitution and tangential restitution, (e, et); where e depends on the impact speed, that
        of slow impacts
    max_collisions : number of collisions after which a tracer ends, 0 for no limit
    places : where tracers start (`placement.free_places`), shape (count, 4); (0, 4): at the centre
    """

    first: int
    size: int
    dimension: int
    velocities: np.ndarray
    monoenergetic: bool
    seed: np.uint64
    configuration: int
    law: tuple[float, float]
    max_collisions: int
    places: np.ndarray = AT_THE_CENTRE


@inlined
def start_tracer(
    tracer: Tracer, batch: Batch, times: np.ndarray, number: int
) -> tuple[float, float, float]:
    """Set a lane to the start of a tracer, what all kernels share; return its velocity."""
    vx, vy, vz = _initial_velocity(batch, number)
    tracer.number = number
    tracer.start_vx = vx
    tracer.start_vy = vy
    tracer.start_vz = vz
    tracer.slowness = 1.0 / max(sqrt(vx * vx + vy * vy + vz * vz), AT_REST)
    tracer.unit = 1.0
    tracer.shifts = 0
    tracer.time = tracer.travelled = 0.0
    tracer.flight_x = tracer.flight_y = tracer.flight_z = 0.0
    tracer.collisions = tracer.output = 0
    tracer.next_output = times[0] if times.size else np.inf
    return vx, vy, vz


@inlined
def _initial_velocity(batch: Batch, number: int) -> tuple[float, float, float]:
    """Return the velocity that a tracer starts with, specified or drawn, in U."""
    is_solid = batch.dimension == 3
    vz = 0.0
    if batch.velocities.shape[0]:
        if is_solid:
            vz = batch.velocities[number, 2]
        return batch.velocities[number, 0], batch.velocities[number, 1], vz
    state, gamma = open_stream(batch.seed, START, batch.configuration, batch.first + number)
    angle = 2.0 * pi * uniform(state, gamma, 0)
    speed = 1.0 if batch.monoenergetic else sqrt(-2.0 * log(uniform(state, gamma, 1)))
    vx = speed * cos(angle)
    vy = speed * sin(angle)
    if is_solid and batch.monoenergetic:
        # The third coordinate of a uniform place on the unit sphere is uniform in (-1, 1).
        vz = 2.0 * uniform(state, gamma, 2) - 1.0
        across = sqrt((1.0 - vz) * (1.0 + vz))
        return across * vx, across * vy, vz
    if is_solid:
        radius = sqrt(-2.0 * log(uniform(state, gamma, 2)))
        vz = radius * cos(2.0 * pi * uniform(state, gamma, 3))
    return vx, vy, vz
