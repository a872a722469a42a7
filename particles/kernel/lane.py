"""The state of one tracer under way, called its lane, and the steps that both kernels share.

The path of a tracer does not depend on its speed (`particles.events`), so a lane holds a place, a
unit direction and, apart from them, the slowness 1/speed. Lengths are in d, times in d/U.

A tracer slows down without end. So that neither slowness nor time overflows, both are kept times
2**-64k; `shifts` is k and `unit` is 2**-64k.
"""

from math import cos, log, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from particles.compiled.decorators import by_dimension, inlined
from particles.kernel.records import Records, record_type
from particles.streams import START, open_stream, uniform

# Tracers that one thread follows in turns. Speed depends on it, results do not;
# tests/particles/measurements/kernel_speed.py measures the speed with several numbers.
LANES = 16
RUNNING = -1  # the status of a tracer that has not ended
SHIFT = 2.0**64
AT_REST = 1e-300  # a speed in place of 0, with which a tracer begins in a field only

# Of type np.record, so that `lane.x` is read in the same way compiled and interpreted.
_FIELDS = {
    np.float64: (
        "x", "y",                       # place, from the centre of the lane's cell
        "ux", "uy",                     # unit direction
        "slowness", "time", "unit",     # each times 2**-64 shifts
        "next_output",                  # time of the next output, as `time`; inf after the last
        "travelled",                    # path since the start
        "flight_x", "flight_y",         # where this flight began, from the start of the path
        "start_vx", "start_vy",         # velocity at time 0, in U
        "normal_x", "normal_y",         # of the scatterer struck last, towards the tracer
        "wall_x", "wall_y",             # path to the next cell wall of each direction
        "between_x", "between_y",       # path from one such wall to the next
        "move_x", "move_y",             # from the centre of this cell to that of the next
        "contact",                      # path to the next contact in this cell
        "struck_x", "struck_y",         # the scatterer met there, from the cell's centre
    ),
    np.int64: (
        "collisions", "output",         # how many there have been, of collisions and of outputs
        "tracer", "shifts",
        "i", "j",                       # the cell, counted without regard to periodicity
        "stored_i", "stored_j",         # the cell of the box that stands for it
        "cell",                         # where its scatterers are stored
        "step_i", "step_j",             # +1 or -1: from this cell to the next
    ),
    np.uint64: ("stream", "gamma"),     # what random flights without scatterers are drawn from
}  # fmt: skip
# What a lane has besides in three dimensions: the third coordinates.
_FIELDS_IN_SPACE = {
    np.float64: (
        "z", "uz", "flight_z", "start_vz", "wall_z", "between_z", "move_z", "struck_z",
    ),
    np.int64: ("k", "stored_k", "step_k"),
}  # fmt: skip
LANE_OF = {2: record_type(_FIELDS), 3: record_type(_FIELDS_IN_SPACE, _FIELDS)}
# In a field the path depends on the speed: a lane holds the velocity where its flight began. The
# direction and the slowness are not used there, and times are never shifted.
LANE_IN_FIELD_OF = {
    2: record_type({np.float64: ("vx", "vy")}, _FIELDS),
    3: record_type({np.float64: ("vz", "vx", "vy")}, _FIELDS_IN_SPACE, _FIELDS),
}


# Among disks in a field the place and the velocity are those at the last node of the parabola.
LANE_AMONG_DISKS_IN_FIELD = record_type(
    {
        np.float64: (
            "first_vx", "lasted",       # velocity along x where the flight began; time since then
            "vx", "vy",
            "meets_x", "meets_y",       # the disk of the next contact, from the cell's centre
            "from_x", "from_y",         # where the path began, from the centre of its cell
        ),
        np.int64: (
            "before", "crossed",        # whether it is on the disk `struck`; walls crossed since
            "from_i", "from_j",         # the cell where the path began, from the middle one
        ),
    },
    _FIELDS,
)  # fmt: skip


AT_THE_CENTRE = np.empty((0, 4))


class Start(NamedTuple):
    """Which tracers to follow, and how.

    first: number of the first one. given (n, dimension): initial velocities in U, or
    (0, dimension) to draw n of them. restitution, tangential: what a collision leaves of the normal
    and of the tangential velocity. most: the largest number of collisions, 0 for no limit.
    places (n, 4): where they start, of `grid.free_places`, or (0, 4): at the centre.
    """

    first: int
    n: int
    given: np.ndarray
    monoenergetic: bool
    seed: Any
    configuration: int
    restitution: float
    tangential: float
    most: int
    places: np.ndarray = AT_THE_CENTRE


