"""The state of one tracer under way, called its lane, and the steps that all event loops share.

The path of a tracer without a field does not depend on its speed (`particles.events`), so a lane
holds a place, a unit direction and, apart from them, the slowness 1/speed. Lengths are in d, times
in d/U. In the plane the third coordinates are 0.

A tracer slows down without end: slowness and time are kept times `unit` = 2**-64k, `shifts` is k.
"""

from collections.abc import Mapping
from math import cos, log, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from particles.compiled import inlined
from particles.events import NEVER, Varying, law_at, scatter, scatter_in_space
from particles.streams import FLIGHTS, START, bits, in_disk, open_stream, uniform

# Tracers that one thread follows in turns; only the speed depends on it: 4 to 64 were measured.
LANES = 16
SHIFT = 2.0**64
AT_REST = 1.0 / NEVER  # a speed in place of 0, with which a tracer begins in a field only


def record_type(fields: Mapping[Any, tuple[str, ...]]) -> np.dtype:
    """Return the type of a record, kind of number -> names; `lane.x` is read also interpreted."""
    named = [(name, kind) for kind, names in fields.items() for name in names]
    return np.dtype((np.record, np.dtype(named, align=True)))


LANE = record_type(
    {
        np.float64: (
            "x", "y", "z",              # place, from the centre of the lane's cell
            "ux", "uy", "uz",           # unit direction
            "slowness", "time", "unit",  # each times 2**-64 shifts
            "next_output",              # time of the next output, as `time`; inf after the last
            "travelled",                # path since the start
            "flight_x", "flight_y", "flight_z",  # where this flight began, from the path's start
            "start_vx", "start_vy", "start_vz",  # velocity at time 0, in U
            "normal_x", "normal_y", "normal_z",  # of the scatterer struck last, towards the tracer
            "wall_x", "wall_y", "wall_z",  # path to the next cell wall of each direction
            "between_x", "between_y", "between_z",  # path from one such wall to the next
            "move_x", "move_y", "move_z",  # from the centre of this cell to that of the next
            "contact",                  # path to the next contact in this cell
            "struck_x", "struck_y", "struck_z",  # the scatterer met there, from the cell's centre
            "impact",                   # normal speed of the last collision, where e depends on it
            # In a field, where the path depends on the speed and times are never shifted. Among
            # disks place and velocity are those at the last node of the parabola; walls and contact
            # are times until then.
            "vx", "vy", "vz",           # velocity; without scatterers where the flight began
            "first_vx", "lasted",       # velocity along x where the flight began; time since then
            "meets_x", "meets_y",       # the disk of the next contact, from the cell's centre
            "from_x", "from_y",         # where the path began, from the centre of its cell
            # Of tracers that are driven.
            "clock",                    # left of an exponential variable
            "since", "began",           # path and time at the last collision
            "span", "left",             # a step of the noise, 0 between two; what is left of it
            "kick_x", "kick_y", "kick_z",  # the noise at its beginning
        ),
        np.int64: (
            "collisions", "output",     # how many there have been, of collisions and of outputs
            "tracer", "shifts",
            "i", "j", "k",              # the cell, counted without regard to periodicity
            "stored_i", "stored_j", "stored_k",  # the cell of the box that stands for it
            "cell",                     # where its scatterers are stored
            "step_i", "step_j", "step_k",  # +1 or -1: from this cell to the next
            "before", "crossed",        # whether it is on the disk `struck`; walls crossed since
            "from_i", "from_j",         # the cell where the path began, from the middle one
            "draws",                    # random numbers used
        ),
        np.uint64: ("stream", "gamma"),  # what random flights without scatterers are drawn from
    }
)  # fmt: skip
AT_THE_CENTRE = np.empty((0, 4))


class Start(NamedTuple):
    """Which tracers to follow, and how.

    first: number of the first one. given (n, dimension): initial velocities, or (0, dimension) to
    draw n of them. law: (e, et). most: the largest number of collisions, 0 for no limit. places
    (n, 4): of `placement.free_places`, or (0, 4): all start at the centre.
    """

    first: int
    n: int
    dimension: int
    given: np.ndarray
    monoenergetic: bool
    seed: Any
    configuration: int
    law: tuple[float, float]
    most: int
    places: np.ndarray = AT_THE_CENTRE


