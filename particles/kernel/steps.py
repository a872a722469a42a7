"""The steps of a tracer among scatterers, which `particles.kernel.follow` puts together.

The compiler knows the number of axes of `shape`, the dimension, and leaves out what is said of a
third coordinate in the plane.
"""

from math import copysign
from typing import Any

import numpy as np

from particles.cells import SLOTS, Cells, cell_at, strike
from particles.compiled import inlined
from particles.events import (
    Varying,
    bounce_in_space,
    contact,
    contact_in_space,
    is_collapsing,
    law_at,
    scatter,
    touch,
)
from particles.kernel.lane import note_impact
from particles.kernel.pockets import end_of_bounces

# Flights shorter than this, in d, occur only in corners, straight on this scale; whether a tracer
# ever leaves is then decided by `is_collapsing`, or in space by `pockets`.
SHORT = 1e-9


@inlined
def begin(lane: Any, cells: Cells) -> None:
    """Put a tracer at the centre of the middle cell, where its path starts."""
    middle = cells.shape[0] // 2
    lane.stored_i = lane.stored_j = lane.stored_k = middle
    lane.cell = cell_at(cells.shape, middle, middle, middle)
    aim(lane, cells.side, cells.shape)


@inlined
def aim(lane: Any, side: float, shape: tuple[int, ...]) -> None:
    """Find the cell walls ahead of a lane that begins a flight."""
    half = 0.5 * side
    sign_x, sign_y = copysign(1.0, lane.ux), copysign(1.0, lane.uy)
    pace_x, pace_y = 1.0 / max(abs(lane.ux), 1e-300), 1.0 / max(abs(lane.uy), 1e-300)
    lane.wall_x = max((half - sign_x * lane.x) * pace_x, 0.0)
    lane.wall_y = max((half - sign_y * lane.y) * pace_y, 0.0)
    lane.between_x, lane.between_y = side * pace_x, side * pace_y
    lane.move_x, lane.move_y = sign_x * side, sign_y * side
    lane.step_i, lane.step_j = int(sign_x), int(sign_y)
    if len(shape) == 3:
        sign_z, pace_z = copysign(1.0, lane.uz), 1.0 / max(abs(lane.uz), 1e-300)
        lane.wall_z = max((half - sign_z * lane.z) * pace_z, 0.0)
        lane.between_z, lane.move_z = side * pace_z, sign_z * side
        lane.step_k = int(sign_z)


@inlined
def next_contact(
    lane: Any, slots: np.ndarray, head: np.ndarray, links: np.ndarray, nodes: np.ndarray,
    shape: tuple[int, ...],
) -> None:  # fmt: skip
    """Find the first scatterer that a lane meets in its cell, if there is one."""
    x, y, z, ux, uy, uz = lane.x, lane.y, lane.z, lane.ux, lane.uy, lane.uz
    cell = lane.cell
    node, cz = head[cell], 0.0
    if len(shape) == 2:
        path, slot = strike(slots, cell, (x, y), (ux, uy))
    else:
        path, slot = strike(slots, cell, (x, y, z), (ux, uy, uz))
        cz = slots[cell, 2 * SLOTS + slot]
    cx, cy = slots[cell, slot], slots[cell, SLOTS + slot]
    while node >= 0:
        if len(shape) == 2:
            s, _ = contact(nodes[node, 0] - x, nodes[node, 1] - y, ux, uy)
        else:
            dx, dy, dz = nodes[node, 0] - x, nodes[node, 1] - y, nodes[node, 2] - z
            s = contact_in_space(dx, dy, dz, ux, uy, uz)
        if s < path:
            path, cx, cy = s, nodes[node, 0], nodes[node, 1]
            if len(shape) == 3:
                cz = nodes[node, 2]
        node = links[node]
    lane.contact, lane.struck_x, lane.struck_y, lane.struck_z = path, cx, cy, cz