@inlined
def _launch(lane: Any, start: Start, records: Records, tracer: int) -> None:
    vx, vy = _draw(start, tracer)
    _begin(lane, records, tracer, vx, vy, max(sqrt(vx * vx + vy * vy), AT_REST))


@inlined
def _launch_in_space(lane: Any, start: Start, records: Records, tracer: int) -> None:
    vx, vy = _draw(start, tracer)
    if start.given.shape[0]:
        vz = start.given[tracer, 2]
    else:
        state, gamma = open_stream(start.seed, START, start.configuration, start.first + tracer)
        if start.monoenergetic:
            # The third coordinate of a place on the unit sphere is uniform.
            vz = 2.0 * uniform(state, gamma, 2) - 1.0
            across = sqrt((1.0 - vz) * (1.0 + vz))
            vx, vy = across * vx, across * vy
        else:
            size = sqrt(-2.0 * log(uniform(state, gamma, 2)))
            vz = size * cos(2.0 * pi * uniform(state, gamma, 3))
    speed = max(sqrt(vx * vx + vy * vy + vz * vz), AT_REST)
    _begin(lane, records, tracer, vx, vy, speed)
    lane.uz, lane.start_vz = vz / speed, vz
    lane.z = lane.flight_z = 0.0
    lane.k = 0


# Set a lane to the beginning of the path of tracer number `start.first + tracer`.
launch = by_dimension(_launch, _launch_in_space)


@inlined
def _draw(start: Start, tracer: int) -> tuple[float, float]:
    """Return the first two components of a tracer's initial velocity."""
    if start.given.shape[0]:
        vx, vy = start.given[tracer, 0], start.given[tracer, 1]
    else:
        state, gamma = open_stream(start.seed, START, start.configuration, start.first + tracer)
        angle = 2.0 * pi * uniform(state, gamma, 0)
        speed = 1.0 if start.monoenergetic else sqrt(-2.0 * log(uniform(state, gamma, 1)))
        vx, vy = speed * cos(angle), speed * sin(angle)
    return vx, vy


@inlined
def _begin(lane: Any, records: Records, tracer: int, vx: float, vy: float, speed: float) -> None:
    """Set a lane to the beginning of a path with this velocity."""
    lane.ux, lane.uy = vx / speed, vy / speed
    lane.slowness, lane.unit = 1.0 / speed, 1.0
    lane.next_output = records.times[0] if records.times.size else np.inf
    lane.start_vx, lane.start_vy = vx, vy
    lane.x = lane.y = lane.flight_x = lane.flight_y = 0.0
    lane.time = lane.travelled = lane.normal_x = lane.normal_y = 0.0
    lane.collisions = lane.output = lane.shifts = lane.i = lane.j = 0
    lane.tracer = tracer


@inlined
def _advance(lane: Any, path: float) -> None:
    lane.flight_x += path * lane.ux
    lane.flight_y += path * lane.uy


@inlined
def _advance_in_space(lane: Any, path: float) -> None:
    _advance(lane, path)
    lane.flight_z += path * lane.uz


# Move the place where the flight of a lane began by a path along its direction.
advance = by_dimension(_advance, _advance_in_space)


@inlined
def is_due(lane: Any, path: float, n_times: int) -> bool:
    """Tell whether an output time comes within the next flight, of this length."""
    return lane.time + path * lane.slowness >= lane.next_output and lane.output < n_times


@inlined
def fly(lane: Any, path: float, n_times: int, last_time: float) -> tuple[float, bool]:
    """Advance the time of a lane by a flight; the outputs within it have been queued before.

    Return the path flown and whether the last output has been reached: the flight then ends there.
    The place is left to the caller, whose coordinates may be those of a cell.
    """
    finished = lane.output == n_times and n_times > 0
    if finished:
        path = max((last_time * lane.unit - lane.time) / lane.slowness, 0.0)
    lane.travelled += path
    lane.time += path * lane.slowness
    return path, finished


@inlined
def shift_clock(lane: Any, times: np.ndarray) -> None:
    """Keep the slowness and the time of a lane that has become slow from overflowing."""
    while lane.slowness > SHIFT:
        lane.slowness /= SHIFT
        lane.time /= SHIFT
        lane.unit /= SHIFT
        lane.shifts += 1
        if lane.output < times.size:
            lane.next_output = times[lane.output] * lane.unit
