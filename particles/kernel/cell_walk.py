"""The steps of a tracer that flies straight from cell to cell among scatterers.

A tracer looks for contacts with the scatterers that its cell lists (`particles.cells`); where there
is none before the cell wall it goes on to the next cell, until it meets one. The compiler knows the
number of axes of `shape`, the dimension, and leaves out what is said of a third coordinate in the
plane.
"""

from math import copysign

import numpy as np

from particles.cells import SLOTS, Cells, cell_at
from particles.compiled import called, inlined
from particles.events import (
    Varying,
    bounce_in_space,
    contact,
    contact_in_space,
    is_collapsing,
    scatter,
    touch,
)
from particles.kernel.pockets import end_of_bounces
from particles.kernel.straight_flight import StraightTracer, law_at_impact, start_straight
from particles.kernel.tracer import Batch, Tracer, record_type
from particles.slot_search import strike

#: Flights shorter than this, in d, are taken to occur in corners only, whose walls are straight on
#: this scale; `events.is_collapsing`, or in space `pockets`, then decides whether the tracer ever
#: leaves. The origin of the number is not recorded.
SHORT = 1e-9
#: Least component of a direction along an axis, so that paths to walls are finite. Chosen: far
#: below any component that is not 0.
LEAST_COMPONENT = 1e-300


class CellPlace(Tracer):
    """Where a tracer is: in which cell, and where from its centre."""

    x: float
    y: float
    i: int  # the cell, from the middle one, without regard to periodicity
    j: int
    stored_i: int  # the cell of the box that stands for it
    stored_j: int
    cell: int  # its number among the cells of the box
    wall_x: float  # path (in a field, time) to the next cell wall across each axis
    wall_y: float
    step_x: float  # +1 or -1: from this cell to the next one
    step_y: float
    met_x: float  # scatterer of the next contact, from the centre of the cell
    met_y: float
    normal_x: float  # from the scatterer struck last to the tracer; unit vector
    normal_y: float


class CellTracer(StraightTracer, CellPlace):
    """A tracer on straight flights among scatterers."""

    z: float
    k: int
    stored_k: int
    wall_z: float
    step_z: float
    met_z: float
    between_x: float  # path from one cell wall to the next one across the same axis
    between_y: float
    between_z: float


#: The record of a lane.
LANE = record_type(CellTracer)


@inlined
def start_in_cell(
    tracer: CellTracer, batch: Batch, cells: Cells, times: np.ndarray, number: int
) -> None:
    """Set a lane to the start of a tracer at the centre of the middle cell."""
    start_straight(tracer, batch, times, number)
    middle = cells.shape[0] // 2
    tracer.x = tracer.y = tracer.z = 0.0
    tracer.i = tracer.j = tracer.k = 0
    tracer.stored_i = tracer.stored_j = tracer.stored_k = middle
    tracer.cell = cell_at(cells.shape, middle, middle, middle)
    tracer.normal_x = tracer.normal_y = 0.0
    find_walls(tracer, cells.side, cells.shape)


@inlined
def find_walls(tracer: CellTracer, side: float, shape: tuple[int, ...]) -> None:
    """Find the cell walls ahead of a tracer that begins a flight."""
    half = 0.5 * side
    sign_x = copysign(1.0, tracer.ux)
    sign_y = copysign(1.0, tracer.uy)
    per_x = 1.0 / max(abs(tracer.ux), LEAST_COMPONENT)
    per_y = 1.0 / max(abs(tracer.uy), LEAST_COMPONENT)
    tracer.wall_x = max((half - sign_x * tracer.x) * per_x, 0.0)
    tracer.wall_y = max((half - sign_y * tracer.y) * per_y, 0.0)
    tracer.between_x = side * per_x
    tracer.between_y = side * per_y
    tracer.step_x = sign_x
    tracer.step_y = sign_y
    if len(shape) == 3:
        sign_z = copysign(1.0, tracer.uz)
        per_z = 1.0 / max(abs(tracer.uz), LEAST_COMPONENT)
        tracer.wall_z = max((half - sign_z * tracer.z) * per_z, 0.0)
        tracer.between_z = side * per_z
        tracer.step_z = sign_z


@inlined
def nearest_wall(tracer: CellTracer, shape: tuple[int, ...]) -> float:
    """Return the path to the first cell wall."""
    path = min(tracer.wall_x, tracer.wall_y)
    if len(shape) == 3:
        path = min(path, tracer.wall_z)
    return path


@inlined
def find_contact(tracer: CellTracer, cells: Cells) -> None:
    """Find the first scatterer of its cell that a tracer meets; the path is NEVER if none."""
    slots = cells.slots
    links = cells.links
    nodes = cells.nodes
    is_solid = len(cells.shape) == 3
    x = tracer.x
    y = tracer.y
    z = tracer.z
    ux = tracer.ux
    uy = tracer.uy
    uz = tracer.uz
    cell = tracer.cell
    node = cells.head[cell]
    met_z = 0.0
    if not is_solid:
        path, slot = strike(slots, cell, (x, y), (ux, uy))
    else:
        path, slot = strike(slots, cell, (x, y, z), (ux, uy, uz))
        met_z = slots[cell, 2 * SLOTS + slot]
    met_x = slots[cell, slot]
    met_y = slots[cell, SLOTS + slot]
    while node >= 0:
        dx = nodes[node, 0] - x
        dy = nodes[node, 1] - y
        if not is_solid:
            path_to_node, _impact = contact(dx, dy, ux, uy)
        else:
            path_to_node = contact_in_space(dx, dy, nodes[node, 2] - z, ux, uy, uz)
        if path_to_node < path:
            path = path_to_node
            met_x = nodes[node, 0]
            met_y = nodes[node, 1]
            if is_solid:
                met_z = nodes[node, 2]
        node = links[node]
    tracer.contact = path
    tracer.met_x = met_x
    tracer.met_y = met_y
    tracer.met_z = met_z


