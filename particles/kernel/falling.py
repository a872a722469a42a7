"""The steps of a tracer on parabolas among disks, in a field along x.

A lane holds place and velocity at the last node of the path: a contact, a cell wall, or the end of
a slide. As without a field (`cell_walk`), the next contact is sought in one cell after the other.
"""

from math import copysign, sqrt

import numpy as np

from particles.cells import SLOTS, Cells, cell_at
from particles.compiled import inlined
from particles.events import NEVER, bounce
from particles.kernel.cell_walk import CellPlace, enter_cell_in_plane
from particles.kernel.disk_contact import APART, STRUCK, TANGENT, contact_in_field
from particles.kernel.parabola import length_flown, time_to_reach
from particles.kernel.parabolic_flight import start_with_velocity
from particles.kernel.tracer import AT_REST, Batch, VelocityTracer, record_type
from particles.slot_search import near_chord

#: Distance in d beyond contact at which a disk near the chord of a parabola is still looked at.
#: Chosen: far more than rounding.
ROUNDING_MARGIN = 1e-9


class FallingTracer(VelocityTracer, CellPlace):
    """A tracer on parabolas among disks; place and velocity are those at the last node."""

    contact: float  # time until the next contact in this cell
    struck_x: float  # the disk struck last, from the centre of the cell
    struck_y: float
    touches: int  # STRUCK or TANGENT while the tracer is on this disk, else APART
    first_vx: float  # velocity along x where the flight began
    duration: float  # of the flight, until the last node
    walls_crossed: int  # in this flight
    origin_i: int  # the cell where the tracer started, from the middle one
    origin_j: int
    origin_x: float  # where it started, from the centre of this cell
    origin_y: float


#: The record of a lane.
LANE = record_type(FallingTracer)


@inlined
def start_falling(
    tracer: FallingTracer, batch: Batch, cells: Cells, times: np.ndarray, number: int
) -> None:
    """Set a lane to the start of a tracer."""
    start_with_velocity(tracer, batch, times, number)
    tracer.origin_i = tracer.origin_j = 0
    tracer.origin_x = tracer.origin_y = 0.0
    if batch.places.shape[0]:
        place = batch.places[number]
        tracer.origin_i = int(place[0])
        tracer.origin_j = int(place[1])
        tracer.origin_x = place[2]
        tracer.origin_y = place[3]
    tracer.i = tracer.origin_i
    tracer.j = tracer.origin_j
    tracer.x = tracer.origin_x
    tracer.y = tracer.origin_y
    middle = cells.shape[0] // 2
    tracer.stored_i = middle + tracer.i
    tracer.stored_j = middle + tracer.j
    tracer.cell = cell_at(cells.shape, tracer.stored_i, tracer.stored_j, 0)
    tracer.normal_x = tracer.normal_y = 0.0
    tracer.touches = APART
    begin_flight(tracer)


@inlined
def begin_flight(tracer: FallingTracer) -> None:
    """Note where on its parabola the flight of a tracer begins."""
    tracer.first_vx = tracer.vx
    tracer.duration = 0.0
    tracer.walls_crossed = 0


@inlined
def place_from_start(tracer: FallingTracer, side: float) -> None:
    """Find the place of a tracer from where it started, as records have it."""
    tracer.flight_x = x_from_start(tracer, tracer.x, side)
    tracer.flight_y = (tracer.j - tracer.origin_j) * side + (tracer.y - tracer.origin_y)


@inlined
def x_from_start(tracer: FallingTracer, x: float, side: float) -> float:
    """Return how far along x a place in the cell of a tracer is from where the tracer started."""
    return (tracer.i - tracer.origin_i) * side + (x - tracer.origin_x)


@inlined
def find_walls_in_field(tracer: FallingTracer, half: float, field: float) -> None:
    """Find when a tracer leaves its cell, of side 2 half, and through which wall."""
    towards = copysign(1.0, field)
    strength = abs(field)
    ahead = towards * tracer.x
    along = towards * tracer.vx
    to_back_wall = ahead + half
    to_back_wall = to_back_wall if to_back_wall > 0.0 else 0.0
    discriminant = along * along - 2.0 * strength * to_back_wall
    if along < 0.0 and discriminant >= 0.0:
        # It runs out against the field before it turns.
        tracer.wall_x = 2.0 * to_back_wall / (sqrt(discriminant) - along)
        tracer.step_x = -towards
    else:
        to_front_wall = half - ahead
        to_front_wall = to_front_wall if to_front_wall > 0.0 else 0.0
        tracer.wall_x = 0.0
        if to_front_wall > 0.0 or along < 0.0:
            tracer.wall_x = time_to_reach(to_front_wall, along, strength)
        tracer.step_x = towards
    sign = copysign(1.0, tracer.vy)
    to_side_wall = half - sign * tracer.y
    to_side_wall = to_side_wall if to_side_wall > 0.0 else 0.0
    tracer.wall_y = to_side_wall / max(abs(tracer.vy), AT_REST)
    tracer.step_y = sign