@inlined
def cross_cell(lane: Any, shape: tuple[int, ...]) -> None:
    """Move a lane into the next cell, through the wall that it reaches first."""
    # Factors 0 and 1 instead of branches: the processor cannot predict which wall comes first.
    first, third = int(lane.wall_x <= lane.wall_y), 0
    if len(shape) == 3:
        third = int(lane.wall_z < min(lane.wall_x, lane.wall_y))
        lane.z -= third * lane.move_z
        lane.wall_z += third * lane.between_z
    across, along = first * (1 - third), (1 - first) * (1 - third)
    lane.x -= across * lane.move_x
    lane.y -= along * lane.move_y
    lane.wall_x += across * lane.between_x
    lane.wall_y += along * lane.between_y
    enter(lane, shape, across * lane.step_i, along * lane.step_j, third * lane.step_k)


@inlined
def enter(lane: Any, shape: tuple[int, ...], di: int, dj: int, dk: int) -> None:
    """Note that a lane is in the next cell: di, dj and dk are -1, 0 or 1."""
    n = shape[0]
    lane.i += di
    lane.j += dj
    i, j = lane.stored_i + di, lane.stored_j + dj
    i = n - 1 if i < 0 else 0 if i == n else i
    j = n - 1 if j < 0 else 0 if j == n else j
    lane.stored_i, lane.stored_j = i, j
    cell = i * n + j
    if len(shape) == 3:
        lane.k += dk
        k = lane.stored_k + dk
        k = n - 1 if k < 0 else 0 if k == n else k
        lane.stored_k = k
        cell = cell * n + k
    lane.cell = cell


@inlined
def collide(
    lane: Any, path: float, side: float, shape: tuple[int, ...], law: tuple[float, float],
    varying: Varying | None, endless: tuple[float, float],
) -> bool:  # fmt: skip
    """Bounce off the scatterer met after this path; tell whether the tracer is trapped.

    law: (e, et), unless varying; endless: those of bounces that never end.
    """
    cx, cy, cz = lane.struck_x, lane.struck_y, lane.struck_z
    ux, uy = lane.ux, lane.uy
    if varying is not None:
        ahead = (cx - lane.x) * ux + (cy - lane.y) * uy - path
        if len(shape) == 3:
            ahead += (cz - lane.z) * lane.uz
        note_impact(lane, varying, max(ahead, 0.0))
        law = law_at(varying, law, lane.impact)
    if len(shape) == 2:
        impact = (cx - lane.x) * uy - (cy - lane.y) * ux
        x, y = touch(cx, cy, ux, uy, impact)
        ux, uy, ratio = scatter(ux, uy, impact, law[0], law[1])
        nx, ny = x - cx, y - cy
        trapped = ratio == 0.0
        if path < SHORT and not trapped:
            before = lane.normal_x, lane.normal_y
            trapped = is_collapsing(before, (nx, ny), (ux, uy), endless[0], endless[1])
        lane.normal_x, lane.normal_y = nx, ny
        lane.x, lane.y, lane.ux, lane.uy = x, y, ux, uy
    else:
        normal, u, ratio = bounce_in_space(
            (cx - lane.x, cy - lane.y, cz - lane.z), (ux, uy, lane.uz), law[0], law[1]
        )
        trapped = ratio == 0.0
        lane.x, lane.y, lane.z = cx + normal[0], cy + normal[1], cz + normal[2]
        lane.ux, lane.uy, lane.uz = u
        lane.flight_z = lane.k * side + lane.z
    lane.flight_x, lane.flight_y = lane.i * side + lane.x, lane.j * side + lane.y
    lane.collisions += 1
    lane.slowness /= ratio
    aim(lane, side, shape)
    return trapped


@inlined
def end_bounces(lane: Any, path: float, cells: Cells, law: tuple[float, float]) -> bool:
    """Let the endless bounces follow, in space after a very short flight; tell as `collide`."""
    if law[0] >= law[1] or len(cells.shape) == 2:
        return False
    place, u = (lane.x, lane.y, lane.z), (lane.ux, lane.uy, lane.uz)
    (lane.ux, lane.uy, lane.uz), ratio = end_of_bounces(cells, lane.cell, place, u, law, path)
    lane.slowness /= ratio
    aim(lane, cells.side, cells.shape)
    return ratio == 0.0
