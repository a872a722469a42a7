"""The steps of a tracer among spheres: as in `particles.kernel.in_plane`, in three dimensions."""

from math import copysign
from typing import Any

import numpy as np

from particles.compiled.decorators import inlined
from particles.compiled.search import SLOTS, strike_in_space
from particles.events import bounce_in_space, contact_in_space
from particles.grid.blocks import is_unbounded
from particles.grid.cells import Cells
from particles.grid.space import place, supply
from particles.kernel import columns, in_plane
from particles.kernel.pockets import end_of_bounces


@inlined
def begin(lane: Any, cells: Cells) -> None:
    """Put a tracer at the centre of the middle cell, where its path starts."""
    n = cells.n
    middle = n // 2
    lane.stored_i = lane.stored_j = lane.stored_k = middle
    if is_unbounded(cells.keys):
        lane.cell = place(0, 0, 0)
    else:
        lane.cell = (middle * n + middle) * n + middle
    aim(lane, cells.side)


@inlined
def lacks_cell(lane: Any, keys: np.ndarray) -> bool:
    """Tell whether the cell of a lane is not made yet, or lost since to another lane."""
    c = lane.cell
    return is_unbounded(keys) and (
        keys[c, 0] != lane.i or keys[c, 1] != lane.j or keys[c, 2] != lane.k
    )


@inlined
def make_cell(lane: Any, keys: np.ndarray, cells: Cells) -> None:
    """Make the cell of a lane."""
    supply(keys, cells, lane.i, lane.j, lane.k)


@inlined
def aim(lane: Any, side: float) -> None:
    """Find the cell walls ahead of a lane that begins a flight."""
    in_plane.aim(lane, side)
    sign = copysign(1.0, lane.uz)
    pace = 1.0 / max(abs(lane.uz), 1e-300)
    lane.wall_z = max((0.5 * side - sign * lane.z) * pace, 0.0)
    lane.between_z, lane.move_z = side * pace, sign * side
    lane.step_k = int(sign)


@inlined
def next_wall(lane: Any) -> float:
    """Return the path to the wall of its cell that a lane reaches first."""
    return min(min(lane.wall_x, lane.wall_y), lane.wall_z)


@inlined
def next_contact(
    lane: Any, slots: np.ndarray, head: np.ndarray, links: np.ndarray, nodes: np.ndarray
) -> None:
    """Find the first scatterer that a lane meets in its cell, if there is one."""
    x, y, z, ux, uy, uz, cell = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz, lane.cell
    path, slot = strike_in_space(slots, cell, (x, y, z), (ux, uy, uz))
    cx, cy, cz = slots[cell, slot], slots[cell, SLOTS + slot], slots[cell, 2 * SLOTS + slot]
    node = head[cell]
    while node >= 0:
        dx, dy, dz = nodes[node, 0] - x, nodes[node, 1] - y, nodes[node, 2] - z
        s = contact_in_space(dx, dy, dz, ux, uy, uz)
        if s < path:
            path, cx, cy, cz = s, nodes[node, 0], nodes[node, 1], nodes[node, 2]
        node = links[node]
    lane.contact, lane.struck_x, lane.struck_y, lane.struck_z = path, cx, cy, cz


@inlined
def cross_cell(lane: Any, keys: np.ndarray, n: int) -> None:
    """Move a lane into the next cell, through the wall that it reaches first."""
    # Factors 0 and 1 instead of branches, as in the plane.
    first = int(lane.wall_x <= lane.wall_y)
    third = int(lane.wall_z < min(lane.wall_x, lane.wall_y))
    across, along = first * (1 - third), (1 - first) * (1 - third)
    lane.x -= across * lane.move_x
    lane.y -= along * lane.move_y
    lane.z -= third * lane.move_z
    lane.wall_x += across * lane.between_x
    lane.wall_y += along * lane.between_y
    lane.wall_z += third * lane.between_z
    di, dj, dk = across * lane.step_i, along * lane.step_j, third * lane.step_k
    lane.i += di
    lane.j += dj
    lane.k += dk
    if is_unbounded(keys):
        lane.cell = place(lane.i, lane.j, lane.k)
    else:
        i, j, k = lane.stored_i + di, lane.stored_j + dj, lane.stored_k + dk
        i = n - 1 if i < 0 else 0 if i == n else i
        j = n - 1 if j < 0 else 0 if j == n else j
        k = n - 1 if k < 0 else 0 if k == n else k
        lane.stored_i, lane.stored_j, lane.stored_k = i, j, k
        lane.cell = (i * n + j) * n + k


@inlined
def collide(lane: Any, path: float, side: float, law: tuple[float, float]) -> tuple[float, bool]:
    """Bounce off the sphere met after this path; the next flight begins there.

    law: restitution and tangential restitution. Return the ratio of the speeds after and
    before, and whether the tracer is trapped from now on.
    """
    cx, cy, cz = lane.struck_x, lane.struck_y, lane.struck_z
    normal, u, ratio = bounce_in_space(
        (cx - lane.x, cy - lane.y, cz - lane.z), (lane.ux, lane.uy, lane.uz), law[0], law[1]
    )
    x, y, z = cx + normal[0], cy + normal[1], cz + normal[2]
    lane.x, lane.y, lane.z = x, y, z
    lane.ux, lane.uy, lane.uz = u
    lane.flight_x, lane.flight_y = lane.i * side + x, lane.j * side + y
    lane.flight_z = lane.k * side + z
    lane.collisions += 1
    aim(lane, side)
    return ratio, ratio == 0.0


@inlined
def end_bounces(
    lane: Any, path: float, cells: Cells, law: tuple[float, float]
) -> tuple[float, bool]:
    """After a bounce and a very short flight before it: let those follow that never end.

    Return as `collide`.
    """
    place, u = (lane.x, lane.y, lane.z), (lane.ux, lane.uy, lane.uz)
    if law[0] >= law[1]:
        return 1.0, False
    (lane.ux, lane.uy, lane.uz), ratio = end_of_bounces(cells, lane.cell, place, u, law, path)
    aim(lane, cells.side)
    return ratio, ratio == 0.0


@inlined
def note_place(lane: Any, trap: np.ndarray) -> None:
    """Record where a tracer was caught."""
    in_plane.note_place(lane, trap)
    trap[columns.TRAP_Z] = lane.flight_z