@inlined
def _contact_time(
    tracer: FallingTracer, disk_x: float, disk_y: float, field: float, limit: float
) -> float:
    """Return the time until a tracer meets a disk, NEVER if that is not before `limit`."""
    touches = APART
    if tracer.touches != APART and disk_x == tracer.struck_x and disk_y == tracer.struck_y:
        touches = tracer.touches
    place = tracer.x - disk_x, tracer.y - disk_y
    return contact_in_field(place, (tracer.vx, tracer.vy), field, limit, touches)


@inlined
def find_contact_in_field(tracer: FallingTracer, cells: Cells, field: float) -> None:
    """Find the first disk that a tracer meets in its cell; the time is NEVER if there is none.

    Only disks near the chord are looked at: the parabola is no farther than g t^2/8 from it.
    """
    slots = cells.slots
    links = cells.links
    nodes = cells.nodes
    cell = tracer.cell
    limit = min(tracer.wall_x, tracer.wall_y)
    contact = NEVER
    met_x = 0.0
    met_y = 0.0
    place = tracer.x, tracer.y
    chord = (tracer.vx + 0.5 * field * limit) * limit, tracer.vy * limit
    reach = 1.0 + ROUNDING_MARGIN + 0.125 * abs(field) * limit * limit
    candidates = near_chord(slots, cell, place, chord, reach * reach)
    slot = 0
    while candidates:
        if candidates & 1:
            disk_x = slots[cell, slot]
            disk_y = slots[cell, SLOTS + slot]
            time = _contact_time(tracer, disk_x, disk_y, field, limit)
            if time < NEVER:
                contact = limit = time
                met_x = disk_x
                met_y = disk_y
        candidates >>= 1
        slot += 1
    node = cells.head[cell]
    while node >= 0:
        time = _contact_time(tracer, nodes[node, 0], nodes[node, 1], field, limit)
        if time < NEVER:
            contact = limit = time
            met_x = nodes[node, 0]
            met_y = nodes[node, 1]
        node = links[node]
    tracer.contact = contact
    tracer.met_x = met_x
    tracer.met_y = met_y


@inlined
def move_in_cell(tracer: FallingTracer, duration: float, field: float) -> None:
    """Move a tracer along its parabola, within its cell."""
    tracer.x += (tracer.vx + 0.5 * field * duration) * duration
    tracer.y += tracer.vy * duration
    tracer.vx += field * duration
    tracer.time += duration
    tracer.duration += duration


@inlined
def fall_into_next_cell(tracer: FallingTracer, n: int, side: float, field: float) -> None:
    """Move a tracer along its parabola into the next cell; n: cells along the box."""
    if tracer.wall_x <= tracer.wall_y:
        move_in_cell(tracer, tracer.wall_x, field)
        tracer.x = -0.5 * side * tracer.step_x
        tracer.cell = enter_cell_in_plane(tracer, n, int(tracer.step_x), 0)
    else:
        move_in_cell(tracer, tracer.wall_y, field)
        tracer.y = -0.5 * side * tracer.step_y
        tracer.cell = enter_cell_in_plane(tracer, n, 0, int(tracer.step_y))
    tracer.touches = APART
    tracer.walls_crossed += 1


@inlined
def flight_length(tracer: FallingTracer, field: float) -> float:
    """Return the length of the flight of a tracer, until its last node."""
    return length_flown(tracer.first_vx, tracer.vy, 0.0, tracer.duration, field)


@inlined
def bounce_off_disk(tracer: FallingTracer, law: tuple[float, float]) -> float:
    """Bounce off the disk that has been met; return the normal velocity after that."""
    tracer.struck_x = tracer.met_x
    tracer.struck_y = tracer.met_y
    nx = tracer.x - tracer.struck_x
    ny = tracer.y - tracer.struck_y
    per = 1.0 / sqrt(nx * nx + ny * ny)
    nx = nx * per
    ny = ny * per
    tracer.x = tracer.struck_x + nx
    tracer.y = tracer.struck_y + ny
    tracer.normal_x = nx
    tracer.normal_y = ny
    tracer.vx, tracer.vy, normal_velocity = bounce(tracer.vx, tracer.vy, nx, ny, law)
    tracer.touches = STRUCK if normal_velocity > 0.0 else TANGENT
    tracer.collisions += 1
    return normal_velocity