@inlined
def cross_cell(tracer: CellTracer, side: float, shape: tuple[int, ...]) -> None:
    """Move a tracer into the next cell, through the wall that it reaches first."""
    # Factors 0 and 1 instead of branches: the processor cannot predict which wall comes first.
    # The steps are floats: of an integer times such a factor LLVM may make a branch again.
    n = shape[0]
    is_x_first = int(tracer.wall_x <= tracer.wall_y)
    is_z = 0
    if len(shape) == 3:
        is_z = int(tracer.wall_z < min(tracer.wall_x, tracer.wall_y))
    is_x = is_x_first * (1 - is_z)
    is_y = (1 - is_x_first) * (1 - is_z)
    di = is_x * tracer.step_x
    dj = is_y * tracer.step_y
    tracer.x -= di * side
    tracer.y -= dj * side
    tracer.wall_x += is_x * tracer.between_x
    tracer.wall_y += is_y * tracer.between_y
    cell = enter_cell_in_plane(tracer, n, int(di), int(dj))
    if len(shape) == 3:
        dk = is_z * tracer.step_z
        tracer.z -= dk * side
        tracer.wall_z += is_z * tracer.between_z
        tracer.k += int(dk)
        tracer.stored_k = _in_box(tracer.stored_k + int(dk), n)
        cell = cell * n + tracer.stored_k
    tracer.cell = cell


@inlined
def _in_box(number: int, n: int) -> int:
    """Return a number from -1 to n modulo n."""
    if number < 0:
        return n - 1
    return 0 if number == n else number


@inlined
def enter_cell_in_plane(tracer: CellPlace, n: int, di: int, dj: int) -> int:
    """Note that a tracer is di and dj cells farther, -1, 0 or 1; return the number of this cell.

    n: cells along each axis of the box.
    """
    tracer.i += di
    tracer.j += dj
    i = _in_box(tracer.stored_i + di, n)
    j = _in_box(tracer.stored_j + dj, n)
    tracer.stored_i = i
    tracer.stored_j = j
    return i * n + j


@inlined
def bounce_off(
    tracer: CellTracer, path: float, side: float, shape: tuple[int, ...],
    law: tuple[float, float], varying: Varying | None, endless: tuple[float, float],
) -> bool:  # fmt: skip
    """Collide with the scatterer met after this path; tell whether the tracer is trapped.

    Parameters
    ----------
    tracer : where the flight began
    path : of the flight in d
    side, shape : of the cells
    law : (e, et), unless `varying`
    varying : restitution that depends on the impact speed, or None
    endless : (e, et) of bounces that never end, which are those of slow impacts
    """
    dx = tracer.met_x - tracer.x
    dy = tracer.met_y - tracer.y
    if varying is not None:
        along = dx * tracer.ux + dy * tracer.uy
        cosine = along - path
        if len(shape) == 3:
            cosine += (tracer.met_z - tracer.z) * tracer.uz
        law = law_at_impact(tracer, law, varying, max(cosine, 0.0))
    if len(shape) == 2:
        trapped, ratio = _bounce_off_disk(tracer, path, law, endless)
    else:
        offset = dx, dy, tracer.met_z - tracer.z
        direction = tracer.ux, tracer.uy, tracer.uz
        normal, direction, ratio = bounce_in_space(offset, direction, law[0], law[1])
        trapped = ratio == 0.0
        tracer.x = tracer.met_x + normal[0]
        tracer.y = tracer.met_y + normal[1]
        tracer.z = tracer.met_z + normal[2]
        tracer.ux, tracer.uy, tracer.uz = direction
        tracer.flight_z = tracer.k * side + tracer.z
    tracer.flight_x = tracer.i * side + tracer.x
    tracer.flight_y = tracer.j * side + tracer.y
    tracer.collisions += 1
    tracer.slowness /= ratio
    find_walls(tracer, side, shape)
    return trapped


@inlined
def _bounce_off_disk(
    tracer: CellTracer, path: float, law: tuple[float, float], endless: tuple[float, float]
) -> tuple[bool, float]:
    """Do what `bounce_off` does in the plane, but for the slowness; return also the speed ratio."""
    ux = tracer.ux
    uy = tracer.uy
    cx = tracer.met_x
    cy = tracer.met_y
    impact = (cx - tracer.x) * uy - (cy - tracer.y) * ux
    x, y = touch(cx, cy, ux, uy, impact)
    ux, uy, ratio = scatter(ux, uy, impact, law[0], law[1])
    normal = x - cx, y - cy
    trapped = ratio == 0.0
    if path < SHORT and not trapped:
        previous_normal = tracer.normal_x, tracer.normal_y
        trapped = is_collapsing(previous_normal, normal, (ux, uy), endless[0], endless[1])
    tracer.normal_x, tracer.normal_y = normal
    tracer.x = x
    tracer.y = y
    tracer.ux = ux
    tracer.uy = uy
    return trapped, ratio


@called
def end_bounces(tracer: CellTracer, path: float, cells: Cells, law: tuple[float, float]) -> bool:
    """Let the endless bounces in space follow that a very short flight is the beginning of.

    Tell whether the tracer is trapped.
    """
    if law[0] >= law[1] or len(cells.shape) == 2:
        return False
    place = tracer.x, tracer.y, tracer.z
    direction = tracer.ux, tracer.uy, tracer.uz
    direction, ratio = end_of_bounces(cells, tracer.cell, place, direction, law, path)
    tracer.ux, tracer.uy, tracer.uz = direction
    tracer.slowness /= ratio
    find_walls(tracer, cells.side, cells.shape)
    return ratio == 0.0