@inlined
def launch(lane: Any, start: Start, times: np.ndarray, tracer: int) -> None:
    """Set a lane to the beginning of the path of tracer number `start.first + tracer`."""
    vx, vy, vz = _velocity(start, tracer)
    speed = max(sqrt(vx * vx + vy * vy + vz * vz), AT_REST)
    lane.ux, lane.uy, lane.uz = vx / speed, vy / speed, vz / speed
    lane.slowness, lane.unit = 1.0 / speed, 1.0
    lane.next_output = times[0] if times.size else np.inf
    lane.start_vx, lane.start_vy, lane.start_vz = lane.vx, lane.vy, lane.vz = vx, vy, vz
    lane.x = lane.y = lane.z = lane.flight_x = lane.flight_y = lane.flight_z = 0.0
    lane.time = lane.travelled = lane.normal_x = lane.normal_y = 0.0
    lane.collisions = lane.output = lane.shifts = lane.i = lane.j = lane.k = 0
    lane.tracer = tracer


@inlined
def open_flights(lane: Any, start: Start) -> None:
    """Open the stream of the random flights of a tracer."""
    lane.stream, lane.gamma = open_stream(
        start.seed, FLIGHTS, start.configuration, start.first + lane.tracer
    )


@inlined
def note_impact(lane: Any, varying: Varying | None, share: float) -> None:
    """Note the impact speed, if it matters; share: of it in the speed."""
    if varying is not None:
        lane.impact = share * lane.unit / lane.slowness


@inlined
def collide_at_random(lane: Any, start: Start, varying: Varying | None) -> float:
    """Collide with an impact parameter at random, never 0; return the ratio of the speeds."""
    draw = 2 * lane.collisions + 1
    if start.dimension == 2:
        impact = 2.0 * uniform(lane.stream, lane.gamma, draw) - 1.0
        note_impact(lane, varying, sqrt((1.0 - impact) * (1.0 + impact)))
        restitution, tangential = law_at(varying, start.law, lane.impact)
        lane.ux, lane.uy, ratio = scatter(lane.ux, lane.uy, impact, restitution, tangential)
    else:
        a, b = in_disk(bits(lane.stream, lane.gamma, draw))
        note_impact(lane, varying, sqrt(1.0 - (a * a + b * b)))
        restitution, tangential = law_at(varying, start.law, lane.impact)
        (lane.ux, lane.uy, lane.uz), ratio = scatter_in_space(
            (lane.ux, lane.uy, lane.uz), (a, b), restitution, tangential
        )
    lane.collisions += 1
    return ratio


@inlined
def _velocity(start: Start, tracer: int) -> tuple[float, float, float]:
    solid, vz = start.dimension == 3, 0.0
    if start.given.shape[0]:
        if solid:
            vz = start.given[tracer, 2]
        return start.given[tracer, 0], start.given[tracer, 1], vz
    state, gamma = open_stream(start.seed, START, start.configuration, start.first + tracer)
    angle = 2.0 * pi * uniform(state, gamma, 0)
    speed = 1.0 if start.monoenergetic else sqrt(-2.0 * log(uniform(state, gamma, 1)))
    vx, vy = speed * cos(angle), speed * sin(angle)
    if solid and start.monoenergetic:
        # The third coordinate of a place on the unit sphere is uniform.
        vz = 2.0 * uniform(state, gamma, 2) - 1.0
        across = sqrt((1.0 - vz) * (1.0 + vz))
        vx, vy = across * vx, across * vy
    elif solid:
        size = sqrt(-2.0 * log(uniform(state, gamma, 2)))
        vz = size * cos(2.0 * pi * uniform(state, gamma, 3))
    return vx, vy, vz


@inlined
def advance(lane: Any, path: float) -> None:
    """Move the place where the flight of a lane began by a path along its direction."""
    lane.flight_x += path * lane.ux
    lane.flight_y += path * lane.uy
    lane.flight_z += path * lane.uz


@inlined
def fly(lane: Any, path: float, n_times: int, last_time: float) -> tuple[float, bool]:
    """Advance the time of a lane by a flight, to the last output at most, but not its place.

    Return the path flown and whether the last output has been reached.
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
